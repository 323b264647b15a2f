//! Motion of the parts of an electrode array, and the board, obstacles and goals of its tasks.
//!
//! One unit is one pitch of the board; electrode (1, 1) is the origin.

use crate::claims::Job;
use crate::claims::electrode_array::{
    BoardZone, ElectrodeArrayAction, ElectrodeArrayMove, ElectrodeArrayObstacle, ElectrodeArrayObstacleBody,
    ElectrodeArrayOrder, ElectrodeArrayStep, ElectrodeArrayStop,
};
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell};
use crate::emit::motion;
use crate::schedule::electrode_array::ElectrodeArrayState;
use crate::schedule::{PlanRecord, ScheduledStep, State};
use crate::verify::Verified;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Share of an electrode's square that an obstacle on it fills.
const OBSTACLE_PART: f64 = 0.9;

/// The middle of an electrode in a picture.
pub fn place(cell: ElectrodeCell) -> [f64; 2] {
    [f64::from(cell.column) - 1.0, f64::from(cell.row) - 1.0]
}

/// The cells of the parts of a board, from an instant on.
pub struct PartsMoment {
    pub t_ns: u64,
    pub parts: BTreeMap<String, ElectrodeCell>,
    /// Last cell of each part that is gone from that instant on.
    pub gone: BTreeMap<String, ElectrodeCell>,
}

impl PartsMoment {
    /// The cell of a part, or its last cell if it is gone.
    pub fn cell(&self, part: &str) -> Option<ElectrodeCell> {
        self.parts.get(part).or(self.gone.get(part)).copied()
    }
}

/// The orders of a board's runs with their plans, in order of time; operations are at the places that the plan has
/// chosen.
pub fn runs<'a>(verified: &'a Verified, device: &str) -> Vec<(Cow<'a, ElectrodeArrayOrder>, &'a PlanRecord)> {
    let schedule = verified.schedule();
    let placed = |(job, plan): (&'a Job, &'a PlanRecord)| {
        let order = ElectrodeArrayOrder::of(&job.order)?;
        let own =
            |step: &&ScheduledStep| schedule.plans.get(step.plan as usize).is_some_and(|own| std::ptr::eq(own, plan));
        Some((at_chosen_places(order, schedule.steps.iter().filter(own)), plan))
    };
    motion::jobs(verified, device).into_iter().filter_map(placed).collect()
}

/// An order with its operations at the places that its plan has chosen; `steps` are those of the plan.
pub fn at_chosen_places<'o, 's>(
    order: &'o ElectrodeArrayOrder,
    steps: impl Iterator<Item = &'s ScheduledStep>,
) -> Cow<'o, ElectrodeArrayOrder> {
    let mut placed = Cow::Borrowed(order);
    for (nth, step) in steps.enumerate() {
        for (place, on) in step.operations.iter().enumerate() {
            let asked = order.steps.get(nth).map(|step| &step.action);
            let (Some(cell), Some(ElectrodeArrayAction::Assay(all))) = (on.at, asked) else { continue };
            let Some(chosen) = all.get(place).and_then(|one| one.at_cell(cell)) else { continue };
            if let ElectrodeArrayAction::Assay(all) = &mut placed.to_mut().steps[nth].action {
                all[place] = chosen;
            }
        }
    }
    placed
}

/// The cells where parts merge with others or leave the board.
fn departures(order: &ElectrodeArrayOrder) -> BTreeMap<&str, ElectrodeCell> {
    let of_step = |step: &ElectrodeArrayStep| -> Vec<(usize, Option<ElectrodeCell>)> {
        let last = |stops: &[ElectrodeArrayStop]| stops.last().map(|stop| stop.cell);
        match &step.action {
            ElectrodeArrayAction::Move(moves) => {
                moves.iter().filter_map(|one| Some((one.with?, last(&one.stops)))).collect()
            }
            ElectrodeArrayAction::Assay(all) => {
                all.iter().filter_map(|one| Some((one.gone()?, last(&one.stops)))).collect()
            }
            ElectrodeArrayAction::Wait(_) => Vec::new(),
        }
    };
    let named = |(part, cell): (usize, Option<ElectrodeCell>)| Some((order.parts.get(part)?.name.as_str(), cell?));
    order.steps.iter().flat_map(of_step).filter_map(named).collect()
}

