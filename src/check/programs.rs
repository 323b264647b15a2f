//! Programs: runs of tasks on one clock, and conflicts between them.

use super::errors::{self, WantedName};
use super::lets::Argument;
use super::neighbours::{Neighbours, RunSite};
use super::scope::{Declaration, DeclarationPlace, DeclarationSort, Scope, nearest};
use super::tasks::TaskRun;
use super::value::Value;
use super::wiring::Wiring;
use super::{Checker, checks};
use crate::claims::{Claims, Job, MAX_TIMELINE_DEPTH, Timeline};
use crate::device::Kind;
use crate::device::instrument::AuxiliaryOutput;
use crate::quantity::Dimension;
use crate::source::{Span, Spanned};
use crate::syntax::PARAMETER_SORTS;
use crate::syntax::tree::{self, Entry, Expr, ExprKind, Item};
use std::collections::{BTreeMap, BTreeSet};

/// Greatest number of runs and waits in one schedule.
pub const MAX_RUNS: usize = 10_000;

/// Greatest number of steps of all tasks of one schedule.
pub const MAX_STEPS: usize = 1_000_000;

/// Greatest nesting of programs.
pub const MAX_PROGRAM_DEPTH: usize = 64;

/// Schedule under construction.
#[derive(Default)]
struct Draft {
    /// One for each of `runs` if the draft is whole.
    jobs: Vec<Job>,
    /// Each run of a task.
    runs: Vec<RunSite>,
    /// The programs that are being read, the outermost first.
    open: Vec<DeclarationPlace>,
    /// The `run`s that led here, the outermost first.
    trail: Vec<Span>,
    /// For each run of a task, the `run`s that led to it and its own.
    trails: Vec<Vec<Span>>,
    /// Number of runs and waits so far.
    parts: usize,
    /// Number of steps of tasks so far.
    steps: usize,
    state: DraftState,
}

/// Whether a draft can still become a schedule.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
enum DraftState {
    #[default]
    Whole,
    /// There are errors; the rest is read only to report more of them.
    Broken,
    /// A limit is passed; nothing more is read.
    Full,
}

impl Draft {
    fn become_at_least(&mut self, state: DraftState) {
        self.state = self.state.max(state);
    }

    /// Where two runs of tasks are written; if both are one line of a program that is run twice, the `run`s that lead
    /// to each.
    fn distinguishing_spans(&self, first: usize, second: usize) -> [Span; 2] {
        let spans = [first, second].map(|run| self.runs[run].span);
        let [one, other] = [first, second].map(|run| self.trails.get(run).into_iter().flatten().copied());
        match one.zip(other).find(|(one, other)| one != other) {
            Some((one, other)) if spans[0] == spans[1] => [one, other],
            Some(_) | None => spans,
        }
    }
}

impl<'a> Checker<'a> {
    /// The claims of every schedule to be built. Everything that a build without `--task` makes is checked in any case.
    pub fn schedules(&mut self, only: Option<&str>, wiring: &Wiring) -> Vec<Claims> {
        let chosen = only.map(|name| self.root_named(name));
        let mut roots = self.roots();
        let extra = chosen.flatten().filter(|place| !roots.contains(place));
        roots.extend(extra);
        let mut schedules = Vec::with_capacity(roots.len());
        for root in roots {
            let claims = self.schedule(root, wiring);
            schedules.extend(claims.filter(|_| chosen.is_none_or(|chosen| chosen == Some(root))));
        }
        schedules
    }

    fn roots(&mut self) -> Vec<DeclarationPlace> {
        let programs = self.roots_of(DeclarationSort::Program);
        let roots = if programs.is_empty() { self.roots_of(DeclarationSort::Task) } else { programs };
        // Of two items with one name only the first is declared, so items are searched here.
        let declares_runs =
            self.modules[0].tree.items.iter().any(|item| matches!(item, Item::Task(_) | Item::Program(_)));
        if roots.is_empty() && !declares_runs && !self.modules[0].has_broken_parts() {
            let file = self.modules[0].tree.file;
            self.sink.push(errors::nothing_to_build(Span::new(file, 0, 0)));
        }
        roots
    }

