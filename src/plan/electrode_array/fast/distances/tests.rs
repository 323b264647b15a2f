//! Tables against Manhattan's distance and against walls.

use super::*;
use crate::plan::search::SearchBudget;

fn meter() -> Meter {
    Meter::new(SearchBudget::of(u64::MAX))
}

#[test]
fn an_open_board_needs_no_table_and_agrees_with_one() {
    let mut board = BoardGrid::new(7, 6);
    for column in 0..7 {
        board.block(board.cell(column, 0));
    }
    let stop = board.cell(2, 3);
    let field = Distances::of(&board).to(&board, stop, &mut meter());
    assert!(matches!(field, DistanceField::Manhattan { .. }));
    let table = DistanceField::Table(flood(&board, stop).into());
    for cell in (0..board.cells() as CellIndex).filter(|cell| !board.is_blocked(*cell)) {
        assert_eq!(field.from(cell), table.from(cell));
    }
}

#[test]
fn a_wall_is_walked_round_and_a_closed_room_not_entered() {
    let mut board = BoardGrid::new(5, 5);
    for row in 1..5 {
        board.block(board.cell(2, row));
    }
    let mut distances = Distances::of(&board);
    assert_eq!(distances.to(&board, board.cell(3, 4), &mut meter()).from(board.cell(1, 4)), 10);
    board.block(board.cell(2, 0));
    let mut distances = Distances::of(&board);
    assert_eq!(distances.to(&board, board.cell(3, 4), &mut meter()).from(board.cell(1, 4)), UNREACHABLE);
}

#[test]
fn tables_are_charged_once() {
    let mut board = BoardGrid::new(64, 64);
    board.block(70);
    let mut distances = Distances::of(&board);
    let mut meter = meter();
    distances.to(&board, 0, &mut meter);
    distances.to(&board, 0, &mut meter);
    assert_eq!(meter.spent(), 64 * 64 / CELLS_PER_STEP);
}
