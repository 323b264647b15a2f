//! Least effort of a task, by Dijkstra's algorithm over every grasp at every angle of every turn, with all turns in one
//! search.
//!
//! It shares nothing with the planner: ellipses are integrated here, a linear program over spatial forces and torques
//! (`forces`) decides whether a grasp holds, and all edges are examined. Taken from docs/language.md: the places of
//! contacts, the rule that a grasp holds at 63 instants of a step with the reserve kept back, which fingers may be
//! placed and removed, the costs, and the rule that a turn goes at most one revolution beyond its start and its goal.

use crate::case::{Case, FINGERS, Step, TRANSLATED_UM};
use crate::ellipse::{Section, Touch};
use crate::forces::{self, Tip};
use crate::orient;
use nalgebra::{UnitQuaternion, Vector3};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};
use std::f64::consts::TAU;

/// No contact.
const FREE: u8 = u8::MAX;

/// One turn of the task as searched, or a change of grasp if `turn` is 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Leg {
    pub is_about_z: bool,
    /// Steps of the section.
    pub turn: i32,
    /// The grasp that it must end with.
    pub end: Option<[u32; FINGERS]>,
    /// Condition on its first grasp.
    pub begins: Begins,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Begins {
    /// The grasp with which the previous leg ended.
    Held,
    Any,
    With([u32; FINGERS]),
}

/// A node: leg, angle in steps, and the contact of each finger.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
struct Node {
    leg: u8,
    angle: i16,
    held: [u8; FINGERS],
}

/// A force on the part in a section: two components in the plane and one across it.
type Load = [f64; 3];

pub struct Brute<'a> {
    case: &'a Case,
    sections: [Section; 2],
    legs: Vec<Leg>,
    /// Tolerance of every condition, as a share of friction and forces.
    slack: f64,
    /// Whether contacts hold, by leg (only the axis if there is no load), angle in 1/64 of a step, and sorted contacts.
    known: HashMap<(u8, i32, [u8; FINGERS]), bool>,
    rolled: HashMap<(u8, i16, [u8; FINGERS]), bool>,
    removed: HashMap<(u8, [u8; FINGERS], u8), bool>,
    /// Path length of a tip that rolls from a contact to the previous one, by axis and contact, in micrometres.
    ways_um: HashMap<(bool, u8), f64>,
}

/// Cost model of the actions of a task.
#[derive(Debug, Clone, Copy)]
enum Costs {
    /// Cost for each finger that rolls by a step, and for each that is placed or removed while others hold.
    Effort { roll: u64, gait: u64 },
    /// Lower bound on the time of the actions, in nanoseconds: tips that hold travel along their rolling path, fingers
    /// are placed and removed one at a time.
    Time,
}

/// The least sum of costs of a task, and the fewest reconfigurations at this cost; `None` if there is no plan.
pub type Least = Option<(u64, u32)>;

impl<'a> Brute<'a> {
    pub fn of(case: &'a Case, slack: f64) -> Self {
        let [a, b, c] = case.semi_um;
        let sections = [Section::of(case, [a, b]), Section::of(case, [a, c])];
        let empty = (HashMap::new(), HashMap::new(), HashMap::new());
        let (known, rolled, removed) = empty;
        Brute { case, sections, legs: Vec::new(), slack, known, rolled, removed, ways_um: HashMap::new() }
    }

