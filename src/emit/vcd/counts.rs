//! Positions as encoder counts.
//!
//! Input: a channel of positions. Output: the instants at which its nearest multiple of [`COUNT_UM`] changes, each with
//! the new multiple. Guarantee: at every nanosecond the current count is within half of [`COUNT_UM`] of the position,
//! except for rounding.

use crate::emit::Signals;
use crate::schedule::{Actuation, ChannelUnit};

/// Length of one count, in micrometres.
pub const COUNT_UM: f64 = 1.0 / COUNTS_PER_UM;

/// A whole number, so that a count divided by it is the nearest number to its decimal form.
const COUNTS_PER_UM: f64 = 100.0;

/// The nearest multiple of [`COUNT_UM`].
pub fn counted(position_um: f64) -> f64 {
    count(position_um) / COUNTS_PER_UM
}

fn count(position_um: f64) -> f64 {
    // Adding 0 turns minus zero into zero.
    (position_um * COUNTS_PER_UM).round() + 0.0
}

/// Upper bound on the number of changes of all position channels.
pub fn number(signals: &Signals) -> u64 {
    let of_actuation = |actuation: &&Actuation| ((actuation.to - actuation.from).abs() * COUNTS_PER_UM) as u64 + 2;
    let actuations = signals.in_unit(ChannelUnit::Micrometre).flat_map(|channel| signals.of(channel));
    actuations.map(of_actuation).fold(0, u64::saturating_add)
}

/// The counts of a channel from each instant on, in order of time.
pub struct Counts<'a> {
    actuations: std::slice::Iter<'a, &'a Actuation>,
    /// The current ramp, and the number of its steps already returned.
    line: Option<(&'a Actuation, f64)>,
}

impl<'a> Counts<'a> {
    pub fn new(signals: &'a Signals, channel: usize) -> Self {
        Counts { actuations: signals.of(channel).iter(), line: None }
    }
}

impl Iterator for Counts<'_> {
    type Item = (u64, f64);

    fn next(&mut self) -> Option<(u64, f64)> {
        if let Some((actuation, written)) = self.line {
            let [from, to] = [actuation.from, actuation.to].map(count);
            if written < (to - from).abs() {
                self.line = Some((actuation, written + 1.0));
                return Some(change(actuation, from + written * (to - from).signum(), (to - from).signum()));
            }
            self.line = None;
        }
        let actuation = *self.actuations.next()?;
        self.line = Some((actuation, 0.0));
        Some((actuation.start_ns, counted(actuation.from)))
    }
}

/// The instant at which a ramp passes to the next count, and that count.
fn change(actuation: &Actuation, count: f64, sign: f64) -> (u64, f64) {
    let at_um = (count + sign / 2.0) / COUNTS_PER_UM;
    let share = ((at_um - actuation.from) / (actuation.to - actuation.from)).clamp(0.0, 1.0);
    let after_ns = (share * actuation.duration_ns as f64).ceil() as u64;
    (actuation.start_ns + after_ns.clamp(1, actuation.duration_ns), (count + sign) / COUNTS_PER_UM)
}
