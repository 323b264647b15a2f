//! The same problem by brute force: nodes as lists of contacts, all edges read from the tables, Dijkstra's algorithm.

use crate::plan::fingers::graph::{Grasp, GraspNode, GraspPath, GraspRequest, Regrasp, Start, TurnLeg};
use crate::plan::fingers::tables::Tables;
use rustc_hash::FxHashMap;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A node of a route; the angle in steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct OracleNode {
    pub leg: usize,
    pub angle: i32,
    pub grasp: Grasp,
}

fn held(grasp: &Grasp) -> Vec<(usize, usize)> {
    (0..6).filter_map(|finger| grasp.contact(finger).map(|contact| (finger, contact))).collect()
}

fn with(grasp: &Grasp, finger: usize, number: u16) -> Grasp {
    let mut other = *grasp;
    other.0[finger] = number;
    other
}

/// Whether a grasp is a node.
pub fn holds(leg: &TurnLeg, angle: i32, grasp: &Grasp) -> bool {
    let layer = leg.tables.layer((angle - leg.lowest) as usize);
    let tables: &Tables = &leg.tables;
    let held = held(grasp);
    if held.iter().any(|(_, contact)| *contact >= tables.contacts) {
        return false;
    }
    match held[..] {
        [(_, i), (_, j)] => layer.pair.has(tables.two(i, j)),
        [(_, i), (_, j), (_, k)] => layer.triple.has(tables.three(i, j, k)),
        _ => false,
    }
}

fn rolled(leg: &TurnLeg, grasp: &Grasp, by: i32) -> Grasp {
    let count = leg.tables.contacts as i32;
    let mut other = *grasp;
    for (finger, contact) in held(grasp) {
        other.0[finger] = (contact as i32 - by).rem_euclid(count) as u16 + 1;
    }
    other
}

/// Whether a grasp may roll from an angle to the next.
fn rolls(leg: &TurnLeg, angle: i32, grasp: &Grasp) -> bool {
    let layer = leg.tables.layer((angle - leg.lowest) as usize);
    match held(grasp)[..] {
        [(_, i), (_, j)] => layer.roll_pair.has(leg.tables.two(i, j)),
        [(_, i), (_, j), (_, k)] => layer.roll_triple.has(leg.tables.three(i, j, k)),
        _ => false,
    }
}

/// The node of the next leg that corresponds to an end of a leg, if any.
pub fn onward(route: &[TurnLeg], from: OracleNode) -> Option<OracleNode> {
    let OracleNode { leg, angle, grasp } = from;
    let (here, next) = (&route[leg], route.get(leg + 1)?);
    if angle != here.steps || here.end.is_some_and(|end| end != grasp) {
        return None;
    }
    let carried = match next.entry {
        Regrasp::Same => grasp,
        Regrasp::Across { old, new } => {
            let held = held(&grasp);
            if held.len() != 2 || held[0].1 == held[1].1 {
                return None;
            }
            let mut other = Grasp([0; 6]);
            for (finger, contact) in held {
                let at = old.iter().position(|old| *old == contact)?;
                other.0[finger] = new[at] as u16 + 1;
            }
            other
        }
    };
    holds(next, 0, &carried).then_some(OracleNode { leg: leg + 1, angle: 0, grasp: carried })
}

/// All edges from a node, with their costs.
pub fn edges(request: &GraspRequest, route: &[TurnLeg], from: OracleNode) -> Vec<(u64, OracleNode)> {
    let (leg, angle, grasp) = (&route[from.leg], from.angle, from.grasp);
    let count = held(&grasp).len() as u64;
    let (roll, gait) = (count * u64::from(request.costs.roll), u64::from(request.costs.gait));
    let mut found: Vec<(u64, OracleNode)> = Vec::new();
    let up = rolled(leg, &grasp, 1);
    if angle < leg.highest && rolls(leg, angle, &grasp) && holds(leg, angle + 1, &up) {
        found.push((roll, OracleNode { angle: angle + 1, grasp: up, ..from }));
    }
    let down = rolled(leg, &grasp, -1);
    if angle > leg.lowest && holds(leg, angle - 1, &down) && rolls(leg, angle - 1, &down) {
        found.push((roll, OracleNode { angle: angle - 1, grasp: down, ..from }));
    }
    let layer = leg.tables.layer((angle - leg.lowest) as usize);
    match held(&grasp)[..] {
        [(_, i), (_, j)] => {
            for finger in (0..request.fingers).filter(|finger| grasp.0[*finger] == 0) {
                for k in 0..leg.tables.contacts {
                    let other = with(&grasp, finger, k as u16 + 1);
                    if layer.place.has(leg.tables.three(i, j, k)) && holds(leg, angle, &other) {
                        found.push((gait, OracleNode { grasp: other, ..from }));
                    }
                }
            }
        }
        [_, _, _] => {
            for (finger, k) in held(&grasp) {
                let other = with(&grasp, finger, 0);
                let [(_, i), (_, j)] = held(&other)[..] else { unreachable!("two stay") };
                if layer.leave.has(leg.tables.three(i, j, k)) && holds(leg, angle, &other) {
                    found.push((gait, OracleNode { grasp: other, ..from }));
                }
            }
        }
        _ => {}
    }
    found.extend(onward(route, from).map(|next| (0, next)));
    found
}

