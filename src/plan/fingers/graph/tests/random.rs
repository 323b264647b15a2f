//! Random cases: both estimators, the oracle, and the consistency of both estimates.

use super::oracle::{OracleNode, dijkstra, edges, gaits, holds, judge};
use crate::plan::fingers::graph::course::courses;
use crate::plan::fingers::graph::published::Published;
use crate::plan::fingers::graph::route::{RemainingReconfigurations, flooded};
use crate::plan::fingers::graph::walk::{Estimate, NEVER};
use crate::plan::fingers::graph::{
    Estimator, Grasp, GraspAnswer, GraspCosts, GraspRequest, GraspSearchEnd, GraspSearchLimits, Regrasp, Start,
    TurnLeg, decompose, solve,
};
use crate::plan::fingers::looks::LooksBudget;
use crate::plan::fingers::tables::{AngleLayer, ContactBits, Tables};
use crate::plan::search::SearchBudget;
use crate::random::support::Random;
use std::rc::Rc;
use std::sync::Arc;

/// A layer from predicates on contacts: `pair` and `triple` return whether they hold and roll, `change` whether a
/// finger may be placed on the last contact and removed from it.
pub fn layer(
    contacts: usize,
    mut pair: impl FnMut(usize, usize) -> [bool; 2],
    mut triple: impl FnMut(usize, usize, usize) -> [bool; 2],
    mut change: impl FnMut(usize, usize, usize) -> [bool; 2],
) -> AngleLayer {
    let [mut pairs, mut roll_pair] = std::array::from_fn(|_| ContactBits::new(contacts.pow(2)));
    let [mut triples, mut roll_triple, mut place, mut leave] =
        std::array::from_fn(|_| ContactBits::new(contacts.pow(3)));
    let two = |i: usize, j: usize| i * contacts + j;
    let three = |i: usize, j: usize, k: usize| (i * contacts + j) * contacts + k;
    let put =
        |bits: &mut ContactBits, is_in: bool, all: &[usize]| all.iter().filter(|_| is_in).for_each(|at| bits.put(*at));
    for i in 0..contacts {
        for j in i + 1..contacts {
            let [holds, rolls] = pair(i, j);
            put(&mut pairs, holds, &[two(i, j), two(j, i)]);
            put(&mut roll_pair, rolls, &[two(i, j), two(j, i)]);
            for k in (0..contacts).filter(|k| *k != i && *k != j) {
                let [comes, leaves] = change(i, j, k);
                put(&mut place, comes, &[three(i, j, k), three(j, i, k)]);
                put(&mut leave, leaves, &[three(i, j, k), three(j, i, k)]);
            }
            for k in j + 1..contacts {
                let [holds, rolls] = triple(i, j, k);
                let all =
                    [[i, j, k], [i, k, j], [j, i, k], [j, k, i], [k, i, j], [k, j, i]].map(|[i, j, k]| three(i, j, k));
                put(&mut triples, holds, &all);
                put(&mut roll_triple, rolls, &all);
            }
        }
    }
    AngleLayer { pair: pairs, triple: triples, roll_pair, roll_triple, place, leave }
}

/// Tables in which all grasps with contacts at least `gap` apart hold, roll, and may be changed.
pub fn circle(contacts: usize, gap: usize) -> Tables {
    let apart = |i: usize, j: usize| i.abs_diff(j).min(contacts - i.abs_diff(j)) >= gap;
    let pair = |i, j| [apart(i, j); 2];
    let triple = |i, j, k| [apart(i, j) && apart(j, k) && apart(i, k); 2];
    let layer = layer(contacts, pair, triple, triple);
    Tables { contacts, layers: vec![layer] }
}

