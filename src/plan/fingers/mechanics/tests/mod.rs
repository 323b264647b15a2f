use super::*;
use crate::claims::fingers::Section;
use crate::device::fingers::{Adhesion, FingersFacts, fixture};
use crate::geometry::outline::{Curve, Outline};
use crate::plan::fingers::looks::LooksBudget;
use crate::plan::fingers::tables::{ContactBits, Tables};
use crate::random::support::Random;
use std::f64::consts::TAU;

mod oracle;
mod paper;

/// The paper's hand, with a κ that imitates the paper.
fn hand(friction: f64, adhesion: Adhesion) -> FingersFacts {
    FingersFacts {
        adhesion,
        friction,
        removal_safety: 1.8,
        clearance_um: 0.0,
        retract_um: 2.0,
        support_un: 10.0,
        range_um: [100.0; 3],
        tolerance_um: 0.1,
        ..fixture::hand()
    }
}

/// A section with the curve of its outline.
struct CurvedSection {
    section: Section,
    curve: Curve,
}

impl CurvedSection {
    fn contacts(&self, facts: &FingersFacts) -> Contacts<'_> {
        Contacts::of(&self.section, &self.curve, facts.tip_radius_um)
    }
}

/// An ellipse with `contacts` contacts.
fn ellipse(semi_um: [f64; 2], contacts: u32) -> CurvedSection {
    section(Outline::Ellipse { semi_um }, contacts)
}

fn section(outline: Outline, contacts: u32) -> CurvedSection {
    let curve = Curve::of(&outline).expect("an outline");
    let once_round_rad = TAU + curve.perimeter_um() / 4.5;
    let opposite = Some(1 + contacts / 2);
    let section = Section { outline, contacts, opposite, step_rad: once_round_rad / f64::from(contacts) };
    CurvedSection { section, curve }
}

fn tabulated(facts: &FingersFacts, part: &CurvedSection, load: Load, angles: usize) -> Tables {
    let contacts = part.contacts(facts);
    tables(&TableRequest { facts, contacts, load, lowest: 0, angles }, &LooksBudget::default(), &mut |_, _, _| true)
        .expect("few grasps")
}

fn count(bits: &ContactBits) -> u32 {
    bits.words().iter().map(|word| word.count_ones()).sum()
}

/// Number of ordered grasps of two or three of three fingers.
fn grasps(tables: &Tables) -> u32 {
    3 * count(&tables.layers[0].pair) + count(&tables.layers[0].triple)
}

const PAPER: [f64; 2] = [16.0, 11.845];

#[test]
fn the_papers_ellipse_has_its_grasps() {
    let part = ellipse(PAPER, 74);
    assert!((part.section.step_rad.to_degrees() - 20.0).abs() < 0.001);
    for friction in [0.1, 0.3, 0.5] {
        let tables = tabulated(&hand(friction, Adhesion::Sticking), &part, Load::NONE, 19);
        assert_eq!((tables.layers.len(), grasps(&tables)), (1, 258_630), "friction does not matter where tips stick");
        assert_eq!(
            tables.layers[0].roll_triple, tables.layers[0].triple,
            "a tip that has room has room while it rolls"
        );
    }
}

#[test]
fn tips_have_room_from_six_contacts_on() {
    for semi_um in [PAPER, [15.5, 12.41], [14.0, 14.0], [17.0, 10.6]] {
        let layer = tabulated(&hand(0.3, Adhesion::Sticking), &ellipse(semi_um, 74), Load::NONE, 1).layers.remove(0);
        for (i, j) in (0..74).flat_map(|i| (0..74).map(move |j| (i, j))) {
            let gap = (74 + i - j) % 74;
            assert_eq!(layer.pair.has(i * 74 + j), gap.min(74 - gap) >= 6, "{semi_um:?}: {i} {j}");
        }
    }
}

#[test]
fn without_adhesion_grasps_grow_with_friction_as_in_table_2() {
    for (semi_um, shares) in [(PAPER, [0.16, 0.47, 0.65]), ([15.5, 12.41], [0.22, 0.53, 0.69])] {
        for (friction, share) in [0.1, 0.3, 0.5].into_iter().zip(shares) {
            let tables = tabulated(&hand(friction, Adhesion::Absent), &ellipse(semi_um, 74), Load::NONE, 1);
            let found = f64::from(grasps(&tables)) / 258_630.0;
            assert!((found - share).abs() < 0.02, "{semi_um:?}, {friction}: {found:.3}");
        }
    }
}

