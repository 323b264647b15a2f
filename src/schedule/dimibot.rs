//! States of a DiMiBot, and the positions that its steps reach.

use super::cost::{Costed, count_of, proof, rounded};
use super::reached::{Reached, Reaching};
use super::{KindState, PlanRecord, State, TimedState};
use crate::claims::dimibot::{Asked, DimibotAction, DimibotOrder, DimibotStop};
use crate::device::dimibot::{DimibotObjective, DimibotOutcome, Side};
use crate::quantity::{count, digits};
use serde::{Deserialize, Serialize};

/// State of a robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DimibotState {
    pub word: u64,
    pub cell: [u32; 2],
    /// Nominal position of the end-effector in the frame R1.
    pub position_um: [f64; 2],
}

impl KindState for DimibotState {
    fn floats(&self) -> Vec<f64> {
        self.position_um.to_vec()
    }
}

impl Reaching for DimibotOrder {
    fn reached(&self, nth: usize, _end: &State) -> Vec<Reached> {
        let stops = match self.steps.get(nth).map(|step| &step.action) {
            Some(DimibotAction::Move(stops) | DimibotAction::Visit(stops)) => stops.as_slice(),
            Some(DimibotAction::Wait(_)) | None => &[],
        };
        let place = |stop: &DimibotStop| {
            let Asked::Place(asked_um) = stop.asked else { return None };
            let reached_um = self.in_scene_um(self.facts.place_um(stop.cell));
            Some(Reached::Place { asked_um, reached_um, off_um: self.off_um(stop)? })
        };
        stops.iter().filter_map(place).collect()
    }
}

impl Costed for DimibotOrder {
    /// `29.88 um (70 r) in 9 switches, optimal (bound 29.88 um)`; the distance in cells (r) only if cells are
    /// squares.
    fn cost(&self, plan: &PlanRecord) -> String {
        let figure = |value: f64| match plan.unit.as_str() {
            "" => digits(value),
            unit => format!("{} {unit}", rounded(value)),
        };
        let pitches = Side::BOTH.map(|side| self.facts.pitch_um(side));
        let switches = count(count_of(plan, DimibotOutcome::Switches.name()) as usize, "switch");
        let proof = proof(plan, figure);
        match self.objective {
            DimibotObjective::Distance if pitches[0] == pitches[1] => {
                format!("{} ({} r) in {switches}, {proof}", figure(plan.cost), (plan.cost / pitches[0]).round())
            }
            DimibotObjective::Switches => format!("{switches}, {proof}"),
            DimibotObjective::Distance | DimibotObjective::Time | DimibotObjective::Energy => {
                format!("{} in {switches}, {proof}", figure(plan.cost))
            }
        }
    }

    /// Number of modules switched in the interval.
    fn work_in(&self, plan: &PlanRecord, start_ns: u64, end_ns: u64) -> Option<String> {
        let words = plan.states.iter().filter_map(|TimedState { t_ns, state }| match state {
            State::Dimibot(DimibotState { word, .. }) => Some((*t_ns, *word)),
            State::ElectrodeArray(_) | State::Microrobots(_) | State::Fingers(_) => None,
        });
        let words: Vec<(u64, u64)> = words.collect();
        let within = words.windows(2).filter(|pair| (start_ns + 1..=end_ns).contains(&pair[1].0));
        let switched: u32 = within.map(|pair| (pair[0].1 ^ pair[1].1).count_ones()).sum();
        Some(count(switched as usize, "switch"))
    }
}
