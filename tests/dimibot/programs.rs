//! Programs of several tasks on two robots: each task starts where its robot's last task ended, and is optimal from
//! there.

use super::brute::{self, Cell, Figures};
use super::scene::{KEYS, Limit, OUTCOMES, Random, Scene};
use super::{UNITS, cases, close};
use std::collections::{BTreeMap, BTreeSet};
use tweeze::diagnostic::{Code, Diagnostic};
use tweeze::schedule::dimibot::DimibotState;
use tweeze::schedule::{PlanRecord, State};

/// A task of one of the robots.
struct Work {
    scene: Scene,
    objective: usize,
    with_pulses: bool,
    limits: Vec<Limit>,
}

impl Work {
    /// The figures of the best plan from a cell, and the final cells of plans with these figures.
    fn best(&self, start: Cell) -> Option<(Figures, BTreeSet<Cell>)> {
        let keeps = |figures: &Figures| {
            self.limits.iter().all(|limit| limit.allows(self.scene.outcome(limit.outcome, *figures)))
        };
        let ends = brute::fronts(&self.scene.lattice, start, &self.scene.parts, self.with_pulses);
        let all = ends.values().flatten().filter(|figures| keeps(figures));
        let best = *all.min_by_key(|figures| self.scene.key(self.objective, **figures))?;
        let last = ends.iter().filter(|(_, figures)| figures.contains(&best)).map(|(cell, _)| *cell).collect();
        Some((best, last))
    }

    /// Whether a plan with these figures keeps all limits, including lower limits, which are not searched for.
    fn holds(&self, figures: Figures) -> bool {
        self.limits.iter().all(|limit| limit.holds(self.scene.outcome(limit.outcome, figures)))
    }

    fn settings(&self) -> String {
        let pulses = if self.with_pulses { "  simultaneous: safe\n" } else { "" };
        format!("  minimize {}\n{pulses}", OUTCOMES[self.objective])
    }
}

const ROBOTS: [&str; 2] = ["one", "two"];

/// Up to three tasks for each robot, with limits near the best figures.
fn works(random: &mut Random) -> [Vec<Work>; 2] {
    [(); 2].map(|()| {
        let first = Scene::random(random, true);
        let mut starts = BTreeSet::from([first.start]);
        let mut scene = first;
        let mut works = Vec::new();
        for _ in 0..1 + random.below(3) {
            let with_pulses = random.below(3) == 0;
            let objective = if with_pulses { 2 } else { random.below(4) as usize };
            let mut work = Work { scene: scene.clone(), objective, with_pulses, limits: Vec::new() };
            let bests: Vec<(Figures, BTreeSet<Cell>)> = starts.iter().filter_map(|start| work.best(*start)).collect();
            if random.below(3) == 0 {
                let figures: Vec<Figures> = bests.iter().map(|(figures, _)| *figures).collect();
                work.limits = work.scene.limits(&figures, random);
            }
            starts = starts.iter().filter_map(|start| work.best(*start)).flat_map(|(_, ends)| ends).collect();
            scene = scene.another(random);
            works.push(work);
        }
        works
    })
}

/// The runs of both robots, each robot's in order, some in parallel.
fn runs(works: &[Vec<Work>; 2], random: &mut Random) -> String {
    let mut next = [0, 0];
    let mut text = String::new();
    while (0..2).any(|robot| next[robot] < works[robot].len()) {
        let open: Vec<usize> = (0..2).filter(|robot| next[*robot] < works[*robot].len()).collect();
        let mut run = |robot: usize| {
            next[robot] += 1;
            format!("run {}{}", ROBOTS[robot], next[robot] - 1)
        };
        if open.len() == 2 && random.below(2) == 0 {
            text += &format!("  together {{ {}, {} }}\n", run(0), run(1));
        } else {
            text += &format!("  {}\n", run(open[random.below(open.len() as u32) as usize]));
        }
    }
    text
}

fn text(works: &[Vec<Work>; 2], random: &mut Random) -> String {
    let mut text = "use std.dimibot\n".to_owned();
    for (robot, works) in ROBOTS.iter().zip(works) {
        text += &works[0].scene.robot(robot);
        for (index, work) in works.iter().enumerate() {
            let says_start = index == 0 && !work.scene.starts_at_home();
            text += &work.scene.task(&format!("{robot}{index}"), robot, &work.settings(), &work.limits, says_start);
        }
    }
    text + &format!("program day {{\n{}}}\n", runs(works, random))
}

