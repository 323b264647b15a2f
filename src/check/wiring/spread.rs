//! `all -> card`: wires every channel that has no wire of its own to the next free outputs of one instrument after the
//! other.

use super::{Outputs, Wired, WiringDraft};
use crate::check::Checker;
use crate::check::errors;
use crate::check::scope::Scope;
use crate::device::instrument::{Drive, Family, LinkSort};
use crate::syntax::tree::{self, WireOutput, WiringEntry};

/// The word that stands for all channels without a wire of their own.
const ALL: &str = "all";

/// Field that selects digital lines instead of outputs of voltage.
const SWITCHES: &str = "switches";

/// Whether a wire is for all channels.
pub fn is_of_all(wire: &tree::Wire) -> bool {
    matches!(wire.channel.segments.as_slice(), [only] if only.name.text == ALL && only.indices.is_empty())
}

impl Checker<'_> {
    /// Carries out the wires of all channels at the top of a wiring, in their order.
    pub(super) fn spread_channels(
        &mut self,
        entries: &[WiringEntry],
        scope: &Scope,
        draft: &mut WiringDraft,
        outputs: &mut Outputs,
    ) {
        let wires = entries.iter().filter_map(|entry| match entry {
            WiringEntry::Wire(wire) if is_of_all(wire) => Some(wire),
            WiringEntry::Wire(_) | WiringEntry::For(_) | WiringEntry::Field(_) | WiringEntry::Error(_) => None,
        });
        let wires: Vec<&tree::Wire> = wires.collect();
        let (Some(last), Some(owner)) = (wires.last(), &draft.owner) else { return };
        let mut left = owner.channels();
        left.retain(|channel| !draft.wired.contains_key(channel));
        let total = left.len();
        let mut by_lines = false;
        for wire in &wires {
            let Some(takes_lines) = self.fill(wire, scope, draft, &mut left, outputs) else { return };
            by_lines = takes_lines;
        }
        if let Some(first) = left.first() {
            let wrong = errors::channels_left_over(last.span, &draft.name, first, [left.len(), total], by_lines);
            self.sink.push(wrong);
        }
    }

    /// Whether some of the remaining channels are numbered, which is reported: the numbers are those of the driver's
    /// outputs, but wired in order the channels would go to others.
    fn is_numbered(&mut self, wire: &tree::Wire, draft: &WiringDraft, left: &[String], instrument: &str) -> bool {
        let numbered = draft.owner.as_ref().and_then(|owner| owner.numbered_channels());
        let is_left = |(channel, _): &&(String, u32)| left.contains(channel);
        let found = numbered.as_ref().and_then(|numbered| numbered.channels.iter().find(is_left));
        let Some((channel, number)) = found else { return false };
        self.sink.push(errors::all_of_numbered(wire.channel.span, channel, *number, instrument));
        true
    }

    /// Wires the first of the remaining channels to the free outputs of an instrument. Returns whether these are
    /// digital lines; `None` after an error.
    fn fill(
        &mut self,
        wire: &tree::Wire,
        scope: &Scope,
        draft: &mut WiringDraft,
        left: &mut Vec<String>,
        outputs: &mut Outputs,
    ) -> Option<bool> {
        let path = match &wire.output {
            WireOutput::Instrument(path) => path,
            WireOutput::Named(text) => {
                self.sink.push(errors::all_to_a_name(text.span));
                return None;
            }
        };
        let (place, words) = self.instrument_of(path, scope)?;
        let instrument = self.facts::<Family>(place)?;
        let (name, declared) = self.named(place);
        let name = name.to_owned();
        if words < path.segments.len() {
            self.sink.push(errors::all_to_one_output(path.span, &name));
            return None;
        }
        let is_stage = draft.owner.as_ref()?.moves_stages();
        let has_field = wire.fields.iter().any(|field| field.name.text == SWITCHES);
        let facts = &instrument.facts;
        if facts.family() == Family::ElectrodeDriver && self.is_numbered(wire, draft, left, &name) {
            return None;
        }
        let has_lines_only = facts.family() == Family::ElectrodeDriver;
        let by_lines = has_field || draft.defaults.contains_key(SWITCHES) || has_lines_only;
        let fits = |output: &String| {
            let link = facts.output(output)?.link(is_stage)?;
            let is_free = !outputs.used.contains_key(&format!("{name}.{output}"));
            (is_free && (link == LinkSort::Switch) == by_lines).then_some(link)
        };
        let fitting = facts.output_names().into_iter().filter_map(|output| Some((fits(&output)?, output)));
        let fitting: Vec<(LinkSort, String)> = fitting.collect();
        let Some(sort) = fitting.first().map(|(sort, _)| *sort) else {
            self.sink.push(errors::nothing_free(path.span, &name, declared, by_lines));
            return None;
        };
        let (link, limits) = self.link(&name, &wire.fields, scope, sort, wire.span, draft)?;
        self.enlist(place, instrument, outputs)?;
        for (channel, (_, output)) in left.drain(..left.len().min(fitting.len())).zip(fitting) {
            let shown = format!("{name}.{output}");
            outputs.used.insert(shown.clone(), path.span);
            let drive = Drive { instrument: name.clone(), output, link, limits, span: wire.span };
            draft.wired.insert(channel, Wired { output: shown, drive: Some(drive), span: wire.channel.span });
        }
        Some(by_lines)
    }
}
