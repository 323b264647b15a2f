//! Errors that a plan is guaranteed to bear, tested against an adversary. In every leg it chooses the errors of each
//! robot's speed and turning, and it chooses the true poses at the start, so that a robot docks as far from its place
//! as possible. It moves robots by its own formulas and knows nothing of the bounds. `TWEEZE_ORACLE_CASES=200` tries
//! more programs.

use super::random::{Random, cases};
use super::recorded::Bench;
use std::f64::consts::TAU;
use tweeze::claims::microrobots::MicrorobotsOrder;
use tweeze::device::microrobots::{Arm, Errors};
use tweeze::geometry::Pose;
use tweeze::plan::microrobots::guarantee::tolerated_multiple;
use tweeze::plan::microrobots::simulation::simulate;
use tweeze::plan::microrobots::{AssemblyStage, MicrorobotsMotion, MicrorobotsStepMotion};

/// Number of body positions sampled in a leg.
const SAMPLES: usize = 12;

/// Three robots assembled at a random place and angle.
fn steps(random: &mut Random) -> String {
    let turned = random.unit() * TAU;
    let middle = [random.thousandths(1000.0, 2200.0), random.thousandths(800.0, 1800.0)];
    let pose = |ahead: f64, aside: f64, heading: f64| {
        let (sin, cos) = turned.sin_cos();
        let (x, y) = (middle[0] + ahead * cos - aside * sin, middle[1] + ahead * sin + aside * cos);
        format!("pose({x:.4} um, {y:.4} um, {:.4} deg)", (heading + turned).to_degrees().rem_euclid(360.0))
    };
    let side = random.thousandths(-60.0, 60.0);
    format!(
        "  assemble {{\n    D3 to {}\n    D2 to {}\n    D1 to {}\n  }}",
        pose(-130.0, 0.0, 0.0),
        pose(130.0, 0.0, TAU / 2.0),
        pose(130.0 + side, 160.0, TAU * 0.75),
    )
}

/// Choices of the adversary: the signs of the errors of each robot, at the start (along, across, heading) and in each
/// leg (speed, turning).
#[derive(Clone)]
struct Choices {
    begin: Vec<[f64; 3]>,
    legs: Vec<Vec<[f64; 2]>>,
}

struct Adversary<'a> {
    order: &'a MicrorobotsOrder,
    motion: &'a MicrorobotsMotion,
    errors: Errors,
}

/// Docking place of a robot in the structure, and the leg of the whole plan after which it docks.
#[derive(Clone, Copy)]
struct Place {
    robot: usize,
    goal: Pose,
    leg: usize,
}

