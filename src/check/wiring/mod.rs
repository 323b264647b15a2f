//! Wirings: the physical output that drives each channel, and the link between the two.

mod spread;

use super::Checker;
use super::KindFacts;
use super::errors;
use super::fields::{Given, Owner};
use super::figures::Figures;
use super::scope::{DeclarationPlace, DeclarationSort, Scope};
use super::value::Accepted;
use crate::device::Kind;
use crate::device::instrument::{
    ANY_WIRE, AuxiliarySort, Bench, Direction, Drive, Family, Instrument, Link, LinkSort, OutputSort, StageLimits,
    Start,
};
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::syntax::tree::{self, Field, Item, WireOutput, WiringEntry};
use std::collections::{BTreeMap, BTreeSet};

/// The word that stands for all numbered channels of a board at the left of a wire.
const ALL_ELECTRODES: &str = "electrodes";

/// The channels of a board as its driver numbers them.
pub struct NumberedChannels {
    /// The voltage of an electrode that is on.
    pub on_v: f64,
    /// Names of channels, without the device's, each with its number. Empty where the board has no numbers.
    pub channels: Vec<(String, u32)>,
}

/// The wires of the user's files.
#[derive(Default)]
pub struct Wiring {
    wires: BTreeMap<DeclarationPlace, BTreeMap<String, Wired>>,
    instruments: BTreeMap<String, Instrument>,
}

/// A wired channel.
struct Wired {
    /// The physical output, by the name that is shown.
    output: String,
    /// `None` where no instrument is declared for it.
    drive: Option<Drive>,
    span: Span,
}

impl Wiring {
    /// The physical outputs of some devices and auxiliary outputs, by the full names of their channels, and the bench
    /// of the instruments that these outputs belong to.
    pub fn of(&self, owners: impl Iterator<Item = DeclarationPlace>) -> (BTreeMap<String, String>, Bench) {
        let mut outputs = BTreeMap::new();
        let mut bench = Bench::default();
        for (channel, wired) in owners.filter_map(|owner| self.wires.get(&owner)).flatten() {
            outputs.insert(channel.clone(), wired.output.clone());
            if let Some(drive) = &wired.drive {
                bench.drives.insert(channel.clone(), drive.clone());
                let instrument = self.instruments.get(&drive.instrument).cloned();
                bench.instruments.extend(instrument.map(|instrument| (drive.instrument.clone(), instrument)));
            }
        }
        (outputs, bench)
    }

    /// The drives of the channels of a device or an auxiliary output that are wired to instruments.
    pub fn drives(&self, owner: DeclarationPlace) -> impl Iterator<Item = &Drive> {
        let wires = self.wires.get(&owner).into_iter().flatten();
        wires.filter_map(|(_, wired)| wired.drive.as_ref())
    }
}

/// State shared by the wires of all devices while they are being read.
#[derive(Default)]
struct Outputs {
    /// Where each output is used.
    used: BTreeMap<String, Span>,
    /// The wired instruments by name, each with its declaration.
    instruments: BTreeMap<String, (DeclarationPlace, Instrument)>,
}

/// Owner of the channels of a wiring.
enum WiredOwner {
    Device(KindFacts),
    AuxiliaryOutput,
}

impl WiredOwner {
    fn sort(&self) -> DeclarationSort {
        match self {
            WiredOwner::Device(_) => DeclarationSort::Device,
            WiredOwner::AuxiliaryOutput => DeclarationSort::Output,
        }
    }

    fn has_channel(&self, name: &str) -> bool {
        match self {
            WiredOwner::Device(facts) => facts.as_checked_facts().has_channel(name),
            WiredOwner::AuxiliaryOutput => name == AuxiliarySort::CHANNEL,
        }
    }

    fn shared_channel(&self, name: &str) -> Option<String> {
        match self {
            WiredOwner::Device(facts) => facts.as_checked_facts().shared_channel(name),
            WiredOwner::AuxiliaryOutput => None,
        }
    }

    fn channel_examples(&self) -> Vec<String> {
        match self {
            WiredOwner::Device(facts) => facts.as_checked_facts().channel_examples(),
            WiredOwner::AuxiliaryOutput => vec![AuxiliarySort::CHANNEL.to_owned()],
        }
    }

    fn channels(&self) -> Vec<String> {
        match self {
            WiredOwner::Device(facts) => facts.as_checked_facts().all_channels(),
            WiredOwner::AuxiliaryOutput => self.channel_examples(),
        }
    }

    fn moves_stages(&self) -> bool {
        matches!(self, WiredOwner::Device(facts) if facts.as_checked_facts().moves_stages())
    }

