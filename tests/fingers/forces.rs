//! Whether tip forces balance the wrench on a part: a small linear program, solved by the plain simplex method.
//!
//! A tip that presses with n and sticks with s exerts forces along both tangents and a torque about its normal, within
//! the friction pyramid: friction times n + s. The pyramid has eight edges, so a balance is a sum of edges with
//! non-negative weights whose sum for each tip is at most the tip's greatest pressing force plus its sticking force.
//! Feasibility is the first phase of the simplex method, with Bland's rule.

/// A tip in contact: its place, pressing direction, and figures.
#[derive(Debug, Clone, Copy)]
pub struct Tip {
    pub at_um: [f64; 2],
    /// Unit vector into the part.
    pub inward: [f64; 2],
    pub friction: f64,
    /// Torque per unit of force, in the unit of the torques below.
    pub torsion: f64,
    pub sticking_un: f64,
    pub most_un: f64,
}

/// A force and a torque in space.
pub type Wrench = [f64; 6];

/// The wrench of a force at a point of the plane; torques are given as forces at a lever arm of `arm_um`.
pub fn wrench([x, y, z]: [f64; 3], at_um: [f64; 2], arm_um: f64) -> Wrench {
    let [px, py] = at_um.map(|part| part / arm_um);
    [x, y, z, py * z, -px * z, px * y - py * x]
}

impl Tip {
    /// The edges of the tip's friction pyramid, per unit of pressing and sticking force.
    fn edges(&self, arm_um: f64) -> [Wrench; 8] {
        let [x, y] = self.inward;
        let mut edges = [[0.0; 6]; 8];
        for (index, edge) in edges.iter_mut().enumerate() {
            let (along, across) = [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)][index / 2];
            let twist = if index % 2 == 0 { self.torsion } else { -self.torsion };
            let force = [x - y * along * self.friction, y + x * along * self.friction, across * self.friction];
            *edge = wrench(force, self.at_um, arm_um);
            edge[3] += twist * x;
            edge[4] += twist * y;
        }
        edges
    }
}

/// Whether the tips can balance an outer wrench, up to a residual of `rest_un`. If there is no load and nothing sticks,
/// the forces must not all be zero.
pub fn balance(tips: &[Tip], outer: Wrench, arm_um: f64, rest_un: f64) -> bool {
    let is_idle = outer == [0.0; 6] && tips.iter().all(|tip| tip.sticking_un == 0.0);
    let mut columns: Vec<Vec<f64>> = Vec::new();
    let mut wanted: Vec<f64> = outer.iter().map(|part| -part).collect();
    // A tip exerts the sum of its edges minus the sticking force along the normal.
    for tip in tips {
        let stuck = wrench([tip.inward[0], tip.inward[1], 0.0], tip.at_um, arm_um);
        wanted.iter_mut().zip(stuck).for_each(|(wanted, part)| *wanted += tip.sticking_un * part);
    }
    let rows = 6 + if is_idle { 1 } else { tips.len() };
    for (index, tip) in tips.iter().enumerate() {
        for edge in tip.edges(arm_um) {
            let mut column = edge.to_vec();
            column.resize(rows, 0.0);
            column[if is_idle { 6 } else { 6 + index }] = 1.0;
            columns.push(column);
        }
    }
    if is_idle {
        wanted.push(1.0);
    } else {
        for (index, tip) in tips.iter().enumerate() {
            let mut slack = vec![0.0; rows];
            slack[6 + index] = 1.0;
            columns.push(slack);
            wanted.push(tip.most_un + tip.sticking_un);
        }
    }
    let size = wanted.iter().fold(1.0, |most: f64, part| most.max(part.abs()));
    wanted.iter_mut().for_each(|part| *part /= size);
    least_rest(columns, wanted) <= rest_un / size + 1e-9
}

/// Entries below this are treated as zero.
const ZERO: f64 = 1e-11;

