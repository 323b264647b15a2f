//! Positions of the parts of each board when a step begins. Goals are fixed, so all positions are known before
//! planning, except which member of a team stands on which of its goals.
//!
//! The runs of a schedule are walked in order. A step is wrong if it needs a part that has merged away, or if it sends
//! a part too near to one that stays where it is or returns there.

use super::cover::{ObstacleCells, SpacedPlaces, nearest_cell};
use super::errors;
use super::errors::Departure;
use super::liquids::{self, BoardLiquids};
use super::scene::distance_to;
use crate::claims::Job;
use crate::claims::electrode_array::{
    AssayOperation, BoardPart, Bystanders, ElectrodeArrayAction, ElectrodeArrayMove, ElectrodeArrayObstacle,
    ElectrodeArrayOrder, ElectrodeArrayStop, Fluids,
};
use crate::device::electrode_array::ElectrodeCell;
use crate::diagnostic::{Diagnostic, Sink};
use crate::source::Span;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;
use std::sync::Arc;

/// The parts of a board before a task, by part index of its order, as far as known before planning.
pub struct BoardBefore {
    /// Fluids that each part contains.
    pub fluids: Vec<Fluids>,
    /// Cell of each part, with the place in the program that put it there; `None` if the part is not on the board or
    /// the plan chooses its cell.
    pub positions: Vec<Option<(ElectrodeCell, Span)>>,
}

/// Checks positions between the tasks of a schedule; returns for each electrode-array job its index and its board
/// before it.
pub fn check_positions(jobs: &[Job], sink: &mut Sink) -> Vec<(usize, BoardBefore)> {
    let mut before = Vec::new();
    let mut boards: BTreeMap<&str, BoardWalk> = BTreeMap::new();
    let mut walk = PartsWalk { reported: BTreeSet::new(), covers: BTreeMap::new() };
    for (nth, job) in jobs.iter().enumerate() {
        let Some(order) = ElectrodeArrayOrder::of(&job.order) else { continue };
        let board = boards.entry(&job.device).or_insert_with(|| BoardWalk::of(order));
        if !Arc::ptr_eq(&board.parts, &order.parts) {
            if let Some(name) = odd_part(&board.parts, &order.parts) {
                sink.push(errors::unlike_parts(job.run_span, &job.device, name));
                return before;
            }
            board.reorder(&order.parts);
        }
        if !Arc::ptr_eq(&board.obstacles, &order.obstacles) {
            board.obstacles = Arc::clone(&order.obstacles);
            board.stands_clear(job, order, &mut walk).into_iter().for_each(|wrong| sink.push(wrong));
        }
        before.push((nth, board.before(order)));
        for step in &order.steps {
            let mut found = match &step.action {
                ElectrodeArrayAction::Wait(_) => continue,
                ElectrodeArrayAction::Move(moves) => board.advance(moves, None, order, &mut walk),
                ElectrodeArrayAction::Assay(operations) => board.operate(operations, order, &mut walk),
            };
            found.extend(board.fill(job, order, &step.action, &mut walk));
            let run = if job.run_span == job.span { step.span } else { job.run_span };
            found.into_iter().for_each(|wrong| sink.push(wrong.label_elsewhere(run, step.span, "run here")));
        }
        let others = board.liquids.judge(order).into_iter();
        others.filter(|(span, _)| walk.reported.insert((*span, None))).for_each(|(_, wrong)| sink.push(wrong));
    }
    before
}

/// State of the walk through the runs of a schedule.
struct PartsWalk {
    reported: BTreeSet<Finding>,
    /// Painted obstacles, by the address of the obstacle list.
    covers: BTreeMap<*const Vec<ElectrodeArrayObstacle>, Rc<ObstacleCells>>,
}

impl PartsWalk {
    fn cover(&mut self, order: &ElectrodeArrayOrder) -> Rc<ObstacleCells> {
        let painted = || Rc::new(ObstacleCells::of(&order.obstacles, &order.facts));
        Rc::clone(self.covers.entry(Arc::as_ptr(&order.obstacles)).or_insert_with(painted))
    }
}

