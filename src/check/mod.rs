//! Checker: resolves names, checks dimensions, evaluates values, and judges whether the devices and scenes are
//! possible.
//!
//! Input: the files of a program as trees. Output: [`Checked`], the schedules to be built as [`Claims`]. Promise: every
//! fault is reported, each once; a checked program is returned exactly if no error was pushed, so that later stages
//! meet no unresolved name and no bare number.

mod boards;
mod budget;
mod camera;
mod curve;
pub mod devices;
mod dimibot;
mod electrode_array;
mod errors;
pub mod evaluate;
mod fields;
mod figures;
mod fingers;
pub(crate) mod frames;
mod functions;
mod holds;
pub mod imports;
mod instruments;
mod labels;
pub mod lets;
mod limits;
mod lineage;
pub mod links;
mod lost;
mod meshes;
pub mod microrobots;
mod neighbours;
mod objects;
mod orientation;
mod outputs;
pub(crate) mod programs;
pub mod reduced;
mod rows;
mod scenes;
pub mod scope;
mod settings;
mod shapes;
mod solid;
mod sorts;
mod tasks;
mod unused;
pub mod value;
mod verbs;
mod wiring;

use crate::claims::{Claims, Job, Order};
use crate::device::instrument::{AuxiliarySort, Drive, Family};
use crate::device::{self, Kind, each_kind, for_each_kind};
use crate::diagnostic::Sink;
use crate::quantity::Quantity;
use crate::source::{Sources, Span, Spanned};
use crate::syntax::tree::{Expr, For, Item, Path};
use devices::CheckedDeclarations;
use imports::Library;
use lets::LetState;
use lost::LostWords;
use rustc_hash::FxHashSet;
use scope::{Declaration, DeclarationPlace, DeclarationSort, Import, Module, Scope};
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;
use std::sync::Arc;
use value::Value;

/// Greatest total number of iterations of all `for`s of a program.
pub const MAX_REPETITIONS: usize = 1_000_000;

/// Settings from the command line.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// `--set name=value`, as given.
    pub settings: Vec<String>,
    /// `--task name`: build this task or program alone.
    pub only: Option<String>,
}

/// A program as it is handed to the compiler.
pub struct ProgramSource<'a> {
    /// The name that outputs carry, without a folder. Used files are resolved relative to it; the library gives its
    /// form in messages.
    pub name: &'a str,
    pub text: &'a str,
    pub library: &'a dyn Library,
    pub options: &'a Options,
}

/// A program without an error.
#[derive(Debug, Clone)]
pub struct Checked {
    /// One for each schedule to be built, in the order of declaration.
    pub claims: Vec<Claims>,
    /// The complete devices of the program's own files, in the order of declaration, by name.
    pub devices: Vec<(String, KindFacts)>,
    pub tally: DeclarationTally,
}

/// Counts of declarations in the program's own file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DeclarationTally {
    pub devices: usize,
    pub scenes: usize,
    pub tasks: usize,
    pub programs: usize,
}

/// Reads and checks a program with the files that it uses; `None` after an error.
pub fn check_program(program: &ProgramSource, sources: &mut Sources, sink: &mut Sink) -> Option<Checked> {
    let modules = imports::load(sources, program.name, program.text, program.library, sink);
    check(sources, &modules, program.options, sink)
}

/// Checks a program: its own file is the first module, used files follow.
///
/// Returns a checked program exactly if neither this stage nor an earlier one pushed an error.
pub fn check(sources: &mut Sources, modules: &[Module], options: &Options, sink: &mut Sink) -> Option<Checked> {
    let checked = Checker::new(modules, sink).check_all(sources, options);
    let lost = LostWords::of(sources, sink);
    if !lost.is_empty() {
        *sink = std::mem::take(sink).retained(|finding| !lost.explain(finding, sources));
    }
    (sink.errors() == 0).then_some(checked)
}

/// The longest time that one field or step may take, in nanoseconds: a little over a day.
pub const MAX_TIME_NS: u64 = 100_000_000_000_000;

/// A time in whole nanoseconds; `None` after an error where it is out of the clock's range. `what` names it in the
/// message.
fn clock_ns(time: Quantity, span: Span, what: &str, sink: &mut Sink) -> Option<u64> {
    let ns = time.in_unit("ns").round();
    let limit = Quantity::time_ns(MAX_TIME_NS);
    if ns > MAX_TIME_NS as f64 {
        sink.push(errors::time_out_of_clock(span, what, &time.to_string(), &format!("at most {limit} is allowed")));
        return None;
    }
    if time.in_unit("ns") < 1.0 && time.si > 0.0 {
        sink.push(errors::time_out_of_clock(span, what, &time.to_string(), "the least is 1 ns"));
        return None;
    }
    Some(ns as u64)
}