    /// The legs of a task, once for each choice of decompositions of its orientations.
    fn choices(&self) -> Vec<Vec<Leg>> {
        let case = self.case;
        let most = case.steps_per_turn;
        let step_rad = |is_about_z: bool| self.sections[usize::from(!is_about_z)].step_rad;
        // For each step, the sequences of turns that can realise it.
        let mut all: Vec<Vec<Vec<(bool, i32)>>> = Vec::new();
        let mut reached = vec![UnitQuaternion::identity()];
        for step in &case.steps {
            let ways = match step {
                Step::Turn(is_about_z, turn) => {
                    let asked_rad = f64::from(*turn) * TAU / f64::from(most);
                    let steps = (asked_rad / step_rad(*is_about_z)).round() as i32;
                    vec![vec![(*is_about_z, steps.clamp(-most, most))]]
                }
                Step::Orient(angles) => {
                    let precision_rad = f64::from(case.precision_deg).to_radians();
                    let goal = turned(&[(true, angles[0]), (false, angles[1]), (true, angles[2])], |_| TAU / 360.0);
                    let mut ways = orient::ways(reached[0].inverse() * goal, [true, false].map(step_rad));
                    ways.retain(|way| {
                        let by = turned(way, step_rad);
                        reached.iter().all(|from| (from * by).angle_to(&goal) <= precision_rad)
                    });
                    ways
                }
                Step::Grasp(_) | Step::Translate | Step::Release => vec![Vec::new()],
            };
            let after = |from: &UnitQuaternion<f64>| ways.iter().map(|way| from * turned(way, step_rad)).collect();
            reached = reached.iter().flat_map(|from| -> Vec<UnitQuaternion<f64>> { after(from) }).collect();
            all.push(ways);
        }
        let mut choices: Vec<Vec<Vec<(bool, i32)>>> = vec![Vec::new()];
        for ways in &all {
            let with = |choice: &Vec<Vec<(bool, i32)>>, way: &Vec<(bool, i32)>| {
                choice.iter().cloned().chain([way.clone()]).collect::<Vec<_>>()
            };
            choices = choices.iter().flat_map(|choice| ways.iter().map(move |way| with(choice, way))).collect();
        }
        choices.iter().map(|turns| legs(&case.steps, turns)).collect()
    }

    /// Number of contacts of the section about z.
    pub fn contacts(&self) -> u32 {
        self.sections[0].contacts as u32
    }

    /// Total steps turned by a task without orientations.
    pub fn steps_turned(&self) -> i32 {
        self.choices()[0].iter().map(|leg| leg.turn).sum()
    }

    /// Number of choices of decompositions.
    pub fn count(&self) -> usize {
        self.choices().len()
    }

    /// The least over all choices, with at most `most` reconfigurations.
    fn over_all(&mut self, costs: Costs, most: Option<u32>) -> Least {
        let mut best: Least = None;
        for legs in self.choices() {
            if self.case.load_un != [0.0; 3] {
                self.known.clear();
                self.rolled.clear();
                self.removed.clear();
            }
            self.legs = legs;
            let found = self.least(costs, most, best.map(|(cost, _)| cost));
            best = best.into_iter().chain(found).min();
        }
        best
    }

    fn section(&self, leg: u8) -> &Section {
        &self.sections[usize::from(!self.legs[usize::from(leg)].is_about_z)]
    }

