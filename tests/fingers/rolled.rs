//! Independent integration: tips touch an outline that is given by a formula here, and roll on it without slip.
//!
//! None of the crate's geometry is used. At each instant the velocity of the part is the least-squares fit over all
//! tips that carries the touched points along with the tips; it is integrated by the midpoint rule along the motion of
//! the stages. Recorded poses and the figures of `reached` must agree with the result.

use crate::random::{Random, cases};
use crate::support::build;
use nalgebra::{Matrix3, Quaternion, Rotation2, Rotation3, UnitQuaternion, Vector2, Vector3};
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use tweeze::device::fingers::Plane;
use tweeze::schedule::fingers::FingersState;
use tweeze::schedule::{PlanRecord, Reached, Schedule, State};

/// Tolerance of a recorded orientation for each full turn rolled so far.
const TURN_DEG: f64 = 0.01;

/// Tolerance of a recorded position: about what such an angle moves the rim of the part.
const PLACE_UM: f64 = 3e-3;

/// Number of parts into which each straight segment is divided.
const PARTS: u32 = 6;

/// The curve a cos t + b cos 2t + p sin³t, c sin t + q sin 2t, in micrometres; in the plane xz the second coordinate is
/// z.
#[derive(Clone, Copy, Debug)]
struct Outline {
    a: f64,
    b: f64,
    c: f64,
    p: f64,
    q: f64,
}

impl Outline {
    fn text(&self) -> String {
        let Outline { a, b, c, p, q } = self;
        format!(
            "profile {{ x: {a} um * cos(t) + ({b} um) * cos(2 * t) + ({p} um) * sin(t)^3, \
             y: {c} um * sin(t) + ({q} um) * sin(2 * t) }}"
        )
    }

    /// Point and first two derivatives by t, in the coordinates of a plane.
    fn at(&self, plane: Plane, t: f64) -> [Vector2<f64>; 3] {
        let Outline { a, b, c, p, q } = *self;
        let (s, k) = t.sin_cos();
        let (s2, k2) = (2.0 * t).sin_cos();
        let sign = if plane == Plane::Xz { -1.0 } else { 1.0 };
        let place = [a * k + b * k2 + p * s.powi(3), c * s + q * s2];
        let first = [-a * s - 2.0 * b * s2 + 3.0 * p * s * s * k, c * k + 2.0 * q * k2];
        let bend = 3.0 * p * (2.0 * s * k * k - s.powi(3));
        let second = [-a * k - 4.0 * b * k2 + bend, -c * s - 4.0 * q * s2];
        [place, first, second].map(|[x, y]| Vector2::new(x, sign * y))
    }

    /// The parameter of the point of the curve nearest to a given point.
    fn nearest(&self, plane: Plane, point: Vector2<f64>, from: Option<f64>) -> f64 {
        let square = |t: f64| (self.at(plane, t)[0] - point).norm_squared();
        let all = (0..720).map(|index| TAU * f64::from(index) / 720.0);
        let mut t = from.or_else(|| all.min_by(|one, other| square(*one).total_cmp(&square(*other)))).expect("720");
        for _ in 0..40 {
            let [place, first, second] = self.at(plane, t);
            let gap = place - point;
            let step = gap.dot(&first) / (first.norm_squared() + gap.dot(&second));
            t -= step;
            if step.abs() < 1e-14 {
                break;
            }
        }
        t
    }
}

/// The motion segments of each channel of a hand, in order of time.
struct Stages(BTreeMap<(usize, usize), Vec<[f64; 4]>>);

impl Stages {
    fn of(schedule: &Schedule) -> Stages {
        let mut stages: BTreeMap<(usize, usize), Vec<[f64; 4]>> = BTreeMap::new();
        for line in &schedule.actuations {
            let name: Vec<&str> = schedule.channels[line.channel as usize].name.split('.').collect();
            let finger: usize = name[1][1..].parse().expect("a finger");
            let axis = ["x", "y", "z"].iter().position(|axis| *axis == name[2]).expect("an axis");
            let (start, end) = (line.start_ns as f64, line.end_ns() as f64);
            stages.entry((finger - 1, axis)).or_default().push([start, end, line.from, line.to]);
        }
        Stages(stages)
    }

    fn tip_um(&self, finger: usize, t_ns: f64) -> Vector3<f64> {
        let axis = |axis: usize| {
            let lines = &self.0[&(finger, axis)];
            let [start, end, from, to] = lines[lines.partition_point(|line| line[1] < t_ns).min(lines.len() - 1)];
            from + (to - from) * ((t_ns - start) / (end - start))
        };
        Vector3::new(axis(0), axis(1), axis(2))
    }

