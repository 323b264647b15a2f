//! The least effort of a task by Dijkstra's algorithm over every grasp at every angle of every turn, all turns together.
//!
//! It shares nothing with the planner: ellipses are integrated here, what holds is asked of a linear program over forces and torques in
//! space, and all edges are looked at. What is taken from the handbook: where contacts lie, that a grasp holds at 63 instants of a step
//! with the reserve kept back, who may come and leave, what it costs, and that a turn goes once round on its own side at most.

use microlp::{ComparisonOp, OptimizationDirection, Problem, Variable};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};
use std::f64::consts::TAU;

/// Fingers of every hand.
pub const FINGERS: usize = 3;

/// No contact.
const FREE: u8 = u8::MAX;

/// A hand, a part that is an ellipsoid, and a task of turns.
#[derive(Debug, Clone)]
pub struct Case {
    pub tip_radius_um: f64,
    pub steps_per_turn: i32,
    pub adhesion: bool,
    pub friction: f64,
    pub removal_safety: f64,
    pub clearance_um: f64,
    pub gaiting_cost_deg: f64,
    pub pull_off_un: f64,
    pub max_force_un: f64,
    pub torsion_um: f64,
    pub reserve: f64,
    pub semi_um: [f64; 3],
    pub load_un: [f64; 3],
    /// The grasp at the beginning, contacts from 1.
    pub pin: Option<[u32; FINGERS]>,
    /// About z (`true`) or y, in nominal steps.
    pub turns: Vec<(bool, i32)>,
}

impl Case {
    /// The program.
    pub fn text(&self) -> String {
        let [a, b, c] = self.semi_um;
        let [x, y, z] = self.load_un;
        let step_deg = 360 / self.steps_per_turn;
        let mut steps = match self.pin {
            Some([one, two, three]) => format!("  grasp bead at ({one}, {two}, {three})\n"),
            None => String::new(),
        };
        for (is_about_z, turn) in &self.turns {
            let axis = if *is_about_z { "z" } else { "y" };
            steps.push_str(&format!("  rotate bead by {} deg about {axis}\n", turn * step_deg));
        }
        let load = if self.load_un == [0.0; 3] { String::new() } else { format!("  load: ({x} uN, {y} uN, {z} uN)\n") };
        format!(
            "use std.fingers as f\ndevice hand : f.three_fingers {{ tip_radius: {} um, step: {step_deg} deg, adhesion: {}, \
             friction: {}, removal_safety: {}, clearance: {} um, gaiting_cost: {} deg, pull_off: {} uN, max_force: {} uN, \
             torsion: {} um, rolling_reserve: {}, range: (900 um, 900 um, 900 um) }}\n\
             scene cell {{ part bead : ellipsoid {{ axes: ({a} um, {b} um, {c} um) }} }}\n\
             task flip on hand in cell {{\n  precision: 30 deg\n{load}{steps}}}\n",
            self.tip_radius_um,
            self.adhesion,
            self.friction,
            self.removal_safety,
            self.clearance_um,
            self.gaiting_cost_deg,
            self.pull_off_un,
            self.max_force_un,
            self.torsion_um,
            self.reserve,
        )
    }
}

/// An ellipse with contacts.
struct Section {
    semi_um: [f64; 2],
    /// By how much the part has turned when a tip has rolled to each of many angles of the ellipse.
    rolled_rad: Vec<f64>,
    contacts: usize,
    step_rad: f64,
}

/// Angles of an ellipse that are looked at.
const SAMPLES: usize = 200_000;

impl Section {
    fn of(case: &Case, semi_um: [f64; 2]) -> Section {
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
        // An even number of contacts has one opposite to the first.
        let contacts = (0..10_i32).map(|k| exact.round() + f64::from((k + 1) / 2 * if k % 2 == 0 { 1 } else { -1 }));
        let mut even: Vec<f64> = contacts.filter(|count| count % 2.0 == 0.0).collect();
        even.sort_by(|one, other| (one - exact).abs().total_cmp(&(other - exact).abs()));
        Section { semi_um, contacts: even[0] as usize, step_rad: once_rad / even[0], rolled_rad }
    }

