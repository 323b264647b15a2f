use super::*;
use microlp::{ComparisonOp, OptimizationDirection, Problem, SolveOutcome, Variable};
use nalgebra::Vector3;

/// One random query to the solver and to the predicate.
#[derive(Debug, Clone)]
struct Case {
    facts: FingersFacts,
    contacts: Vec<Contact>,
    leaves: Option<Contact>,
    load: Load,
}

const ARM_UM: f64 = 15.0;

impl Case {
    fn random(dice: &mut Random) -> Case {
        let adhesion = if dice.index(2) == 0 { Adhesion::Sticking } else { Adhesion::Absent };
        let mut facts = hand(dice.between(0.05, 0.9), adhesion);
        facts.max_force_un = [3.0, 10.0, 30.0][dice.index(3)];
        facts.removal_safety = dice.between(0.5, 4.0);
        let semi_um = [dice.between(5.0, 20.0), dice.between(5.0, 20.0)];
        let tilt_rad = if dice.index(4) == 0 { 1.5 } else { 0.0 };
        let mut contact = || any_contact(dice, semi_um, tilt_rad);
        let mut contacts = vec![contact(), contact(), contact()];
        let size_un = [0.0, 0.5, 2.0, 8.0][dice.index(4)];
        let force_un = [dice.between(-size_un, size_un), dice.between(-size_un, size_un)];
        let across_un = if dice.index(2) == 0 { 0.0 } else { dice.between(0.0, size_un) };
        facts.torsion_um = [0.0, 0.05, 1.0][dice.index(3)];
        let height_um = if dice.index(2) == 0 { 0.0 } else { dice.between(-2.0, 2.0) };
        let load = Load { force_un, across_un, at_um: [dice.between(-3.0, 3.0), dice.between(-3.0, 3.0)], height_um };
        let kind = dice.index(3);
        let leaves = if kind == 2 { contacts.pop() } else { None };
        contacts.truncate(if kind == 0 { 2 } else { 3 });
        Case { facts, contacts, leaves, load }
    }

    /// Category: two fingers, three, or two against one that leaves; with or without adhesion.
    fn sort(&self) -> usize {
        let fingers = if self.leaves.is_some() { 2 } else { self.contacts.len() - 2 };
        2 * fingers + usize::from(self.facts.adhesion == Adhesion::Absent)
    }

    fn predicted(&self) -> bool {
        let grip = GripModel::of(&self.facts, ARM_UM);
        match &self.leaves {
            Some(leaves) => grip.resists([&self.contacts[0], &self.contacts[1]], leaves, &self.load),
            None => grip.holds(&self.contacts, &self.load),
        }
    }

