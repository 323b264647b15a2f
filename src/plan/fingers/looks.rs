//! Work of the searches of one task, counted in looks at grasps rather than in time, so that a plan does not depend on
//! the machine.

use std::cell::Cell;

/// Remaining looks. One look is one chain of grasps checked against one third contact, or one grasp against one
/// condition of its equilibrium; it takes some tens of nanoseconds.
#[derive(Debug)]
pub struct LooksBudget {
    left: Cell<u64>,
}

impl LooksBudget {
    /// A budget of `most` looks.
    pub fn of(most: u64) -> LooksBudget {
        LooksBudget { left: Cell::new(most) }
    }

    /// Spends looks; the last ones may overdraw the budget.
    #[inline]
    pub fn take(&self, looks: u64) {
        self.left.set(self.left.get().saturating_sub(looks));
    }

    /// Whether no looks are left; the searches then settle for what they know.
    #[inline]
    pub fn are_spent(&self) -> bool {
        self.left.get() == 0
    }

    /// Runs a search that may spend half of the remaining looks.
    pub fn with_half<T>(&self, search: impl FnOnce() -> T) -> T {
        let held_back = self.left.get() / 2;
        self.take(held_back);
        let answer = search();
        self.left.set(self.left.get().saturating_add(held_back));
        answer
    }
}

impl Default for LooksBudget {
    /// Unlimited.
    fn default() -> LooksBudget {
        LooksBudget::of(u64::MAX)
    }
}
