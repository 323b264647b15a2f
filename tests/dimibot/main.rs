//! Plans of DiMiBots compared with brute force: feasibility, cost, bound, `optimal`, ties and limits of small random
//! tasks, and programs that once got a wrong answer.
//!
//! `TWEEZE_ORACLE_CASES` sets the number of random scenes.

// The oracles and the expected figures use the platform's own mathematics.
#![allow(clippy::disallowed_methods)]

mod brute;
mod found;
mod frames;
mod golden;
mod programs;
mod scene;
#[path = "../support/mod.rs"]
mod support;

use brute::Figures;
use scene::{KEYS, Limit, OUTCOMES, Random, Scene, cases};
use support::compiled;
use tweeze::check::imports::NoFiles;
use tweeze::compile::CompileOutcome;
use tweeze::diagnostic::Diagnostic;
use tweeze::schedule::{PlanRecord, Schedule};

const UNITS: [f64; 4] = [1.0, 1.0, 1e-6, 1e3];

/// A plan, or the diagnostics reported instead.
type Answer = Result<PlanRecord, Vec<Diagnostic>>;

fn answer(text: &str) -> Answer {
    answers(text).map(|mut plans| plans.remove(0))
}

/// The first plan of each schedule.
fn answers(text: &str) -> Result<Vec<PlanRecord>, Vec<Diagnostic>> {
    schedules(text).map(|schedules| schedules.into_iter().map(|mut schedule| schedule.plans.remove(0)).collect())
}

fn schedules(text: &str) -> Result<Vec<Schedule>, Vec<Diagnostic>> {
    let (outcome, _, sink) = compiled(&NoFiles, text);
    match outcome {
        CompileOutcome::Compiled(compiled) => {
            Ok(compiled.schedules.iter().map(|verified| verified.schedule().clone()).collect())
        }
        CompileOutcome::Errors => {
            Err(sink.sorted().into_iter().filter(|reported| reported.is_error()).cloned().collect())
        }
        CompileOutcome::Refused => panic!("the verifier refuses it: {:?}\n{text}", sink.sorted()),
    }
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * a.abs().max(b.abs())
}

/// Counts of outcomes.
#[derive(Debug, Default)]
struct Seen {
    plans: usize,
    limited: usize,
    impossible: usize,
    shut: usize,
    advised: usize,
    contradictions: usize,
}

/// Compares an answer with the truth. `searches` is whether the planner guarantees to find a plan if there is one.
fn judge(
    scene: &Scene,
    front: &[Figures],
    objective: usize,
    limits: &[Limit],
    text: &str,
    searches: bool,
    seen: &mut Seen,
) {
    let keeps = |figures: &Figures, limits: &[Limit]| {
        limits.iter().all(|limit| limit.allows(scene.outcome(limit.outcome, *figures)))
    };
    let best =
        front.iter().filter(|figures| keeps(figures, limits)).min_by_key(|figures| scene.key(objective, **figures));
    let answer = answer(text);
    let of_both = |reported: &Diagnostic| reported.title.starts_with("no plan keeps both limits of");
    let contradicts = answer.as_ref().is_err_and(|reported| reported.iter().any(of_both));
    assert_eq!(contradicts, Limit::contradict(limits), "{answer:?}\n{text}");
    if contradicts {
        seen.contradictions += 1;
        return;
    }
    match (answer, best) {
        (Ok(plan), Some(best)) => {
            for limit in limits {
                let value = plan.outcomes[KEYS[limit.outcome]] * UNITS[limit.outcome];
                assert!(limit.holds(value), "{limit:?} {value}\n{text}");
            }
            for (outcome, name) in OUTCOMES.iter().enumerate() {
                let (reported, truth) = (plan.outcomes[KEYS[outcome]] * UNITS[outcome], scene.outcome(outcome, *best));
                assert!(close(reported, truth), "{name}: {reported} for {truth}\n{text}");
            }
            let cost = scene.outcome(objective, *best);
            assert!(close(plan.cost, cost) && close(plan.bound, cost) && plan.optimal, "{plan:?}\n{text}");
            seen.plans += 1;
            seen.limited += usize::from(best != front.iter().min_by_key(|f| scene.key(objective, **f)).unwrap_or(best));
        }
        (Ok(plan), None) => panic!("there is no plan: {plan:?}\n{text}"),
        (Err(reported), _) if front.is_empty() => {
            assert!(reported.iter().any(|reported| reported.code.name() == "E0601"), "{reported:?}\n{text}");
            seen.shut += 1;
        }
        (Err(reported), best) => {
            assert!(reported.iter().all(|reported| reported.code.name() == "E0603"), "{reported:?}\n{text}");
            let proven = reported.iter().any(|reported| reported.title.starts_with("no plan keeps"));
            assert!(!proven || best.is_none(), "there is a plan {best:?}: {reported:?}\n{text}");
            if let Some(best) = best.filter(|_| searches) {
                // Lower limits are only checked for the plan that was found.
                let misses = |limit: &Limit| !limit.holds(scene.outcome(limit.outcome, *best));
                assert!(limits.iter().any(misses), "a plan was missed: {best:?} {reported:?}\n{text}");
            }
            if searches && best.is_none() {
                assert!(proven, "{reported:?}\n{text}");
                seen.impossible += 1;
            }
            for reported in &reported {
                seen.advised += usize::from(advice_holds(scene, front, limits, reported, text));
            }
        }
    }
}

