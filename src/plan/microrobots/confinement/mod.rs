//! Proof that obstacles confine a robot: every path from its start, or every path to its goal, is shorter than a step
//! needs, whatever control states are driven.
//!
//! Problem: a robot turns to one side only and never backs up, so it may stand in a bay that it cannot leave, or its
//! goal may be in one that cannot be entered. Input: the obstacles, a pose with its slack, and the least path that the
//! step needs. Output: the longest path from there (or to there) and the obstacles that end all paths, or nothing, which
//! proves nothing.
//!
//! Method: the configuration space of the robot, as its heading and the place of its turning centre. The centre rests
//! while the robot turns and moves along the heading while it runs. The headings are cut into slices. In a slice, a
//! robot that runs moves its centre within the slice's directions; one that turns takes its centre to the next slice. So
//! the centres that can be reached are computed slice by slice. A set of centres is a list of intervals of y for each
//! column of x. Within a slice the columns are visited along its direction: an interval is moved on by the least and the
//! greatest slope and cut where the body meets an obstacle. That is tested for cells of the column: a cell is closed if,
//! at its middle and the middle heading, the body is nearer to an obstacle than the clearance by more than any pose of
//! the cell is off. If a slice is reached nowhere, no path turns so far. How far a path can have run by then follows from
//! where the centre can be (`PathPart`); if all paths are shorter than needed, there is no plan. Paths to a goal are
//! paths from it in reversed time: those of a robot that faces and turns the other way.
//!
//! Promise: a proof for every schedule that the verifier accepts, since it is looser than the collision rules by
//! `LOOSE_UM`. Not promised: that a proof is found where there is one; other robots are ignored. Cost: at most
//! `MAX_CELLS` distances to the obstacles for each resolution.

mod columns;

use super::collision_proof::LOOSE_UM;
use super::free::PoseWithin;
use super::world::CollisionWorld;
use crate::geometry::{Pose, Rounded};
use crate::real::Real;
use columns::{ColumnInterval, SliceDirections, SliceRuns, merged};
use rustc_hash::FxHashMap;
use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};

/// Fineness of the slices and cells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resolution {
    /// Side of a cell, as a share of the turning radius.
    side_share: f64,
    /// Number of slices in a full turn; a multiple of 4, so that no slice has directions to both sides of a column.
    slices: u32,
}

/// Resolutions to be tried in turn. A centre may seem to gain up to a side in each slice, so finer cells come with few
/// more slices.
pub const RESOLUTIONS: [Resolution; 3] = [
    Resolution { side_share: 0.04, slices: 240 },
    Resolution { side_share: 0.015, slices: 360 },
    Resolution { side_share: 0.005, slices: 360 },
];

/// Most cells that are tested at one resolution.
const MAX_CELLS: usize = 1_000_000;

/// Full turns after which a robot counts as free.
const MAX_TURNS: u32 = 2;

/// Turning radii from the pose beyond which a turning centre counts as free.
const FAR_SHARE: f64 = 8.0;

/// Turn after which a path's next part begins.
const PART_RAD: f64 = 1.2;

/// The end of the paths that is near the given pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PathEnd {
    Start,
    Goal,
}

/// Question whether obstacles confine a robot.
#[derive(Debug, Clone, Copy)]
pub struct ConfinementQuestion<'a> {
    pub world: &'a CollisionWorld,
    pub robot: usize,
    /// Where the paths begin or end.
    pub near: PoseWithin,
    pub end: PathEnd,
    /// Least path of any plan.
    pub needed_um: f64,
}

/// A robot that cannot be driven far from its start, or come from far to its goal.
#[derive(Debug, Clone, PartialEq)]
pub struct Confinement {
    pub end: PathEnd,
    pub robot: usize,
    /// Indices of the obstacles that it meets, ascending; every longer path meets one of them.
    pub obstacles: Vec<usize>,
    /// Upper limit of the path.
    pub way_um: f64,
}

