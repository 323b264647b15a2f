//! Builds claims on a bed, and schedules from legs, with an independent lowering, motion in tiny steps, and
//! independent records.

use crate::claims::fixture::bed_order;
use crate::claims::microrobots::{
    Dock, MicrorobotsAction, MicrorobotsObstacle, MicrorobotsOrder, MicrorobotsStep, MicrorobotsStop,
};
use crate::claims::{Claims, Job, Order};
pub use crate::device::microrobots::fixture::pose;
use crate::device::microrobots::{Arm, ControlState, Docking, Fine, MicrorobotsFacts, Robot, Turning, fixture};
use crate::geometry::{Pose, Shape};
use crate::schedule::microrobots::{MicrorobotsState, RecordedPose};
use crate::schedule::{Actuation, Channel, ChannelUnit, PlanRecord, Schedule, State, Swing, TimedState};
use crate::source::Span;
use crate::verify::tests::{self, bare, record_of, step_of};
use std::f64::consts::TAU;

/// Period of a stroke, in nanoseconds.
pub const PERIOD: u64 = 100_000;

/// Dwell time of a level of a control cycle, in nanoseconds.
pub const DWELL: u64 = 5_000_000;

fn robot(name: &str, snap_down_v: f64, release_v: f64) -> Robot {
    Robot { snap_down_v, release_v, length_um: 240.0, ..fixture::robot(name, 100.0, 0.5) }
}

/// The table of the design notes, which is an example and not measured. D4 turns to the other side, and has a wider
/// circle and longer steps.
pub fn facts() -> MicrorobotsFacts {
    let last = Robot {
        turning: Turning::Counterclockwise,
        turning_radius_um: 150.0,
        step_um: 0.625,
        length_um: 200.0,
        ..robot("D4", 150.0, 50.0)
    };
    MicrorobotsFacts {
        period_ns: PERIOD,
        dwell_ns: DWELL,
        docking: Docking { self_aligning_rad: 1.0, self_aligning_um: 80.0, sticking_rad: 0.75, tolerance_um: 5.0 },
        fine: Fine { length_um: 200.0, cycle_um: 20.0 },
        ..fixture::facts(vec![robot("D1", 110.0, 20.0), robot("D2", 110.0, 35.0), robot("D3", 130.0, 35.0), last])
    }
}

/// The five control states of the table.
pub fn states() -> Vec<ControlState> {
    let cycles: [&[f64]; 5] = [&[9.0], &[176.0, 27.5], &[9.0, 120.0], &[9.0, 140.0], &[176.0]];
    fixture::string_states(4, 0.5, |down| cycles[down].to_vec())
}

/// An order with robots by row, x, y and heading.
pub fn order(robots: &[(usize, f64, f64, f64)]) -> MicrorobotsOrder {
    let place = |(row, x, y, deg): &(usize, f64, f64, f64)| (*row, pose(*x, *y, *deg));
    bed_order(facts(), states(), robots.iter().map(place))
}

pub fn stop(pose: Pose) -> MicrorobotsStop {
    MicrorobotsStop { pose, span: Span::default(), origin: None }
}

pub fn obstacle(name: &str, shape: Shape, pose: Pose) -> MicrorobotsObstacle {
    MicrorobotsObstacle { name: name.into(), shape, pose, span: Span::default() }
}

/// Tasks of one device, one after the other.
pub fn in_turn(orders: Vec<MicrorobotsOrder>) -> Claims {
    tests::in_turn("fleet", orders.into_iter().map(Order::Microrobots))
}

pub fn order_of(claims: &mut Claims, job: usize) -> &mut MicrorobotsOrder {
    let Order::Microrobots(order) = &mut claims.jobs[job].order else { panic!("an order of a bed") };
    order
}

/// A control state, its strokes, and the robots that dock at the end.
#[derive(Debug, Clone)]
pub struct Leg {
    pub state: usize,
    pub strokes: u64,
    pub docks: Vec<usize>,
    /// Pause without voltage before the leg.
    pub pause_ns: u64,
    /// Time in addition to the dwell time, for each level.
    pub linger_ns: u64,
}

