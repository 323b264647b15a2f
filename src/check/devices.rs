//! Devices: bases, fields, and what the kind makes of them.

use super::fields::{Accepted, Given, Owner};
use super::scope::{DeclarationSort, Place, nearest, path_text};
use super::{Checker, dimibot, errors};
use crate::device::{self, Kind};
use crate::source::Span;
use crate::syntax::tree::{self, Item};
use std::collections::BTreeSet;
use std::rc::Rc;

/// How many devices may stand on one another as bases.
pub const MAX_BASES: usize = 32;

/// A device with its own fields and those of its bases.
#[derive(Debug, Clone)]
pub struct Device {
    pub kind: Kind,
    pub name: String,
    /// Its name where it is declared.
    pub span: Span,
    pub fields: Accepted,
}

impl Device {
    fn owner(&self) -> Owner {
        owner(self.kind, &self.name, self.span)
    }
}

fn owner(kind: Kind, name: &str, span: Span) -> Owner {
    let declared = Some((span, format!("a device of the kind {}", kind.name())));
    Owner { name: format!("device `{name}`"), declared }
}

/// The facts of a device in its kind's own type.
#[derive(Debug, Clone)]
pub enum Facts {
    Dimibot(Rc<device::dimibot::Facts>),
}

impl Facts {
    /// The kind that these are facts of.
    pub fn kind(&self) -> Kind {
        match self {
            Facts::Dimibot(_) => Kind::Dimibot,
        }
    }
}

impl Checker<'_> {
    /// Checks every device of the user's files; one that only serves as a base may lack fields.
    pub fn check_devices(&mut self) {
        let own = self.own_places(DeclarationSort::Device);
        let mut bases: BTreeSet<Place> = BTreeSet::new();
        for (place, _) in &own {
            let Item::Device(item) = self.item(*place) else { continue };
            let base = self.find(&item.base, &self.top(*place)).map(|(base, _)| base);
            bases.extend(base);
            self.device(*place, 0);
        }
        for (place, _) in own {
            if !bases.contains(&place) {
                self.facts(place);
            }
        }
    }

    /// A device with all that it inherits; `None` after an error.
    pub fn device(&mut self, place: Place, depth: usize) -> Option<Device> {
        if let Some(known) = self.devices.get(&place) {
            return known.clone();
        }
        let Item::Device(item) = self.item(place) else { return None };
        // An entry that stands before it is made out ends a circle of bases.
        self.devices.insert(place, None);
        let device = self.inherit(place, item, depth);
        self.devices.insert(place, device.clone());
        device
    }

    fn inherit(&mut self, place: Place, item: &tree::Device, depth: usize) -> Option<Device> {
        let scope = self.top(place);
        let Some((kind, mut fields)) = self.base(place, item, depth) else {
            self.read_for_errors(&item.fields, &scope);
            return None;
        };
        let owner = owner(kind, &item.name.text, item.name.span);
        let given: Vec<Given> = item.fields.iter().map(|field| Given { field, scope: scope.clone() }).collect();
        fields.extend(self.read_fields(&owner, &given, kind.vocabulary().fields));
        Some(Device { kind, name: item.name.text.clone(), span: item.name.span, fields })
    }

    fn base(&mut self, place: Place, item: &tree::Device, depth: usize) -> Option<(Kind, Accepted)> {
        let text = path_text(&item.base);
        if let Some(kind) = Kind::find(&text).filter(|_| item.base.segments.len() == 1) {
            return Some((kind, Accepted::new()));
        }
        let scope = self.top(place);
        let is_plain_name = item.base.segments.len() == 1;
        if is_plain_name && self.find(&item.base, &scope).is_none() {
            self.report_unknown_base(item, place);
            return None;
        }
        let base = self.resolve(&item.base, &scope, DeclarationSort::Device)?;
        if self.is_own_base(place, base) {
            self.sink.push(errors::defined_by_itself(item.base.span, item.name.span));
            return None;
        }
        if depth >= MAX_BASES {
            self.sink.push(errors::too_deep(item.base.span, "devices", MAX_BASES));
            return None;
        }
        let base = self.device(base, depth + 1)?;
        Some((base.kind, base.fields))
    }

    fn report_unknown_base(&mut self, item: &tree::Device, place: Place) {
        let text = path_text(&item.base);
        let kinds: Vec<&str> = Kind::ALL.iter().map(|kind| kind.name()).collect();
        let mut known = self.names_in_reach(&self.top(place), DeclarationSort::Device);
        known.retain(|name| *name != item.name.text);
        let near = nearest(&text, known.iter().map(String::as_str).chain(kinds.iter().copied()));
        self.sink.push(errors::unknown_kind(item.base.span, &text, near, &kinds));
    }

    /// Whether following the bases from `base` leads back to `place`.
    fn is_own_base(&self, place: Place, base: Place) -> bool {
        let mut seen = BTreeSet::new();
        let mut at = base;
        while seen.insert(at) {
            if at == place {
                return true;
            }
            let Item::Device(item) = self.item(at) else { return false };
            match self.find(&item.base, &self.top(at)) {
                Some((next, _)) => at = next,
                None => return false,
            }
        }
        false
    }

    /// The facts of a complete device; `None` after an error.
    pub fn facts(&mut self, place: Place) -> Option<Facts> {
        let device = self.device(place, 0)?;
        let missing = Self::missing(&device.fields, device.kind.vocabulary().fields);
        if !missing.is_empty() {
            let library = device.kind.vocabulary().library;
            self.sink.push(errors::missing_fields(device.span, &device.owner().name, &missing, Some(library)));
            return None;
        }
        match device.kind {
            Kind::Dimibot => dimibot::facts(&device, self.sink).map(|facts| Facts::Dimibot(Rc::new(facts))),
        }
    }
}
