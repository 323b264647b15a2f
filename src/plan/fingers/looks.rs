//! Work of the searches of one task, counted in looks at grasps: never in time, so that a plan does not depend on the machine.

use std::cell::Cell;

/// Remaining looks. One look is one chain of grasps checked against one third contact, or one grasp against one condition of its
/// equilibrium: some tens of nanoseconds.
#[derive(Debug)]
pub struct LooksBudget {
    left: Cell<u64>,
    held_back: Cell<u64>,
}

impl LooksBudget {
    /// A budget of `most` looks.
    pub fn of(most: u64) -> LooksBudget {
        LooksBudget { left: Cell::new(most), held_back: Cell::new(0) }
    }

    /// Spends looks; the last ones may overdraw the budget.
    #[inline]
    pub fn take(&self, looks: u64) {
        self.left.set(self.left.get().saturating_sub(looks));
    }

    /// Whether none are left; the searches then settle for what they know.
    #[inline]
    pub fn are_spent(&self) -> bool {
        self.left.get() == 0
    }

    /// Reserves half of the remaining looks until [`LooksBudget::give_back`].
    pub fn hold_half_back(&self) {
        let half = self.left.get() / 2;
        self.take(half);
        self.held_back.set(self.held_back.get() + half);
    }

    /// Releases the reserved looks.
    pub fn give_back(&self) {
        self.left.set(self.left.get().saturating_add(self.held_back.take()));
    }
}

impl Default for LooksBudget {
    /// Unlimited.
    fn default() -> LooksBudget {
        LooksBudget::of(u64::MAX)
    }
}