/// Compares the tables with single grasps, at each instant by `holds` and the room between tips; of triples, only those
/// with every third last contact.
fn assert_told_by_single_grasps(facts: &FingersFacts, part: &CurvedSection, load: Load, angles: usize) {
    let tables = tabulated(facts, part, load, angles);
    let contacts = part.contacts(facts);
    let grip = GripModel::of(facts, contacts.reach_um());
    let size = contacts.number();
    let firm = grip.with_reserve();
    let is_single = tables.layers.len() == 1;
    for (at, layer) in tables.layers.iter().enumerate() {
        let loaded =
            |hand, part: usize, of: usize| LoadedGrip::at(hand, &contacts, load, [at as f64, part as f64 / of as f64]);
        let now = loaded(&grip, 0, 1);
        let next = loaded(&grip, 1, 1);
        let between: Vec<LoadedGrip> = (1..PARTS_OF_STEP).map(|part| loaded(&firm, part, PARTS_OF_STEP)).collect();
        let passing: Vec<LoadedGrip> =
            (1..PARTS_OF_ROLLING).map(|part| loaded(&grip, part, PARTS_OF_ROLLING)).collect();
        let on = |grasp: &[usize]| {
            (is_single || at + 1 < angles)
                && next.holds(grasp)
                && between.iter().all(|part| part.holds(grasp))
                && passing.iter().all(|part| part.has_room(grasp))
        };
        for (i, j) in (0..size).flat_map(|i| (0..size).map(move |j| (i, j))) {
            let held = i != j && now.holds(&[i, j]);
            assert_eq!(layer.pair.has(i * size + j), held, "{at}: {i} {j}");
            assert_eq!(layer.roll_pair.has(i * size + j), held && on(&[i, j]), "{at}: {i} {j} roll");
            for k in (0..size).step_by(3) {
                let bit = tables.three(i, j, k);
                let all = i != j && i != k && j != k && now.holds(&[i, j, k]);
                assert_eq!(layer.triple.has(bit), all, "{at}: {i} {j} {k}");
                assert_eq!(layer.roll_triple.has(bit), all && on(&[i, j, k]), "{at}: {i} {j} {k} roll");
                assert_eq!(layer.place.has(bit), all && held, "{at}: {i} {j} {k} comes");
                let lets_go =
                    all && held && grip.resists([&now.contacts[i], &now.contacts[j]], &now.contacts[k], &now.load);
                assert_eq!(layer.leave.has(bit), lets_go, "{at}: {i} {j} {k} leaves");
            }
        }
    }
}

/// Contacts and load a part of a step after an angle.
struct LoadedGrip<'a> {
    grip: &'a GripModel,
    contacts: Vec<Contact>,
    load: Load,
}