    /// Point and outward normal at a contact, counted from 0, that may be a broken number.
    fn touch(&self, contact: f64) -> Touch {
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
struct Touch {
    at_um: [f64; 2],
    normal: [f64; 2],
}

/// A node: leg, angle in steps, and the contact of each finger.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
struct Node {
    leg: u8,
    angle: i16,
    held: [u8; FINGERS],
}

/// A force on the part in a section: in the plane, and across it.
type Load = [f64; 3];

pub struct Brute<'a> {
    case: &'a Case,
    sections: [Section; 2],
    /// About z (`true`) or y, in the steps of the sections.
    turns: Vec<(bool, i32)>,
    /// By how much every condition may be missed, as a share of friction and forces.
    slack: f64,
    /// What holds: leg (or none where the load is), angle in 64ths of a step, sorted contacts.
    known: HashMap<(u8, i32, [u8; FINGERS]), bool>,
    rolled: HashMap<(u8, i16, [u8; FINGERS]), bool>,
}

impl<'a> Brute<'a> {
    pub fn of(case: &'a Case, slack: f64) -> Self {
        let [a, b, c] = case.semi_um;
        let sections = [Section::of(case, [a, b]), Section::of(case, [a, c])];
        let most = case.steps_per_turn;
        let whole = |(is_about_z, turn): &(bool, i32)| {
            let asked_rad = f64::from(*turn) * TAU / f64::from(most);
            let steps = asked_rad / sections[usize::from(!is_about_z)].step_rad;
            (*is_about_z, (steps.round() as i32).clamp(-most, most))
        };
        let turns = case.turns.iter().map(whole).collect();
        Brute { case, sections, turns, slack, known: HashMap::new(), rolled: HashMap::new() }
    }

    fn section(&self, leg: u8) -> &Section {
        &self.sections[usize::from(!self.turns[usize::from(leg)].0)]
    }

    /// The load as a section sees it after some steps of a leg.
    fn load(&self, leg: u8, steps: f64) -> Load {
        let mut load = self.case.load_un;
        for (at, (is_about_z, turn)) in self.turns.iter().enumerate().take(usize::from(leg) + 1) {
            let part = if at == usize::from(leg) { steps } else { f64::from(*turn) };
            let (sin, cos) = (-part * self.section(at as u8).step_rad).sin_cos();
            let [x, y, z] = load;
            load = match is_about_z {
                true => [x * cos - y * sin, x * sin + y * cos, z],
                false => [x * cos + z * sin, y, z * cos - x * sin],
            };
        }
        let [x, y, z] = load;
        if self.turns[usize::from(leg)].0 { [x, y, z] } else { [x, -z, y] }
    }

    fn apart(&self, touches: &[Touch]) -> bool {
        let centre = |touch: &Touch| [0, 1].map(|k| touch.at_um[k] + self.case.tip_radius_um * touch.normal[k]);
        let least_um = (2.0 * self.case.tip_radius_um + self.case.clearance_um) * (1.0 - 1e-9 - 0.01 * self.slack);
        (0..touches.len()).all(|one| {
            (0..one).all(|other| {
                let [a, b] = [centre(&touches[one]), centre(&touches[other])];
                (a[0] - b[0]).hypot(a[1] - b[1]) >= least_um
            })
        })
    }

    fn touches(&self, leg: u8, held: &[u8; FINGERS], part: f64) -> Vec<Touch> {
        let contacts = held.iter().filter(|contact| **contact != FREE);
        contacts.map(|contact| self.section(leg).touch(f64::from(*contact) - part)).collect()
    }

    /// Whether contacts hold some 64ths of a step after an angle.
    fn holds(&mut self, leg: u8, angle: i16, held: [u8; FINGERS], instant: i32) -> bool {
        let mut sorted = held;
        sorted.sort_unstable();
        let key = (leg, i32::from(angle) * 64 + instant, sorted);
        let is_loaded = self.case.load_un != [0.0; 3];
        let key = if is_loaded { key } else { (u8::from(self.turns[usize::from(leg)].0), instant, sorted) };
        if let Some(known) = self.known.get(&key) {
            return *known;
        }
        let part = f64::from(instant) / 64.0;
        let touches = self.touches(leg, &sorted, part);
        let load = self.load(leg, f64::from(angle) + part);
        let kept = if instant == 0 { 1.0 } else { 1.0 - self.case.reserve };
        let is_near = instant % 4 != 0 || self.apart(&touches);
        let sticks = self.case.adhesion && self.case.pull_off_un > 0.0;
        let holds = is_near
            && touches.len() >= 2
            && self.balance(&touches, load, None, kept)
            && (sticks || !is_loaded || self.balance(&touches, [0.0; 3], None, kept));
        self.known.insert(key, holds);
        holds
    }

