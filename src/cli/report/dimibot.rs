//! Report on a DiMiBot's plan.

use super::{Note, ReportTopic, ReportedRun, count, figure_of, proof, rounded};
use crate::claims::dimibot::{Asked, DimibotAction, DimibotOrder, DimibotStop};
use crate::device::dimibot::{DimibotObjective, DimibotOutcome, LatticeCell, Side};
use crate::quantity::{Dimension, Quantity, digits};
use crate::real::Real;
use crate::schedule::{PlanRecord, State, TimedState};
use std::ops::RangeInclusive;

/// `29.88 um (70 r) in 9 switches, optimal (bound 29.88 um)`; in cells only where they are squares.
pub fn cost(plan: &PlanRecord, order: &DimibotOrder) -> String {
    let figure = |value: f64| match plan.unit.as_str() {
        "" => digits(value),
        unit => format!("{} {unit}", rounded(value)),
    };
    let pitches = Side::BOTH.map(|side| order.facts.pitch_um(side));
    let switches = count(figure_of(plan, DimibotOutcome::Switches.name()) as usize, "switch");
    let proof = proof(plan, figure);
    match order.objective {
        DimibotObjective::Distance if pitches[0] == pitches[1] => {
            format!("{} ({} r) in {switches}, {proof}", figure(plan.cost), (plan.cost / pitches[0]).round())
        }
        DimibotObjective::Switches => format!("{switches}, {proof}"),
        DimibotObjective::Distance | DimibotObjective::Time | DimibotObjective::Energy => {
            format!("{} in {switches}, {proof}", figure(plan.cost))
        }
    }
}

/// The order in which each `visit` reaches its places, and the distance between places and the cells that replace them.
pub fn notes(run: &ReportedRun, order: &DimibotOrder) -> Vec<Note> {
    let visits = run.steps.iter().zip(&order.steps).filter_map(|(step, claim)| match &claim.action {
        DimibotAction::Visit(stops) => {
            Some(visited(stops, &run.plan.states, step.start_ns..=step.start_ns + step.duration_ns))
        }
        DimibotAction::Move(_) | DimibotAction::Wait(_) => None,
    });
    let visits = visits.map(|line| (ReportTopic::Visits, line));
    let nearest = nearest(order).into_iter().map(|line| (ReportTopic::Nearest, line));
    visits.chain(nearest).chain(waits(run, order).map(|line| (ReportTopic::Waits, line))).collect()
}

/// Time that a robot waits for others: neither pulse nor rest nor a wait of the task.
fn waits(run: &ReportedRun, order: &DimibotOrder) -> Option<String> {
    let moving =
        run.steps.iter().zip(&order.steps).filter(|(_, claim)| !matches!(claim.action, DimibotAction::Wait(_)));
    let lasts_ns: u64 = moving.map(|(step, _)| step.duration_ns).sum();
    // Every state but the first follows a pulse.
    let pulses = run.plan.states.len().saturating_sub(1) as u64;
    let idle_ns = lasts_ns.saturating_sub(pulses * (order.facts.pulse_duration_ns + order.facts.rest_ns));
    let idle = Quantity::new(idle_ns as f64 / 1e9, Dimension::TIME);
    (idle_ns > 0).then(|| format!("`{}` waits {idle} to let others pass", run.plan.device))
}

/// The stops in the order in which states of a stretch of time first stand at them.
fn visited(stops: &[DimibotStop], states: &[TimedState], during: RangeInclusive<u64>) -> String {
    // The state in which the stretch begins may be older than it.
    let before = states.iter().rev().find(|state| state.t_ns <= *during.start());
    let within = states.iter().filter(|state| during.contains(&state.t_ns));
    let mut order: Vec<LatticeCell> = Vec::new();
    for state in before.into_iter().chain(within) {
        let State::Dimibot { cell: [x, y], .. } = state.state else { continue };
        let cell = LatticeCell::new(x, y);
        if stops.iter().any(|stop| stop.cell == cell) && !order.contains(&cell) {
            order.push(cell);
        }
    }
    order.iter().map(LatticeCell::to_string).collect::<Vec<_>>().join(" → ")
}

fn nearest(order: &DimibotOrder) -> Vec<String> {
    let stops = order.steps.iter().flat_map(|step| match &step.action {
        DimibotAction::Move(stops) | DimibotAction::Visit(stops) => stops.as_slice(),
        DimibotAction::Wait(_) => &[],
    });
    let line = |stop: &DimibotStop| {
        let Asked::Place([x_um, y_um]) = stop.asked else { return None };
        let [cell_x_um, cell_y_um] = order.in_scene_um(order.facts.place_um(stop.cell));
        let off = length((cell_x_um - x_um).hypotenuse(cell_y_um - y_um));
        Some(format!("({}, {}) is cell {}, {off} off", length(x_um), length(y_um), stop.cell))
    };
    stops.filter_map(line).collect()
}

fn length(um: f64) -> String {
    let rounded = (um * 1e4).round() / 1e4;
    Quantity::new(rounded / 1e6, Dimension::LENGTH).to_string()
}
