//! Tracks the docked robots from step to step; they are known before planning, because goals of assemblies are fixed.
//!
//! The runs of a schedule are walked in order. The places of the other robots depend on the plan.

use super::bodies::{ObstacleSolid, RobotBody, is_too_near};
use super::docking::{self, Docked, GoalLimits, Partner};
use super::errors;
use super::ground::first_near;
use crate::claims::Job;
use crate::claims::ValueOrigin;
use crate::claims::microrobots::{
    Dock, MicrorobotsAction, MicrorobotsObstacle, MicrorobotsOrder, MicrorobotsStop, Placed,
};
use crate::device::microrobots::{Arm, Docking};
use crate::diagnostic::{Diagnostic, Sink};
use crate::source::Span;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Checks the demands of a schedule on docked robots.
pub fn check_beds(jobs: &[Job], sink: &mut Sink) {
    let mut beds: BTreeMap<&str, BedWalk> = BTreeMap::new();
    for job in jobs {
        let Some(order) = MicrorobotsOrder::of(&job.order) else { continue };
        let walk = beds.entry(&job.device).or_insert_with(|| BedWalk::of(order));
        if let Some(name) = walk.odd_robot(order) {
            sink.push(errors::unlike_robots(job.run_span, &job.device, name));
            return;
        }
        walk.enter_scene(job, order).into_iter().for_each(|wrong| sink.push(wrong));
        for step in &order.steps {
            let run = if job.run_span == job.span { step.span } else { job.run_span };
            for diagnostic in walk.advance(&step.action, step.span, order) {
                let at = diagnostic.span().unwrap_or(step.span);
                let diagnostic = errors::given_from(diagnostic, at, origin_of(&step.action, at));
                sink.push(diagnostic.label_elsewhere(run, step.span, "run here"));
            }
        }
    }
}

/// Origin of the stop at a place; `None` too if a `for` puts several stops of different origins there.
fn origin_of(action: &MicrorobotsAction, at: Span) -> Option<&ValueOrigin> {
    let stops: Vec<&MicrorobotsStop> = match action {
        MicrorobotsAction::Wait(_) | MicrorobotsAction::Apply { .. } => Vec::new(),
        MicrorobotsAction::Drive { stops, .. } => stops.iter().collect(),
        MicrorobotsAction::Assemble(docks) => docks.iter().map(|dock| &dock.goal).collect(),
    };
    let mut origins = stops.into_iter().filter(|stop| stop.span == at).map(|stop| stop.origin.as_ref());
    let first = origins.next()?;
    origins.all(|origin| origin == first).then_some(first)?
}

/// State of a bed between two steps.
struct BedWalk {
    /// Start poses of the first scene.
    robots: Arc<Vec<Placed>>,
    /// Obstacles of the scene of the last run.
    obstacles: Arc<Vec<MicrorobotsObstacle>>,
    /// Where robots have docked, by their index.
    docked: BTreeMap<usize, MicrorobotsStop>,
}

impl BedWalk {
    fn of(order: &MicrorobotsOrder) -> BedWalk {
        let (robots, obstacles) = (Arc::clone(&order.robots), Arc::clone(&order.obstacles));
        BedWalk { robots, obstacles, docked: BTreeMap::new() }
    }