fn noise(random: &mut Random, contacts: usize, layers: usize) -> Tables {
    let density = random.pick(&[15, 30, 50, 70, 90]);
    let change = random.pick(&[3, 10, 25, 50, 90]);
    let rolls = random.pick(&[50, 80, 100]);
    let gap = random.pick(&[1, 1, contacts / 10 + 1]);
    let apart = |i: usize, j: usize| i.abs_diff(j).min(contacts - i.abs_diff(j)) >= gap;
    let seed = random.next();
    let layers = (0..layers as u64).map(|at| {
        let cell = std::cell::RefCell::new(Random::new(seed ^ at));
        let chance = |percent| cell.borrow_mut().chance(percent);
        layer(
            contacts,
            |i, j| [apart(i, j) && chance(density), chance(rolls)],
            |i, j, k| [apart(i, j) && apart(j, k) && apart(i, k) && chance(density), chance(rolls)],
            |_, _, _| [chance(change), chance(change)],
        )
    });
    Tables { contacts, layers: layers.collect() }
}

/// A random case: fingers, contacts, legs, junctions and pins.
pub fn case(seed: u64) -> GraspRequest {
    let random = &mut Random::new(seed.wrapping_mul(0x1234_5677));
    let fingers = if random.chance(75) || seed.is_multiple_of(50) { 3 } else { 4 };
    let most = if fingers == 3 { random.pick(&[6, 7, 9, 10, 12, 14, 20]) } else { random.pick(&[5, 8, 11]) };
    let most = if seed.is_multiple_of(50) { 40 } else { most };
    let turn = random.pick(&[2, 4, 7, 12]);
    let by_angle = random.chance(20);
    let table = |random: &mut Random| {
        let contacts = most - 2 * random.index(2);
        let layers = if by_angle { turn + 1 } else { 1 };
        Arc::new(if random.chance(20) && !by_angle {
            circle(contacts, contacts / 7 + 1)
        } else {
            noise(random, contacts, layers)
        })
    };
    let sections = [table(random), table(random)];
    let routes =
        (0..random.pick(&[1, 1, 2, 3, 6])).map(|_| route(random, fingers, turn, &sections)).collect::<Vec<_>>();
    let first = &routes[0][0];
    let start = match random.chance(40) {
        true => Start::Any,
        false => Start::At(some(random, fingers, first, 0)),
    };
    let costs = random.pick(&[(20, 180), (1, 9), (7, 30), (3, 1), (2, 0)]);
    GraspRequest {
        fingers,
        start,
        routes,
        costs: GraspCosts { roll: costs.0, gait: costs.1 },
        limits: GraspSearchLimits::default(),
    }
}

/// A random grasp, mostly one that holds.
fn some(random: &mut Random, fingers: usize, leg: &TurnLeg, angle: i32) -> Grasp {
    let tries: Vec<Grasp> = (0..50).map(|_| any(random, fingers, leg.tables.contacts)).collect();
    let holding = tries.iter().copied().find(|grasp| holds(leg, angle, grasp));
    if random.chance(95) { holding.unwrap_or(tries[0]) } else { tries[0] }
}

/// A random grasp of two or three fingers.
fn any(random: &mut Random, fingers: usize, contacts: usize) -> Grasp {
    let count = 2 + random.index(2);
    let mut grasp = Grasp([0; 6]);
    while grasp.holding() < count {
        grasp.0[random.index(fingers)] = random.index(contacts) as u16 + 1;
    }
    grasp
}

fn route(random: &mut Random, fingers: usize, turn: usize, sections: &[Arc<Tables>; 2]) -> Vec<TurnLeg> {
    let mut at = random.index(2);
    let mut legs: Vec<TurnLeg> = Vec::new();
    for number in 0..random.pick(&[1, 1, 2, 3]) {
        let before = at;
        let crosses = number > 0 && random.chance(70);
        if crosses {
            at = 1 - at;
        }
        let half = |at: usize| [0, sections[at].contacts / 2];
        let entry = if crosses { Regrasp::Across { old: half(before), new: half(at) } } else { Regrasp::Same };
        let lowest = -(random.pick(&[0, turn / 2, turn]) as i32);
        let (highest, steps) = (lowest + turn as i32, lowest + random.index(turn + 1) as i32);
        let mut leg = TurnLeg { tables: sections[at].clone(), steps, lowest, highest, entry, end: None, lazy: None };
        if random.chance(30) {
            leg.end = Some(some(random, fingers, &leg, steps));
        }
        legs.push(leg);
    }
    legs
}