impl Adversary<'_> {
    fn legs(&self) -> impl Iterator<Item = (usize, f64)> {
        let legs = self.motion.steps.iter().flat_map(MicrorobotsStepMotion::legs);
        legs.map(|leg| (leg.state, leg.strokes as f64))
    }

    fn none(&self) -> Choices {
        let robots = self.motion.start.poses.len();
        Choices { begin: vec![[0.0; 3]; robots], legs: vec![vec![[0.0; 2]; robots]; self.legs().count()] }
    }

    /// The first two places, which form the structure, followed by the others.
    fn places(&self) -> Vec<Place> {
        let mut found = Vec::new();
        let mut before = 0;
        for step in &self.motion.steps {
            let MicrorobotsStepMotion::Legs { legs, docks, stages } = step else { continue };
            let leg = |robot: usize| {
                let dock = docks.iter().find(|dock| dock.robot == robot).expect("it docks");
                before + dock.leg
            };
            for stage in stages {
                match *stage {
                    AssemblyStage::Pair { first, second, goals, .. } => {
                        for (robot, goal) in [(first, goals[0]), (second, goals[1])] {
                            found.push(Place { robot, goal, leg: leg(robot) });
                        }
                    }
                    AssemblyStage::Single { robot, goal, .. } => found.push(Place { robot, goal, leg: leg(robot) }),
                    AssemblyStage::BedLegs { .. } | AssemblyStage::Escort { .. } => {}
                }
            }
            before += legs.len();
        }
        found
    }

    /// Pose of a robot after a part of a leg, with the chosen errors.
    fn moved(&self, robot: usize, pose: Pose, state: usize, strokes: f64, [speed, turning]: [f64; 2]) -> Pose {
        let facts = self.order.robot(robot);
        let way = facts.step_um * strokes * (1.0 + speed * self.errors.speed_ratio);
        let down = self.order.states[state].arms[self.order.robots[robot].row] == Arm::Down;
        let own = if down { facts.turning.sign() / facts.turning_radius_um } else { 0.0 };
        let curvature = own + turning * self.errors.turning_rad_per_um;
        let heading_rad = pose.heading_rad + curvature * way;
        let (x, y) = if curvature.abs() < 1e-12 {
            (way * pose.heading_rad.cos(), way * pose.heading_rad.sin())
        } else {
            (
                (heading_rad.sin() - pose.heading_rad.sin()) / curvature,
                (pose.heading_rad.cos() - heading_rad.cos()) / curvature,
            )
        };
        Pose { x_um: pose.x_um + x, y_um: pose.y_um + y, heading_rad }
    }

    fn begun(&self, robot: usize, [along, across, turned]: [f64; 3]) -> Pose {
        let pose = self.motion.start.poses[robot];
        let longest = along.hypot(across).max(1.0);
        Pose {
            x_um: pose.x_um + self.errors.place_um * along / longest,
            y_um: pose.y_um + self.errors.place_um * across / longest,
            heading_rad: pose.heading_rad + self.errors.heading_rad * turned,
        }
    }

    /// Pose of a robot before each leg and after the last one.
    fn followed(&self, robot: usize, choices: &Choices) -> Vec<Pose> {
        let mut poses = vec![self.begun(robot, choices.begin[robot])];
        for (at, (state, strokes)) in self.legs().enumerate() {
            let pose = poses[poses.len() - 1];
            poses.push(self.moved(robot, pose, state, strokes, choices.legs[at][robot]));
        }
        poses
    }

    /// Lateral offset of a robot's front from its place at the end of its legs, and its heading error, in the frame of
    /// the structure, which is the mean pose of the fronts of the first two robots.
    fn off(&self, places: &[Place], nth: usize, choices: &Choices) -> [f64; 2] {
        let end = |place: &Place| self.followed(place.robot, choices)[place.leg + 1];
        let front = |place: &Place, pose: Pose| {
            let half = self.order.robot(place.robot).length_um / 2.0;
            [pose.x_um + half * pose.heading_rad.cos(), pose.y_um + half * pose.heading_rad.sin()]
        };
        let middle = |points: [[f64; 2]; 2]| [0, 1].map(|axis| (points[0][axis] + points[1][axis]) / 2.0);
        let pair = [places[0], places[1]];
        let there = pair.map(|place| end(&place));
        let met = middle([0, 1].map(|at| front(&pair[at], there[at])));
        let planned = middle(pair.map(|place| front(&place, place.goal)));
        let turned = [0, 1].map(|at| there[at].heading_rad - pair[at].goal.heading_rad);
        let wrapped = |angle: f64| (angle + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0;
        let tilt = (wrapped(turned[0]) + wrapped(turned[1])) / 2.0;
        let place = &places[nth];
        if nth < 2 {
            // Lateral distance between the axes of the two.
            let [one, other] = [0, 1].map(|at| front(&pair[at], there[at]));
            let axis = pair[0].goal.heading_rad + tilt;
            let across = (other[1] - one[1]) * axis.cos() - (other[0] - one[0]) * axis.sin();
            return [across, wrapped(turned[0]) - wrapped(turned[1])];
        }
        let goal = front(place, place.goal);
        let (dx, dy) = (goal[0] - planned[0], goal[1] - planned[1]);
        let moved = [met[0] + dx * tilt.cos() - dy * tilt.sin(), met[1] + dx * tilt.sin() + dy * tilt.cos()];
        let pose = end(place);
        let nose = front(place, pose);
        let heading = place.goal.heading_rad + tilt;
        let across = (nose[1] - moved[1]) * heading.cos() - (nose[0] - moved[0]) * heading.sin();
        [across, wrapped(pose.heading_rad - heading)]
    }

    /// The choices that bring a robot farthest to the side of its place.
    fn worst(&self, places: &[Place], nth: usize) -> (Choices, [f64; 2]) {
        let mut choices = self.none();
        let score = |choices: &Choices| self.off(places, nth, choices)[0].abs();
        let mut best = score(&choices);
        let involved: Vec<usize> = [0, 1, nth].map(|at| places[at].robot).to_vec();
        let mut attempt = |change: &dyn Fn(&mut Choices), choices: &mut Choices| {
            let mut other = choices.clone();
            change(&mut other);
            let value = score(&other);
            if value > best {
                (best, *choices) = (value, other);
            }
        };
        // The effects of the choices add up except for small terms, so that trying each of them once finds the worst
        // combination.
        for &robot in &involved {
            for axis in 0..3 {
                for sign in [-1.0, 1.0] {
                    attempt(&|choices| choices.begin[robot][axis] = sign, &mut choices);
                }
            }
            for leg in 0..choices.legs.len() {
                for (error, sign) in [(0, -1.0), (0, 1.0), (1, -1.0), (1, 1.0)] {
                    attempt(&|choices| choices.legs[leg][robot][error] = sign, &mut choices);
                }
            }
        }
        let off = self.off(places, nth, &choices);
        (choices, off)
    }

    /// Whether two robots that have not docked yet ever overlap.
    fn collides(&self, places: &[Place], choices: &Choices) -> bool {
        let robots = self.motion.start.poses.len();
        let followed: Vec<Vec<Pose>> = (0..robots).map(|robot| self.followed(robot, choices)).collect();
        let docks =
            |robot: usize| places.iter().find(|place| place.robot == robot).map_or(usize::MAX, |place| place.leg);
        for (at, (state, strokes)) in self.legs().enumerate() {
            for sample in 0..=SAMPLES {
                let driven = strokes * sample as f64 / SAMPLES as f64;
                let body = |robot: usize| {
                    let pose = followed[robot][at];
                    corners(self, robot, self.moved(robot, pose, state, driven, choices.legs[at][robot]))
                };
                for robot in (0..robots).filter(|robot| docks(*robot) > at) {
                    for other in (0..robot).filter(|other| docks(*other) > at) {
                        if overlap(&body(robot), &body(other)) {
                            return true;
                        }
                    }
                }
            }
        }
        false
    }

    /// A reason why some robot does not dock, if the adversary finds one.
    fn defeats(&self) -> Option<String> {
        let (places, docking) = (self.places(), self.order.facts.docking);
        for nth in 1..places.len() {
            let (choices, [across, tilt]) = self.worst(&places, nth);
            let most = if nth < 2 {
                [docking.self_aligning_um, docking.self_aligning_rad]
            } else {
                [docking.tolerance_um, docking.sticking_rad]
            };
            let name = &self.order.robot(places[nth].robot).name;
            if across.abs() > most[0] || tilt.abs() > most[1] {
                return Some(format!("{name} is {across} um and {tilt} rad from its place"));
            }
            if self.collides(&places, &choices) {
                return Some(format!("robots collide while {name} is led astray"));
            }
        }
        None
    }
}

