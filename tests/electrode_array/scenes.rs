//! Instances: random ones from seeds, the droplet routing benchmarks, and the five parts of the paper's Table 6.

#[path = "../support/random.rs"]
pub mod random;

pub use random::Random;
use serde_json::Value;
use tweeze::plan::electrode_array::board::{Agent, BoardGrid, CellIndex, Instance};

/// Number of random cells tried before a scene counts as full.
const TRIES: usize = 20_000;

/// Parameters of random instances.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// Columns and rows, including the rim.
    pub size: (u32, u32),
    /// Cells at each edge that no centre may reach.
    pub rim: u32,
    pub separation: u32,
    pub agents: usize,
    /// Number of blocked rectangles, each at most a fifth of the board wide and high.
    pub obstacles: u32,
}

impl Shape {
    /// A random instance; `None` if the parts do not fit.
    pub fn instance(self, chance: &mut Random) -> Option<Instance> {
        let mut board = rimmed(self.size.0, self.size.1, self.rim);
        for _ in 0..self.obstacles {
            let corner = (chance.below(self.size.0), chance.below(self.size.1));
            let (wide, high) = (chance.below(self.size.0 / 5 + 1), chance.below(self.size.1 / 5 + 1));
            block(&mut board, corner, (corner.0 + wide, corner.1 + high));
        }
        let starts = self.scatter(&board, chance)?;
        let goals = self.scatter(&board, chance)?;
        let agents = starts.into_iter().zip(goals).map(|(start, goal)| Agent { start, stops: vec![goal] }).collect();
        Some(Instance { board, separation: self.separation, agents, merges: vec![] })
    }

    /// Random free cells that keep the separation; `None` if they do not fit.
    pub fn scatter(self, board: &BoardGrid, chance: &mut Random) -> Option<Vec<CellIndex>> {
        let mut free = board.clone();
        let mut cells = Vec::with_capacity(self.agents);
        for _ in 0..self.agents {
            let tries = (0..TRIES).map(|_| (chance.below(self.size.0), chance.below(self.size.1)));
            let (column, row) = tries.into_iter().find(|(column, row)| !free.is_blocked(free.cell(*column, *row)))?;
            free.block_around(i64::from(column), i64::from(row), self.separation);
            cells.push(board.cell(column, row));
        }
        Some(cells)
    }
}

/// A board whose outer cells are blocked.
pub fn rimmed(width: u32, height: u32, rim: u32) -> BoardGrid {
    let mut board = BoardGrid::new(width, height);
    if rim > 0 {
        block(&mut board, (0, 0), (width, rim - 1));
        block(&mut board, (0, height - rim), (width, height));
        block(&mut board, (0, 0), (rim - 1, height));
        block(&mut board, (width - rim, 0), (width, height));
    }
    board
}

/// Blocks the cells of a rectangle that are on the board, both corners included.
pub fn block(board: &mut BoardGrid, low: (u32, u32), high: (u32, u32)) {
    for row in low.1..=high.1.min(board.height() - 1) {
        for column in low.0..=high.0.min(board.width() - 1) {
            board.block(board.cell(column, row));
        }
    }
}

/// The benchmarks in `tests/data/droplet_routing.json`, by name. A start or goal on a blockage is freed, as the file
/// says.
pub fn droplets() -> Vec<(String, Instance)> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/droplet_routing.json");
    let text = std::fs::read_to_string(path).expect("the data lie beside the tests");
    let set: Value = serde_json::from_str(&text).expect("the data are JSON");
    let cases = set["cases"].as_object().expect("an object of cases");
    cases.iter().map(|(name, case)| (name.clone(), droplet_case(case))).collect()
}

fn droplet_case(case: &Value) -> Instance {
    let number = |value: &Value| value.as_u64().expect("a cell is two numbers") as u32;
    let place = |cell: &Value| (number(&cell[0]) - 1, number(&cell[1]) - 1);
    let list = |value: &Value| value.as_array().expect("a list").clone();
    let (width, height) = place(&case["grid"][0][1]);
    let mut board = BoardGrid::new(width + 1, height + 1);
    for blockage in list(&case["blockages"]) {
        block(&mut board, place(&blockage[0]), place(&blockage[1]));
    }
    let ends: Vec<[(u32, u32); 2]> =
        list(&case["nets"]).iter().map(|net| [place(&net["from"][0]), place(&net["to"])]).collect();
    let agents: Vec<Agent> = ends
        .iter()
        .map(|[start, goal]| Agent { start: board.cell(start.0, start.1), stops: vec![board.cell(goal.0, goal.1)] })
        .collect();
    let board = freed(board, agents.iter().flat_map(|agent| [agent.start, agent.stops[0]]).collect());
    Instance { board, separation: 2, agents, merges: vec![] }
}

/// The same board with these cells free.
fn freed(board: BoardGrid, cells: Vec<CellIndex>) -> BoardGrid {
    let mut freed = BoardGrid::new(board.width(), board.height());
    let blocked = (0..board.cells() as CellIndex).filter(|cell| board.is_blocked(*cell) && !cells.contains(cell));
    blocked.for_each(|cell| freed.block(cell));
    freed
}

/// Table 6 of Kritikou et al. 2018: five parts on 50 × 50 electrodes, with the outer ring out of reach; its cells count
/// from 1.
pub fn table_6() -> Instance {
    let board = rimmed(50, 50, 1);
    let parts = [((5, 3), (26, 31)), ((26, 31), (5, 3)), ((46, 4), (4, 48)), ((14, 45), (46, 4)), ((3, 20), (48, 30))];
    let at = |(column, row): (u32, u32)| board.cell(column - 1, row - 1);
    let agents = parts.iter().map(|(start, goal)| Agent { start: at(*start), stops: vec![at(*goal)] }).collect();
    Instance { board, separation: 4, agents, merges: vec![] }
}
