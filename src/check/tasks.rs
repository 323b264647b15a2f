//! Tasks: settings and steps, in the words of the kind of their device.

use super::Checker;
use super::devices::CheckedDevice;
use super::errors::{self, WantedName};
use super::fields::{Given, Owner};
use super::figures::Figures;
use super::lets::Argument;
use super::scenes::CheckedScene;
use super::scope::{DeclarationPlace, DeclarationSort, STEP_WORDS, Scope, nearest, path_text};
use super::value::{Accepted, Value};
use super::verbs::Call;
use crate::claims::auxiliary::{AuxiliaryAction, AuxiliaryEvent, Hold};
use crate::claims::{Job, Relation, Requirement};
use crate::device::{self, Assay, Kind, Together, Vocabulary, instrument::HoldTerms};
use crate::quantity::Dimension;
use crate::source::{Span, Spanned};
use crate::syntax::tree::{self, Entry, Expr, ExprKind, Ident, Item, Operator};
use std::collections::BTreeMap;
use std::rc::Rc;

/// A run of a task: its arguments, and where it is run.
pub struct TaskRun {
    pub task: DeclarationPlace,
    pub arguments: Vec<Spanned<Value>>,
    pub span: Span,
}

/// A task's body, checked against its kind's vocabulary.
pub struct Parts {
    /// Objective that `minimize` names, with the place of the step.
    pub objective: Option<Spanned<&'static str>>,
    /// The planner that the task names.
    pub planner: Option<Spanned<&'static device::Planner>>,
    /// Its options, or those of the kind's first planner.
    pub options: Accepted,
    pub start: Option<Argument>,
    pub settings: Accepted,
    pub requirements: Vec<Requirement>,
    /// Required contents of droplets.
    pub contents: Vec<ContentRequirement>,
    /// The kind's own conditions.
    pub conditions: Vec<Call>,
    pub steps: Vec<VocabularyStep>,
    /// Switching of auxiliary outputs.
    pub events: Vec<AuxiliaryEvent>,
    /// Waits for an input or a person.
    pub holds: Vec<Hold>,
    /// Whether nothing was left out because of errors.
    pub is_whole: bool,
}

impl Parts {
    /// The limit of expansions set by the task, or the vocabulary's default.
    pub fn expansions(&self) -> Option<u64> {
        self.options.count("expansions").map(u64::from)
    }
}

/// `require sample.dye == 1/8`, before its names are looked up in a scene.
pub struct ContentRequirement {
    /// The name of the droplet, and where it stands.
    pub part: Spanned<String>,
    /// The name of a fluid, or `volume`.
    pub share: Spanned<String>,
    pub relation: Relation,
    pub limit: f64,
    pub span: Span,
}

/// A step in the vocabulary's words.
pub struct VocabularyStep {
    pub action: VocabularyAction,
    pub span: Span,
}

/// Action of a step.
pub enum VocabularyAction {
    Verb(Call),
    /// Goals that are reached at the same time, in the order of writing.
    Together(Vec<Call>),
    /// Operations that depend on each other only by their objects, in the order of writing.
    Assay(Vec<Call>),
    /// In nanoseconds.
    Wait(u64),
}

/// Context of a task: its device with the facts of its kind, and its scene.
pub struct TaskSite {
    pub place: DeclarationPlace,
    pub device: Rc<CheckedDevice>,
    pub scene: Option<(DeclarationPlace, Rc<CheckedScene>)>,
}

/// The body while it is being read.
struct TaskReading<'a> {
    vocabulary: &'static Vocabulary,
    task: &'a tree::Task,
    parts: Parts,
    given: Vec<Given<'a>>,
    seen: BTreeMap<String, Span>,
    nesting: Nesting,
}

impl TaskReading<'_> {
    /// Records the switching of an output. For the device it is a wait of no duration.
    fn switched(&mut self, output: String, action: AuxiliaryAction) -> VocabularyAction {
        self.parts.events.push(AuxiliaryEvent { step: self.parts.steps.len(), output, action });
        VocabularyAction::Wait(0)
    }

    /// Records a wait for an input or a person. For the device it is a wait of the longest time.
    fn held(&mut self, terms: HoldTerms) -> VocabularyAction {
        self.parts.holds.push(Hold { step: self.parts.steps.len(), terms: terms.clone() });
        VocabularyAction::Wait(terms.duration_ns)
    }
}

