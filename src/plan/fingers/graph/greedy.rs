//! The paper's method: the legs are planned one after the other, each alone and to the cheapest grasp with which the
//! next leg can begin.
//!
//! The path of each leg is optimal alone. The whole may not be, and a route that has a path may be missed, since the
//! next leg may have no path from that end.

use super::route::{bound, cheapest_of_few};
use super::{
    Estimator, FarthestRoute, Grasp, GraspAnswer, GraspPath, GraspRequest, GraspSearchLimits, Regrasp, Start, TurnLeg,
};
use crate::device::fingers::MAX_FINGERS;
use crate::plan::search::{Meter, SearchBudget};
use std::rc::Rc;

/// See [`super::decompose`].
pub fn decompose(request: &GraspRequest, estimator: Estimator, budget: SearchBudget) -> GraspAnswer {
    let mut meter = Meter::new(budget);
    let mut farthest: Option<FarthestRoute> = None;
    for route in 0..request.routes.len() {
        match by_legs(request, route, estimator, &mut meter) {
            GraspAnswer::Impossible(blocked) => {
                if farthest.as_ref().is_none_or(|other| other.leg < blocked.leg) {
                    farthest = Some(blocked);
                }
            }
            GraspAnswer::Found(way) => {
                let one = GraspRequest {
                    limits: GraspSearchLimits { gaits: None, looks: Rc::clone(&request.limits.looks) },
                    ..request.clone()
                };
                return GraspAnswer::Found(GraspPath { bound: bound(&one).unwrap_or(0).min(way.cost), ..way });
            }
            other @ GraspAnswer::GaveUp(_) => {
                return other;
            }
        }
    }
    GraspAnswer::Impossible(farthest.unwrap_or(FarthestRoute::NOWHERE))
}

fn by_legs(request: &GraspRequest, route: usize, estimator: Estimator, meter: &mut Meter) -> GraspAnswer {
    let legs = &request.routes[route];
    let mut way = GraspPath { route, cost: 0, bound: 0, legs: Vec::new(), expanded: 0 };
    let mut start = request.start;
    for (at, leg) in legs.iter().enumerate() {
        let routes = vec![alone(leg, legs.get(at + 1))];
        let limits = GraspSearchLimits { gaits: None, looks: Rc::clone(&request.limits.looks) };
        let alone = GraspRequest { fingers: request.fingers, start, routes, costs: request.costs, limits };
        let nodes = match cheapest_of_few(&alone, estimator, meter) {
            GraspAnswer::Found(part) => {
                way.cost += part.cost;
                way.expanded += part.expanded;
                part.legs.into_iter().next().unwrap_or_default()
            }
            GraspAnswer::Impossible(blocked) => {
                return GraspAnswer::Impossible(FarthestRoute { route, leg: at, ..blocked });
            }
            other @ GraspAnswer::GaveUp(_) => {
                return other;
            }
        };
        let last = nodes.last().map(|node| node.grasp);
        way.legs.push(nodes);
        let entry = legs.get(at + 1).map_or(Regrasp::Same, |next| next.entry);
        match last.and_then(|grasp| carried(grasp, entry)) {
            Some(grasp) => start = Start::At(grasp),
            None => return GraspAnswer::Impossible(FarthestRoute { route, leg: at, ..FarthestRoute::NOWHERE }),
        }
    }
    GraspAnswer::Found(way)
}

/// A leg alone. If it must end at a junction, the next leg follows without its turn, so that the search takes the
/// cheapest of all permutations of fingers.
pub fn alone(leg: &TurnLeg, next: Option<&TurnLeg>) -> Vec<TurnLeg> {
    let crossed = next.filter(|next| next.entry != Regrasp::Same);
    let standing = crossed.map(|next| TurnLeg { steps: 0, end: None, ..next.clone() });
    std::iter::once(TurnLeg { entry: Regrasp::Same, ..leg.clone() }).chain(standing).collect()
}

/// Two fingers on two contacts, counted from 0.
pub fn grasp(fingers: &[usize], contacts: [usize; 2]) -> Grasp {
    let mut grasp = Grasp([0; MAX_FINGERS as usize]);
    fingers.iter().zip(contacts).for_each(|(finger, contact)| grasp.0[*finger] = contact as u16 + 1);
    grasp
}

/// The grasp with which the next leg begins; `None` if it cannot continue.
fn carried(held: Grasp, entry: Regrasp) -> Option<Grasp> {
    let Regrasp::Across { old, new } = entry else { return Some(held) };
    let fingers: Vec<usize> = (0..held.0.len()).filter(|finger| held.contact(*finger).is_some()).collect();
    let contacts: Vec<usize> = fingers.iter().filter_map(|finger| held.contact(*finger)).collect();
    let to = |contact: usize| old.iter().position(|old| *old == contact).map(|at| new[at]);
    match contacts[..] {
        [i, j] if i != j => Some(grasp(&fingers, [to(i)?, to(j)?])),
        _ => None,
    }
}