/// The least cost, its reconfigurations and its route; the farthest leg that a route begins, and the first route that does.
type Best = (Option<(u64, u32, usize)>, (usize, usize));

fn best(request: &GraspRequest) -> Best {
    let oracle: Vec<(Option<(u64, u32)>, usize)> =
        request.routes.iter().map(|route| dijkstra(request, route)).collect();
    let ways = oracle.iter().enumerate().filter_map(|(at, (way, _))| way.map(|(cost, gaits)| (cost, gaits, at)));
    let farthest = oracle.iter().map(|(_, leg)| *leg).max().expect("a case has routes");
    let first = oracle.iter().position(|(_, leg)| *leg == farthest).expect("it is one of them");
    (ways.min(), (farthest, first))
}

fn agrees(seed: u64) -> Option<u64> {
    let mut request = case(seed);
    let way = agrees_within(seed, &request);
    // Then the limit is set below the reconfigurations of each path found, until there is none.
    let mut most = way.map_or(0, |(_, gaits)| gaits);
    while let Some(fewer) = most.checked_sub(1) {
        request.limits.gaits = Some(fewer);
        most = agrees_within(seed, &request).map_or(0, |(_, gaits)| gaits);
    }
    way.map(|(cost, _)| cost)
}

/// Cost and reconfigurations of the best path within the limit of a request.
fn agrees_within(seed: u64, request: &GraspRequest) -> Option<(u64, u32)> {
    let (best, farthest) = best(request);
    for estimator in [Estimator::Published, Estimator::Layers] {
        match solve(request, estimator, SearchBudget::DEFAULT) {
            GraspAnswer::Found(way) => {
                assert_eq!(Some((way.cost, gaits(&way), way.route)), best, "case {seed}, {estimator:?}");
                assert_eq!(way.bound, way.cost);
                judge(request, &way);
            }
            GraspAnswer::Impossible(blocked) => {
                assert_eq!(best, None, "case {seed}, {estimator:?}");
                let is_said = request.limits.gaits.is_some() || (blocked.leg, blocked.route) == farthest;
                assert!(is_said, "case {seed}: {blocked:?}, {farthest:?}");
            }
            other => panic!("case {seed}, {estimator:?}: {other:?}"),
        }
    }
    best.map(|(cost, gaits, _)| (cost, gaits))
}

/// However few looks are available, the answers are true.
#[test]
fn what_is_said_when_looks_run_out_is_so() {
    let (mut ended, mut found) = (0, 0);
    for seed in 2000..2120 {
        let mut request = case(seed);
        let best = best(&request).0;
        for looks in [1, 30, 300, 3000, 30_000] {
            request.limits.looks = Rc::new(LooksBudget::of(looks));
            match solve(&request, Estimator::Layers, SearchBudget::DEFAULT) {
                GraspAnswer::Found(way) => {
                    assert_eq!(Some((way.cost, gaits(&way), way.route)), best, "case {seed}, {looks} looks");
                    found += 1;
                }
                GraspAnswer::Impossible(_) => assert_eq!(best, None, "case {seed}, {looks} looks"),
                GraspAnswer::GaveUp(GraspSearchEnd::Looks { bound }) => {
                    assert!(
                        best.is_none_or(|(cost, ..)| bound <= cost),
                        "case {seed}, {looks} looks: {bound}, {best:?}"
                    );
                    ended += 1;
                }
                other => panic!("case {seed}, {looks} looks: {other:?}"),
            }
            request.limits.looks = Rc::new(LooksBudget::of(looks));
            if let GraspAnswer::Found(way) = decompose(&request, Estimator::Layers, SearchBudget::DEFAULT) {
                assert!(
                    best.is_some_and(|(cost, ..)| way.bound <= cost),
                    "case {seed}, {looks} looks: {way:?}, {best:?}"
                );
            }
        }
    }
    assert!(ended > 100 && found > 50, "{ended} ended, {found} found");
}

