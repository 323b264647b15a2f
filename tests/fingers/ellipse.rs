//! An ellipse for the brute force: integrated at many angles, with its contacts.

use crate::case::Case;
use std::f64::consts::TAU;

/// An ellipse with contacts.
pub struct Section {
    pub semi_um: [f64; 2],
    /// Angle by which the part has turned when a tip has rolled to each of the sampled angles of the ellipse.
    rolled_rad: Vec<f64>,
    pub contacts: usize,
    pub step_rad: f64,
}

/// Number of sampled angles.
const SAMPLES: usize = 200_000;

impl Section {
    pub fn of(case: &Case, semi_um: [f64; 2]) -> Section {
        let [a, b] = semi_um;
        let mut rolled_rad = vec![0.0];
        let (mut way_um, mut laps) = (0.0, 0.0);
        let normal = |t: f64| (t.sin() / b).atan2(t.cos() / a);
        let mut last = 0.0;
        for k in 1..=SAMPLES {
            let middle = TAU * (k as f64 - 0.5) / SAMPLES as f64;
            way_um += (a * middle.sin()).hypot(b * middle.cos()) * TAU / SAMPLES as f64;
            let mut turned = normal(TAU * k as f64 / SAMPLES as f64) + laps;
            if turned < last - 1.0 {
                laps += TAU;
                turned += TAU;
            }
            last = turned;
            rolled_rad.push(turned + way_um / case.tip_radius_um);
        }
        let once_rad = rolled_rad[SAMPLES];
        let exact = once_rad / (TAU / f64::from(case.steps_per_turn));
        // With an even number of contacts, one is opposite to the first.
        let contacts = (0..10_i32).map(|k| exact.round() + f64::from((k + 1) / 2 * if k % 2 == 0 { 1 } else { -1 }));
        let mut even: Vec<f64> = contacts.filter(|count| count % 2.0 == 0.0).collect();
        even.sort_by(|one, other| (one - exact).abs().total_cmp(&(other - exact).abs()));
        Section { semi_um, contacts: even[0] as usize, step_rad: once_rad / even[0], rolled_rad }
    }

    /// Point and outward normal at a contact, from 0; fractional contacts are allowed.
    pub fn touch(&self, contact: f64) -> Touch {
        let once_rad = self.rolled_rad[SAMPLES];
        let wanted = (contact * self.step_rad).rem_euclid(once_rad);
        let after = self.rolled_rad.partition_point(|rolled| *rolled <= wanted).clamp(1, SAMPLES);
        let [low, high] = [self.rolled_rad[after - 1], self.rolled_rad[after]];
        let t = TAU * ((after - 1) as f64 + (wanted - low) / (high - low)) / SAMPLES as f64;
        let [a, b] = self.semi_um;
        let normal = [t.cos() / a, t.sin() / b];
        let size = normal[0].hypot(normal[1]);
        Touch { at_um: [a * t.cos(), b * t.sin()], normal: normal.map(|part| part / size) }
    }
}

#[derive(Debug, Clone, Copy)]
pub struct Touch {
    pub at_um: [f64; 2],
    pub normal: [f64; 2],
}
