//! Devices, instruments and outputs: bases, fields, and the facts that a device's kind derives from them.

use super::fields::{Given, Owner};
use super::lineage::Base;
use super::scope::{DeclarationPlace, DeclarationSort, in_a_used_file, nearest, path_text};
use super::value::Accepted;
use super::{Checker, KindFacts, checks, errors};
use crate::claims::ValueOrigin;
use crate::device::instrument::{AuxiliarySort, Family};
use crate::device::{Kind, VocabularyField};
use crate::source::Span;
use crate::syntax::tree::{self, Item};
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// A declaration with its own fields and those of its bases.
#[derive(Debug, Clone)]
pub(crate) struct CheckedDeclaration<R> {
    /// Where its line of bases ends.
    pub root: R,
    pub name: String,
    /// Its name where it is declared.
    pub span: Span,
    pub fields: Accepted,
    /// Where the value of a field was given, if a name stands in it.
    pub origins: FieldOrigins,
    /// Whether it, or one of its bases, gives a field that is not known: of what the field was meant for, the value is not that of the base.
    has_unknown_field: bool,
}

/// A device and its kind.
pub(crate) type CheckedDevice = CheckedDeclaration<Kind>;

/// An instrument and its family.
pub(crate) type CheckedInstrument = CheckedDeclaration<Family>;

/// Where values were given, by the names of their fields.
pub type FieldOrigins = BTreeMap<&'static str, ValueOrigin>;

/// Declarations that were checked; `None` after an error.
pub(crate) type CheckedDeclarations<R> = BTreeMap<DeclarationPlace, Option<Rc<CheckedDeclaration<R>>>>;

/// What a line of bases ends in: a device kind, a family of instruments, or a sort of outputs.
pub(crate) trait RootBase: Copy + 'static {
    const SORT: DeclarationSort;
    /// "a device of the kind".
    const OF: &'static str;
    const ALL: &'static [Self];
    fn name(self) -> &'static str;
    fn fields(self) -> &'static [VocabularyField];
    /// Declares something published to start from, if there is such: the file, and its name there.
    fn library(self) -> Option<(&'static str, &'static str)>;
    fn checked<'c>(checker: &'c Checker<'_>) -> &'c CheckedDeclarations<Self>;
    fn checked_mut<'c>(checker: &'c mut Checker<'_>) -> &'c mut CheckedDeclarations<Self>;
}

impl RootBase for Kind {
    const SORT: DeclarationSort = DeclarationSort::Device;
    const OF: &'static str = "a device of the kind";
    const ALL: &'static [Kind] = Kind::ALL;

    fn name(self) -> &'static str {
        Kind::name(self)
    }

    fn fields(self) -> &'static [VocabularyField] {
        self.vocabulary().fields
    }

    fn library(self) -> Option<(&'static str, &'static str)> {
        Some(self.vocabulary().library)
    }

    fn checked<'c>(checker: &'c Checker<'_>) -> &'c CheckedDeclarations<Kind> {
        &checker.devices
    }

    fn checked_mut<'c>(checker: &'c mut Checker<'_>) -> &'c mut CheckedDeclarations<Kind> {
        &mut checker.devices
    }
}

impl RootBase for Family {
    const SORT: DeclarationSort = DeclarationSort::Instrument;
    const OF: &'static str = "an instrument of the family";
    const ALL: &'static [Family] = Family::ALL;

    fn name(self) -> &'static str {
        Family::name(self)
    }

    fn fields(self) -> &'static [VocabularyField] {
        Family::fields(self)
    }

    fn library(self) -> Option<(&'static str, &'static str)> {
        Some(Family::library(self))
    }

    fn checked<'c>(checker: &'c Checker<'_>) -> &'c CheckedDeclarations<Family> {
        &checker.instruments
    }

    fn checked_mut<'c>(checker: &'c mut Checker<'_>) -> &'c mut CheckedDeclarations<Family> {
        &mut checker.instruments
    }
}

impl RootBase for AuxiliarySort {
    const SORT: DeclarationSort = DeclarationSort::Output;
    const OF: &'static str = "an output of the sort";
    const ALL: &'static [AuxiliarySort] = AuxiliarySort::ALL;

    fn name(self) -> &'static str {
        AuxiliarySort::name(self)
    }

    fn fields(self) -> &'static [VocabularyField] {
        AuxiliarySort::fields(self)
    }

    fn library(self) -> Option<(&'static str, &'static str)> {
        None
    }

    fn checked<'c>(checker: &'c Checker<'_>) -> &'c CheckedDeclarations<AuxiliarySort> {
        &checker.outputs
    }

    fn checked_mut<'c>(checker: &'c mut Checker<'_>) -> &'c mut CheckedDeclarations<AuxiliarySort> {
        &mut checker.outputs
    }
}

impl<R: RootBase> CheckedDeclaration<R> {
    fn owner(&self) -> Owner {
        owner(self.root, &self.name, self.span)
    }

    /// Whether it has all that its kind requires and nothing unknown; what is missing is reported, unless an unknown field may be meant for it.
    pub fn is_complete(&self, checker: &mut Checker) -> bool {
        if self.has_unknown_field {
            return false;
        }
        let missing = Checker::missing(&self.fields, self.root.fields());
        if !missing.is_empty() {
            let (name, library) = (self.owner().name, self.root.library());
            checker.sink.push(errors::missing_fields(self.span, &name, &missing, library));
            return false;
        }
        !self.fields.values().any(|field| field.value.is_unknown())
    }
}

