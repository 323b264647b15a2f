//! A small linear program: feasibility of conditions on a dozen variables.
//!
//! Input: equalities and inequalities. Output: whether some values satisfy all of them, each inequality up to a slack. Method:
//! equalities are solved for some of the variables (Gauss and Jordan); for the remaining inequalities the greatest margin is the
//! least value of the dual program, which the two-phase simplex method finds with Bland's rule, which guarantees termination.

/// Number of variables: forces and torques of three fingers.
pub const VARIABLES: usize = 12;

/// Number of equalities: sums of forces and moments.
const EQUALITIES: usize = 6;

/// Most inequalities: conditions on three fingers.
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
pub fn are_kept(mut conditions: Conditions, slack: f64) -> bool {
    let Some(solved) = solve(&mut conditions, slack) else { return false };
    let inequalities = &conditions.inequalities[..conditions.count];
    let mut dual = DualTableau { count: 0, rows: [[0.0; COLUMNS]; ROWS], basis: [0; ROWS] };
    for variable in (0..VARIABLES).filter(|variable| !solved[*variable]) {
        dual.push(inequalities.iter().map(|row| row[variable]), 0.0);
    }
    dual.push(inequalities.iter().map(|_| 1.0), 1.0);
    match dual.least(inequalities.iter().map(|row| row[VARIABLES]), -slack) {
        Some(margin) => margin >= -slack,
        // The dual is infeasible: the margin is unbounded.
        None => true,
    }
}

/// Solves the equalities for as many variables as they determine, and substitutes these into the inequalities. Returns
/// which variables were solved; `None` if the equalities contradict one another.
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
        for row in rest.chain(&mut conditions.inequalities[..conditions.count]) {
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

/// Columns of the dual program: one for each inequality, then the right-hand side.
const COLUMNS: usize = INEQUALITIES + 1;

/// Most rows of the dual program: one for each free variable, and the sum of the weights, which must be 1.
const ROWS: usize = VARIABLES + 1;

/// Limit on pivots: more than any program of this size takes.
const MAX_PIVOTS: usize = 1000;

/// Basis entry for the artificial variable of a row, which never returns once it has left the basis.
const ARTIFICIAL: usize = INEQUALITIES;

/// Rows over non-negative weights, and the weight that each row is solved for.
struct DualTableau {
    count: usize,
    rows: [[f64; COLUMNS]; ROWS],
    basis: [usize; ROWS],
}

impl DualTableau {
    /// Adds a row, which is solved for its artificial variable; the right-hand side is not negative.
    fn push(&mut self, shares: impl Iterator<Item = f64>, sum: f64) {
        let row = &mut self.rows[self.count];
        row.iter_mut().zip(shares).for_each(|(share, given)| *share = given);
        row[COLUMNS - 1] = sum;
        self.basis[self.count] = ARTIFICIAL;
        self.count += 1;
    }

    /// The least cost of weights that satisfy the rows; or any cost below `enough`. `None` if the rows are infeasible.
    fn least(mut self, costs: impl Iterator<Item = f64>, enough: f64) -> Option<f64> {
        // First the sum of the artificial variables is minimised.
        let mut sum = [0.0; COLUMNS];
        sum[ARTIFICIAL] = 1.0;
        if self.descend(&sum, f64::NEG_INFINITY) > 1e-9 {
            return None;
        }
        // Artificial variables left in the basis are zero; pivot them out where their row has another coefficient.
        for at in 0..self.count {
            let pivot = (0..INEQUALITIES).find(|column| self.rows[at][*column].abs() > 1e-9);
            if let (ARTIFICIAL, Some(column)) = (self.basis[at], pivot) {
                self.pivot(at, column);
            }
        }
        let mut all = [0.0; COLUMNS];
        all.iter_mut().zip(costs).for_each(|(share, cost)| *share = cost);
        Some(self.descend(&all, enough))
    }

    /// Descends from vertex to vertex, and returns the cost at the last one; it stops early at a cost below `enough`.
    /// The last of the costs is that of artificial variables.
    fn descend(&mut self, costs: &[f64; COLUMNS], enough: f64) -> f64 {
        // Bland's rule terminates in exact arithmetic; the limit guards against rounding.
        for _ in 0..MAX_PIVOTS {
            let cost = self.sum(COLUMNS - 1, costs);
            if cost < enough {
                return cost;
            }
            // Computed afresh at each vertex: carried along, reduced costs would add up the rounding of all pivots.
            let falls = |column: &usize| costs[*column] - self.sum(*column, costs) < -NOTHING;
            let Some(column) = (0..INEQUALITIES).find(falls) else { return cost };
            let mut leaving: Option<(usize, f64)> = None;
            for (at, row) in self.rows[..self.count].iter().enumerate().filter(|(_, row)| row[column] > NOTHING) {
                let ratio = row[COLUMNS - 1] / row[column];
                // Artificial variables leave last among equals: their order is that of their rows.
                let comes_before = |other: usize| (self.basis[at], at) < (self.basis[other], other);
                if leaving.is_none_or(|(other, least)| ratio < least || (ratio == least && comes_before(other))) {
                    leaving = Some((at, ratio));
                }
            }
            let Some((at, _)) = leaving else { return f64::NEG_INFINITY };
            self.pivot(at, column);
        }
        self.sum(COLUMNS - 1, costs)
    }

    /// The sum of a column over all rows, each times the cost of the weight that it is solved for.
    fn sum(&self, column: usize, costs: &[f64; COLUMNS]) -> f64 {
        self.rows[..self.count].iter().zip(&self.basis).map(|(row, basic)| row[column] * costs[*basic]).sum()
    }

    /// Solves a row for the weight of a column.
    fn pivot(&mut self, at: usize, column: usize) {
        let share = self.rows[at][column];
        self.rows[at].iter_mut().for_each(|number| *number /= share);
        let base = self.rows[at];
        for row in self.rows[..self.count].iter_mut().enumerate().filter(|(other, _)| *other != at).map(|(_, row)| row)
        {
            eliminate(row, &base, column);
        }
        self.basis[at] = column;
    }
}

/// Eliminates a weight from a row, by the row that is solved for it.
fn eliminate(row: &mut [f64; COLUMNS], by: &[f64; COLUMNS], column: usize) {
    let factor = row[column];
    if factor != 0.0 {
        row.iter_mut().zip(by).for_each(|(number, of)| *number -= factor * of);
        row[column] = 0.0;
    }
}
