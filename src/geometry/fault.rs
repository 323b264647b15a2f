//! Faults put into shared measures on purpose: the tests see whether the verifier, which has measures of its own, notices them.
//!
//! Input: a number that a measure gives. Output: the same number. Promise: only tests can change one, and only in their own thread.

/// A measure that can be put wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fault {
    /// `geometry::distance`: between the area swept by a body and the core of an obstacle.
    Distance,
    /// `geometry::shape`: the radius of a grown shape.
    Grown,
    /// `geometry::shape`: the x coordinate of a shape's place.
    Place,
    /// `device::dimibot`: growth of obstacles.
    Growth,
    /// `device::dimibot`: from a cell to the next one.
    Pitch,
    /// `geometry::outline`: the distance of a point from an outline.
    Outline,
    /// `geometry::outline`: the x coordinate of a place on an outline.
    Spot,
    /// `geometry::outline`: the direction of a normal.
    Normal,
    /// `geometry::outline`: the perimeter.
    Perimeter,
    /// `geometry::outline`: turn of a part while a tip rolls along a path.
    Rolled,
    /// `geometry::outline`: path rolled by a tip while a part turns.
    WayRolled,
    /// `device::fingers`: the force that pulls a tip off.
    Sticking,
    /// `device::fingers`: distance from a contact within which tips are slow.
    Slow,
    /// `device::fingers`: the nominal step of rotation.
    Step,
    /// `device::microrobots`: distance that a stroke carries a robot.
    Stroke,
    /// Verifier: distance between bodies.
    JudgedDistance,
    /// Verifier: the x coordinate of an obstacle's place.
    JudgedPlace,
    /// Verifier: the distance of a point from an outline.
    JudgedOutline,
    /// Verifier: the direction of a normal.
    JudgedNormal,
    /// Verifier: turn of a part while a tip rolls along a path.
    JudgedRoll,
}

/// The result of a measure, unchanged outside of tests.
#[cfg(not(test))]
#[inline(always)]
pub(crate) const fn through(_: Fault, number: f64) -> f64 {
    number
}

#[cfg(test)]
pub(crate) use switch::{Wrong, through, with};

#[cfg(test)]
mod switch {
    use super::Fault;
    use std::cell::Cell;

    /// A factor, and an offset added after it.
    pub(crate) type Wrong = [f64; 2];

    thread_local! {
        static ON: Cell<Option<(Fault, Wrong)>> = const { Cell::new(None) };
    }

    pub(crate) fn through(fault: Fault, number: f64) -> f64 {
        match ON.get() {
            Some((on, [factor, more])) if on == fault => number * factor + more,
            Some(_) | None => number,
        }
    }

    /// Runs something while a measure of this thread is wrong.
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