/// Whether a step of a task is a setting; settings come before everything that is done.
pub fn is_setting(step: &tree::Step) -> bool {
    let head = step.head.text.as_str();
    matches!(head, "minimize" | "using" | "require")
        || (head == "start" && step.object.is_none())
        || device::condition_of_any_kind(head).is_some()
}

/// Whether a setting may be given several times, also in a `for`; conditions may.
pub fn may_repeat(head: &Ident, vocabulary: &Vocabulary) -> bool {
    head.text == "require" || vocabulary.condition(&head.text).is_some()
}

/// Whether the entries stand in the task itself or in a `for` of it.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Nesting {
    Task,
    Loop,
}

impl<'a> Checker<'a> {
    /// One run of a task; `None` after an error, or where a parameter is unknown. Without parameters all runs are equal.
    pub fn job(&mut self, run: &TaskRun) -> Option<Job> {
        if !run.arguments.is_empty() {
            return self.job_of(run);
        }
        if !self.jobs.contains_key(&run.task) {
            let job = self.job_of(run).map(Rc::new);
            self.jobs.insert(run.task, job);
        }
        let known = self.jobs.get(&run.task).and_then(Option::as_ref)?;
        Some(Job { run_span: run.span, ..Job::clone(known) })
    }

    fn job_of(&mut self, run: &TaskRun) -> Option<Job> {
        let Item::Task(item) = self.item(run.task) else { return None };
        let mut scope = self.task_scope(run.task, item, &run.arguments);
        let top = self.top(run.task);
        let place = self.resolve(&item.device, &top, DeclarationSort::Device);
        let scene = item.scene.as_ref().map(|path| self.resolve(path, &top, DeclarationSort::Scene));
        let place = place?;
        let device = self.inherited::<Kind>(place)?;
        scope.view = self.view_of(scene);
        // The task's words are checked even if the device's own figures are unknown.
        let mut parts = self.parts(item, device.root.vocabulary(), scope);
        let is_whole = parts.is_whole && super::limits::can_be_kept(&parts.requirements, self.sink);
        let requirements = std::mem::take(&mut parts.requirements);
        let events = std::mem::take(&mut parts.events);
        let holds = std::mem::take(&mut parts.holds);
        let scene = match scene {
            None => None,
            Some(place) => Some(place.and_then(|place| Some((place, self.scene(place)?)))?),
        };
        let named = scene.as_ref().map(|(_, scene)| scene.as_ref());
        self.link_objects(&parts.steps, named);
        self.link_conditions(&item.entries, device.root.vocabulary(), named);
        let site = TaskSite { place, device: Rc::clone(&device), scene };
        let order = self.facts::<Kind>(place)?.as_checked_facts().order(self, &site, parts);
        Some(Job {
            task: item.name.text.clone(),
            device: device.name.clone(),
            requirements,
            order: order.filter(|_| is_whole)?,
            events,
            holds,
            span: item.name.span,
            run_span: run.span,
        })
    }

    fn task_scope(&mut self, place: DeclarationPlace, item: &tree::Task, arguments: &[Spanned<Value>]) -> Scope {
        let mut scope = self.top(place);
        self.bind(&item.parameters, arguments, &mut scope);
        scope
    }

    fn parts(&mut self, task: &'a tree::Task, vocabulary: &'static Vocabulary, mut scope: Scope) -> Parts {
        let parts = Parts {
            objective: None,
            planner: None,
            options: Accepted::new(vocabulary.planners[0].options),
            start: None,
            settings: Accepted::new(vocabulary.settings),
            requirements: Vec::new(),
            contents: Vec::new(),
            conditions: Vec::new(),
            steps: Vec::new(),
            events: Vec::new(),
            holds: Vec::new(),
            is_whole: true,
        };
        let mut reading =
            TaskReading { vocabulary, task, parts, given: Vec::new(), seen: BTreeMap::new(), nesting: Nesting::Task };
        self.entries(&task.entries, &mut scope, &mut reading);
        let owner = Owner { name: format!("task `{}`", task.name.text), declared: None };
        reading.parts.settings = self.read_fields(&owner, &reading.given, vocabulary.settings);
        reading.parts
    }

