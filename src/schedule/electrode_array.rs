//! States of an electrode array. Its steps ask for cells, which are met or not.

use super::reached::{Reached, Reaching};
use super::{KindState, State};
use crate::claims::electrode_array::ElectrodeArrayOrder;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Where the parts of a board stand.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ElectrodeArrayState {
    /// Column and row of each part, both from 1, by its name; a part that has merged with another is gone.
    pub parts: BTreeMap<String, [u32; 2]>,
}

impl KindState for ElectrodeArrayState {
    fn floats(&self) -> Vec<f64> {
        Vec::new()
    }
}

impl Reaching for ElectrodeArrayOrder {
    fn reached(&self, _nth: usize, _end: &State) -> Vec<Reached> {
        Vec::new()
    }
}
