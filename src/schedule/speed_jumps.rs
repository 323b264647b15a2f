//! Speed jumps of stages: the corners of paths made of straight segments.

use super::{Actuation, Schedule};

/// A jump of a stage's speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedJump {
    pub t_ns: u64,
    /// Above 0.
    pub change_um_per_s: f64,
    /// How long the speed is constant before and after it, the shorter of the two; `u64::MAX` if the stage is at rest
    /// on both sides for good.
    pub room_ns: u64,
    /// The step of the actuation that begins or ends there.
    pub step: u32,
}

/// An interval of constant speed.
struct SpeedInterval {
    start_ns: u64,
    speed_um_per_s: f64,
    step: u32,
}

impl Actuation {
    /// Speed of a stage, in micrometres per second.
    pub fn speed_um_per_s(&self) -> f64 {
        (self.to - self.from) / self.duration_ns.max(1) as f64 * 1e9
    }
}

impl Schedule {
    /// The actuations of a channel, in order of time.
    pub fn actuations_of(&self, channel: usize) -> Vec<&Actuation> {
        let own = self.actuations.iter().filter(|actuation| actuation.channel as usize == channel);
        let mut own: Vec<&Actuation> = own.collect();
        own.sort_by_key(|actuation| actuation.start_ns);
        own
    }

    /// The speed jumps of a channel of positions, in order of time.
    pub fn speed_jumps(&self, channel: usize) -> Vec<SpeedJump> {
        let mut intervals = vec![SpeedInterval { start_ns: 0, speed_um_per_s: 0.0, step: 0 }];
        let mut add = |start_ns: u64, speed_um_per_s: f64, step: u32| {
            if intervals.last().is_none_or(|last| last.speed_um_per_s != speed_um_per_s) {
                intervals.push(SpeedInterval { start_ns, speed_um_per_s, step });
            }
        };
        let mut end = None;
        for actuation in self.actuations_of(channel) {
            if let Some((end_ns, step)) = end.filter(|(end_ns, _)| *end_ns < actuation.start_ns) {
                add(end_ns, 0.0, step);
            }
            add(actuation.start_ns, actuation.speed_um_per_s(), actuation.step);
            end = Some((actuation.end_ns(), actuation.step));
        }
        if let Some((end_ns, step)) = end {
            add(end_ns, 0.0, step);
        }
        let lasts_ns = |index: usize| match (index, intervals.get(index + 1)) {
            (0, _) | (_, None) => u64::MAX,
            (_, Some(next)) => next.start_ns - intervals[index].start_ns,
        };
        let jump = |(index, pair): (usize, &[SpeedInterval])| SpeedJump {
            t_ns: pair[1].start_ns,
            change_um_per_s: (pair[1].speed_um_per_s - pair[0].speed_um_per_s).abs(),
            room_ns: lasts_ns(index).min(lasts_ns(index + 1)),
            step: pair[1].step,
        };
        intervals.windows(2).enumerate().map(jump).collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::emit::fixture;

    /// Compares the speed before and after every instant at which an actuation begins or ends.
    #[test]
    fn speed_jumps_are_where_the_speed_changes() {
        let hand = fixture::hand().verified;
        let schedule = hand.schedule();
        let mut count = 0;
        for channel in 0..schedule.channels.len() {
            let own = schedule.actuations_of(channel);
            let speed = |t_ns: u64| own.iter().find(|one| (one.start_ns..one.end_ns()).contains(&t_ns));
            let speed = |t_ns: u64| speed(t_ns).map_or(0.0, |one| one.speed_um_per_s());
            let mut edges: Vec<u64> = own.iter().flat_map(|one| [one.start_ns, one.end_ns()]).collect();
            edges.sort_unstable();
            edges.dedup();
            let changes = edges.iter().map(|t_ns| (*t_ns, (speed(*t_ns) - speed(t_ns - 1)).abs()));
            let expected: Vec<(u64, f64)> = changes.filter(|(_, change)| *change > 0.0).collect();
            let speed_jumps = schedule.speed_jumps(channel);
            assert_eq!(speed_jumps.iter().map(|jump| (jump.t_ns, jump.change_um_per_s)).collect::<Vec<_>>(), expected);
            for (index, jump) in speed_jumps.iter().enumerate() {
                let gap = |a: Option<&(u64, f64)>, b: Option<&(u64, f64)>| Some(b?.0 - a?.0);
                let around = [
                    gap(index.checked_sub(1).and_then(|before| expected.get(before)), expected.get(index)),
                    gap(expected.get(index), expected.get(index + 1)),
                ];
                assert_eq!(jump.room_ns, around.into_iter().flatten().min().unwrap_or(u64::MAX));
                count += 1;
            }
        }
        assert!(count > 20, "{count}");
    }
}