/// Every position of every part: the states of all plans, and before each step of the board the old positions once
/// more, so that a part that rests between steps is not drawn as if it crept.
pub fn moments(verified: &Verified, device: &str) -> Vec<PartsMoment> {
    let mut moments: Vec<PartsMoment> = Vec::new();
    for (order, plan) in runs(verified, device) {
        let departures = departures(&order);
        for timed in &plan.states {
            let State::ElectrodeArray(ElectrodeArrayState { parts }) = &timed.state else { continue };
            let parts: BTreeMap<String, ElectrodeCell> =
                parts.iter().map(|(name, [column, row])| (name.to_owned(), ElectrodeCell::new(column, row))).collect();
            let begins_ns = timed.t_ns.saturating_sub(order.facts.step_ns);
            let Some(last) = moments.last() else {
                moments.push(PartsMoment { t_ns: 0, parts, gone: BTreeMap::new() });
                continue;
            };
            if last.parts == parts {
                continue;
            }
            let left = last.parts.keys().filter(|part| !parts.contains_key(*part));
            let gone = left.filter_map(|part| Some((part.clone(), *departures.get(part.as_str())?))).collect();
            if last.t_ns < begins_ns {
                let parts = last.parts.clone();
                moments.push(PartsMoment { t_ns: begins_ns, parts, gone: BTreeMap::new() });
            }
            moments.push(PartsMoment { t_ns: timed.t_ns, parts, gone });
        }
    }
    moments
}

/// The lower and the upper corner of the board, half a pitch outside its electrodes.
pub fn outline(facts: &ElectrodeArrayFacts) -> [[f64; 2]; 2] {
    let [x, y] = place(ElectrodeCell::new(facts.columns, facts.rows));
    [[-0.5, -0.5], [x + 0.5, y + 0.5]]
}

/// The corners of an obstacle's body.
pub fn body(facts: &ElectrodeArrayFacts, obstacle: &ElectrodeArrayObstacle) -> [[f64; 2]; 2] {
    let half = OBSTACLE_PART / 2.0;
    let (low, high, half) = match obstacle.body {
        ElectrodeArrayObstacleBody::Electrodes { from, to } => (place(from), place(to), half),
        ElectrodeArrayObstacleBody::Fixed(cell) => (place(cell), place(cell), facts.layout.half_width_pitches),
    };
    [low.map(|value| value - half), high.map(|value| value + half)]
}

/// The corners of a heater, a detector or a magnet: the whole squares of its electrodes.
pub fn zone_body(zone: &BoardZone) -> [[f64; 2]; 2] {
    let (low, high) = (place(zone.from), place(zone.to));
    [low.map(|value| value - 0.5), high.map(|value| value + 0.5)]
}

/// The goals of every step of a task: the part's index, or `None` if any of several parts may take the goal, and the
/// cell.
pub fn goal_cells(order: &ElectrodeArrayOrder) -> impl Iterator<Item = (Option<usize>, ElectrodeCell)> + '_ {
    let stops = |part: Option<usize>, stops: &[ElectrodeArrayStop]| -> Vec<(Option<usize>, ElectrodeCell)> {
        stops.iter().map(|stop| (part, stop.cell)).collect()
    };
    let of_move = move |one: &ElectrodeArrayMove| stops(Some(one.part).filter(|_| one.team.is_none()), &one.stops);
    order.steps.iter().flat_map(move |step| match &step.action {
        ElectrodeArrayAction::Move(moves) => moves.iter().flat_map(of_move).collect(),
        ElectrodeArrayAction::Assay(all) => all.iter().flat_map(|one| stops(Some(one.part), &one.stops)).collect(),
        ElectrodeArrayAction::Wait(_) => Vec::new(),
    })
}