#[test]
fn costs_are_those_of_a_plain_search() {
    let found = (0..150).filter(|seed| agrees(*seed).is_some()).count();
    assert!((60..135).contains(&found), "{found} of 150 cases have a way");
}

/// A node that a flood has not reached lies in no layer below the floor of the flood.
#[test]
fn no_node_lies_below_the_floor_of_a_flood() {
    let (mut unknown, mut exact) = (0, 0);
    for seed in 500..700 {
        let request = case(seed);
        let courses = courses(&request).expect("cases are small");
        for (course, route) in courses.iter().zip(&request.routes) {
            let random = &mut Random::new(seed);
            let (shallow, mut deep) = (flooded::<1>(course, request.start), flooded::<1>(course, request.start));
            while !deep.ended() {
                deep.deepen();
            }
            for _ in 0..300 {
                let leg = random.index(route.len());
                let angle = route[leg].lowest + random.index(route[leg].angles()) as i32;
                let grasp = some(random, request.fingers, &route[leg], angle);
                let spot = course.place(leg, (angle - route[leg].lowest) as usize, &grasp);
                let Some(spot) = spot.filter(|spot| shallow.layer_of(*spot).is_none()) else { continue };
                let (floor, Some(layer)) = (shallow.floor(spot), deep.layer_of(spot)) else { continue };
                assert!(floor <= layer, "case {seed}: {spot:?} lies in layer {layer}, below {floor}");
                unknown += 1;
                exact += usize::from(floor == layer);
            }
        }
    }
    assert!(exact > 20, "{exact} of {unknown} nodes lie on the floor");
}

/// Neither estimate drops by more than an edge costs.
#[test]
fn estimates_are_consistent() {
    let mut checked = 0;
    for seed in 500..700 {
        let request = case(seed);
        let courses = courses(&request).expect("cases are small");
        for (course, route) in courses.iter().zip(&request.routes) {
            let random = &mut Random::new(seed);
            let published = Published::of(course);
            let mut layers = RemainingReconfigurations::<1>(flooded(course, request.start));
            (0..random.index(3)).for_each(|_| layers.deepen());
            for _ in 0..100 {
                let leg = random.index(route.len());
                let angle = route[leg].lowest + random.index(route[leg].angles()) as i32;
                let from = OracleNode { leg, angle, grasp: some(random, request.fingers, &route[leg], angle) };
                checked += usize::from(holds(&route[leg], angle, &from.grasp));
                for estimate in [&published as &dyn Estimate, &layers] {
                    consistent(&request, route, course, estimate, from);
                }
            }
        }
    }
    assert!(checked > 10_000, "{checked} nodes");
}

fn consistent(
    request: &GraspRequest,
    route: &[TurnLeg],
    course: &crate::plan::fingers::graph::course::PreparedRoute,
    estimate: &dyn Estimate,
    from: OracleNode,
) {
    let spot = |at: OracleNode| course.place(at.leg, (at.angle - route[at.leg].lowest) as usize, &at.grasp);
    let Some(here) = spot(from) else { return };
    for (_, to) in edges(request, route, from) {
        let there = spot(to).expect("edges lead to nodes");
        let is_gait = to.leg == from.leg && to.angle == from.angle;
        let (now, then) = (estimate.gaits(here), estimate.gaits(there));
        assert!(then == NEVER || now <= then + u32::from(is_gait), "{from:?} {now}, {to:?} {then}");
    }
}