/// The facts of a device in its kind's own type.
#[derive(Debug, Clone)]
pub enum KindFacts {
    Dimibot(Rc<device::dimibot::DimibotFacts>),
    ElectrodeArray(Rc<device::electrode_array::ElectrodeArrayFacts>),
    Microrobots(Rc<microrobots::CheckedBed>),
    Fingers(Arc<device::fingers::FingersFacts>),
}

/// Checks of a kind that work on the facts of one of its devices.
trait CheckedFacts {
    /// The names of its channels, for a message; of a long list only the first and the last.
    fn channel_examples(&self) -> Vec<String>;

    /// The names of all its channels, in their order.
    fn all_channels(&self) -> Vec<String> {
        self.channel_examples()
    }

    /// Whether its channels are positions of stages rather than voltages.
    fn moves_stages(&self) -> bool {
        false
    }

    /// Grid pitch for a message, as `cells of 80 um`; `None` where positions are continuous.
    fn pitch(&self) -> Option<String> {
        None
    }

    /// Whether the device has a channel of a name.
    fn has_channel(&self, name: &str) -> bool {
        self.channel_examples().iter().any(|channel| channel == name)
    }

    /// The channel that switches a named electrode, if that channel bears the name of another electrode that shares it.
    fn shared_channel(&self, _name: &str) -> Option<String> {
        None
    }

    /// Its channels with their numbers on an electrode driver; `None` for a kind without electrodes.
    fn numbered_channels(&self) -> Option<wiring::NumberedChannels> {
        None
    }

    /// The order of a task on the device; `None` after an error.
    fn order(&self, checker: &mut Checker, site: &tasks::TaskSite, parts: tasks::Parts) -> Option<Order>;
}

impl KindFacts {
    /// The facts as the trait that all kinds implement.
    fn as_checked_facts(&self) -> &dyn CheckedFacts {
        each_kind!(KindFacts, self, facts => facts)
    }

    /// Grid pitch for a message, as `cells of 80 um`; `None` where positions are continuous.
    pub fn pitch(&self) -> Option<String> {
        self.as_checked_facts().pitch()
    }
}

/// Checks of a kind that derive the facts of its devices or compare several jobs.
trait KindChecks {
    /// The facts of a device that lacks no field; `None` after an error.
    fn facts(&self, device: &devices::CheckedDevice, sink: &mut Sink) -> Option<KindFacts>;

    /// Checks that the jobs of a program, in their order, agree on where the kind's devices and their parts are. A kind
    /// may enter what earlier jobs leave behind into later ones.
    fn check_continuity(&self, jobs: &mut [Job], sink: &mut Sink);

    /// Warns of steps that do not suit the settings of the bench's instruments or what comes before them. `idle` are
    /// the outputs that are wired to these instruments and that no step switches, each with its drive.
    fn warn_of_mismatches(&self, _claims: &Claims, _idle: &[(String, Drive)], _sink: &mut Sink) {}

    /// Adds the program's placed devices that never run as obstacles of the others; for kinds that have frames.
    fn add_idle_obstacles(&self, _checker: &mut Checker, _placed: &neighbours::PlacedDevices, _jobs: &mut [Job]) {}
}

/// The checks of a kind.
fn checks(kind: Kind) -> &'static dyn KindChecks {
    macro_rules! checks_of {
        ({} $($module:ident $kind:ident),+) => {
            match kind { $(Kind::$kind => &$module::CHECKS,)+ }
        };
    }
    for_each_kind!(checks_of, {})
}

