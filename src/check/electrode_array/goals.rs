//! Judges the steps of a task: which parts go where, as far as possible without knowing where the parts stand when a
//! step begins.

use super::cells::{on_board, whole_cell};
use super::cover::{SpacedPlaces, nearest_cell};
use super::default_expansions;
use super::errors;
use super::errors::Departure;
use super::scene::{BlockedCell, BoardScene, Outlet, on_obstacle};
use super::stay_steps::{StayExcess, StaySteps};
use crate::check::figures::Figures;
use crate::check::lets::Argument;
use crate::check::tasks::{self, ContentRequirement, Parts, TaskSite};
use crate::check::value::{ObjectName, Value};
use crate::check::verbs::Call;
use crate::check::{Checker, clock_ns};

use crate::claims::electrode_array::{
    AssayOperation, Bystanders, DropletContent, DropletShare, ElectrodeArrayAction, ElectrodeArrayMethod,
    ElectrodeArrayMove, ElectrodeArrayObjective, ElectrodeArrayOrder, ElectrodeArrayPlanner, ElectrodeArrayStep,
    ElectrodeArrayStop, OperationLag, SplitDroplet,
};
use crate::device::electrode_array::{
    BoardNoun, ElectrodeArrayFacts, ElectrodeArrayVerb, ElectrodeCell, Electrodes, Hold, SPLIT_APART, Separation,
};
use crate::diagnostic::{Code, Sink};
use crate::source::Span;
use std::collections::BTreeMap;
use std::sync::Arc;

impl Checker<'_> {
    /// The body of a task as an order for an electrode array; `None` after an error.
    pub fn electrode_array_order(
        &mut self,
        site: &TaskSite,
        facts: &ElectrodeArrayFacts,
        parts: Parts,
    ) -> Option<ElectrodeArrayOrder> {
        let board_scene = self.board_scene(site, facts);
        let objective = objective(parts.objective.as_ref().map(|objective| objective.value))?;
        let bystanders = bystanders(&parts);
        let planner = planner(&parts, objective, bystanders, facts, board_scene.parts.len(), self.sink);
        let scene = site.scene.as_ref().map(|(place, _)| self.named(*place).1);
        let hold = site.device.fields.get("hold").map(|field| field.span);
        let mut judge = BoardStepJudge {
            facts,
            board_scene: &board_scene,
            scene,
            device: &site.device.name,
            hold,
            sink: self.sink,
        };
        let steps: Vec<Option<ElectrodeArrayStep>> = parts.steps.iter().map(|step| judge.step(step)).collect();
        let steps: Option<Vec<ElectrodeArrayStep>> = steps.into_iter().collect();
        let contents = judge.contents(&parts.contents);
        let contamination = judge.contamination(&parts.conditions, &parts.steps);
        let order = ElectrodeArrayOrder {
            facts: facts.clone(),
            obstacles: Arc::clone(&board_scene.obstacles),
            parts: Arc::clone(&board_scene.parts),
            zones: Arc::clone(&board_scene.zones),
            objective,
            planner: planner?,
            bystanders,
            contents: contents?,
            contamination: contamination?,
            steps: steps?,
        };
        board_scene.is_whole.then_some(order)
    }
}

/// The objective that `minimize` names; the makespan by default.
fn objective(name: Option<&str>) -> Option<ElectrodeArrayObjective> {
    name.map_or(Some(ElectrodeArrayObjective::Makespan), ElectrodeArrayObjective::find)
}

fn bystanders(parts: &Parts) -> Bystanders {
    if parts.settings.is_set("may_yield") { Bystanders::Yield } else { Bystanders::Stay }
}

