//! Possible next dockings, given the control states and the bodies at rest.
//!
//! Input: the goals, and a bed. Output: the next moves that the control states, the contacts of goals and the orbit
//! discs of waiting robots allow; whether such moves can lead to the end; and, if none can, the reason. That is no
//! proof that there is no assembly: it covers only those in which robots that are neither docked nor steered orbit in
//! place. Docked robots keep their arms up, which removes control states from later moves, so orders are searched to
//! see whether one leads to the end.

use super::StuckAssembly;
use super::bed::AssemblyState;
use super::pair::{Roles, roles};
use crate::claims::microrobots::Dock;
use crate::device::microrobots::Arm;
use crate::geometry::{Core, Pose, distance};
use crate::plan::microrobots::bound::together::{self, RobotArrival};
use crate::plan::microrobots::free;
use crate::real::Real;
use nalgebra::Point2;
use std::collections::BTreeSet;
use std::f64::consts::TAU;

/// Most sets of docked robots recorded as dead ends; beyond that, an order to the end is assumed to exist.
const MAX_DEAD_ENDS: usize = 64;

/// Next move of an assembly.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AssemblyMove {
    Pair(Roles),
    /// Control states in which it turns and runs straight.
    Single {
        robot: usize,
        states: [usize; 2],
    },
}

impl AssemblyMove {
    /// The robots that dock.
    pub fn robots(&self) -> Vec<usize> {
        match self {
            AssemblyMove::Pair(Roles { first, second, .. }) => vec![*first, *second],
            AssemblyMove::Single { robot, .. } => vec![*robot],
        }
    }
}

/// The goals of an assembly.
pub struct Orders<'a> {
    pub docks: &'a [Dock],
    /// Whether robots that are neither docked nor steered orbit in place.
    pub others_orbit: bool,
}

impl<'a> Orders<'a> {
    /// The goal of a robot that has one.
    pub fn dock(&self, robot: usize) -> &'a Dock {
        self.docks.iter().find(|dock| dock.robot == robot).expect("only robots with goals move")
    }

    /// Goals not yet reached, those of the robots that snap last first.
    pub fn open<'b>(&'b self, bed: &'b AssemblyState) -> impl Iterator<Item = &'a Dock> + 'b {
        let mut open: Vec<&Dock> = self.docks.iter().filter(|dock| !bed.docked[dock.robot]).collect();
        open.sort_by_key(|dock| together::lowering(bed.order, dock.robot).count());
        open.into_iter()
    }

    /// Possible next moves: single robots before pairs.
    pub fn moves(&self, bed: &AssemblyState) -> Vec<AssemblyMove> {
        let open: Vec<&Dock> = self.open(bed).collect();
        let single = |dock: &&Dock| self.single(bed, dock).ok();
        let pairs = open.iter().flat_map(|first| open.iter().map(move |second| (*first, *second)));
        let pair = |(first, second)| self.pair(bed, first, second).ok();
        open.iter().filter_map(single).chain(pairs.filter_map(pair)).collect()
    }

    /// The move that docks a single robot next, or why it cannot.
    fn single(&self, bed: &AssemblyState, dock: &Dock) -> Result<AssemblyMove, StuckAssembly> {
        if !touches_structure(bed, dock) {
            return Err(StuckAssembly::Apart { robot: dock.robot });
        }
        let states = [Arm::Down, Arm::Up].map(|arm| bed.state(&[(dock.robot, arm)]));
        let [Some(turn), Some(straight)] = states else {
            return Err(unsteerable(bed, &[dock.robot], &[&[Arm::Down], &[Arm::Up]]));
        };
        self.keeps_orbits(bed, &[dock])?;
        Ok(AssemblyMove::Single { robot: dock.robot, states: [turn, straight] })
    }

    /// The move that docks two robots together, or why they cannot.
    fn pair(&self, bed: &AssemblyState, first: &Dock, second: &Dock) -> Result<AssemblyMove, StuckAssembly> {
        let apart = first.robot == second.robot || touches_structure(bed, first) || touches_structure(bed, second);
        if apart || !touch(bed, (first.robot, first.goal.pose), (second.robot, second.goal.pose)) {
            return Err(StuckAssembly::Apart { robot: first.robot });
        }
        let robots = [first.robot, second.robot];
        let Some(roles) = roles(bed, first.robot, second.robot) else {
            let arms: [&[Arm]; 3] = [&[Arm::Down, Arm::Down], &[Arm::Up, Arm::Down], &[Arm::Up, Arm::Up]];
            return Err(unsteerable(bed, &robots, &arms));
        };
        self.keeps_orbits(bed, &[first, second])?;
        Ok(AssemblyMove::Pair(roles))
    }

    fn keeps_orbits(&self, bed: &AssemblyState, docks: &[&Dock]) -> Result<(), StuckAssembly> {
        if self.others_orbit { goal_in_orbit(bed, docks) } else { Ok(()) }
    }

    /// Whether all goals remain reachable after this move, judged by control states and bodies at rest.
    pub fn leads_on(&self, bed: &AssemblyState, step: &AssemblyMove) -> bool {
        let mut bed = bed.clone();
        self.carry_out(&mut bed, step);
        self.reaches_end(&bed, &mut BTreeSet::new())
    }

    /// Whether some order of moves docks all open robots. The recursion is as deep as their number.
    fn reaches_end(&self, bed: &AssemblyState, dead_ends: &mut BTreeSet<Vec<bool>>) -> bool {
        if self.open(bed).next().is_none() || dead_ends.len() >= MAX_DEAD_ENDS {
            return true;
        }
        if dead_ends.contains(&bed.docked) {
            return false;
        }
        for step in self.moves(bed) {
            let mut next = bed.clone();
            self.carry_out(&mut next, &step);
            if self.reaches_end(&next, dead_ends) {
                return true;
            }
        }
        dead_ends.insert(bed.docked.clone());
        false
    }

    /// Reason why no order of moves reaches all goals: that of the order that gets farthest. `None` if some order does.
    pub fn dead_end(&self, bed: &AssemblyState) -> Option<StuckAssembly> {
        if self.reaches_end(bed, &mut BTreeSet::new()) {
            return None;
        }
        let mut ends = vec![bed.clone()];
        for step in self.moves(bed) {
            let mut end = bed.clone();
            self.carry_out(&mut end, &step);
            self.exhaust(&mut end);
            ends.push(end);
        }
        let end = ends.iter().min_by_key(|end| self.open(end).count())?;
        self.open(end).next()?;
        let open: Vec<&Dock> = self.open(end).collect();
        let singles = open.iter().filter_map(|dock| self.single(end, dock).err());
        let pairs = open.iter().flat_map(|first| open.iter().map(move |second| (*first, *second)));
        let reasons = singles.chain(pairs.filter_map(|(first, second)| self.pair(end, first, second).err()));
        reasons.min_by_key(|stuck| match stuck {
            StuckAssembly::GoalInOrbit { .. } => 0,
            StuckAssembly::Unsteerable { .. } => 1,
            StuckAssembly::Apart { .. } => 2,
            StuckAssembly::Blocked { .. }
            | StuckAssembly::Untimely { .. }
            | StuckAssembly::NoPath { .. }
            | StuckAssembly::NoOrbit { .. }
            | StuckAssembly::Coarse { .. }
            | StuckAssembly::Loose { .. }
            | StuckAssembly::GaveUp => 3,
        })
    }

    /// Carries out moves until none is left.
    fn exhaust(&self, bed: &mut AssemblyState) {
        while let Some(step) = self.moves(bed).first() {
            self.carry_out(bed, step);
        }
    }

    /// Places robots at their goals.
    pub fn carry_out(&self, bed: &mut AssemblyState, step: &AssemblyMove) {
        let mut put = |robot: usize| {
            bed.poses[robot] = self.dock(robot).goal.pose;
            bed.docked[robot] = true;
        };
        match step {
            AssemblyMove::Pair(roles) => {
                put(roles.first);
                put(roles.second);
            }
            AssemblyMove::Single { robot, .. } => put(*robot),
        }
    }
}

