//! Timing of a robot's pulses along a given path, so that its tip meets no other.
//!
//! Problem: pulses in a fixed order, each as early as the positions of the other tips allow. Method: safe intervals (Phillips and
//! Likhachev, SIPP: safe interval path planning, ICRA 2011) along the one path: for each place, the intervals during which no other
//! tip is near, and for each of them the earliest arrival. Guaranteed: if the path has a valid timing, the earliest end on the grid
//! of the robots' pulses is found. Cost: comparisons of each place of the path with each stretch of the others.

use super::tips::Area;

/// Area that a tip occupies between two instants, both included.
#[derive(Debug, Clone, Copy)]
pub struct TipStay {
    pub start_ns: u64,
    pub end_ns: u64,
    pub area: Area,
}

/// Occupied areas of another robot in order of time, and the gap to keep from it.
#[derive(Debug, Clone, Copy)]
pub struct OtherRobot<'a> {
    pub stretches: &'a [TipStay],
    pub gap_um: f64,
}

/// One action of a robot along its path.
#[derive(Debug, Clone, Copy)]
pub enum TimedAct {
    /// A pulse: the tip moves within an area to a place of it.
    Pulse { within: Area, to: Area },
    /// Idle time in nanoseconds.
    Wait(u64),
}

/// A path, and when it may begin.
#[derive(Debug, Clone)]
pub struct TimedPath {
    /// From this instant on the robot stands at the start of the path.
    pub since_ns: u64,
    /// From this instant on it may move.
    pub start_ns: u64,
    pub from: Area,
    pub acts: Vec<TimedAct>,
    pub pulse_ns: u64,
    /// From the beginning of a pulse to the end of its rest.
    pub slot_ns: u64,
    /// A delayed pulse begins at a multiple of this, so that the delay demands no finer clock from the instruments.
    pub grain_ns: u64,
}

/// Why no timing of the path exists.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoTiming {
    /// Another robot always blocks the path; this is the first meeting without delays.
    Met(TipMeeting),
    /// The budget of comparisons is spent.
    Spent,
}

/// Two tips that may touch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TipMeeting {
    pub at_ns: u64,
    /// Index into the other robots.
    pub with: usize,
}

/// Time intervals, both ends included, in order.
type Free = Vec<[u64; 2]>;

/// Earliest arrival at a place of the path within one safe interval.
#[derive(Debug, Clone, Copy)]
struct Arrival {
    /// Earliest instant of the next pulse.
    ready_ns: u64,
    /// Last instant of the safe interval.
    until_ns: u64,
    /// Index of the previous arrival, and the instant of the pulse between the two.
    before: usize,
    pulse_ns: u64,
}

impl TimedPath {
    /// Delay before each pulse, for the earliest end of the path.
    ///
    /// # Errors
    /// See [`NoTiming`]. `allowed` is the remaining number of comparisons and is decremented.
    pub fn delays(&self, others: &[OtherRobot], allowed: &mut u64) -> Result<Vec<u64>, NoTiming> {
        let at_once = vec![0; self.acts.iter().filter(|act| matches!(act, TimedAct::Pulse { .. })).count()];
        let Some(meeting) = self.first_meeting(others, allowed)? else { return Ok(at_once) };
        let levels = self.levels(others, allowed)?;
        let last = levels.last().map(Vec::as_slice).unwrap_or_default();
        let best = (0..last.len()).filter(|at| last[*at].until_ns == u64::MAX).min_by_key(|at| last[*at].ready_ns);
        best.map(|best| self.traced(&levels, best)).ok_or(NoTiming::Met(meeting))
    }

    /// Areas of the tip over time, given a delay before each pulse; and the end of the last rest or wait.
    pub fn stretches(&self, delays: &[u64]) -> (Vec<TipStay>, u64) {
        let (mut stretches, mut since_ns, mut ready_ns, mut at) = (Vec::new(), self.since_ns, self.start_ns, self.from);
        let mut delays = delays.iter();
        for act in &self.acts {
            match act {
                TimedAct::Wait(duration_ns) => ready_ns = ready_ns.saturating_add(*duration_ns),
                TimedAct::Pulse { within, to } => {
                    let start_ns = ready_ns.saturating_add(delays.next().copied().unwrap_or(0));
                    let end_ns = start_ns.saturating_add(self.pulse_ns);
                    stretches.push(TipStay { start_ns: since_ns, end_ns: start_ns, area: at });
                    stretches.push(TipStay { start_ns, end_ns, area: *within });
                    (at, since_ns, ready_ns) = (*to, end_ns, start_ns.saturating_add(self.slot_ns));
                }
            }
        }
        stretches.push(TipStay { start_ns: since_ns, end_ns: u64::MAX, area: at });
        (stretches, ready_ns)
    }