    fn entries(&mut self, entries: &'a [Entry], scope: &mut Scope, reading: &mut TaskReading<'a>) {
        for entry in entries {
            match entry {
                Entry::Field(field) => {
                    self.settings_come_first(&field.name, reading);
                    reading.given.push(Given { field, scope: scope.clone() });
                }
                Entry::Step(step) => self.entry(step, scope, reading),
                Entry::For(each) => {
                    let outer = std::mem::replace(&mut reading.nesting, Nesting::Loop);
                    self.repeat(each, scope, &mut |checker, scope| checker.entries(&each.entries, scope, reading));
                    reading.nesting = outer;
                }
                Entry::Error(_) => reading.parts.is_whole = false,
            }
        }
    }

    fn entry(&mut self, step: &'a tree::Step, scope: &Scope, reading: &mut TaskReading<'a>) {
        if is_setting(step) {
            // A repeated setting is a mistake wherever it stands.
            if may_repeat(&step.head, reading.vocabulary) || !reading.seen.contains_key(&step.head.text) {
                self.settings_come_first(&step.head, reading);
            }
            self.setting(step, scope, reading);
            return;
        }
        match self.step(step, scope, reading) {
            Some(action) => reading.parts.steps.push(VocabularyStep { action, span: step.span }),
            None => reading.parts.is_whole = false,
        }
    }

    fn settings_come_first(&mut self, name: &tree::Ident, reading: &TaskReading) {
        match reading.parts.steps.first() {
            Some(first) => self.sink.push(errors::setting_after_step(name, first.span)),
            // Conditions and requirements may be set for many objects at once.
            None if reading.nesting == Nesting::Loop && !may_repeat(name, reading.vocabulary) => {
                self.sink.push(errors::setting_in_loop(name));
            }
            None => {}
        }
    }

    fn setting(&mut self, step: &'a tree::Step, scope: &Scope, reading: &mut TaskReading<'a>) {
        let head = &step.head;
        let is_single = !may_repeat(head, reading.vocabulary);
        if let Some(earlier) = reading.seen.insert(head.text.clone(), head.span).filter(|_| is_single) {
            self.sink.push(errors::setting_twice(head, earlier));
        }
        match head.text.as_str() {
            "minimize" => {
                let objective = self.objective(step, reading.vocabulary);
                reading.parts.objective = objective.map(|value| Spanned { value, span: step.span });
            }
            "using" => {
                if let Some((planner, options)) = self.planner(step, scope, reading.vocabulary) {
                    (reading.parts.planner, reading.parts.options) = (Some(planner), options);
                }
            }
            "require" => match content_sides(step, reading.vocabulary) {
                Some(sides) if !self.names_value(sides.path, scope) => match self.content(step, &sides, scope) {
                    Some(content) => reading.parts.contents.push(content),
                    None => reading.parts.is_whole = false,
                },
                Some(_) | None => match self.requirement(step, scope, reading.vocabulary) {
                    Some(requirement) => reading.parts.requirements.push(requirement),
                    None => reading.parts.is_whole = false,
                },
            },
            "start" => reading.parts.start = self.start(step, scope, reading),
            word => {
                let condition = reading.vocabulary.condition(word);
                let call = match condition {
                    Some(condition) => self.verb_call(step, scope, condition),
                    // A condition of another kind is reported.
                    None => self.verb(step, scope, reading.vocabulary),
                };
                match call {
                    Some(call) => reading.parts.conditions.push(call),
                    None => reading.parts.is_whole = false,
                }
            }
        }
    }

