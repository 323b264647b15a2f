//! Random legs and random changes of legs, for local searches of initial legs.

use super::Leg;
use super::world::CollisionWorld;
use crate::random::SplitMix64;

/// Largest change of a leg, in micrometres, the factor from one scale to the next, and the number of scales.
const CHANGE_UM: f64 = 1_600.0;
const SCALE_SHARE: f64 = 0.3;
const SCALES: usize = 4;

/// Legs shorter than this are left out, in micrometres.
const SHORTEST_UM: f64 = 2.0;

/// The legs that a bed allows.
pub struct LegChanges {
    /// Control states that keep the arms of docked robots up.
    states: Vec<usize>,
    /// Path of the fastest robot in one stroke.
    step_um: f64,
}

impl LegChanges {
    /// Changes for a bed with these docked robots; `None` if there is nothing to move.
    pub fn new(world: &CollisionWorld, docked: &[bool]) -> Option<LegChanges> {
        let (states, step_um): (Vec<usize>, f64) =
            (world.allowed_states(docked).collect(), world.fastest_step_um(docked));
        (step_um > 0.0 && !states.is_empty()).then_some(LegChanges { states, step_um })
    }

    /// Number of control states.
    pub fn state_count(&self) -> usize {
        self.states.len()
    }

    /// Path of the fastest robot in one stroke.
    pub fn step_um(&self) -> f64 {
        self.step_um
    }

    /// A random leg; short ones are more likely.
    pub fn leg(&self, random: &mut SplitMix64) -> Leg {
        let state = self.states[random.below(self.states.len())];
        let way_um = CHANGE_UM * random.unit() * random.unit();
        Leg { state, strokes: (way_um / self.step_um) as u64 + 1 }
    }

    /// One random change; the legs are not tidy after it.
    pub fn change(&self, legs: &mut Vec<Leg>, random: &mut SplitMix64) {
        if legs.is_empty() {
            return legs.push(self.leg(random));
        }
        let at = random.below(legs.len());
        match random.below(8) {
            0 | 1 => legs.insert(random.below(legs.len() + 1), self.leg(random)),
            2 => {
                legs.remove(at);
            }
            3 => legs[at].state = self.states[random.below(self.states.len())],
            4 => {
                let (other, strokes) = (random.below(legs.len()), self.some_strokes(random));
                let moved = strokes.clamp(-(legs[at].strokes as i64), legs[other].strokes as i64);
                legs[at].strokes = legs[at].strokes.saturating_add_signed(moved);
                legs[other].strokes = legs[other].strokes.saturating_add_signed(-moved);
            }
            _ => legs[at].strokes = legs[at].strokes.saturating_add_signed(self.some_strokes(random)),
        }
    }

    /// Leaves out short legs and merges consecutive ones of the same state.
    pub fn tidy(&self, legs: &mut Vec<Leg>) {
        let least = ((SHORTEST_UM / self.step_um) as u64).max(1);
        legs.retain(|leg| leg.strokes >= least);
        merge_equal(legs);
    }

    /// Random number of strokes of either sign, on one of several scales.
    fn some_strokes(&self, random: &mut SplitMix64) -> i64 {
        let scale = (0..random.below(SCALES)).fold(1.0, |scale, _| scale * SCALE_SHARE);
        (random.signed_unit() * scale * CHANGE_UM / self.step_um) as i64
    }
}

/// Merges consecutive legs of the same state.
pub fn merge_equal(legs: &mut Vec<Leg>) {
    legs.dedup_by(|later, earlier| {
        let is_same = later.state == earlier.state;
        if is_same {
            earlier.strokes = earlier.strokes.saturating_add(later.strokes);
        }
        is_same
    });
}
