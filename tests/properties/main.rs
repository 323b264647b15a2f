//! Properties of all programs, tested on random ones: the compiler against brute force, against itself, and against
//! garbage.
//!
//! The scenes come from fixed seeds. The oracle is based on the language and the paper; it shares no code with the
//! compiler.

// The expected figures come from the platform's own mathematics.
#![allow(clippy::disallowed_methods)]

mod format;
mod garbage;
mod geometry;
mod oracle;
mod scene;
#[path = "../support/mod.rs"]
mod support;

use oracle::Graph;
use scene::{Random, Scene};
use support::{Built, build};
use tweeze::schedule::PlanRecord;

const PLANNERS: [&str; 5] = ["staged_astar", "dijkstra", "bidirectional_dijkstra", "astar", "hypercube_astar"];

const OBJECTIVES: [&str; 4] = ["distance", "switches", "time", "energy"];

/// Duration of the `wait` in every task.
const WAIT_MS: f64 = 3.0;

/// The least cost of a task by brute force, in the unit of the objective; `None` if there is no path.
fn truth(graph: &Graph, scene: &Scene, objective: &str) -> Option<f64> {
    let pitch_um = scene.pitch_um();
    let switch = move |_: usize, _: u32| 1.0;
    let pulse_ms = f64::from(scene.pulse_ms);
    match objective {
        "distance" => graph.task(scene, &move |side, module| f64::from(1 << module) * pitch_um[side]),
        "switches" => graph.task(scene, &switch),
        "time" => graph.task(scene, &switch).map(|n| n * (pulse_ms + f64::from(scene.rest_ms)) + WAIT_MS),
        // 20 V × 100 mA.
        "energy" => graph.task(scene, &switch).map(|n| n * 2.0 * pulse_ms),
        other => panic!("{other}"),
    }
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * a.abs().max(b.abs())
}

/// A scene, and a graph in which no move is so close to a rim that rounding could decide whether it is free.
fn clear_cut_scene(random: &mut Random, most_modules: u32) -> (Scene, Graph) {
    loop {
        let mut scene = Scene::random(random, most_modules);
        if let Some(graph) = Graph::new(&scene) {
            scene.leave_obstacles(random, |cell| graph.is_free_cell(cell));
            return (scene, graph);
        }
    }
}

/// Counts of outcomes, so that a test can check that all sorts occurred.
#[derive(Debug, Default)]
struct Seen {
    covered: usize,
    shut: usize,
    detours: usize,
    straight: usize,
}

impl Seen {
    /// Compares the plans of a program, which has a task for each objective, with brute force.
    fn judge(&mut self, scene: &Scene, graph: &Graph, built: &Built, text: &str) {
        let errors: Vec<&str> = built.codes.iter().copied().filter(|code| code.starts_with('E')).collect();
        let stops = scene.stops.iter().chain(&scene.visits);
        let covers = |cell: &[u32; 2]| !graph.is_free_cell(*cell);
        if covers(&scene.start) || stops.clone().any(covers) {
            let expected = |code: &&str| matches!(*code, "E0502" | "E0505");
            assert!(!errors.is_empty() && errors.iter().all(expected), "{errors:?}\n{text}");
            self.covered += 1;
            return;
        }
        let Some(distance) = truth(graph, scene, "distance") else {
            // At least one error for each of the four tasks.
            assert!(errors.len() >= 4 && errors.iter().all(|code| *code == "E0601"), "{errors:?}\n{text}");
            self.shut += 1;
            return;
        };
        assert!(errors.is_empty() && !built.refused, "{errors:?}\n{text}");
        for (verified, objective) in built.schedules.iter().zip(OBJECTIVES) {
            let plan = &verified.schedule().plans[0];
            let truth = truth(graph, scene, objective).expect("the same ways for every objective");
            self.judge_plan(plan, truth, text);
        }
        let free_way = |a: &[u32; 2], b: &[u32; 2]| -> f64 {
            (0..2).map(|axis| f64::from(a[axis] ^ b[axis]) * scene.pitch_um()[axis]).sum()
        };
        let way = std::iter::once(&scene.start).chain(&scene.stops).collect::<Vec<_>>();
        let straight: f64 = way.windows(2).map(|pair| free_way(pair[0], pair[1])).sum();
        if scene.visits.is_empty() && close(straight, distance) { self.straight += 1 } else { self.detours += 1 }
    }

