//! Motion of the robots of a bed: the legs of all plans, and poses along them.
//!
//! The recorded states are the poses at the start of each leg; between them the robots follow their circles and lines
//! while the drive train lasts, and otherwise stand still. The number of poses is bounded for every plan.

use crate::claims::microrobots::{MicrorobotsAction, MicrorobotsOrder, MicrorobotsStop};
use crate::device::microrobots::{Arm, Robot};
use crate::emit::motion;
use crate::geometry::Pose;
use crate::schedule::microrobots::MicrorobotsState;
use crate::schedule::{Actuation, PlanRecord, Schedule, State};
use crate::verify::Verified;
use nalgebra::Point2;
use std::f64::consts::TAU;

/// Greatest distance of a robot between two poses, unless there would be too many.
const STEP_UM: f64 = 20.0;

/// Greatest turn of a robot between two poses, unless there would be too many.
const TURN_RAD: f64 = TAU / 72.0;

/// Approximate limit of poses for all robots, besides those at the ends of legs.
pub const MAX_POSES: usize = 100_000;

/// Rounding of the sum of path lengths, as a share of a turn.
const TURN_ROUNDING: f64 = 1e-9;

/// Distance from the middle of a robot to the base of its nose, as a share of its length.
const NOSE_PART: f64 = 0.2;

/// Motion of a bed in all plans.
pub struct BedMotion<'a> {
    /// Names of the robots on the bed, in the order of the table.
    pub robots: Vec<String>,
    /// In order of time.
    pub plans: Vec<BedPlanMotion<'a>>,
}

/// Motion of a bed in one plan.
pub struct BedPlanMotion<'a> {
    pub order: &'a MicrorobotsOrder,
    pub start_ns: u64,
    pub legs: Vec<ControlLeg<'a>>,
    /// In order of time; the first one is that of the first state.
    pub moments: Vec<BedMoment>,
}

/// The poses of all robots at an instant.
pub struct BedMoment {
    pub t_ns: u64,
    pub poses: Vec<Pose>,
}

/// An interval in one control state; also a wait, and the end of a run.
pub struct ControlLeg<'a> {
    pub start_ns: u64,
    pub end_ns: u64,
    pub control: usize,
    /// By row of the table.
    pub arms: &'a [u8],
    /// Start and end of its drive train, if it has one.
    pub train_ns: Option<[u64; 2]>,
    pub movers: Vec<RobotInLeg>,
}

/// A robot in a leg.
pub struct RobotInLeg {
    pub pose: Pose,
    pub arm: Arm,
    /// Length of its path in the leg's train, in micrometres.
    pub way_um: f64,
    pub is_docked: bool,
}

/// The disc that a robot sweeps while its arm stays down for a full turn or more.
pub struct SweptDisc {
    pub robot: usize,
    pub start_ns: u64,
    pub end_ns: u64,
    pub centre_um: [f64; 2],
    pub reach_um: f64,
}

impl<'a> BedMotion<'a> {
    /// Motion of a device; empty for one of another kind.
    pub fn new(verified: &'a Verified, device: &str) -> Self {
        let trains = trains(verified.schedule(), device);
        let jobs = motion::jobs(verified, device).into_iter();
        let plans = jobs.filter_map(|(job, plan)| BedPlanMotion::new(MicrorobotsOrder::of(&job.order)?, plan, &trains));
        let mut plans: Vec<BedPlanMotion> = plans.collect();
        let robots = plans.first().map_or_else(Vec::new, |plan| names(plan.order));
        plans.retain(|plan| plan.order.robots.len() == robots.len());
        let wanted = plans.iter().map(BedPlanMotion::wanted).fold(0, usize::saturating_add);
        let most = MAX_POSES / robots.len().max(1);
        for plan in &mut plans {
            plan.moments = moments(plan, most.min(wanted) as f64 / wanted.max(1) as f64);
        }
        // Before the first task the robots stand where it begins.
        if let Some(first) = plans.first_mut().and_then(|plan| plan.moments.first_mut()) {
            first.t_ns = 0;
        }
        BedMotion { robots, plans }
    }

