//! The A* of the crate `pathfinding` on the same tables, with the paper's heuristic (contacts compared modulo their
//! number).

use pathfinding::prelude::astar;
use std::cell::Cell;
use tweeze::plan::fingers::graph::{GraspRequest, Start};
use tweeze::plan::fingers::tables::Tables;

/// The contact of each finger, from 1, and the angle.
type Node = ([u16; 3], u16);

/// Result of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    Cost(u64),
    NoPath,
    /// The search was stopped.
    Open,
}

/// The least cost of a request with one leg; stops after `most` node expansions.
pub fn cost(request: &GraspRequest, most: u64) -> Outcome {
    let leg = &request.routes[0][0];
    let Start::At(start) = request.start else { unreachable!("our queries begin with a grasp") };
    let end = leg.end.expect("our queries end with a grasp");
    let list = |grasp: [u16; 6]| [grasp[0], grasp[1], grasp[2]];
    let goal = (list(end.0), leg.steps as u16);
    let expanded = Cell::new(0);
    let successors = |(grasp, angle): &Node| {
        expanded.set(expanded.get() + 1);
        neighbours(request, &leg.tables, *grasp, *angle)
    };
    let estimate = |node: &Node| estimate(request, leg.tables.contacts as u16, *node, goal);
    let found = astar(&(list(start.0), 0), successors, estimate, |node| *node == goal || expanded.get() >= most);
    match found {
        Some((path, cost)) if path.last() == Some(&goal) => Outcome::Cost(cost),
        Some(_) => Outcome::Open,
        None => Outcome::NoPath,
    }
}

fn held(grasp: [u16; 3]) -> Vec<(usize, usize)> {
    (0..3).filter(|finger| grasp[*finger] != 0).map(|finger| (finger, usize::from(grasp[finger]) - 1)).collect()
}

fn holds(tables: &Tables, grasp: [u16; 3]) -> bool {
    match held(grasp)[..] {
        [(_, i), (_, j)] => tables.layers[0].pair.has(tables.two(i, j)),
        [(_, i), (_, j), (_, k)] => tables.layers[0].triple.has(tables.three(i, j, k)),
        _ => false,
    }
}

fn rolls(tables: &Tables, grasp: [u16; 3]) -> bool {
    match held(grasp)[..] {
        [(_, i), (_, j)] => tables.layers[0].roll_pair.has(tables.two(i, j)),
        [(_, i), (_, j), (_, k)] => tables.layers[0].roll_triple.has(tables.three(i, j, k)),
        _ => false,
    }
}

fn neighbours(request: &GraspRequest, tables: &Tables, grasp: [u16; 3], angle: u16) -> Vec<(Node, u64)> {
    let layer = &tables.layers[0];
    let contacts = tables.contacts as u16;
    let held = held(grasp);
    let roll = held.len() as u64 * u64::from(request.costs.roll);
    let gait = u64::from(request.costs.gait);
    let turned = |by: u16| grasp.map(|contact| if contact == 0 { 0 } else { (contact - 1 + by) % contacts + 1 });
    let mut found = Vec::new();
    let (up, down) = (turned(contacts - 1), turned(1));
    if i32::from(angle) < request.routes[0][0].highest && rolls(tables, grasp) && holds(tables, up) {
        found.push(((up, angle + 1), roll));
    }
    if angle > 0 && rolls(tables, down) && holds(tables, down) {
        found.push(((down, angle - 1), roll));
    }
    let with = |finger: usize, number: u16| {
        let mut other = grasp;
        other[finger] = number;
        other
    };
    match held[..] {
        [(a, i), (b, j)] => {
            let finger = 3 - a - b;
            let comes = |k: &usize| {
                let triple = tables.three(i, j, *k);
                layer.place.has(triple) && layer.triple.has(triple)
            };
            let placed = (0..tables.contacts).filter(comes).map(|k| with(finger, k as u16 + 1));
            found.extend(placed.map(|grasp| ((grasp, angle), gait)));
        }
        [(a, i), (b, j), (c, k)] => {
            for (finger, [i, j, k]) in [(c, [i, j, k]), (b, [i, k, j]), (a, [j, k, i])] {
                if layer.leave.has(tables.three(i, j, k)) && layer.pair.has(tables.two(i, j)) {
                    found.push(((with(finger, 0), angle), gait));
                }
            }
        }
        _ => {}
    }
    found
}

fn estimate(request: &GraspRequest, contacts: u16, now: Node, goal: Node) -> u64 {
    let (mut blocked, mut changing, mut unused) = (0, 0, 0);
    for finger in 0..3 {
        match (now.0[finger], goal.0[finger]) {
            (0, 0) => unused += 1,
            (0, _) | (_, 0) => changing += 1,
            (here, there) => blocked += u64::from((here + now.1) % contacts != (there + goal.1) % contacts),
        }
    }
    let help = if unused > 0 && blocked > 0 { 2 } else { 0 };
    let steps = u64::from(now.1.abs_diff(goal.1));
    2 * u64::from(request.costs.roll) * steps + u64::from(request.costs.gait) * (2 * blocked + changing + help)
}
