//! Elementary functions of real numbers that give the same bits on every platform.
//!
//! The functions of the standard library call whatever mathematics library the platform links, and these differ in
//! the last digits; a plan, a file or a verdict that depends on such a digit would differ too. These functions come
//! from the pure-Rust `libm`, and `clippy.toml` forbids the others. Arithmetic, square roots and rounding are exact
//! by IEEE 754 and stay as they are.

/// Elementary functions; angles are in radians.
pub trait Real {
    fn sine(self) -> f64;
    fn cosine(self) -> f64;
    /// Sine and cosine.
    fn sine_cosine(self) -> (f64, f64);
    /// In -π/2 to π/2; NaN outside of -1 to 1.
    fn arc_sine(self) -> f64;
    /// The angle of the point (`x`, `self`), in -π to π.
    fn arc_tangent_over(self, x: f64) -> f64;
    /// The length of the hypotenuse over two legs, without intermediate overflow.
    fn hypotenuse(self, other: f64) -> f64;
    /// e to the power of `self`.
    fn exponential(self) -> f64;
    fn natural_logarithm(self) -> f64;
    /// The natural logarithm of 1 + `self`, accurate near 0.
    fn natural_logarithm_of_one_plus(self) -> f64;
    /// The logarithm to base 10.
    fn common_logarithm(self) -> f64;
    fn power(self, exponent: f64) -> f64;
    /// By repeated squaring; the reciprocal is taken last.
    fn whole_power(self, exponent: i32) -> f64;
}

impl Real for f64 {
    fn sine(self) -> f64 {
        libm::sin(self)
    }

    fn cosine(self) -> f64 {
        libm::cos(self)
    }

    fn sine_cosine(self) -> (f64, f64) {
        libm::sincos(self)
    }

    fn arc_sine(self) -> f64 {
        libm::asin(self)
    }

    fn arc_tangent_over(self, x: f64) -> f64 {
        libm::atan2(self, x)
    }

    fn hypotenuse(self, other: f64) -> f64 {
        libm::hypot(self, other)
    }

    fn exponential(self) -> f64 {
        libm::exp(self)
    }

    fn natural_logarithm(self) -> f64 {
        libm::log(self)
    }

    fn natural_logarithm_of_one_plus(self) -> f64 {
        libm::log1p(self)
    }

    fn common_logarithm(self) -> f64 {
        libm::log10(self)
    }

    fn power(self, exponent: f64) -> f64 {
        libm::pow(self, exponent)
    }

    fn whole_power(self, exponent: i32) -> f64 {
        let (mut square, mut left, mut product) = (self, exponent.unsigned_abs(), 1.0);
        while left > 0 {
            if left % 2 == 1 {
                product *= square;
            }
            square *= square;
            left /= 2;
        }
        if exponent < 0 { 1.0 / product } else { product }
    }
}

#[cfg(test)]
mod tests {
    use super::Real;

    #[test]
    fn bits_are_those_of_every_platform() {
        let bits: Vec<u64> = [
            0.7.sine(),
            0.7.cosine(),
            1e5.sine_cosine().0,
            0.3.arc_sine(),
            0.3.arc_tangent_over(-0.8),
            0.3.hypotenuse(0.8),
            0.3.exponential(),
            0.3.natural_logarithm(),
            1e-9.natural_logarithm_of_one_plus(),
            0.3.common_logarithm(),
            0.3.power(1.7),
        ]
        .map(f64::to_bits)
        .to_vec();
        insta::assert_debug_snapshot!(bits);
    }

    #[test]
    fn whole_powers_are_products() {
        assert_eq!(3.0.whole_power(4), 81.0);
        assert_eq!(10.0.whole_power(0), 1.0);
        assert_eq!(2.0.whole_power(-3), 0.125);
    }
}
