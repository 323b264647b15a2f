//! Report of plans for DiMiBots.

use super::{Note, ReportTopic, ReportedDevice, ReportedOrder, ReportedRun};
use crate::claims::Claims;
use crate::claims::dimibot::{Asked, DimibotAction, DimibotOrder, DimibotStop};
use crate::device::dimibot::{DimibotFacts, LatticeCell, Side};
use crate::quantity::{Quantity, to_decimals};
use crate::schedule::dimibot::DimibotState;
use crate::schedule::{State, TimedState};
use std::ops::RangeInclusive;

impl ReportedOrder for DimibotOrder {
    /// The order in which each `visit` reaches its places, the distance of the cells taken for places from these places, and
    /// the time spent waiting for other robots.
    fn notes(&self, run: &ReportedRun) -> Vec<Note> {
        let visits = run.steps.iter().zip(&self.steps).filter_map(|(step, claim)| match &claim.action {
            DimibotAction::Visit(stops) => Some(visited(stops, &run.plan.states, step.start_ns..=step.end_ns())),
            DimibotAction::Move(_) | DimibotAction::Wait(_) => None,
        });
        let visits = visits.map(|line| (ReportTopic::Visits, line));
        let nearest = nearest(self).into_iter().map(|line| (ReportTopic::Nearest, line));
        visits.chain(nearest).chain(waits(run, self).map(|line| (ReportTopic::Waits, line))).collect()
    }
}

impl ReportedDevice for DimibotFacts {
    fn describe(&self, name: &str, _claims: &[Claims]) -> String {
        let [left, right] = Side::BOTH.map(|side| self.modules(side));
        let [left_um, right_um] = Side::BOTH.map(|side| super::length(self.pitch_um(side)));
        format!("{name}: dimibot, {left} modules of {left_um} left, {right} of {right_um} right\n")
    }
}

/// Note on the time that a robot waits for others: the duration of its steps other than waits of the task, without the
/// pulses and rests.
fn waits(run: &ReportedRun, order: &DimibotOrder) -> Option<String> {
    let moving =
        run.steps.iter().zip(&order.steps).filter(|(_, claim)| !matches!(claim.action, DimibotAction::Wait(_)));
    let lasts_ns: u64 = moving.map(|(step, _)| step.duration_ns).sum();
    // Every state but the first follows a pulse.
    let pulses = run.plan.states.len().saturating_sub(1) as u64;
    let idle_ns = lasts_ns.saturating_sub(pulses * (order.facts.pulse_duration_ns + order.facts.rest_ns));
    let idle = Quantity::time_ns(idle_ns);
    (idle_ns > 0).then(|| format!("`{}` waits {idle} to let others pass", run.plan.device))
}

/// The stops of a `visit`, in the order in which states of an interval first reach them.
fn visited(stops: &[DimibotStop], states: &[TimedState], during: RangeInclusive<u64>) -> String {
    // The state at the beginning of the interval may be older than it.
    let before = states.iter().rev().find(|state| state.t_ns <= *during.start());
    let within = states.iter().filter(|state| during.contains(&state.t_ns));
    let mut order: Vec<LatticeCell> = Vec::new();
    for state in before.into_iter().chain(within) {
        let State::Dimibot(DimibotState { cell: [x, y], .. }) = state.state else { continue };
        let cell = LatticeCell::new(x, y);
        if stops.iter().any(|stop| stop.cell == cell) && !order.contains(&cell) {
            order.push(cell);
        }
    }
    order.iter().map(LatticeCell::to_string).collect::<Vec<_>>().join(" → ")
}

fn nearest(order: &DimibotOrder) -> Vec<String> {
    let line = |stop: &DimibotStop| {
        let Asked::Place([x_um, y_um]) = stop.asked else { return None };
        Some(format!("({}, {}) is {}", length(x_um), length(y_um), order.taken_for(stop)?))
    };
    order.stops().filter_map(line).collect()
}

fn length(um: f64) -> String {
    let rounded = to_decimals(um, 4);
    Quantity::length_um(rounded).to_string()
}