    /// The first meeting when every pulse comes as early as the robot can.
    fn first_meeting(&self, others: &[OtherRobot], allowed: &mut u64) -> Result<Option<TipMeeting>, NoTiming> {
        let (own, _) = self.stretches(&[]);
        let mut first: Option<TipMeeting> = None;
        for (with, other) in others.iter().enumerate() {
            let mut from = other.stretches.partition_point(|stretch| stretch.end_ns < self.since_ns);
            for stretch in &own {
                while other.stretches.get(from).is_some_and(|beside| beside.end_ns < stretch.start_ns) {
                    from += 1;
                }
                let beside = other.stretches[from..].iter().take_while(|beside| beside.start_ns <= stretch.end_ns);
                for beside in beside {
                    spend(allowed)?;
                    let at_ns = stretch.start_ns.max(beside.start_ns);
                    if stretch.area.is_near(&beside.area, other.gap_um) && first.is_none_or(|first| at_ns < first.at_ns)
                    {
                        first = Some(TipMeeting { at_ns, with });
                    }
                }
            }
        }
        Ok(first)
    }

    /// The arrivals at the start, then those after each act.
    fn levels(&self, others: &[OtherRobot], allowed: &mut u64) -> Result<Vec<Vec<Arrival>>, NoTiming> {
        let mut here = self.free(&self.from, others, allowed)?;
        let stands = here.iter().filter(|[from, to]| *from <= self.since_ns && self.start_ns <= *to);
        let begin = stands.map(|[_, to]| Arrival { ready_ns: self.start_ns, until_ns: *to, before: 0, pulse_ns: 0 });
        let mut levels = vec![begin.collect::<Vec<_>>()];
        for act in &self.acts {
            let last = levels.last().map(Vec::as_slice).unwrap_or_default();
            let next = match act {
                TimedAct::Wait(duration_ns) => waited(last, *duration_ns),
                TimedAct::Pulse { within, to } => {
                    let moving = self.free(within, others, allowed)?;
                    here = self.free(to, others, allowed)?;
                    self.switched(last, &moving, &here)
                }
            };
            levels.push(next);
        }
        Ok(levels)
    }

    /// The arrivals after a pulse: the earliest in each safe interval of its end.
    fn switched(&self, last: &[Arrival], moving: &Free, here: &Free) -> Vec<Arrival> {
        let mut next: Vec<Arrival> = Vec::new();
        for (before, arrival) in last.iter().enumerate() {
            for [from, to] in moving {
                let pulse_ns = match arrival.ready_ns >= *from {
                    true => arrival.ready_ns,
                    false => from.checked_next_multiple_of(self.grain_ns).unwrap_or(u64::MAX),
                };
                let end_ns = pulse_ns.saturating_add(self.pulse_ns);
                if pulse_ns > arrival.until_ns || end_ns > *to {
                    continue;
                }
                let Some([_, until_ns]) = here.iter().find(|[from, to]| (*from..=*to).contains(&end_ns)) else {
                    continue;
                };
                let ready_ns = pulse_ns.saturating_add(self.slot_ns);
                let arrival = Arrival { ready_ns, until_ns: *until_ns, before, pulse_ns };
                match next.iter_mut().find(|known| known.until_ns == *until_ns) {
                    Some(known) if known.ready_ns > ready_ns => *known = arrival,
                    Some(_) => {}
                    None if ready_ns <= *until_ns => next.push(arrival),
                    None => {}
                }
            }
        }
        next
    }

    /// The delays that lead to an arrival at the end of the path.
    fn traced(&self, levels: &[Vec<Arrival>], best: usize) -> Vec<u64> {
        let (mut at, mut delays) = (best, Vec::new());
        for (act, pair) in self.acts.iter().zip(levels.windows(2)).rev() {
            let arrival = pair[1][at];
            at = arrival.before;
            if let TimedAct::Pulse { .. } = act {
                delays.push(arrival.pulse_ns - pair[0][at].ready_ns);
            }
        }
        delays.reverse();
        delays
    }

    /// The intervals in which no other tip is near an area, from the instant at which the robot stands at the start of its path.
    fn free(&self, area: &Area, others: &[OtherRobot], allowed: &mut u64) -> Result<Free, NoTiming> {
        let mut taken: Vec<[u64; 2]> = Vec::new();
        for other in others {
            let from = other.stretches.partition_point(|stretch| stretch.end_ns < self.since_ns);
            for stretch in &other.stretches[from..] {
                spend(allowed)?;
                if area.is_near(&stretch.area, other.gap_um) {
                    taken.push([stretch.start_ns, stretch.end_ns]);
                }
            }
        }
        taken.sort_unstable();
        let (mut free, mut from) = (Free::new(), Some(0));
        for [start_ns, end_ns] in taken {
            let Some(at) = from else { break };
            if at < start_ns {
                free.push([at, start_ns - 1]);
            }
            from = end_ns.checked_add(1).map(|after| after.max(at));
        }
        free.extend(from.map(|from| [from, u64::MAX]));
        Ok(free)
    }
}

fn waited(last: &[Arrival], duration_ns: u64) -> Vec<Arrival> {
    let later = last.iter().enumerate().map(|(before, arrival)| Arrival {
        ready_ns: arrival.ready_ns.saturating_add(duration_ns),
        before,
        ..*arrival
    });
    later.filter(|arrival| arrival.ready_ns <= arrival.until_ns).collect()
}

fn spend(allowed: &mut u64) -> Result<(), NoTiming> {
    *allowed = allowed.checked_sub(1).ok_or(NoTiming::Spent)?;
    Ok(())
}
