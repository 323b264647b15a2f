//! The masks compared with paths that are sampled in small steps.

use super::*;

/// Greatest violation of the clearances by a tip on a path, from the outline and from tips on other contacts; negative
/// if the path is clear.
fn intrusion_um(bench: &Bench, way: &RetreatPath, holding: &[usize]) -> f64 {
    let facts = &bench.facts;
    let far_um = facts.sphere_um(0, bench.curve.reach_um());
    let tips: Vec<Vector2<f64>> =
        holding.iter().map(|contact| bench.reach.way(*contact, &[]).expect("it is open").touch_um).collect();
    let mut worst_um = f64::NEG_INFINITY;
    let end = way.end_um(far_um);
    for (from, to, apart_um) in
        [(way.touch_um, way.bend_um, facts.tip_radius_um), (way.bend_um, end, facts.tip_radius_um + facts.clearance_um)]
    {
        for part in 0..=60 {
            let place = from.lerp(&to, f64::from(part) / 60.0);
            let outline_um = bench.curve.nearest([place.x, place.y]).distance_um;
            worst_um = worst_um.max(apart_um - outline_um);
            for tip in &tips {
                worst_um = worst_um.max(2.0 * facts.tip_radius_um + facts.clearance_um - (place - tip).norm());
            }
        }
    }
    worst_um
}

/// A disc with a deep pocket, whose walls face each other.
fn pocket() -> Outline {
    let place = |index: u32| {
        let turn_rad = TAU * f64::from(index) / 96.0;
        let depth_um = 36.0 * (-((turn_rad - TAU / 4.0) / 0.35).powi(2)).exp();
        [(60.0 - depth_um) * turn_rad.cos(), (60.0 - depth_um) * turn_rad.sin()]
    };
    Outline::Spline { points_um: (0..96).map(place).collect() }
}

#[test]
fn ways_are_clear() {
    let small = FingersFacts { tip_radius_um: 0.8, clearance_um: 0.5, steps_per_turn: 5, ..facts(3) };
    let [convex, waist] = benches(3);
    for (bench, has_bends) in [(convex, false), (waist, false), (Bench::new(pocket(), small), true)] {
        let mut dice = Dice::new(7);
        let count = bench.reach.contacts();
        let (mut bent, mut found) = (0, 0);
        for _ in 0..500 {
            let [i, k] = std::array::from_fn(|_| dice.below(count));
            let across = (count / 2 + count - k + dice.below(count / 20)) % count;
            let j = [dice.below(count), across][dice.below(2)];
            assert_eq!(bench.reach.reaches(i, j, k), bench.reach.reaches(j, i, k));
            let Some(way) = bench.reach.way(k, &[i, j]).filter(|_| i != j) else {
                assert!(!bench.reach.reaches(i, j, k), "({i}, {j}, {k})");
                continue;
            };
            found += 1;
            assert!(bench.reach.reaches(i, j, k));
            let straight = (way.bend_um - way.touch_um).normalize();
            bent += usize::from((way.towards - straight).norm() > 1e-6);
            let intrusion_um = intrusion_um(&bench, &way, &[i, j]);
            assert!(intrusion_um <= bench.facts.tolerance_um / 4.0, "({i}, {j}, {k}): {intrusion_um}");
        }
        assert!(found > 100 && (bent > 0) == has_bends, "{found} ways, {bent} of them bent");
    }
}

/// Where there is no path, each direction of the fan is obstructed.
#[test]
fn blocked_contacts_are_blocked() {
    for bench in benches(3) {
        let count = bench.reach.contacts();
        let mut blocked = 0;
        for (i, j, k) in (0..count).flat_map(|k| [(k + 5, k + 20, k), (k + 6, k + count - 6, k), (k + 7, k + 14, k)]) {
            let (i, j) = (i % count, j % count);
            if bench.reach.reaches(i, j, k) {
                continue;
            }
            blocked += 1;
            let open = bench.reach.way(k, &[]).expect("both outlines are open everywhere");
            for turn in -5..=5 {
                let normal = (open.bend_um - open.touch_um).normalize();
                let towards = nalgebra::Rotation2::new(f64::from(turn) * TAU / 24.0) * normal;
                let intrusion_um = intrusion_um(&bench, &RetreatPath { towards, ..open }, &[i, j]);
                assert!(intrusion_um > -bench.facts.tolerance_um, "({i}, {j}, {k}) is clear at {turn}");
            }
        }
        assert!(blocked > 0);
    }
}

/// The paper's ellipsoid: tips six contacts apart have room, tips five apart do not.
#[test]
fn tips_keep_apart() {
    let paper = FingersFacts { clearance_um: 0.0, ..facts(3) };
    let bench = Bench::new(ellipse(), paper);
    assert_eq!(bench.section.contacts, 74);
    for k in 0..74 {
        assert!(bench.reach.reaches((k + 6) % 74, (k + 40) % 74, k), "{k}");
        assert!(!bench.reach.reaches((k + 5) % 74, (k + 40) % 74, k), "{k}");
        assert!(!bench.reach.reaches(k, (k + 40) % 74, k) && !bench.reach.reaches((k + 40) % 74, (k + 40) % 74, k));
    }
}

#[test]
fn tips_come_in_an_order_that_is_clear() {
    let [bench, _] = benches(3);
    assert_eq!(bench.reach.order(&[0, 37]), Some(vec![0, 1]));
    assert_eq!(bench.reach.order(&[0]), Some(vec![0]));
    assert_eq!(bench.reach.order(&[]), Some(vec![]));
    assert_eq!(bench.reach.order(&[0, 2]), None, "they meet");
    assert_eq!(bench.reach.order(&[0, 20, 40, 60]), None, "never more than three");
}

/// A pocket too narrow for a tip's disc is not reached, however its floor is curved.
#[test]
fn narrow_pockets_are_not_reached() {
    let curve = Curve::of(&pocket()).expect("it is sound");
    let facts = FingersFacts { tip_radius_um: 0.8, ..facts(3) };
    assert!(curve.least_curvature_per_um() > -1.25, "{}", curve.least_curvature_per_um());
    let wide = ContactReach::new(&curve, &FingersFacts { clearance_um: 0.5, ..facts.clone() }, 300);
    assert!((0..300).all(|contact| wide.way(contact, &[]).is_some()));
    let narrow = ContactReach::new(&curve, &FingersFacts { clearance_um: 25.0, retract_um: 25.0, ..facts }, 300);
    let closed = (0..300).filter(|contact| narrow.way(*contact, &[]).is_none()).count();
    assert!(closed > 0 && closed < 150, "{closed}");
}
