use crate::plan::dimibot::*;
use crate::plan::search::SearchBudget;

fn symmetric(n: u32) -> Lattice {
    Lattice::new([n, n], [1.0, 1.0]).unwrap()
}

fn numbered(lattice: &Lattice, number: u32) -> LatticeCell {
    LatticeCell::new(number >> lattice.modules[1], number & lattice.last(Side::Right))
}

fn blocks(lattice: &Lattice, numbers: &[u32]) -> Vec<FieldObstacle> {
    let cell = |&k: &u32| numbered(lattice, k).pair();
    numbers.iter().map(cell).map(|c| FieldObstacle::Cells { from: c, to: c }).collect()
}

/// From 6 to 10 with N = 2: cost and the index of the first place visited.
fn six_to_ten(obstacles: &[u32]) -> Option<(u64, u32)> {
    let lattice = symmetric(2);
    let field = LatticeField::new(lattice, &blocks(&lattice, obstacles)).unwrap();
    let ends = [6, 10].map(|k| numbered(&lattice, k));
    match shortest(&field, ends[0], ends[1], &SwitchWeights::distance(&lattice), SearchBudget::DEFAULT) {
        DimibotAnswer::Found(path) => {
            assert_eq!(path.cost, path.bound);
            let first = ends[0].after(path.flips[0]);
            Some((path.cost, first.x << 2 | first.y))
        }
        DimibotAnswer::Impossible(_) => None,
        DimibotAnswer::GaveUp(gave_up) => panic!("{gave_up:?}"),
    }
}

#[test]
fn from_six_to_ten_with_two_modules_a_side() {
    assert_eq!(six_to_ten(&[]).unwrap().0, 3);
    assert_eq!(six_to_ten(&[14]), Some((3, 2)));
    assert_eq!(six_to_ten(&[2]), Some((3, 14)));
    assert_eq!(six_to_ten(&[2, 14]).unwrap().0, 5);
    assert_eq!(six_to_ten(&[2, 7, 9, 14]), None);
}

#[test]
fn four_modules_a_side_across_the_middle_cost_thirty() {
    let lattice = symmetric(4);
    let field = LatticeField::new(lattice, &[]).unwrap();
    let (start, goal) = (LatticeCell::new(8, 8), LatticeCell::new(7, 7));
    let DimibotAnswer::Found(path) =
        shortest(&field, start, goal, &SwitchWeights::distance(&lattice), SearchBudget::DEFAULT)
    else {
        panic!("an empty scene has a path")
    };
    assert_eq!((path.cost, path.flips.len()), (30, 8));
}

fn edges(obstacles: &[u32]) -> Vec<(u32, u32, u64)> {
    let lattice = symmetric(2);
    let field = LatticeField::new(lattice, &blocks(&lattice, obstacles)).unwrap();
    let weights = SwitchWeights::distance(&lattice);
    let mut edges = Vec::new();
    for number in 0..16 {
        let cell = numbered(&lattice, number);
        let Some(masks) = field.legal(cell) else {
            continue;
        };
        for side in Side::BOTH {
            for module in (0..2).filter(|m| masks[side.index()] >> m & 1 == 1) {
                let flip = Flip { side, module };
                let next = cell.after(flip);
                edges.push((number, next.x << 2 | next.y, weights.of(flip)));
            }
        }
    }
    edges
}

#[test]
fn an_obstacle_at_six_deletes_exactly_six_edges() {
    let (all, left) = (edges(&[]), edges(&[6]));
    let mut gone: Vec<(u32, u32)> = all.iter().filter(|e| e.0 < e.1 && !left.contains(e)).map(|e| (e.0, e.1)).collect();
    gone.sort_unstable();
    assert_eq!(gone, [(2, 6), (2, 10), (4, 6), (5, 7), (6, 7), (6, 14)]);
}

/// Table 2 of the paper as printed, one digit per column.
const TABLE_TWO: [&str; 16] = [
    "0120100020000000", "1002010002000000", "2001001000200000", "0210000100020000", "1000012000002000",
    "0100100200000200", "0010200100000020", "0001021000000002", "2000000001201000", "0200000010020100",
    "0020000020010010", "0002000002100001", "0000200010000120", "0000020010010002", "0000002000102001",
    "0000000200010210",
];

/// The printed row 13 has two entries in columns 8 and 11 that belong in columns 9 and 12; otherwise the table would
/// not be symmetric.
#[test]
fn the_adjacency_of_table_two() {
    let mut table = vec![vec![b'0'; 16]; 16];
    for (a, b, weight) in edges(&[]) {
        table[a as usize][b as usize] = b'0' + weight as u8;
    }
    for (number, printed) in TABLE_TWO.iter().enumerate() {
        let row = std::str::from_utf8(&table[number]).unwrap();
        match number {
            13 => assert_eq!((*printed, row), ("0000020010010002", "0000020001001002")),
            _ => assert_eq!(*printed, row, "row {number}"),
        }
    }
}
