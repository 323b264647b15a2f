//! States of a DiMiBot, and the places that its steps reach.

use super::reached::{Reached, Reaching};
use super::{KindState, State};
use crate::claims::dimibot::{Asked, DimibotAction, DimibotOrder, DimibotStop};
use crate::real::Real;
use serde::{Deserialize, Serialize};

/// Where a robot stands.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DimibotState {
    pub word: u64,
    pub cell: [u32; 2],
    /// Nominal place of the end-effector in the frame R1.
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
            let off_um = (reached_um[0] - asked_um[0]).hypotenuse(reached_um[1] - asked_um[1]);
            Some(Reached::Place { asked_um, reached_um, off_um })
        };
        stops.iter().filter_map(place).collect()
    }
}
