//! Motion of a DiMiBot's end-effector, and the lattice, stops and obstacles of its tasks.

use crate::claims::dimibot::{DimibotAction, DimibotOrder, DimibotStop};
use crate::device::dimibot::{DimibotFacts, LatticeCell, Side};
use crate::emit::Signals;
use crate::emit::motion::{self, plans};
use crate::schedule::dimibot::DimibotState;
use crate::schedule::{PlanRecord, State, TimedState};
use crate::verify::Verified;
use std::collections::BTreeSet;

/// Share of a cell that a blocked cell fills, so that neighbouring blocked cells can be told apart.
const CELL_PART: f64 = 0.8;

/// Position of the end-effector in a state.
pub fn place(state: &TimedState) -> [f64; 3] {
    match &state.state {
        State::Dimibot(DimibotState { position_um: [x, y], .. }) => [*x, *y, 0.0],
        State::ElectrodeArray(_) | State::Microrobots(_) | State::Fingers(_) => {
            unreachable!("the verifier holds states against the kind of their device")
        }
    }
}

/// Poses of the end-effector of a device over time: each new pose at the instant of its state, and the old one at the
/// start of the pulse that leads there. Before its first task it stands where that begins.
pub fn poses(verified: &Verified, signals: &Signals, device: &str) -> Vec<(u64, [f64; 3])> {
    let channels = &signals.schedule.channels;
    let of_device = |channel: u32| channels.get(channel as usize).is_some_and(|channel| channel.device == device);
    let actuations = signals.schedule.actuations.iter().filter(|actuation| of_device(actuation.channel));
    let starts: BTreeSet<u64> = actuations.map(|actuation| actuation.start_ns).collect();
    let mut poses: Vec<(u64, [f64; 3])> = Vec::new();
    for state in plans(verified, device).iter().flat_map(|plan| &plan.states) {
        if poses.is_empty() {
            poses.push((0, place(state)));
        }
        if let Some(&(last_ns, old)) = poses.last() {
            let start_ns = starts.range(..state.t_ns).next_back().copied();
            if let Some(start_ns) = start_ns.filter(|start_ns| *start_ns > last_ns) {
                poses.push((start_ns, old));
            }
        }
        if poses.last() != Some(&(state.t_ns, place(state))) {
            poses.push((state.t_ns, place(state)));
        }
    }
    poses
}

/// The cell of all modules at 1.
pub fn last_cell(facts: &DimibotFacts) -> LatticeCell {
    LatticeCell { x: facts.cells(Side::Left) - 1, y: facts.cells(Side::Right) - 1 }
}

pub fn extent_um(facts: &DimibotFacts) -> [f64; 2] {
    facts.place_um(last_cell(facts))
}

/// The goal cells of a task, each once, in source order.
pub fn stops(order: &DimibotOrder) -> Vec<LatticeCell> {
    let all = order.steps.iter().flat_map(|step| match &step.action {
        DimibotAction::Move(stops) | DimibotAction::Visit(stops) => stops.as_slice(),
        DimibotAction::Wait(_) => &[],
    });
    let mut met = BTreeSet::new();
    all.map(|stop: &DimibotStop| stop.cell).filter(|cell| met.insert(cell.pair())).collect()
}

/// The lower and the upper corner of a block of cells, each cell being a tile.
pub fn tiles_um(facts: &DimibotFacts, from: LatticeCell, to: LatticeCell) -> ([f64; 2], [f64; 2]) {
    let half = [Side::Left, Side::Right].map(|side| facts.pitch_um(side) * CELL_PART / 2.0);
    let ([x0, y0], [x1, y1]) = (facts.place_um(from), facts.place_um(to));
    ([x0 - half[0], y0 - half[1]], [x1 + half[0], y1 + half[1]])
}

/// The orders of a device with their plans, in order of time.
pub fn jobs<'a>(verified: &'a Verified, device: &str) -> Vec<(&'a DimibotOrder, &'a PlanRecord)> {
    let jobs = motion::jobs(verified, device).into_iter();
    jobs.filter_map(|(job, plan)| Some((DimibotOrder::of(&job.order)?, plan))).collect()
}

/// The sceneries of a device, each with the instant from which it holds; the first holds from the beginning.
pub fn sceneries<'a>(verified: &'a Verified, device: &str) -> Vec<(u64, &'a DimibotOrder)> {
    let mut sceneries: Vec<(u64, &DimibotOrder)> = Vec::new();
    for (order, plan) in jobs(verified, device) {
        match sceneries.last() {
            None => sceneries.push((0, order)),
            Some((_, last)) if last.obstacles == order.obstacles && last.facts == order.facts => {}
            Some(_) => sceneries.push((plan.start_ns, order)),
        }
    }
    sceneries
}