impl<'a> LoadedGrip<'a> {
    fn at(grip: &'a GripModel, contacts: &Contacts, load: Load, [angle, part]: [f64; 2]) -> LoadedGrip<'a> {
        let load = load.after_turn((angle + part) * contacts.step_rad());
        LoadedGrip { grip, contacts: contacts.after(part), load }
    }

    fn held(&self, grasp: &[usize]) -> Vec<Contact> {
        grasp.iter().map(|contact| self.contacts[*contact]).collect()
    }

    fn has_room(&self, grasp: &[usize]) -> bool {
        let held = self.held(grasp);
        (0..held.len()).all(|a| held[a].usable && (0..a).all(|b| held[a].tips_apart_um(&held[b]) >= 9.0))
    }

    fn holds(&self, grasp: &[usize]) -> bool {
        self.has_room(grasp) && self.grip.holds(&self.held(grasp), &self.load)
    }
}

#[test]
fn tables_say_what_single_grasps_say() {
    let round = ellipse([8.0, 6.1], 28);
    let waist = peanut(30);
    let weight = Load { force_un: [0.4, -0.9], at_um: [0.5, 0.2], ..Load::NONE };
    let oblique = Load { across_un: 0.7, height_um: 0.3, ..weight };
    for adhesion in [Adhesion::Sticking, Adhesion::Absent] {
        for part in [&round, &waist] {
            assert_told_by_single_grasps(&hand(0.4, adhesion), part, Load::NONE, 5);
        }
        for load in [weight, oblique] {
            assert_told_by_single_grasps(&hand(0.4, adhesion), &round, load, 3);
        }
    }
}

/// Slimmer in the middle: a tip in the waist may intersect the outline elsewhere.
fn peanut(contacts: u32) -> CurvedSection {
    let round = |k: usize| {
        let (sin, cos) = (k as f64 * TAU / 32.0).sin_cos();
        let radius_um = 7.0 + 4.0 * (2.0 * cos * cos - 1.0);
        [radius_um * cos, radius_um * sin]
    };
    section(Outline::Spline { points_um: (0..32).map(round).collect() }, contacts)
}

/// A contact every 10 deg around a circle, exactly.
fn circle() -> Vec<Contact> {
    let at = |index: u32| {
        let (sin, cos) = (f64::from(index) * TAU / 36.0).sin_cos();
        let out = |radius_um: f64| [radius_um * cos, radius_um * sin];
        Contact { point_um: out(9.0), normal: [cos, sin], tip_um: out(13.5), usable: true }
    };
    (0..36).map(at).collect()
}

#[test]
fn what_is_exactly_balanced_holds() {
    // Two fingers 90 deg apart as seen from the centre: the chord is 45 deg off both normals.
    let contacts = circle();
    let grip = |friction: f64| GripModel::of(&hand(friction, Adhesion::Absent), 9.0);
    let right_angle = [contacts[0], contacts[9]];
    assert!(grip(1.0).holds(&right_angle, &Load::NONE));
    assert!(!grip(1.0 - 1e-8).holds(&right_angle, &Load::NONE));
    // Three at 0, 90 and 180 deg: without friction the third one is useless, and not needed.
    let three = [contacts[0], contacts[9], contacts[18]];
    assert!(grip(1e-3).holds(&three, &Load::NONE));
    // Three on one half of a circle cannot press against each other.
    assert!(!grip(1e-3).holds(&[contacts[0], contacts[4], contacts[9]], &Load::NONE));
}

#[test]
fn a_removal_in_balance_holds_up_to_its_safety() {
    // Without a moment two opposite fingers resist across their chord up to friction times all pressing and adhesive force.
    let contacts = circle();
    let resists = |safety: f64| {
        let facts = FingersFacts { removal_safety: safety, ..hand(0.3, Adhesion::Sticking) };
        GripModel::of(&facts, 9.0).resists([&contacts[0], &contacts[18]], &contacts[9], &Load::NONE)
    };
    // Both press with their greatest force: 2 × 0.3 × (30 + 1.5) μN over 1.5 μN.
    assert!(resists(12.6) && !resists(12.6 + 1e-6));
}

#[test]
fn a_load_across_is_borne_by_levers_and_torsion() {
    let contacts = circle();
    let holds = |grasp: &[usize], torsion_um: f64, load: Load| {
        let held: Vec<Contact> = grasp.iter().map(|contact| contacts[*contact]).collect();
        GripModel::of(&FingersFacts { torsion_um, ..hand(0.3, Adhesion::Sticking) }, 9.0).holds(&held, &load)
    };
    let across = |across_un: f64| Load { across_un, ..Load::NONE };
    // Through the chord: each of two that press with 30 uN bears 0.3 × (30 + 1.5) uN.
    assert!(holds(&[0, 18], 0.0, across(18.9)) && !holds(&[0, 18], 0.0, across(18.9 + 1e-6)));
    assert!(holds(&[0, 12, 24], 0.0, across(-28.35)) && !holds(&[0, 12, 24], 0.0, across(-28.35 - 1e-6)));
    // Off the chord, two bear the torque about their normals, 2 × 31.5 uN × 0.1 um.
    let beside = |across_un: f64| Load { across_un, at_um: [0.0, 3.0], ..Load::NONE };
    assert!(!holds(&[0, 18], 0.0, beside(1e-3)));
    assert!(holds(&[0, 18], 0.1, beside(2.1)) && !holds(&[0, 18], 0.1, beside(2.1 + 1e-6)));
    // A third finger behind the chord acts as a lever: the load off the chord is borne, since adhesive tips pull too.
    assert!(holds(&[0, 18, 27], 0.0, beside(1.0)));
    // Parallel to the plane, but acting at a height above it.
    let before = |height_um: f64| Load { force_un: [0.0, 1.0], height_um, ..Load::NONE };
    assert!(
        holds(&[0, 18], 0.0, before(0.0)) && !holds(&[0, 18], 0.0, before(0.1)) && holds(&[0, 18], 0.1, before(0.1))
    );
}

/// Two tips below a part bear its weight like a table; the part is held only if they would hold it without the weight,
/// too.
#[test]
fn a_part_that_rests_on_its_tips_is_not_held() {
    let contacts = circle();
    let grip = GripModel::of(&hand(0.3, Adhesion::Absent), 9.0);
    let weight = Load { force_un: [0.0, -1.0], ..Load::NONE };
    let below = [contacts[24], contacts[30]];
    assert!(grip.holds_under(&below, &weight) && !grip.holds(&below, &weight));
    let beside = [contacts[0], contacts[18]];
    assert!(grip.holds_under(&beside, &weight) && grip.holds(&beside, &weight));
}

#[test]
fn a_load_turns_against_the_part() {
    let load = Load { force_un: [0.0, -2.0], across_un: 0.5, at_um: [1.0, 0.0], height_um: 0.0 };
    let [x_un, y_un] = load.after_turn(TAU / 4.0).force_un;
    assert!((x_un + 2.0).abs() < 1e-12 && y_un.abs() < 1e-12, "what is down lies along -x of a part turned by 90 deg");
    let quarter = nalgebra::UnitQuaternion::from_euler_angles(0.0, 0.0, TAU / 4.0);
    let seen = Load::seen(crate::device::fingers::Plane::Xy, &quarter, [0.0, -2.0, -0.5], [1.0, 0.0, 0.0]);
    assert!((seen.force_un[0] + 2.0).abs() < 1e-12 && seen.across_un == -0.5 && seen.at_um == [1.0, 0.0]);
}

#[test]
fn tables_have_a_size_that_is_not_passed() {
    let part = ellipse([120.0, 90.0], 512);
    let facts = hand(0.3, Adhesion::Sticking);
    let contacts = part.contacts(&facts);
    let load = Load { force_un: [0.1, 0.0], ..Load::NONE };
    let asked = TableRequest { facts: &facts, contacts, load, lowest: 0, angles: 5 };
    let refused = tables(&asked, &LooksBudget::default(), &mut |_, _, _| true);
    assert_eq!(refused.err(), Some(NoTables::TooManyGrasps { contacts: 512, layers: 5 }));
}

#[test]
fn a_contact_that_is_out_of_reach_is_neither_come_to_nor_left() {
    let part = ellipse([8.0, 6.1], 28);
    let facts = hand(0.3, Adhesion::Sticking);
    let contacts = part.contacts(&facts);
    let asked = TableRequest { facts: &facts, contacts, load: Load::NONE, lowest: 0, angles: 1 };
    let found = tables(&asked, &LooksBudget::default(), &mut |i, j, k| i < j && k != 5).expect("few grasps");
    let free = tabulated(&facts, &part, Load::NONE, 1);
    for (i, j) in (0..28).flat_map(|i| (0..28).map(move |j| (i, j))) {
        for k in 0..28 {
            let bit = found.three(i, j, k);
            let (now, was) = (&found.layers[0], &free.layers[0]);
            assert_eq!(
                [now.place.has(bit), now.leave.has(bit)],
                [was.place.has(bit), was.leave.has(bit)].map(|was| was && k != 5)
            );
            assert_eq!(now.triple.has(bit), was.triple.has(bit));
        }
    }
}

#[test]
fn rows_of_bits_go_in_and_out_anywhere() {
    let mut dice = Random::new(1);
    for length in [1, 28, 63, 64, 65, 74, 128, 200] {
        let start = dice.index(200);
        let mut bits = ContactBits::new(start + length + 70);
        let mut row = vec![0_u64; usize::div_ceil(length, 64)];
        (0..length).filter(|_| dice.index(2) == 0).for_each(|bit| row[bit / 64] |= 1 << (bit % 64));
        bits.put_row(start, &row);
        (start + length..start + length + 70).for_each(|bit| bits.put(bit));
        let mut back = vec![u64::MAX; row.len()];
        bits.read_row(start, length, &mut back);
        assert_eq!(back, row, "{start} {length}");
        let mut stepped = row.clone();
        rows::step(&row, length, &mut stepped);
        let has = |row: &[u64], bit: usize| row[bit / 64] >> (bit % 64) & 1 == 1;
        assert!((0..length).all(|bit| has(&stepped, (bit + 1) % length) == has(&row, bit)));
    }
}