    fn numbered_channels(&self) -> Option<NumberedChannels> {
        match self {
            WiredOwner::Device(facts) => facts.as_checked_facts().numbered_channels(),
            WiredOwner::AuxiliaryOutput => None,
        }
    }
}

/// The wires of one device or auxiliary output while they are being read, with their places.
struct WiringDraft {
    /// Where it is declared.
    place: DeclarationPlace,
    name: String,
    /// `None` if its figures are unknown.
    owner: Option<WiredOwner>,
    /// Defaults for the fields that a wire does not give itself.
    defaults: Accepted,
    /// Names of the fields that apply to some wire.
    taken: BTreeSet<&'static str>,
    wired: BTreeMap<String, Wired>,
}

/// The output of an instrument, as a wire names it.
struct NamedOutput {
    instrument: String,
    output: String,
    link: LinkSort,
    /// Whether it is a magnet or a heater beside electrodes.
    is_accessory: bool,
}

/// The fields of a wire, each with its scope.
fn given_in<'f>(fields: &'f [Field], scope: &Scope) -> Vec<Given<'f>> {
    fields.iter().map(|field| Given { field, scope: scope.clone() }).collect()
}

impl<'a> Checker<'a> {
    /// Checks every wiring of the user's files.
    pub fn wiring(&mut self) -> Wiring {
        let modules = self.modules;
        let mut wiring = Wiring::default();
        let mut wirings: BTreeMap<DeclarationPlace, Span> = BTreeMap::new();
        let mut outputs = Outputs::default();
        for (module, file) in modules.iter().enumerate().filter(|(_, file)| !file.is_library()) {
            for item in &file.tree.items {
                let Item::Wiring(item) = item else { continue };
                let mut scope = Scope::top(module);
                let Some(mut draft) = self.wiring_draft(item, &scope) else { continue };
                if let Some(earlier) = wirings.insert(draft.place, item.device.span) {
                    self.sink.push(errors::wired_twice(&draft.name, item.device.span, earlier));
                }
                self.wiring_entries(&item.entries, &mut scope, &mut draft, &mut outputs);
                self.spread_channels(&item.entries, &scope, &mut draft, &mut outputs);
                self.warn_of_idle_fields(&draft);
                let named =
                    draft.wired.into_iter().map(|(channel, wired)| (format!("{}.{channel}", draft.name), wired));
                wiring.wires.entry(draft.place).or_default().extend(named);
            }
        }
        let instruments = outputs.instruments.into_iter();
        wiring.instruments = instruments.map(|(name, (_, instrument))| (name, instrument)).collect();
        wiring
    }

    fn wiring_draft(&mut self, item: &tree::Wiring, scope: &Scope) -> Option<WiringDraft> {
        let named = self.find(&item.device, scope).map(|(place, _)| self.declaration(place).sort);
        let sort = named.filter(|sort| *sort == DeclarationSort::Output).unwrap_or(DeclarationSort::Device);
        let place = self.resolve(&item.device, scope, sort)?;
        let name = self.named(place).0.to_owned();
        let owner = match sort {
            DeclarationSort::Output => Some(WiredOwner::AuxiliaryOutput),
            _ => self.facts::<Kind>(place).map(WiredOwner::Device),
        };
        let own = item.entries.iter().filter_map(|entry| match entry {
            WiringEntry::Field(field) => Some(Given { field, scope: scope.clone() }),
            WiringEntry::Wire(_) | WiringEntry::For(_) | WiringEntry::Error(_) => None,
        });
        let mut given: Vec<Given> = own.collect();
        if let Some(owner) = &owner {
            given.retain(|given| match owner.has_channel(&given.field.name.text) {
                true => {
                    self.sink.push(errors::colon_in_wire(&given.field.name));
                    false
                }
                false => true,
            });
        }
        let wires = Owner { name: format!("the wires of `{name}`"), declared: None };
        let defaults = self.read_fields(&wires, &given, ANY_WIRE);
        Some(WiringDraft { place, name, owner, defaults, taken: BTreeSet::new(), wired: BTreeMap::new() })
    }

    /// Warns of default fields that apply to no wire: a limit that limits nothing is no protection.
    fn warn_of_idle_fields(&mut self, draft: &WiringDraft) {
        let idle = draft.defaults.iter().filter(|(name, _)| !draft.wired.is_empty() && !draft.taken.contains(*name));
        for (name, field) in idle {
            self.sink.push(errors::idle_wire_field(field.span, &draft.name, name));
        }
    }

