//! What the relays of a table allow, and what is said where they do not.

use super::table::Table;
use crate::check::devices::Device;
use crate::device::microrobots::{Arm, ControlState, Facts};
use crate::diagnostic::Sink;

/// The control states of a bed; `None` after an error.
pub fn states(facts: &Facts, _table: &Table, _device: &Device, _sink: &mut Sink) -> Option<Vec<ControlState>> {
    let mut order: Vec<usize> = (0..facts.robots.len()).collect();
    order.sort_by(|a, b| {
        let key = |row: usize| (facts.robots[row].snap_down_v, facts.robots[row].release_v);
        key(*a).partial_cmp(&key(*b)).unwrap()
    });
    let states = (0..=order.len()).map(|down| {
        let mut arms = vec![Arm::Up; order.len()];
        order[..down].iter().for_each(|row| arms[*row] = Arm::Down);
        ControlState { arms, levels_v: vec![0.0], slack_v: 1.0 }
    });
    Some(states.collect())
}
