//! Wirings: which physical output drives which channel.

use super::Checker;
use super::devices::KindFacts;
use super::errors;
use super::programs::Wires;
use super::scope::{DeclarationPlace, DeclarationSort, Scope};
use crate::source::Span;
use crate::syntax::tree::{self, Item, WiringEntry};
use std::collections::BTreeMap;

/// The wires of one device while they are being read, with their places.
struct Panel {
    device: DeclarationPlace,
    name: String,
    /// `None` if its figures are unknown.
    facts: Option<KindFacts>,
    wired: BTreeMap<String, (String, Span)>,
}

impl<'a> Checker<'a> {
    /// Checks every wiring of the user's files.
    pub fn wires(&mut self) -> Wires {
        let modules = self.modules;
        let mut wires = Wires::new();
        let mut wirings: BTreeMap<DeclarationPlace, Span> = BTreeMap::new();
        let mut outputs: BTreeMap<String, Span> = BTreeMap::new();
        for (module, file) in modules.iter().enumerate().filter(|(_, file)| !file.is_library()) {
            for item in &file.tree.items {
                let Item::Wiring(item) = item else { continue };
                let mut scope = Scope::top(module, file.tree.file);
                let Some(mut panel) = self.panel(item, &scope) else { continue };
                if let Some(earlier) = wirings.insert(panel.device, item.device.span) {
                    self.sink.push(errors::wired_twice(&panel.name, item.device.span, earlier));
                }
                self.wiring_entries(&item.entries, &mut scope, &mut panel, &mut outputs);
                let named =
                    panel.wired.into_iter().map(|(channel, (output, _))| (format!("{}.{channel}", panel.name), output));
                wires.entry(panel.device).or_default().extend(named);
            }
        }
        wires
    }

    fn panel(&mut self, item: &tree::Wiring, scope: &Scope) -> Option<Panel> {
        let device = self.resolve(&item.device, scope, DeclarationSort::Device)?;
        let Item::Device(declared) = self.item(device) else { return None };
        let facts = self.facts(device);
        Some(Panel { device, name: declared.name.text.clone(), facts, wired: BTreeMap::new() })
    }

    fn wiring_entries(
        &mut self,
        entries: &[WiringEntry],
        scope: &mut Scope,
        panel: &mut Panel,
        outputs: &mut BTreeMap<String, Span>,
    ) {
        for entry in entries {
            match entry {
                WiringEntry::Wire(wire) => {
                    self.wire(wire, scope, panel, outputs);
                }
                WiringEntry::For(each) => self.repeat(each, scope, &mut |checker, scope| {
                    checker.wiring_entries(&each.entries, scope, panel, outputs);
                }),
                WiringEntry::Error(_) => {}
            }
        }
    }

    fn wire(
        &mut self,
        wire: &tree::Wire,
        scope: &Scope,
        panel: &mut Panel,
        outputs: &mut BTreeMap<String, Span>,
    ) -> Option<()> {
        let channel = self.channel_name(&wire.channel, scope);
        let output = self.text(&wire.output, wire.output.span, scope)?;
        let channel = channel?;
        let facts = panel.facts.as_ref()?;
        if !facts.has_channel(&channel) {
            let known = facts.channel_examples();
            self.sink.push(errors::unknown_channel(wire.channel.span, &panel.name, &channel, &known));
            return None;
        }
        if let Some((_, earlier)) = panel.wired.get(&channel) {
            self.sink.push(errors::channel_wired_twice(&channel, wire.channel.span, *earlier));
        }
        if let Some(earlier) = outputs.insert(output.clone(), wire.output.span) {
            self.sink.push(errors::output_used_twice(&output, wire.output.span, earlier));
        }
        panel.wired.insert(channel, (output, wire.channel.span));
        Some(())
    }

    /// `bl[i].set` with i = 3 is `bl3.set`.
    fn channel_name(&mut self, path: &tree::Path, scope: &Scope) -> Option<String> {
        let mut words = Vec::with_capacity(path.segments.len());
        for segment in &path.segments {
            words.push(self.joined(&segment.name.text, &segment.indices, scope)?);
        }
        Some(words.join("."))
    }
}