    /// The instants in an interval at which an axis of these fingers begins a new segment, and both ends of the
    /// interval.
    fn instants(&self, fingers: &[usize], [from, to]: [f64; 2]) -> Vec<f64> {
        let lines = self.0.iter().filter(|((finger, _), _)| fingers.contains(finger)).flat_map(|(_, lines)| lines);
        let mut instants: Vec<f64> = lines.flat_map(|line| [line[0], line[1]]).collect();
        instants.retain(|t| (from..=to).contains(t));
        instants.extend([from, to]);
        instants.sort_by(f64::total_cmp);
        instants.dedup();
        instants
    }
}

/// Pose of the part.
#[derive(Clone, Copy)]
struct Pose {
    place: Vector3<f64>,
    turn: Rotation3<f64>,
}

impl Pose {
    /// A point of space in the coordinates of a plane of the part.
    fn seen(&self, plane: Plane, point: Vector3<f64>) -> Vector2<f64> {
        let own = self.turn.inverse() * (point - self.place);
        let [first, second] = plane.axes().map(Vector3::from);
        Vector2::new(own.dot(&first), own.dot(&second))
    }

    fn moved(&self, plane: Plane, shift: Vector2<f64>, turn: f64) -> Pose {
        let [first, second] = plane.axes().map(Vector3::from);
        let place = self.place + self.turn * (first * shift.x + second * shift.y);
        Pose { place, turn: self.turn * Rotation3::new(Vector3::from(plane.normal()) * turn) }
    }
}

/// Shift in the plane and turn, accumulated from a pose.
type Sweep = Vector3<f64>;

/// Rate of the part's motion with its tips, from the pose reached so far; the tips move along straight segments.
fn swept(
    outline: &Outline,
    plane: Plane,
    so_far: &Sweep,
    tips: &[[Vector2<f64>; 2]],
    at: &mut [Option<f64>],
    share: f64,
) -> Sweep {
    let turn = Rotation2::new(so_far.z);
    let (mut square, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for ([from, to], at) in tips.iter().zip(at.iter_mut()) {
        let own = turn.inverse() * (from.lerp(to, share) - so_far.xy());
        let t = outline.nearest(plane, own, *at);
        *at = Some(t);
        let [touch, ..] = outline.at(plane, t);
        let (touch, way) = (turn * touch, to - from);
        for (row, value) in [(Vector3::new(1.0, 0.0, -touch.y), way.x), (Vector3::new(0.0, 1.0, touch.x), way.y)] {
            square += row * row.transpose();
            right += row * value;
        }
    }
    square.try_inverse().expect("two tips that are apart") * right
}

/// The worst deviation of a record, in degrees and micrometres, each per full turn rolled; less than one turn counts as
/// one.
fn deviation(schedule: &Schedule, plan: &PlanRecord, outlines: &BTreeMap<Plane, Outline>) -> [f64; 2] {
    let stages = Stages::of(schedule);
    type Recorded<'a> = (u64, &'a Vec<u32>, Plane, Vector3<f64>, UnitQuaternion<f64>);
    let reported: Vec<Recorded> = plan
        .states
        .iter()
        .map(|timed| match &timed.state {
            State::Fingers(FingersState { grasp, plane, position_um, orientation: [w, x, y, z], .. }) => {
                let turn = UnitQuaternion::from_quaternion(Quaternion::new(*w, *x, *y, *z));
                (timed.t_ns, grasp, *plane, Vector3::from(*position_um), turn)
            }
            other => panic!("a state of a hand: {other:?}"),
        })
        .collect();
    let (_, _, _, place, turn) = reported[0];
    let mut pose = Pose { place, turn: turn.to_rotation_matrix() };
    let (mut worst, mut rolled_rad) = ([0.0_f64; 2], 0.0);
    for pair in reported.windows(2) {
        let (from_ns, before, ..) = pair[0];
        let (to_ns, after, plane, place, turn) = pair[1];
        let holding = |grasp: &[u32]| (0..grasp.len()).filter(|finger| grasp[*finger] > 0).collect::<Vec<usize>>();
        let fingers = holding(before);
        if fingers.len() >= 2 && fingers == holding(after) {
            let instants = stages.instants(&fingers, [from_ns as f64, to_ns as f64]);
            let mut at = vec![None; fingers.len()];
            let (start, mut sweep) = (pose, Sweep::zeros());
            let outline = &outlines[&plane];
            for ends in instants.windows(2) {
                for part in 0..PARTS {
                    let time = |part: u32| ends[0] + (ends[1] - ends[0]) * f64::from(part) / f64::from(PARTS);
                    let seen = |finger: usize, t_ns: f64| start.seen(plane, stages.tip_um(finger, t_ns));
                    let tips: Vec<[Vector2<f64>; 2]> =
                        fingers.iter().map(|finger| [part, part + 1].map(|part| seen(*finger, time(part)))).collect();
                    let half = sweep + swept(outline, plane, &sweep, &tips, &mut at, 0.0) / 2.0;
                    sweep += swept(outline, plane, &half, &tips, &mut at, 0.5);
                }
            }
            pose = start.moved(plane, sweep.xy(), sweep.z);
            rolled_rad += sweep.z.abs();
            // Motion of carried tips across the plane.
            let across = pose.turn * Vector3::from(plane.normal());
            let lift: f64 = fingers
                .iter()
                .map(|finger| {
                    (stages.tip_um(*finger, to_ns as f64) - stages.tip_um(*finger, from_ns as f64)).dot(&across)
                })
                .sum();
            pose.place += across * (lift / fingers.len() as f64);
        }
        let off_deg = UnitQuaternion::from_rotation_matrix(&pose.turn).angle_to(&turn).to_degrees();
        let turns = (rolled_rad / TAU).max(1.0);
        worst = [worst[0].max(off_deg / turns), worst[1].max((pose.place - place).norm() / turns)];
    }
    worst
}