pub fn leg(state: usize, strokes: u64) -> Leg {
    Leg { state, strokes, docks: Vec::new(), pause_ns: 0, linger_ns: 0 }
}

pub fn legs(all: &[(usize, u64)]) -> Vec<Leg> {
    all.iter().map(|(state, strokes)| leg(*state, *strokes)).collect()
}

/// The unicycle model, integrated in tiny steps by the classical Runge-Kutta method.
pub fn carried(robot: &Robot, arm: Arm, from: Pose, path_um: f64) -> Pose {
    let turning_per_um = match (arm, robot.turning) {
        (Arm::Up, _) => 0.0,
        (Arm::Down, Turning::Clockwise) => -1.0 / robot.turning_radius_um,
        (Arm::Down, Turning::Counterclockwise) => 1.0 / robot.turning_radius_um,
    };
    // A straight path needs one step, and whole turns need none.
    let (path_um, longest_um) = match arm {
        Arm::Up => (path_um, path_um.max(1.0)),
        Arm::Down => (path_um % (TAU * robot.turning_radius_um), 0.5),
    };
    let steps = (path_um / longest_um).ceil().max(1.0);
    let h_um = path_um / steps;
    let mut pose = from;
    for _ in 0..steps as u64 {
        let later_rad = pose.heading_rad + turning_per_um * h_um;
        let middle_rad = (pose.heading_rad + later_rad) / 2.0;
        let mean = |f: fn(f64) -> f64| (f(pose.heading_rad) + 4.0 * f(middle_rad) + f(later_rad)) / 6.0;
        pose.x_um += h_um * mean(f64::cos);
        pose.y_um += h_um * mean(f64::sin);
        pose.heading_rad = later_rad;
    }
    pose
}

/// An order while its steps are being written, with the legs that fulfil them.
#[derive(Debug, Clone)]
pub struct Day {
    pub order: MicrorobotsOrder,
    pub legs: Vec<Vec<Leg>>,
    pub poses: Vec<Pose>,
    pub docked: Vec<usize>,
}

impl Day {
    pub fn new(order: MicrorobotsOrder) -> Day {
        let poses = order.robots.iter().map(|robot| robot.pose).collect();
        Day { order, legs: Vec::new(), poses, docked: Vec::new() }
    }

    pub fn go(&mut self, legs: &[Leg]) {
        for leg in legs {
            advance(&self.order, leg, &mut self.poses, &mut self.docked);
        }
        self.legs.push(legs.to_vec());
    }

    fn push(mut self, action: MicrorobotsAction) -> Day {
        self.order.steps.push(MicrorobotsStep { action, span: Span::default() });
        self
    }

    pub fn wait(mut self, duration_ns: u64) -> Day {
        self.legs.push(Vec::new());
        self.push(MicrorobotsAction::Wait(duration_ns))
    }

    pub fn apply(mut self, state: usize, strokes: u64) -> Day {
        self.go(&[leg(state, strokes)]);
        self.push(MicrorobotsAction::Apply { state, duration_ns: strokes * PERIOD })
    }

    /// A step that drives a robot to where the legs bring it.
    pub fn drive(mut self, robot: usize, all: &[(usize, u64)]) -> Day {
        self.go(&legs(all));
        let stops = vec![stop(self.poses[robot])];
        self.push(MicrorobotsAction::Drive { robot, stops })
    }

    /// A step that assembles robots where the legs bring them; some of them dock.
    pub fn assemble(mut self, robots: &[usize], legs: &[Leg]) -> Day {
        self.go(legs);
        let docks = robots.iter().map(|robot| Dock { robot: *robot, goal: stop(self.poses[*robot]) }).collect();
        self.push(MicrorobotsAction::Assemble(docks))
    }

    pub fn both(&self) -> (Schedule, Claims) {
        let claims = in_turn(vec![self.order.clone()]);
        (schedule(&claims, std::slice::from_ref(&self.legs)), claims)
    }
}

fn advance(order: &MicrorobotsOrder, leg: &Leg, poses: &mut [Pose], docked: &mut Vec<usize>) {
    for (index, pose) in poses.iter_mut().enumerate().filter(|(index, _)| !docked.contains(index)) {
        let robot = order.robot(index);
        let arm = states()[leg.state].arms[order.robots[index].row];
        *pose = carried(robot, arm, *pose, robot.step_um * leg.strokes as f64);
    }
    docked.extend(&leg.docks);
}

