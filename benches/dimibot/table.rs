//! Timing and printing.

use crate::scenes::Scene;
use crate::{cost, rivals};
use std::hint::black_box;
use std::time::Instant;
use tweeze::plan::dimibot::{LatticeCell, shortest};
use tweeze::plan::search::SearchBudget;

pub fn sparse_header() {
    println!(" N   tweeze  pathfinding A*  ratio   petgraph A*  ratio  (build ms)");
}

/// Median over scenes of the time per query; each fast query is repeated to be measurable.
pub fn sparse_row(modules: u32, scenes: &[Scene]) {
    let (mut mine, mut path, mut graph, mut build) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for scene in scenes {
        let (start, goal) = scene.queries(1, 5)[0];
        let rivals = rivals(scene);
        let search = || shortest(&scene.field, start, goal, &scene.weights, SearchBudget::DEFAULT);
        let truth = cost(&search());
        mine.push(time_us(200, || cost(&search())));
        assert_eq!(rivals.pathfinding_astar(start, goal), truth);
        path.push(time_us(20, || rivals.pathfinding_astar(start, goal)));
        // Explicit graphs of 2^20 cells are built for a few scenes only.
        if modules <= 8 || modules == 10 && build.len() < 5 {
            let begun = Instant::now();
            let explicit = rivals.graph();
            build.push(begun.elapsed().as_secs_f64() * 1e3);
            assert_eq!(rivals.petgraph_astar(&explicit, start, goal), truth);
            graph.push(time_us(5, || rivals.petgraph_astar(&explicit, start, goal)));
        }
    }
    let (mine, path) = (median(&mut mine), median(&mut path));
    print!("{modules:2} {mine:8.3} {path:15.2} {:6.0}", path / mine);
    match graph.is_empty() {
        true => println!("            -"),
        false => {
            let graph = median(&mut graph);
            println!(" {graph:13.1} {:6.0}  {:.1}", graph / mine, median(&mut build));
        }
    }
}

pub fn dense_header() {
    println!(" N  c  no path | tweeze median      p90      max | pathfinding A* median      p90 | ratio of medians");
}

pub fn dense_row(modules: u32, crowd: u32) {
    let (mut mine, mut theirs, mut shut) = (Vec::new(), Vec::new(), 0);
    let per_scene = if modules == 10 { 20 } else { 2 };
    // The rival would visit up to 2^26 cells, with more memory than many machines have.
    let rival_can = modules < 13 || crowd <= 16;
    for seed in 0..5 {
        let scene = Scene::dense(modules, crowd, seed);
        let rivals = rivals(&scene);
        let queries: Vec<(LatticeCell, LatticeCell)> = scene.queries(per_scene, 9);
        // The first query computes the lines of the scene; it is repeated among the measured ones.
        shortest(&scene.field, queries[0].0, queries[0].1, &scene.weights, SearchBudget::DEFAULT);
        for (start, goal) in queries {
            let begun = Instant::now();
            let found = shortest(&scene.field, start, goal, &scene.weights, SearchBudget::DEFAULT);
            mine.push(begun.elapsed().as_secs_f64() * 1e6);
            let truth = cost(&found);
            shut += usize::from(truth.is_none());
            if rival_can {
                let begun = Instant::now();
                assert_eq!(rivals.pathfinding_astar(start, goal), truth);
                theirs.push(begun.elapsed().as_secs_f64() * 1e6);
            }
        }
    }
    let count = mine.len();
    let m = median(&mut mine);
    let tenth = count * 9 / 10;
    print!("{modules:2} {crowd:2} {shut:4}/{count:3} | {m:13.1} {:8.0} {:8.0} | ", mine[tenth], mine[count - 1]);
    match rival_can {
        true => {
            let t = median(&mut theirs);
            println!("{t:21.0} {:8.0} | {:.0}", theirs[tenth], t / m);
        }
        false => println!("{:>21} {:>8} | -", "-", "-"),
    }
}

fn time_us<T>(repeats: u32, mut work: impl FnMut() -> T) -> f64 {
    let begun = Instant::now();
    for _ in 0..repeats {
        black_box(work());
    }
    begun.elapsed().as_secs_f64() * 1e6 / f64::from(repeats)
}

/// The median; sorts the values.
pub fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Count, median, 90th percentile and largest value.
pub fn spread(values: &mut [f64]) -> String {
    if values.is_empty() {
        return "none".into();
    }
    let (count, median) = (values.len(), median(values));
    format!("{count} proofs, median {median:.1}, p90 {:.1}, max {:.1}", values[count * 9 / 10], values[count - 1])
}
