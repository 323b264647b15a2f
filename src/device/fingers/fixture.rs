//! A hand for tests.

use super::{Adhesion, FingersFacts};

/// The paper's hand, with stages of our own.
pub fn hand() -> FingersFacts {
    FingersFacts {
        fingers: 3,
        tip_radius_um: 4.5,
        adhesion: Adhesion::Sticking,
        pull_off_un: 1.5,
        max_force_un: 30.0,
        friction: 0.3,
        steps_per_turn: 18,
        removal_safety: 1.0,
        gaiting_cost_deg: 180.0,
        clearance_um: 1.0,
        retract_um: 3.0,
        speed_um_per_s: 100.0,
        approach_um_per_s: 20.0,
        rolling_um_per_s: 10.0,
        support_un: 5.0,
        range_um: [200.0; 3],
        tolerance_um: 0.05,
        torsion_um: 0.01,
        rolling_reserve: 0.02,
    }
}