    fn wiring_entries(
        &mut self,
        entries: &[WiringEntry],
        scope: &mut Scope,
        draft: &mut WiringDraft,
        outputs: &mut Outputs,
    ) {
        for entry in entries {
            match entry {
                // Read later: they take the outputs that all other wires leave.
                WiringEntry::Wire(wire) if scope.is_top() && spread::is_of_all(wire) => {}
                WiringEntry::Wire(wire) => {
                    self.wire(wire, scope, draft, outputs);
                }
                WiringEntry::For(each) => self.repeat(each, scope, &mut |checker, scope| {
                    checker.wiring_entries(&each.entries, scope, draft, outputs);
                }),
                WiringEntry::Field(field) if !scope.is_top() => {
                    self.sink.push(errors::wire_field_in_loop(&field.name));
                }
                WiringEntry::Field(_) | WiringEntry::Error(_) => {}
            }
        }
    }

    fn wire(&mut self, wire: &tree::Wire, scope: &Scope, draft: &mut WiringDraft, outputs: &mut Outputs) -> Option<()> {
        let first = self.modules[scope.module].names.get(&wire.channel.segments[0].name.text);
        if let WireOutput::Instrument(path) = &wire.output
            && first.is_some_and(|first| first.sort == DeclarationSort::Instrument)
        {
            self.sink.push(errors::wire_turned_round(&wire.channel, path));
            return None;
        }
        let channel = self.channel_name(&wire.channel.segments, scope);
        if channel.as_deref() == Some(ALL_ELECTRODES)
            && let WireOutput::Instrument(path) = &wire.output
            && let Some(board) = draft.owner.as_ref().and_then(WiredOwner::numbered_channels)
        {
            return self.board_wire(wire, path, scope, &board, draft, outputs);
        }
        // A board without facts was reported.
        if channel.as_deref() == Some(ALL_ELECTRODES) && draft.owner.is_none() {
            return None;
        }
        let is_stage = draft.owner.as_ref().map(WiredOwner::moves_stages);
        let (span, output, drive) = match &wire.output {
            WireOutput::Named(text) => {
                if let Some(field) = wire.fields.first() {
                    self.sink.push(errors::wire_without_instrument(&field.name, text.span));
                }
                (text.span, self.text(text, text.span, scope)?, None)
            }
            WireOutput::Instrument(path) => {
                let named = self.output_of_instrument(path, scope, is_stage, outputs)?;
                let name = format!("{}.{}", named.instrument, named.output);
                let (link, limits) = match named.is_accessory {
                    true => {
                        (self.accessory_link(&name, wire, channel.as_deref()?, scope, draft)?, StageLimits::default())
                    }
                    false => self.link(&name, &wire.fields, scope, named.link, wire.span, draft)?,
                };
                let NamedOutput { instrument, output, .. } = named;
                (path.span, name, Some(Drive { instrument, output, link, limits, span: wire.span }))
            }
        };
        let channel = channel?;
        let owner = draft.owner.as_ref()?;
        if !owner.has_channel(&channel) {
            if let Some(first) = owner.shared_channel(&channel) {
                self.sink.push(errors::wire_of_shared_channel(wire.channel.span, &channel, &first));
                return None;
            }
            let (known, name) = (owner.channel_examples(), format!("{} `{}`", owner.sort().name(), draft.name));
            self.sink.push(errors::unknown_channel(wire.channel.span, &name, &channel, &known));
            return None;
        }
        if let Some(earlier) = draft.wired.get(&channel) {
            self.sink.push(errors::channel_wired_twice(&channel, wire.channel.span, earlier.span));
        }
        if let Some(earlier) = outputs.used.insert(output.clone(), span) {
            self.sink.push(errors::output_used_twice(&output, span, earlier));
        }
        draft.wired.insert(channel, Wired { output, drive, span: wire.channel.span });
        Some(())
    }

    /// The instrument that the first words of a path name, and the output that the others do. `is_stage` tells whether
    /// the channel moves a stage; `None` if that is unknown.
    fn output_of_instrument(
        &mut self,
        path: &tree::Path,
        scope: &Scope,
        is_stage: Option<bool>,
        outputs: &mut Outputs,
    ) -> Option<NamedOutput> {
        let (place, words) = self.instrument_of(path, scope)?;
        let instrument = self.facts::<Family>(place)?;
        let (name, declared) = self.named(place);
        let output = self.channel_name(&path.segments[words..], scope)?;
        let Some(sort) = instrument.facts.output(&output) else {
            let known = instrument.facts.outputs();
            let takes_boards = instrument.facts.family() == Family::ElectrodeDriver;
            self.sink.push(match instrument.facts.lacks_temperature(&output) {
                true => errors::heater_without_temperature(path.span, name, declared, &output),
                false => errors::unknown_output(path.span, name, declared, &output, &known, takes_boards),
            });
            return None;
        };
        // It is unknown for a device with errors.
        let Some(link) = sort.link(is_stage?) else {
            self.sink.push(match sort {
                OutputSort::Digital | OutputSort::Voltage | OutputSort::Accessory => {
                    errors::line_for_a_stage(path.span)
                }
                OutputSort::Position => errors::stage_for_a_voltage(path.span, name, declared),
            });
            return None;
        };
        let name = name.to_owned();
        self.enlist(place, instrument, outputs)?;
        Some(NamedOutput { instrument: name, output, link, is_accessory: sort == OutputSort::Accessory })
    }

