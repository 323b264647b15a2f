use super::{Edit, each_alone, only, passes, rules};
use crate::check::claims::fingers::Action;
use crate::device::fingers::{Adhesion, Plane};
use crate::schedule::{Schedule, State};
use crate::verify::{Rule, Verdict, verify};
use build::*;

mod build;

/// Two fingers take the bead and roll it, the third one takes the place of the second, and it is carried and released.
fn day() -> Day {
    Day::new(order())
        .step(Action::Grasp(Some(vec![1, 38, 0])))
        .come(0, 1)
        .come(1, 38)
        .record()
        .rotate(Plane::Xy, 3)
        .roll(2)
        .come(2, 28)
        .counted()
        .record()
        .roll(1)
        .go(1)
        .counted()
        .record()
        .step(Action::Translate([5.0, -3.0, 2.0]))
        .carry([5.0, -3.0, 2.0])
        .step(Action::Wait(7 * MS))
        .still(7 * MS)
        .step(Action::Release)
        .go(0)
        .go(2)
        .record()
}

#[test]
fn the_day_is_sound() {
    let (schedule, claims) = day().both();
    passes(&schedule, &claims);
}
