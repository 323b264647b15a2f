//! Devices, instruments and outputs: bases, fields, and the facts that a device's kind derives from them.

use super::fields::{Given, Owner};
use super::lineage::Base;
use super::scope::{DeclarationPlace, DeclarationSort, in_a_used_file, nearest, path_text};
use super::value::Accepted;
use super::{Checker, KindFacts, checks, errors};
use crate::claims::ValueOrigin;
use crate::device::instrument::{AuxiliaryOutput, AuxiliarySort, Family, Instrument};
use crate::device::{Kind, VocabularyField};
use crate::source::Span;
use crate::syntax::tree::{self, Item};
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// A declaration with its own fields and those of its bases.
#[derive(Debug, Clone)]
pub(crate) struct CheckedDeclaration<R> {
    /// Root of its chain of bases.
    pub root: R,
    pub name: String,
    /// Span of its name in its declaration.
    pub span: Span,
    pub fields: Accepted,
    /// Origins of the field values in which a name stands.
    pub origins: FieldOrigins,
    /// Whether it or one of its bases gives an unknown field. The field that was meant then wrongly has the value of
    /// the base.
    has_unknown_field: bool,
}

/// A device and its kind.
pub(crate) type CheckedDevice = CheckedDeclaration<Kind>;

/// Origins of values, by field name.
pub type FieldOrigins = BTreeMap<&'static str, ValueOrigin>;

/// Checked declarations of one sort, each `None` after an error.
pub(crate) struct CheckedDeclarations<R: RootBase> {
    /// Declarations with all their inherited fields.
    inherited: BTreeMap<DeclarationPlace, Option<Rc<CheckedDeclaration<R>>>>,
    /// Facts, derived on demand: a declaration that only serves as a base may lack fields.
    pub facts: BTreeMap<DeclarationPlace, Option<R::Facts>>,
}

impl<R: RootBase> CheckedDeclarations<R> {
    pub fn new() -> Self {
        CheckedDeclarations { inherited: BTreeMap::new(), facts: BTreeMap::new() }
    }
}

/// Root of a chain of bases: a device kind, a family of instruments, or a sort of outputs.
pub(crate) trait RootBase: Copy + 'static {
    type Facts: Clone;
    const SORT: DeclarationSort;
    /// Phrase for messages, such as "a device of the kind".
    const OF: &'static str;
    const ALL: &'static [Self];
    fn name(self) -> &'static str;
    fn fields(self) -> &'static [VocabularyField];
    /// Library file and name in it of a published declaration to start from, if there is one.
    fn library(self) -> Option<(&'static str, &'static str)>;
    fn checked<'c>(checker: &'c mut Checker<'_>) -> &'c mut CheckedDeclarations<Self>;
    /// The facts of a declaration that lacks no field; `None` after an error.
    fn facts(
        checker: &mut Checker,
        place: DeclarationPlace,
        declared: &CheckedDeclaration<Self>,
    ) -> Option<Self::Facts>;
}

impl RootBase for Kind {
    type Facts = KindFacts;
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

    fn checked<'c>(checker: &'c mut Checker<'_>) -> &'c mut CheckedDeclarations<Kind> {
        &mut checker.devices
    }

    fn facts(checker: &mut Checker, _: DeclarationPlace, declared: &CheckedDeclaration<Kind>) -> Option<KindFacts> {
        checks(declared.root).facts(declared, checker.sink)
    }
}

impl RootBase for Family {
    type Facts = Instrument;
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

    fn checked<'c>(checker: &'c mut Checker<'_>) -> &'c mut CheckedDeclarations<Family> {
        &mut checker.instruments
    }

    fn facts(
        checker: &mut Checker,
        place: DeclarationPlace,
        declared: &CheckedDeclaration<Family>,
    ) -> Option<Instrument> {
        let item = with_base(checker.item(place))?;
        let facts = checker.facts_of_instrument(declared)?;
        Some(Instrument { model: path_text(&item.base), facts })
    }
}

