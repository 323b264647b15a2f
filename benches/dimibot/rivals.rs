//! The same problem for `pathfinding` (implicit graph) and `petgraph` (explicit graph), with the same admissible
//! heuristic (XOR distance).
//!
//! Both get a fast test for free moves: binary search in sorted obstacle coordinates by row and by column.

use crate::scenes::Scene;
use petgraph::graph::{NodeIndex, UnGraph};
use tweeze::plan::dimibot::LatticeCell;

pub struct Rivals<'a> {
    scene: &'a Scene,
    rows: Vec<Vec<u32>>,
    columns: Vec<Vec<u32>>,
    by_hash: Option<[std::collections::HashMap<u32, Vec<u32>>; 2]>,
}

impl<'a> Rivals<'a> {
    pub fn new(scene: &'a Scene) -> Self {
        if scene.modules > 13 {
            let mut maps = [std::collections::HashMap::new(), std::collections::HashMap::new()];
            for &[x, y] in &scene.cells {
                maps[0].entry(y).or_insert_with(Vec::new).push(x);
                maps[1].entry(x).or_insert_with(Vec::new).push(y);
            }
            for map in &mut maps {
                map.values_mut().for_each(|v: &mut Vec<u32>| v.sort_unstable());
            }
            return Rivals { scene, rows: Vec::new(), columns: Vec::new(), by_hash: Some(maps) };
        }
        let mut rows = vec![Vec::new(); 1 << scene.modules];
        let mut columns = rows.clone();
        for &[x, y] in &scene.cells {
            rows[y as usize].push(x);
            columns[x as usize].push(y);
        }
        rows.iter_mut().chain(&mut columns).for_each(|v| v.sort_unstable());
        Rivals { scene, rows, columns, by_hash: None }
    }

    fn line(&self, k: usize, at: u32) -> &[u32] {
        match (&self.by_hash, k) {
            (Some(maps), _) => maps[k].get(&at).map_or(&[], |v| v.as_slice()),
            (None, 0) => &self.rows[at as usize],
            (None, _) => &self.columns[at as usize],
        }
    }

    fn free(line: &[u32], a: u32, b: u32) -> bool {
        let next = line.partition_point(|&o| o < a.min(b));
        line.get(next).is_none_or(|&o| o > a.max(b))
    }

    fn moves(&self, cell: LatticeCell) -> impl Iterator<Item = (LatticeCell, u64)> + '_ {
        let LatticeCell { x, y } = cell;
        (0..self.scene.modules).flat_map(move |i| {
            let bit = 1 << i;
            let along =
                Rivals::free(self.line(0, y), x, x ^ bit).then_some((LatticeCell::new(x ^ bit, y), u64::from(bit)));
            let across =
                Rivals::free(self.line(1, x), y, y ^ bit).then_some((LatticeCell::new(x, y ^ bit), u64::from(bit)));
            along.into_iter().chain(across)
        })
    }

    pub fn pathfinding_astar(&self, start: LatticeCell, goal: LatticeCell) -> Option<u64> {
        let estimate = |c: &LatticeCell| u64::from(c.x ^ goal.x) + u64::from(c.y ^ goal.y);
        let moves = |c: &LatticeCell| self.moves(*c).collect::<Vec<_>>();
        pathfinding::prelude::astar(&start, moves, estimate, |c| *c == goal).map(|(_, cost)| cost)
    }

    pub fn graph(&self) -> UnGraph<(), u32, u32> {
        let n = self.scene.modules;
        let mut graph = UnGraph::with_capacity(1 << (2 * n), (n as usize) << (2 * n));
        (0..1_u32 << (2 * n)).for_each(|_| {
            graph.add_node(());
        });
        for index in 0..1_u32 << (2 * n) {
            let cell = LatticeCell::new(index >> n, index & ((1 << n) - 1));
            for (next, cost) in self.moves(cell) {
                let other = next.x << n | next.y;
                if other > index {
                    graph.add_edge(NodeIndex::new(index as usize), NodeIndex::new(other as usize), cost as u32);
                }
            }
        }
        graph
    }

    pub fn petgraph_astar(&self, graph: &UnGraph<(), u32, u32>, start: LatticeCell, goal: LatticeCell) -> Option<u64> {
        let n = self.scene.modules;
        let node = |c: LatticeCell| NodeIndex::new((c.x << n | c.y) as usize);
        let end = node(goal).index() as u32;
        let low = (1 << n) - 1;
        let estimate = |v: NodeIndex<u32>| {
            let apart = v.index() as u32 ^ end;
            (apart >> n) + (apart & low)
        };
        petgraph::algo::astar(graph, node(start), |v| v.index() as u32 == end, |e| *e.weight(), estimate)
            .map(|(cost, _)| u64::from(cost))
    }
}