/// The schedule of these legs, with true records.
pub fn schedule(claims: &Claims, legs: &[Vec<Vec<Leg>>]) -> Schedule {
    let mut writer = Writer { schedule: bare(claims), at_ns: 0, poses: Vec::new(), docked: Vec::new() };
    let channel =
        Channel { name: "fleet.bed".into(), device: "fleet".into(), unit: ChannelUnit::Volt, wire: None, rest_v: 0.0 };
    writer.schedule.channels.push(channel);
    for (index, job) in claims.jobs.iter().enumerate() {
        let Order::Microrobots(order) = &job.order else { panic!("an order of a bed") };
        if index == 0 {
            writer.poses = order.robots.iter().map(|robot| robot.pose).collect();
        }
        writer.run(index, job, order, &legs[index]);
    }
    writer.schedule.duration_ns = writer.at_ns;
    writer.schedule
}

/// A bed while its schedule is being written.
struct Writer {
    schedule: Schedule,
    at_ns: u64,
    poses: Vec<Pose>,
    docked: Vec<usize>,
}

impl Writer {
    fn run(&mut self, index: usize, job: &Job, order: &MicrorobotsOrder, legs: &[Vec<Leg>]) {
        let start_ns = self.at_ns;
        let mut states = Vec::new();
        for (nth, step) in order.steps.iter().enumerate() {
            let step_ns = self.at_ns;
            if let MicrorobotsAction::Wait(duration_ns) = step.action {
                states.push(self.state(order, 0));
                self.at_ns += duration_ns;
            }
            for leg in &legs[nth] {
                self.at_ns += leg.pause_ns;
                states.push(self.state(order, leg.state));
                self.drive(order, leg);
                advance(order, leg, &mut self.poses, &mut self.docked);
            }
            self.schedule.steps.push(step_of(job, index, [step_ns, self.at_ns]));
        }
        states.push(self.state(order, 0));
        let seconds = (self.at_ns - start_ns) as f64 / 1e9;
        let strokes: u64 = legs.iter().flatten().map(|leg| leg.strokes).sum();
        let outcomes = [
            ("time_ns", (self.at_ns - start_ns) as f64),
            ("switches", legs.concat().len() as f64),
            ("strokes", strokes as f64),
        ];
        self.schedule.plans.push(PlanRecord {
            cost: seconds,
            outcomes: outcomes.map(|(name, value)| (name.to_owned(), value)).into(),
            states,
            ..record_of(job, "one_way_dubins", ["time", "s"], [start_ns, self.at_ns])
        });
    }

    fn state(&self, order: &MicrorobotsOrder, control: usize) -> TimedState {
        let name = |robot: usize| order.robot(robot).name.clone();
        let arms = (0..4).map(|row| u8::from(row < control)).collect();
        let mut docked: Vec<String> = self.docked.iter().map(|robot| name(*robot)).collect();
        docked.sort();
        let place = |(robot, pose): (usize, &Pose)| (name(robot), RecordedPose::from(*pose));
        let poses = self.poses.iter().enumerate().map(place).collect();
        TimedState { t_ns: self.at_ns, state: State::Microrobots(MicrorobotsState { control, arms, docked, poses }) }
    }

    fn drive(&mut self, order: &MicrorobotsOrder, leg: &Leg) {
        for level_v in &states()[leg.state].levels_v {
            self.on(order.facts.dwell_ns + leg.linger_ns, [*level_v; 2], None);
        }
        let levels = [order.facts.flex_v, order.facts.relax_v];
        let period_ns = order.facts.period_ns;
        self.on(leg.strokes * period_ns, levels, Some(Swing { period_ns, levels }));
    }

    fn on(&mut self, duration_ns: u64, [from, to]: [f64; 2], swing: Option<Swing>) {
        let step = self.schedule.steps.len() as u32;
        let start_ns = self.at_ns;
        self.schedule.actuations.push(Actuation { channel: 0, start_ns, duration_ns, from, to, swing, step });
        self.at_ns += duration_ns;
    }
}