/// Key under which a finding is reported once, however often its task runs: a place in the source and a cell.
type Finding = (Span, Option<ElectrodeCell>);

/// A part that only one of two scenes has.
fn odd_part<'p>(before: &'p [BoardPart], now: &'p [BoardPart]) -> Option<&'p str> {
    let names = |parts: &'p [BoardPart]| -> BTreeSet<&'p str> { parts.iter().map(|part| part.name.as_str()).collect() };
    let (before, now) = (names(before), names(now));
    now.symmetric_difference(&before).next().copied()
}

/// Position of a part.
#[derive(Debug, Clone, Copy)]
enum PartPosition {
    /// On this cell since the program put or sent it there.
    At(ElectrodeCell, Span),
    /// On one of the goals of its team, or of the cells among which the plan chooses; which one is not known.
    Somewhere(Span),
    /// Not yet dispensed.
    Due,
    /// Merged with another part, or left the board.
    Gone(Departure),
}

impl PartPosition {
    fn at_first(part: &BoardPart) -> PartPosition {
        part.cell.map_or(PartPosition::Due, |cell| PartPosition::At(cell, part.span))
    }
}

/// A board between two steps.
struct BoardWalk {
    parts: Arc<Vec<BoardPart>>,
    /// Obstacles of the scene of the last run; all parts are clear of them.
    obstacles: Arc<Vec<ElectrodeArrayObstacle>>,
    /// By part.
    positions: Vec<PartPosition>,
    liquids: BoardLiquids,
    /// The parts on known cells, by index.
    spread: SpacedPlaces<usize>,
    /// Teams whose members may stand on each other's cells: each entry has the parts on the goals of one team.
    teams: Vec<BTreeSet<usize>>,
}

impl BoardWalk {
    fn of(order: &ElectrodeArrayOrder) -> BoardWalk {
        let positions = order.parts.iter().map(PartPosition::at_first).collect();
        let spread = SpacedPlaces::new(order.facts.separation.apart());
        let (parts, obstacles) = (Arc::clone(&order.parts), Arc::clone(&order.obstacles));
        let mut liquids = BoardLiquids::default();
        liquids.put(&parts);
        let mut board = BoardWalk { parts, obstacles, positions, liquids, spread, teams: Vec::new() };
        (0..board.positions.len()).for_each(|part| board.occupy(part));
        board
    }

    /// The board as known before a task.
    fn before(&self, order: &ElectrodeArrayOrder) -> BoardBefore {
        let known = |position: &PartPosition| match *position {
            PartPosition::At(cell, since) => Some((cell, since)),
            PartPosition::Somewhere(_) | PartPosition::Due | PartPosition::Gone(_) => None,
        };
        BoardBefore { fluids: self.liquids.before(order), positions: self.positions.iter().map(known).collect() }
    }

    /// Name of a part in messages; for a member of a team, the name before its index.
    fn name_of(&self, part: usize) -> &str {
        let is_loose = self.teams.iter().any(|team| team.contains(&part));
        self.parts[part].family().filter(|_| is_loose).unwrap_or(&self.parts[part].name)
    }

    /// Takes the moved parts off their cells; the cells of the other members of their teams are then unknown.
    fn set_out(&mut self, moves: &[ElectrodeArrayMove]) {
        let moved: BTreeSet<usize> = moves.iter().flat_map(ElectrodeArrayMove::parts).collect();
        let mut lost: Vec<usize> = Vec::new();
        for team in &mut self.teams {
            if !team.is_disjoint(&moved) {
                lost.extend(team.difference(&moved));
                team.clear();
            }
        }
        self.teams.retain(|team| !team.is_empty());
        moved.iter().chain(&lost).for_each(|part| self.leave(*part));
        for part in lost {
            if let PartPosition::At(_, since) = self.positions[part] {
                self.positions[part] = PartPosition::Somewhere(since);
            }
        }
        let mut teams: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
        for (team, part) in moves.iter().filter_map(|one| Some((one.team?, one.part))) {
            teams.entry(team).or_default().insert(part);
        }
        self.teams.extend(teams.into_values());
    }