    fn objective(&mut self, step: &tree::Step, vocabulary: &'static Vocabulary) -> Option<&'static str> {
        let wanted = WantedName { name: "`minimize`".to_owned(), doc: String::new(), declared: None };
        let expr = self.only_object(step, "distance")?;
        let Value::Text(word) =
            self.accept(device::Sort::Word(vocabulary.objectives), expr, &self.nowhere(), &wanted)?
        else {
            return None;
        };
        vocabulary.objectives.iter().find(|choice| choice.name == word).map(|choice| choice.name)
    }

    /// A scope for words, which are looked up in tables and not among names.
    fn nowhere(&self) -> Scope {
        Scope::top(0)
    }

    fn planner(
        &mut self,
        step: &'a tree::Step,
        scope: &Scope,
        vocabulary: &'static Vocabulary,
    ) -> Option<(Spanned<&'static device::Planner>, Accepted)> {
        let expr = self.only_object(step, vocabulary.planners[0].name)?;
        let (path, fields) = match &expr.kind {
            ExprKind::Path(path) => (path, [].as_slice()),
            ExprKind::With { base, fields } => (base, fields.as_slice()),
            _ => {
                self.sink.push(errors::unknown_planner(expr.span, "this", None, vocabulary));
                return None;
            }
        };
        let name = path_text(path);
        let Some(planner) = vocabulary.planners.iter().find(|planner| planner.name == name) else {
            let near = nearest(&name, vocabulary.planners.iter().map(|planner| planner.name));
            self.sink.push(errors::unknown_planner(path.span, &name, near, vocabulary));
            return None;
        };
        let owner = Owner { name: format!("planner `{name}`"), declared: None };
        let given: Vec<Given> = fields.iter().map(|field| Given { field, scope: scope.clone() }).collect();
        Some((Spanned::new(planner, path.span), self.read_fields(&owner, &given, planner.options)))
    }

    fn start(&mut self, step: &tree::Step, scope: &Scope, reading: &TaskReading) -> Option<Argument> {
        let [phrase] = step.phrases.as_slice() else {
            self.sink.push(errors::bad_start(step.span));
            return None;
        };
        if phrase.preposition.text != "at" || step.block.is_some() {
            self.sink.push(errors::bad_start(step.span));
            return None;
        }
        let wanted = WantedName { name: "`start at`".to_owned(), doc: String::new(), declared: None };
        let Some(state) = reading.vocabulary.state else {
            self.sink.push(errors::no_start(step.span, reading.vocabulary));
            return None;
        };
        let value = self.accept(state, &phrase.value, scope, &wanted)?;
        Some(self.argument_of(&phrase.value, value, scope))
    }

    /// The object of a setting that takes nothing else.
    fn only_object<'s>(&mut self, step: &'s tree::Step, example: &str) -> Option<&'s Expr> {
        let alone = step.phrases.is_empty() && step.block.is_none() && step.noun.is_none();
        match &step.object {
            Some(expr) if alone => Some(expr),
            _ => {
                self.sink.push(errors::bad_setting_form(step.span, &step.head.text, example));
                None
            }
        }
    }

    fn requirement(
        &mut self,
        step: &tree::Step,
        scope: &Scope,
        vocabulary: &'static Vocabulary,
    ) -> Option<Requirement> {
        let expr = self.only_object(step, "time <= 400 ms")?;
        let (outcome, relation, limit) = match &expr.kind {
            ExprKind::Binary { left, operator, right, .. } => {
                let names = (self.outcome_name(left, scope), self.outcome_name(right, scope));
                match (names, relation(*operator)) {
                    ((Some(name), _), Some(relation)) => (name, relation, right),
                    ((None, Some(name)), Some(relation)) => (name, mirrored(relation), left),
                    _ => return self.bad_requirement(expr, vocabulary),
                }
            }
            ExprKind::Error => return None,
            _ => return self.bad_requirement(expr, vocabulary),
        };
        let (name, span) = outcome;
        let Some(outcome) = vocabulary.outcomes.iter().find(|outcome| outcome.name == name) else {
            let near = nearest(name, vocabulary.outcomes.iter().map(|outcome| outcome.name));
            self.sink.push(errors::unknown_outcome(span, name, near, vocabulary));
            return None;
        };
        let sort = device::Sort::Quantity { dimension: outcome.unit.dimension(), range: device::Range::NotNegative };
        let wanted = WantedName { name: format!("the limit of `{name}`"), doc: outcome.doc.to_owned(), declared: None };
        let Value::Quantity(limit) = self.accept(sort, limit, scope, &wanted)? else { return None };
        Some(Requirement { outcome: name.to_owned(), relation, limit: limit.si, span: expr.span })
    }

    /// Required content of a droplet: a share of it, or a volume in droplets.
    fn content(&mut self, step: &tree::Step, sides: &ContentSides, scope: &Scope) -> Option<ContentRequirement> {
        let expr = self.only_object(step, "sample.dye == 1/8")?;
        let [part, share] = sides.path.segments.as_slice() else { return None };
        let name = |checker: &mut Self, segment: &tree::IndexedName| {
            let name = checker.joined(&segment.name.text, &segment.indices, scope)?;
            Some(Spanned::new(name, segment.name.span))
        };
        let (part, share) = (name(self, part)?, name(self, share)?);
        let sort = device::Sort::Quantity { dimension: Dimension::NUMBER, range: device::Range::NotNegative };
        let wanted = WantedName {
            name: format!("the limit of `{}.{}`", part.value, share.value),
            doc: "a share, as `1/8`, or a volume in droplets".to_owned(),
            declared: None,
        };
        let Value::Quantity(limit) = self.accept(sort, sides.limit, scope, &wanted)? else { return None };
        Some(ContentRequirement { part, share, relation: sides.relation, limit: limit.si, span: expr.span })
    }

    /// The outcome that a bare word means, unless it names a value.
    fn outcome_name<'e>(&self, expr: &'e Expr, scope: &Scope) -> Option<(&'e str, Span)> {
        let ExprKind::Path(path) = &expr.kind else { return None };
        let name = path.segments[0].name.text.as_str();
        let bare = path.segments.len() == 1 && path.segments[0].indices.is_empty();
        (bare && !self.names_value(path, scope)).then_some((name, path.span))
    }

    fn bad_requirement(&mut self, expr: &Expr, vocabulary: &'static Vocabulary) -> Option<Requirement> {
        self.sink.push(errors::bad_requirement(expr.span, vocabulary));
        None
    }

    fn step(&mut self, step: &tree::Step, scope: &Scope, reading: &mut TaskReading) -> Option<VocabularyAction> {
        match step.head.text.as_str() {
            "wait" | "prompt" if super::holds::is_hold(step) => self.hold(step, scope).map(|terms| reading.held(terms)),
            "wait" => self.wait(step, scope).map(VocabularyAction::Wait),
            "pulse" => self.pulse(step, scope).map(|(output, action)| reading.switched(output, action)),
            "set" => self.level(step, scope).map(|(output, action)| reading.switched(output, action)),
            "together" => self.goals_together(step, scope, reading).map(VocabularyAction::Together),
            "assay" => self.operations(step, scope, reading).map(VocabularyAction::Assay),
            "run" => {
                self.sink.push(errors::run_in_task(step.head.span, &reading.task.name.text));
                None
            }
            _ => self.verb(step, scope, reading.vocabulary).map(VocabularyAction::Verb),
        }
    }

    fn goals_together(&mut self, step: &tree::Step, scope: &Scope, reading: &TaskReading) -> Option<Vec<Call>> {
        if let Together::No(why) = reading.vocabulary.together {
            self.sink.push(errors::together_in_task(step.head.span, why));
            return None;
        }
        self.block_of_verbs(step, scope, reading.vocabulary)
    }

    fn operations(&mut self, step: &tree::Step, scope: &Scope, reading: &TaskReading) -> Option<Vec<Call>> {
        match reading.vocabulary.assay {
            Assay::Yes => self.block_of_verbs(step, scope, reading.vocabulary),
            Assay::No => {
                self.sink.push(errors::assay_of_other_kind(step.head.span, reading.vocabulary.name));
                None
            }
        }
    }

    /// The verbs in the braces of a `together` or an `assay`; `None` after an error.
    fn block_of_verbs(
        &mut self,
        step: &tree::Step,
        scope: &Scope,
        vocabulary: &'static Vocabulary,
    ) -> Option<Vec<Call>> {
        let alone = step.phrases.is_empty() && step.object.is_none() && step.noun.is_none();
        let mut calls = Vec::new();
        let block = step.block.as_ref().filter(|_| alone);
        let is_whole =
            block.is_none_or(|block| self.calls(block, &mut scope.clone(), &step.head, vocabulary, &mut calls));
        if is_whole && calls.is_empty() {
            self.sink.push(errors::bad_block_in_task(step));
            return None;
        }
        is_whole.then_some(calls)
    }

    /// Collects the verbs of a block; `false` if any was left out because of an error.
    fn calls(
        &mut self,
        entries: &[Entry],
        scope: &mut Scope,
        head: &Ident,
        vocabulary: &'static Vocabulary,
        calls: &mut Vec<Call>,
    ) -> bool {
        let mut is_whole = true;
        for entry in entries {
            is_whole &= match entry {
                Entry::Step(step) if is_no_goal(&step.head.text) => {
                    self.sink.push(errors::not_in_block(&step.head, head));
                    false
                }
                Entry::Step(step) => match self.verb(step, scope, vocabulary) {
                    Some(call) => {
                        calls.push(call);
                        true
                    }
                    None => false,
                },
                Entry::For(each) => {
                    let mut all = true;
                    self.repeat(each, scope, &mut |checker, scope| {
                        all &= checker.calls(&each.entries, scope, head, vocabulary, calls);
                    });
                    all
                }
                Entry::Field(field) => {
                    self.sink.push(errors::not_in_block(&field.name, head));
                    false
                }
                Entry::Error(_) => false,
            };
        }
        is_whole
    }

    /// The nanoseconds of `wait 10 ms`.
    pub fn wait(&mut self, step: &tree::Step, scope: &Scope) -> Option<u64> {
        if let ([phrase], None) = (step.phrases.as_slice(), &step.object)
            && phrase.preposition.text == "for"
        {
            self.sink.push(errors::wait_for(phrase.preposition.span, phrase.value.span));
            return None;
        }
        let expr = self.only_object(step, "10 ms")?;
        let sort = device::Sort::Quantity { dimension: Dimension::TIME, range: device::Range::NotNegative };
        let wanted = WantedName { name: "`wait`".to_owned(), doc: String::new(), declared: None };
        let Value::Quantity(time) = self.accept(sort, expr, scope, &wanted)? else { return None };
        super::clock_ns(time, expr.span, "`wait`", self.sink)
    }
}

