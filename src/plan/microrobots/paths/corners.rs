//! Candidate corners of a path's polyline.
//!
//! For each point p that a path may pass around (corners of obstacles and bodies, points around discs): turning centres
//! at the distance from p at which the robot just turns around it, with p inside its orbit; centres at the distance at
//! which the whole orbit stays clear of it; and centres on the lines along which the robot just passes it on either
//! side. In addition: points on the first and the last heading, and a coarse lattice. A candidate is kept only if the
//! robot can be there with some heading.

use super::{PathRequest, SHORTEST_UM, TotallyOrdered};
use crate::device::microrobots::Robot;
use crate::geometry::{Core, Rounded};
use crate::plan::microrobots::free::{self, CentredPose};
use crate::plan::microrobots::world::{MARGIN_UM, OrbitDisc, OrientedRectangle};
use crate::real::Real;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::TAU;

/// Directions around a point.
const DIRECTIONS: usize = 8;

/// Points around a disc.
const POINTS_OF_DISC: usize = 6;

/// Most points that a path may pass around.
const MAX_POINTS: usize = 400;

/// Points per row of the lattice.
const LATTICE: usize = 7;

/// Corners nearer to each other than this coincide.
const SAME_UM: f64 = 1.0;

/// Distance kept beyond the required clearance.
const ROOM_UM: f64 = 0.5 + MARGIN_UM;

/// Corners in the order in which they are tried: those with the shortest paths through them first.
pub(super) struct OrderedCorners {
    /// The others. Most are never needed, so they are not sorted.
    left: BinaryHeap<Reverse<RankedCorner>>,
    kept: Vec<[f64; 2]>,
}

impl OrderedCorners {
    pub(super) fn around(request: &PathRequest) -> Self {
        let mut found = Vec::new();
        let points = points(request);
        points.iter().for_each(|point| around_point(request, point, &mut found));
        along_headings(request, &mut found);
        lattice(request, &points, &mut found);
        let detour = CornerDetour::new(request);
        let ranked = |corner: [f64; 2]| {
            let cost_um = TotallyOrdered(detour.cost_um(corner));
            Reverse(RankedCorner { cost_um, at_um: corner.map(TotallyOrdered) })
        };
        OrderedCorners { left: found.into_iter().map(ranked).collect(), kept: Vec::new() }
    }

    /// The first `count` corners at which the robot can be; fewer if there are no more.
    pub(super) fn first(&mut self, request: &PathRequest, count: usize) -> &[[f64; 2]] {
        while self.kept.len() < count {
            let Some(Reverse(RankedCorner { at_um, .. })) = self.left.pop() else { break };
            let corner = at_um.map(|TotallyOrdered(coordinate_um)| coordinate_um);
            let far = |other: &[f64; 2]| (other[0] - corner[0]).hypotenuse(other[1] - corner[1]) > SAME_UM;
            if self.kept.iter().all(far) && is_usable(request, corner) {
                self.kept.push(corner);
            }
        }
        &self.kept[..self.kept.len().min(count)]
    }
}

/// A corner, ordered by its cost, then by its place.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct RankedCorner {
    cost_um: TotallyOrdered,
    at_um: [TotallyOrdered; 2],
}

/// Paths via a corner without obstacles: a turn and a run to the corner, then the free optimum.
struct CornerDetour<'a> {
    robot: &'a Robot,
    from: CentredPose,
    to: CentredPose,
}

impl<'a> CornerDetour<'a> {
    fn new(request: &PathRequest<'a>) -> CornerDetour<'a> {
        let robot = request.facts();
        CornerDetour { robot, from: CentredPose::of(robot, request.from), to: CentredPose::of(robot, request.to) }
    }

    /// Length of the path; infinite if the turning centre is at the corner already.
    fn cost_um(&self, corner: [f64; 2]) -> f64 {
        let [dx, dy] = [0, 1].map(|axis| corner[axis] - self.from.centre_um[axis]);
        let run_um = dx.hypotenuse(dy);
        if run_um <= SHORTEST_UM {
            return f64::INFINITY;
        }
        let heading_rad = dy.arc_tangent_over(dx);
        let turn_rad = free::turn_rad(self.robot, self.from.heading_rad, heading_rad);
        let there = CentredPose { centre_um: corner, heading_rad, axis: [dx / run_um, dy / run_um] };
        let rest_um = free::distance_about_um(self.robot, there, self.to);
        turn_rad * self.robot.turning_radius_um + run_um + rest_um
    }
}

fn is_usable(request: &PathRequest, corner: [f64; 2]) -> bool {
    (0..2 * DIRECTIONS).any(|direction| {
        let pose = request.pose_about(corner, TAU * direction as f64 / (2 * DIRECTIONS) as f64);
        request.world.obstruction_at(request.robot, pose, request.fixtures).is_none()
    })
}

/// A point that a path may pass around.
struct CornerPoint {
    at_um: [f64; 2],
    /// Clearance of a body from it.
    keep_um: f64,
    /// Heading of an adjacent side.
    heading_rad: f64,
}

fn points(request: &PathRequest) -> Vec<CornerPoint> {
    let [keep_um, orbit_keep_um] = request.world.keeps_um();
    let mut points = Vec::new();
    for body in request.world.obstacles() {
        of_obstacle(body, keep_um, &mut points);
    }
    for body in &request.fixtures.bodies {
        of_rectangle(body, keep_um, &mut points);
    }
    for disc in &request.fixtures.discs {
        of_disc(disc, orbit_keep_um, &mut points);
    }
    points.truncate(MAX_POINTS);
    points
}

fn of_obstacle(body: &Rounded, keep_um: f64, points: &mut Vec<CornerPoint>) {
    let keep_um = keep_um + body.radius_um;
    let side = |a: [f64; 2], b: [f64; 2]| (b[1] - a[1]).arc_tangent_over(b[0] - a[0]);
    match &body.core {
        Core::Point(point) => {
            of_disc(
                &OrbitDisc { centre_um: [point.x, point.y], radius_um: body.radius_um },
                keep_um - body.radius_um,
                points,
            );
        }
        Core::Segment([a, b]) => {
            let heading_rad = side([a.x, a.y], [b.x, b.y]);
            points.extend([a, b].map(|end| CornerPoint { at_um: [end.x, end.y], keep_um, heading_rad }));
        }
        Core::Polygon(corners) => {
            for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
                points.push(CornerPoint { at_um: [a.x, a.y], keep_um, heading_rad: side([a.x, a.y], [b.x, b.y]) });
            }
        }
    }
}