    /// Checks every task and program that no schedule runs, with unknown values for their parameters.
    pub fn check_unrun(&mut self) {
        let sorts = [DeclarationSort::Program, DeclarationSort::Task];
        let unrun: Vec<(DeclarationPlace, Declaration)> =
            sorts.into_iter().flat_map(|sort| self.own_places(sort)).collect();
        let mut own = Vec::new();
        for (place, declaration) in unrun {
            if self.run.contains(&place) {
                continue;
            }
            let unknown = |parameter: &tree::Parameter| Spanned::new(Value::Unknown, parameter.span);
            let arguments: Vec<Spanned<Value>> = self.parameters(place).iter().map(unknown).collect();
            if place.module == 0 {
                own.push((place, declaration));
            }
            self.run(place, arguments, declaration.span, &mut Draft::default());
        }
        if self.sink.errors() == 0 {
            own.into_iter().for_each(|(place, declaration)| self.warn_of_unrun(place, declaration));
        }
    }

    fn warn_of_unrun(&mut self, place: DeclarationPlace, declaration: Declaration) {
        let (name, _) = self.named(place);
        let diagnostic = if self.parameters(place).is_empty() {
            errors::never_run(declaration.span, declaration.sort, name)
        } else {
            errors::never_run_with_parameters(declaration.span, declaration.sort, name)
        };
        self.sink.push(diagnostic);
    }

    /// Whether the program's own file declares something of a sort.
    pub fn declares(&self, sort: DeclarationSort) -> bool {
        self.modules[0].names.values().any(|declaration| declaration.sort == sort)
    }

    /// The programs or tasks of the program's own file that need no arguments.
    fn roots_of(&self, sort: DeclarationSort) -> Vec<DeclarationPlace> {
        let own = self.own_places(sort).into_iter().map(|(place, _)| place);
        own.filter(|place| place.module == 0 && self.parameters(*place).is_empty()).collect()
    }

    fn root_named(&mut self, name: &str) -> Option<DeclarationPlace> {
        let runnable = |sort| matches!(sort, DeclarationSort::Task | DeclarationSort::Program);
        let declared = self.modules[0].names.get(name).filter(|declaration| runnable(declaration.sort)).copied();
        let Some(declaration) = declared else {
            let names = self.modules[0].names.iter().filter(|(_, d)| runnable(d.sort)).map(|(name, _)| name.as_str());
            let names: Vec<&str> = names.collect();
            self.sink.push(errors::no_such_task(name, nearest(name, names.iter().copied()), &names));
            return None;
        };
        let place = DeclarationPlace { module: 0, item: declaration.item };
        if !self.parameters(place).is_empty() {
            self.sink.push(errors::task_needs_arguments(declaration.span, name));
            return None;
        }
        Some(place)
    }