impl RootBase for AuxiliarySort {
    type Facts = AuxiliaryOutput;
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

    fn checked<'c>(checker: &'c mut Checker<'_>) -> &'c mut CheckedDeclarations<AuxiliarySort> {
        &mut checker.outputs
    }

    fn facts(
        checker: &mut Checker,
        _: DeclarationPlace,
        declared: &CheckedDeclaration<AuxiliarySort>,
    ) -> Option<AuxiliaryOutput> {
        checker.facts_of_output(declared)
    }
}

impl<R: RootBase> CheckedDeclaration<R> {
    fn owner(&self) -> Owner {
        owner(self.root, &self.name, self.span)
    }

    /// Whether it has all required fields and no unknown value. Missing fields are reported, unless an unknown field
    /// may be meant for one of them.
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

/// The declaration of a device, an instrument or an output; `None` for other items.
fn with_base(item: &Item) -> Option<&tree::Device> {
    let (Item::Device(item) | Item::Instrument(item) | Item::Output(item)) = item else { return None };
    Some(item)
}

impl Checker<'_> {
    /// Checks every declaration of a sort in the user's files; one that only serves as a base may lack fields.
    pub fn check_declared<R: RootBase>(&mut self) {
        let own = self.own_places(R::SORT);
        let mut bases: BTreeSet<DeclarationPlace> = BTreeSet::new();
        for (place, _) in &own {
            let Some(item) = with_base(self.item(*place)) else { continue };
            bases.extend(self.find(&item.base, &self.top(*place)).map(|(base, _)| base));
            self.inherited::<R>(*place);
        }
        for (place, _) in own {
            if !bases.contains(&place) {
                self.facts::<R>(place);
            }
        }
    }

    /// The devices of the user's files whose facts are known, by name; one that only serves as a base may lack fields.
    pub fn known_devices(&self) -> Vec<(String, KindFacts)> {
        let own = self.own_places(DeclarationSort::Device).into_iter();
        let known = |place| Some((self.named(place).0.to_owned(), self.devices.facts.get(&place)?.clone()?));
        own.filter_map(|(place, _)| known(place)).collect()
    }

    /// A device, an instrument or an output with all that it inherits; `None` after an error.
    pub fn inherited<R: RootBase>(&mut self, place: DeclarationPlace) -> Option<Rc<CheckedDeclaration<R>>> {
        if let Some(known) = R::checked(self).inherited.get(&place) {
            return known.clone();
        }
        let chain =
            self.lineage(place, &|checker, at| R::checked(checker).inherited.contains_key(&at), &Checker::base::<R>);
        for (at, base) in chain.into_iter().rev() {
            let inherited = match base {
                Base::Root(root) => Some((root, None)),
                Base::Of(base) => {
                    let known = R::checked(self).inherited.get(&base).cloned().flatten();
                    known.map(|known| (known.root, Some(known)))
                }
                Base::Broken => None,
            };
            let declaration = self.inherit(at, inherited).map(Rc::new);
            R::checked(self).inherited.insert(at, declaration);
        }
        R::checked(self).inherited.get(&place).cloned().flatten()
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
        let (mut fields, mut origins) = base.map_or_else(
            || (Accepted::new(root.fields()), BTreeMap::new()),
            |base| (base.fields.clone(), base.origins.clone()),
        );
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

    /// The facts of a complete device, instrument or output; `None` after an error.
    pub fn facts<R: RootBase>(&mut self, place: DeclarationPlace) -> Option<R::Facts> {
        if let Some(known) = R::checked(self).facts.get(&place) {
            return known.clone();
        }
        let declared = self.inherited::<R>(place);
        let facts = declared
            .and_then(|declared| if declared.is_complete(self) { R::facts(self, place, &declared) } else { None });
        R::checked(self).facts.insert(place, facts.clone());
        facts
    }
}