fn cell(state: &State) -> Cell {
    let State::Dimibot(DimibotState { cell, .. }) = state else { panic!("{state:?}") };
    *cell
}

/// Compares each plan of a robot with the best plan from where it begins.
fn judge(works: &[Work], plans: &[&PlanRecord], text: &str) {
    assert_eq!(works.len(), plans.len(), "{text}");
    let mut at = works[0].scene.start;
    for (work, plan) in works.iter().zip(plans) {
        let states = &plan.states;
        assert_eq!(cell(&states[0].state), at, "{}\n{text}", plan.task);
        let (best, ends) = work.best(at).unwrap_or_else(|| panic!("{} has no plan: {plan:?}\n{text}", plan.task));
        for (outcome, name) in OUTCOMES.iter().enumerate() {
            let (reported, truth) = (plan.outcomes[KEYS[outcome]] * UNITS[outcome], work.scene.outcome(outcome, best));
            assert!(close(reported, truth), "{} {name}: {reported} for {truth}\n{text}", plan.task);
        }
        assert!(work.holds(best), "{}: {best:?}\n{text}", plan.task);
        assert!(plan.optimal && close(plan.bound, plan.cost), "{plan:?}\n{text}");
        at = cell(&states[states.len() - 1].state);
        assert!(ends.contains(&at), "{} ends at {at:?}, not in {ends:?}\n{text}", plan.task);
    }
}

/// Whether some task has no plan from one of the possible final cells of the task before it (`may`), or from all of
/// them (`must`).
struct Failure {
    may: bool,
    must: bool,
}

fn failure(works: &[Work]) -> Failure {
    let mut starts = BTreeSet::from([works[0].scene.start]);
    let mut may = false;
    for work in works {
        let bests: Vec<_> = starts.iter().map(|start| work.best(*start)).collect();
        let fails = |best: &Option<(_, _)>| best.as_ref().is_none_or(|(figures, _)| !work.holds(*figures));
        may |= bests.iter().any(fails);
        if bests.iter().all(fails) {
            return Failure { may, must: true };
        }
        starts = bests.into_iter().flatten().flat_map(|(_, ends)| ends).collect();
    }
    Failure { may, must: false }
}

fn may_fail(works: &[Work]) -> bool {
    failure(works).may
}

#[test]
fn programs_of_several_tasks_agree_with_brute_force() {
    let mut random = Random::new(44);
    let (mut planned, mut refused, mut proven) = (BTreeMap::new(), 0, 0);
    for round in 0..cases(25) {
        // In three of four rounds, only programs with a plan for every task.
        let mut draws = (0..1000).map(|_| works(&mut random));
        let works = match round % 4 {
            0 => draws.next(),
            _ => draws.find(|works| !works.iter().any(|works| may_fail(works))),
        };
        let works = works.expect("one of a thousand has plans");
        let text = text(&works, &mut random);
        match super::schedules(&text) {
            Ok(schedules) => {
                assert_eq!(schedules.len(), 1, "{text}");
                for (robot, works) in ROBOTS.iter().zip(&works) {
                    let plans: Vec<&PlanRecord> =
                        schedules[0].plans.iter().filter(|plan| plan.device == *robot).collect();
                    judge(works, &plans, &text);
                    *planned.entry(plans.len()).or_insert(0) += 1;
                }
            }
            Err(reported) => {
                let known = |code: &str| ["E0601", "E0602", "E0603"].contains(&code);
                assert!(reported.iter().all(|reported| known(reported.code.name())), "{reported:?}\n{text}");
                assert!(works.iter().any(|works| may_fail(works)), "{reported:?}\n{text}");
                let is_proof =
                    |reported: &Diagnostic| reported.code == Code::E0601 || reported.title.starts_with("no plan keeps");
                if reported.iter().any(is_proof) {
                    assert!(works.iter().any(|works| failure(works).must), "{reported:?}\n{text}");
                    proven += 1;
                }
                refused += 1;
            }
        }
    }
    println!("robots by their tasks: {planned:?}, {refused} programs refused, {proven} of them proven impossible");
    assert!(planned.values().sum::<usize>() >= 20 && refused > 0, "{planned:?} {refused}");
}