/// A part with one random outline, or two that meet on the x axis, and turns of it.
fn random_case(chance: &mut Random) -> (String, BTreeMap<Plane, Outline>) {
    let small = |chance: &mut Random| chance.thousandths(-1.5, 1.5);
    let a = chance.thousandths(13.0, 15.0);
    let outline = |chance: &mut Random, b: f64| Outline {
        a,
        b,
        c: chance.thousandths(10.0, 13.0),
        p: small(chance),
        q: small(chance),
    };
    let is_flat = chance.below(3) == 0;
    let b = if is_flat { chance.thousandths(-5.0, 0.0) } else { chance.thousandths(-1.0, 1.0) };
    let top = outline(chance, b);
    let mut outlines = BTreeMap::from([(Plane::Xy, top)]);
    let shape = if is_flat {
        top.text()
    } else {
        let side = outline(chance, b);
        outlines.insert(Plane::Xz, side);
        format!("sections {{ xy: {}, xz: {} }}", top.text(), side.text())
    };
    let step = [15, 18, 20, 24, 30][chance.below(5) as usize];
    let mut steps = String::new();
    for index in 0..1 + chance.below(3) {
        let sign = if chance.below(2) == 0 { "" } else { "-" };
        let axis = if is_flat || index % 2 == 0 { "z" } else { "y" };
        steps.push_str(&format!("  rotate part1 by {sign}{} deg about {axis}\n", step * (1 + chance.below(6))));
    }
    let tolerance = [50, 100, 300][chance.below(3) as usize];
    let text = format!(
        "use std.fingers as f\n\
         device hand : f.three_fingers {{ step: {step} deg, tolerance: {tolerance} nm, clearance: 0.5 um, support: 20 uN }}\n\
         scene cell {{ part part1 : {shape} }}\n\
         task turn on hand in cell {{\n  precision: 30 deg\n{steps}}}\n"
    );
    (text, outlines)
}

#[test]
fn recorded_poses_are_where_the_tips_have_rolled_the_part() {
    let cases = cases(24_u32);
    let mut chance = Random::new(1211);
    let (mut planned, mut crossed, mut worst) = (0, 0, [0.0_f64; 2]);
    for case in 0..cases {
        let (text, outlines) = random_case(&mut chance);
        let built = build(&text);
        let known = ["E0542", "E0601", "E0602"];
        assert!(!built.refused, "{:?}\n{text}", built.codes);
        assert!(built.codes.iter().all(|code| known.contains(code)), "{:?}\n{text}", built.codes);
        let Some(verified) = built.schedules.first() else { continue };
        let schedule = verified.schedule();
        let [off_deg, off_um] = deviation(schedule, &schedule.plans[0], &outlines);
        assert!(off_deg <= TURN_DEG && off_um <= PLACE_UM, "case {case}: {off_deg} deg, {off_um} um\n{text}");
        planned += 1;
        crossed += u32::from(outlines.len() > 1 && schedule.steps.len() > 1);
        worst = [worst[0].max(off_deg), worst[1].max(off_um)];
    }
    println!("{planned} of {cases} planned, {crossed} in both planes, at worst {worst:?} deg and um off");
    assert!(planned * 3 >= cases, "{planned} of {cases}");
    assert!(crossed > 0);
}

