//! Timing that is little disturbed by other programs on the machine.
//!
//! The scheduler reports how long this thread has actually run, in ticks of some milliseconds; if it does not, or for
//! short work, the wall clock is used. Short work is repeated, and the least time counts.

use std::time::{Duration, Instant};

/// Work of at least this duration is measured by the scheduler's time.
const LONG: Duration = Duration::from_millis(40);

/// Repetitions of short work.
const REPEATS: u32 = 5;

/// The running time of this thread so far, from an arbitrary origin.
pub fn running() -> Duration {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = text.split_whitespace().next().and_then(|word| word.parse().ok()).filter(|count| *count > 0);
    nanoseconds.map_or_else(since_start, Duration::from_nanos)
}

fn since_start() -> Duration {
    static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    START.get_or_init(Instant::now).elapsed()
}

/// The result of deterministic work, and its time.
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