fn of_rectangle(body: &OrientedRectangle, keep_um: f64, points: &mut Vec<CornerPoint>) {
    let heading_rad = body.axis[1].arc_tangent_over(body.axis[0]);
    points.extend(body.corners().map(|at_um| CornerPoint { at_um, keep_um, heading_rad }));
}

fn of_disc(disc: &OrbitDisc, keep_um: f64, points: &mut Vec<CornerPoint>) {
    let [x, y] = disc.centre_um;
    points.push(CornerPoint { at_um: disc.centre_um, keep_um: keep_um + disc.radius_um, heading_rad: 0.0 });
    points.extend((0..POINTS_OF_DISC).filter(|_| disc.radius_um > 1.0).map(|index| {
        let heading_rad = TAU * index as f64 / POINTS_OF_DISC as f64;
        let (sin, cos) = heading_rad.sine_cosine();
        CornerPoint { at_um: [x + disc.radius_um * cos, y + disc.radius_um * sin], keep_um, heading_rad }
    }));
}

fn around_point(request: &PathRequest, point: &CornerPoint, found: &mut Vec<[f64; 2]>) {
    let body = request.world.body(request.robot);
    let radius_um = request.facts().turning_radius_um;
    let [half_length_um, half_width_um] = body.half_um;
    let keep_um = point.keep_um + ROOM_UM;
    let inner_um = radius_um - half_width_um - keep_um;
    let (outer_um, beside_um) = (body.reach_um + keep_um, radius_um + half_width_um + keep_um);
    let beyond_um = half_length_um + keep_um;
    for direction in 0..DIRECTIONS {
        let (sin, cos) = (point.heading_rad + TAU * direction as f64 / DIRECTIONS as f64).sine_cosine();
        let at = |along_um: f64, left_um: f64| {
            [point.at_um[0] + along_um * cos - left_um * sin, point.at_um[1] + along_um * sin + left_um * cos]
        };
        found.push(at(outer_um, 0.0));
        found.extend((inner_um > 0.0).then(|| at(inner_um, 0.0)));
        if direction % 2 == 0 {
            // The centre is on the side to which the robot turns; the point may be between them or on the other side.
            let sign = request.facts().turning.sign();
            for left_um in [sign * beside_um, sign * inner_um] {
                found.extend([at(-beyond_um, left_um), at(beyond_um, left_um)]);
            }
        }
    }
    found.extend((inner_um > 0.0).then_some(point.at_um));
}

/// Points ahead of the start and behind the goal.
fn along_headings(request: &PathRequest, found: &mut Vec<[f64; 2]>) {
    let far_um = 2.0 * free::distance_um(request.facts(), request.from, request.to);
    for (pose, sign) in [(request.from, 1.0), (request.to, -1.0)] {
        let [x, y] = request.facts().orbit_centre_um(pose);
        let (sin, cos) = pose.heading_rad.sine_cosine();
        let mut way_um = request.facts().turning_radius_um / 4.0;
        while way_um < far_um {
            found.push([x + sign * way_um * cos, y + sign * way_um * sin]);
            way_um *= 1.5;
        }
    }
    // The corner of the straight–turn–straight path.
    found.extend(free::words(request.facts(), request.from, request.to).map(|word| {
        let [x, y] = request.facts().orbit_centre_um(request.from);
        let (sin, cos) = (request.from.heading_rad + request.facts().turning.sign() * word.turns_rad[0]).sine_cosine();
        [x + word.runs_um[0] * cos, y + word.runs_um[0] * sin]
    }));
}

fn lattice(request: &PathRequest, points: &[CornerPoint], found: &mut Vec<[f64; 2]>) {
    let reach_um = 2.0 * request.world.body(request.robot).reach_um;
    let ends = [request.from, request.to].map(|pose| request.facts().orbit_centre_um(pose));
    let all = || ends.iter().copied().chain(points.iter().map(|point| point.at_um));
    let low = [0, 1].map(|axis| all().map(|at| at[axis]).fold(f64::INFINITY, f64::min) - reach_um);
    let high = [0, 1].map(|axis| all().map(|at| at[axis]).fold(f64::NEG_INFINITY, f64::max) + reach_um);
    let at = |axis: usize, index: usize| low[axis] + (high[axis] - low[axis]) * index as f64 / (LATTICE - 1) as f64;
    found.extend((0..LATTICE * LATTICE).map(|index| [at(0, index % LATTICE), at(1, index / LATTICE)]));
}
