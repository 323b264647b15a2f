//! Where the parts of each board stand when a step begins: goals are fixed, so all of that is known before planning.
//!
//! The runs of a schedule are walked in their order. A step is wrong if it needs a part that has merged away, or sends one too
//! near to a part that stays where it is, or that comes back there.

use super::cover::{Cover, Spread, nearest_cell};
use crate::check::claims::Job;
use crate::check::claims::electrode_array::{Action, Bystanders, ElectrodeArrayOrder, Move, Part, Stop};
use crate::check::errors;
use crate::device::electrode_array::Cell;
use crate::diagnostic::{Diagnostic, Sink};
use crate::source::Span;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Where parts stand between the tasks of a schedule, as far as that is known before planning.
pub fn places_agree(jobs: &[Job], sink: &mut Sink) {
    let mut boards: BTreeMap<&str, Board> = BTreeMap::new();
    let mut told: BTreeSet<Finding> = BTreeSet::new();
    for job in jobs {
        let Some(order) = job.order.electrode_array() else { continue };
        let board = boards.entry(&job.device).or_insert_with(|| Board::of(order));
        if !Arc::ptr_eq(&board.parts, &order.parts) {
            if let Some(name) = odd_part(&board.parts, &order.parts) {
                sink.push(errors::unlike_parts(job.run_span, &job.device, name));
                return;
            }
            board.reorder(&order.parts);
        }
        for step in &order.steps {
            match &step.action {
                Action::Wait(_) => {}
                Action::Move(moves) => {
                    let run = if job.run_span == job.span { step.span } else { job.run_span };
                    for diagnostic in board.advance(moves, order, &mut told) {
                        sink.push(diagnostic.label_elsewhere(run, step.span, "run here"));
                    }
                }
            }
        }
    }
}

/// What tells one finding from another, however often a task runs: a place in the source and a cell.
type Finding = (Span, Option<Cell>);

/// A part that only one of two scenes has.
fn odd_part<'p>(before: &'p [Part], now: &'p [Part]) -> Option<&'p str> {
    let names = |parts: &'p [Part]| -> BTreeSet<&'p str> { parts.iter().map(|part| part.name.as_str()).collect() };
    let (before, now) = (names(before), names(now));
    now.symmetric_difference(&before).next().copied()
}

/// Where a part is.
#[derive(Debug, Clone, Copy)]
enum Stand {
    /// There, since it was put or sent there.
    At(Cell, Span),
    /// It has merged with another.
    Merged(Span),
}

/// A board between two steps.
struct Board {
    parts: Arc<Vec<Part>>,
    /// One for each part.
    stands: Vec<Stand>,
    /// The parts that are still there, by index.
    spread: Spread<usize>,
}

impl Board {
    fn of(order: &ElectrodeArrayOrder) -> Board {
        let stands = order.parts.iter().map(|part| Stand::At(part.cell, part.span)).collect();
        let spread = Spread::new(order.facts.separation.apart());
        let mut board = Board { parts: Arc::clone(&order.parts), stands, spread };
        (0..board.stands.len()).for_each(|part| board.enter(part));
        board
    }

    fn enter(&mut self, part: usize) {
        if let Stand::At(cell, _) = self.stands[part] {
            self.spread.put(cell, part);
        }
    }

    fn leave(&mut self, part: usize) {
        if let Stand::At(cell, _) = self.stands[part] {
            self.spread.take(cell, |there| there == part);
        }
    }

    /// Takes over the order of another scene with parts of the same names.
    fn reorder(&mut self, parts: &Arc<Vec<Part>>) {
        let index: BTreeMap<&str, usize> =
            self.parts.iter().enumerate().map(|(index, part)| (part.name.as_str(), index)).collect();
        let before: Vec<Stand> = parts
            .iter()
            .map(|part| index.get(part.name.as_str()).map_or(Stand::At(part.cell, part.span), |at| self.stands[*at]))
            .collect();
        (0..self.stands.len()).for_each(|part| self.leave(part));
        self.stands = before;
        self.parts = Arc::clone(parts);
        (0..self.stands.len()).for_each(|part| self.enter(part));
    }

    /// Judges a step, and moves its parts to their goals; what was told is not said again.
    fn advance(
        &mut self,
        moves: &[Move],
        order: &ElectrodeArrayOrder,
        told: &mut BTreeSet<Finding>,
    ) -> Vec<Diagnostic> {
        let mut found = self.merged_before(moves, told);
        moves.iter().flat_map(of_move).for_each(|part| self.leave(part));
        for step in moves {
            let stops = match order.bystanders {
                Bystanders::Stay => step.stops.as_slice(),
                // They make way, and are back when the step ends.
                Bystanders::Yield => std::slice::from_ref(step.goal()),
            };
            let near = stops.iter().find_map(|stop| Some((stop, self.spread.near(stop.cell)?)));
            if let Some((stop, (_, other))) = near
                && told.insert((stop.span, Some(stop.cell)))
            {
                found.push(self.too_near((step, stop), other, moves, order));
            }
        }
        for step in moves {
            let goal = step.goal();
            self.stands[step.part] = Stand::At(goal.cell, goal.span);
            if let Some(with) = step.with {
                self.stands[with] = Stand::Merged(step.span);
            }
        }
        moves.iter().for_each(|step| self.enter(step.part));
        found
    }

    fn merged_before(&self, moves: &[Move], told: &mut BTreeSet<Finding>) -> Vec<Diagnostic> {
        let mut found = Vec::new();
        for step in moves {
            for part in of_move(step) {
                if let Stand::Merged(merged) = self.stands[part]
                    && told.insert((step.span, None))
                {
                    found.push(errors::merged_away(step.span, &self.parts[part].name, merged));
                }
            }
        }
        found
    }

    /// A stop too near to a part that stays, and the nearest cell that is not, nor too near to the goals of others.
    fn too_near(
        &self,
        (step, stop): (&Move, &Stop),
        other: usize,
        moves: &[Move],
        order: &ElectrodeArrayOrder,
    ) -> Diagnostic {
        let Stand::At(cell, since) = self.stands[other] else {
            return errors::merged_away(step.span, &self.parts[other].name, step.span);
        };
        let apart = order.facts.separation.apart();
        let cover = Cover::of(&order.obstacles, &order.facts);
        let goals = moves.iter().filter(|one| one.part != step.part).map(|one| one.goal().cell);
        let free = nearest_cell(stop.cell, &order.facts, |cell| {
            cover.covering(cell).is_none()
                && self.spread.near(cell).is_none()
                && goals.clone().all(|goal| goal.apart(cell) >= apart)
        });
        let moved = (self.parts[step.part].name.as_str(), stop.cell, stop.span);
        let stays = (self.parts[other].name.as_str(), cell, since);
        errors::near_standing_part(moved, stays, apart, free)
    }
}

/// The parts that a move takes from their cells.
fn of_move(step: &Move) -> impl Iterator<Item = usize> {
    [Some(step.part), step.with].into_iter().flatten()
}
