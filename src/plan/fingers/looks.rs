//! The work of the searches of one task, counted in looks at grasps: never in time, so that a plan does not depend on the machine.

use std::cell::Cell;

/// How many looks may still be taken. One look is a chain of grasps held against one third contact, or a grasp against a condition of
/// its balance: some tens of nanoseconds.
#[derive(Debug)]
pub struct LooksBudget {
    left: Cell<u64>,
    held_back: Cell<u64>,
}

impl LooksBudget {
    /// So many.
    pub fn of(most: u64) -> LooksBudget {
        LooksBudget { left: Cell::new(most), held_back: Cell::new(0) }
    }

    /// Takes some; the last ones may overdraw what is left.
    #[inline]
    pub fn take(&self, looks: u64) {
        self.left.set(self.left.get().saturating_sub(looks));
    }

    /// Whether none are left: what is known by then is all that will be known.
    #[inline]
    pub fn are_spent(&self) -> bool {
        self.left.get() == 0
    }

    /// Keeps a half of those that are left for later, until [`LooksBudget::give_back`].
    pub fn hold_half_back(&self) {
        let half = self.left.get() / 2;
        self.take(half);
        self.held_back.set(self.held_back.get() + half);
    }

    /// What was held back may be taken again.
    pub fn give_back(&self) {
        self.left.set(self.left.get().saturating_add(self.held_back.take()));
    }
}

impl Default for LooksBudget {
    /// Without an end.
    fn default() -> LooksBudget {
        LooksBudget::of(u64::MAX)
    }
}