    /// The load as a section sees it after some steps of a leg.
    fn load(&self, leg: u8, steps: f64) -> Load {
        let mut load = self.case.load_un;
        for (at, Leg { is_about_z, turn, .. }) in self.legs.iter().enumerate().take(usize::from(leg) + 1) {
            let part = if at == usize::from(leg) { steps } else { f64::from(*turn) };
            let (sin, cos) = (-part * self.section(at as u8).step_rad).sin_cos();
            let [x, y, z] = load;
            load = match is_about_z {
                true => [x * cos - y * sin, x * sin + y * cos, z],
                false => [x * cos + z * sin, y, z * cos - x * sin],
            };
        }
        let [x, y, z] = load;
        if self.legs[usize::from(leg)].is_about_z { [x, y, z] } else { [x, -z, y] }
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

    /// Whether contacts hold at `instant`/64 of a step after an angle.
    fn holds(&mut self, leg: u8, angle: i16, held: [u8; FINGERS], instant: i32) -> bool {
        let mut sorted = held;
        sorted.sort_unstable();
        let key = (leg, i32::from(angle) * 64 + instant, sorted);
        let is_loaded = self.case.load_un != [0.0; 3];
        let key = if is_loaded { key } else { (u8::from(self.legs[usize::from(leg)].is_about_z), instant, sorted) };
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

    /// Whether tip forces and torques balance a load at the origin, and the pull of a finger that is removed if there
    /// is one.
    fn balance(&self, touches: &[Touch], load: Load, leaves: Option<&Touch>, kept: f64) -> bool {
        let case = self.case;
        let change = kept * (1.0 + self.slack);
        let sticking_un = if case.adhesion { case.pull_off_un * kept } else { 0.0 };
        if leaves.is_none() && load == [0.0; 3] && sticking_un > 0.0 {
            return true;
        }
        let arm_um = case.semi_um[0];
        let tip = |touch: &Touch| Tip {
            at_um: touch.at_um,
            inward: touch.normal.map(|part| -part),
            friction: case.friction * change,
            torsion: case.torsion_um * change / arm_um,
            sticking_un,
            most_un: case.max_force_un * change,
        };
        let tips: Vec<Tip> = touches.iter().map(tip).collect();
        let mut outer = forces::wrench(load, [0.0; 2], arm_um);
        if let Some(touch) = leaves {
            let pull_un = if case.adhesion { case.pull_off_un * case.removal_safety } else { 0.0 };
            let [x, y] = touch.normal.map(|part| part * pull_un);
            let pull = forces::wrench([x, y, 0.0], touch.at_um, arm_um);
            outer.iter_mut().zip(pull).for_each(|(outer, pull)| *outer += pull);
        }
        forces::balance(&tips, outer, arm_um, self.slack.max(0.0))
    }

    /// Whether contacts hold throughout the step from an angle to the next.
    fn lasts(&mut self, leg: u8, angle: i16, held: [u8; FINGERS]) -> bool {
        let mut sorted = held;
        sorted.sort_unstable();
        let is_loaded = self.case.load_un != [0.0; 3];
        let about_z = u8::from(self.legs[usize::from(leg)].is_about_z);
        let key = if is_loaded { (leg, angle, sorted) } else { (about_z, 0, sorted) };
        if let Some(known) = self.rolled.get(&key) {
            return *known;
        }
        // Instants near the middle of the step come first, because most grasps that fail do so there.
        let lasts =
            (1..64).map(|k| (k * 32 + k / 2) % 64).chain(1..64).all(|k| k == 0 || self.holds(leg, angle, held, k));
        self.rolled.insert(key, lasts);
        lasts
    }

    fn turned(&self, leg: u8, held: [u8; FINGERS], by: usize) -> [u8; FINGERS] {
        let count = self.section(leg).contacts;
        held.map(|contact| if contact == FREE { FREE } else { ((usize::from(contact) + by) % count) as u8 })
    }

    /// The least effort in degrees, and the fewest reconfigurations at it, with at most `most` of them; `None` if no
    /// sequence of grasps carries the task out.
    pub fn least_deg(&mut self, most: Option<u32>) -> Option<(f64, u32)> {
        let unit = |deg: f64| (deg * 1000.0).round() as u64;
        let (roll, gait) = (unit(360.0 / f64::from(self.case.steps_per_turn)), unit(self.case.gaiting_cost_deg));
        self.over_all(Costs::Effort { roll, gait }, most).map(|(cost, gaits)| (cost as f64 / 1000.0, gaits))
    }

    /// A lower bound on the time of the task, in seconds; motion of free fingers far from the part counts as zero.
    pub fn least_s(&mut self) -> Option<f64> {
        let translations = self.case.steps.iter().filter(|step| **step == Step::Translate).count();
        let by_um = Vector3::from(TRANSLATED_UM).norm() * translations as f64;
        let least = self.over_all(Costs::Time, None)?;
        Some(least.0 as f64 / 1e9 + by_um / self.case.rolling_um_per_s)
    }

    /// Path length of a tip that rolls from a contact to the previous one while the part turns by a step.
    fn way_um(&mut self, leg: u8, contact: u8) -> f64 {
        const PARTS: u32 = 256;
        let key = (self.legs[usize::from(leg)].is_about_z, contact);
        if let Some(known) = self.ways_um.get(&key) {
            return *known;
        }
        let section = self.section(leg);
        let tip = |part: f64| {
            let touch = section.touch(f64::from(contact) - part);
            let [x, y] = [0, 1].map(|k| touch.at_um[k] + self.case.tip_radius_um * touch.normal[k]);
            let (sin, cos) = (part * section.step_rad).sin_cos();
            [x * cos - y * sin, x * sin + y * cos]
        };
        let places: Vec<[f64; 2]> = (0..=PARTS).map(|k| tip(f64::from(k) / f64::from(PARTS))).collect();
        let way_um = places.windows(2).map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1])).sum();
        self.ways_um.insert(key, way_um);
        way_um
    }

    /// Cost of rolling by a step, each finger from its contact to the previous one or back.
    fn rolling(&mut self, costs: Costs, leg: u8, held: [u8; FINGERS]) -> u64 {
        let contacts = held.into_iter().filter(|contact| *contact != FREE);
        match costs {
            Costs::Effort { roll, .. } => roll * contacts.count() as u64,
            Costs::Time => {
                let longest_um = contacts.map(|contact| self.way_um(leg, contact)).fold(0.0, f64::max);
                (1e9 * longest_um / self.case.rolling_um_per_s) as u64
            }
        }
    }

    /// Cost of placing or removing `fingers` fingers at once, when none holds before or after.
    fn coming(&self, costs: Costs, fingers: usize) -> u64 {
        let near_um = self.case.retract_um.max(self.case.clearance_um);
        match costs {
            Costs::Effort { .. } => 0,
            Costs::Time => (1e9 * near_um * fingers as f64 / self.case.approach_um_per_s) as u64,
        }
    }

    /// Cost of placing or removing one finger while others hold.
    fn gaiting(&self, costs: Costs) -> u64 {
        match costs {
            Costs::Effort { gait, .. } => gait,
            Costs::Time => self.coming(costs, 1),
        }
    }

    /// The fewest reconfigurations of any plan.
    pub fn fewest(&mut self) -> Option<u32> {
        self.over_all(Costs::Effort { roll: 0, gait: 1 }, None).map(|(_, gaits)| gaits)
    }

    /// The least sum of costs; stops at anything dearer than `enough`.
    fn least(&mut self, costs: Costs, most: Option<u32>, enough: Option<u64>) -> Least {
        let mut open: BinaryHeap<Reverse<(u64, u32, Node)>> = BinaryHeap::new();
        // If reconfigurations are limited, their number is part of the node.
        let mut best: HashMap<(Node, u32), (u64, u32)> = HashMap::new();
        // The least cost of a task that ends with a release, the release included.
        let mut ended: Least = None;
        for held in self.first(0) {
            open.push(Reverse((self.coming(costs, holding(&held)), 0, Node { leg: 0, angle: 0, held })));
        }
        let is_released = self.case.steps.last() == Some(&Step::Release);
        while let Some(Reverse((cost, gaits, node))) = open.pop() {
            let place = (node, most.map_or(0, |_| gaits));
            if best.get(&place).is_some_and(|known| *known <= (cost, gaits))
                || enough.is_some_and(|enough| cost > enough)
                || ended.is_some_and(|ended| (cost, gaits) >= ended)
            {
                continue;
            }
            best.insert(place, (cost, gaits));
            let Leg { turn, end, .. } = self.legs[usize::from(node.leg)];
            if i32::from(node.angle) == turn && end.is_none_or(|end| numbered(end) == node.held) {
                let left = self.coming(costs, holding(&node.held));
                if usize::from(node.leg) + 1 == self.legs.len() {
                    if !is_released || left == 0 {
                        return Some((cost, gaits));
                    }
                    ended = ended.into_iter().chain([(cost + left, gaits)]).min();
                    continue;
                }
                let goes_on = self.legs[usize::from(node.leg) + 1].begins == Begins::Held;
                for held in self.handed_over(node) {
                    let anew = if goes_on { 0 } else { left + self.coming(costs, holding(&held)) };
                    open.push(Reverse((cost + anew, gaits, Node { leg: node.leg + 1, angle: 0, held })));
                }
            }
            let holding = holding(&node.held);
            let round = self.case.steps_per_turn;
            let [low, high] = [turn.min(0) - round, turn.max(0) + round];
            let count = self.section(node.leg).contacts;
            if i32::from(node.angle) < high && self.lasts(node.leg, node.angle, node.held) {
                let held = self.turned(node.leg, node.held, count - 1);
                let next = Node { angle: node.angle + 1, held, ..node };
                if self.holds(node.leg, next.angle, held, 0) {
                    open.push(Reverse((cost + self.rolling(costs, node.leg, node.held), gaits, next)));
                }
            }
            let before = self.turned(node.leg, node.held, 1);
            if i32::from(node.angle) > low && self.lasts(node.leg, node.angle - 1, before) {
                let next = Node { angle: node.angle - 1, held: before, ..node };
                if self.holds(node.leg, next.angle, before, 0) {
                    open.push(Reverse((cost + self.rolling(costs, node.leg, before), gaits, next)));
                }
            }
            if most.is_some_and(|most| gaits >= most) {
                continue;
            }
            for next in self.gaited(node, holding) {
                open.push(Reverse((cost + self.gaiting(costs), gaits + 1, next)));
            }
        }
        ended
    }

    /// The nodes after a finger is placed or removed.
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
                if self.resists(node, next.held, node.held[finger]) && self.holds(node.leg, node.angle, next.held, 0) {
                    nodes.push(next);
                }
            }
        }
        nodes
    }

    /// Whether the remaining fingers resist the pull of a finger that is removed.
    fn resists(&mut self, node: Node, stay: [u8; FINGERS], leaves: u8) -> bool {
        if !self.case.adhesion {
            return true;
        }
        let mut sorted = stay;
        sorted.sort_unstable();
        let is_loaded = self.case.load_un != [0.0; 3];
        let key = (u8::from(self.legs[usize::from(node.leg)].is_about_z), sorted, leaves);
        if let Some(known) = self.removed.get(&key).filter(|_| !is_loaded) {
            return *known;
        }
        let touches = self.touches(node.leg, &sorted, 0.0);
        let leaving = self.section(node.leg).touch(f64::from(leaves));
        let load = self.load(node.leg, f64::from(node.angle));
        let resists = self.balance(&touches, load, Some(&leaving), 1.0);
        self.removed.insert(key, resists);
        resists
    }

    /// Every grasp that a leg may begin with if nothing holds before it.
    fn first(&mut self, leg: u8) -> Vec<[u8; FINGERS]> {
        if let Begins::With(pin) = self.legs[usize::from(leg)].begins {
            let held = numbered(pin);
            return if self.holds(leg, 0, held, 0) { vec![held] } else { Vec::new() };
        }
        let count = self.section(leg).contacts as u8;
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
        all.into_iter().filter(|held| differs(held) && self.holds(leg, 0, *held, 0)).collect()
    }

    /// The grasps with which the next turn may begin: the same contacts, or, about another axis, the two on the x axis.
    fn handed_over(&mut self, node: Node) -> Vec<[u8; FINGERS]> {
        let next = node.leg + 1;
        if self.legs[usize::from(next)].begins != Begins::Held {
            return self.first(next);
        }
        if self.legs[usize::from(node.leg)].is_about_z == self.legs[usize::from(next)].is_about_z {
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

/// Number of fingers that hold.
fn holding(held: &[u8; FINGERS]) -> usize {
    held.iter().filter(|contact| **contact != FREE).count()
}

/// A grasp in the numbering of nodes.
fn numbered(grasp: [u32; FINGERS]) -> [u8; FINGERS] {
    grasp.map(|contact| if contact == 0 { FREE } else { contact as u8 - 1 })
}

/// Rotation of a part by turns about its own axes, one after the other.
fn turned(turns: &[(bool, i32)], step_rad: impl Fn(bool) -> f64) -> UnitQuaternion<f64> {
    let axis = |is_about_z: bool| if is_about_z { Vector3::z() } else { Vector3::y() };
    turns.iter().fold(UnitQuaternion::identity(), |reached, (is_about_z, steps)| {
        reached * UnitQuaternion::from_scaled_axis(axis(*is_about_z) * (f64::from(*steps) * step_rad(*is_about_z)))
    })
}

/// The legs of a task whose steps are realised by these turns.
fn legs(steps: &[Step], turns: &[Vec<(bool, i32)>]) -> Vec<Leg> {
    let mut legs: Vec<Leg> = Vec::new();
    let mut begins = Begins::Any;
    // The plane of the next turn of the task, or else of its last one.
    let plane_at = |at: usize| {
        let (before, after) = turns.split_at(at);
        let turn = after.iter().flatten().next().or_else(|| before.iter().flatten().last());
        turn.is_none_or(|(is_about_z, _)| *is_about_z)
    };
    for (at, step) in steps.iter().enumerate() {
        let plane = plane_at(at);
        match step {
            Step::Grasp(pin) if begins == Begins::Any => begins = Begins::With(*pin),
            Step::Grasp(pin) => {
                legs.push(Leg { is_about_z: plane, turn: 0, end: Some(*pin), begins });
                begins = Begins::Held;
            }
            Step::Turn(..) | Step::Orient(_) => {
                for (is_about_z, turn) in &turns[at] {
                    legs.push(Leg { is_about_z: *is_about_z, turn: *turn, end: None, begins });
                    begins = Begins::Held;
                }
            }
            Step::Translate => {}
            Step::Release => {
                if begins != Begins::Held {
                    legs.push(Leg { is_about_z: plane, turn: 0, end: None, begins });
                }
                begins = Begins::Any;
            }
        }
    }
    if begins != Begins::Held && !matches!(steps.last(), Some(Step::Release)) {
        legs.push(Leg { is_about_z: plane_at(steps.len()), turn: 0, end: None, begins });
    }
    legs
}