/// The least residual of `wanted` over all sums of the columns with non-negative weights.
fn least_rest(columns: Vec<Vec<f64>>, mut wanted: Vec<f64>) -> f64 {
    let (rows, count) = (wanted.len(), columns.len());
    let mut table: Vec<Vec<f64>> = (0..rows).map(|row| columns.iter().map(|column| column[row]).collect()).collect();
    for (row, wanted) in table.iter_mut().zip(&mut wanted) {
        if *wanted < 0.0 {
            *wanted = -*wanted;
            row.iter_mut().for_each(|entry| *entry = -*entry);
        }
    }
    // The basis begins with the residual of each row, numbered from `count` on.
    let mut basis: Vec<usize> = (count..count + rows).collect();
    for pivots in 0.. {
        assert!(pivots < 10_000, "no end: {table:?}");
        let gain = |column: usize| -> f64 {
            basis.iter().zip(&table).filter(|(member, _)| **member >= count).map(|(_, row)| row[column]).sum()
        };
        let missing = || basis.iter().zip(&wanted).filter(|(member, _)| **member >= count).map(|(_, w)| *w).sum();
        let Some(column) = (0..count).find(|column| !basis.contains(column) && gain(*column) > ZERO) else {
            return missing();
        };
        let steps =
            (0..rows).filter(|row| table[*row][column] > ZERO).map(|row| (wanted[row] / table[row][column], row));
        let leaving = steps.min_by(|one, other| one.0.total_cmp(&other.0).then(basis[one.1].cmp(&basis[other.1])));
        let Some((_, pivot)) = leaving else { return missing() };
        let by = table[pivot][column];
        table[pivot].iter_mut().for_each(|entry| *entry /= by);
        wanted[pivot] /= by;
        let (above, kept) = (table[pivot].clone(), wanted[pivot]);
        for row in (0..rows).filter(|row| *row != pivot) {
            let by = table[row][column];
            if by != 0.0 {
                table[row].iter_mut().zip(&above).for_each(|(entry, above)| *entry -= by * above);
                wanted[row] = (wanted[row] - by * kept).max(0.0);
            }
        }
        basis[pivot] = column;
    }
    f64::INFINITY
}

mod tests {
    use super::*;
    use crate::random::Random;
    use microlp::{ComparisonOp, OptimizationDirection, Problem, Variable};

    /// The same feasibility problem as a linear program for another solver.
    fn solved(tips: &[Tip], outer: Wrench, arm_um: f64) -> bool {
        let mut problem = Problem::new(OptimizationDirection::Maximize);
        let mut rows: [Vec<(Variable, f64)>; 6] = Default::default();
        let free = (f64::NEG_INFINITY, f64::INFINITY);
        for tip in tips {
            let normal = problem.add_var(0.0, (-tip.sticking_un, tip.most_un));
            let [along, across, torque] = [0, 1, 2].map(|_| problem.add_var(0.0, free));
            for (one, other) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                let row = [(along, one), (across, other), (normal, -tip.friction)];
                problem.add_constraint(row, ComparisonOp::Le, tip.friction * tip.sticking_un);
            }
            for sign in [1.0, -1.0] {
                let row = [(torque, sign), (normal, -tip.torsion)];
                problem.add_constraint(row, ComparisonOp::Le, tip.torsion * tip.sticking_un);
            }
            let [x, y] = tip.inward;
            for (variable, force) in [(normal, [x, y, 0.0]), (along, [-y, x, 0.0]), (across, [0.0, 0.0, 1.0])] {
                let parts = wrench(force, tip.at_um, arm_um);
                rows.iter_mut().zip(parts).for_each(|(row, part)| row.push((variable, part)));
            }
            rows[3].push((torque, x));
            rows[4].push((torque, y));
        }
        for (row, outer) in rows.iter().zip(outer) {
            problem.add_constraint(row, ComparisonOp::Eq, -outer);
        }
        problem.solve().is_ok()
    }

    #[test]
    fn balances_are_those_of_another_solver() {
        let mut chance = Random::new(77);
        let mut count = [0; 2];
        for _ in 0..2000 {
            let sticking_un = [0.0, 1.5][chance.below(2) as usize];
            let tip = |chance: &mut Random| {
                let (sin, cos) = (std::f64::consts::TAU * chance.thousandths(0.0, 1.0)).sin_cos();
                Tip {
                    at_um: [-10.0 * cos, -7.0 * sin],
                    inward: [cos, sin],
                    friction: chance.thousandths(0.1, 0.8),
                    torsion: [0.0, 0.05][chance.below(2) as usize],
                    sticking_un,
                    most_un: 5.0,
                }
            };
            let tips: Vec<Tip> = (0..2 + chance.below(2)).map(|_| tip(&mut chance)).collect();
            let mut part = || chance.thousandths(-1.0, 1.0);
            let outer = wrench([part(), part(), 0.3 * part()], [part(), part()], 10.0);
            let holds = balance(&tips, outer, 10.0, 0.0);
            assert_eq!(holds, solved(&tips, outer, 10.0), "{tips:?} {outer:?}");
            count[usize::from(holds)] += 1;
        }
        assert!(count[0] > 300 && count[1] > 300, "{count:?}");
    }
}
