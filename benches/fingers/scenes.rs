//! Sections, their tables, and queries from fixed seeds.

#[path = "../../tests/support/random.rs"]
mod random;

use random::Random;
use std::f64::consts::TAU;
use std::sync::Arc;
use tweeze::claims::fingers::Section;
use tweeze::device::fingers::{Adhesion, FingersFacts};
use tweeze::geometry::outline::{Curve, Outline};
use tweeze::plan::fingers::graph::{Grasp, GraspCosts, GraspRequest, GraspSearchLimits, Regrasp, Start, TurnLeg};
use tweeze::plan::fingers::looks::LooksBudget;
use tweeze::plan::fingers::mechanics::{Contacts, Load, TableRequest, tables};
use tweeze::plan::fingers::tables::{AngleLayer, ContactBits, Tables};

/// Number of angles of a leg: one turn in steps of 20 deg, and its end.
pub const ANGLES: i32 = 19;

/// Costs in degrees: rolling by 20 deg with one finger, and a placement or removal.
pub const COSTS: GraspCosts = GraspCosts { roll: 20, gait: 180 };

/// The paper's hand, with the removal safety that imitates its results.
pub fn hand(adhesion: Adhesion) -> FingersFacts {
    FingersFacts {
        fingers: 3,
        tip_radius_um: 4.5,
        adhesion,
        pull_off_un: 1.5,
        max_force_un: 30.0,
        friction: 0.3,
        steps_per_turn: 18,
        removal_safety: 1.8,
        gaiting_cost_deg: 180.0,
        clearance_um: 0.0,
        retract_um: 2.0,
        speed_um_per_s: 100.0,
        approach_um_per_s: 10.0,
        rolling_um_per_s: 10.0,
        support_un: 10.0,
        range_um: [100.0; 3],
        tolerance_um: 0.1,
        torsion_um: 0.01,
        rolling_reserve: 0.02,
    }
}

/// The tables of the paper's ellipsoid: 74 contacts.
pub fn ellipsoid(facts: &FingersFacts) -> Tables {
    let outline = Outline::Ellipse { semi_um: [16.0, 11.845] };
    let curve = Curve::of(&outline).expect("an ellipse has a curve");
    let once_round_rad = TAU + curve.perimeter_um() / facts.tip_radius_um;
    let section = Section { outline, contacts: 74, opposite: Some(38), step_rad: once_round_rad / 74.0 };
    let contacts = Contacts::of(&section, &curve, facts.tip_radius_um);
    let asked = TableRequest { facts, contacts, load: Load::NONE, lowest: 0, angles: ANGLES as usize };
    tables(&asked, &LooksBudget::default(), &mut |_, _, _| true).expect("an ellipse has few grasps")
}

/// All grasps whose contacts are at least `gap` apart; every placement and removal is allowed.
pub fn circle(contacts: usize, gap: usize) -> Tables {
    let apart = |i: usize, j: usize| i.abs_diff(j).min(contacts - i.abs_diff(j)) >= gap;
    let mut tables = Tables { contacts, layers: Vec::new() };
    let (mut pair, mut triple) = (ContactBits::new(contacts.pow(2)), ContactBits::new(contacts.pow(3)));
    for i in 0..contacts {
        for j in (0..contacts).filter(|j| apart(i, *j)) {
            pair.put(tables.two(i, j));
            (0..contacts).filter(|k| apart(i, *k) && apart(j, *k)).for_each(|k| triple.put(tables.three(i, j, k)));
        }
    }
    let (place, leave) = (triple.clone(), triple.clone());
    tables.layers.push(AngleLayer { roll_pair: pair.clone(), roll_triple: triple.clone(), pair, triple, place, leave });
    tables
}

/// The same tables, but no finger may leave a given triple, nor any triple that it rolls to.
pub fn stuck(tables: &Tables, triple: [usize; 3]) -> Tables {
    let mut other = tables.clone();
    for by in 0..tables.contacts {
        let [i, j, k] = triple.map(|contact| (contact + by) % tables.contacts);
        for [i, j, k] in [[i, j, k], [i, k, j], [j, i, k], [j, k, i], [k, i, j], [k, j, i]] {
            other.layers[0].leave.take(tables.three(i, j, k));
        }
    }
    other
}

/// The same tables, but no finger may be placed to form a given triple, nor any triple that it rolls to.
pub fn lonely(tables: &Tables, triple: [usize; 3]) -> Tables {
    let mut other = tables.clone();
    for by in 0..tables.contacts {
        let [i, j, k] = triple.map(|contact| (contact + by) % tables.contacts);
        for [i, j, k] in [[i, j, k], [i, k, j], [j, i, k], [j, k, i], [k, i, j], [k, j, i]] {
            other.layers[0].place.take(tables.three(i, j, k));
        }
    }
    other
}

/// A turn from one three-finger grasp to another.
pub fn query(tables: &Arc<Tables>, start: [u32; 3], steps: i32, end: [u32; 3]) -> GraspRequest {
    let grasp = |list: [u32; 3]| Grasp::of(&list).expect("three fingers");
    let (lowest, highest) = (0, ANGLES - 1);
    let leg = TurnLeg {
        tables: tables.clone(),
        steps,
        lowest,
        highest,
        entry: Regrasp::Same,
        end: Some(grasp(end)),
        lazy: None,
    };
    GraspRequest {
        fingers: 3,
        start: Start::At(grasp(start)),
        routes: vec![vec![leg]],
        costs: COSTS,
        limits: GraspSearchLimits::default(),
    }
}

/// A turn that ends with any two fingers on contacts 1 and 38, where a turn in the other plane begins.
pub fn junction(tables: &Arc<Tables>, start: [u32; 3], steps: i32) -> GraspRequest {
    let mut request = query(tables, start, steps, start);
    let ends = [0, 37];
    let mut next = request.routes[0][0].clone();
    request.routes[0][0].end = None;
    (next.steps, next.end, next.entry) = (0, None, Regrasp::Across { old: ends, new: ends });
    request.routes[0].push(next);
    request
}

/// Queries between stable grasps, with two and with three fingers, at random angles.
pub fn random(tables: &Arc<Tables>, count: usize) -> Vec<GraspRequest> {
    let mut random = Random::new(7);
    let mut grasp = || loop {
        let mut list = [0, 1, 2].map(|_| 1 + random.below(tables.contacts as u32));
        let free = random.index(6);
        if let Some(contact) = list.get_mut(free) {
            *contact = 0;
        }
        if holds(tables, list) {
            return (list, random.below(ANGLES as u32) as i32);
        }
    };
    (0..count).map(|_| query(tables, grasp().0, grasp().1, grasp().0)).collect()
}

fn holds(tables: &Tables, list: [u32; 3]) -> bool {
    let held: Vec<usize> = list.iter().filter(|contact| **contact != 0).map(|contact| *contact as usize - 1).collect();
    match held[..] {
        [i, j] => tables.layers[0].pair.has(tables.two(i, j)),
        [i, j, k] => tables.layers[0].triple.has(tables.three(i, j, k)),
        _ => false,
    }
}