/// Checker state.
pub(crate) struct Checker<'a> {
    modules: &'a [Module],
    sink: &'a mut Sink,
    lets: BTreeMap<DeclarationPlace, LetState>,
    /// Expressions that `--set` gives in place of the values of some `let`s.
    replaced: BTreeMap<DeclarationPlace, Rc<Expr>>,
    devices: CheckedDeclarations<Kind>,
    instruments: CheckedDeclarations<Family>,
    outputs: CheckedDeclarations<AuxiliarySort>,
    /// Declarations of the outputs that tasks switch, by name.
    outputs_by_name: BTreeMap<String, DeclarationPlace>,
    scenes: BTreeMap<DeclarationPlace, Option<Rc<scenes::CheckedScene>>>,
    used: BTreeSet<DeclarationPlace>,
    used_imports: BTreeSet<(usize, String)>,
    /// The tasks and programs that some schedule runs.
    run: BTreeSet<DeclarationPlace>,
    /// The programs that run themselves, already reported.
    circular: BTreeSet<DeclarationPlace>,
    jobs: BTreeMap<DeclarationPlace, Option<Rc<Job>>>,
    /// Scenes as devices see them, each scene checked once with each device.
    judged: objects::JudgedScenes,
    /// Mesh files that were read, by the module and the path written there; `None` after an error.
    meshes: BTreeMap<(usize, String), Option<Rc<value::MeshFile>>>,
    /// Board files, with the same keys.
    boards: BTreeMap<(usize, String), Option<Rc<value::BoardFile>>>,
    repetitions: usize,
    /// Whether some `for` has no iterations, so that names used only in its body seem unused.
    has_idle_loop: bool,
    /// Links from names to their declarations; `None` unless an editor asks for them.
    links: Option<FxHashSet<links::NameLink>>,
    budget: budget::CheckBudget,
}

impl<'a> Checker<'a> {
    /// Runs every check, whatever errors are found.
    fn check_all(&mut self, sources: &mut Sources, options: &Options) -> Checked {
        let overrides = settings::parse(sources, &options.settings, self.sink);
        self.apply_settings(overrides);
        self.check_values();
        self.check_declared::<Kind>();
        self.check_declared::<Family>();
        self.check_declared::<AuxiliarySort>();
        self.check_scenes();
        let wiring = self.wiring();
        let claims = self.schedules(options.only.as_deref(), &wiring);
        let devices = self.known_devices();
        self.check_unrun();
        self.warn_of_unused();
        Checked { claims, devices, tally: self.tally() }
    }

    fn new(modules: &'a [Module], sink: &'a mut Sink) -> Self {
        Checker {
            modules,
            sink,
            lets: BTreeMap::new(),
            replaced: BTreeMap::new(),
            devices: CheckedDeclarations::new(),
            instruments: CheckedDeclarations::new(),
            outputs: CheckedDeclarations::new(),
            outputs_by_name: BTreeMap::new(),
            scenes: BTreeMap::new(),
            used: BTreeSet::new(),
            used_imports: BTreeSet::new(),
            run: BTreeSet::new(),
            circular: BTreeSet::new(),
            jobs: BTreeMap::new(),
            judged: objects::JudgedScenes::new(),
            meshes: BTreeMap::new(),
            boards: BTreeMap::new(),
            repetitions: 0,
            has_idle_loop: false,
            links: None,
            budget: budget::CheckBudget::default(),
        }
    }

    /// The declarations of a sort in the user's files, in order; the standard library is left out.
    fn own_places(&self, sort: DeclarationSort) -> Vec<(DeclarationPlace, Declaration)> {
        let own = self.modules.iter().enumerate().filter(|(_, module)| !module.is_library());
        let mut places: Vec<(DeclarationPlace, Declaration)> = own
            .flat_map(|(module, file)| {
                let declared = file.names.values().filter(move |declaration| declaration.sort == sort);
                declared.map(move |declaration| (DeclarationPlace { module, item: declaration.item }, *declaration))
            })
            .collect();
        places.sort_by_key(|(place, _)| *place);
        places
    }

    fn check_values(&mut self) {
        for (place, declaration) in self.own_places(DeclarationSort::Let) {
            self.value_of_let(place, declaration.span);
        }
    }