    fn occupy(&mut self, part: usize) {
        if let PartPosition::At(cell, _) = self.positions[part] {
            self.spread.put(cell, part);
        }
    }

    fn leave(&mut self, part: usize) {
        if let PartPosition::At(cell, _) = self.positions[part] {
            self.spread.take(cell, |there| there == part);
        }
    }

    /// Takes over the part order of another scene with parts of the same names.
    fn reorder(&mut self, parts: &Arc<Vec<BoardPart>>) {
        let index: BTreeMap<&str, usize> =
            self.parts.iter().enumerate().map(|(index, part)| (part.name.as_str(), index)).collect();
        let before: Vec<PartPosition> = parts
            .iter()
            .map(|part| index.get(part.name.as_str()).map_or(PartPosition::at_first(part), |at| self.positions[*at]))
            .collect();
        (0..self.positions.len()).for_each(|part| self.leave(part));
        let now: BTreeMap<&str, usize> = parts.iter().enumerate().map(|(at, part)| (part.name.as_str(), at)).collect();
        let renamed = |part: &usize| now.get(self.parts[*part].name.as_str()).copied();
        self.teams = self.teams.iter().map(|team| team.iter().filter_map(renamed).collect()).collect();
        self.positions = before;
        self.parts = Arc::clone(parts);
        self.liquids.put(parts);
        (0..self.positions.len()).for_each(|part| self.occupy(part));
    }

    /// Reports parts that stand too near to an obstacle when a scene with other obstacles begins.
    fn stands_clear(&self, job: &Job, order: &ElectrodeArrayOrder, walk: &mut PartsWalk) -> Vec<Diagnostic> {
        let cover = walk.cover(order);
        let mut found = Vec::new();
        for (part, position) in self.positions.iter().enumerate() {
            let PartPosition::At(cell, since) = *position else { continue };
            let Some(obstacle) = cover.covering(cell).map(|index| &order.obstacles[index]) else { continue };
            if walk.reported.insert((job.run_span, Some(cell))) {
                let (distance, apart) = distance_to(obstacle, cell, &order.facts);
                let place = errors::PartPlace { name: self.name_of(part), cell, span: since };
                let ElectrodeArrayObstacle { name, span, .. } = obstacle;
                found.push(errors::obstacle_comes_near(job.run_span, place, name, *span, distance, apart));
            }
        }
        found
    }

    /// Checks a step and moves its parts to their goals; each finding is reported once. In an assay, the parts in `on`
    /// do not come to rest at their last stop.
    fn advance(
        &mut self,
        moves: &[ElectrodeArrayMove],
        on: Option<&BTreeSet<usize>>,
        order: &ElectrodeArrayOrder,
        walk: &mut PartsWalk,
    ) -> Vec<Diagnostic> {
        let mut found = self.not_there(moves, &mut walk.reported);
        self.set_out(moves);
        for step in moves {
            let stops = match order.bystanders {
                Bystanders::Stay => step.stops.as_slice(),
                // Bystanders step aside, and are back when the step ends.
                Bystanders::Yield if on.is_some_and(|on| on.contains(&step.part)) => &[],
                Bystanders::Yield => std::slice::from_ref(step.goal()),
            };
            let near = stops.iter().find_map(|stop| Some((stop, self.spread.near(stop.cell)?)));
            if let Some((stop, (_, other))) = near
                && walk.reported.insert((stop.span, Some(stop.cell)))
            {
                let goals = moves.iter().filter(|one| one.part != step.part).map(|one| one.goal().cell);
                let goals: Vec<ElectrodeCell> = goals.collect();
                let free = self.nearest_free(stop.cell, &goals, order, &walk.cover(order));
                let wrong = self.too_near(step, stop, other, order, free, on.is_some());
                found.push(errors::given_from(wrong, stop.span, stop.origin.as_ref()));
            }
        }
        for step in moves {
            let goal = step.goal();
            self.positions[step.part] = PartPosition::At(goal.cell, goal.span);
            if let Some(with) = step.with {
                self.positions[with] = PartPosition::Gone(Departure::Merged(step.span));
            }
        }
        moves.iter().for_each(|step| self.occupy(step.part));
        found
    }