    /// Whether forces and torques in space balance a load at the origin, and the pull of a finger that leaves.
    fn balance(&self, touches: &[Touch], load: Load, leaves: Option<&Touch>, kept: f64) -> bool {
        let case = self.case;
        let change = kept * (1.0 + self.slack);
        let friction = case.friction * change;
        let sticking = if case.adhesion { case.pull_off_un * kept } else { 0.0 };
        let pull = if case.adhesion { case.pull_off_un * case.removal_safety } else { 0.0 };
        if leaves.is_none() && load == [0.0; 3] && sticking > 0.0 {
            return true;
        }
        let is_idle = sticking == 0.0 && load == [0.0; 3];
        let arm_um = case.semi_um[0];
        let mut problem = Problem::new(OptimizationDirection::Maximize);
        let mut rows: [Vec<(Variable, f64)>; 6] = Default::default();
        let free = (f64::NEG_INFINITY, f64::INFINITY);
        let mut normals = Vec::new();
        for touch in touches {
            let most = if is_idle { f64::INFINITY } else { case.max_force_un * change };
            let normal = problem.add_var(0.0, (-sticking, most));
            let [tangential, across, torque] = [0, 1, 2].map(|_| problem.add_var(0.0, free));
            normals.push(normal);
            for (one, other) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                let row = [(tangential, one), (across, other), (normal, -friction)];
                problem.add_constraint(row, ComparisonOp::Le, friction * sticking + self.slack.max(0.0));
            }
            let torsion = case.torsion_um * change / arm_um;
            for sign in [1.0, -1.0] {
                let row = [(torque, sign), (normal, -torsion)];
                problem.add_constraint(row, ComparisonOp::Le, torsion * sticking + self.slack.max(0.0));
            }
            let [x, y] = touch.normal.map(|part| -part);
            let [px, py] = touch.at_um.map(|part| part / arm_um);
            for (variable, [fx, fy, fz]) in
                [(normal, [x, y, 0.0]), (tangential, [-y, x, 0.0]), (across, [0.0, 0.0, 1.0])]
            {
                let parts = [fx, fy, fz, py * fz, -px * fz, px * fy - py * fx];
                rows.iter_mut().zip(parts).for_each(|(row, part)| row.push((variable, part)));
            }
            rows[3].push((torque, x));
            rows[4].push((torque, y));
        }
        if is_idle {
            let sum: Vec<_> = normals.iter().map(|normal| (*normal, 1.0)).collect();
            problem.add_constraint(&sum, ComparisonOp::Eq, 1.0);
        }
        let mut outer = [load[0], load[1], load[2], 0.0, 0.0, 0.0];
        if let Some(touch) = leaves {
            let [x, y] = touch.normal.map(|part| part * pull);
            let [px, py] = touch.at_um.map(|part| part / arm_um);
            outer = [outer[0] + x, outer[1] + y, outer[2], 0.0, 0.0, px * y - py * x];
        }
        for (row, outer) in rows.iter().zip(outer) {
            problem.add_constraint(row, ComparisonOp::Eq, -outer);
        }
        problem.solve().is_ok()
    }

    /// Whether contacts hold all the way from an angle to the next.
    fn lasts(&mut self, leg: u8, angle: i16, held: [u8; FINGERS]) -> bool {
        let mut sorted = held;
        sorted.sort_unstable();
        let is_loaded = self.case.load_un != [0.0; 3];
        let about_z = u8::from(self.turns[usize::from(leg)].0);
        let key = if is_loaded { (leg, angle, sorted) } else { (about_z, 0, sorted) };
        if let Some(known) = self.rolled.get(&key) {
            return *known;
        }
        // The middle first, where most that lapse do.
        let lasts =
            (1..64).map(|k| (k * 32 + k / 2) % 64).chain(1..64).all(|k| k == 0 || self.holds(leg, angle, held, k));
        self.rolled.insert(key, lasts);
        lasts
    }

    fn turned(&self, leg: u8, held: [u8; FINGERS], by: usize) -> [u8; FINGERS] {
        let count = self.section(leg).contacts;
        held.map(|contact| if contact == FREE { FREE } else { ((usize::from(contact) + by) % count) as u8 })
    }

    /// The least effort, in degrees; `None` where no sequence of grasps carries the task out.
    pub fn least_deg(&mut self) -> Option<f64> {
        let unit = |deg: f64| (deg * 1000.0).round() as u64;
        let roll = unit(360.0 / f64::from(self.case.steps_per_turn));
        let gait = unit(self.case.gaiting_cost_deg);
        Some(self.least(roll, gait)? as f64 / 1000.0)
    }

    /// The fewest reconfigurations.
    pub fn fewest(&mut self) -> Option<u64> {
        self.least(0, 1)
    }

