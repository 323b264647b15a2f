//! The channels of a schedule as functions of time.
//!
//! Outside its actuations a voltage is at rest, and a stage stays at its last position, or at its first one before the
//! first actuation.
//!
//! A swing is one actuation however long it is. Its ends are [`Signals::breaks`]; the changes between them are only
//! counted, or listed one by one by [`SignalEdges`] for formats without a notation for trains.

use super::identifier;
use crate::schedule::levels::away_from_rest;
use crate::schedule::{Actuation, ChannelUnit, Schedule, Swing};
use std::collections::{BTreeMap, BTreeSet};

/// Greatest rounding difference of two equal positions, in micrometres.
pub const JUMP_TOLERANCE_UM: f64 = 1e-9;

/// State of a channel around an instant: a drive train, or a single value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    /// Levels of the train in order; without a train, twice the value.
    pub levels: [f64; 2],
    /// 0 without a train.
    pub period_ns: u64,
    /// Start of the train; 0 without one.
    pub start_ns: u64,
}

/// The actuations of a schedule by channel, for looking up values.
pub struct Signals<'a> {
    pub schedule: &'a Schedule,
    by_channel: Vec<Vec<&'a Actuation>>,
}

impl<'a> Signals<'a> {
    /// Sorts the actuations of a schedule by channel. A channel has at most one value at a time.
    pub fn new(schedule: &'a Schedule) -> Self {
        Signals { schedule, by_channel: schedule.by_channel() }
    }

    /// The actuations of a channel in order of time.
    pub fn of(&self, channel: usize) -> &[&'a Actuation] {
        &self.by_channel[channel]
    }

    /// The actuations of a voltage channel between which its value changes, in order of time.
    pub fn away_from_rest(&self, channel: usize) -> Vec<Actuation> {
        away_from_rest(self.of(channel).iter().copied(), self.schedule.channels[channel].rest_v)
    }

    /// The swings of a channel with their actuations, in order of time.
    pub fn swings(&self, channel: usize) -> impl Iterator<Item = (&'a Actuation, Swing)> {
        self.of(channel).iter().filter_map(|actuation| Some((*actuation, actuation.swing?)))
    }

    /// Unit of a channel.
    pub fn unit(&self, channel: usize) -> ChannelUnit {
        self.schedule.channels[channel].unit
    }

    /// The channels of a unit.
    pub fn in_unit(&self, unit: ChannelUnit) -> impl Iterator<Item = usize> + Clone {
        (0..self.schedule.channels.len()).filter(move |channel| self.unit(*channel) == unit)
    }

    /// The value at an instant; at a jump, the new one.
    pub fn value(&self, channel: usize, t_ns: u64) -> f64 {
        self.value_of(channel, self.begun(channel, t_ns), t_ns)
    }

    /// The value at an instant, given the number of actuations that have begun by then.
    fn value_of(&self, channel: usize, begun: usize, t_ns: u64) -> f64 {
        self.during_of(channel, begun, t_ns).map_or_else(|| self.rest(channel, begun), |actuation| at(actuation, t_ns))
    }

    /// The value just before an instant.
    pub fn value_before(&self, channel: usize, t_ns: u64) -> f64 {
        let rest = || self.rest(channel, self.begun_before(channel, t_ns));
        self.until(channel, t_ns).map_or_else(rest, |actuation| match actuation.swing {
            // Levels hold for whole nanoseconds, so the value before is that of the preceding nanosecond.
            Some(_) => at(actuation, t_ns - 1),
            None => at(actuation, t_ns),
        })
    }

    /// The value of a voltage before and after the schedule; `None` for a stage, which stays where it is.
    pub fn rest_v(&self, channel: usize) -> Option<f64> {
        match self.unit(channel) {
            ChannelUnit::Volt => Some(self.schedule.channels[channel].rest_v),
            ChannelUnit::Micrometre => None,
        }
    }

