//! Free tips keep their clearances for all grasps: every move is sampled densely.

use super::*;

/// Random acts that are consistent with one another.
struct Author<'a> {
    bench: &'a Bench,
    dice: Dice,
    grasp: Vec<u32>,
    acts: Vec<FingerAct>,
}

impl Author<'_> {
    fn held(&self) -> Vec<usize> {
        (0..self.grasp.len()).filter(|finger| self.grasp[*finger] != 0).collect()
    }

    fn contacts(&self, fingers: &[usize]) -> Vec<usize> {
        fingers.iter().map(|finger| self.grasp[*finger] as usize - 1).collect()
    }

    fn are_apart(&self, grasp: &[u32]) -> bool {
        let held: Vec<u32> = grasp.iter().copied().filter(|contact| *contact != 0).collect();
        let contacts: Vec<usize> = held.iter().map(|contact| *contact as usize - 1).collect();
        let touch = |contact: usize| self.bench.reach.way(contact, &[]).expect("it is open").touch_um;
        let pairs = (0..contacts.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
        let far_um = 2.0 * self.bench.facts.tip_radius_um + self.bench.facts.clearance_um;
        pairs.into_iter().all(|(a, b)| (touch(contacts[a]) - touch(contacts[b])).norm() > far_um)
    }

    fn begin(&mut self) {
        let (fingers, count) = (self.grasp.len(), self.bench.reach.contacts());
        loop {
            let mut grasp = vec![0; fingers];
            for _ in 0..2 + self.dice.below(2) {
                grasp[self.dice.below(fingers)] = 1 + self.dice.below(count) as u32;
            }
            let held: Vec<usize> =
                grasp.iter().filter(|contact| **contact != 0).map(|contact| *contact as usize - 1).collect();
            if held.len() >= 2 && self.bench.reach.order(&held).is_some() {
                let plane = Plane::ALL[self.dice.below(2)];
                self.acts.push(FingerAct::Begin { plane, grasp: grasp.clone() });
                self.grasp = grasp;
                return;
            }
        }
    }

    fn change(&mut self) {
        let held = self.held();
        if held.len() == 2 {
            let free: Vec<usize> = (0..self.grasp.len()).filter(|finger| self.grasp[*finger] == 0).collect();
            let finger = free[self.dice.below(free.len())];
            let contact = self.dice.below(self.bench.reach.contacts());
            let [i, j] = self.contacts(&held)[..] else { return };
            if self.bench.reach.reaches(i, j, contact) {
                self.grasp[finger] = contact as u32 + 1;
                self.acts.push(FingerAct::Place { finger, contact: contact as u32 + 1 });
            }
        } else {
            let finger = held[self.dice.below(held.len())];
            let stay: Vec<usize> = held.into_iter().filter(|other| *other != finger).collect();
            let [i, j] = self.contacts(&stay)[..] else { return };
            if self.bench.reach.reaches(i, j, self.grasp[finger] as usize - 1) {
                self.grasp[finger] = 0;
                self.acts.push(FingerAct::Leave { finger });
            }
        }
    }

    fn roll(&mut self) {
        let sense = [1, -1][self.dice.below(2)];
        let count = self.bench.reach.contacts() as i64;
        let next = |contact: u32| ((i64::from(contact) - 1 - i64::from(sense)).rem_euclid(count) + 1) as u32;
        let grasp: Vec<u32> = self.grasp.iter().map(|contact| if *contact == 0 { 0 } else { next(*contact) }).collect();
        if self.are_apart(&grasp) {
            self.grasp = grasp;
            self.acts.push(FingerAct::Roll(sense));
        }
    }

    fn release(&mut self) {
        let held = self.held();
        if let Some(order) = self.bench.reach.order(&self.contacts(&held)) {
            self.acts.push(FingerAct::Release { order: order.iter().rev().map(|index| held[*index]).collect() });
            self.grasp.fill(0);
            self.begin();
        }
    }
}