    fn parameters(&self, place: DeclarationPlace) -> &'a [tree::Parameter] {
        self.item(place).runnable().map_or(&[], |runnable| runnable.parameters)
    }

    fn schedule(&mut self, root: DeclarationPlace, wiring: &Wiring) -> Option<Claims> {
        let declaration = self.declaration(root);
        let (name, _) = self.named(root);
        let mut draft = Draft::default();
        let timeline = self.run(root, Vec::new(), declaration.span, &mut draft);
        self.check_device_conflicts(&timeline, &draft);
        let timeline = timeline.flat();
        if timeline.depth() > MAX_TIMELINE_DEPTH {
            self.sink.push(errors::too_deep(declaration.span, "groups of runs", MAX_TIMELINE_DEPTH));
            return None;
        }
        self.names_apart(&draft);
        if draft.state != DraftState::Whole {
            return None;
        }
        let errors = self.sink.errors();
        Kind::ALL.iter().for_each(|kind| checks(*kind).check_continuity(&mut draft.jobs, self.sink));
        if self.sink.errors() > errors {
            return None;
        }
        let Neighbours { shared, not_held } = self.neighbours(&timeline, &draft.runs, &mut draft.jobs);
        if self.sink.errors() > errors {
            return None;
        }
        let mut outputs = self.outputs_of(&draft.jobs);
        let on_bench = |outputs: &BTreeMap<String, (AuxiliaryOutput, DeclarationPlace)>| {
            let places = outputs.values().map(|(_, place)| *place);
            wiring.of(draft.runs.iter().map(|run| run.device).chain(places))
        };
        let switched = on_bench(&outputs).1;
        for (name, resting) in self.resting_outputs(wiring, &switched) {
            outputs.entry(name).or_insert(resting);
        }
        let (wires, bench) = on_bench(&outputs);
        if let Some(finding) = self.starts_apart(&bench, declaration.span) {
            self.sink.push(finding);
            return None;
        }
        self.holds_of(&draft.jobs, &wires, &bench);
        if self.sink.errors() > errors {
            return None;
        }
        let (name, jobs) = (name.to_owned(), draft.jobs);
        let outputs = outputs.into_iter().map(|(name, (facts, _))| (name, facts)).collect();
        let claims = Claims { name, timeline, jobs, wires, bench, outputs, shared, not_held, span: declaration.span };
        let idle = self.idle_outputs(wiring, &claims);
        Kind::ALL.iter().for_each(|kind| checks(*kind).warn_of_mismatches(&claims, &idle, self.sink));
        Some(claims)
    }

    /// Runs a task or a program with its arguments; `span` is where it is run.
    fn run(
        &mut self,
        place: DeclarationPlace,
        arguments: Vec<Spanned<Value>>,
        span: Span,
        draft: &mut Draft,
    ) -> Timeline {
        self.run.insert(place);
        match self.item(place) {
            Item::Task(item) => self.run_task(TaskRun { task: place, arguments, span }, item, draft),
            Item::Program(item) => self.run_program(place, item, &arguments, span, draft),
            Item::Use(_)
            | Item::Let(_)
            | Item::Device(_)
            | Item::Instrument(_)
            | Item::Output(_)
            | Item::Scene(_)
            | Item::Wiring(_)
            | Item::Error(_) => Timeline::Sequence(Vec::new()),
        }
    }

    fn run_task(&mut self, run: TaskRun, item: &tree::Task, draft: &mut Draft) -> Timeline {
        let device = self.find(&item.device, &self.top(run.task)).map(|(device, _)| device);
        let job = self.job(&run);
        let Some(device) = device.filter(|device| matches!(self.item(*device), Item::Device(_))) else {
            draft.become_at_least(DraftState::Broken);
            return Timeline::Sequence(Vec::new());
        };
        let scene = item.scene.as_ref().and_then(|path| self.find(path, &self.top(run.task)));
        draft.trails.push(draft.trail.clone());
        draft.runs.push(RunSite { device, scene: scene.map(|(scene, _)| scene), span: run.span });
        let timeline = Timeline::Run(draft.runs.len() - 1);
        let Some(job) = job else {
            draft.become_at_least(DraftState::Broken);
            return timeline;
        };
        draft.steps += job.steps();
        if draft.steps > MAX_STEPS {
            self.sink.push(errors::too_many_steps(run.span, MAX_STEPS));
            draft.become_at_least(DraftState::Full);
            return Timeline::Sequence(Vec::new());
        }
        draft.jobs.push(job);
        timeline
    }

    fn run_program(
        &mut self,
        place: DeclarationPlace,
        item: &'a tree::Program,
        arguments: &[Spanned<Value>],
        span: Span,
        draft: &mut Draft,
    ) -> Timeline {
        if let Some(first) = draft.open.iter().position(|open| *open == place) {
            if !self.circular.contains(&place) {
                self.sink.push(errors::defined_by_itself(&item.name.text, item.name.span, span));
            }
            self.circular.extend(&draft.open[first..]);
            draft.become_at_least(DraftState::Broken);
            return Timeline::Sequence(Vec::new());
        }
        if draft.open.len() >= MAX_PROGRAM_DEPTH {
            self.sink.push(errors::too_deep(span, "programs", MAX_PROGRAM_DEPTH));
            draft.become_at_least(DraftState::Broken);
            return Timeline::Sequence(Vec::new());
        }
        draft.open.push(place);
        let mut scope = self.top(place);
        self.bind(&item.parameters, arguments, &mut scope);
        let timeline = Timeline::Sequence(self.program_entries(&item.entries, &mut scope, draft));
        draft.open.pop();
        timeline
    }

    fn program_entries(&mut self, entries: &'a [Entry], scope: &mut Scope, draft: &mut Draft) -> Vec<Timeline> {
        let mut parts = Vec::new();
        for entry in entries {
            if draft.state == DraftState::Full {
                break;
            }
            match entry {
                Entry::Step(step) => parts.extend(self.program_step(step, scope, draft)),
                Entry::For(each) => {
                    self.repeat(each, scope, &mut |checker, scope| {
                        parts.extend(checker.program_entries(&each.entries, scope, draft));
                    });
                }
                Entry::Field(field) => {
                    self.sink.push(errors::field_in_program(&field.name));
                    draft.become_at_least(DraftState::Broken);
                }
                Entry::Error(_) => draft.become_at_least(DraftState::Broken),
            }
        }
        parts
    }

    fn program_step(&mut self, step: &'a tree::Step, scope: &mut Scope, draft: &mut Draft) -> Option<Timeline> {
        draft.parts += 1;
        if draft.parts > MAX_RUNS {
            self.sink.push(errors::too_many_runs(step.span, MAX_RUNS));
            draft.become_at_least(DraftState::Full);
            return None;
        }
        let timeline = match step.head.text.as_str() {
            "run" => self.run_step(step, scope, draft),
            "wait" | "prompt" if super::holds::is_hold(step) => {
                self.sink.push(errors::hold_in_program(&step.head));
                None
            }
            "wait" => self.wait(step, scope).map(Timeline::Wait),
            "together" => self.together(step, scope, draft),
            other => {
                let near = nearest(other, ["run", "wait", "together"]);
                self.sink.push(match self.modules[scope.module].names.get(other).map(|declared| declared.sort) {
                    Some(DeclarationSort::Task | DeclarationSort::Program) => errors::run_without_its_word(&step.head),
                    _ => errors::unknown_program_step(&step.head, near),
                });
                None
            }
        };
        if timeline.is_none() {
            draft.become_at_least(DraftState::Broken);
        }
        timeline
    }

    fn together(&mut self, step: &'a tree::Step, scope: &mut Scope, draft: &mut Draft) -> Option<Timeline> {
        let alone = step.phrases.is_empty() && step.object.is_none() && step.noun.is_none();
        let Some(block) = step.block.as_ref().filter(|_| alone) else {
            self.sink.push(errors::bad_together(step.span));
            return None;
        };
        Some(Timeline::Together(self.program_entries(block, scope, draft)))
    }

    fn run_step(&mut self, step: &'a tree::Step, scope: &Scope, draft: &mut Draft) -> Option<Timeline> {
        let alone = step.phrases.is_empty() && step.block.is_none() && step.noun.is_none();
        let (path, arguments) = match step.object.as_ref().filter(|_| alone).map(|object| &object.kind) {
            Some(ExprKind::Path(path)) => (path, [].as_slice()),
            Some(ExprKind::Call { function, arguments }) => (function, arguments.as_slice()),
            Some(ExprKind::Error) => return None,
            _ => {
                self.sink.push(errors::bad_run(step.span));
                return None;
            }
        };
        let named = self.find(path, scope).map(|(place, _)| self.declaration(place).sort);
        let sort = match named {
            Some(DeclarationSort::Program) => DeclarationSort::Program,
            Some(_) | None => DeclarationSort::Task,
        };
        let place = self.resolve(path, scope, sort)?;
        let values = self.arguments(place, path.span, arguments, scope)?;
        draft.trail.push(step.span);
        let timeline = self.run(place, values, step.span, draft);
        draft.trail.pop();
        Some(timeline)
    }

    fn arguments(
        &mut self,
        place: DeclarationPlace,
        span: Span,
        arguments: &[Expr],
        scope: &Scope,
    ) -> Option<Vec<Spanned<Value>>> {
        let parameters = self.parameters(place);
        if parameters.len() != arguments.len() {
            let (form, declared) = (self.call_form(place), self.declaration(place).span);
            self.sink.push(errors::wrong_argument_count(span, &form, parameters.len(), arguments.len(), declared));
            return None;
        }
        let mut values = Vec::with_capacity(arguments.len());
        for (parameter, argument) in parameters.iter().zip(arguments) {
            let value = match ParameterSort::find(&parameter.sort.text) {
                Some(ParameterSort::Object(noun)) => {
                    let wanted = WantedName {
                        name: format!("parameter `{}`", parameter.name.text),
                        doc: String::new(),
                        declared: Some((parameter.span, format!("declared as a {noun}"))),
                    };
                    self.accept_object(noun, argument, scope, &wanted).unwrap_or(Value::Unknown)
                }
                Some(_) | None => self.evaluate(argument, scope),
            };
            let is_name = matches!(argument.kind, ExprKind::Path(_));
            let argument = self.argument_of(argument, value, scope);
            let given = argument.origin.as_ref().filter(|_| is_name).map_or(argument.span, |origin| origin.span);
            values.push(Spanned::new(self.argument(parameter, argument), given));
        }
        Some(values)
    }

    /// Signature for messages, as `go(goal: cell)`.
    fn call_form(&self, place: DeclarationPlace) -> String {
        let (name, _) = self.named(place);
        let parameters = self.parameters(place);
        if parameters.is_empty() {
            return name.to_owned();
        }
        let list: Vec<String> = parameters.iter().map(|p| format!("{}: {}", p.name.text, p.sort.text)).collect();
        format!("{name}({})", list.join(", "))
    }

    fn argument(&mut self, parameter: &tree::Parameter, value: Argument) -> Value {
        let Some(sort) = ParameterSort::find(&parameter.sort.text) else { return Value::Unknown };
        if value.value.is_unknown() || sort.holds(&value.value) {
            return value.value;
        }
        let wanted = WantedName {
            name: format!("parameter `{}`", parameter.name.text),
            doc: String::new(),
            declared: Some((parameter.span, format!("declared as {}", sort.describe()))),
        };
        let diagnostic = match sort {
            ParameterSort::Quantity(dimension) => errors::wrong_dimension(&wanted, dimension, value.span, &value.value),
            ParameterSort::Cell
            | ParameterSort::Place
            | ParameterSort::Pose
            | ParameterSort::Word
            | ParameterSort::Object(_) => {
                errors::wrong_value(&wanted, &sort.describe(), sort.example(), value.span, &value.value)
            }
        };
        self.unknown(errors::given_at(diagnostic, &value))
    }

    /// Puts parameters into scope; their names and sorts are checked.
    pub fn bind(&mut self, parameters: &[tree::Parameter], arguments: &[Spanned<Value>], scope: &mut Scope) {
        for (index, parameter) in parameters.iter().enumerate() {
            if let Some(earlier) = self.taken(&parameter.name.text, scope) {
                self.sink.push(errors::declared_twice(&parameter.name.text, parameter.name.span, earlier));
                continue;
            }
            if let Some(reserved_as) = super::scope::reserved_as(&parameter.name.text) {
                self.sink.push(errors::reserved_name(&parameter.name, reserved_as));
                continue;
            }
            if ParameterSort::find(&parameter.sort.text).is_none() {
                let names = Vec::from_iter(parameter_sorts());
                let near = nearest(&parameter.sort.text, names.iter().copied());
                self.sink.push(errors::unknown_parameter_sort(&parameter.sort, near, &names));
            }
            let unknown = || Spanned::new(Value::Unknown, parameter.span);
            scope.push(&parameter.name, arguments.get(index).cloned().unwrap_or_else(unknown));
        }
    }

    /// Reports devices in two runs at a time, at both places. Returns each device of the part with the index of one of
    /// its runs.
    fn check_device_conflicts(&mut self, timeline: &Timeline, draft: &Draft) -> BTreeMap<DeclarationPlace, usize> {
        match timeline {
            Timeline::Run(run) => BTreeMap::from([(draft.runs[*run].device, *run)]),
            Timeline::Wait(_) => BTreeMap::new(),
            Timeline::Sequence(parts) => {
                parts.iter().flat_map(|part| self.check_device_conflicts(part, draft)).collect()
            }
            Timeline::Together(parts) => {
                let mut busy: BTreeMap<DeclarationPlace, usize> = BTreeMap::new();
                for part in parts {
                    for (device, run) in self.check_device_conflicts(part, draft) {
                        if let Some(earlier) = busy.insert(device, run) {
                            let (name, _) = self.named(device);
                            let [first, second] = draft.distinguishing_spans(earlier, run);
                            self.sink.push(errors::two_things_at_once(name, first, second));
                        }
                    }
                }
                busy
            }
        }
    }

    /// Channels carry the device's name alone, so two devices of one name cannot share a schedule.
    fn names_apart(&mut self, draft: &Draft) {
        let mut seen: BTreeMap<&str, (DeclarationPlace, Span)> = BTreeMap::new();
        for RunSite { device, span, .. } in draft.runs.iter().copied() {
            let (name, _) = self.named(device);
            let (first, earlier) = *seen.entry(name).or_insert((device, span));
            if first != device {
                self.sink.push(errors::devices_of_one_name(name, earlier, span));
            }
        }
        for (output, (_, place)) in self.outputs_of(&draft.jobs) {
            if let Some((device, _)) = seen.get(output.as_str()) {
                let [declared, other] = [place, *device].map(|place| self.named(place).1);
                self.sink.push(errors::outputs_of_one_name(&output, declared, other));
            }
        }
    }
}

