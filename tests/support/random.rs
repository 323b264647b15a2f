//! The random numbers of tests and benchmarks: splitmix64, so that a seed gives the same numbers on each machine.

#![allow(dead_code, reason = "each test uses the part that it needs")]

/// A source of numbers that its seed determines.
pub struct Random(pub u64);

/// How many random cases a test looks at; `TWEEZE_ORACLE_CASES` says another number.
pub fn cases<T: std::str::FromStr>(usual: T) -> T {
    std::env::var("TWEEZE_ORACLE_CASES").ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
}

impl Random {
    /// The next number.
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let a = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let b = (a ^ (a >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        b ^ (b >> 31)
    }

    /// A number below `n`.
    pub fn below(&mut self, n: u32) -> u32 {
        (self.next() % u64::from(n)) as u32
    }

    /// A number from 0 to 1.
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A number of thousandths in `from..to`, so that its text is exact.
    pub fn thousandths(&mut self, from: f64, to: f64) -> f64 {
        let steps = ((to - from) * 1000.0) as u32;
        ((from * 1000.0).round() + f64::from(self.below(steps.max(1)))) / 1000.0
    }
}