    /// The solver's answer with friction and forces changed by a relative amount.
    fn solved(&self, change: f64) -> bool {
        let leans = self.leaves.is_none() && self.facts.sticking_un() == 0.0 && self.load.size_un() > 0.0;
        if leans && !(Case { load: Load::NONE, ..self.clone() }).solved(change) {
            return false;
        }
        let friction = self.facts.friction * (1.0 + change);
        let sticking_un = self.facts.sticking_un();
        let most_un = self.facts.max_force_un * (1.0 + change);
        let (pull_un, leaves) = match (&self.leaves, sticking_un > 0.0) {
            (Some(leaves), true) => (self.facts.removal_safety * sticking_un, *leaves),
            (Some(_), false) | (None, _) => (0.0, self.contacts[0]),
        };
        let must_squeeze = sticking_un == 0.0 && self.load.size_un() == 0.0;
        let torsion_um = self.facts.torsion_um * (1.0 + change);
        let mut problem = Problem::new(OptimizationDirection::Maximize);
        let mut rows: [Vec<(Variable, f64)>; 6] = Default::default();
        for contact in &self.contacts {
            let free = (f64::NEG_INFINITY, f64::INFINITY);
            let normal_un = problem.add_var(1.0, (-sticking_un, most_un));
            let [tangential_un, across_un, torque_un] = [0, 1, 2].map(|_| problem.add_var(0.0, free));
            for (one, other) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                let row = [(tangential_un, one), (across_un, other), (normal_un, -friction)];
                problem.add_constraint(row, ComparisonOp::Le, friction * sticking_un);
            }
            for sign in [1.0, -1.0] {
                let row = [(torque_un, sign), (normal_un, -torsion_um / ARM_UM)];
                problem.add_constraint(row, ComparisonOp::Le, torsion_um / ARM_UM * sticking_un);
            }
            let [x, y] = contact.normal.map(|part| -part);
            let at = Vector3::new(contact.point_um[0], contact.point_um[1], 0.0) / ARM_UM;
            for (variable, force) in [
                (normal_un, Vector3::new(x, y, 0.0)),
                (tangential_un, Vector3::new(-y, x, 0.0)),
                (across_un, Vector3::z()),
            ] {
                let parts = force.iter().copied().chain(at.cross(&force).iter().copied()).collect::<Vec<f64>>();
                rows.iter_mut().zip(parts).for_each(|(row, part)| row.push((variable, part)));
            }
            rows[3].push((torque_un, x));
            rows[4].push((torque_un, y));
        }
        let [nx, ny] = leaves.normal.map(|part| part * pull_un);
        let pull = (Vector3::new(nx, ny, 0.0), Vector3::new(leaves.point_um[0], leaves.point_um[1], 0.0));
        let [fx, fy] = self.load.force_un;
        let [lx, ly] = self.load.at_um;
        let load = (Vector3::new(fx, fy, self.load.across_un), Vector3::new(lx, ly, self.load.height_um));
        let outer_un = [pull, load].map(|(force, at)| (force, (at / ARM_UM).cross(&force)));
        for (axis, row) in rows.iter().enumerate() {
            let sum: f64 =
                outer_un.iter().map(|(force, torque)| if axis < 3 { force[axis] } else { torque[axis - 3] }).sum();
            problem.add_constraint(row, ComparisonOp::Eq, -sum);
        }
        match problem.solve() {
            Ok(SolveOutcome::Solution(solution)) => !must_squeeze || solution.objective() > 1e-3,
            Ok(SolveOutcome::Interrupted(_)) | Err(_) => false,
        }
    }
}

/// A contact on an ellipse, with its normal rotated by up to `tilt_rad`, as on a concave outline.
fn any_contact(dice: &mut Random, [a, b]: [f64; 2], tilt_rad: f64) -> Contact {
    let (sin, cos) = dice.between(0.0, TAU).sin_cos();
    let normal_rad = (sin / b).atan2(cos / a) + dice.between(-tilt_rad, tilt_rad);
    let (ny, nx) = normal_rad.sin_cos();
    let point_um = [a * cos, b * sin];
    let tip_um = [point_um[0] + 4.5 * nx, point_um[1] + 4.5 * ny];
    Contact { point_um, normal: [nx, ny], tip_um, usable: true }
}

#[test]
fn the_predicate_agrees_with_a_solver_on_random_grasps() {
    let mut dice = Random::new(5);
    let (mut tally, mut marginal) = ([[0_u32; 2]; 6], 0);
    for _ in 0..40_000 {
        let case = Case::random(&mut dice);
        let (predicted, solved) = (case.predicted(), case.solved(0.0));
        tally[case.sort()][usize::from(solved)] += 1;
        if predicted != solved {
            marginal += 1;
            assert_ne!(case.solved(-1e-4), case.solved(1e-4), "{predicted} and not {solved}: {case:?}");
        }
    }
    let is_mixed = |[no, yes]: &[u32; 2]| no.min(yes) * 20 > no + yes;
    assert!(tally.iter().all(is_mixed) && marginal < 20, "{tally:?} {marginal}");
}