/// All grasps of a hand on a section, whether they hold or not.
pub fn grasps(fingers: usize, contacts: usize) -> Vec<Grasp> {
    let mut all = vec![Grasp([0; 6])];
    for finger in 0..fingers {
        let longer = all.iter().flat_map(|grasp| (0..=contacts).map(move |number| with(grasp, finger, number as u16)));
        all = longer.filter(|grasp| grasp.holding() <= 3).collect();
    }
    all.retain(|grasp| grasp.holding() >= 2);
    all
}

/// Possible start nodes of a route.
pub fn starts(request: &GraspRequest, route: &[TurnLeg]) -> Vec<OracleNode> {
    let all = match request.start {
        Start::Any => grasps(request.fingers, route[0].tables.contacts),
        Start::At(grasp) => vec![grasp],
    };
    let node = |grasp: Grasp| OracleNode { leg: 0, angle: 0, grasp };
    all.into_iter().filter(|grasp| holds(&route[0], 0, grasp)).map(node).collect()
}

pub fn is_end(route: &[TurnLeg], at: OracleNode) -> bool {
    let leg = &route[at.leg];
    at.leg + 1 == route.len() && at.angle == leg.steps && leg.end.is_none_or(|end| end == at.grasp)
}

/// The least cost of a route and the fewest reconfigurations at this cost, within the limit of reconfigurations; and the farthest
/// leg that is begun.
pub fn dijkstra(request: &GraspRequest, route: &[TurnLeg]) -> (Option<(u64, u32)>, usize) {
    let most = request.limits.gaits;
    // Where they are limited, nodes are distinguished by their number of reconfigurations.
    let place = |at: OracleNode, gaits: u32| (at, most.map_or(0, |_| gaits));
    let mut costs: FxHashMap<(OracleNode, u32), (u64, u32)> = FxHashMap::default();
    let mut open: BinaryHeap<Reverse<((u64, u32), OracleNode)>> = BinaryHeap::new();
    for start in starts(request, route) {
        costs.insert(place(start, 0), (0, 0));
        open.push(Reverse(((0, 0), start)));
    }
    let mut farthest = 0;
    while let Some(Reverse(((cost, gaits), at))) = open.pop() {
        if costs[&place(at, gaits)] < (cost, gaits) {
            continue;
        }
        farthest = farthest.max(at.leg);
        if is_end(route, at) {
            return (Some((cost, gaits)), farthest);
        }
        for (edge, next) in edges(request, route, at) {
            let gaits = gaits + u32::from((next.leg, next.angle) == (at.leg, at.angle));
            if most.is_some_and(|most| gaits > most) {
                continue;
            }
            let known = costs.entry(place(next, gaits)).or_insert((u64::MAX, 0));
            if (cost + edge, gaits) < *known {
                *known = (cost + edge, gaits);
                open.push(Reverse(((cost + edge, gaits), next)));
            }
        }
    }
    (None, farthest)
}

/// Number of fingers placed and removed on a path.
pub fn gaits(way: &GraspPath) -> u32 {
    let changes = |nodes: &Vec<GraspNode>| nodes.windows(2).filter(|pair| pair[0].angle == pair[1].angle).count();
    way.legs.iter().map(changes).sum::<usize>() as u32
}

/// Follows a path edge by edge, and adds up its cost.
pub fn judge(request: &GraspRequest, way: &GraspPath) {
    let route = &request.routes[way.route];
    let node = |leg: usize, node: &GraspNode| OracleNode { leg, angle: node.angle, grasp: node.grasp };
    let legs = way.legs.iter().enumerate();
    let nodes: Vec<OracleNode> =
        legs.flat_map(|(leg, nodes)| nodes.iter().map(move |of_leg| node(leg, of_leg))).collect();
    assert!(starts(request, route).contains(&nodes[0]), "{:?} is no start", nodes[0]);
    let mut cost = 0;
    for pair in nodes.windows(2) {
        let edge = edges(request, route, pair[0]).into_iter().find(|(_, next)| *next == pair[1]);
        cost += edge.unwrap_or_else(|| panic!("no edge from {:?} to {:?}", pair[0], pair[1])).0;
    }
    assert!(is_end(route, *nodes.last().expect("a way has nodes")), "the way does not end where it should");
    assert_eq!(cost, way.cost);
}