    /// The leg at an instant, with its plan, and the poses of the robots then. Before the first leg they stand where it
    /// begins.
    pub fn at(&self, t_ns: u64) -> Option<(&BedPlanMotion<'a>, &ControlLeg<'a>, Vec<Pose>)> {
        let begun = self.plans.iter().rfind(|plan| plan.start_ns <= t_ns);
        let plan = begun.or_else(|| self.plans.first())?;
        let after = plan.legs.partition_point(|leg| leg.start_ns <= t_ns);
        let leg = plan.legs.get(after.saturating_sub(1))?;
        let share = match leg.train_ns {
            Some([start_ns, end_ns]) if t_ns > start_ns => {
                (t_ns.min(end_ns) - start_ns) as f64 / (end_ns - start_ns) as f64
            }
            Some(_) | None => 0.0,
        };
        Some((plan, leg, leg.poses(plan.order, share)))
    }
}

fn names(order: &MicrorobotsOrder) -> Vec<String> {
    (0..order.robots.len()).map(|robot| order.robot(robot).name.clone()).collect()
}

/// The goal poses of a task, with their robots.
pub fn goals(order: &MicrorobotsOrder) -> impl Iterator<Item = (usize, &MicrorobotsStop)> {
    order.steps.iter().flat_map(|step| match &step.action {
        MicrorobotsAction::Drive { robot, stops } => stops.iter().map(|stop| (*robot, stop)).collect::<Vec<_>>(),
        MicrorobotsAction::Assemble(docks) => docks.iter().map(|dock| (dock.robot, &dock.goal)).collect(),
        MicrorobotsAction::Apply { .. } | MicrorobotsAction::Wait(_) => Vec::new(),
    })
}

/// The corners of a robot's nose in its own frame, the tip first.
pub fn nose_corners(robot: &Robot) -> [Point2<f64>; 3] {
    let (back_um, half_um) = (NOSE_PART * robot.length_um, robot.width_um / 2.0);
    [Point2::new(robot.length_um / 2.0, 0.0), Point2::new(back_um, half_um), Point2::new(back_um, -half_um)]
}

/// The drive trains of a device, in order of time.
fn trains<'a>(schedule: &'a Schedule, device: &str) -> Vec<&'a Actuation> {
    let of_device = |actuation: &&Actuation| {
        let channel = schedule.channels.get(actuation.channel as usize);
        channel.is_some_and(|channel| channel.device == device) && actuation.swing.is_some()
    };
    schedule.actuations.iter().filter(of_device).collect()
}

impl<'a> BedPlanMotion<'a> {
    fn new(order: &'a MicrorobotsOrder, plan: &'a PlanRecord, trains: &[&Actuation]) -> Option<Self> {
        let mut legs = Vec::with_capacity(plan.states.len());
        for (index, timed) in plan.states.iter().enumerate() {
            let State::Microrobots(MicrorobotsState { control, arms, docked, poses }) = &timed.state else {
                return None;
            };
            let end_ns = plan.states.get(index + 1).map_or(plan.end_ns(), |next| next.t_ns);
            let first = trains.partition_point(|train| train.start_ns < timed.t_ns);
            let train = trains.get(first).filter(|train| train.start_ns < end_ns);
            let strokes = train.and_then(|train| Some(train.duration_ns / train.swing?.period_ns.max(1))).unwrap_or(0);
            let body = |robot: usize| {
                let facts = order.robot(robot);
                let is_docked = docked.contains(&facts.name);
                let is_down = arms.get(order.robots[robot].row) == Some(&Arm::Down.digit());
                Some(RobotInLeg {
                    pose: poses.get(&facts.name)?.pose(),
                    arm: if is_down { Arm::Down } else { Arm::Up },
                    way_um: if is_docked { 0.0 } else { facts.step_um * strokes as f64 },
                    is_docked,
                })
            };
            let movers = (0..order.robots.len()).map(body).collect::<Option<Vec<RobotInLeg>>>()?;
            let train_ns = train.map(|train| [train.start_ns, train.end_ns()]);
            legs.push(ControlLeg { start_ns: timed.t_ns, end_ns, control: *control, arms, train_ns, movers });
        }
        Some(BedPlanMotion { order, start_ns: plan.start_ns, legs, moments: Vec::new() })
    }

