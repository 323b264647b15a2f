//! A small linear program: feasibility of conditions on a dozen variables.
//!
//! Input: equalities and inequalities. Output: whether some values satisfy all of them, each inequality up to a slack. Method:
//! equalities are solved for some of the variables (Gauss and Jordan); for the remaining inequalities the greatest margin is the
//! least value of the dual program, which the two-phase simplex method finds with Bland's rule, which guarantees termination.

/// Forces and torques of three fingers.
pub const VARIABLES: usize = 12;

/// Sums of forces and moments.
const EQUALITIES: usize = 6;

/// Conditions on three fingers.
const INEQUALITIES: usize = 21;

/// Magnitude below which a number counts as zero, up to rounding.
const NOTHING: f64 = 1e-11;

/// A row: coefficients of the variables, and the right-hand side.
type SimplexRow = [f64; VARIABLES + 1];

/// A system of conditions.
#[derive(Debug, Clone)]
pub struct Conditions {
    /// The left-hand side equals the last number.
    pub equalities: [SimplexRow; EQUALITIES],
    /// The left-hand side is at most the last number.
    inequalities: [SimplexRow; INEQUALITIES],
    count: usize,
}

impl Conditions {
    /// No inequality, and trivial equalities.
    pub fn none() -> Conditions {
        let (equalities, inequalities) = ([[0.0; VARIABLES + 1]; EQUALITIES], [[0.0; VARIABLES + 1]; INEQUALITIES]);
        Conditions { equalities, inequalities, count: 0 }
    }

    /// Adds an inequality over four consecutive variables.
    pub fn push(&mut self, from: usize, shares: [f64; 4], bound: f64) {
        let row = &mut self.inequalities[self.count];
        row[from..from + 4].copy_from_slice(&shares);
        row[VARIABLES] = bound;
        self.count += 1;
    }
}

/// Whether some values satisfy all conditions, inequalities up to a slack.
pub fn are_kept(conditions: &Conditions, slack: f64) -> bool {
    let mut conditions = conditions.clone();
    let Some(solved) = solve(&mut conditions, slack) else { return false };
    let free: Vec<usize> = (0..VARIABLES).filter(|variable| !solved[*variable]).collect();
    let inequalities = &conditions.inequalities[..conditions.count];
    // One row for each free variable, and the sum of the weights, which must be 1.
    let mut rows: Vec<Vec<f64>> = Vec::with_capacity(free.len() + 1);
    for variable in &free {
        rows.push(inequalities.iter().map(|row| row[*variable]).chain([0.0]).collect());
    }
    rows.push(vec![1.0; inequalities.len() + 1]);
    let costs: Vec<f64> = inequalities.iter().map(|row| row[VARIABLES]).collect();
    match least(rows, &costs, -slack) {
        Some(margin) => margin >= -slack,
        // The dual is infeasible: the margin is unbounded.
        None => true,
    }
}

/// Solves the equalities for as many variables as they determine, and substitutes these into the inequalities; returns which
/// variables they are. `None` where the equalities contradict one another.
fn solve(conditions: &mut Conditions, slack: f64) -> Option<[bool; VARIABLES]> {
    let mut solved = [false; VARIABLES];
    for at in 0..EQUALITIES {
        let places = (at..EQUALITIES).flat_map(|row| (0..VARIABLES).map(move |variable| (row, variable)));
        let size = |place: &(usize, usize)| conditions.equalities[place.0][place.1].abs();
        let best = places.max_by(|one, other| size(one).total_cmp(&size(other)));
        let (row, variable) = best.filter(|place| size(place) > NOTHING).unwrap_or((EQUALITIES, 0));
        if row == EQUALITIES {
            let is_kept = |row: &SimplexRow| row[VARIABLES].abs() <= slack;
            return conditions.equalities[at..].iter().all(is_kept).then_some(solved);
        }
        conditions.equalities.swap(at, row);
        let pivot = conditions.equalities[at][variable];
        conditions.equalities[at].iter_mut().for_each(|share| *share /= pivot);
        let solution = conditions.equalities[at];
        let rest = conditions.equalities.iter_mut().enumerate().filter(|(row, _)| *row != at).map(|(_, row)| row);
        for row in rest.chain(&mut conditions.inequalities) {
            let factor = row[variable];
            if factor != 0.0 {
                row.iter_mut().zip(&solution).for_each(|(share, of)| *share -= factor * of);
                row[variable] = 0.0;
            }
        }
        solved[variable] = true;
    }
    Some(solved)
}

