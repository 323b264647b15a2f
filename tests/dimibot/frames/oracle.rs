//! Tip positions by independent kinematics: the area that a robot may touch at each instant, and the distance between
//! two robots.

use std::collections::BTreeMap;
use tweeze::claims::Claims;
use tweeze::claims::dimibot::DimibotOrder;
use tweeze::device::dimibot::DimibotFacts;
use tweeze::schedule::Schedule;

/// A rectangle along the axes of a robot, with the pose of that robot.
#[derive(Debug, Clone, Copy)]
struct Area {
    low: [f64; 2],
    high: [f64; 2],
    stand: [f64; 3],
}

/// Where a tip may be between two instants, both included.
#[derive(Debug, Clone, Copy)]
struct Stay {
    times: [u64; 2],
    area: Area,
}

/// Iterations of the search for the nearest points of two areas.
const STEPS: usize = 4000;

impl Area {
    fn in_scene(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [x0, y0, heading] = self.stand;
        [x0 + x * heading.cos() - y * heading.sin(), y0 + x * heading.sin() + y * heading.cos()]
    }

    /// The point of the area nearest to a point; both in scene coordinates.
    fn nearest(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [x0, y0, heading] = self.stand;
        let (dx, dy) = (x - x0, y - y0);
        let own = [dx * heading.cos() + dy * heading.sin(), dy * heading.cos() - dx * heading.sin()];
        self.in_scene([0, 1].map(|axis| own[axis].clamp(self.low[axis], self.high[axis])))
    }

    /// Distance of two areas by alternating projection onto them, which converges for convex sets.
    fn gap_um(&self, other: &Area) -> f64 {
        let mut at = self.in_scene([0, 1].map(|axis| (self.low[axis] + self.high[axis]) / 2.0));
        let mut gap_um = f64::INFINITY;
        for _ in 0..STEPS {
            let there = other.nearest(at);
            at = self.nearest(there);
            let now_um = (at[0] - there[0]).hypot(at[1] - there[1]);
            if gap_um - now_um < 1e-13 {
                return now_um;
            }
            gap_um = now_um;
        }
        gap_um
    }
}

/// Pitch of a side: equations 2 and 6 of the paper.
fn pitch_um(facts: &DimibotFacts, modules: u32) -> f64 {
    facts.gain * facts.stroke_um * 2f64.sqrt() / f64::from(1u32 << (modules - 1))
}

/// All stays of a device in a schedule.
fn stays(schedule: &Schedule, claims: &Claims, device: &str) -> (Vec<Stay>, f64) {
    let first = claims.jobs.iter().find(|job| job.device == device).expect("a run of the device");
    let order = DimibotOrder::of(&first.order).expect("a DiMiBot");
    let facts = &order.facts;
    let frame = claims.shared.iter().find_map(|scene| scene.frames.get(device)).expect("a place in a scene");
    let stand = [frame.x_um, frame.y_um, frame.heading_rad];
    let pitches = [pitch_um(facts, facts.left), pitch_um(facts, facts.right)];
    let home = order.start.as_ref().map_or(facts.home, |start| start.value);
    let mut bits = [home.x, home.y];
    let place = |bits: [u32; 2]| [0, 1].map(|axis| f64::from(bits[axis]) * pitches[axis]);
    let mut pulses: BTreeMap<u64, Vec<(usize, u32, bool)>> = BTreeMap::new();
    for actuation in &schedule.actuations {
        let name = &schedule.channels[actuation.channel as usize].name;
        let mut parts = name.split('.');
        if parts.next() != Some(device) {
            continue;
        }
        let (module, switch) = (parts.next().expect("a module"), parts.next().expect("a switch"));
        let number = module[2..].parse().expect("a number");
        let axis = usize::from(module.starts_with("br"));
        pulses.entry(actuation.start_ns).or_default().push((axis, number, switch == "set"));
    }
    let (mut stays, mut since_ns) = (Vec::new(), 0);
    for (start_ns, parts) in pulses {
        let (mut low, mut high, at) = (bits, bits, place(bits));
        for (axis, module, is_set) in parts {
            let mask = 1 << module;
            if is_set {
                bits[axis] |= mask;
                high[axis] |= mask;
            } else {
                bits[axis] &= !mask;
                low[axis] &= !mask;
            }
        }
        stays.push(Stay { times: [since_ns, start_ns], area: Area { low: at, high: at, stand } });
        let end_ns = start_ns + facts.pulse_duration_ns;
        stays.push(Stay { times: [start_ns, end_ns], area: Area { low: place(low), high: place(high), stand } });
        since_ns = end_ns;
    }
    let at = place(bits);
    stays.push(Stay { times: [since_ns, schedule.duration_ns.max(since_ns)], area: Area { low: at, high: at, stand } });
    (stays, facts.tip_radius_um + facts.repeatability_um)
}

/// The least gap between the rims of two robots' grown tips over all instants; negative if they overlap.
pub fn least_gap_um(schedule: &Schedule, claims: &Claims, [one, other]: [&str; 2]) -> f64 {
    let ((first, one_um), (second, other_um)) = (stays(schedule, claims, one), stays(schedule, claims, other));
    let mut least_um = f64::INFINITY;
    // Two stays that overlap in time do so at an instant at which one of them begins.
    let instants = first.iter().chain(&second).map(|stay| stay.times[0]);
    for t_ns in instants {
        let now = |stays: &[Stay]| -> Vec<Area> {
            stays.iter().filter(|stay| stay.times[0] <= t_ns && t_ns <= stay.times[1]).map(|stay| stay.area).collect()
        };
        for area in now(&first) {
            for beside in now(&second) {
                least_um = least_um.min(area.gap_um(&beside) - one_um - other_um);
            }
        }
    }
    least_um
}
