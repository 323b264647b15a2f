//! A simple, independent search: random first legs of the whole bed, followed by the planner without first legs from
//! where they end. It shows whether a program has a plan at all.

use tweeze::claims::microrobots::{MicrorobotsAction, MicrorobotsOrder};
use tweeze::geometry::Pose;
use tweeze::plan::microrobots::assembly::{self, AssemblyTerms, CYCLES, MAX_PLANS};
use tweeze::plan::microrobots::drive::{self, DriveRequest};
use tweeze::plan::microrobots::world::{BedPoses, CollisionWorld};
use tweeze::plan::microrobots::{Leg, legs_ns};
use tweeze::plan::search::{Meter, SearchBudget};
use tweeze::random::SplitMix64;

/// Random sequences of first legs tried before the search gives up.
const DRAWS: usize = 1_500;

/// Most legs of one sequence.
const MAX_LEGS: usize = 5;

/// Longest path of one leg.
const SPAN_UM: f64 = 3_000.0;

/// Budget of the planner from the end of each sequence.
const STEPS: u64 = 50_000;

/// Legs of the only step, planned without first legs.
pub fn direct(order: &MicrorobotsOrder, start: &[Pose], steps: u64) -> Option<Vec<Leg>> {
    let (budget, docked) = (SearchBudget::of(steps), vec![false; start.len()]);
    match &order.steps.first()?.action {
        MicrorobotsAction::Assemble(docks) => {
            let terms = AssemblyTerms { fine: CYCLES, most_stages: MAX_PLANS };
            let found = assembly::assemble(order, start, &docked, None, docks, &mut Meter::new(budget), terms);
            found.ok().map(|found| found.legs)
        }
        MicrorobotsAction::Drive { robot, stops } => {
            let stops: Vec<Pose> = stops.iter().map(|stop| stop.pose).collect();
            let (world, bed) = (CollisionWorld::new(order), BedPoses::new(start.to_vec(), docked));
            let request = DriveRequest { order, world: &world, bed: &bed, robot: *robot, stops: &stops };
            drive::drive(&request, budget).ok().map(|found| found.legs)
        }
        MicrorobotsAction::Apply { .. } | MicrorobotsAction::Wait(_) => None,
    }
}

/// The duration of a plan without first legs, in seconds.
pub fn direct_s(order: &MicrorobotsOrder) -> Option<f64> {
    let legs = direct(order, &start(order), order.expansions)?;
    Some(legs_ns(order, &legs) as f64 / 1e9)
}

fn start(order: &MicrorobotsOrder) -> Vec<Pose> {
    order.robots.iter().map(|placed| placed.pose).collect()
}

/// Whether some sequence of first legs leads to a plan.
pub fn has_plan(order: &MicrorobotsOrder) -> bool {
    let (world, start) = (CollisionWorld::new(order), start(order));
    let docked = vec![false; start.len()];
    let mut random = SplitMix64::new(99);
    (0..DRAWS).any(|_| {
        let mut legs: Vec<Leg> = Vec::new();
        for _ in 0..random.below(MAX_LEGS + 1) {
            let state = random.below(world.state_count());
            let way_um = SPAN_UM * random.unit() * random.unit();
            if legs.last().is_none_or(|last| last.state != state) {
                legs.push(Leg { state, strokes: (way_um / order.robot(0).step_um) as u64 + 1 });
            }
        }
        if world.first_collision(&start, &docked, &legs, &[]).is_some() {
            return false;
        }
        let mut poses = start.clone();
        legs.iter().for_each(|leg| world.advance(&mut poses, &docked, *leg));
        let Some(later) = direct(order, &poses, STEPS) else { return false };
        let drives = legs.last().is_none_or(|last| last.state != later[0].state);
        let all: Vec<Leg> = legs.into_iter().chain(later).collect();
        let docks = docks(order, &all, &start);
        drives && world.first_collision(&start, &docked, &all, &docks).is_none()
    })
}

/// The leg at whose end each robot of an assembly docks: the first that ends within the precision of its goal.
fn docks(order: &MicrorobotsOrder, legs: &[Leg], start: &[Pose]) -> Vec<tweeze::plan::microrobots::RobotDocking> {
    let Some(MicrorobotsAction::Assemble(docks)) = order.steps.first().map(|step| &step.action) else {
        return Vec::new();
    };
    let mut found = Vec::new();
    for dock in docks {
        let mut pose = start[dock.robot];
        let there = legs.iter().position(|leg| {
            pose = leg.carried(order, dock.robot, pose);
            let [dx, dy] = [pose.x_um - dock.goal.pose.x_um, pose.y_um - dock.goal.pose.y_um];
            let turned = (pose.heading_rad - dock.goal.pose.heading_rad).rem_euclid(std::f64::consts::TAU);
            let heading_rad = turned.min(std::f64::consts::TAU - turned);
            dx * dx + dy * dy <= order.precision.place_um * order.precision.place_um
                && heading_rad <= order.precision.heading_rad
        });
        found.extend(there.map(|leg| tweeze::plan::microrobots::RobotDocking { robot: dock.robot, leg }));
    }
    found
}