fn by_chance(bench: &Bench, seed: u64) -> FingersCourse {
    let fingers = bench.facts.fingers as usize;
    let mut author = Author { bench, dice: Dice::new(seed), grasp: vec![0; fingers], acts: Vec::new() };
    author.begin();
    for _ in 0..60 {
        match author.dice.below(8) {
            0..=3 => author.change(),
            4 | 5 => author.roll(),
            6 => author.acts.push(FingerAct::Translate([1.0, -2.0, 0.5])),
            _ => author.release(),
        }
    }
    bench.course(author.acts)
}

/// The situation during the moves between two states.
struct Scene<'a> {
    bench: &'a Bench,
    holds: [&'a HeldGrasp; 2],
    /// Position of each tip at both states.
    ends: [&'a [[f64; 3]]; 2],
}

impl Scene<'_> {
    fn is_free(&self, finger: usize) -> bool {
        self.holds.iter().any(|hold| hold.grasp[finger] == 0)
    }

    /// Whether the part rests: neither turned nor moved.
    fn is_quiet(&self) -> bool {
        let [before, after] = self.holds;
        before.position_um == after.position_um && before.orientation == after.orientation
    }

    fn check(&self, tips: &[[f64; 3]]) -> usize {
        let facts = &self.bench.facts;
        let apart_um = 2.0 * facts.tip_radius_um + facts.clearance_um - facts.tolerance_um - 1e-9;
        for (a, b) in (0..tips.len()).flat_map(|b| (0..b).map(move |a| (a, b))) {
            let gap_um = (Vector3::from(tips[a]) - Vector3::from(tips[b])).norm();
            assert!(gap_um >= apart_um || !(self.is_free(a) || self.is_free(b)), "{a} and {b}: {gap_um}");
        }
        let free = (0..tips.len()).filter(|finger| self.is_quiet() && self.is_free(*finger));
        free.map(|finger| self.check_outline(finger, tips[finger])).sum()
    }

    /// 1 if the tip is near enough for a check against the outline.
    fn check_outline(&self, finger: usize, tip: [f64; 3]) -> usize {
        let (bench, facts) = (self.bench, &self.bench.facts);
        let hold = HeldGrasp { plane: self.holds[1].plane, ..self.holds[0].clone() };
        let (place, off_um) = in_section(&hold, tip);
        if place.norm().hypot(off_um) >= bench.hand().sphere_um(0) - facts.tolerance_um - 1e-9 {
            return 0;
        }
        assert!(off_um.abs() < 1e-6, "within the sphere a tip stays in the plane");
        let is_slow = [0, 1].iter().any(|end| {
            let from_um = (Vector3::from(tip) - Vector3::from(self.ends[*end][finger])).norm();
            self.holds[*end].grasp[finger] != 0 && from_um <= facts.retract_um + 1e-6
        });
        let apart_um = facts.tip_radius_um + if is_slow { 0.0 } else { facts.clearance_um };
        let outline_um = bench.curve.nearest([place.x, place.y]).distance_um;
        assert!(outline_um >= apart_um - facts.tolerance_um / 4.0, "finger {finger}: {outline_um}");
        1
    }
}

/// Samples a motion; returns the number of samples in which a free tip was near the part.
fn sample(bench: &Bench, motion: &FingersMotion) -> usize {
    let moves: Vec<&TipsMove> = motion.steps.iter().flatten().collect();
    let mut tips = &motion.start.tips_um;
    let mut before = (&motion.start.hold, &motion.start.tips_um);
    let mut near = 0;
    for (index, stretch) in moves.iter().enumerate() {
        let next = moves[index..].iter().find_map(|after| after.state.as_ref().map(|hold| (hold, &after.tips_um)));
        let after = next.expect("all acts of these courses end in a state");
        let scene = Scene { bench, holds: [before.0, after.0], ends: [before.1, after.1] };
        for part in 1..=12 {
            let part = f64::from(part) / 12.0;
            let between = |finger: usize| {
                std::array::from_fn(|axis| tips[finger][axis] * (1.0 - part) + stretch.tips_um[finger][axis] * part)
            };
            near += scene.check(&(0..tips.len()).map(between).collect::<Vec<_>>());
        }
        tips = &stretch.tips_um;
        before = stretch.state.as_ref().map_or(before, |hold| (hold, tips));
    }
    near
}