    fn judge_plan(&self, plan: &PlanRecord, truth: f64, text: &str) {
        assert!(close(plan.cost, truth), "{} {} costs {truth}, not {}\n{text}", plan.task, plan.objective, plan.cost);
        assert!(plan.optimal && close(plan.bound, truth), "{} is not proven: {}\n{text}", plan.task, plan.bound);
    }
}

#[test]
fn costs_agree_with_brute_force_in_a_thousand_scenes() {
    let mut random = Random::new(20160210);
    let mut seen = Seen::default();
    for round in 0..1000 {
        let (scene, graph) = clear_cut_scene(&mut random, if round % 4 == 0 { 5 } else { 4 });
        let settings = OBJECTIVES.map(|objective| {
            let planner = PLANNERS[random.below(5) as usize];
            format!("minimize {objective}\n  using {planner}")
        });
        let text = scene.text(&settings);
        seen.judge(&scene, &graph, &build(&text), &text);
    }
    assert!(seen.covered > 50 && seen.shut > 80 && seen.detours > 80 && seen.straight > 200, "{seen:?}");
}

#[test]
fn the_order_of_a_visit_is_the_best() {
    let mut random = Random::new(2);
    let mut seen = Seen::default();
    for _ in 0..150 {
        let (mut scene, graph) = clear_cut_scene(&mut random, 4);
        scene.visits = (0..2 + random.below(4)).map(|_| scene.some_cell(&mut random)).collect();
        let settings = OBJECTIVES.map(|objective| format!("minimize {objective}"));
        let text = scene.text(&settings);
        seen.judge(&scene, &graph, &build(&text), &text);
    }
    assert!(seen.shut > 3 && seen.detours > 40, "{seen:?}");
}

#[test]
fn modules_switched_together_take_the_fewest_pulses() {
    let mut random = Random::new(3);
    let (mut together, mut alone, mut shut) = (0, 0, 0);
    while together + alone + shut < 300 {
        let (scene, graph) = clear_cut_scene(&mut random, 3);
        let Some(pulses) = oracle::pulses(&scene) else { continue };
        if !graph.is_free_cell(scene.start) || scene.stops.iter().any(|stop| !graph.is_free_cell(*stop)) {
            continue;
        }
        let text = scene.text(&["minimize time\n  simultaneous: safe".to_owned()]);
        let built = build(&text);
        let Some(pulses) = pulses else {
            assert!(built.codes.contains(&"E0601"), "{:?}\n{text}", built.codes);
            shut += 1;
            continue;
        };
        let cost_ms = pulses as f64 * f64::from(scene.pulse_ms + scene.rest_ms) + WAIT_MS;
        let plan = &built.schedules.first().unwrap_or_else(|| panic!("{:?}\n{text}", built.codes)).schedule().plans[0];
        Seen::default().judge_plan(plan, cost_ms, &text);
        let one_by_one = truth(&graph, &scene, "time").expect("a way together is a way one by one");
        if cost_ms < one_by_one { together += 1 } else { alone += 1 }
    }
    assert!(together > 60 && alone > 60 && shut > 5, "{together} {alone} {shut}");
}

#[test]
fn the_same_program_gives_the_same_bytes() {
    let mut random = Random::new(4);
    let mut compared = 0;
    while compared < 25 {
        let (scene, _) = clear_cut_scene(&mut random, 4);
        let text = scene.text(&OBJECTIVES.map(|objective| format!("minimize {objective}\n  simultaneous: safe")));
        let (one, other) = (build(&text), build(&text));
        assert_eq!(one.codes, other.codes);
        assert!(one.files() == other.files(), "{text}");
        compared += usize::from(!one.schedules.is_empty());
    }
}
