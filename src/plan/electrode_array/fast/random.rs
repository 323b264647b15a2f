//! The little generator behind every random choice of the fast planner: splitmix64, so that a seed means the same plan on each
//! machine.

/// A stream of numbers that its seed determines.
#[derive(Debug, Clone)]
pub struct PlannerRandom(u64);

impl PlannerRandom {
    pub fn new(seed: u64) -> PlannerRandom {
        PlannerRandom(seed)
    }

    /// The next number of the stream.
    #[inline]
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// A number below `count`, which is at least 1.
    #[inline]
    pub fn below(&mut self, count: usize) -> usize {
        ((u128::from(self.next()) * count as u128) >> 64) as usize
    }

    /// Fisher and Yates: every order is as likely as every other.
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.below(last + 1));
        }
    }
}
