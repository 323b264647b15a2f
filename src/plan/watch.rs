//! Observation of a running search: its steps, the cost of its best plan so far, and the request to accept that plan.
//!
//! A [`SearchWatch`] is shared between the planning thread and an observer. Searches report to it through their
//! [`Meter`]s, once per [`BEAT_STEPS`] steps, and hold an [`IncumbentPlan`] for as long as they would return a plan if
//! they ended now. Once the observer accepts the best known plan, every meter reports that no step is left, but only
//! while a plan is held. A search then ends as if its budget were spent, and claims no more about its plan than in that
//! case. Without a watch, as in tests, nothing is reported and nothing ends early.
//!
//! [`Meter`]: super::search::Meter

use std::cell::RefCell;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Steps of a meter between two checks of its watch: less than a millisecond in most searches.
pub const BEAT_STEPS: u64 = 4096;

thread_local! {
    static WATCHED_BY: RefCell<Option<Arc<SearchWatch>>> = const { RefCell::new(None) };
}

/// Progress of the searches of one thread and of those that help it, and the request that they end.
#[derive(Debug, Default)]
pub struct SearchWatch {
    steps: AtomicU64,
    is_accepted: AtomicBool,
    /// Whether a search has ended because of that request.
    has_ended: AtomicBool,
    /// Costs, in words, of the plans that searches hold; those of inner searches come last.
    incumbents: Mutex<Vec<String>>,
}

/// Progress of a search.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SearchProgress {
    /// Steps since the planning of the current job began.
    pub steps: u64,
    /// Cost of the best plan and the known lower bound, in words.
    pub best: Option<String>,
}

impl SearchWatch {
    /// Watches the searches that `plan` runs on this thread.
    pub fn over<T>(self: &Arc<Self>, plan: impl FnOnce() -> T) -> T {
        /// Restores the former watch, also after a panic.
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

    /// Progress of the running search.
    pub fn progress(&self) -> SearchProgress {
        SearchProgress { steps: self.steps.load(Ordering::Relaxed), best: self.incumbents().last().cloned() }
    }

    /// From now on, the first plan of each search is accepted.
    pub fn accept_incumbent(&self) {
        self.is_accepted.store(true, Ordering::Relaxed);
    }

    fn incumbents(&self) -> MutexGuard<'_, Vec<String>> {
        // A thread that panicked leaves the list intact.
        self.incumbents.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn watched<T>(read: impl FnOnce(&SearchWatch) -> T) -> Option<T> {
    WATCHED_BY.with_borrow(|watch| watch.as_deref().map(read))
}

/// The watch over the searches of this thread.
pub(super) fn current() -> Option<Arc<SearchWatch>> {
    WATCHED_BY.with_borrow(Clone::clone)
}

/// Resets the progress for the next job.
pub(super) fn begin_run() {
    watched(|watch| {
        watch.steps.store(0, Ordering::Relaxed);
        watch.has_ended.store(false, Ordering::Relaxed);
        watch.incumbents().clear();
    });
}

/// Whether a search of the current job has ended early because its plan was accepted.
pub(super) fn has_ended_early() -> bool {
    watched(|watch| watch.has_ended.load(Ordering::Relaxed)).unwrap_or(false)
}

/// Reports further steps.
pub(super) fn report_steps(steps: u64) {
    watched(|watch| watch.steps.fetch_add(steps, Ordering::Relaxed));
}

/// Whether the search may continue.
pub(super) fn may_continue() -> bool {
    let is_over = watched(|watch| {
        let is_over = watch.is_accepted.load(Ordering::Relaxed) && !watch.incumbents().is_empty();
        if is_over {
            watch.has_ended.store(true, Ordering::Relaxed);
        }
        is_over
    });
    !is_over.unwrap_or(false)
}

/// A plan that a search returns wherever it ends, for as long as this lives.
#[derive(Debug)]
pub struct IncumbentPlan {
    /// Number of enclosing searches that hold a plan.
    depth: usize,
}

impl IncumbentPlan {
    /// Begins to hold a plan; `cost` gives its cost and the known lower bound, in words.
    pub fn begin(cost: impl FnOnce() -> String) -> IncumbentPlan {
        let depth = watched(|watch| {
            let mut held = watch.incumbents();
            held.push(cost());
            held.len() - 1
        });
        IncumbentPlan { depth: depth.unwrap_or(0) }
    }

    /// Updates the held plan: a better one, or a better lower bound.
    pub fn improve(&self, cost: impl FnOnce() -> String) {
        watched(|watch| {
            if let Some(held) = watch.incumbents().get_mut(self.depth) {
                *held = cost();
            }
        });
    }
}

impl Drop for IncumbentPlan {
    fn drop(&mut self) {
        watched(|watch| watch.incumbents().truncate(self.depth));
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
            let held = IncumbentPlan::begin(|| "41 steps".to_owned());
            watch.accept_incumbent();
            assert_eq!(steps_of(&mut meter), BEAT_STEPS - 1);
            assert!(has_ended_early());
            assert_eq!((meter.left().steps, meter.spent()), (0, BEAT_STEPS));
            // A nested search gets no step either, and the outer one ends with it.
            let mut outer = Meter::new(budget);
            assert_eq!(outer.share(BEAT_STEPS, steps_of), 0);
            assert_eq!(outer.left().steps, 0);
            assert_eq!(watch.progress().best.as_deref(), Some("41 steps"));
            drop(held);
            begin_run();
            assert_eq!(steps_of(&mut Meter::new(budget)), 3 * BEAT_STEPS);
            assert!(!has_ended_early());
        });
        let _held = IncumbentPlan::begin(|| "unwatched".to_owned());
        assert_eq!(steps_of(&mut Meter::new(budget)), 3 * BEAT_STEPS);
    }

    #[test]
    fn plans_are_held_one_within_the_other() {
        let watch = Arc::new(SearchWatch::default());
        watch.over(|| {
            let outer = IncumbentPlan::begin(|| "outer".to_owned());
            let inner = IncumbentPlan::begin(|| "inner".to_owned());
            outer.improve(|| "better".to_owned());
            assert_eq!(watch.progress().best.as_deref(), Some("inner"));
            drop(inner);
            assert_eq!(watch.progress().best.as_deref(), Some("better"));
        });
    }
}