    /// The instrument that the first words of a path name, and how many words these are.
    pub fn instrument_of(&mut self, path: &tree::Path, scope: &Scope) -> Option<(DeclarationPlace, usize)> {
        let words = match self.find(path, scope) {
            Some((_, last)) => last + 1,
            None => (path.segments.len() - 1).clamp(1, 2),
        };
        let segments = path.segments[..words].to_vec();
        let end = segments.last().map_or(path.span, |segment| segment.span);
        let own = tree::Path { segments, span: path.span.to(end) };
        Some((self.resolve(&own, scope, DeclarationSort::Instrument)?, words))
    }

    /// Records that an instrument is wired; `None` after an error, if another one has its name.
    fn enlist(&mut self, place: DeclarationPlace, instrument: Instrument, outputs: &mut Outputs) -> Option<()> {
        let (name, declared) = self.named(place);
        match outputs.instruments.get(name) {
            Some((other, _)) if *other != place => {
                let earlier = self.named(*other).1;
                self.sink.push(errors::instruments_of_one_name(name, declared, earlier));
                None
            }
            Some(_) => Some(()),
            None => {
                outputs.instruments.insert(name.to_owned(), (place, instrument));
                Some(())
            }
        }
    }

    /// Wires every numbered electrode of a board to the channel of its number.
    fn board_wire(
        &mut self,
        wire: &tree::Wire,
        path: &tree::Path,
        scope: &Scope,
        board: &NumberedChannels,
        draft: &mut WiringDraft,
        outputs: &mut Outputs,
    ) -> Option<()> {
        let (place, words) = self.instrument_of(path, scope)?;
        let instrument = self.facts::<Family>(place)?;
        let (name, declared) = self.named(place);
        let facts = &instrument.facts;
        let known = facts.outputs();
        let lacks = board.channels.iter().find(|(_, number)| facts.output(&format!("c{number}")).is_none());
        let wrong = if facts.family() != Family::ElectrodeDriver {
            Some(errors::electrodes_to_other_instrument(path.span, name, declared))
        } else if words < path.segments.len() {
            Some(errors::electrodes_to_one_output(path.span, name))
        } else if let Some((channel, number)) = lacks {
            Some(errors::channel_beyond_driver(path.span, name, declared, channel, *number, &known))
        } else if board.channels.is_empty() {
            Some(errors::electrodes_without_numbers(wire.channel.span, &draft.name))
        } else {
            None
        };
        let name = name.to_owned();
        self.sink.push_if_some(wrong)?;
        let owner = Owner { name: format!("the wire to `{name}`"), declared: None };
        let given = given_in(&wire.fields, scope);
        self.read_fields(&owner, &given, &[]);
        self.enlist(place, instrument, outputs)?;
        for (channel, number) in &board.channels {
            let output = format!("c{number}");
            let link = Link::Switch { on_v: board.on_v };
            let limits = StageLimits::default();
            let drive = Drive { instrument: name.clone(), output: output.clone(), link, limits, span: wire.span };
            let output = format!("{name}.{output}");
            if let Some(earlier) = draft.wired.get(channel) {
                self.sink.push(errors::channel_wired_twice(channel, wire.channel.span, earlier.span));
                return None;
            }
            if let Some(earlier) = outputs.used.insert(output.clone(), path.span) {
                self.sink.push(errors::output_used_twice(&output, path.span, earlier));
                return None;
            }
            draft.wired.insert(channel.clone(), Wired { output, drive: Some(drive), span: wire.channel.span });
        }
        Some(())
    }