/// The method and budget of a task; `None` if the method lacks a feature that the task uses.
fn planner(
    parts: &Parts,
    objective: ElectrodeArrayObjective,
    bystanders: Bystanders,
    facts: &ElectrodeArrayFacts,
    count: usize,
    sink: &mut Sink,
) -> Option<ElectrodeArrayPlanner> {
    let asked_for = parts.planner.as_ref().map(|planner| planner.value.name);
    let method = asked_for.map_or(Some(ElectrodeArrayMethod::Portfolio), ElectrodeArrayMethod::find)?;
    if method == ElectrodeArrayMethod::Portfolio && facts.separation == Separation::AsPublished {
        let chosen = parts.planner.as_ref().map(|planner| planner.span);
        let span = chosen.or(parts.steps.first().map(|step| step.span));
        sink.push(errors::published_needs_published(span));
        return None;
    }
    let Some(planner) = &parts.planner else {
        return Some(ElectrodeArrayPlanner { method, expansions: default_expansions(facts, count) });
    };
    if method != ElectrodeArrayMethod::Portfolio
        && let Some((what, span)) = beyond_published(parts, objective, bystanders, planner.span)
    {
        let wrong = errors::planner_cannot(planner.span, planner.value.name, what, span);
        let both = "give the device `separation: 4` and leave `using` out: Tweeze's own planner does it".to_owned();
        sink.push(wrong.help_if((facts.separation == Separation::AsPublished).then_some(both)));
        return None;
    }
    Some(ElectrodeArrayPlanner { method, expansions: parts.expansions().unwrap_or(default_expansions(facts, count)) })
}

/// The first feature that the task uses and a published method lacks, and where it is used.
fn beyond_published(
    parts: &Parts,
    objective: ElectrodeArrayObjective,
    bystanders: Bystanders,
    chosen: Span,
) -> Option<(&'static str, Span)> {
    if objective == ElectrodeArrayObjective::SumOfCosts {
        return Some(("minimise `sum_of_costs`", chosen));
    }
    if bystanders == Bystanders::Yield {
        let span = parts.settings.get("may_yield").map_or(chosen, |setting| setting.span);
        return Some(("let parts step aside", span));
    }
    let assay = parts.steps.iter().find(|step| is_assay(&step.action)).map(|step| ("plan operations", step.span));
    assay.or_else(|| parts.steps.iter().flat_map(|step| calls(&step.action)).find_map(beyond_greed))
}

/// The first feature that a goal uses and a published method lacks, and where it is used.
fn beyond_greed(call: &Call) -> Option<(&'static str, Span)> {
    if verb(call) == Some(ElectrodeArrayVerb::Merge) {
        return Some(("merge", call.span));
    }
    if call.verb.noun.is_some() {
        return Some(("choose which part comes to which goal", call.span));
    }
    let via = call.phrases.iter().find(|(preposition, _)| *preposition == "via");
    via.map(|(_, via)| ("plan by way of a cell", via.span))
}

fn calls(action: &tasks::VocabularyAction) -> &[Call] {
    match action {
        tasks::VocabularyAction::Verb(call) => std::slice::from_ref(call),
        tasks::VocabularyAction::Together(calls) | tasks::VocabularyAction::Assay(calls) => calls,
        tasks::VocabularyAction::Wait(_) => &[],
    }
}

fn verb(call: &Call) -> Option<ElectrodeArrayVerb> {
    ElectrodeArrayVerb::find(call.verb.name)
}

/// Whether a step consists of operations rather than goals.
pub(super) fn is_assay(action: &tasks::VocabularyAction) -> bool {
    let is_operation = |call: &Call| verb(call).is_some_and(ElectrodeArrayVerb::is_operation);
    matches!(action, tasks::VocabularyAction::Assay(_)) || calls(action).iter().any(is_operation)
}

/// Judges the steps of one task.
pub(super) struct BoardStepJudge<'a> {
    pub facts: &'a ElectrodeArrayFacts,
    pub board_scene: &'a BoardScene,
    /// Where the task's scene is declared.
    pub scene: Option<Span>,
    /// Name of the device.
    pub(super) device: &'a str,
    /// The field that sets whether the device holds its parts, if given.
    hold: Option<Span>,
    pub sink: &'a mut Sink,
}