fn owner<R: RootBase>(root: R, name: &str, span: Span) -> Owner {
    let declared = Some((span, format!("{} {}", R::OF, root.name())));
    Owner { name: format!("{} `{name}`", R::SORT.name()), declared }
}

/// The declaration of a device, an instrument or an output.
fn with_base(item: &Item) -> Option<&tree::Device> {
    let (Item::Device(item) | Item::Instrument(item) | Item::Output(item)) = item else { return None };
    Some(item)
}

impl Checker<'_> {
    /// Checks every device of the user's files; one that only serves as a base may lack fields.
    pub fn check_devices(&mut self) {
        let own = self.own_places(DeclarationSort::Device);
        let mut bases: BTreeSet<DeclarationPlace> = BTreeSet::new();
        for (place, _) in &own {
            let Some(item) = with_base(self.item(*place)) else { continue };
            let base = self.find(&item.base, &self.top(*place)).map(|(base, _)| base);
            bases.extend(base);
            self.inherited::<Kind>(*place);
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

    /// A device, an instrument or an output with all that it inherits; `None` after an error.
    pub fn inherited<R: RootBase>(&mut self, place: DeclarationPlace) -> Option<Rc<CheckedDeclaration<R>>> {
        if let Some(known) = R::checked(self).get(&place) {
            return known.clone();
        }
        let chain = self.lineage(place, &|checker, at| R::checked(checker).contains_key(&at), &Checker::base::<R>);
        for (at, base) in chain.into_iter().rev() {
            let inherited = match base {
                Base::Root(root) => Some((root, None)),
                Base::Of(base) => {
                    let known = R::checked(self).get(&base).cloned().flatten();
                    known.map(|known| (known.root, Some(known)))
                }
                Base::Broken => None,
            };
            let declaration = self.inherit(at, inherited).map(Rc::new);
            R::checked_mut(self).insert(at, declaration);
        }
        R::checked(self).get(&place).cloned().flatten()
    }

    fn inherit<R: RootBase>(
        &mut self,
        place: DeclarationPlace,
        inherited: Option<(R, Option<Rc<CheckedDeclaration<R>>>)>,
    ) -> Option<CheckedDeclaration<R>> {
        let item = with_base(self.item(place))?;
        let scope = self.top(place);
        let Some((root, base)) = inherited else {
            self.read_for_errors(&item.fields, &scope);
            return None;
        };
        let owner = owner(root, &item.name.text, item.name.span);
        let given: Vec<Given> = item.fields.iter().map(|field| Given { field, scope: scope.clone() }).collect();
        let own = self.read_fields(&owner, &given, root.fields());
        let is_known = |field: &tree::Field| root.fields().iter().any(|known| known.name == field.name.text);
        let has_unknown_field =
            base.as_ref().is_some_and(|base| base.has_unknown_field) || !item.fields.iter().all(is_known);
        let (mut fields, mut origins) =
            base.map(|base| (base.fields.clone(), base.origins.clone())).unwrap_or_default();
        origins.retain(|name, _| !own.contains_key(name));
        for field in &item.fields {
            let name = own.keys().find(|name| **name == field.name.text);
            origins.extend(name.copied().zip(self.origin(&field.value, &scope)));
        }
        fields.extend(own);
        let (name, span) = (item.name.text.clone(), item.name.span);
        Some(CheckedDeclaration { root, name, span, fields, origins, has_unknown_field })
    }

    fn base<R: RootBase>(&mut self, place: DeclarationPlace) -> Base<R> {
        let Some(item) = with_base(self.item(place)) else { return Base::Broken };
        let is_plain_name = item.base.segments.len() == 1;
        let text = path_text(&item.base);
        if let Some(root) = R::ALL.iter().find(|root| root.name() == text).filter(|_| is_plain_name) {
            return Base::Root(*root);
        }
        let scope = self.top(place);
        if is_plain_name && self.find(&item.base, &scope).is_none() {
            self.report_unknown_base::<R>(item, place);
            return Base::Broken;
        }
        self.resolve(&item.base, &scope, R::SORT).map_or(Base::Broken, Base::Of)
    }

    fn report_unknown_base<R: RootBase>(&mut self, item: &tree::Device, place: DeclarationPlace) {
        let text = path_text(&item.base);
        if self.modules[place.module].is_broken(&text) {
            return;
        }
        let roots: Vec<&str> = R::ALL.iter().map(|root| root.name()).collect();
        let mut known = self.names_in_reach(&self.top(place), R::SORT);
        known.retain(|name| *name != item.name.text);
        let near = in_a_used_file(&text, &known);
        let near = near.or_else(|| nearest(&text, known.iter().map(String::as_str).chain(roots.iter().copied())));
        self.sink.push(errors::unknown_base(item.base.span, &text, R::SORT, near, &roots));
    }

    /// The facts of a complete device; `None` after an error.
    pub fn facts(&mut self, place: DeclarationPlace) -> Option<KindFacts> {
        if let Some(known) = self.facts.get(&place) {
            return known.clone();
        }
        let facts = self.inherited::<Kind>(place).and_then(|device| self.facts_of(&device));
        self.facts.insert(place, facts.clone());
        facts
    }

    fn facts_of(&mut self, device: &CheckedDevice) -> Option<KindFacts> {
        if device.is_complete(self) { checks(device.root).facts(device, self.sink) } else { None }
    }
}
