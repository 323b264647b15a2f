//! Lower bounds on the cost of routes: the sum of the costs of their legs alone, each from the best grasp that it can
//! begin with to the best one that it may end with.
//!
//! Fingers are interchangeable, so a leg that begins at a junction costs the same whichever two of them hold there. Legs that
//! several routes share are searched once. The sum over the legs of a route is an admissible bound.

use super::greedy::{alone, grasp};
use super::route::cheapest_of_few;
use super::{Estimator, GraspAnswer, GraspRequest, GraspSearchLimits, Regrasp, Start, TurnLeg};
use crate::plan::search::Meter;
use std::rc::Rc;
use std::sync::Arc;

/// Most routes whose legs are not searched separately.
const FEW: usize = 4;

/// A leg that was searched alone.
struct KnownLeg<'a> {
    leg: &'a TurnLeg,
    next: Option<&'a TurnLeg>,
    start: Start,
    /// Cost of the leg; `None` if it has no path.
    cost: Option<u64>,
}

/// See [`super::route::RouteBounds`]. The bounds are valid for any limit on reconfigurations.
pub fn bounds(request: &GraspRequest, estimator: Estimator, meter: &mut Meter) -> Option<Vec<Option<u64>>> {
    if request.routes.len() <= FEW {
        return None;
    }
    let mut known: Vec<KnownLeg> = Vec::new();
    let mut bounds = Vec::with_capacity(request.routes.len());
    for route in &request.routes {
        let mut sum = Some(0);
        for (at, leg) in route.iter().enumerate() {
            let start = begins(request, route, at);
            let next = route.get(at + 1).filter(|next| next.entry != Regrasp::Same);
            let cost = match known.iter().find(|known| known.is(leg, next, start)) {
                Some(known) => known.cost,
                None => {
                    let cost = leg_cost(request, leg, next, start, estimator, meter)?;
                    known.push(KnownLeg { leg, next, start, cost });
                    cost
                }
            };
            sum = sum.zip(cost).map(|(sum, cost)| sum + cost);
        }
        bounds.push(sum);
    }
    Some(bounds)
}

impl KnownLeg<'_> {
    fn is(&self, leg: &TurnLeg, next: Option<&TurnLeg>, start: Start) -> bool {
        let same = |one: &TurnLeg, other: &TurnLeg| {
            Arc::ptr_eq(&one.tables, &other.tables)
                && (one.steps, one.lowest, one.highest, one.end)
                    == (other.steps, other.lowest, other.highest, other.end)
        };
        let follows = match (self.next, next) {
            (Some(one), Some(other)) => one.entry == other.entry && Arc::ptr_eq(&one.tables, &other.tables),
            (None, None) => true,
            (Some(_), None) | (None, Some(_)) => false,
        };
        self.start == start && same(self.leg, leg) && follows
    }
}

/// Start of a leg of a route, as far as it affects the cost.
fn begins(request: &GraspRequest, route: &[TurnLeg], at: usize) -> Start {
    match (at, route[at].entry) {
        (0, _) => request.start,
        // A pinned grasp at the end distinguishes the fingers.
        (_, Regrasp::Across { new, .. }) if route[at].end.is_none() => Start::At(grasp(&[0, 1], new)),
        (_, Regrasp::Across { .. } | Regrasp::Same) => Start::Any,
    }
}

/// Cost of a leg alone: `Some(None)` if it has no path, `None` if a budget runs out.
fn leg_cost(
    request: &GraspRequest,
    leg: &TurnLeg,
    next: Option<&TurnLeg>,
    start: Start,
    estimator: Estimator,
    meter: &mut Meter,
) -> Option<Option<u64>> {
    let routes = vec![alone(leg, next)];
    let limits = GraspSearchLimits { gaits: None, looks: Rc::clone(&request.limits.looks) };
    match cheapest_of_few(
        &GraspRequest { fingers: request.fingers, start, routes, costs: request.costs, limits },
        estimator,
        meter,
    ) {
        GraspAnswer::Found(way) => Some(Some(way.cost)),
        GraspAnswer::Impossible(_) => Some(None),
        GraspAnswer::GaveUp(_) => None,
    }
}