#[test]
fn free_tips_keep_clear() {
    for (fingers, seeds) in [(3, 0..8), (4, 8..12), (6, 12..16)] {
        for bench in benches(fingers) {
            for seed in seeds.clone() {
                let course = by_chance(&bench, seed);
                let motion = bench.hand().motion(&course).expect("these courses can be carried out");
                let count: usize = motion.steps.iter().map(Vec::len).sum();
                assert!(count > 100, "{count}");
                assert!(sample(&bench, &motion) > 100);
            }
        }
    }
}

/// Only the finger that an act names moves, apart from others that step aside.
#[test]
fn fingers_step_aside_only_where_they_must() {
    let mut asides = 0;
    for bench in benches(6) {
        let motion = bench.hand().motion(&by_chance(&bench, 3)).expect("it can be carried out");
        let mut tips = &motion.start.tips_um;
        let mut hold = &motion.start.hold;
        for stretch in motion.steps.iter().flatten() {
            let moved: Vec<usize> = (0..6).filter(|finger| tips[*finger] != stretch.tips_um[*finger]).collect();
            let is_carried = moved.len() == 6;
            let held = moved.iter().filter(|finger| hold.grasp[**finger] != 0).count();
            assert!(is_carried || moved.len() == 1 || held == moved.len(), "{moved:?}");
            let from_um = |tip: &[f64; 3]| (Vector3::from(*tip) - Vector3::from(hold.position_um)).norm();
            asides += usize::from(moved.len() == 1 && moved[0] == 0 && held == 0 && from_um(&tips[0]) > 30.0);
            tips = &stretch.tips_um;
            hold = stretch.state.as_ref().unwrap_or(hold);
        }
    }
    assert!(asides > 0);
}

#[test]
fn home_is_clear() {
    for fingers in 3..=6 {
        let bench = Bench::new(ellipse(), facts(fingers));
        let home = bench.hand().home([5.0, -3.0, 2.0]);
        assert_eq!(home.tips_um.len(), fingers as usize);
        assert!((home.tips_um[0][0] - 5.0 - bench.hand().sphere_um(0)).abs() < 1e-12);
        assert!(home.tips_um.iter().all(|tip| tip[2] == 2.0));
        assert_eq!(home.hold.grasp, vec![0; fingers as usize]);
    }
}

/// Between opposite directions the great circle is not unique: the path is deterministic, and lies on the sphere.
#[test]
fn opposite_directions_have_a_way() {
    let bench = Bench::new(ellipse(), facts(3));
    let mut course = bench.course(vec![begin(Plane::Xy, &[38, 1, 0])]);
    course.start.tips_um[0] = [bench.hand().sphere_um(0), 0.0, 0.0];
    let motion = bench.hand().motion(&course).expect("it can be carried out");
    assert_eq!(bench.hand().motion(&course).expect("again"), motion);
    let half: Vec<f64> = motion.steps[0].iter().map(|stretch| stretch.tips_um[0][1]).collect();
    let farthest_um = half.iter().fold(0.0, |most: f64, y| most.max(*y));
    assert!((farthest_um - bench.hand().sphere_um(0)).abs() < 1.0, "it goes by +y: {farthest_um}");
    assert!(sample(&bench, &motion) > 10);
}

/// Chords are as long as the tolerance allows.
#[test]
fn travel_follows_its_sphere() {
    let bench = Bench::new(ellipse(), facts(3));
    let course = bench.course(vec![begin(Plane::Xz, &[30, 60, 0])]);
    let motion = bench.hand().motion(&course).expect("it can be carried out");
    let radius_um = bench.hand().sphere_um(0);
    let mut tip = Vector3::from(motion.start.tips_um[0]);
    let mut lowest_um = f64::INFINITY;
    for stretch in &motion.steps[0] {
        let next = Vector3::from(stretch.tips_um[0]);
        if (next.norm() - radius_um).abs() < 1e-9 && next != tip {
            assert!((tip.norm() - radius_um).abs() < 1e-9);
            lowest_um = lowest_um.min(tip.lerp(&next, 0.5).norm());
        }
        tip = next;
    }
    let dip_um = radius_um - lowest_um;
    assert!(dip_um <= bench.facts.tolerance_um + 1e-9 && dip_um > bench.facts.tolerance_um / 2.0, "{dip_um}");
}
