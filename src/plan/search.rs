//! Result and budget of a search, shared by all planners. Budgets count steps, never time, so that a plan does not
//! depend on the machine.

use super::watch::{self, BEAT_STEPS};

/// Result of a search. An empty plan never means "no", and a search that ended early proves nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SearchAnswer<P, I, G = GaveUp> {
    /// A plan, with a lower bound on the cost of any plan.
    Found(P),
    /// Proven: there is no plan, and why.
    Impossible(I),
    /// A limit ended the search before a plan or a proof was found, with the bounds known by then.
    GaveUp(G),
}

/// Number of steps a planner may take before it gives up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SearchBudget {
    /// Number of steps. Each planner documents what one step is.
    pub steps: u64,
}

impl SearchBudget {
    /// Enough for every scene of the benchmarks; a few seconds and some hundred megabytes at most.
    pub const DEFAULT: SearchBudget = SearchBudget { steps: 16_000_000 };

    /// A budget of `steps` steps.
    pub const fn of(steps: u64) -> Self {
        SearchBudget { steps }
    }
}

impl Default for SearchBudget {
    fn default() -> Self {
        SearchBudget::DEFAULT
    }
}

/// A budget ran out before a plan or a proof was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GaveUp {
    /// The budget that was given.
    pub budget: SearchBudget,
    /// Steps spent.
    pub spent: u64,
    /// Lower bound on the cost of any plan, in the units of the objective.
    pub bound: u64,
}

/// Counts steps against a budget and reports them to the watch on the search.
#[derive(Debug)]
pub struct Meter {
    budget: SearchBudget,
    spent: u64,
    /// Number of steps up to which neither the budget nor the watch is checked.
    free: u64,
    /// Steps that the watch knows of, including those charged from other meters.
    reported: u64,
}

impl Meter {
    /// A meter that has spent nothing.
    pub const fn new(budget: SearchBudget) -> Self {
        Meter { budget, spent: 0, free: 0, reported: 0 }
    }

    /// Takes one step; `None` if none is left.
    #[inline]
    pub fn step(&mut self) -> Option<()> {
        if self.spent >= self.free {
            self.go_on()?;
        }
        self.spent += 1;
        Some(())
    }

    /// Frees further steps from checks; `None` if the search must end.
    #[cold]
    fn go_on(&mut self) -> Option<()> {
        if !self.is_wanted() || self.spent >= self.budget.steps {
            return None;
        }
        self.free = self.budget.steps.min(self.spent.saturating_add(BEAT_STEPS));
        Some(())
    }

    /// Reports new steps to the watch. If the watch ends the search, returns `false` and leaves no step.
    fn is_wanted(&mut self) -> bool {
        watch::report_steps(self.spent - self.reported);
        self.reported = self.spent;
        let may_continue = watch::may_continue();
        if !may_continue {
            self.budget = SearchBudget::of(self.spent);
            self.free = self.spent;
        }
        may_continue
    }

    /// Charges `steps` steps at once; the last of them may overdraw the budget.
    #[inline]
    pub fn charge(&mut self, steps: u64) {
        self.spent = self.spent.saturating_add(steps);
        if self.spent >= self.free {
            self.go_on();
        }
    }

    /// Charges the steps of a search that had a meter of its own.
    pub fn charge_metered(&mut self, steps: u64) {
        self.spent = self.spent.saturating_add(steps);
        self.reported = self.reported.saturating_add(steps);
        self.is_wanted();
    }

    /// Runs a search on at most `steps` of the remaining steps, and charges the steps it took.
    pub fn share<T>(&mut self, steps: u64, search: impl FnOnce(&mut Meter) -> T) -> T {
        let mut part = Meter::new(SearchBudget::of(steps.min(self.left().steps)));
        let result = search(&mut part);
        self.charge_metered(part.spent());
        result
    }

    /// Steps taken so far.
    pub const fn spent(&self) -> u64 {
        self.spent
    }

    /// The budget that is left.
    pub const fn left(&self) -> SearchBudget {
        SearchBudget::of(self.budget.steps.saturating_sub(self.spent))
    }

    /// Report of a budget that ran out; no plan can cost less than `bound`.
    pub const fn gave_up(&self, bound: u64) -> GaveUp {
        GaveUp { budget: self.budget, spent: self.spent, bound }
    }
}

impl Drop for Meter {
    fn drop(&mut self) {
        watch::report_steps(self.spent - self.reported);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_meter_stops_exactly_at_its_budget() {
        let mut meter = Meter::new(SearchBudget::of(2));
        assert_eq!((meter.step(), meter.step()), (Some(()), Some(())));
        assert_eq!(meter.step(), None);
        assert_eq!(meter.gave_up(7).spent, 2);
    }
}
