use super::shape::{Pose, Shape};
pub fn to_point_um(_: &Shape, _: &Pose, _: [f64; 2]) -> f64 {
    0.0
}
