//! Settling time: from leaving one cell until at rest on the next.
//!
//! The equation of motion is the paper's (2): m du/dt + b u = F(x), with x from the pitch to 0. The paper gives F as a
//! figure; the curve here is the simplest odd one through its known points: zero at 0, greatest at the peak distance,
//! and the table's force at the table's distance. It is solved by fourth-order Runge-Kutta with a fixed step, so that
//! every machine gets the same result.

use crate::real::Real;

/// Integration steps before giving up: about eight hundred oscillations.
const MAX_INSTANTS: usize = 1_000_000;

/// Integration steps per radian of the oscillation around the goal; the error of the fourth-order method is then
/// negligible.
const INSTANTS_PER_RADIAN: f64 = 200.0;

/// Ratio of damping rate to oscillation frequency beyond which inertia is neglected: its time constant is then below
/// 1/400 of that of the creep.
const CREEPING: f64 = 20.0;

/// Lateral force over distance: 2 F u / (1 + u²) with u the distance over that of the peak, and F the peak force.
#[derive(Debug, Clone, Copy)]
pub struct Pull {
    /// Distance between centres at which the force is greatest.
    pub peak_at_m: f64,
    /// The greatest force.
    pub peak_n: f64,
}

impl Pull {
    /// The curve through a given force at a given distance.
    pub fn through(distance_m: f64, force_n: f64, peak_at_m: f64) -> Pull {
        Pull { peak_at_m, peak_n: force_n / share(distance_m / peak_at_m) }
    }

    /// Force towards the goal at a distance from it.
    pub fn at(&self, distance_m: f64) -> f64 {
        self.peak_n * share(distance_m / self.peak_at_m)
    }

    /// Work of the force from a distance to the goal.
    fn work(&self, distance_m: f64) -> f64 {
        let u = distance_m / self.peak_at_m;
        self.peak_n * self.peak_at_m * (u * u).natural_logarithm_of_one_plus()
    }
}

fn share(u: f64) -> f64 {
    2.0 * u / (1.0 + u * u)
}

/// A part in motion from one cell to the next.
#[derive(Debug, Clone, Copy)]
pub struct Glide {
    pub pull: Pull,
    pub mass_kg: f64,
    /// Drag over speed, in N s/m.
    pub damping: f64,
    /// Distance from cell to cell.
    pub pitch_m: f64,
    /// Share of the pitch, and of the greatest speed, within which the part is at rest.
    pub rest_share: f64,
}

impl Glide {
    /// Time until place and speed stay at rest; `None` if they do not within the simulated steps.
    pub fn settling_s(&self) -> Option<f64> {
        let stiffness = 2.0 * self.pull.peak_n / self.pull.peak_at_m;
        let frequency = (stiffness / self.mass_kg).sqrt();
        let rate = self.damping / self.mass_kg;
        let is_countable = [frequency, rate].iter().all(|figure| figure.is_finite()) && frequency > 0.0 && rate > 0.0;
        if !is_countable {
            return None;
        }
        let settling_s =
            if rate > CREEPING * frequency { self.creeping_s() } else { self.swinging_s(frequency, rate)? };
        settling_s.is_finite().then_some(settling_s)
    }

    /// Settling time without inertia: the speed is F(x)/b, and the time the integral of its inverse.
    fn creeping_s(&self) -> f64 {
        let begin = self.pitch_m / self.pull.peak_at_m;
        let fastest = share(begin.min(1.0)).max(share(begin));
        let slow = self.rest_share.min(1.0) * fastest;
        let end = (self.rest_share * begin).min(slow / 2.0).min(begin);
        let scale_s = self.damping * self.pull.peak_at_m / (2.0 * self.pull.peak_n);
        scale_s * ((begin / end).natural_logarithm() + (begin * begin - end * end) / 2.0)
    }

    fn swinging_s(&self, frequency: f64, rate: f64) -> Option<f64> {
        let instant_s = 1.0 / (INSTANTS_PER_RADIAN * frequency.max(rate));
        let near_m = self.rest_share * self.pitch_m;
        let mut state = [self.pitch_m, 0.0];
        let (mut fastest, mut settled) = (0.0f64, 0);
        for instant in 1..=MAX_INSTANTS {
            state = self.after(state, instant_s);
            let [place_m, speed] = state;
            fastest = fastest.max(speed.abs());
            let slow = self.rest_share * fastest;
            if place_m.abs() > near_m || speed.abs() > slow {
                settled = instant;
            }
            // Energy only falls, so once it is below the energy at either bound, neither bound is left again.
            let energy = self.mass_kg * speed * speed / 2.0 + self.pull.work(place_m);
            if energy < self.pull.work(near_m).min(self.mass_kg * slow * slow / 2.0) {
                return Some(settled as f64 * instant_s);
            }
        }
        None
    }

    /// Place and speed one integration step later.
    fn after(&self, state: [f64; 2], instant_s: f64) -> [f64; 2] {
        let slope =
            |[place_m, speed]: [f64; 2]| [speed, -(self.pull.at(place_m) + self.damping * speed) / self.mass_kg];
        let moved = |slope: [f64; 2], time_s: f64| [state[0] + slope[0] * time_s, state[1] + slope[1] * time_s];
        let first = slope(state);
        let second = slope(moved(first, instant_s / 2.0));
        let third = slope(moved(second, instant_s / 2.0));
        let fourth = slope(moved(third, instant_s));
        let mean = [0, 1].map(|axis| (first[axis] + 2.0 * (second[axis] + third[axis]) + fourth[axis]) / 6.0);
        moved(mean, instant_s)
    }
}

#[cfg(test)]
mod tests;
