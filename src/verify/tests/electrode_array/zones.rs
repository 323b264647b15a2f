//! Stays in heaters, detectors and magnets.

use super::build::{alone, assay, cell, incubate, merge, operation, schedule};
use super::{judged, why};
use crate::claims::electrode_array::{AssayOperation, BoardZone, ElectrodeArrayOrder, ZoneSort, ZoneStay};
use crate::source::Span;
use crate::verify::Rule;
use std::sync::Arc;

/// The order with one zone between two corners.
fn with_zone(order: ElectrodeArrayOrder, sort: ZoneSort, [from, to]: [(u32, u32); 2]) -> ElectrodeArrayOrder {
    let (from, to) = (cell(from.0, from.1), cell(to.0, to.1));
    let zone = BoardZone { name: "zone".into(), sort, from, to, span: Span::default() };
    ElectrodeArrayOrder { zones: Arc::new(vec![zone]), ..order }
}

fn inside(operation: AssayOperation, temperature_k: Option<f64>) -> AssayOperation {
    AssayOperation { zone: Some(ZoneStay { zone: 0, temperature_k }), ..operation }
}

const TWO: [(&str, u32, u32); 2] = [("a", 4, 4), ("b", 10, 4)];

/// `a` goes two cells to the right and is read there for two beats.
fn read(corners: [(u32, u32); 2]) -> ElectrodeArrayOrder {
    let operations = vec![inside(incubate(0, &[(6, 4)], 2), None), incubate(1, &[(9, 4)], 1)];
    with_zone(assay(&TWO, operations), ZoneSort::Detector, corners)
}

#[test]
fn a_part_is_within_the_zone_for_its_time() {
    judged(read([(6, 4), (6, 4)]), &["RR..", "..L."], &[]);
    judged(read([(5, 3), (7, 5)]), &["RR..", "..L."], &[]);
    // It stays at its stop for the whole time, but outside the zone.
    for beside in [[(7, 4), (8, 4)], [(4, 4), (5, 4)], [(6, 5), (6, 6)], [(6, 2), (6, 3)]] {
        judged(read(beside), &["RR..", "..L."], &[Rule::Zone]);
    }
    // Too short a stay at its stop does not count as one.
    judged(read([(6, 4), (6, 4)]), &["RR.", ".L."], &[Rule::Goal]);
}

#[test]
fn a_part_is_alone_where_it_is_read() {
    let wide = [(6, 4), (9, 4)];
    judged(read(wide), &["RR..", "..L."], &[Rule::Zone]);
    // The other one comes in as soon as the first one has been read.
    judged(read(wide), &["RR....", "....L."], &[]);
    judged(read(wide), &["RR...", "...L."], &[Rule::Zone]);
    // Heaters and magnets may be shared.
    let with = |sort, temperature_k| {
        let operations = vec![inside(incubate(0, &[(6, 4)], 2), temperature_k), incubate(1, &[(9, 4)], 1)];
        with_zone(assay(&TWO, operations), sort, wide)
    };
    judged(with(ZoneSort::Heater, Some(333.15)), &["RR..", "..L."], &[]);
    judged(with(ZoneSort::Magnet, None), &["RR..", "..L."], &[]);
}

/// Two droplets that have merged are one from that instant on, and it may be the first instant of the reading.
#[test]
fn a_droplet_is_read_where_it_has_merged() {
    let operations = vec![operation(merge(0, 1, (6, 4))), inside(incubate(0, &[(6, 4)], 2), None)];
    let read = || with_zone(assay(&TWO, operations.clone()), ZoneSort::Detector, [(6, 4), (6, 4)]);
    judged(read(), &["RR....", "LLLLx"], &[]);
    judged(read(), &["RR...", "LLLLx"], &[Rule::Goal]);
}

#[test]
fn claims_of_zones_are_sound() {
    let is_judged = |order: ElectrodeArrayOrder| {
        let claims = alone(order);
        why(&schedule(&claims, &[&[&[""]]]), &claims).is_none()
    };
    let sound = || read([(6, 4), (6, 4)]);
    assert!(is_judged(sound()));
    let with = |operation: AssayOperation, sort| with_zone(assay(&TWO, vec![operation]), sort, [(6, 4), (6, 4)]);
    let stay = || incubate(0, &[(6, 4)], 2);
    let unsound = [
        with_zone(sound(), ZoneSort::Detector, [(7, 4), (6, 4)]),
        with_zone(sound(), ZoneSort::Detector, [(0, 4), (6, 4)]),
        with_zone(sound(), ZoneSort::Detector, [(6, 4), (15, 4)]),
        ElectrodeArrayOrder { zones: Arc::default(), ..sound() },
        with(inside(stay(), Some(300.0)), ZoneSort::Magnet),
        with(inside(stay(), None), ZoneSort::Heater),
        with(inside(stay(), Some(f64::NAN)), ZoneSort::Heater),
        with(inside(incubate(0, &[], 2), None), ZoneSort::Magnet),
        with(inside(incubate(0, &[(6, 4)], 0), None), ZoneSort::Magnet),
        with(inside(operation(merge(0, 1, (6, 4))), None), ZoneSort::Magnet),
        with(AssayOperation { mixes: true, ..inside(stay(), None) }, ZoneSort::Magnet),
    ];
    for (nth, order) in unsound.into_iter().enumerate() {
        assert!(!is_judged(order), "{nth}");
    }
    let twice = vec![inside(stay(), Some(300.0)), inside(stay(), Some(301.0))];
    assert!(!is_judged(with_zone(assay(&TWO, twice), ZoneSort::Heater, [(6, 4), (6, 4)])));
}