    /// Applies the merges and splits of a step to the liquids; each finding is reported once.
    fn fill(
        &mut self,
        job: &Job,
        order: &ElectrodeArrayOrder,
        action: &ElectrodeArrayAction,
        walk: &mut PartsWalk,
    ) -> Vec<Diagnostic> {
        let changes = liquids::changes(action).into_iter();
        let found: Vec<(Span, Diagnostic)> =
            changes.filter_map(|change| Some((change.span, self.liquids.change(job, order, &change)?))).collect();
        found.into_iter().filter(|(span, _)| walk.reported.insert((*span, None))).map(|(_, wrong)| wrong).collect()
    }

    /// Checks an assay as moves of its parts to all their stops, and moves the parts to their last ones.
    fn operate(
        &mut self,
        operations: &[AssayOperation],
        order: &ElectrodeArrayOrder,
        walk: &mut PartsWalk,
    ) -> Vec<Diagnostic> {
        let mut found = Vec::new();
        let mut moves: BTreeMap<usize, ElectrodeArrayMove> = BTreeMap::new();
        for operation in operations {
            if operation.comes {
                found.extend(self.comes(operation, &mut walk.reported));
            }
            for part in operation.parts() {
                if let PartPosition::Due = self.positions[part]
                    && walk.reported.insert((operation.span, None))
                {
                    found.push(errors::not_there_yet(operation.span, &self.parts[part]));
                }
                let fresh = || ElectrodeArrayMove::alone(part, Vec::new(), operation.span);
                let stops = operation.stops.iter().filter(|_| operation.among.is_empty());
                moves.entry(part).or_insert_with(fresh).stops.extend(stops.cloned());
            }
            if let Some(half) = operation.splits {
                found.extend(self.comes(operation, &mut walk.reported));
                let stops = vec![half.stop(operation)];
                moves.insert(half.part, ElectrodeArrayMove::alone(half.part, stops, operation.span));
            }
        }
        let chosen = operations.iter().filter(|operation| !operation.among.is_empty());
        let chosen: BTreeMap<usize, Span> =
            chosen.flat_map(|operation| operation.parts().map(|part| (part, operation.span))).collect();
        let still = moves.values().filter(|one| one.stops.is_empty()).map(|one| one.part);
        let (led, rests): (Vec<usize>, Vec<usize>) = still.partition(|part| chosen.contains_key(part));
        let mut moves: Vec<ElectrodeArrayMove> = moves.into_values().collect();
        found.extend(self.not_there(&moves, &mut walk.reported));
        if !found.is_empty() {
            return found;
        }
        for one in &mut moves {
            if let PartPosition::At(cell, span) = self.positions[one.part]
                && one.stops.is_empty()
                && !chosen.contains_key(&one.part)
            {
                one.stops.push(ElectrodeArrayStop { cell, span, origin: None });
            }
        }
        // Nothing can be judged about a part that stays on an unknown cell.
        moves.retain(|one| !one.stops.is_empty());
        found.extend(self.loops(operations, order, walk));
        self.mark_unknown(led.into_iter().map(|part| (part, chosen[&part])));
        let open = AssayOperation::left_open(operations);
        let gone = operations.iter().filter_map(AssayOperation::gone);
        let on = open.keys().copied().chain(gone).collect();
        found.extend(self.advance(&moves, Some(&on), order, walk));
        self.mark_unknown(open.into_iter().map(|(part, operation)| (part, operation.span)));
        for operation in operations {
            if let Some((part, departure)) = Departure::of(operation) {
                self.leave(part);
                self.positions[part] = PartPosition::Gone(departure);
            }
        }
        for part in rests {
            found.extend(self.rests_apart(part, order, walk));
        }
        found
    }

