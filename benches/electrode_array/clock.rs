//! Time that other programs on the machine disturb little.
//!
//! The scheduler tells how long this thread has really run, in ticks of some milliseconds; where it does not, or for short work,
//! the clock on the wall is read. Short work is repeated, and the least time counts.

use std::time::{Duration, Instant};

/// Work as long as this is measured by the scheduler's time.
const LONG: Duration = Duration::from_millis(40);

/// How often short work is done.
const REPEATS: u32 = 5;

/// The time of this thread so far, from any beginning.
pub fn running() -> Duration {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = text.split_whitespace().next().and_then(|word| word.parse().ok()).filter(|count| *count > 0);
    nanoseconds.map_or_else(since_start, Duration::from_nanos)
}

fn since_start() -> Duration {
    static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    START.get_or_init(Instant::now).elapsed()
}

/// The result of some work that always does the same, and its time.
pub fn timed<T>(mut work: impl FnMut() -> T) -> (Duration, T) {
    let mut least = Duration::MAX;
    for repeat in 1.. {
        let (wall, ran) = (Instant::now(), running());
        let result = work();
        let (wall, ran) = (wall.elapsed(), running().saturating_sub(ran));
        least = least.min(wall);
        if ran >= LONG {
            return (ran.min(least), result);
        }
        if repeat >= REPEATS {
            return (least, result);
        }
    }
    unreachable!("the loop has no end")
}
