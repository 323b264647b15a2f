//! Lowering of legs, and a schedule for the tests of later stages.

use super::*;
use crate::claims::fixture::{self, bed_order};
use crate::claims::microrobots::{Dock, MicrorobotsAction, MicrorobotsObstacle, MicrorobotsStep, MicrorobotsStop};
use crate::claims::{Claims, Order, Timeline};
use crate::device::microrobots::fixture as bed;
use crate::device::microrobots::{Docking as Meeting, Fine, MicrorobotsFacts, Robot, Turning};
use crate::diagnostic::Sink;
use crate::geometry::Pose;
use crate::geometry::Shape;
use crate::lower::lower;
use crate::plan::{Motion, Optimality, Plan, Planned};
use crate::schedule::Schedule;
use crate::schedule::microrobots::{MicrorobotsState, RecordedPose};
use crate::source::{Sources, Span};
use std::sync::Arc;

/// Three robots, the last of which turns in the opposite direction; a stroke of 50 us moves them by 2 um.
pub(crate) fn facts() -> MicrorobotsFacts {
    let robot = |name: &str, snap_down_v: f64, turning| Robot {
        snap_down_v,
        release_v: 250.0 - snap_down_v,
        turning,
        length_um: 120.0,
        ..bed::robot(name, 150.0, 2.0)
    };
    let robots = vec![
        robot("D1", 140.0, Turning::Clockwise),
        robot("D2", 160.0, Turning::Clockwise),
        robot("D3", 180.0, Turning::Counterclockwise),
    ];
    MicrorobotsFacts {
        margin_v: 3.0,
        relax_v: 115.0,
        flex_v: 130.0,
        clearance_um: 20.0,
        orbit_clearance_um: 40.0,
        docking: Meeting { self_aligning_rad: 1.0, self_aligning_um: 80.0, sticking_rad: 0.75, tolerance_um: 2.0 },
        fine: Fine { length_um: 300.0, cycle_um: 30.0 },
        ..bed::facts(robots)
    }
}

/// The levels of the states, each of which lowers one more arm.
const LEVELS_V: [&[f64]; 4] = [&[0.0], &[0.0, 150.0], &[0.0, 170.0], &[200.0]];

/// The claims and the schedule of a task on the bed `m` with these steps; robots that dock have that as their goal.
pub(crate) fn carried(steps: Vec<MicrorobotsStepMotion>) -> (Claims, Schedule) {
    let start = [(0.0, 0.0, 0.0), (600.0, 0.0, 1.5), (0.0, -500.0, -3.0)];
    let start = start.map(|(x_um, y_um, heading_rad)| Pose { x_um, y_um, heading_rad });
    let post = MicrorobotsObstacle {
        name: "post".to_owned(),
        shape: Shape::Box { size_um: [80.0, 40.0] },
        pose: Pose { x_um: -400.0, y_um: 300.0, heading_rad: 0.5 },
        span: Span::default(),
    };
    let states = bed::string_states(3, 2.0, |down| LEVELS_V[down].to_vec());
    let order = MicrorobotsOrder {
        obstacles: Arc::new(vec![post]),
        expansions: 1,
        steps: steps.iter().map(asked).collect(),
        ..bed_order(facts(), states, start.into_iter().enumerate())
    };
    let plan = Plan {
        planner: "one_way_dubins",
        objective: "time",
        unit: "s",
        cost: 0.0,
        bound: 0.0,
        proof: Optimality::Open,
        bounds: Default::default(),
        outcomes: Default::default(),
        remarks: Vec::new(),
        motion: MicrorobotsMotion { start: Crew { poses: start.to_vec(), docked: vec![false; 3] }, steps },
    };
    let jobs = vec![fixture::job("assemble", "m", Order::Microrobots(order))];
    let mut claims = fixture::claims("bed", jobs, Timeline::Run(0));
    claims.wires = [("m.bed".to_owned(), "Dev2/ao0".to_owned())].into();
    let mut sources = Sources::default();
    sources.add("bed.twz", SOURCE);
    let order = MicrorobotsOrder::of(&claims.jobs[0].order).expect("its order");
    let plan = plan.map(|motion| Motion::Microrobots(Planned { order, motion }));
    let schedule = lower(&claims, &[plan], &sources, &mut Sink::default()).expect("a short schedule");
    let last = schedule.plans[0].states.last().expect("the state at the end");
    let State::Microrobots(MicrorobotsState { poses, .. }) = &last.state else { panic!("a state of microrobots") };
    let ends: Vec<Pose> = poses.values().map(RecordedPose::pose).collect();
    if let Order::Microrobots(order) = &mut claims.jobs[0].order {
        order.steps.iter_mut().for_each(|step| aim(step, &ends));
    }
    (claims, schedule)
}