/// Failure to steer robots, with the first other robot that prevents it.
fn unsteerable(bed: &AssemblyState, robots: &[usize], patterns: &[&[Arm]]) -> StuckAssembly {
    let arm = |state: usize, robot: usize| bed.order.states[state].arms[bed.order.robots[robot].row];
    let steers =
        |state: usize, pattern: &[Arm]| robots.iter().zip(pattern).all(|(robot, wanted)| arm(state, *robot) == *wanted);
    let states = 0..bed.order.states.len();
    let holds = |other: usize, pattern: &[Arm]| {
        states.clone().any(|state| steers(state, pattern) && arm(state, other) == Arm::Down)
    };
    let orbiting = bed.others(robots).find(|other| !patterns.iter().all(|pattern| holds(*other, pattern)));
    StuckAssembly::Unsteerable { robots: robots.to_vec(), orbiting }
}

/// Checks that goals keep clear of the discs of the robots that orbit meanwhile.
fn goal_in_orbit(bed: &AssemblyState, docks: &[&Dock]) -> Result<(), StuckAssembly> {
    let steered: Vec<usize> = docks.iter().map(|dock| dock.robot).collect();
    for orbiting in bed.others(&steered) {
        let facts = bed.robot(orbiting);
        let [x_um, y_um] = facts.orbit_centre_um(bed.poses[orbiting]);
        let centre = Core::Point(Point2::new(x_um, y_um));
        for dock in docks.iter().filter(|dock| orbits_meanwhile(bed, orbiting, dock)) {
            let robot = bed.robot(dock.robot);
            let body = bed.outline(dock.robot, dock.goal.pose);
            let gap_um = distance::quadrilateral_core(body, &centre) - facts.orbit_reach_um();
            let corner_um = robot.length_um.hypotenuse(robot.width_um) / 2.0;
            let precision = bed.order.precision;
            let give_um = precision.place_um + corner_um * precision.heading_rad;
            if gap_um < bed.order.facts.orbit_clearance_um - give_um {
                return Err(StuckAssembly::GoalInOrbit { robot: dock.robot, orbiting, gap_um });
            }
        }
    }
    Ok(())
}

/// Whether an orbiting robot completes a full turn while another one takes its shortest path to its goal; otherwise
/// nothing needs to keep clear of its disc.
fn orbits_meanwhile(bed: &AssemblyState, orbiting: usize, dock: &Dock) -> bool {
    let (facts, robot) = (bed.robot(orbiting), bed.robot(dock.robot));
    let RobotArrival { from, to, .. } = RobotArrival::of(bed.order, dock.robot, bed.poses[dock.robot], dock.goal.pose);
    let least_um = free::least_um(robot, from, to);
    least_um / robot.step_um * facts.step_um >= TAU * facts.turning_radius_um
}

fn touches_structure(bed: &AssemblyState, dock: &Dock) -> bool {
    let docked = (0..bed.poses.len()).filter(|robot| bed.docked[*robot]);
    docked.into_iter().any(|other| touch(bed, (dock.robot, dock.goal.pose), (other, bed.poses[other])))
}

/// Whether two bodies are close enough to dock.
fn touch(bed: &AssemblyState, one: (usize, Pose), other: (usize, Pose)) -> bool {
    bed.gap_um(one, other) <= bed.order.facts.docking.tolerance_um
}
