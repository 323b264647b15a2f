use super::*;
use proptest::prelude::*;

fn p(x: f64, y: f64) -> Point2<f64> {
    Point2::new(x, y)
}