/// Whether a report names the least value, and that value is correct: a limit there can be kept, and no lower one.
fn advice_holds(scene: &Scene, front: &[Figures], limits: &[Limit], reported: &Diagnostic, text: &str) -> bool {
    let label = &reported.labels[0];
    let Some(value) = label.text.strip_prefix("proven: the minimum is ") else { return false };
    let value = value.strip_suffix(" with the other limits").unwrap_or(value);
    let line = text[label.span.start as usize..].split_whitespace().next().expect("a limit begins with an outcome");
    let outcome = OUTCOMES.iter().position(|name| *name == line).expect("the label stands at an outcome");
    // The limits are numbered in the order of the text.
    let index = text[..label.span.start as usize].matches("  require ").count() - 1;
    let others = |figures: &&Figures| {
        let mut others = limits.iter().enumerate().filter(|(other, _)| *other != index);
        others.all(|(_, limit)| limit.allows(scene.outcome(limit.outcome, **figures)))
    };
    let least =
        front.iter().filter(others).map(|figures| scene.outcome(outcome, *figures)).fold(f64::INFINITY, f64::min);
    let reported: f64 = {
        let (number, unit) = value.split_once(' ').unwrap_or((value, ""));
        let scale = match unit {
            "s" | "mm" | "J" => 1e3,
            "nm" | "us" | "uJ" => 1e-3,
            _ => 1.0,
        };
        number.parse::<f64>().expect("a number") * scale
    };
    assert!(
        reported >= least * (1.0 - 1e-9) && reported <= least * 1.000_02,
        "{reported} for {least}: {label:?}\n{text}"
    );
    true
}

/// A scene with its Pareto front; in every second round, if possible, one with more than one plan on the front.
fn drawn(random: &mut Random, round: usize, has_pulses: bool) -> (Scene, Vec<Figures>) {
    let mut draw = || {
        let scene = Scene::random(random, has_pulses);
        let front = brute::front(&scene.lattice, scene.start, &scene.parts, has_pulses);
        (scene, front)
    };
    let first = draw();
    if round.is_multiple_of(2) {
        return first;
    }
    (0..200).map(|_| draw()).find(|(_, front)| front.len() > 1).unwrap_or(first)
}

const PUBLISHED: [&str; 4] = ["dijkstra", "bidirectional_dijkstra", "astar", "hypercube_astar"];

