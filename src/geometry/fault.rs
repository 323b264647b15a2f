//! Fault injection into shared measurements: tests check that the verifier, which has its own measurements, notices
//! the faults.
//!
//! Input: the result of a measurement. Output: the same number. Promise: only tests can change one, and only in their
//! own thread.

/// A measurement that a test can falsify.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fault {
    /// `geometry::distance`: between the area swept by a body and the core of an obstacle.
    Distance,
    /// `geometry::shape`: the radius of a grown shape.
    Grown,
    /// `geometry::shape`: the x coordinate of a shape's position.
    Place,
    /// `device::dimibot`: growth of obstacles.
    Growth,
    /// `device::dimibot`: distance between neighbouring cells.
    Pitch,
    /// `geometry::outline`: the distance of a point from an outline.
    Outline,
    /// `geometry::outline`: the x coordinate of a point of an outline.
    OutlinePoint,
    /// `geometry::outline`: the direction of a normal.
    Normal,
    /// `geometry::outline`: the perimeter.
    Perimeter,
    /// `geometry::outline`: rotation of a part while a tip rolls along a path.
    Rolled,
    /// `geometry::outline`: path rolled by a tip while a part rotates.
    WayRolled,
    /// `device::fingers`: the force that pulls a tip off.
    Sticking,
    /// `device::fingers`: distance from a contact within which tips move slowly.
    Slow,
    /// `device::fingers`: the nominal rotation step.
    Step,
    /// `device::microrobots`: distance that one stroke moves a robot.
    Stroke,
    /// Verifier: distance between bodies.
    JudgedDistance,
    /// Verifier: the x coordinate of an obstacle's position.
    JudgedPlace,
    /// Verifier: the distance of a point from an outline.
    JudgedOutline,
    /// Verifier: the direction of a normal.
    JudgedNormal,
    /// Verifier: rotation of a part while a tip rolls along a path.
    JudgedRoll,
}

/// The result of a measurement, unchanged outside of tests.
#[cfg(not(test))]
#[inline(always)]
pub(crate) const fn inject(_: Fault, number: f64) -> f64 {
    number
}

#[cfg(test)]
pub(crate) use switch::{Wrong, inject, with};

#[cfg(test)]
mod switch {
    use super::Fault;
    use std::cell::Cell;

    /// A factor, and an offset that is added after it.
    pub(crate) type Wrong = [f64; 2];

    thread_local! {
        static ON: Cell<Option<(Fault, Wrong)>> = const { Cell::new(None) };
    }

    pub(crate) fn inject(fault: Fault, number: f64) -> f64 {
        match ON.get() {
            Some((on, [factor, more])) if on == fault => number * factor + more,
            Some(_) | None => number,
        }
    }

    /// Calls `run` while a measurement is falsified in this thread.
    pub(crate) fn with<T>(fault: Fault, wrong: Wrong, run: impl FnOnce() -> T) -> T {
        struct Off;
        impl Drop for Off {
            fn drop(&mut self) {
                ON.set(None);
            }
        }
        let _off = Off;
        ON.set(Some((fault, wrong)));
        run()
    }
}