impl ConfinementQuestion<'_> {
    /// Proves that every path that begins or ends near the pose is shorter than needed; `None` if there is no such
    /// proof.
    pub fn confinement(&self, resolutions: &[Resolution]) -> Option<Confinement> {
        resolutions.iter().find_map(|resolution| ConfigurationSpace::new(self, *resolution).confinement())
    }
}

/// The configuration space of one robot, cut into slices and cells.
struct ConfigurationSpace<'a> {
    question: &'a ConfinementQuestion<'a>,
    /// Heading in which the paths begin, or that against which those to a goal end.
    heading_rad: f64,
    /// Turning radius, positive for a turn to the left; in reversed time for paths to a goal.
    curve_um: f64,
    /// Turning centre at the pose.
    centre_um: [f64; 2],
    side_um: f64,
    slices: u32,
    obstacles: Vec<&'a Rounded>,
    /// Number of cells tested.
    tested: usize,
    /// Obstacles that closed one of them.
    met: BTreeSet<usize>,
}

/// A part of all paths, in which the robot turns by little more than [`PART_RAD`].
///
/// In it the heading is at most half of that away from the bisector of the first and the last heading. So a run moves
/// the turning centre along the bisector by at least the cosine of that half times its length.
struct PathPart {
    /// Upper limit of the path run before it.
    before_um: f64,
    /// Turning centres at its beginning.
    from: Vec<ColumnInterval>,
    /// Number of slices turned before it.
    first: u32,
}

