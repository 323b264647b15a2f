//! The channels of a schedule as functions of time.

use crate::schedule::{Actuation, Schedule};
use std::collections::BTreeSet;

/// The actuations of every channel, for looking up values.
pub struct Signals<'a> {
    pub schedule: &'a Schedule,
    by_channel: Vec<Vec<&'a Actuation>>,
}

impl<'a> Signals<'a> {
    /// Sorts the actuations of a schedule by their channels. One channel has at most one value at a time.
    pub fn new(schedule: &'a Schedule) -> Self {
        let mut by_channel = vec![Vec::new(); schedule.channels.len()];
        for actuation in &schedule.actuations {
            if let Some(list) = by_channel.get_mut(actuation.channel as usize) {
                list.push(actuation);
            }
        }
        by_channel.iter_mut().for_each(|list| list.sort_by_key(|actuation| actuation.start_ns));
        Signals { schedule, by_channel }
    }

    /// The actuations of a channel in order of time.
    pub fn of(&self, channel: usize) -> &[&'a Actuation] {
        &self.by_channel[channel]
    }

    /// The value at an instant; where it jumps, the new one.
    pub fn value(&self, channel: usize, t_ns: u64) -> f64 {
        let list = self.of(channel);
        let after = list.partition_point(|actuation| actuation.start_ns <= t_ns);
        match after.checked_sub(1).map(|last| list[last]) {
            Some(actuation) if t_ns < actuation.end_ns() => at(actuation, t_ns),
            Some(_) | None => 0.0,
        }
    }

    /// The value just before an instant.
    pub fn value_before(&self, channel: usize, t_ns: u64) -> f64 {
        let list = self.of(channel);
        let after = list.partition_point(|actuation| actuation.start_ns < t_ns);
        match after.checked_sub(1).map(|last| list[last]) {
            Some(actuation) if t_ns <= actuation.end_ns() => at(actuation, t_ns),
            Some(_) | None => 0.0,
        }
    }

    /// The instants at which one of these channels jumps or bends, in order.
    pub fn breaks(&self, channels: impl IntoIterator<Item = usize>) -> BTreeSet<u64> {
        let actuations = channels.into_iter().flat_map(|channel| self.of(channel));
        actuations.flat_map(|actuation| [actuation.start_ns, actuation.end_ns()]).collect()
    }

    /// The devices that have channels, with their channels' indices, in the order of the channels.
    pub fn devices(&self) -> Vec<(&'a str, Vec<usize>)> {
        let mut devices: indexmap::IndexMap<&str, Vec<usize>> = indexmap::IndexMap::new();
        for (index, channel) in self.schedule.channels.iter().enumerate() {
            devices.entry(&channel.device).or_default().push(index);
        }
        devices.into_iter().collect()
    }

    /// The first actuation that is not constant, where a format can only hold values.
    pub fn first_ramp(&self) -> Option<&'a Actuation> {
        self.schedule.actuations.iter().find(|actuation| actuation.from != actuation.to)
    }
}

fn at(actuation: &Actuation, t_ns: u64) -> f64 {
    if actuation.from == actuation.to {
        return actuation.from;
    }
    let part = (t_ns - actuation.start_ns) as f64 / actuation.duration_ns as f64;
    actuation.from + (actuation.to - actuation.from) * part
}