    /// A robot that only one of two scenes has.
    fn odd_robot<'o>(&self, order: &'o MicrorobotsOrder) -> Option<&'o str> {
        let rows = |robots: &[Placed]| -> BTreeSet<usize> { robots.iter().map(|placed| placed.row).collect() };
        let (before, now) = (rows(&self.robots), rows(&order.robots));
        let odd = now.symmetric_difference(&before).next()?;
        Some(order.facts.robots[*odd].name.as_str())
    }

    /// Takes over the obstacles of another scene; a docked robot must not lie on one.
    fn enter_scene(&mut self, job: &Job, order: &MicrorobotsOrder) -> Option<Diagnostic> {
        if Arc::ptr_eq(&self.obstacles, &order.obstacles) {
            return None;
        }
        self.obstacles = Arc::clone(&order.obstacles);
        let solids: Vec<Option<ObstacleSolid>> = order.obstacles.iter().map(ObstacleSolid::of).collect();
        self.docked.iter().find_map(|(robot, at)| {
            let body = RobotBody::of(order.robot(*robot), at.pose);
            let (obstacle, _) = first_near(&body, &order.obstacles, &solids, 0.0)?;
            let docked = errors::GoalPlace { robot: order.robot(*robot).name.clone(), span: at.span };
            Some(errors::obstacle_on_docked(job.run_span, &docked, &obstacle.name, obstacle.span))
        })
    }

    /// Checks a step, and docks the robots that it assembles.
    fn advance(&mut self, action: &MicrorobotsAction, span: Span, order: &MicrorobotsOrder) -> Vec<Diagnostic> {
        match action {
            MicrorobotsAction::Wait(_) | MicrorobotsAction::Apply { .. } => Vec::new(),
            MicrorobotsAction::Drive { robot, stops } => {
                if let Some(since) = self.docked.get(robot) {
                    return vec![errors::docked_before(&order.robot(*robot).name, span, "driven", since.span)];
                }
                stops.iter().find_map(|stop| self.on_docked(*robot, stop, order)).into_iter().collect()
            }
            MicrorobotsAction::Assemble(docks) => {
                let found = self.assemble(docks, order);
                self.docked.extend(docks.iter().map(|dock| (dock.robot, dock.goal.clone())));
                found
            }
        }
    }

    /// A stop at which a robot would be too near to one that has docked.
    fn on_docked(&self, robot: usize, stop: &MicrorobotsStop, order: &MicrorobotsOrder) -> Option<Diagnostic> {
        let body = RobotBody::of(order.robot(robot), stop.pose);
        let kept_um = order.facts.clearance_um;
        self.docked.iter().find_map(|(other, at)| {
            let gap_um = body.gap_um(&RobotBody::of(order.robot(*other), at.pose));
            is_too_near(gap_um, kept_um).then(|| {
                let goal = errors::GoalPlace { robot: order.robot(robot).name.clone(), span: stop.span };
                let docked = errors::GoalPlace { robot: order.robot(*other).name.clone(), span: at.span };
                errors::goal_on_docked(&goal, &docked, gap_um, kept_um)
            })
        })
    }

    fn assemble(&self, docks: &[Dock], order: &MicrorobotsOrder) -> Vec<Diagnostic> {
        let again = docks.iter().filter_map(|dock| {
            let since = self.docked.get(&dock.robot)?;
            Some(errors::docked_before(&order.robot(dock.robot).name, dock.goal.span, "assembled", since.span))
        });
        let again: Vec<Diagnostic> = again.collect();
        if !again.is_empty() {
            return again;
        }
        let structure: Vec<Docked> = self.docked.iter().map(|(robot, at)| docked(*robot, at, order)).collect();
        let goals: Vec<Docked> = docks.iter().map(|dock| docked(dock.robot, &dock.goal, order)).collect();
        let limits = GoalLimits { docking: order.facts.docking, flat_rad: order.precision.heading_rad };
        let Some(ranks) = ranks(order) else {
            return in_any_order(&structure, &goals, &limits).into_iter().collect();
        };
        let mut goals = goals;
        goals.sort_by_key(|goal| std::cmp::Reverse(ranks[goal.robot]));
        in_this_order(&structure, &goals, &limits).into_iter().collect()
    }
}

fn docked<'a>(robot: usize, at: &MicrorobotsStop, order: &'a MicrorobotsOrder) -> Docked<'a> {
    Docked { robot, facts: order.robot(robot), pose: at.pose, span: at.span }
}

/// Rank of each robot of the order by snap-down, greater for a later one. `None` unless the states lower one arm after
/// the other, as those of a STRING table do.
fn ranks(order: &MicrorobotsOrder) -> Option<Vec<usize>> {
    let row = |robot: usize| order.robots[robot].row;
    let is_down = |robot: usize| order.states.iter().map(move |state| state.arms[row(robot)] == Arm::Down);
    let lowered = |robot: usize| is_down(robot).filter(|is_down| *is_down).count();
    let lowered: Vec<usize> = (0..order.robots.len()).map(lowered).collect();
    let is_chain = (0..lowered.len()).all(|one| {
        (0..one).all(|other| {
            let (few, many) = if lowered[one] < lowered[other] { (one, other) } else { (other, one) };
            lowered[few] < lowered[many] && is_down(few).zip(is_down(many)).all(|(few, many)| many || !few)
        })
    });
    is_chain.then(|| lowered.iter().map(|lowered| order.states.len() - lowered).collect())
}

