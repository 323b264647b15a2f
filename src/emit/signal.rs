//! The channels of a schedule as functions of time.
//!
//! A swing is one actuation, however long it is. Its ends are [`Signals::breaks`]; what happens between them is only counted, or
//! told one instant after the other by [`Edges`], for the formats that cannot say it in one go.

use crate::schedule::{Actuation, Schedule, Swing};
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

    /// The swings of a channel with their actuations, in order of time.
    pub fn swings(&self, channel: usize) -> impl Iterator<Item = (&'a Actuation, Swing)> {
        self.of(channel).iter().filter_map(|actuation| Some((*actuation, actuation.swing?)))
    }

    /// The value at an instant; where it jumps, the new one.
    pub fn value(&self, channel: usize, t_ns: u64) -> f64 {
        self.during(channel, t_ns).map_or(0.0, |actuation| at(actuation, t_ns))
    }

    /// The value just before an instant.
    pub fn value_before(&self, channel: usize, t_ns: u64) -> f64 {
        self.until(channel, t_ns).map_or(0.0, |actuation| match actuation.swing {
            // Levels hold for whole nanoseconds, so the one before is that of the nanosecond before.
            Some(_) => at(actuation, t_ns - 1),
            None => at(actuation, t_ns),
        })
    }

    /// The lowest and the highest value that a channel takes about an instant: the levels of a swing, else twice the value.
    pub fn envelope(&self, channel: usize, t_ns: u64) -> [f64; 2] {
        match self.during(channel, t_ns) {
            Some(Actuation { swing: Some(Swing { levels: [a, b], .. }), .. }) => [a.min(*b), a.max(*b)],
            Some(actuation) => [at(actuation, t_ns); 2],
            None => [0.0; 2],
        }
    }

    /// The actuation of a channel that an instant lies in, its start included.
    pub fn during(&self, channel: usize, t_ns: u64) -> Option<&'a Actuation> {
        let list = self.of(channel);
        let after = list.partition_point(|actuation| actuation.start_ns <= t_ns);
        after.checked_sub(1).map(|last| list[last]).filter(|actuation| t_ns < actuation.end_ns())
    }

    /// The actuation of a channel that an instant lies in, its end included.
    pub fn until(&self, channel: usize, t_ns: u64) -> Option<&'a Actuation> {
        let list = self.of(channel);
        let after = list.partition_point(|actuation| actuation.start_ns < t_ns);
        after.checked_sub(1).map(|last| list[last]).filter(|actuation| t_ns <= actuation.end_ns())
    }

    /// The instants at which an actuation of one of these channels begins or ends, in order.
    pub fn breaks(&self, channels: impl IntoIterator<Item = usize>) -> BTreeSet<u64> {
        let actuations = channels.into_iter().flat_map(|channel| self.of(channel));
        actuations.flat_map(|actuation| [actuation.start_ns, actuation.end_ns()]).collect()
    }

    /// The instants at which one of these channels jumps or bends, within swings too.
    pub fn edges(&self, channels: impl IntoIterator<Item = usize> + Clone) -> Edges<'_> {
        let swinging = channels.clone().into_iter().filter(|channel| self.swings(*channel).next().is_some()).collect();
        let breaks = self.breaks(channels).into_iter().collect();
        Edges { signals: self, swinging, breaks, next: 0, open: Vec::new(), last_ns: 0 }
    }

    /// No fewer than the edges of these channels.
    pub fn count_edges(&self, channels: impl IntoIterator<Item = usize>) -> u64 {
        let of_actuation = |actuation: &&Actuation| match actuation.swing {
            Some(swing) => 2 + actuation.duration_ns / half_ns(swing),
            None => 2,
        };
        let actuations = channels.into_iter().flat_map(|channel| self.of(channel));
        actuations.map(of_actuation).fold(0, u64::saturating_add)
    }

    /// The devices that have channels, with their channels' indices, in the order of the channels.
    pub fn devices(&self) -> Vec<(&'a str, Vec<usize>)> {
        let mut devices: indexmap::IndexMap<&str, Vec<usize>> = indexmap::IndexMap::new();
        for (index, channel) in self.schedule.channels.iter().enumerate() {
            devices.entry(&channel.device).or_default().push(index);
        }
        devices.into_iter().collect()
    }

    /// The first actuation that runs in a straight line, where a format can only hold values.
    pub fn first_ramp(&self) -> Option<&'a Actuation> {
        self.schedule.actuations.iter().find(|actuation| actuation.swing.is_none() && actuation.from != actuation.to)
    }
}

/// The edges of some channels, each instant once, in order.
pub struct Edges<'a> {
    signals: &'a Signals<'a>,
    swinging: Vec<usize>,
    breaks: Vec<u64>,
    /// Index of the first break that is not told yet.
    next: usize,
    /// Start and half period of the swings that go on since the last break.
    open: Vec<(u64, u64)>,
    last_ns: u64,
}

impl Iterator for Edges<'_> {
    type Item = u64;

    fn next(&mut self) -> Option<u64> {
        let break_ns = *self.breaks.get(self.next)?;
        let turn = |&(start_ns, half_ns): &(u64, u64)| start_ns + ((self.last_ns - start_ns) / half_ns + 1) * half_ns;
        if let Some(turn_ns) = self.open.iter().map(turn).min().filter(|turn_ns| *turn_ns < break_ns) {
            self.last_ns = turn_ns;
            return Some(turn_ns);
        }
        self.next += 1;
        self.last_ns = break_ns;
        let during = self.swinging.iter().filter_map(|channel| self.signals.during(*channel, break_ns));
        self.open = during.filter_map(|actuation| Some((actuation.start_ns, half_ns(actuation.swing?)))).collect();
        Some(break_ns)
    }
}

/// How long each level of a swing lasts; at least a nanosecond, whatever the period says.
pub fn half_ns(swing: Swing) -> u64 {
    (swing.period_ns / 2).max(1)
}

fn at(actuation: &Actuation, t_ns: u64) -> f64 {
    if let Some(swing) = actuation.swing {
        return swing.levels[((t_ns - actuation.start_ns) / half_ns(swing) % 2) as usize];
    }
    if actuation.from == actuation.to {
        return actuation.from;
    }
    let part = (t_ns - actuation.start_ns) as f64 / actuation.duration_ns as f64;
    actuation.from + (actuation.to - actuation.from) * part
}