/// Sort of a parameter.
#[derive(Clone, Copy)]
enum ParameterSort {
    Quantity(Dimension),
    Cell,
    Place,
    Pose,
    Word,
    /// An object of the task's scene, by its noun.
    Object(&'static str),
}

/// The nouns that a parameter can have: objects that a device handles, not obstacles.
fn object_nouns() -> impl Iterator<Item = &'static str> {
    let nouns = Kind::ALL.iter().flat_map(|kind| kind.vocabulary().nouns).map(|noun| noun.name);
    nouns.filter(|noun| *noun != "obstacle").collect::<BTreeSet<_>>().into_iter()
}

/// The words that name the sort of a parameter.
pub fn parameter_sorts() -> impl Iterator<Item = &'static str> {
    PARAMETER_SORTS.iter().copied().chain(object_nouns())
}

impl ParameterSort {
    fn find(name: &str) -> Option<ParameterSort> {
        Some(match name {
            "length" => ParameterSort::Quantity(Dimension::LENGTH),
            "time" => ParameterSort::Quantity(Dimension::TIME),
            "angle" => ParameterSort::Quantity(Dimension::ANGLE),
            "voltage" => ParameterSort::Quantity(Dimension::VOLTAGE),
            "force" => ParameterSort::Quantity(Dimension::FORCE),
            "speed" => ParameterSort::Quantity(Dimension::SPEED),
            "number" => ParameterSort::Quantity(Dimension::NUMBER),
            "cell" => ParameterSort::Cell,
            "place" => ParameterSort::Place,
            "pose" => ParameterSort::Pose,
            "word" => ParameterSort::Word,
            _ => return object_nouns().find(|noun| *noun == name).map(ParameterSort::Object),
        })
    }

