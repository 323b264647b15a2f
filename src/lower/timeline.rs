//! Placement of the runs and waits of a program in time.

use crate::claims::Timeline;

/// Longest schedule, in nanoseconds: a little over eleven days.
pub const MAX_DURATION_NS: u64 = 1_000_000_000_000_000;

/// A run or a wait of a program, on its clock; a wait has no job.
pub struct PlacedStretch {
    pub start_ns: u64,
    pub end_ns: u64,
    pub job: Option<usize>,
}

/// Places the runs and waits of a timeline on the clock; run i lasts `runs_ns[i]`. Returns the end of the timeline;
/// `None` if that is later than [`MAX_DURATION_NS`].
pub fn place(timeline: &Timeline, at_ns: u64, runs_ns: &[u64], placed: &mut Vec<PlacedStretch>) -> Option<u64> {
    let mut lasts = |duration_ns: u64, job: Option<usize>| {
        let end_ns = at_ns.checked_add(duration_ns)?;
        placed.push(PlacedStretch { start_ns: at_ns, end_ns, job });
        Some(end_ns)
    };
    let end = match timeline {
        Timeline::Run(job) => lasts(runs_ns[*job], Some(*job))?,
        Timeline::Wait(duration_ns) => lasts(*duration_ns, None)?,
        Timeline::Sequence(parts) => {
            let mut end = at_ns;
            for part in parts {
                end = place(part, end, runs_ns, placed)?;
            }
            end
        }
        Timeline::Together(parts) => {
            let mut end = at_ns;
            for part in parts {
                end = end.max(place(part, at_ns, runs_ns, placed)?);
            }
            end
        }
    };
    (end <= MAX_DURATION_NS).then_some(end)
}