    /// The value between two actuations, after the first `over` of them: a stage stays where it is, a voltage is at
    /// rest.
    fn rest(&self, channel: usize, over: usize) -> f64 {
        let list = self.of(channel);
        self.rest_v(channel).unwrap_or_else(|| match over.checked_sub(1) {
            Some(last) => list[last].to,
            None => list.first().map_or(0.0, |first| first.from),
        })
    }

    /// Number of actuations of a channel that have begun by an instant.
    fn begun(&self, channel: usize, t_ns: u64) -> usize {
        self.of(channel).partition_point(|actuation| actuation.start_ns <= t_ns)
    }

    /// Number of actuations of a channel that have begun before an instant.
    fn begun_before(&self, channel: usize, t_ns: u64) -> usize {
        self.of(channel).partition_point(|actuation| actuation.start_ns < t_ns)
    }

    /// Whether a channel has drive trains.
    pub fn has_trains(&self, channel: usize) -> bool {
        self.swings(channel).next().is_some()
    }

    /// State of a channel around an instant, for formats with a notation for trains.
    pub fn drive(&self, channel: usize, t_ns: u64) -> Drive {
        match self.during(channel, t_ns) {
            Some(Actuation { swing: Some(Swing { period_ns, levels }), start_ns, .. }) => {
                Drive { levels: *levels, period_ns: *period_ns, start_ns: *start_ns }
            }
            Some(_) | None => Drive { levels: [self.value(channel, t_ns); 2], period_ns: 0, start_ns: 0 },
        }
    }

    /// The actuation of a channel at an instant, its start included.
    pub fn during(&self, channel: usize, t_ns: u64) -> Option<&'a Actuation> {
        self.during_of(channel, self.begun(channel, t_ns), t_ns)
    }

    /// The actuation at an instant, given the number of actuations that have begun by then.
    fn during_of(&self, channel: usize, begun: usize, t_ns: u64) -> Option<&'a Actuation> {
        let last = begun.checked_sub(1)?;
        Some(self.of(channel)[last]).filter(|actuation| t_ns < actuation.end_ns())
    }

    /// The actuation of a channel at an instant, its end included.
    pub fn until(&self, channel: usize, t_ns: u64) -> Option<&'a Actuation> {
        let last = self.begun_before(channel, t_ns).checked_sub(1)?;
        Some(self.of(channel)[last]).filter(|actuation| t_ns <= actuation.end_ns())
    }

    /// The instants at which an actuation of one of these channels begins or ends, in order.
    pub fn breaks(&self, channels: impl IntoIterator<Item = usize>) -> BTreeSet<u64> {
        let actuations = channels.into_iter().flat_map(|channel| self.of(channel));
        actuations.flat_map(|actuation| [actuation.start_ns, actuation.end_ns()]).collect()
    }

    /// The instants at which one of these channels jumps or bends, including those within swings.
    pub fn edges(&self, channels: impl IntoIterator<Item = usize> + Clone) -> SignalEdges<'_> {
        let swinging = channels.clone().into_iter().filter(|channel| self.swings(*channel).next().is_some()).collect();
        let breaks = self.breaks(channels).into_iter().collect();
        SignalEdges { signals: self, swinging, breaks, next: 0, open: Vec::new(), last_ns: 0 }
    }

    /// Upper bound on the number of edges of these channels.
    pub fn count_edges(&self, channels: impl IntoIterator<Item = usize>) -> u64 {
        let of_actuation = |actuation: &&Actuation| match actuation.swing {
            Some(swing) => 2 + actuation.duration_ns / half_ns(swing),
            None => 2,
        };
        let actuations = channels.into_iter().flat_map(|channel| self.of(channel));
        actuations.map(of_actuation).fold(0, u64::saturating_add)
    }

    /// The devices that have channels, each with a name that is distinct in the grammar of `plain`.
    pub fn device_names(&self, plain: impl Fn(&str) -> String) -> BTreeMap<&'a str, String> {
        let devices: indexmap::IndexSet<&str> =
            self.schedule.channels.iter().map(|channel| channel.device.as_str()).collect();
        let names = identifier::distinct_by(devices.iter().copied(), plain);
        devices.into_iter().zip(names).collect()
    }

    /// The devices that have channels, by unit, with the indices of their channels, in channel order.
    pub fn devices(&self) -> Vec<(&'a str, ChannelUnit, Vec<usize>)> {
        let mut devices: indexmap::IndexMap<(&str, ChannelUnit), Vec<usize>> = indexmap::IndexMap::new();
        for (index, channel) in self.schedule.channels.iter().enumerate() {
            devices.entry((&channel.device, channel.unit)).or_default().push(index);
        }
        devices.into_iter().map(|((device, unit), channels)| (device, unit, channels)).collect()
    }

    /// The first voltage ramp, for formats that can only hold voltages.
    pub fn first_ramp(&self) -> Option<&'a Actuation> {
        self.schedule.actuations.iter().find(|actuation| {
            let of_volts = self
                .schedule
                .channels
                .get(actuation.channel as usize)
                .is_some_and(|channel| channel.unit == ChannelUnit::Volt);
            of_volts && actuation.swing.is_none() && actuation.from != actuation.to
        })
    }

    /// The channel and instant of the first position jump or swing of a stage.
    pub fn first_jump(&self) -> Option<(usize, u64)> {
        let jump = |channel: usize| {
            let jumps =
                |t_ns: &u64| (self.value_before(channel, *t_ns) - self.value(channel, *t_ns)).abs() > JUMP_TOLERANCE_UM;
            let swing = self.swings(channel).next().map(|(actuation, _)| actuation.start_ns);
            let t_ns = swing.or_else(|| self.breaks([channel]).into_iter().find(jumps))?;
            Some((channel, t_ns))
        };
        self.in_unit(ChannelUnit::Micrometre).find_map(jump)
    }
}