fn corners(adversary: &Adversary, robot: usize, pose: Pose) -> [[f64; 2]; 4] {
    let facts = adversary.order.robot(robot);
    let (sin, cos) = pose.heading_rad.sin_cos();
    let (a, b) = (facts.length_um / 2.0, facts.width_um / 2.0);
    [(a, b), (a, -b), (-a, -b), (-a, b)].map(|(x, y)| [pose.x_um + x * cos - y * sin, pose.y_um + x * sin + y * cos])
}

/// Whether two rectangles overlap: no side of either is a separating axis.
pub fn overlap(one: &[[f64; 2]; 4], other: &[[f64; 2]; 4]) -> bool {
    let mut axes = [one, other]
        .into_iter()
        .flat_map(|body| [0, 1].map(|at| [body[at + 1][0] - body[at][0], body[at + 1][1] - body[at][1]]));
    let span = |body: &[[f64; 2]; 4], axis: [f64; 2]| {
        let along = body.map(|corner| corner[0] * axis[0] + corner[1] * axis[1]);
        (along.iter().copied().fold(f64::INFINITY, f64::min), along.iter().copied().fold(f64::NEG_INFINITY, f64::max))
    };
    !axes.any(|axis| {
        let ((least, most), (other_least, other_most)) = (span(one, axis), span(other, axis));
        most < other_least || other_most < least
    })
}

/// The error bounds of a device times a factor.
fn scaled(errors: Errors, multiple: f64) -> Errors {
    Errors {
        speed_ratio: errors.speed_ratio * multiple,
        turning_rad_per_um: errors.turning_rad_per_um * multiple,
        place_um: errors.place_um * multiple,
        heading_rad: errors.heading_rad * multiple,
        ..errors
    }
}

#[test]
fn no_adversary_defeats_a_plan_within_the_errors_that_it_bears() {
    let mut limited = 0;
    let (mut loosest, mut tightest) = (0.0_f64, f64::INFINITY);
    let all = cases(4);
    for seed in 0..all {
        let bench = Bench::of(&steps(&mut Random::new(77 + seed)));
        let Some(motion) = bench.planned() else { continue };
        let mut order = bench.order().clone();
        let errors = order.facts.errors.expect("they are stated");
        let multiple = tolerated_multiple(&order, &motion);
        if multiple == 0.0 {
            continue;
        }
        limited += 1;
        let defeated = |multiple: f64| {
            Adversary { order: bench.order(), motion: &motion, errors: scaled(errors, multiple) }.defeats()
        };
        assert_eq!(defeated(multiple), None, "case {seed} at {multiple} times the errors");
        // Factor at which the adversary succeeds.
        let needs = (0..25).map(|step| multiple * 1.5_f64.powi(step)).find(|more| defeated(*more).is_some());
        let needs = needs.unwrap_or_else(|| panic!("case {seed}: no errors defeat it"));
        (loosest, tightest) = (loosest.max(needs / multiple), tightest.min(needs / multiple));
        // The controller carries out the plan as written, and simulated robots with errors at the limit all dock.
        std::sync::Arc::make_mut(&mut order.facts).errors = Some(scaled(errors, multiple));
        let report = simulate(&order, &motion, 40, 5, 1).expect("an assembly");
        assert_eq!(report.successes, 40, "case {seed}: {:?}", report.failures);
        // Half the errors are borne with twice the factor.
        std::sync::Arc::make_mut(&mut order.facts).errors = Some(scaled(errors, multiple / 2.0));
        let twice = tolerated_multiple(&order, &motion);
        assert!((1.999..2.001).contains(&twice), "case {seed}: {twice}");
    }
    println!("{limited} of {all} plans have a limit; the adversary needs {tightest:.2} to {loosest:.2} times as much");
    assert!(2 * limited >= all, "only {limited} of {all} plans have a limit");
}