/// The source text of the schedule.
pub(crate) const SOURCE: &str = "task assemble on m { }\n";

/// The step that a motion fulfils, with goal poses still to be filled in.
fn asked(motion: &MicrorobotsStepMotion) -> MicrorobotsStep {
    let goal = || MicrorobotsStop { pose: Pose::at(0.0, 0.0), span: Span::default(), origin: None };
    let action = match motion {
        MicrorobotsStepMotion::Wait(duration_ns) => MicrorobotsAction::Wait(*duration_ns),
        MicrorobotsStepMotion::Legs { docks, .. } if docks.is_empty() => {
            MicrorobotsAction::Drive { robot: 0, stops: vec![goal()] }
        }
        MicrorobotsStepMotion::Legs { docks, .. } => {
            MicrorobotsAction::Assemble(docks.iter().map(|dock| Dock { robot: dock.robot, goal: goal() }).collect())
        }
    };
    MicrorobotsStep { action, span: Span::default() }
}

/// Sets the goals of a step to the poses at which the robots end.
fn aim(step: &mut MicrorobotsStep, ends: &[Pose]) {
    match &mut step.action {
        MicrorobotsAction::Assemble(docks) => docks.iter_mut().for_each(|dock| dock.goal.pose = ends[dock.robot]),
        MicrorobotsAction::Drive { robot, stops } => stops.iter_mut().for_each(|stop| stop.pose = ends[*robot]),
        MicrorobotsAction::Apply { .. } | MicrorobotsAction::Wait(_) => {}
    }
}

/// Two robots turn by more than a full circle; all run straight; after a rest, one turns, and then two of them dock.
pub(crate) fn bed() -> (Claims, Schedule) {
    let leg = |state, strokes| Leg { state, strokes };
    let legs = |legs: Vec<Leg>, docks| MicrorobotsStepMotion::Legs { legs, docks, stages: Vec::new() };
    let docks = vec![RobotDocking { robot: 1, leg: 1 }, RobotDocking { robot: 2, leg: 1 }];
    carried(vec![
        legs(vec![leg(2, 600), leg(0, 200)], Vec::new()),
        MicrorobotsStepMotion::Wait(5_000_000),
        legs(vec![leg(1, 100), leg(0, 150), leg(3, 50)], docks),
    ])
}

#[test]
fn a_leg_is_its_control_cycle_and_one_swing() {
    let (_, schedule) = bed();
    let reported: Vec<_> = schedule
        .actuations
        .iter()
        .map(|actuation| {
            (actuation.start_ns / 1000, actuation.duration_ns / 1000, actuation.from, actuation.swing.is_some())
        })
        .collect();
    let first =
        [(0, 1000, 0.0, false), (1000, 1000, 170.0, false), (2000, 30_000, 130.0, true), (32_000, 1000, 0.0, false)];
    assert_eq!(reported[..4], first);
    let swing = Swing { period_ns: 50_000, levels: [130.0, 115.0] };
    assert!(schedule.actuations.iter().filter_map(|actuation| actuation.swing).all(|found| found == swing));
    assert_eq!(schedule.duration_ns, reported.iter().map(|reported| reported.1 * 1000).sum::<u64>() + 5_000_000);
}

#[test]
fn robots_that_dock_stay_where_they_are() {
    let (_, schedule) = bed();
    let states: Vec<_> = schedule.plans[0].states.iter().map(|timed| &timed.state).collect();
    let [.., before, after] = states[..] else { panic!("two states at least") };
    let (
        State::Microrobots(MicrorobotsState { poses: old, docked, .. }),
        State::Microrobots(MicrorobotsState { poses: new, .. }),
    ) = (before, after)
    else {
        panic!("states of microrobots")
    };
    assert_eq!(docked, &["D2", "D3"]);
    assert_eq!((old["D2"], old["D3"]), (new["D2"], new["D3"]));
    assert_ne!(old["D1"], new["D1"]);
}