    /// The least sum of costs of rolling by a step, for each finger, and of a finger that comes or leaves.
    fn least(&mut self, roll: u64, gait: u64) -> Option<u64> {
        let mut open: BinaryHeap<Reverse<(u64, Node)>> = BinaryHeap::new();
        let mut best: HashMap<Node, u64> = HashMap::new();
        for held in self.first() {
            open.push(Reverse((0, Node { leg: 0, angle: 0, held })));
        }
        while let Some(Reverse((cost, node))) = open.pop() {
            if best.get(&node).is_some_and(|known| *known <= cost) {
                continue;
            }
            best.insert(node, cost);
            let (_, turn) = self.turns[usize::from(node.leg)];
            if i32::from(node.angle) == turn {
                if usize::from(node.leg) + 1 == self.turns.len() {
                    return Some(cost);
                }
                for held in self.handed_over(node) {
                    open.push(Reverse((cost, Node { leg: node.leg + 1, angle: 0, held })));
                }
            }
            let holding = node.held.iter().filter(|contact| **contact != FREE).count();
            let round = self.case.steps_per_turn;
            let [low, high] = if turn < 0 { [turn.min(-round), 0] } else { [0, turn.max(round)] };
            let count = self.section(node.leg).contacts;
            if i32::from(node.angle) < high && self.lasts(node.leg, node.angle, node.held) {
                let held = self.turned(node.leg, node.held, count - 1);
                let next = Node { angle: node.angle + 1, held, ..node };
                if self.holds(node.leg, next.angle, held, 0) {
                    open.push(Reverse((cost + roll * holding as u64, next)));
                }
            }
            let before = self.turned(node.leg, node.held, 1);
            if i32::from(node.angle) > low && self.lasts(node.leg, node.angle - 1, before) {
                let next = Node { angle: node.angle - 1, held: before, ..node };
                if self.holds(node.leg, next.angle, before, 0) {
                    open.push(Reverse((cost + roll * holding as u64, next)));
                }
            }
            for next in self.gaited(node, holding) {
                open.push(Reverse((cost + gait, next)));
            }
        }
        None
    }

    /// A finger comes, or leaves.
    fn gaited(&mut self, node: Node, holding: usize) -> Vec<Node> {
        let mut nodes = Vec::new();
        for finger in 0..FINGERS {
            let with = |contact: u8| {
                let mut held = node.held;
                held[finger] = contact;
                Node { held, ..node }
            };
            if node.held[finger] == FREE && holding == 2 {
                for contact in 0..self.section(node.leg).contacts as u8 {
                    let next = with(contact);
                    if !node.held.contains(&contact) && self.holds(node.leg, node.angle, next.held, 0) {
                        nodes.push(next);
                    }
                }
            } else if node.held[finger] != FREE && holding == 3 {
                let next = with(FREE);
                let touches = self.touches(node.leg, &next.held, 0.0);
                let leaves = self.section(node.leg).touch(f64::from(node.held[finger]));
                let load = self.load(node.leg, f64::from(node.angle));
                let resists = !self.case.adhesion || self.balance(&touches, load, Some(&leaves), 1.0);
                if resists && self.holds(node.leg, node.angle, next.held, 0) {
                    nodes.push(next);
                }
            }
        }
        nodes
    }

    /// Every grasp that the task may begin with.
    fn first(&mut self) -> Vec<[u8; FINGERS]> {
        if let Some(pin) = self.case.pin {
            let held = pin.map(|contact| if contact == 0 { FREE } else { contact as u8 - 1 });
            return if self.holds(0, 0, held, 0) { vec![held] } else { Vec::new() };
        }
        let count = self.section(0).contacts as u8;
        let choices: Vec<u8> = (0..count).chain([FREE]).collect();
        let mut all = Vec::new();
        for a in &choices {
            for b in &choices {
                all.extend(choices.iter().map(|c| [*a, *b, *c]));
            }
        }
        let differs = |held: &[u8; FINGERS]| {
            let contacts: Vec<&u8> = held.iter().filter(|contact| **contact != FREE).collect();
            contacts.len() >= 2 && (0..contacts.len()).all(|at| !contacts[..at].contains(&contacts[at]))
        };
        all.into_iter().filter(|held| differs(held) && self.holds(0, 0, *held, 0)).collect()
    }

    /// With what the next turn begins: the same contacts, or, about another axis, the two on the x axis.
    fn handed_over(&mut self, node: Node) -> Vec<[u8; FINGERS]> {
        let next = node.leg + 1;
        if self.turns[usize::from(node.leg)].0 == self.turns[usize::from(next)].0 {
            return vec![node.held];
        }
        let [old, new] = [node.leg, next].map(|leg| (self.section(leg).contacts / 2) as u8);
        let carried = node.held.map(|contact| match contact {
            FREE => Some(FREE),
            0 => Some(0),
            other if other == old => Some(new),
            _ => None,
        });
        let on_axis = carried.iter().filter(|contact| contact.is_some_and(|contact| contact != FREE)).count();
        let [Some(a), Some(b), Some(c)] = carried else { return Vec::new() };
        let held = [a, b, c];
        if on_axis == 2 && self.holds(next, 0, held, 0) { vec![held] } else { Vec::new() }
    }
}