    fn item(&self, place: DeclarationPlace) -> &'a Item {
        &self.modules[place.module].tree.items[place.item]
    }

    fn top(&self, place: DeclarationPlace) -> Scope {
        Scope::top(place.module)
    }

    /// The declaration at a place.
    fn declaration(&self, place: DeclarationPlace) -> Declaration {
        let (name, sort) = scope::declared(self.item(place)).expect("every place comes from a declaration");
        Declaration { sort, item: place.item, span: name.span }
    }

    /// The name of a declaration, and where that name stands.
    fn named(&self, place: DeclarationPlace) -> (&'a str, Span) {
        scope::declared(self.item(place)).map_or(("", Span::default()), |(name, _)| (&name.text, name.span))
    }

    fn use_place(&mut self, place: DeclarationPlace) {
        self.used.insert(place);
    }

    /// The declaration that a path names, and the index of the segment that names it; pushes no diagnostic.
    fn find(&self, path: &Path, scope: &Scope) -> Option<(DeclarationPlace, usize)> {
        let file = &self.modules[scope.module];
        let first = &path.segments[0].name.text;
        if let Some(declaration) = file.names.get(first) {
            return Some((DeclarationPlace { module: scope.module, item: declaration.item }, 0));
        }
        let import = file.imports.get(first)?;
        let second = &path.segments.get(1)?.name.text;
        let module = import.module?;
        let declaration = self.modules[module].names.get(second)?;
        Some((DeclarationPlace { module, item: declaration.item }, 1))
    }

    /// Whether a path names a local or a declaration, and is therefore not a bare word.
    fn names_value(&self, path: &Path, scope: &Scope) -> bool {
        scope.local(&path.segments[0].name.text).is_some() || self.find(path, scope).is_some()
    }

    /// The declaration of a sort that a path names; faults are reported.
    fn resolve(&mut self, path: &Path, scope: &Scope, sort: DeclarationSort) -> Option<DeclarationPlace> {
        if let Some(segment) = path.segments.iter().find(|segment| !segment.indices.is_empty()) {
            self.sink.push(errors::indexed_name(segment.span));
            return None;
        }
        self.use_import(path, scope);
        let Some((place, segment)) = self.find(path, scope) else {
            return self.report_unknown(path, scope, sort);
        };
        self.use_place(place);
        let declaration = self.declaration(place);
        self.note_use(path.segments[segment].name.span, declaration.span);
        if declaration.sort != sort {
            self.sink.push(errors::wrong_sort(path, declaration, sort.describe()));
            return None;
        }
        if let Some(extra) = path.segments.get(segment + 1) {
            self.sink.push(errors::no_fields_on_values(extra.span));
            return None;
        }
        Some(place)
    }

    fn use_import(&mut self, path: &Path, scope: &Scope) {
        if path.segments.len() > 1 {
            self.used_imports.insert((scope.module, path.segments[0].name.text.clone()));
        }
    }

    /// Reports an unknown name, unless its declaration could not be read or its file could not be used, which
    /// was already reported.
    ///
    /// Returns the declaration in this file that a misspelt device or scene most likely means, so that what depends on
    /// it is checked all the same.
    fn report_unknown(&mut self, path: &Path, scope: &Scope, sort: DeclarationSort) -> Option<DeclarationPlace> {
        let file = &self.modules[scope.module];
        let first = &path.segments[0];
        let import = file.imports.get(&first.name.text);
        let is_alone = path.segments.len() == 1;
        let is_broken = match import.and_then(|import| import.module) {
            Some(used) => path.segments.get(1).is_some_and(|word| self.modules[used].is_broken(&word.name.text)),
            None => file.is_broken(&first.name.text),
        };
        if is_broken {
            return None;
        }
        match import {
            Some(Import { module: None, .. }) => {}
            Some(import) if is_alone => {
                self.sink.push(errors::file_for_value(path.span, &first.name.text, import.span, sort));
            }
            // The name may be that of a file that could not be used, or of a `use` that could not be read.
            None if !is_alone && file.has_broken_use(&first.name.text) => {}
            None if !is_alone => {
                let near = scope::nearest(&first.name.text, file.imports.keys().map(String::as_str));
                self.sink.push(match file.used_as(&first.name.text) {
                    Some((alias, used)) => errors::file_used_as(path, alias, used),
                    None => errors::unknown_file(path, sort, near),
                });
            }
            Some(_) | None => {
                // A finding that is only counted needs no near name, and the search among very many names is slow.
                let known = if self.sink.is_full() { Vec::new() } else { self.names_in_reach(scope, sort) };
                let text = scope::path_text(path);
                let near = scope::in_a_used_file(&text, &known);
                let near = near.or_else(|| scope::nearest(&text, known.iter().map(String::as_str)));
                let finding = errors::unknown_name(path.span, &text, sort, near);
                let object = file.object_of_scenes(&text).filter(|_| sort == DeclarationSort::Let);
                if let Some(object) = object {
                    let finding = errors::object_for_place(path.span, &object.noun.text, &object.name.name);
                    self.sink.push(finding);
                    return None;
                }
                let beside = text.rfind('.').filter(|_| near.is_none()).map(|dot| &text[..=dot]);
                let beside =
                    beside.map(|file| known.iter().map(String::as_str).filter(move |name| name.starts_with(file)));
                self.sink.push(finding.help_if(beside.and_then(errors::declared_there)));
                if matches!(sort, DeclarationSort::Device | DeclarationSort::Scene) {
                    let meant = near.and_then(|near| file.names.get(near));
                    return meant.map(|meant| DeclarationPlace { module: scope.module, item: meant.item });
                }
            }
        }
        None
    }

    /// The names of a sort that may be written here.
    fn names_in_reach(&self, scope: &Scope, sort: DeclarationSort) -> Vec<String> {
        let file = &self.modules[scope.module];
        let of_sort =
            |module: &'a Module| module.names.iter().filter(move |(_, d)| d.sort == sort).map(|(name, _)| name);
        let mut known: Vec<String> = of_sort(file).cloned().collect();
        if sort == DeclarationSort::Let {
            known.extend(scope.local_names().map(str::to_owned));
        }
        let used = file.imports.iter().filter_map(|(alias, import)| Some((alias, &self.modules[import.module?])));
        for (alias, module) in used {
            known.extend(of_sort(module).map(|name| format!("{alias}.{name}")));
        }
        known
    }

    /// Runs a `for`: `inside` is called for each element with the loop's names in scope.
    fn repeat<E>(&mut self, each: &For<E>, scope: &mut Scope, inside: &mut dyn FnMut(&mut Self, &mut Scope)) {
        for name in each.counter.iter().chain([&each.element]) {
            if let Some(earlier) = self.taken(&name.text, scope) {
                self.sink.push(errors::declared_twice(&name.text, name.span, earlier));
                return;
            }
            if let Some(reserved_as) = scope::reserved_as(&name.text) {
                self.sink.push(errors::reserved_name(name, reserved_as));
                return;
            }
        }
        if self.repetitions > MAX_REPETITIONS {
            return;
        }
        let elements = self.elements(&each.over, scope);
        self.has_idle_loop |= elements.is_empty();
        // Inside another loop, or with parameters, zero iterations may be intended.
        if elements.is_empty() && scope.local_names().next().is_none() {
            self.sink.push(errors::repeats_nothing(each.over.span));
        }
        for (number, element) in elements.into_iter().enumerate() {
            // The body may have passed the limit, already reported there.
            if self.repetitions > MAX_REPETITIONS {
                return;
            }
            self.repetitions += 1;
            if self.repetitions > MAX_REPETITIONS {
                self.sink.push(errors::too_many_repetitions(each.over.span, MAX_REPETITIONS));
                return;
            }
            scope.with(&each.element, element, |scope| match &each.counter {
                Some(counter) => {
                    let number = Spanned::new(Value::number(number as f64), each.over.span);
                    scope.with(counter, number, |scope| inside(self, scope))
                }
                None => inside(self, scope),
            });
        }
    }

    /// Charges the cost of a curve or a solid as `turns` loop iterations of equal cost; `false` once the limit is
    /// passed, which is reported at `span`.
    fn charge_iterations(&mut self, turns: usize, span: Span) -> bool {
        let before = self.repetitions;
        self.repetitions = before.saturating_add(turns);
        if before <= MAX_REPETITIONS && self.repetitions > MAX_REPETITIONS {
            self.sink.push(errors::too_many_outlines(span));
        }
        self.repetitions <= MAX_REPETITIONS
    }

    /// The elements that a `for` runs over; a single unknown value if they are unknown.
    fn elements(&mut self, over: &Expr, scope: &Scope) -> Vec<Spanned<Value>> {
        match self.evaluate(over, scope) {
            Value::Range { from, to } => {
                (from..to).map(|number| Spanned::new(Value::number(number as f64), over.span)).collect()
            }
            Value::List(list) => {
                let element =
                    |element: &Spanned<Value>| Spanned::new(self.charged_copy(&element.value, over.span), element.span);
                list.iter().map(element).collect()
            }
            Value::Unknown => vec![Spanned::new(Value::Unknown, over.span)],
            other => {
                self.sink.push(errors::not_to_repeat(over.span, &other));
                vec![Spanned::new(Value::Unknown, over.span)]
            }
        }
    }

    /// Span of the declaration that already has a name, as seen from a block; `None` if the name is free.
    fn taken(&self, name: &str, scope: &Scope) -> Option<Span> {
        let file = &self.modules[scope.module];
        let local = scope.local(name).map(|local| local.span);
        local.or(file.names.get(name).map(|d| d.span)).or(file.imports.get(name).map(|import| import.span))
    }

    fn tally(&self) -> DeclarationTally {
        let count = |sort| self.modules[0].names.values().filter(|declaration| declaration.sort == sort).count();
        DeclarationTally {
            devices: count(DeclarationSort::Device),
            scenes: count(DeclarationSort::Scene),
            tasks: count(DeclarationSort::Task),
            programs: count(DeclarationSort::Program),
        }
    }
}

#[cfg(test)]
mod tests;
