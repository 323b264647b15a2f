//! Table 3 of the paper: which two moves are compatible, by the distance of the parts before the step.
//!
//! The table is written for a part `i` of higher priority that lies right of and above a part `j`, both distances at most 6. Other
//! quadrants follow by mirroring both motions; beyond 6 on an axis every pair is safe. Several printed entries are unsafe and
//! others stricter than the rule; they are kept as printed.

use crate::plan::electrode_array::board::{BoardGrid, CellIndex};

/// Motion of a part in a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PartMotion {
    Right,
    Left,
    Down,
    Up,
    Stay,
}

/// How the table, printed for two distances above zero, is applied when one of them is zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Zero {
    /// As if `i` lay on the printed side.
    Printed,
    /// Allowed if the table allows it on one of the two sides.
    EitherSide,
    /// Allowed only if the table allows it on both sides.
    BothSides,
}

/// Beyond this distance on one axis the table has no entry: the parts do not influence one another.
const REACH: i64 = 6;

impl PartMotion {
    fn of(board: &BoardGrid, [from, to]: [CellIndex; 2]) -> PartMotion {
        let ((c, r), (d, s)) = (board.place(from), board.place(to));
        match ((i64::from(d) - i64::from(c)).signum(), (i64::from(s) - i64::from(r)).signum()) {
            (1, _) => PartMotion::Right,
            (-1, _) => PartMotion::Left,
            (_, -1) => PartMotion::Down,
            (_, 1) => PartMotion::Up,
            (_, _) => PartMotion::Stay,
        }
    }

    fn mirrored(self, columns: MotionSide, rows: MotionSide) -> PartMotion {
        match (self, columns, rows) {
            (PartMotion::Right, MotionSide::Mirrored, _) => PartMotion::Left,
            (PartMotion::Left, MotionSide::Mirrored, _) => PartMotion::Right,
            (PartMotion::Down, _, MotionSide::Mirrored) => PartMotion::Up,
            (PartMotion::Up, _, MotionSide::Mirrored) => PartMotion::Down,
            (motion, _, _) => motion,
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum MotionSide {
    AsIs,
    Mirrored,
}

/// Whether `j` may make its move while `i` makes its own; each is a start and an end.
pub(super) fn allows(board: &BoardGrid, i: [CellIndex; 2], j: [CellIndex; 2], zero: Zero) -> bool {
    let ((ci, ri), (cj, rj)) = (board.place(i[0]), board.place(j[0]));
    let (dc, dl) = (i64::from(ci) - i64::from(cj), i64::from(ri) - i64::from(rj));
    if dc.abs() > REACH || dl.abs() > REACH {
        return true;
    }
    let (motion_i, motion_j) = (PartMotion::of(board, i), PartMotion::of(board, j));
    let mut verdicts = sides(dc, zero).iter().flat_map(|columns| {
        sides(dl, zero).iter().map(|rows| {
            let turned = |motion: PartMotion| motion.mirrored(*columns, *rows);
            printed(turned(motion_i), turned(motion_j), dc.abs(), dl.abs())
        })
    });
    match zero {
        Zero::Printed | Zero::BothSides => verdicts.all(|allowed| allowed),
        Zero::EitherSide => verdicts.any(|allowed| allowed),
    }
}

fn sides(difference: i64, zero: Zero) -> &'static [MotionSide] {
    match (difference.signum(), zero) {
        (-1, _) => &[MotionSide::Mirrored],
        (0, Zero::EitherSide | Zero::BothSides) => &[MotionSide::AsIs, MotionSide::Mirrored],
        (_, _) => &[MotionSide::AsIs],
    }
}

/// The printed entry for motions of `i` and `j` at distances `dc` and `dl`.
fn printed(i: PartMotion, j: PartMotion, dc: i64, dl: i64) -> bool {
    use PartMotion::{Down, Left, Right, Stay, Up};
    match (i, j) {
        (Right, Right) | (Left, Left) | (Left, Stay) | (Stay, Right) => dc >= 5,
        (Right, Left) | (Left, Right) => dc >= 6,
        (Right, Stay) | (Stay, Left) => dc >= 4,
        (Down, Down) | (Up, Up) | (Down, Stay) | (Stay, Up) => dl >= 5,
        (Down, Up) | (Up, Down) => dl >= 6,
        (Up, Stay) | (Stay, Down) => dl >= 4,
        (Right, Down) | (Left, Up) | (Down, Left) | (Up, Right) => dc >= 6 || dl >= 6,
        (Right, Up) | (Left, Down) | (Down, Right) | (Up, Left) => dc >= 4 || dl >= 4,
        (Stay, Stay) => dc >= 5 || dl >= 5,
    }
}
