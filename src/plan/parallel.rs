//! Independent parts of a planner's work on all processors, with results in the order of the parts.
//!
//! Each part is worked out once, whatever the number of threads, so that number does not change the results. The threads
//! report their steps to the watch of the calling thread. They must not hold plans ([`super::watch::IncumbentPlan`]),
//! since these are nested by time.

use super::watch;
use std::num::NonZero;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::ScopedJoinHandle;

/// Number of threads that this machine runs at once.
pub fn processors() -> usize {
    std::thread::available_parallelism().map_or(1, NonZero::get)
}

/// `one(0)` to `one(count - 1)`, by that many threads at most. A part that panics panics here.
pub fn in_order<T: Send>(count: usize, threads: usize, one: impl Fn(usize) -> T + Sync) -> Vec<T> {
    if threads <= 1 || count <= 1 {
        return (0..count).map(one).collect();
    }
    let (watch, next) = (watch::current(), AtomicUsize::new(0));
    // The next part goes to the thread that is free first, since parts differ in their cost.
    let parts = || std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed)).take_while(|part| *part < count);
    let work = || parts().map(|part| (part, one(part))).collect::<Vec<(usize, T)>>();
    let watched = || match &watch {
        Some(watch) => watch.over(work),
        None => work(),
    };
    let mut done: Vec<(usize, T)> = std::thread::scope(|scope| {
        let handles: Vec<_> = (0..threads.min(count)).map(|_| scope.spawn(watched)).collect();
        let joined =
            |handle: ScopedJoinHandle<Vec<(usize, T)>>| handle.join().unwrap_or_else(|panic| resume_unwind(panic));
        handles.into_iter().flat_map(joined).collect()
    });
    done.sort_unstable_by_key(|(part, _)| *part);
    done.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::search::{Meter, SearchBudget};
    use crate::plan::watch::{BEAT_STEPS, SearchWatch};
    use std::sync::Arc;

    #[test]
    fn results_are_in_order_and_the_same_with_any_number_of_threads() {
        let watch = Arc::new(SearchWatch::default());
        for count in [0, 1, 2, 50] {
            let expected: Vec<usize> = (0..count).map(|part| part * part).collect();
            for threads in [0, 1, 2, 3, 8] {
                assert_eq!(in_order(count, threads, |part| part * part), expected, "{count} parts, {threads} threads");
            }
        }
        let steps = |_: usize| {
            let mut meter = Meter::new(SearchBudget::of(2 * BEAT_STEPS));
            std::iter::from_fn(|| meter.step()).count()
        };
        let counted: usize = watch.over(|| in_order(3, 2, steps)).into_iter().sum();
        assert_eq!((counted as u64, watch.progress().steps), (6 * BEAT_STEPS, 6 * BEAT_STEPS));
    }

    #[test]
    #[should_panic(expected = "part 5")]
    fn a_panic_of_a_part_is_passed_on() {
        in_order(8, 2, |part| assert!(part != 5, "part {part}"));
    }
}