    /// Diagnostic for a bench of several instruments that the sender would start one after the other. Electrode drivers
    /// alone are allowed, because one program plays all of them on its clock.
    pub fn starts_apart(&self, bench: &Bench, program: Span) -> Option<Diagnostic> {
        let mut sent: Vec<(&String, &Instrument)> =
            bench.instruments.iter().filter(|(_, instrument)| instrument.facts.start() == Start::Sender).collect();
        let is_driver = |instrument: &Instrument| instrument.facts.family() == Family::ElectrodeDriver;
        sent.sort_by_key(|(_, instrument)| is_driver(instrument));
        let [(first, one), (second, other), ..] = sent[..] else { return None };
        let wire = |name: &str| bench.drives.values().find(|drive| drive.instrument == name).map(|drive| drive.span);
        let place = |name: &str| wire(name).unwrap_or(program);
        let together = [one, other].map(is_driver);
        (together != [true; 2]).then(|| errors::starts_apart(first, place(first), second, place(second), together[1]))
    }

    /// The link between a channel and its output, from the wire's own fields, then from the defaults of the wiring;
    /// `None` after an error.
    fn link(
        &mut self,
        output: &str,
        fields: &[Field],
        scope: &Scope,
        sort: LinkSort,
        span: Span,
        draft: &mut WiringDraft,
    ) -> Option<(Link, StageLimits)> {
        let owner = Owner { name: format!("the wire to `{output}`"), declared: None };
        let given = given_in(fields, scope);
        let mut accepted = self.read_fields(&owner, &given, sort.fields());
        for field in sort.fields() {
            draft.taken.insert(field.name);
            if let Some(value) = draft.defaults.get(field.name) {
                accepted.entry(field.name).or_insert_with(|| value.clone());
            }
        }
        let missing = Checker::missing(&accepted, sort.fields());
        if !missing.is_empty() {
            self.sink.push(errors::missing_fields(span, &owner.name, &missing, None));
            return None;
        }
        let limits = StageLimits {
            speed_um_per_s: accepted.quantity("speed").map(|most| most.in_unit("um/s")),
            acceleration_um_per_s2: accepted.quantity("acceleration").map(|most| most.in_unit("um/s^2")),
        };
        let link = match sort {
            LinkSort::Amplifier => Link::Amplifier {
                gain: accepted.si("gain")?,
                limit_v: accepted.si("limit"),
                slew_v_per_s: accepted.si("slew"),
            },
            LinkSort::StageDriver => Link::StageDriver {
                zero_v: accepted.si("zero")?,
                scale_v_per_um: accepted.quantity("scale")?.in_unit("V/um"),
            },
            LinkSort::Switch => Link::Switch { on_v: accepted.si("switches")? },
            LinkSort::Axis => self.axis(&accepted, span)?,
        };
        Some((link, limits))
    }

    /// The link to a magnet or a heater, which is on where the auxiliary output is high; `None` after an error.
    fn accessory_link(
        &mut self,
        name: &str,
        wire: &tree::Wire,
        channel: &str,
        scope: &Scope,
        draft: &WiringDraft,
    ) -> Option<Link> {
        if let WiredOwner::Device(_) = draft.owner.as_ref()? {
            self.sink.push(errors::channel_to_accessory(wire.channel.span, channel, name));
            return None;
        }
        let owner = Owner { name: format!("the wire to `{name}`"), declared: None };
        let given = given_in(&wire.fields, scope);
        self.read_fields(&owner, &given, &[]);
        let facts = self.facts::<AuxiliarySort>(draft.place)?;
        let declared = self.named(draft.place).1;
        self.sink.push_if_some(
            facts.is_graded.then(|| errors::share_of_accessory(wire.span, &draft.name, declared, name)),
        )?;
        Some(Link::Switch { on_v: facts.high_v })
    }

    /// The link to an axis of a stage controller; `None` after an error.
    fn axis(&mut self, accepted: &Accepted, span: Span) -> Option<Link> {
        let (from, to) = (accepted.quantity("travel_from")?, accepted.quantity("travel_to")?);
        let [least_um, most_um] = [from, to].map(|end| end.in_unit("um"));
        if least_um >= most_um {
            let place = accepted.get("travel_to").map_or(span, |field| field.span);
            self.sink.push(errors::no_travel(place, from, to));
            return None;
        }
        let direction = accepted.word("direction").and_then(Direction::find).unwrap_or_default();
        Some(Link::Axis { origin_um: accepted.length_um("origin")?, direction, least_um, most_um })
    }

    /// The name of a channel or an output, its indices joined: `bl[i].set` with i = 3 is `bl3.set`.
    pub fn channel_name(&mut self, segments: &[tree::IndexedName], scope: &Scope) -> Option<String> {
        let mut words = Vec::with_capacity(segments.len());
        for segment in segments {
            words.push(self.joined(&segment.name.text, &segment.indices, scope)?);
        }
        Some(words.join("."))
    }
}