    fn describe(self) -> String {
        match self {
            ParameterSort::Quantity(dimension) => dimension.with_article(),
            ParameterSort::Cell => "a cell".to_owned(),
            ParameterSort::Place => "a place".to_owned(),
            ParameterSort::Pose => "a pose".to_owned(),
            ParameterSort::Word => "a word".to_owned(),
            ParameterSort::Object(noun) => format!("a {noun}"),
        }
    }

    fn example(self) -> &'static str {
        match self {
            ParameterSort::Quantity(_) => "1",
            ParameterSort::Cell => "(19, 28)",
            ParameterSort::Place => "(3.2 um, 5.9 um)",
            ParameterSort::Pose => "pose(8 um, 3 um, 30 deg)",
            ParameterSort::Word => "0b10001_00010",
            ParameterSort::Object(_) => "m1",
        }
    }

    fn holds(self, value: &Value) -> bool {
        let point_of = |dimension| matches!(value, Value::Point(p) if p.len() == 2 && p[0].dimension == dimension);
        match self {
            ParameterSort::Quantity(dimension) => matches!(value, Value::Quantity(q) if q.dimension == dimension),
            ParameterSort::Cell => point_of(Dimension::NUMBER),
            ParameterSort::Place => point_of(Dimension::LENGTH) || point_of(Dimension::PIXELS),
            ParameterSort::Pose => matches!(value, Value::Pose(_)),
            ParameterSort::Word => matches!(value, Value::Word(_)),
            ParameterSort::Object(noun) => matches!(value, Value::Object(object) if object.noun == noun),
        }
    }
}