impl<'a> ConfigurationSpace<'a> {
    fn new(question: &'a ConfinementQuestion<'a>, resolution: Resolution) -> ConfigurationSpace<'a> {
        let facts = &question.world.body(question.robot).robot;
        let (back_rad, sense) = match question.end {
            PathEnd::Start => (0.0, facts.turning.sign()),
            PathEnd::Goal => (PI, -facts.turning.sign()),
        };
        ConfigurationSpace {
            question,
            heading_rad: question.near.pose.heading_rad + back_rad,
            curve_um: sense * facts.turning_radius_um,
            centre_um: facts.orbit_centre_um(question.near.pose),
            side_um: resolution.side_share * facts.turning_radius_um,
            slices: resolution.slices,
            obstacles: question.world.obstacles().collect(),
            tested: 0,
            met: BTreeSet::new(),
        }
    }

    fn slice_rad(&self) -> f64 {
        TAU / f64::from(self.slices)
    }

    fn confinement(mut self) -> Option<Confinement> {
        let sense = self.curve_um.signum();
        let slack_rad = sense * self.question.near.slack.heading_rad;
        let slice = |heading_rad: f64| (heading_rad / self.slice_rad()).floor() as i64;
        let first = slice(self.heading_rad - slack_rad);
        let slack_slices = first.abs_diff(slice(self.heading_rad + slack_rad));
        // The edge of the first slice from which the robot turns.
        let from_rad = (if sense > 0.0 { first } else { first + 1 }) as f64 * self.slice_rad();
        let mut part = PathPart { before_um: 0.0, from: self.begun(), first: 0 };
        let (mut reached, mut way_um): (Vec<ColumnInterval>, f64) = (Vec::new(), 0.0);
        for turned in 0..MAX_TURNS * self.slices {
            let begins = u64::from(turned) <= slack_slices;
            if begins {
                reached.extend(self.begun());
                reached = merged(reached);
            }
            reached = self.runs(first + i64::from(turned) * sense as i64, &reached)?;
            if reached.is_empty() && !begins {
                let ConfinementQuestion { end, robot, .. } = *self.question;
                return Some(Confinement { end, robot, obstacles: self.met.into_iter().collect(), way_um });
            }
            let [before_rad, turn_rad] = [part.first, turned + 1].map(|slices| f64::from(slices) * self.slice_rad());
            let half_rad = (turn_rad - before_rad) / 2.0;
            let bisector_rad = from_rad + sense * (before_rad + half_rad);
            let along_um = self.greatest(&reached, bisector_rad) + self.greatest(&part.from, bisector_rad + PI);
            let run_um = part.before_um + along_um.max(0.0) / half_rad.cosine();
            way_um = way_um.max(run_um + turn_rad * self.curve_um.abs());
            if way_um >= self.question.needed_um {
                return None;
            }
            if 2.0 * half_rad >= PART_RAD {
                part = PathPart { before_um: run_um, from: reached.clone(), first: turned + 1 };
            }
        }
        None
    }

    /// The greatest component of turning centres along a direction, from the middle; minus infinity for none.
    fn greatest(&self, centres: &[ColumnInterval], direction_rad: f64) -> f64 {
        let (sin, cos) = direction_rad.sine_cosine();
        let of = |interval: &ColumnInterval| {
            let x = [interval.column, interval.column + 1].map(|column| column as f64 * self.side_um * cos);
            let y = interval.range_um.map(|y_um| y_um * sin);
            x[0].max(x[1]) + y[0].max(y[1])
        };
        centres.iter().map(of).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The turning centres within the slack.
    fn begun(&self) -> Vec<ColumnInterval> {
        let slack = self.question.near.slack;
        let wide_um = slack.place_um + self.curve_um.abs() * slack.heading_rad;
        let [x, y] = self.centre_um;
        let column = |x_um: f64| (x_um / self.side_um).floor() as i64;
        let interval = |column| ColumnInterval { column, range_um: [y - wide_um, y + wide_um] };
        (column(x - wide_um)..=column(x + wide_um)).map(interval).collect()
    }

    /// The turning centres reached from some in the same slice; `None` if one is far from the pose, or if too many
    /// cells were tested.
    fn runs(&mut self, slice: i64, from: &[ColumnInterval]) -> Option<Vec<ColumnInterval>> {
        let slices = i64::from(self.slices);
        let directions = SliceDirections::new(slice.rem_euclid(slices), self.slice_rad(), self.side_um);
        let [x, y] = self.centre_um;
        let far_um = FAR_SHARE * self.curve_um.abs();
        let mut sources: Vec<&ColumnInterval> = from.iter().collect();
        sources.sort_by_key(|interval| interval.column * directions.forward);
        let mut sources = sources.into_iter().peekable();
        let mut runs = SliceRuns::new([y - far_um, y + far_um]);
        let mut moving: Vec<ColumnInterval> = Vec::new();
        while let Some(column) = moving.first().or(sources.peek().copied()).map(|first| first.column) {
            let mut cells: FxHashMap<i64, bool> = FxHashMap::default();
            let mut is_closed =
                |row: i64| *cells.entry(row).or_insert_with(|| self.is_closed(directions.middle_rad, [column, row]));
            for interval in &moving {
                directions.cross(interval, false, &mut is_closed, &mut runs);
            }
            while let Some(source) = sources.next_if(|source| source.column == column) {
                directions.cross(source, true, &mut is_closed, &mut runs);
            }
            let is_far = runs.is_far || (column as f64 * self.side_um - x).abs() > far_um;
            if is_far || self.tested > MAX_CELLS {
                return None;
            }
            moving = merged(std::mem::take(&mut runs.next));
        }
        Some(merged(runs.reached))
    }

    /// Whether the body is too near to an obstacle in every pose of a cell.
    fn is_closed(&mut self, heading_rad: f64, cell: [i64; 2]) -> bool {
        self.tested += 1;
        let ConfinementQuestion { world, robot, .. } = *self.question;
        let [x, y] = cell.map(|index| (index as f64 + 0.5) * self.side_um);
        let (sin, cos) = heading_rad.sine_cosine();
        let pose = Pose { x_um: x + self.curve_um * sin, y_um: y - self.curve_um * cos, heading_rad };
        let body = world.rectangle(robot, pose);
        let half_um = self.side_um / 2.0;
        // All points of the body turn about the turning centre; none is farther from it than `reach_um`.
        let off_um = half_um.hypotenuse(half_um) + world.body(robot).reach_um * self.slice_rad() / 2.0;
        let near_um = world.keeps_um()[0] - LOOSE_UM - off_um;
        let met = self.obstacles.iter().position(|obstacle| body.nearly_to_rounded_um(obstacle, near_um) < near_um);
        self.met.extend(met);
        met.is_some()
    }
}

#[cfg(test)]
mod tests;
