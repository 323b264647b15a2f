//! Random numbers for tests and benchmarks, including the crate's own tests.

#![allow(dead_code, reason = "each test uses the part that it needs")]

use tweeze::random::SplitMix64;

/// A random stream whose draws are remainders; exact counts in tests depend on this.
pub struct Random(SplitMix64);

/// Number of random cases of a test; `TWEEZE_ORACLE_CASES` overrides it.
pub fn cases<T: std::str::FromStr>(usual: T) -> T {
    std::env::var("TWEEZE_ORACLE_CASES").ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
}

impl Random {
    /// The stream with a seed.
    pub fn new(seed: u64) -> Random {
        Random(SplitMix64::new(seed))
    }

    /// The next number.
    pub fn next(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// A number below `n`.
    pub fn below(&mut self, n: u32) -> u32 {
        (self.next() % u64::from(n)) as u32
    }

    /// The index of one of `count` items.
    pub fn index(&mut self, count: usize) -> usize {
        (self.next() % count as u64) as usize
    }

    /// One of the items.
    pub fn pick<T: Copy>(&mut self, items: &[T]) -> T {
        items[self.index(items.len())]
    }

    /// True with a probability in percent.
    pub fn chance(&mut self, percent: u32) -> bool {
        self.below(100) < percent
    }

    /// A number in 0..1, excluding 1.
    pub fn unit(&mut self) -> f64 {
        self.0.unit()
    }

    /// A number in `low..high`.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + self.unit() * (high - low)
    }

    /// A multiple of 0.001 in `from..to`, so that its text is exact.
    pub fn thousandths(&mut self, from: f64, to: f64) -> f64 {
        let steps = ((to - from) * 1000.0) as u32;
        ((from * 1000.0).round() + f64::from(self.below(steps.max(1)))) / 1000.0
    }
}
