//! The paper's estimate of the remaining reconfigurations (its Table 1), corrected and extended.
//!
//! Each finger is classified by whether it holds now and at the goal: in neither (nu), in one of them (ar), in both and
//! it rolls from here to there (dp), in both and it does not (ip). The count is 2·ip + ar, plus 2 if the same two
//! fingers hold now and at the goal and one of them is ip. It is admissible: an ip finger must leave and come back, an
//! ar finger must come or leave; and if only two fingers hold, neither can leave before a third one comes, which must
//! leave again. With three fingers this is the paper's table, where the last case reads "one is nu", which is
//! equivalent for three fingers only. The paper does not compare contacts modulo their number, which makes some counts
//! too large; here phases are compared.
//!
//! One placement or removal changes the class of one finger by one step (ip to ar, ar to dp or nu, or back), and so the
//! sum by one. Its effect on the case of the same two fingers is compensated by the sum (checked on all classes in the
//! tests). So the estimate is consistent. If a leg may end with several grasps, the estimate is the minimum over them,
//! each with the remaining reconfigurations from there.

use super::course::PreparedRoute;
use super::layout::{NodeSpot, Sets};
use super::walk::{Estimate, NEVER};

/// A grasp with which a leg may end.
#[derive(Debug, Clone, Copy)]
struct EndGrasp {
    set: u8,
    /// Phases in this leg.
    phases: [u16; 3],
    /// Remaining reconfigurations from there.
    rest: u32,
}

/// The estimate for one route.
#[derive(Debug)]
pub struct Published<'a> {
    course: &'a PreparedRoute,
    /// For each leg the target grasps; `None` if any is allowed.
    goals: Vec<Option<Vec<EndGrasp>>>,
}

impl<'a> Published<'a> {
    /// Derives the targets of all legs, from the last to the first.
    pub fn of(course: &'a PreparedRoute) -> Self {
        let mut published = Published { course, goals: vec![None; course.legs.len()] };
        for leg in (0..course.legs.len()).rev() {
            published.goals[leg] = published.aims(leg);
        }
        published
    }

    fn aims(&self, leg: usize) -> Option<Vec<EndGrasp>> {
        let course = self.course;
        let prepared = &course.legs[leg];
        let goal = |spot: NodeSpot| {
            let rest = if course.is_goal(spot) { 0 } else { self.gaits(course.next(spot)?) };
            Some(EndGrasp { set: spot.chain.set, phases: spot.chain.phases, rest }).filter(|goal| goal.rest != NEVER)
        };
        if let Some(ends) = course.few_ends(leg) {
            return Some(ends.into_iter().filter_map(goal).collect());
        }
        // The next leg is in the same plane. Converts one of its phases to this leg: the contact at the border is the same.
        let next = course.legs.get(leg + 1)?;
        let carried = |phase: u16| prepared.phase(prepared.end, next.contact(next.start, phase));
        let goals = self.goals[leg + 1].as_ref()?.iter();
        Some(goals.map(|goal| EndGrasp { phases: goal.phases.map(carried), ..*goal }).collect())
    }
}

impl Estimate for Published<'_> {
    fn gaits(&self, spot: NodeSpot) -> u32 {
        let Some(goals) = &self.goals[spot.leg] else { return 0 };
        self.course.looks.take(goals.len() as u64);
        let count = |goal: &EndGrasp| {
            reconfigurations(&self.course.sets, (spot.chain.set, spot.chain.phases), (goal.set, goal.phases))
                + goal.rest
        };
        goals.iter().map(count).min().unwrap_or(NEVER)
    }

    fn is_settled(&self, _spot: NodeSpot) -> bool {
        true
    }

    fn deepen(&mut self) {}
}

/// Estimated placements and removals between two chains of a leg, each a set of fingers and their phases.
pub fn reconfigurations(sets: &Sets, now: (u8, [u16; 3]), goal: (u8, [u16; 3])) -> u32 {
    let (here, there) = (sets.members(now.0), sets.members(goal.0));
    let (mut both, mut blocked) = (0, 0);
    for (finger, phase) in here.iter().zip(now.1) {
        if let Some(at) = there.iter().position(|other| other == finger) {
            both += 1;
            blocked += u32::from(goal.1[at] != phase);
        }
    }
    let changing = (here.len() + there.len()) as u32 - 2 * both;
    let needs_help = blocked > 0 && changing == 0 && here.len() == 2;
    2 * blocked + changing + if needs_help { 2 } else { 0 }
}
