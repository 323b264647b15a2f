//! Devices: bases, fields, and the facts that the kind derives from them.

use super::fields::{Given, Owner};
use super::lineage::Base;
use super::scope::{DeclarationPlace, DeclarationSort, in_a_used_file, nearest, path_text};
use super::value::Accepted;
use super::{Checker, KindFacts, checks, errors};
use crate::claims::ValueOrigin;
use crate::device::Kind;
use crate::source::Span;
use crate::syntax::tree::{self, Item};
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// A device with its own fields and those of its bases.
#[derive(Debug, Clone)]
pub struct CheckedDevice {
    pub kind: Kind,
    pub name: String,
    /// Its name where it is declared.
    pub span: Span,
    pub fields: Accepted,
    /// Where the value of a field was given, if a name stands in it.
    pub origins: FieldOrigins,
}

/// Where values were given, by the names of their fields.
pub type FieldOrigins = BTreeMap<&'static str, ValueOrigin>;

impl CheckedDevice {
    fn owner(&self) -> Owner {
        owner(self.kind, &self.name, self.span)
    }
}

fn owner(kind: Kind, name: &str, span: Span) -> Owner {
    let declared = Some((span, format!("a device of the kind {}", kind.name())));
    Owner { name: format!("device `{name}`"), declared }
}

impl Checker<'_> {
    /// Checks every device of the user's files; one that only serves as a base may lack fields.
    pub fn check_devices(&mut self) {
        let own = self.own_places(DeclarationSort::Device);
        let mut bases: BTreeSet<DeclarationPlace> = BTreeSet::new();
        for (place, _) in &own {
            let Item::Device(item) = self.item(*place) else { continue };
            let base = self.find(&item.base, &self.top(*place)).map(|(base, _)| base);
            bases.extend(base);
            self.device(*place);
        }
        for (place, _) in own {
            if !bases.contains(&place) {
                self.facts(place);
            }
        }
    }

    /// The devices of the user's files whose facts are known, by name; one that only serves as a base may lack fields.
    pub fn known_devices(&self) -> Vec<(String, KindFacts)> {
        let own = self.own_places(DeclarationSort::Device).into_iter();
        let known = |place| Some((self.named(place).0.to_owned(), self.facts.get(&place)?.clone()?));
        own.filter_map(|(place, _)| known(place)).collect()
    }

    /// A device with all that it inherits; `None` after an error.
    pub fn device(&mut self, place: DeclarationPlace) -> Option<Rc<CheckedDevice>> {
        let chain = self.lineage(place, &|checker, at| checker.devices.contains_key(&at), &Checker::base);
        for (at, base) in chain.into_iter().rev() {
            let inherited = match base {
                Base::Root(kind) => Some((kind, Accepted::new(), FieldOrigins::new())),
                Base::Of(base) => {
                    let known = self.devices.get(&base).and_then(Option::as_ref);
                    known.map(|device| (device.kind, device.fields.clone(), device.origins.clone()))
                }
                Base::Broken => None,
            };
            let device = self.inherit(at, inherited).map(Rc::new);
            self.devices.insert(at, device);
        }
        self.devices.get(&place).cloned().flatten()
    }

    fn inherit(
        &mut self,
        place: DeclarationPlace,
        inherited: Option<(Kind, Accepted, FieldOrigins)>,
    ) -> Option<CheckedDevice> {
        let Item::Device(item) = self.item(place) else { return None };
        let scope = self.top(place);
        let Some((kind, mut fields, mut origins)) = inherited else {
            self.read_for_errors(&item.fields, &scope);
            return None;
        };
        let owner = owner(kind, &item.name.text, item.name.span);
        let given: Vec<Given> = item.fields.iter().map(|field| Given { field, scope: scope.clone() }).collect();
        let own = self.read_fields(&owner, &given, kind.vocabulary().fields);
        origins.retain(|name, _| !own.contains_key(name));
        for field in &item.fields {
            let name = own.keys().find(|name| **name == field.name.text);
            origins.extend(name.copied().zip(self.origin(&field.value, &scope)));
        }
        fields.extend(own);
        Some(CheckedDevice { kind, name: item.name.text.clone(), span: item.name.span, fields, origins })
    }

    fn base(&mut self, place: DeclarationPlace) -> Base<Kind> {
        let Item::Device(item) = self.item(place) else { return Base::Broken };
        let is_plain_name = item.base.segments.len() == 1;
        if let Some(kind) = Kind::find(&path_text(&item.base)).filter(|_| is_plain_name) {
            return Base::Root(kind);
        }
        let scope = self.top(place);
        if is_plain_name && self.find(&item.base, &scope).is_none() {
            self.report_unknown_base(item, place);
            return Base::Broken;
        }
        self.resolve(&item.base, &scope, DeclarationSort::Device).map_or(Base::Broken, Base::Of)
    }

    fn report_unknown_base(&mut self, item: &tree::Device, place: DeclarationPlace) {
        let text = path_text(&item.base);
        if self.modules[place.module].is_broken(&text) {
            return;
        }
        let kinds: Vec<&str> = Kind::ALL.iter().map(|kind| kind.name()).collect();
        let mut known = self.names_in_reach(&self.top(place), DeclarationSort::Device);
        known.retain(|name| *name != item.name.text);
        let near = in_a_used_file(&text, &known);
        let near = near.or_else(|| nearest(&text, known.iter().map(String::as_str).chain(kinds.iter().copied())));
        self.sink.push(errors::unknown_kind(item.base.span, &text, near, &kinds));
    }

    /// The facts of a complete device; `None` after an error.
    pub fn facts(&mut self, place: DeclarationPlace) -> Option<KindFacts> {
        if let Some(known) = self.facts.get(&place) {
            return known.clone();
        }
        let facts = self.device(place).and_then(|device| self.facts_of(&device));
        self.facts.insert(place, facts.clone());
        facts
    }

    fn facts_of(&mut self, device: &CheckedDevice) -> Option<KindFacts> {
        let missing = Self::missing(&device.fields, device.kind.vocabulary().fields);
        if !missing.is_empty() {
            let library = device.kind.vocabulary().library;
            self.sink.push(errors::missing_fields(device.span, &device.owner().name, &missing, Some(library)));
            return None;
        }
        if device.fields.values().any(|field| field.value.is_unknown()) {
            return None;
        }
        checks(device.kind).facts(device, self.sink)
    }
}
