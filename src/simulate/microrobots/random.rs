//! A small generator of random numbers: SplitMix64, begun anew for every trial.
//!
//! Source: Steele, Lea, Flood, *Fast splittable pseudorandom number generators*, OOPSLA 2014; the constants are those of its
//! reference implementation.

/// A stream of numbers that depends on a seed and a trial alone.
#[derive(Debug, Clone)]
pub struct TrialRandom(u64);

impl TrialRandom {
    pub fn new(seed: u64, trial: u64) -> Self {
        let mut random = TrialRandom(seed);
        let begin = random.bits();
        TrialRandom(begin ^ trial.wrapping_mul(0xD134_2543_DE82_EF95))
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ (mixed >> 31)
    }

    /// From 0 to 1, the latter left out.
    pub fn share(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// From -1 to 1.
    pub fn either(&mut self) -> f64 {
        2.0 * self.share() - 1.0
    }

    /// -1, 0 or 1.
    pub fn sign(&mut self) -> f64 {
        [-1.0, 0.0, 1.0][(self.bits() % 3) as usize]
    }
}
