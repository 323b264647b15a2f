//! Visibility graph: pairs of corners between which a robot can run straight, and the shortest polyline lengths over
//! them.
//!
//! An edge has one heading, whatever the turns before and after it, so each pair is tested at most once; most of them
//! are never asked for.

use super::{PathRequest, SHORTEST_UM};
use crate::device::microrobots::Arm;
use crate::plan::microrobots::free::ArmSegment;
use crate::real::Real;

/// Edges between corners, and from them to the goal.
pub(super) struct Graph<'a> {
    request: &'a PathRequest<'a>,
    corners: &'a [[f64; 2]],
    /// Whether a run is free, by the corner where it begins, then by the one where it ends; `None` if not yet tested.
    tested: Vec<Option<bool>>,
    /// Length of the shortest polyline to the goal's turning centre, without turns; infinite if there is none.
    rest_um: Vec<f64>,
}

impl<'a> Graph<'a> {
    pub(super) fn new(request: &'a PathRequest, corners: &'a [[f64; 2]]) -> Self {
        let goal_um = request.facts().orbit_centre_um(request.to);
        let rest_um = corners.iter().map(|corner| last_um(request, *corner, goal_um)).collect();
        let mut graph = Graph { request, corners, tested: vec![None; corners.len() * corners.len()], rest_um };
        graph.settle();
        graph
    }

    /// Whether the run from one corner to another is free.
    pub(super) fn leads(&mut self, from: usize, to: usize) -> bool {
        let test = || is_free(self.request, self.corners[from], self.corners[to]);
        *self.tested[from * self.corners.len() + to].get_or_insert_with(test)
    }

    /// The least length from a corner to the goal's turning centre.
    pub(super) fn rest_um(&self, corner: usize) -> f64 {
        self.rest_um[corner]
    }

    /// Dijkstra's algorithm from the goal, in its dense form. Edges are tested only where they would shorten the rest.
    fn settle(&mut self) {
        let mut open: Vec<usize> = (0..self.corners.len()).collect();
        while !open.is_empty() {
            let by_rest = |a: &usize, b: &usize| self.rest_um[open[*a]].total_cmp(&self.rest_um[open[*b]]);
            let Some(nearest) = (0..open.len()).min_by(by_rest) else { return };
            let to = open.swap_remove(nearest);
            if self.rest_um[to].is_infinite() {
                return;
            }
            for &from in &open {
                let rest_um = self.rest_um[to] + apart_um(self.corners[from], self.corners[to]);
                if rest_um < self.rest_um[from] && self.leads(from, to) {
                    self.rest_um[from] = rest_um;
                }
            }
        }
    }
}

fn apart_um(a: [f64; 2], b: [f64; 2]) -> f64 {
    (b[0] - a[0]).hypotenuse(b[1] - a[1])
}

/// Length of the last run, if it is free.
fn last_um(request: &PathRequest, corner: [f64; 2], goal_um: [f64; 2]) -> f64 {
    let way_um = apart_um(corner, goal_um);
    if way_um <= SHORTEST_UM || is_free(request, corner, goal_um) { way_um } else { f64::INFINITY }
}

fn is_free(request: &PathRequest, a: [f64; 2], b: [f64; 2]) -> bool {
    let way_um = apart_um(a, b);
    if way_um <= SHORTEST_UM {
        return false;
    }
    let from = request.pose_about(a, (b[1] - a[1]).arc_tangent_over(b[0] - a[0]));
    request.world.obstruction(request.robot, from, ArmSegment { arm: Arm::Up, way_um }, request.fixtures).is_none()
}