/// Fault of goals that are taken in this order.
fn in_this_order(structure: &[Docked], goals: &[Docked], limits: &GoalLimits) -> Option<Diagnostic> {
    let mut before = structure.to_vec();
    for (at, goal) in goals.iter().enumerate() {
        let partner = partner(structure, goals, at, &limits.docking);
        if let Some(misfit) = docking::misfit(goal, &before, partner, limits) {
            return Some(docking::misfit_diagnostic(goal, &before, partner, &misfit, limits));
        }
        before.push(*goal);
    }
    None
}

/// Docking partner of the goal at an index: the first two begin a structure of their own, unless the first one touches
/// another.
fn partner<'a>(structure: &[Docked], goals: &'a [Docked<'a>], at: usize, docking: &Docking) -> Partner<'a> {
    let first = &goals[0];
    let is_new = structure.iter().all(|docked| !docking::touches(first, docked, docking));
    match at {
        0 if is_new => Partner::Nothing,
        1 if is_new => Partner::First(first),
        _ => Partner::Structure,
    }
}

/// Fault of goals where no order is fixed: that of the greedy order that gets furthest.
fn in_any_order(structure: &[Docked], goals: &[Docked], limits: &GoalLimits) -> Option<Diagnostic> {
    let pairs = Pairs::of(structure, goals, limits);
    let orders = (0..goals.len()).map(|first| pairs.order(first));
    let (furthest, _) = orders.max_by_key(|(_, fitting)| *fitting)?;
    let ordered: Vec<Docked> = furthest.into_iter().map(|goal| goals[goal]).collect();
    in_this_order(structure, &ordered, limits)
}

/// Pairwise fits of goals with each other and with a structure, each computed once.
struct Pairs {
    /// For each goal its possible partners: goals, then the structure. `None` where the two overlap.
    fits: Vec<Vec<Option<Fit>>>,
    goals: usize,
}

/// Fit of two bodies that do not overlap.
#[derive(Debug, Clone, Copy)]
struct Fit {
    meets_head_on: bool,
    lies_flat: bool,
    touches: bool,
}

impl Pairs {
    fn of(structure: &[Docked], goals: &[Docked], limits: &GoalLimits) -> Pairs {
        let fit = |one: &Docked, other: &Docked| {
            let alone = std::slice::from_ref(other);
            docking::misfit(one, alone, Partner::Nothing, limits).is_none().then(|| Fit {
                meets_head_on: docking::misfit(one, alone, Partner::First(other), limits).is_none(),
                lies_flat: docking::lies_flat(one, other, limits),
                touches: docking::touches(one, other, &limits.docking),
            })
        };
        let others = || goals.iter().chain(structure);
        let fits = goals.iter().map(|one| others().map(|other| fit(one, other)).collect()).collect();
        Pairs { fits, goals: goals.len() }
    }

    /// A greedy order of the goals that begins with one of them and takes the next that fits as long as there is one,
    /// with the rest at the end; and the number that fit.
    fn order(&self, first: usize) -> (Vec<usize>, usize) {
        let structure = self.goals..self.fits[first].len();
        let is_new = structure.clone().all(|docked| !self.fits[first][docked].is_some_and(|fit| fit.touches));
        let mut docked: Vec<usize> = structure.collect();
        let mut taken = vec![first];
        let mut open: Vec<usize> = (0..self.goals).filter(|goal| *goal != first).collect();
        docked.push(first);
        loop {
            let fits = |goal: &usize| {
                let fits = &self.fits[*goal];
                let is_clear = docked.iter().all(|other| fits[*other].is_some());
                let holds = match (is_new, taken.len()) {
                    (true, 1) => fits[first].is_some_and(|fit| fit.meets_head_on),
                    _ => docked.iter().any(|other| fits[*other].is_some_and(|fit| fit.lies_flat)),
                };
                is_clear && holds
            };
            let Some(at) = open.iter().position(fits) else { break };
            let next = open.remove(at);
            docked.push(next);
            taken.push(next);
        }
        let fitting = taken.len();
        taken.append(&mut open);
        (taken, fitting)
    }
}