/// Whether a word begins a step or a setting that is not a goal.
fn is_no_goal(word: &str) -> bool {
    word == "run" || STEP_WORDS.contains(&word) || device::condition_of_any_kind(word).is_some()
}

/// The sides of a `require` that compares what a droplet contains.
struct ContentSides<'e> {
    path: &'e tree::Path,
    relation: Relation,
    limit: &'e Expr,
}

/// The sides of `sample.dye == 1/8` or `1/8 == sample.dye`, for a device that has assays.
fn content_sides<'e>(step: &'e tree::Step, vocabulary: &Vocabulary) -> Option<ContentSides<'e>> {
    let Some(Expr { kind: ExprKind::Binary { left, operator, right, .. }, .. }) = &step.object else { return None };
    let relation = relation(*operator).filter(|_| vocabulary.assay == device::Assay::Yes)?;
    let of_two = |expr: &'e Expr| match &expr.kind {
        ExprKind::Path(path) if path.segments.len() == 2 => Some(path),
        _ => None,
    };
    match (of_two(left), of_two(right)) {
        (Some(path), _) => Some(ContentSides { path, relation, limit: right }),
        (None, Some(path)) => Some(ContentSides { path, relation: mirrored(relation), limit: left }),
        (None, None) => None,
    }
}

fn relation(operator: Operator) -> Option<Relation> {
    match operator {
        Operator::Less => Some(Relation::Less),
        Operator::LessEqual => Some(Relation::AtMost),
        Operator::Equal => Some(Relation::Equal),
        Operator::GreaterEqual => Some(Relation::AtLeast),
        Operator::Greater => Some(Relation::More),
        Operator::NotEqual
        | Operator::Add
        | Operator::Subtract
        | Operator::Multiply
        | Operator::Divide
        | Operator::Power => None,
    }
}

fn mirrored(relation: Relation) -> Relation {
    match relation {
        Relation::Less => Relation::More,
        Relation::AtMost => Relation::AtLeast,
        Relation::Equal => Relation::Equal,
        Relation::AtLeast => Relation::AtMost,
        Relation::More => Relation::Less,
    }
}