impl BoardStepJudge<'_> {
    /// Required contents of droplets, with names resolved in the scene.
    fn contents(&mut self, asked: &[ContentRequirement]) -> Option<Vec<DropletContent>> {
        let contents: Vec<Option<DropletContent>> = asked.iter().map(|asked| self.content(asked)).collect();
        contents.into_iter().collect()
    }

    fn content(&mut self, asked: &ContentRequirement) -> Option<DropletContent> {
        let ContentRequirement { part, share, relation, limit, span } = asked;
        let no_droplet = self.facts.layout.electrodes != Electrodes::Single;
        self.sink.push_if_some(no_droplet.then(|| errors::parts_contain_nothing(*span)))?;
        let object =
            Value::Object(ObjectName { noun: BoardNoun::Part.name(), name: part.value.clone(), word: part.span });
        let part = self.part(&Argument { value: object, span: part.span, origin: None })?;
        let fluids = self.board_scene.fluids();
        let share = match share.value.as_str() {
            "volume" => DropletShare::Volume,
            name if fluids.contains(name) => DropletShare::Fluid(name.to_owned()),
            name if self.board_scene.is_faulty_fluid(name) => return None,
            name => {
                let wrong = errors::unknown_fluid(Code::E0559, share.span, name, share.span, &fluids, self.scene);
                self.sink.push(wrong);
                return None;
            }
        };
        Some(DropletContent { part, share, relation: *relation, limit: *limit, span: *span })
    }

    fn step(&mut self, step: &tasks::VocabularyStep) -> Option<ElectrodeArrayStep> {
        let action = match &step.action {
            tasks::VocabularyAction::Wait(duration_ns) => ElectrodeArrayAction::Wait(*duration_ns),
            action if is_assay(action) => ElectrodeArrayAction::Assay(self.operations(action)?),
            action => ElectrodeArrayAction::Move(self.moves(calls(action))?),
        };
        Some(ElectrodeArrayStep { action, span: step.span })
    }

    /// Simultaneous goals: each part has one goal, and the goals keep the separation.
    fn moves(&mut self, calls: &[Call]) -> Option<Vec<ElectrodeArrayMove>> {
        self.nothing_after(calls)?;
        let open = calls.iter().flat_map(|call| phrases(call, "among")).next();
        self.sink.push_if_some(open.map(|open| errors::among_outside_assay(open.span)))?;
        let moves: Vec<Option<Vec<ElectrodeArrayMove>>> =
            calls.iter().enumerate().map(|(nth, call)| self.moves_of(call, nth)).collect();
        let each = calls.iter().zip(&moves);
        let found: Vec<(&Call, &ElectrodeArrayMove)> =
            each.flat_map(|(call, moves)| moves.iter().flatten().map(move |found| (call, found))).collect();
        let before = self.sink.errors();
        self.one_goal_each(&found);
        self.goals_apart(&found);
        (self.sink.errors() == before).then_some(())?;
        Some(moves.into_iter().collect::<Option<Vec<_>>>()?.concat())
    }

    /// The moves of the `nth` of several simultaneous calls: one move, or those of a team.
    fn moves_of(&mut self, call: &Call, nth: usize) -> Option<Vec<ElectrodeArrayMove>> {
        match call.verb.noun {
            Some(_) => self.team(call, nth),
            None => self.one_move(call).map(|one| vec![one]),
        }
    }

    /// The operations of a step: those of one part follow each other, and none needs a part that is already gone.
    fn operations(&mut self, action: &tasks::VocabularyAction) -> Option<Vec<AssayOperation>> {
        let calls = calls(action);
        let operations: Vec<Option<AssayOperation>> = calls.iter().map(|call| self.operation(call)).collect();
        let mut operations = operations.into_iter().collect::<Option<Vec<AssayOperation>>>()?;
        let before = self.sink.errors();
        match action {
            tasks::VocabularyAction::Assay(_) => self.follow(&mut operations, calls),
            tasks::VocabularyAction::Verb(_)
            | tasks::VocabularyAction::Together(_)
            | tasks::VocabularyAction::Wait(_) => self.nothing_after(calls)?,
        }
        let mut gone: BTreeMap<usize, Departure> = BTreeMap::new();
        let mut stays = StaySteps::default();
        for (operation, call) in operations.iter().zip(calls) {
            if let Some(StayExcess { part, steps }) = stays.add(operation, self.facts) {
                let time = phrases(call, "for").next();
                let span = time.map_or(call.span, |time| time.span);
                let part = part.map(|part| self.name(part));
                let wrong = errors::stays_too_long(span, part, steps, self.facts.step_ns);
                self.sink.push(match time {
                    Some(time) => errors::given_at(wrong, time),
                    None => wrong,
                });
                return None;
            }
            for part in operation.all_parts() {
                let wrong = gone.get(&part).map(|gone| match gone {
                    Departure::Merged(merged) if operation.comes => {
                        errors::dispensed_after_merging(operation.span, self.name(part), *merged)
                    }
                    Departure::Merged(_) | Departure::Left(_) => {
                        errors::gone_before(operation.span, self.name(part), *gone)
                    }
                });
                self.sink.push_if_some(wrong);
            }
            gone.extend(Departure::of(operation));
        }
        if let tasks::VocabularyAction::Together(_) = action {
            self.one_operation_each(&operations);
        }
        self.ends_apart(&operations, &gone);
        (self.sink.errors() == before).then_some(operations)
    }

    /// Resolves `after`: each operation of an assay follows the last preceding operation of each part that its `after`
    /// names.
    fn follow(&mut self, operations: &mut [AssayOperation], calls: &[Call]) {
        // By part, its last operation so far.
        let mut last: BTreeMap<usize, usize> = BTreeMap::new();
        for (place, call) in calls.iter().enumerate() {
            let mut before = Vec::new();
            for asked in phrases(call, "after") {
                let Some(part) = self.part(asked) else { continue };
                before.extend(last.get(&part).copied());
                match last.get(&part) {
                    // Operations of one part follow each other anyway.
                    Some(_) if operations[place].parts().any(|own| own == part) => {}
                    Some(earlier) => operations[place].after.push(*earlier),
                    None => {
                        let wrong = errors::nothing_to_come_after(asked.span, self.name(part));
                        asked.unless(Some(wrong), self.sink);
                    }
                }
            }
            if let Some(within) = phrases(call, "within").next() {
                let is_idle = phrases(call, "after").next().is_none();
                self.sink.push_if_some(is_idle.then(|| errors::within_of_nothing(within.span)));
                let most_ns = self.stay_ns(within, "`within`").filter(|_| !before.is_empty());
                operations[place].within =
                    most_ns.map(|most_ns| OperationLag { of: before, most_ns, span: within.span });
            }
            last.extend(operations[place].all_parts().map(|part| (part, place)));
        }
    }

    /// Reports `after` and `within` outside an assay, where each step follows the one before.
    fn nothing_after(&mut self, calls: &[Call]) -> Option<()> {
        let asked = calls.iter().flat_map(|call| phrases(call, "after").chain(phrases(call, "within"))).next();
        self.sink.push_if_some(asked.map(|asked| errors::after_outside_assay(asked.span)))
    }

    fn operation(&mut self, call: &Call) -> Option<AssayOperation> {
        self.sink.push_if_some(call.verb.noun.map(|_| errors::team_in_assay(call.span)))?;
        let verb = verb(call)?;
        if !verb.is_operation() {
            return self.passing(call);
        }
        let part = self.part(call.object.as_ref()?);
        if let Some(sort) = verb.zone() {
            return self.in_zone(call, part, sort);
        }
        if verb == ElectrodeArrayVerb::Dispense {
            return self.dispensed(call, part);
        }
        if verb == ElectrodeArrayVerb::Split {
            return self.split(call, part);
        }
        let places = self.places(call, None);
        let what = format!("`{}`", verb.name());
        let (leaves, mixes) = (verb == ElectrodeArrayVerb::Discard, verb == ElectrodeArrayVerb::Mix);
        let stay_ns = if leaves { Some(0) } else { self.stay_ns(phrases(call, "for").next()?, &what) };
        let places = places?;
        let no_droplet = mixes && self.facts.layout.electrodes != Electrodes::Single;
        self.sink.push_if_some(no_droplet.then(|| errors::parts_do_not_mix(call.span)))?;
        let passing = AssayOperation::passing(part?, Vec::new(), call.span);
        Some(AssayOperation { stay_ns: stay_ns?, mixes, leaves, ..Self::at_one_of(passing, places) })
    }

    /// A goal among operations: one part moves on, or two merge.
    fn passing(&mut self, call: &Call) -> Option<AssayOperation> {
        if phrases(call, "among").next().is_none() {
            let ElectrodeArrayMove { part, with, stops, span, .. } = self.one_move(call)?;
            return Some(AssayOperation { with, ..AssayOperation::passing(part, stops, span) });
        }
        let part = self.part(call.object.as_ref()?);
        let with = self.part(phrases(call, "with").next()?);
        let places = self.places(call, None);
        self.may_merge(call, part, with)?;
        let passing = AssayOperation { with: Some(with?), ..AssayOperation::passing(part?, Vec::new(), call.span) };
        Some(Self::at_one_of(passing, places?))
    }

    /// A split: pulls a droplet out of another, which moves in the opposite direction.
    fn split(&mut self, call: &Call, part: Option<usize>) -> Option<AssayOperation> {
        let other = phrases(call, "from").next()?;
        let from = self.part(other);
        let at = phrases(call, "at").next()?;
        let place = self.stop(at);
        let wrong = if self.facts.layout.electrodes != Electrodes::Single {
            Some(errors::parts_do_not_split(call.span))
        } else if self.facts.hold == Hold::Off {
            Some(errors::splits_without_hold(call.span, self.hold))
        } else if self.facts.separation.apart() > SPLIT_APART {
            Some(errors::halves_too_near(call.span, self.device, self.facts.separation.apart()))
        } else if part.is_some() && part == from {
            Some(errors::splits_from_itself(call.span, self.name(part?)))
        } else {
            None
        };
        self.sink.push_if_some(wrong)?;
        let place = place?;
        let centre = place.cell;
        let (to, to_span) = match phrases(call, "to").next() {
            Some(to) => (self.stop(to)?.cell, to.span),
            None => (ElectrodeCell::new(centre.column.saturating_add(1), centre.row), at.span),
        };
        let split = errors::SplitPlace { at: centre, span: call.span };
        if to.steps_to(centre) != 1 {
            self.sink.push(errors::comes_not_beside(split, to, to_span));
            return None;
        }
        let free = |[column, row]: [i64; 2]| {
            let pair = [i64::from(centre.column) + column, i64::from(centre.row) + row];
            let cell = on_board(pair, self.facts).filter(|cell| self.facts.reaches(*cell));
            cell.filter(|cell| self.board_scene.cover.covering(*cell).is_none()).ok_or(pair)
        };
        let side = [(to.column, centre.column), (to.row, centre.row)].map(|(to, at)| i64::from(to) - i64::from(at));
        let across =
            || free([side[1].abs(), side[0].abs()]).ok().filter(|_| free([-side[1].abs(), -side[0].abs()]).is_ok());
        let (comes, goes) = (free(side), free(side.map(|step| -step)));
        let (part, from) = (part?, from?);
        let wrong = match (comes, goes) {
            (Err(pair), _) => Some(errors::half_has_no_room(split, self.name(part), pair, across())),
            (_, Err(pair)) => Some(errors::half_has_no_room(split, self.name(from), pair, across())),
            (Ok(_), Ok(_)) => None,
        };
        self.sink.push_if_some(wrong)?;
        let stop = ElectrodeArrayStop { cell: goes.ok()?, span: at.span, origin: at.origin.clone() };
        let splits = Some(SplitDroplet { part, cell: to });
        Some(AssayOperation { splits, ..AssayOperation::passing(from, vec![place, stop], call.span) })
    }

    /// A droplet that a reservoir dispenses at its outlet, where the electrode holds it.
    fn dispensed(&mut self, call: &Call, part: Option<usize>) -> Option<AssayOperation> {
        let from = phrases(call, "from").next()?;
        let (fluid, cell, stay_ns) = self.dispensing(call, from)?;
        let stop = ElectrodeArrayStop { cell, span: from.span, origin: from.origin.clone() };
        let passing = AssayOperation::passing(part?, vec![stop], call.span);
        Some(AssayOperation { stay_ns, comes: true, fluid: Some(fluid), ..passing })
    }

    /// The reservoir that an argument names: its name, its outlet, and the time in which it dispenses a droplet, in
    /// nanoseconds.
    pub(super) fn dispensing(&mut self, call: &Call, from: &Argument) -> Option<(String, ElectrodeCell, u64)> {
        let outlet = self.board_scene.reservoirs.index(from, self.scene, self.board_scene.is_whole, self.sink);
        let wrong = if self.facts.layout.electrodes != Electrodes::Single {
            Some(errors::parts_are_not_dispensed(call.span))
        } else if self.facts.hold == Hold::Off {
            Some(errors::dispenses_without_hold(call.span, self.hold))
        } else if self.facts.dispense_ns.is_none() && self.facts.reservoirs.is_none() {
            Some(errors::dispenses_in_no_time(call.span, self.device))
        } else {
            None
        };
        self.sink.push_if_some(wrong)?;
        let Outlet { name, cell, .. } = self.board_scene.outlets.get(outlet?)?;
        Some((name.clone(), *cell, self.facts.dispense_ns_at(*cell)?))
    }

    pub(super) fn stay_ns(&mut self, time: &Argument, what: &str) -> Option<u64> {
        let Value::Quantity(quantity) = time.value else { return None };
        clock_ns(quantity, time.span, what, self.sink)
    }

    /// Reports a part that takes part in two simultaneous operations.
    fn one_operation_each(&mut self, operations: &[AssayOperation]) {
        let mut busy: BTreeMap<usize, Span> = BTreeMap::new();
        for operation in operations {
            for part in operation.all_parts() {
                let earlier = busy.insert(part, operation.span);
                let wrong = earlier.map(|earlier| errors::two_goals(self.name(part), operation.span, earlier));
                self.sink.push_if_some(wrong);
            }
        }
    }

    /// Reports last stops of the remaining parts that do not keep the separation.
    fn ends_apart(&mut self, operations: &[AssayOperation], gone: &BTreeMap<usize, Departure>) {
        let apart = self.facts.separation.apart();
        let mut ends: BTreeMap<usize, ElectrodeArrayStop> = BTreeMap::new();
        for operation in operations {
            if !operation.among.is_empty() {
                ends.remove(&operation.part);
                continue;
            }
            ends.extend(operation.stops.last().map(|stop| (operation.part, stop.clone())));
            let half = operation.splits.map(|half| (half.part, half.stop(operation)));
            ends.extend(half);
        }
        let mut spread: SpacedPlaces<usize> = SpacedPlaces::new(apart);
        for (part, stop) in ends.iter().filter(|(part, _)| !gone.contains_key(*part)) {
            let Some((cell, other)) = spread.near(stop.cell) else {
                spread.put(stop.cell, *part);
                continue;
            };
            let cover = &self.board_scene.cover;
            let free = nearest_cell(stop.cell, self.facts, |cell| {
                cover.covering(cell).is_none() && spread.near(cell).is_none()
            });
            let places = [
                errors::PartPlace { name: self.name(*part), cell: stop.cell, span: stop.span },
                errors::PartPlace { name: self.name(other), cell, span: ends[&other].span },
            ];
            let wrong = errors::ends_too_near(places, apart, free);
            self.sink.push(errors::given_from(wrong, stop.span, stop.origin.as_ref()));
        }
    }

    fn one_move(&mut self, call: &Call) -> Option<ElectrodeArrayMove> {
        let part = self.part(call.object.as_ref()?);
        let (with, stops) = if verb(call)? == ElectrodeArrayVerb::Merge {
            let other = phrases(call, "with").next()?;
            let with = self.part(other);
            let stop = self.stop(phrases(call, "at").next()?);
            self.may_merge(call, part, with)?;
            (Some(with?), vec![stop?])
        } else {
            let stops: Vec<Option<ElectrodeArrayStop>> =
                phrases(call, "via").chain(phrases(call, "to")).map(|target| self.stop(target)).collect();
            (None, stops.into_iter().collect::<Option<Vec<ElectrodeArrayStop>>>()?)
        };
        Some(ElectrodeArrayMove { with, ..ElectrodeArrayMove::alone(part?, stops, call.span) })
    }

    /// Reports a merge that is impossible: only two different droplets merge, and only where electrodes hold them.
    fn may_merge(&mut self, call: &Call, part: Option<usize>, with: Option<usize>) -> Option<()> {
        let wrong = if self.facts.layout.electrodes != Electrodes::Single {
            Some(errors::parts_do_not_merge(call.span))
        } else if self.facts.hold == Hold::Off {
            Some(errors::merges_without_hold(call.span, self.hold))
        } else if part.is_some() && part == with {
            Some(errors::merges_with_itself(call.span, self.name(part?)))
        } else {
            None
        };
        self.sink.push_if_some(wrong)
    }

    pub(super) fn name(&self, part: usize) -> &str {
        self.board_scene.parts.get(part).map_or("", |part| part.name.as_str())
    }

    /// Index of the part that an argument names; `None` after an error.
    fn part(&mut self, argument: &Argument) -> Option<usize> {
        self.board_scene.names.index(argument, self.scene, self.board_scene.is_whole, self.sink)
    }

    /// A cell that the centre of a part can take; `None` after an error.
    pub(super) fn stop(&mut self, target: &Argument) -> Option<ElectrodeArrayStop> {
        let Some(pair) = whole_cell(&target.value) else {
            target.unless(Some(errors::no_cell(target.span, &target.value)), self.sink);
            return None;
        };
        let cover = &self.board_scene.cover;
        let is_free = |cell| cover.covering(cell).is_none();
        let Some(cell) = on_board(pair, self.facts).filter(|cell| self.facts.reaches(*cell)) else {
            let clamped = ElectrodeCell::new(clamped(pair[0]), clamped(pair[1]));
            let free = nearest_cell(clamped, self.facts, is_free);
            let wrong = errors::goal_out_of_reach(target.span, pair, self.facts, free);
            target.unless(Some(wrong), self.sink);
            return None;
        };
        let wrong = cover.covering(cell).map(|index| {
            let place = BlockedCell { code: Code::E0502, cell, span: target.span };
            on_obstacle(&place, &self.board_scene.obstacles[index], self.facts, nearest_cell(cell, self.facts, is_free))
        });
        target.unless(wrong, self.sink)?;
        Some(ElectrodeArrayStop { cell, span: target.span, origin: target.origin.clone() })
    }

    fn one_goal_each(&mut self, moves: &[(&Call, &ElectrodeArrayMove)]) {
        let mut busy: BTreeMap<usize, Span> = BTreeMap::new();
        for (call, found) in moves {
            for part in found.parts() {
                let earlier = busy.insert(part, call.span);
                let wrong = earlier.map(|earlier| errors::two_goals(self.name(part), call.span, earlier));
                self.sink.push_if_some(wrong);
            }
        }
    }

    fn goals_apart(&mut self, moves: &[(&Call, &ElectrodeArrayMove)]) {
        let apart = self.facts.separation.apart();
        let mut spread: SpacedPlaces<usize> = SpacedPlaces::new(apart);
        for (index, (call, found)) in moves.iter().enumerate() {
            let goal = found.goal();
            let Some((cell, other)) = spread.near(goal.cell) else {
                spread.put(goal.cell, index);
                continue;
            };
            let (_, earlier) = moves[other];
            if earlier.part == found.part {
                continue;
            }
            let cover = &self.board_scene.cover;
            let free = nearest_cell(goal.cell, self.facts, |cell| {
                cover.covering(cell).is_none() && spread.near(cell).is_none()
            });
            let goals = [
                errors::PartPlace { name: self.mover(found), cell: goal.cell, span: goal.span },
                errors::PartPlace { name: self.mover(earlier), cell, span: earlier.goal().span },
            ];
            let is_one_team = found.team.is_some() && found.team == earlier.team;
            let wrong = match is_one_team {
                true => errors::team_goals_too_near(goals, apart, free),
                false => errors::goals_too_near(goals, apart, free),
            };
            let given = phrases(call, if found.with.is_some() { "at" } else { "to" }).next();
            self.sink.push(match given.filter(|_| found.team.is_none()) {
                Some(given) => errors::given_at(wrong, given),
                None => wrong,
            });
        }
    }
}

pub(super) fn phrases<'c>(call: &'c Call, preposition: &'c str) -> impl Iterator<Item = &'c Argument> {
    call.phrases.iter().filter(move |(name, _)| *name == preposition).map(|(_, argument)| argument)
}

fn clamped(number: i64) -> u32 {
    u32::try_from(number.max(1)).unwrap_or(u32::MAX)
}