    /// Marks parts as standing where the plan chooses, each since an operation.
    fn mark_unknown(&mut self, parts: impl IntoIterator<Item = (usize, Span)>) {
        for (part, since) in parts {
            self.leave(part);
            self.positions[part] = PartPosition::Somewhere(since);
        }
    }

    /// Reports a part at rest if another part is too near to it at the end.
    fn rests_apart(&mut self, part: usize, order: &ElectrodeArrayOrder, walk: &mut PartsWalk) -> Option<Diagnostic> {
        let PartPosition::At(cell, since) = self.positions[part] else { return None };
        self.leave(part);
        let near = self.spread.near(cell);
        self.occupy(part);
        let (at, other) = near?;
        let PartPosition::At(_, span) = self.positions[other] else { return None };
        if !walk.reported.insert((span, Some(at))) {
            return None;
        }
        let free = self.nearest_free(at, &[], order, &walk.cover(order));
        let moved = errors::PartPlace { name: &self.parts[other].name, cell: at, span };
        let stays = errors::PartPlace { name: &self.parts[part].name, cell, span: since };
        Some(errors::near_standing_part(moved, stays, order.facts.separation.apart(), free, true))
    }

    /// Reports mixing loops that leave the board, or lie too near to an obstacle or to a part that stays.
    fn loops(
        &self,
        operations: &[AssayOperation],
        order: &ElectrodeArrayOrder,
        walk: &mut PartsWalk,
    ) -> Vec<Diagnostic> {
        // Cell of each part after its operations so far, `None` where the plan chooses; `positions` has the parts
        // that are not in the map.
        let mut here: BTreeMap<usize, Option<ElectrodeCell>> = BTreeMap::new();
        let mut found = Vec::new();
        for operation in operations {
            let part = operation.part;
            let at = operation.stops.last();
            if !operation.among.is_empty() {
                here.insert(part, None);
            } else if let Some(stop) = at {
                here.insert(part, Some(stop.cell));
            }
            if !operation.mixes {
                continue;
            }
            let name = self.parts[part].name.as_str();
            let mut wrong: Vec<(ElectrodeCell, Option<&ElectrodeArrayStop>, Diagnostic)> = Vec::new();
            for place in &operation.among {
                let stop = &place.stop;
                let blocked = blocked_loop(name, stop.span, stop.cell, order, &walk.cover(order));
                wrong.extend(blocked.map(|blocked| (stop.cell, Some(stop), blocked)));
            }
            let known = match self.positions[part] {
                PartPosition::At(cell, _) => Some(cell),
                PartPosition::Due | PartPosition::Somewhere(_) | PartPosition::Gone(_) => None,
            };
            if let Some(corner) = here.get(&part).copied().unwrap_or(known) {
                let span = at.map_or(operation.span, |stop| stop.span);
                let blocked = blocked_loop(name, span, corner, order, &walk.cover(order));
                let blocked = blocked.or_else(|| self.loop_near_part(name, span, corner, operations, order));
                wrong.extend(blocked.map(|blocked| (corner, at, blocked)));
            }
            for (corner, at, wrong) in wrong {
                if walk.reported.insert((at.map_or(operation.span, |stop| stop.span), Some(corner))) {
                    found.push(match at {
                        Some(stop) => errors::given_from(wrong, stop.span, stop.origin.as_ref()),
                        None => wrong,
                    });
                }
            }
        }
        found
    }

    /// Diagnostic for a part that stays too near to a mixing loop.
    fn loop_near_part(
        &self,
        name: &str,
        span: Span,
        corner: ElectrodeCell,
        operations: &[AssayOperation],
        order: &ElectrodeArrayOrder,
    ) -> Option<Diagnostic> {
        let stays = |other: &usize| {
            let is_moved = operations.iter().any(|own| own.all_parts().any(|part| part == *other));
            !is_moved && order.bystanders == Bystanders::Stay
        };
        let around = order.facts.mixing_loop(corner);
        let near = around.iter().find_map(|cell| self.spread.near(*cell).filter(|(_, other)| stays(other)));
        let (cell, other) = near?;
        let PartPosition::At(_, since) = self.positions[other] else { return None };
        let other = errors::PartPlace { name: &self.parts[other].name, cell, span: since };
        Some(errors::loop_near_part(name, span, corner, other, order.facts.separation.apart()))
    }

