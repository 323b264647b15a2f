//! Shortest paths of the DiMiBot against the crates `pathfinding` and `petgraph`, on the same scenes and queries in
//! one run; costs are compared.
//!
//! `cargo bench --bench dimibot` prints medians in microseconds and ratios of medians. Scenes and queries come from fixed seeds.

mod rivals;
mod scenes;
mod table;

use rivals::Rivals;
use scenes::Scene;
use std::time::Instant;
use tweeze::plan::dimibot::{DimibotAnswer, FlipPath, shortest};
use tweeze::plan::search::SearchBudget;

fn main() {
    let filter = std::env::args().skip(1).find(|a| !a.starts_with('-')).unwrap_or_default();
    let wanted = |name: &str| name.contains(&filter);
    if wanted("sparse") {
        sparse();
    }
    if wanted("dense") {
        dense();
    }
    if wanted("shut") {
        shut();
    }
}

fn sparse() {
    println!("\nsparse: 0 to 5 lattice obstacles, 300 scenes with one query each; median µs per query");
    table::sparse_header();
    for modules in [5, 8, 10, 13, 20] {
        let scenes: Vec<Scene> = (0..300).map(|k| Scene::sparse(modules, k)).collect();
        table::sparse_row(modules, &scenes);
    }
}

fn dense() {
    println!("\ndense: c·2^N obstacle cells; 5 scenes with queries each; µs per query");
    table::dense_header();
    for modules in [10, 13] {
        for crowd in [4, 8, 16, 32] {
            table::dense_row(modules, crowd);
        }
    }
}

fn shut() {
    println!("\nno path: queries of dense scenes that have none; µs per proof, and set-up of a scene");
    for (modules, crowd) in [(10, 16), (10, 32), (13, 32)] {
        let (mut proofs, mut set_ups) = (Vec::new(), Vec::new());
        for seed in 0..5 {
            let scene = Scene::dense(modules, crowd, seed);
            set_ups.push(set_up_us(&scene));
            scene.field.prepare();
            for (start, goal) in scene.queries(100, 77) {
                let begun = Instant::now();
                let outcome = shortest(&scene.field, start, goal, &scene.weights, SearchBudget::DEFAULT);
                let time = begun.elapsed().as_secs_f64() * 1e6;
                if matches!(outcome, DimibotAnswer::Impossible(_)) {
                    proofs.push(time);
                }
            }
        }
        let (proofs, set_up) = (table::spread(&mut proofs), table::median(&mut set_ups));
        println!("N {modules:2} c {crowd:2}: {proofs}; set-up {set_up:.0}");
    }
}

/// Time to construct a field from its obstacles, with all lines and blocks, in microseconds.
fn set_up_us(scene: &Scene) -> f64 {
    let begun = Instant::now();
    scene.again().field.prepare();
    begun.elapsed().as_secs_f64() * 1e6
}

/// Cost of the path; `None` if there is no path.
pub fn cost(outcome: &DimibotAnswer<FlipPath>) -> Option<u64> {
    match outcome {
        DimibotAnswer::Found(path) => {
            assert_eq!(path.cost, path.bound, "a benchmark must be solved to the optimum");
            Some(path.cost)
        }
        DimibotAnswer::Impossible(_) => None,
        DimibotAnswer::GaveUp(report) => panic!("a benchmark must fit its budget: {report:?}"),
    }
}

/// The rivals of a scene.
pub fn rivals(scene: &Scene) -> Rivals<'_> {
    Rivals::new(scene)
}
