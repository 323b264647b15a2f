//! Who follows a search while it runs: how many steps it took, what its best plan costs so far, and that this plan is good enough.
//!
//! A [`SearchWatch`] is shared between the thread that plans and one that looks on. Searches feed it through their [`Meter`]s, once in
//! [`BEAT_STEPS`] steps, and with a [`HeldPlan`] for as long as they would answer with a plan if they ended now. Once the plan at hand is
//! enough, every meter says that no step is left, but only while a plan is held: a search ends as if its budget were spent, and says no
//! more of its plan than in that case. Without a watch, as in tests, nothing is fed and nothing ends early.
//!
//! [`Meter`]: super::search::Meter

use std::cell::RefCell;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Steps of a meter between two looks at its watch: less than a millisecond of most searches.
pub const BEAT_STEPS: u64 = 4096;

thread_local! {
    static WATCHED_BY: RefCell<Option<Arc<SearchWatch>>> = const { RefCell::new(None) };
}

/// News of the searches of one thread, and the wish that they end.
#[derive(Debug, Default)]
pub struct SearchWatch {
    steps: AtomicU64,
    is_enough: AtomicBool,
    /// Whether a search has ended because of that.
    has_ended: AtomicBool,
    /// The plans that searches hold, one within the other: what each costs, in words.
    held: Mutex<Vec<String>>,
}

/// What a search has come to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SearchNews {
    /// Steps since the run of a task was begun.
    pub steps: u64,
    /// What the best plan costs, and what is known of the least cost.
    pub best: Option<String>,
}

impl SearchWatch {
    /// Watches the searches that `plan` runs on this thread.
    pub fn over<T>(self: &Arc<Self>, plan: impl FnOnce() -> T) -> T {
        /// Puts the former watch back, also after a panic.
        struct Former(Option<Arc<SearchWatch>>);
        impl Drop for Former {
            fn drop(&mut self) {
                let former = self.0.take();
                WATCHED_BY.with_borrow_mut(|watch| *watch = former);
            }
        }
        let _former = Former(WATCHED_BY.with_borrow_mut(|watch| watch.replace(Arc::clone(self))));
        plan()
    }

    /// What the search that runs has come to.
    pub fn news(&self) -> SearchNews {
        SearchNews { steps: self.steps.load(Ordering::Relaxed), best: self.held().last().cloned() }
    }

    /// From now on the first plan of each search is enough.
    pub fn take_what_is_held(&self) {
        self.is_enough.store(true, Ordering::Relaxed);
    }

    fn held(&self) -> MutexGuard<'_, Vec<String>> {
        // A thread that panicked has left a list as it was.
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn watched<T>(tell: impl FnOnce(&SearchWatch) -> T) -> Option<T> {
    WATCHED_BY.with_borrow(|watch| watch.as_deref().map(tell))
}

/// The searches for the next run of a task begin.
pub(super) fn begin_run() {
    watched(|watch| {
        watch.steps.store(0, Ordering::Relaxed);
        watch.has_ended.store(false, Ordering::Relaxed);
        watch.held().clear();
    });
}

/// Whether a search has ended since then because its plan was enough.
pub(super) fn has_ended_early() -> bool {
    watched(|watch| watch.has_ended.load(Ordering::Relaxed)).unwrap_or(false)
}

/// Tells of so many steps.
pub(super) fn tell(steps: u64) {
    watched(|watch| watch.steps.fetch_add(steps, Ordering::Relaxed));
}

/// Whether the search is to go on.
pub(super) fn goes_on() -> bool {
    let is_over = watched(|watch| {
        let is_over = watch.is_enough.load(Ordering::Relaxed) && !watch.held().is_empty();
        if is_over {
            watch.has_ended.store(true, Ordering::Relaxed);
        }
        is_over
    });
    !is_over.unwrap_or(false)
}

/// A plan that a search answers with wherever it ends, for as long as this lives.
#[derive(Debug)]
pub struct HeldPlan {
    /// How many searches around this one hold a plan.
    depth: usize,
}

impl HeldPlan {
    /// Begins to hold a plan; `cost` says what it costs, and what is known of the least cost.
    pub fn begin(cost: impl FnOnce() -> String) -> HeldPlan {
        let depth = watched(|watch| {
            let mut held = watch.held();
            held.push(cost());
            held.len() - 1
        });
        HeldPlan { depth: depth.unwrap_or(0) }
    }

    /// Holds a better plan, or knows more of the least cost.
    pub fn improve(&self, cost: impl FnOnce() -> String) {
        watched(|watch| {
            if let Some(held) = watch.held().get_mut(self.depth) {
                *held = cost();
            }
        });
    }
}

impl Drop for HeldPlan {
    fn drop(&mut self) {
        watched(|watch| watch.held().truncate(self.depth));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::search::{Meter, SearchBudget};

    #[test]
    fn a_search_ends_early_only_with_a_plan() {
        let watch = Arc::new(SearchWatch::default());
        let steps_of = |meter: &mut Meter| std::iter::from_fn(|| meter.step()).count() as u64;
        let budget = SearchBudget::of(3 * BEAT_STEPS);
        watch.over(|| {
            let mut meter = Meter::new(budget);
            assert_eq!(meter.step(), Some(()));
            let held = HeldPlan::begin(|| "41 steps".to_owned());
            watch.take_what_is_held();
            assert_eq!(steps_of(&mut meter), BEAT_STEPS - 1);
            assert!(has_ended_early());
            assert_eq!((meter.left().steps, meter.spent()), (0, BEAT_STEPS));
            // Nor does a search within another one, which then ends too.
            let mut outer = Meter::new(budget);
            assert_eq!(outer.share(BEAT_STEPS, steps_of), 0);
            assert_eq!(outer.left().steps, 0);
            assert_eq!(watch.news().best.as_deref(), Some("41 steps"));
            drop(held);
            begin_run();
            assert_eq!(steps_of(&mut Meter::new(budget)), 3 * BEAT_STEPS);
            assert!(!has_ended_early());
        });
        let _held = HeldPlan::begin(|| "unwatched".to_owned());
        assert_eq!(steps_of(&mut Meter::new(budget)), 3 * BEAT_STEPS);
    }

    #[test]
    fn plans_are_held_one_within_the_other() {
        let watch = Arc::new(SearchWatch::default());
        watch.over(|| {
            let outer = HeldPlan::begin(|| "outer".to_owned());
            let inner = HeldPlan::begin(|| "inner".to_owned());
            outer.improve(|| "better".to_owned());
            assert_eq!(watch.news().best.as_deref(), Some("inner"));
            drop(inner);
            assert_eq!(watch.news().best.as_deref(), Some("better"));
        });
    }
}