    /// Puts a dispensed or split-off droplet on the board; an error if it was there before.
    fn comes(&mut self, operation: &AssayOperation, reported: &mut BTreeSet<Finding>) -> Option<Diagnostic> {
        let (part, cell) = operation.new_part()?;
        let name = &self.parts[part].name;
        let wrong = match self.positions[part] {
            PartPosition::Due => {
                self.positions[part] = PartPosition::At(cell, operation.span);
                return None;
            }
            PartPosition::At(_, since) | PartPosition::Somewhere(since) => {
                errors::there_already(operation.span, name, since)
            }
            PartPosition::Gone(departure) => errors::gone_before(operation.span, name, departure),
        };
        reported.insert((operation.span, None)).then_some(wrong)
    }

    /// Reports moves of parts that are gone or not there yet.
    fn not_there(&self, moves: &[ElectrodeArrayMove], reported: &mut BTreeSet<Finding>) -> Vec<Diagnostic> {
        let mut found = Vec::new();
        for step in moves {
            for part in step.parts() {
                let name = &self.parts[part].name;
                let wrong = match self.positions[part] {
                    PartPosition::At(..) | PartPosition::Somewhere(_) => continue,
                    PartPosition::Due => errors::not_there_yet(step.span, &self.parts[part]),
                    PartPosition::Gone(departure) => errors::gone_before(step.span, name, departure),
                };
                if reported.insert((step.span, None)) {
                    found.push(wrong);
                }
            }
        }
        found
    }

    /// The nearest cell that no obstacle covers and that is not too near to a part that stays, nor to the goals.
    fn nearest_free(
        &self,
        to: ElectrodeCell,
        goals: &[ElectrodeCell],
        order: &ElectrodeArrayOrder,
        cover: &ObstacleCells,
    ) -> Option<ElectrodeCell> {
        let apart = order.facts.separation.apart();
        nearest_cell(to, &order.facts, |cell| {
            cover.covering(cell).is_none()
                && self.spread.near(cell).is_none()
                && goals.iter().all(|goal| goal.apart(cell) >= apart)
        })
    }

    /// Diagnostic for a stop too near to a part that stays; `free` is the nearest cell that is not.
    fn too_near(
        &self,
        step: &ElectrodeArrayMove,
        stop: &ElectrodeArrayStop,
        other: usize,
        order: &ElectrodeArrayOrder,
        free: Option<ElectrodeCell>,
        in_assay: bool,
    ) -> Diagnostic {
        let PartPosition::At(cell, since) = self.positions[other] else {
            return errors::gone_before(step.span, &self.parts[other].name, Departure::Merged(step.span));
        };
        let apart = order.facts.separation.apart();
        let moved = errors::PartPlace { name: self.name_of(step.part), cell: stop.cell, span: stop.span };
        let stays = errors::PartPlace { name: self.name_of(other), cell, span: since };
        errors::near_standing_part(moved, stays, apart, free, in_assay)
    }
}

/// Diagnostic for a mixing loop that leaves the board or that an obstacle covers.
fn blocked_loop(
    name: &str,
    span: Span,
    corner: ElectrodeCell,
    order: &ElectrodeArrayOrder,
    cover: &ObstacleCells,
) -> Option<Diagnostic> {
    let facts = &order.facts;
    let is_free = |cell: &ElectrodeCell| facts.reaches(*cell) && cover.covering(*cell).is_none();
    let cell = facts.mixing_loop(corner).into_iter().find(|cell| !is_free(cell))?;
    let free = nearest_cell(corner, facts, |cell| facts.mixing_loop(cell).iter().all(is_free));
    Some(errors::loop_blocked(name, span, corner, facts.mixer, cell, free))
}