#[test]
fn plans_and_limits_agree_with_brute_force() {
    let mut random = Random::new(41);
    let mut seen = Seen::default();
    for round in 0..cases(40) {
        let (scene, front) = drawn(&mut random, round, false);
        for (objective, name) in OUTCOMES.iter().enumerate() {
            let settings = format!("  minimize {name}\n");
            judge(&scene, &front, objective, &[], &scene.text(&settings, &[]), true, &mut seen);
            for _ in 0..3 {
                let limits = scene.limits(&front, &mut random);
                judge(&scene, &front, objective, &limits, &scene.text(&settings, &limits), true, &mut seen);
            }
            if !scene.parts.iter().any(|part| matches!(part, brute::Part::All(_))) {
                let limits = scene.limits(&front, &mut random);
                let settings = format!("{settings}  using {}\n", PUBLISHED[(round + objective) % 4]);
                judge(&scene, &front, objective, &[], &scene.text(&settings, &[]), false, &mut seen);
                judge(&scene, &front, objective, &limits, &scene.text(&settings, &limits), false, &mut seen);
            }
        }
    }
    assert!(seen.plans > 150 && seen.limited > 5 && seen.impossible > 40 && seen.advised > 30, "{seen:?}");
    println!("{seen:?}");
}

#[test]
fn plans_with_several_modules_in_a_pulse_agree_with_brute_force() {
    let mut random = Random::new(42);
    let mut seen = Seen::default();
    for round in 0..cases(25) {
        let (scene, front) = drawn(&mut random, round, true);
        let settings = "  minimize time\n  simultaneous: safe\n";
        judge(&scene, &front, 2, &[], &scene.text(settings, &[]), true, &mut seen);
        for _ in 0..4 {
            let limits = scene.limits(&front, &mut random);
            judge(&scene, &front, 2, &limits, &scene.text(settings, &limits), true, &mut seen);
        }
        // For any other objective the setting has no effect.
        let single = brute::front(&scene.lattice, scene.start, &scene.parts, false);
        let objective = [0, 1, 3][round % 3];
        let settings = settings.replace("time", OUTCOMES[objective]);
        let limits = scene.limits(&single, &mut random);
        for limits in [&[], limits.as_slice()] {
            judge(&scene, &single, objective, limits, &scene.text(&settings, limits), true, &mut seen);
        }
    }
    assert!(seen.plans > 40 && seen.limited > 1 && seen.impossible > 10, "{seen:?}");
    println!("{seen:?}");
}

#[test]
fn long_visits_agree_with_brute_force() {
    let mut random = Random::new(43);
    let (mut proven, mut open) = (0, 0);
    for round in 0..cases(8) {
        let places = if round % 8 == 7 { 13 } else { 5 + random.below(6) };
        let scene = Scene::long_visit(&mut random, places);
        let objective = round % 4;
        let key = |figures| scene.key(objective, figures);
        let best = brute::least(&scene.lattice, scene.start, &scene.parts, key);
        let text = scene.text(&format!("  minimize {}\n", OUTCOMES[objective]), &[]);
        match (answer(&text), best) {
            (Ok(plan), Some(best)) => {
                let cost = scene.outcome(objective, best);
                assert!(
                    plan.bound <= cost * (1.0 + 1e-9) && plan.cost >= cost * (1.0 - 1e-9),
                    "{plan:?} {cost}\n{text}"
                );
                assert!(places > 12 || plan.optimal, "{plan:?}\n{text}");
                assert!(!plan.optimal || close(plan.cost, cost), "{plan:?} {cost}\n{text}");
                for (outcome, name) in OUTCOMES.iter().enumerate().filter(|_| places <= 12) {
                    let (reported, truth) =
                        (plan.outcomes[KEYS[outcome]] * UNITS[outcome], scene.outcome(outcome, best));
                    assert!(close(reported, truth), "{name}: {reported} for {truth}\n{text}");
                }
                proven += usize::from(plan.optimal);
                open += usize::from(!plan.optimal);
            }
            (Err(reported), None) => {
                assert!(reported.iter().any(|reported| reported.code.name() == "E0601"), "{reported:?}\n{text}")
            }
            (answer, best) => panic!("{answer:?} for {best:?}\n{text}"),
        }
    }
    println!("{proven} proven, {open} open");
    assert!(proven > 3, "{proven} proven, {open} open");
}