    /// Number of desired poses per robot.
    fn wanted(&self) -> usize {
        self.legs.iter().map(|leg| leg.wanted(self.order)).fold(0, usize::saturating_add)
    }

    /// The orbits of all robots: an arm that is down in one leg and in the next stays down between them.
    pub fn orbits(&self) -> Vec<SweptDisc> {
        let mut orbits = Vec::new();
        for robot in 0..self.order.robots.len() {
            let orbits_at = |leg: &&ControlLeg| leg.movers[robot].arm == Arm::Down && !leg.movers[robot].is_docked;
            let mut rest = &self.legs[..];
            while let Some(first) = rest.iter().position(|leg| orbits_at(&leg)) {
                let length = rest[first..].iter().take_while(orbits_at).count();
                orbits.extend(self.orbit(robot, &rest[first..first + length]));
                rest = &rest[first + length..];
            }
        }
        orbits
    }

    fn orbit(&self, robot: usize, legs: &[ControlLeg]) -> Option<SweptDisc> {
        let facts = self.order.robot(robot);
        let (first, last) = (legs.first()?, legs.last()?);
        let way_um: f64 = legs.iter().map(|leg| leg.movers[robot].way_um).sum();
        let turns = way_um / (TAU * facts.turning_radius_um);
        (turns >= 1.0 - TURN_ROUNDING).then(|| SweptDisc {
            robot,
            start_ns: first.start_ns,
            end_ns: last.end_ns,
            centre_um: facts.orbit_centre_um(first.movers[robot].pose),
            reach_um: facts.orbit_reach_um(),
        })
    }
}

impl ControlLeg<'_> {
    /// Desired number of parts of its train.
    fn wanted(&self, order: &MicrorobotsOrder) -> usize {
        let parts = self.movers.iter().enumerate().map(|(robot, body)| match body.arm {
            Arm::Up => body.way_um / STEP_UM,
            Arm::Down => body.way_um / order.robot(robot).turning_radius_um / TURN_RAD,
        });
        // Unbounded for extreme figures: the cast saturates.
        parts.fold(0.0, f64::max).ceil() as usize
    }

    /// Poses of all robots after a share of the train.
    fn poses(&self, order: &MicrorobotsOrder, share: f64) -> Vec<Pose> {
        let place = |(robot, body): (usize, &RobotInLeg)| match body.way_um {
            0.0 => body.pose,
            way_um => order.robot(robot).moved(body.pose, body.arm, way_um * share),
        };
        self.movers.iter().enumerate().map(place).collect()
    }
}

/// A share of the desired poses of a plan: at its start, at the start of each train, and along the train to its end.
fn moments(plan: &BedPlanMotion, share: f64) -> Vec<BedMoment> {
    let mut moments: Vec<BedMoment> = Vec::new();
    let mut tell = |t_ns: u64, poses: Vec<Pose>| {
        if moments.last().is_none_or(|last| last.t_ns < t_ns) {
            moments.push(BedMoment { t_ns, poses });
        }
    };
    if let Some(first) = plan.legs.first() {
        tell(first.start_ns, first.poses(plan.order, 0.0));
    }
    for leg in &plan.legs {
        let (Some([start_ns, end_ns]), wanted @ 1..) = (leg.train_ns, leg.wanted(plan.order)) else { continue };
        let parts = ((wanted as f64 * share) as u64).clamp(1, end_ns - start_ns);
        tell(start_ns, leg.poses(plan.order, 0.0));
        for part in 1..=parts {
            let passed_ns = u128::from(end_ns - start_ns) * u128::from(part) / u128::from(parts);
            tell(start_ns + passed_ns as u64, leg.poses(plan.order, part as f64 / parts as f64));
        }
    }
    moments
}