/// A channel read at successive instants in order of time, without a search for each.
pub struct SignalCursor<'a> {
    signals: &'a Signals<'a>,
    channel: usize,
    /// Number of its actuations that have begun by the last instant.
    begun: usize,
}

impl<'a> SignalCursor<'a> {
    pub fn new(signals: &'a Signals<'a>, channel: usize) -> SignalCursor<'a> {
        SignalCursor { signals, channel, begun: 0 }
    }

    /// The lowest and the highest value of the channel around an instant that is no earlier than the last one: the
    /// levels of a swing, else twice the value.
    pub fn envelope(&mut self, t_ns: u64) -> [f64; 2] {
        let rest = &self.signals.of(self.channel)[self.begun..];
        self.begun += rest.iter().take_while(|actuation| t_ns >= actuation.start_ns).count();
        match self.signals.during_of(self.channel, self.begun, t_ns) {
            Some(Actuation { swing: Some(Swing { levels: [a, b], .. }), .. }) => [a.min(*b), a.max(*b)],
            Some(_) | None => [self.signals.value_of(self.channel, self.begun, t_ns); 2],
        }
    }
}

/// The edges of some channels in order, each instant once.
pub struct SignalEdges<'a> {
    signals: &'a Signals<'a>,
    swinging: Vec<usize>,
    breaks: Vec<u64>,
    /// Index of the first break not yet listed.
    next: usize,
    /// Start and half period of the swings in progress since the last break.
    open: Vec<(u64, u64)>,
    last_ns: u64,
}

impl Iterator for SignalEdges<'_> {
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

/// Duration of each level of a swing; at least one nanosecond, whatever the period.
pub fn half_ns(swing: Swing) -> u64 {
    (swing.period_ns / 2).max(1)
}

fn at(actuation: &Actuation, t_ns: u64) -> f64 {
    if let Some(swing) = actuation.swing {
        return swing.levels[((t_ns - actuation.start_ns) / half_ns(swing) % 2) as usize];
    }
    if actuation.from == actuation.to || t_ns == actuation.end_ns() {
        return actuation.to;
    }
    let part = (t_ns - actuation.start_ns) as f64 / actuation.duration_ns as f64;
    actuation.from + (actuation.to - actuation.from) * part
}