/// The least cost of non-negative weights that satisfy the rows (the last number of each is its right-hand side, which is not
/// negative); or any cost below `enough`. `None` if the rows are infeasible.
fn least(mut rows: Vec<Vec<f64>>, costs: &[f64], enough: f64) -> Option<f64> {
    let (count, width) = (rows.len(), costs.len());
    // One artificial variable per row, initially in the basis.
    for (at, row) in rows.iter_mut().enumerate() {
        let sum = row.pop().unwrap_or_default();
        row.extend((0..count).map(|helper| if helper == at { 1.0 } else { 0.0 }));
        row.push(sum);
    }
    let mut basis: Vec<usize> = (width..width + count).collect();
    let helping: Vec<f64> = (0..width + count).map(|at| if at < width { 0.0 } else { 1.0 }).collect();
    if descend(&mut rows, &mut basis, &helping, width + count, f64::NEG_INFINITY) > 1e-9 {
        return None;
    }
    // Artificial variables left in the basis are zero; pivot them out where their row has another coefficient.
    for at in 0..count {
        if basis[at] >= width
            && let Some(column) = (0..width).find(|column| rows[at][*column].abs() > 1e-9)
        {
            pivot(&mut rows, &mut basis, (at, column));
        }
    }
    let all: Vec<f64> = costs.iter().copied().chain((0..count).map(|_| 0.0)).collect();
    Some(descend(&mut rows, &mut basis, &all, width, enough))
}

/// Descends from vertex to vertex; returns the cost at the last one.
fn descend(rows: &mut [Vec<f64>], basis: &mut [usize], costs: &[f64], width: usize, enough: f64) -> f64 {
    let last = rows[0].len() - 1;
    // Bland's rule terminates in exact arithmetic; the limit guards against rounding.
    for _ in 0..MAX_PIVOTS {
        let sum: f64 = rows.iter().zip(basis.iter()).map(|(row, at)| row[last] * costs[*at]).sum();
        if sum < enough {
            return sum;
        }
        let reduced = |column: usize| {
            costs[column] - rows.iter().zip(basis.iter()).map(|(row, at)| row[column] * costs[*at]).sum::<f64>()
        };
        let Some(column) = (0..width).find(|column| reduced(*column) < -NOTHING) else { return sum };
        let mut leaving: Option<(usize, f64)> = None;
        for (at, row) in rows.iter().enumerate().filter(|(_, row)| row[column] > NOTHING) {
            let ratio = row[last] / row[column];
            let is_first =
                leaving.is_none_or(|(other, least)| ratio < least || (ratio == least && basis[at] < basis[other]));
            if is_first {
                leaving = Some((at, ratio));
            }
        }
        let Some((at, _)) = leaving else { return f64::NEG_INFINITY };
        pivot(rows, basis, (at, column));
    }
    rows.iter().zip(basis.iter()).map(|(row, at)| row[last] * costs[*at]).sum()
}

/// More pivots than any program of this size takes.
const MAX_PIVOTS: usize = 1000;

fn pivot(rows: &mut [Vec<f64>], basis: &mut [usize], (at, column): (usize, usize)) {
    let share = rows[at][column];
    rows[at].iter_mut().for_each(|number| *number /= share);
    let base = rows[at].clone();
    for row in rows.iter_mut().enumerate().filter(|(other, _)| *other != at).map(|(_, row)| row) {
        let factor = row[column];
        if factor != 0.0 {
            row.iter_mut().zip(&base).for_each(|(number, of)| *number -= factor * of);
            row[column] = 0.0;
        }
    }
    basis[at] = column;
}