/// Every turn that a step of the only plan reports as reached: asked, reached, and difference.
fn turns(text: &str) -> Vec<[f64; 3]> {
    let built = build(text);
    assert_eq!(built.codes, Vec::<&str>::new(), "{text}");
    let reached = built.schedules[0].schedule().steps.iter().flat_map(|step| step.reached.clone());
    let turn = |reached: Reached| match reached {
        Reached::Turn { asked_deg, reached_deg, off_deg, .. } => Some([asked_deg, reached_deg, off_deg]),
        Reached::Orientation { .. } | Reached::Place { .. } | Reached::Pose { .. } => None,
    };
    reached.filter_map(turn).collect()
}

/// The angle by which a step turns an ellipse: 360 deg plus the perimeter over the tip's radius, divided by the number
/// of contacts.
fn ellipse_step_deg([a, b]: [f64; 2], tip_radius: f64, contacts: f64) -> f64 {
    let parts = 100_000;
    let speed = |t: f64| (a * t.sin()).hypot(b * t.cos());
    let perimeter: f64 =
        (0..parts).map(|part| speed(TAU * f64::from(part) / f64::from(parts))).sum::<f64>() * TAU / f64::from(parts);
    (TAU + perimeter / tip_radius).to_degrees() / contacts
}

#[test]
fn a_coarse_turn_says_where_it_ends() {
    let text = "use std.fingers as f\ndevice hand : f.three_fingers {}\n\
                scene cell { part bead : ellipsoid { axes: (16 um, 11.845 um, 11.845 um) } }\n\
                task flip on hand in cell {\n  precision: 10 deg\n  rotate bead by 90 deg about z\n}\n";
    let found = turns(text);
    let reached = 4.0 * ellipse_step_deg([16.0, 11.845], 4.5, 74.0);
    assert_eq!(found.len(), 1);
    let [asked, reported, off] = found[0];
    assert!(
        (asked - 90.0).abs() < 1e-9 && (reported - reached).abs() < 1e-6,
        "{reported} deg, {reached} deg by formula"
    );
    assert!((off - (reached - 90.0)).abs() < 1e-6 && off < -9.9, "{off} deg");
}

#[test]
fn an_orientation_says_how_far_it_is_off() {
    let text = "use std.fingers as f\ndevice hand : f.three_fingers {}\n\
                scene cell { part bead : ellipsoid { axes: (16 um, 11.845 um, 11.845 um) } }\n\
                task flip on hand in cell {\n  precision: 6 deg\n  orient bead to euler(85 deg, 0 deg, 0 deg)\n}\n";
    let built = build(text);
    assert_eq!(built.codes, Vec::<&str>::new());
    let step_deg = ellipse_step_deg([16.0, 11.845], 4.5, 74.0);
    match built.schedules[0].schedule().steps[0].reached.as_slice() {
        [Reached::Orientation { off_deg, .. }] => {
            let due = (4.0 * step_deg - 85.0).abs().min((5.0 * step_deg - 85.0).abs());
            // The cheapest way within the precision is taken.
            assert!((off_deg - due).abs() < 1e-6, "{off_deg} deg, {due} deg by formula");
        }
        other => panic!("an orientation: {other:?}"),
    }
}

/// The help of an error suggests a step, with which the program builds.
#[test]
fn the_step_that_is_advised_reaches_the_goal() {
    let program = |step: &str, action: &str| {
        format!(
            "use std.fingers as f\ndevice hand : f.three_fingers {{ step: {step} }}\n\
             scene cell {{ part bead : ellipsoid {{ axes: (16 um, 11.845 um, 11.845 um) }} }}\n\
             task flip on hand in cell {{\n  {action}\n}}\n"
        )
    };
    let actions = [
        ("rotate bead by 90 deg about z", "E0543"),
        ("rotate bead by 90 deg about z\n  rotate bead by 60 deg about y", "E0543"),
        ("rotate bead by 77 deg about y", "E0543"),
        ("orient bead to euler(30 deg, 0 deg, 0 deg)", "E0545"),
        ("rotate bead by 80 deg about x", "E0545"),
    ];
    for (action, code) in actions {
        let (codes, helps) = crate::support::complaints(&program("20 deg", action));
        assert_eq!(codes.first(), Some(&code), "{action}");
        let help = helps.first().cloned().unwrap_or_default();
        let advised = help.split("`step: ").nth(1).and_then(|rest| rest.split('`').next());
        let advised = advised.unwrap_or_else(|| panic!("a step in `{help}`"));
        let (codes, _) = crate::support::complaints(&program(advised, action));
        assert!(codes.iter().all(|code| !["E0543", "E0545"].contains(code)), "{action} with {advised}: {codes:?}");
    }
}
