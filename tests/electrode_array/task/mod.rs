//! Whole tasks compared with brute force: random programs of one or two steps on tiny boards, with limits, and every
//! possible plan.
//!
//! The truth is found without the planner: instant by instant, all joint positions with all sums of costs and moves
//! that lead to them, up to [`MOST_STEPS`] for each step of the task. `TWEEZE_ORACLE_CASES=1000` runs 1000 tasks for
//! each objective, each without limits and with three sets of limits.

mod advice;
mod counted;
mod pins;

use crate::pins::{Droplet, Pins};
use crate::programs::{Answered, answered};
use crate::scenes::Random;
use crate::scenes::random::cases;
use advice::{advice, remedied};
use std::collections::{BTreeSet, HashSet};
use tweeze::plan::{Optimality, Plan};

/// Longer plans of a step of the task are not considered.
const MOST_STEPS: u64 = 9;

/// Steps, sum of costs and moves, in this order.
type Figures = [u64; 3];

const NAMES: [&str; 3] = ["steps", "sum_of_costs", "moves"];

/// A step of the task: the goals of the parts, and which parts merge where.
#[derive(Clone, Debug, Default)]
struct Step {
    /// Part and its stops, the goal last.
    moves: Vec<(usize, Vec<(i32, i32)>)>,
    merge: Option<(usize, usize, (i32, i32))>,
    wait_ms: u64,
}

/// Kind of parts: separation of their centres, and clearance from electrodes under obstacles and from the rim.
#[derive(Clone, Copy, Debug)]
struct Kind {
    device: &'static str,
    part: &'static str,
    separation: i32,
    clearance: i32,
    rim: i32,
    step_ms: u64,
    can_merge: bool,
}

const DROPLETS: Kind =
    Kind { device: "droplet_chip", part: "droplet", separation: 2, clearance: 1, rim: 0, step_ms: 60, can_merge: true };
const WIDE_DROPLETS: Kind = Kind { separation: 3, clearance: 2, ..DROPLETS };
const MICROPARTS: Kind = Kind {
    device: "smart_platform",
    part: "micropart",
    separation: 4,
    clearance: 3,
    rim: 1,
    step_ms: 3,
    can_merge: false,
};

/// An obstacle.
#[derive(Clone, Copy, Debug)]
enum Obstacle {
    /// The lower and the upper corner.
    Block((i32, i32), (i32, i32)),
    /// A stuck part.
    Stuck((i32, i32)),
    /// A cell without an electrode, on a board of droplets.
    Gap((i32, i32)),
    /// A cell with a defective electrode.
    Disabled((i32, i32)),
}

impl Obstacle {
    fn allows(self, kind: Kind, cell: (i32, i32)) -> bool {
        match self {
            Obstacle::Block(low, high) => {
                let beyond = |at: i32, low: i32, high: i32| (low - at).max(at - high).max(0);
                beyond(cell.0, low.0, high.0).max(beyond(cell.1, low.1, high.1)) >= kind.clearance
            }
            Obstacle::Stuck(at) => apart(cell, at) >= kind.separation,
            Obstacle::Gap(at) | Obstacle::Disabled(at) => cell != at,
        }
    }

    /// Its text in the scene; `None` if it belongs to the device.
    fn text(self, kind: Kind) -> Option<String> {
        match self {
            Obstacle::Block(low, high) if low == high => Some(format!("at {low:?}")),
            Obstacle::Block(low, high) => Some(format!(": cells {{ from: {low:?}, to: {high:?} }}")),
            Obstacle::Stuck(at) => Some(format!(": ea.{} at {at:?}", kind.part)),
            Obstacle::Gap(_) | Obstacle::Disabled(_) => None,
        }
    }
}

#[derive(Clone, Debug)]
struct Task {
    kind: Kind,
    size: (i32, i32),
    obstacles: Vec<Obstacle>,
    parts: Vec<(i32, i32)>,
    may_yield: bool,
    by_sum: bool,
    steps: Vec<Step>,
    /// Outcome, relation, limit.
    limits: Vec<(&'static str, &'static str, u64)>,
    /// Channels that switch several electrodes.
    pins: Option<Pins>,
}

fn apart(one: (i32, i32), other: (i32, i32)) -> i32 {
    (one.0 - other.0).abs().max((one.1 - other.1).abs())
}

impl Task {
    fn random(chance: &mut Random) -> Option<Task> {
        let kind = [DROPLETS, DROPLETS, WIDE_DROPLETS, MICROPARTS][chance.below(4) as usize];
        let sizes = match kind.separation {
            2 => [(4, 4), (5, 3), (3, 3), (6, 2), (5, 4)],
            3 => [(5, 5), (6, 4), (4, 4), (7, 3), (6, 5)],
            _ => [(8, 5), (7, 7), (9, 5), (8, 6), (11, 4)],
        };
        let size = sizes[chance.below(5) as usize];
        let mut task = Task {
            kind,
            size,
            obstacles: vec![],
            parts: vec![],
            may_yield: false,
            by_sum: false,
            steps: vec![],
            limits: vec![],
            pins: None,
        };
        for _ in 0..chance.below(4) {
            let obstacle = task.obstacle(chance);
            task.obstacles.push(obstacle);
        }
        for _ in 0..2 + chance.below(if kind.separation == 2 { 2 } else { 1 }) {
            let cell = task.far(chance, &task.parts);
            task.parts.extend(cell);
        }
        (task.parts.len() >= 2).then_some(())?;
        let mut at: Vec<Option<(i32, i32)>> = task.parts.iter().copied().map(Some).collect();
        for _ in 0..1 + chance.below(2) {
            let step = task.step(chance, &mut at)?;
            task.steps.push(step);
        }
        task.may_yield = chance.below(2) == 0;
        Some(task)
    }

    fn cell(&self, chance: &mut Random) -> (i32, i32) {
        (1 + chance.below(self.size.0 as u32) as i32, 1 + chance.below(self.size.1 as u32) as i32)
    }

    fn obstacle(&self, chance: &mut Random) -> Obstacle {
        let (one, other) = (self.cell(chance), self.cell(chance));
        match chance.below(if self.kind.can_merge { 8 } else { 6 }) {
            0 => Obstacle::Stuck(one),
            6 => Obstacle::Gap(one),
            7 if !self.obstacles.iter().any(|other| matches!(other, Obstacle::Gap(at) if *at == one)) => {
                Obstacle::Disabled(one)
            }
            1 if apart(one, other) <= 1 => {
                Obstacle::Block((one.0.min(other.0), one.1.min(other.1)), (one.0.max(other.0), one.1.max(other.1)))
            }
            _ => Obstacle::Block(one, one),
        }
    }

    /// Whether a part's centre may be on a cell.
    fn is_free(&self, cell: (i32, i32)) -> bool {
        let within = |at: i32, size: i32| at > self.kind.rim && at <= size - self.kind.rim;
        within(cell.0, self.size.0)
            && within(cell.1, self.size.1)
            && self.obstacles.iter().all(|obstacle| obstacle.allows(self.kind, cell))
    }

    /// A random free cell that keeps the separation from others.
    fn far(&self, chance: &mut Random, taken: &[(i32, i32)]) -> Option<(i32, i32)> {
        let keeps = |cell: (i32, i32)| taken.iter().all(|other| apart(cell, *other) >= self.kind.separation);
        (0..40).map(|_| self.cell(chance)).find(|cell| self.is_free(*cell) && keeps(*cell))
    }

    fn step(&self, chance: &mut Random, at: &mut [Option<(i32, i32)>]) -> Option<Step> {
        let mut step = Step { wait_ms: self.kind.step_ms * u64::from(chance.below(2)), ..Step::default() };
        let standing: Vec<usize> = (0..at.len()).filter(|part| at[*part].is_some()).collect();
        if self.kind.can_merge && standing.len() >= 2 && chance.below(6) == 0 {
            let goal = self.far(chance, &[])?;
            step.merge = Some((standing[0], standing[1], goal));
            (at[standing[0]], at[standing[1]]) = (Some(goal), None);
            return Some(step);
        }
        let asked: Vec<usize> = standing.iter().copied().filter(|_| chance.below(4) > 0).collect();
        let mut taken: Vec<(i32, i32)> =
            standing.iter().filter(|part| !asked.contains(part)).filter_map(|part| at[*part]).collect();
        for part in asked {
            let goal = self.far(chance, &taken)?;
            taken.push(goal);
            let mut stops: Vec<(i32, i32)> = if chance.below(4) == 0 { vec![self.far(chance, &[])?] } else { vec![] };
            stops.push(goal);
            step.moves.push((part, stops));
            at[part] = Some(goal);
        }
        (!step.moves.is_empty()).then_some(step)
    }

    fn has_electrode(&self, cell: (i32, i32)) -> bool {
        !self.obstacles.iter().any(|other| matches!(other, Obstacle::Gap(at) if *at == cell))
    }

    /// Whether shared channels allow some moves in the same step.
    fn allows(&self, droplets: &[Droplet]) -> bool {
        self.pins.as_ref().is_none_or(|pins| pins.allow(droplets, |cell| self.has_electrode(cell)))
    }

    /// The fields of the device for missing and defective electrodes.
    fn map(&self) -> String {
        let (columns, rows) = self.size;
        let gap = |cell: (i32, i32)| !self.has_electrode(cell);
        let number = |column: i32, row: i32| match gap((column, row)) {
            true => "none".to_owned(),
            false => (columns * row + column).to_string(),
        };
        let row = |row: i32| (1..=columns).map(|column| number(column, row)).collect::<Vec<_>>().join(", ");
        let channels: Vec<String> = (1..=rows).rev().map(|at| format!("[{}]", row(at))).collect();
        let dead = self.obstacles.iter().filter_map(|obstacle| match obstacle {
            Obstacle::Disabled(at) if !gap(*at) => Some(format!("{at:?}")),
            _ => None,
        });
        let dead: Vec<String> = dead.collect();
        if let Some(pins) = &self.pins {
            let rows = pins.rows(|cell| self.has_electrode(cell));
            return format!(", channels: [{rows}], disabled: [{}], hold: {}", dead.join(", "), pins.is_held);
        }
        match self.obstacles.iter().any(|obstacle| matches!(obstacle, Obstacle::Gap(_))) {
            true => format!(", channels: [{}], disabled: [{}]", channels.join(", "), dead.join(", ")),
            false if dead.is_empty() => String::new(),
            false => format!(", disabled: [{}]", dead.join(", ")),
        }
    }

    fn text(&self) -> String {
        let (columns, rows) = self.size;
        let mut lines = vec![
            "use std.electrode_array as ea".to_owned(),
            format!(
                "device chip : ea.{} {{ columns: {columns}, rows: {rows}, separation: {}, clearance: {}{} }}",
                self.kind.device,
                self.kind.separation,
                self.kind.clearance,
                self.map()
            ),
            "scene tray {".to_owned(),
        ];
        let obstacles = self.obstacles.iter().enumerate();
        lines.extend(
            obstacles.filter_map(|(index, obstacle)| Some(format!("obstacle o{index} {}", obstacle.text(self.kind)?))),
        );
        let parts = self.parts.iter().enumerate();
        lines.extend(parts.map(|(index, at)| format!("part d{index} : ea.{} at {at:?}", self.kind.part)));
        let objective = if self.by_sum { "sum_of_costs" } else { "makespan" };
        lines.push(format!("}}\ntask go on chip in tray {{\nminimize {objective}"));
        for (outcome, relation, limit) in &self.limits {
            let (value, unit) =
                if *outcome == "time" { (limit * self.kind.step_ms + self.waits_ms(), " ms") } else { (*limit, "") };
            lines.push(format!("require {outcome} {relation} {value}{unit}"));
        }
        if self.may_yield {
            lines.push("may_yield: true".to_owned());
        }
        for step in &self.steps {
            if step.wait_ms > 0 {
                lines.push(format!("wait {} ms", step.wait_ms));
            }
            lines.push("together {".to_owned());
            for (part, stops) in &step.moves {
                let vias: String = stops[..stops.len() - 1].iter().map(|stop| format!(" via {stop:?}")).collect();
                lines.push(format!("move d{part} to {:?}{vias}", stops[stops.len() - 1]));
            }
            if let Some((one, other, at)) = step.merge {
                lines.push(format!("merge d{one} with d{other} at {at:?}"));
            }
            lines.push("}".to_owned());
        }
        lines.push("}".to_owned());
        lines.join("\n")
    }

    fn waits_ms(&self) -> u64 {
        self.steps.iter().map(|step| step.wait_ms).sum()
    }

    /// The figures of all plans of all steps of at most [`MOST_STEPS`] each.
    fn all(&self) -> BTreeSet<Figures> {
        let mut at: Vec<Option<(i32, i32)>> = self.parts.iter().copied().map(Some).collect();
        let mut all = BTreeSet::from([[0; 3]]);
        for step in &self.steps {
            let rest = |at: (i32, i32)| Droplet { from: at, to: at, partner: None, is_split: false };
            if step.wait_ms > 0 && !self.allows(&at.iter().flatten().copied().map(rest).collect::<Vec<_>>()) {
                return BTreeSet::new();
            }
            let own = Stage::new(self, step, &at).all();
            all = all.iter().flat_map(|sum| own.iter().map(|own| [0, 1, 2].map(|k: usize| sum[k] + own[k]))).collect();
            for (part, stops) in &step.moves {
                at[*part] = stops.last().copied();
            }
            if let Some((one, other, goal)) = step.merge {
                (at[one], at[other]) = (Some(goal), None);
            }
        }
        all
    }

    fn keeps(&self, figures: &Figures) -> bool {
        self.limits.iter().all(|(outcome, relation, limit)| {
            let reached = figures[NAMES.iter().position(|name| name == outcome).unwrap_or(0)];
            match *relation {
                "<=" => reached <= *limit,
                "<" => reached < *limit,
                "==" => reached == *limit,
                ">=" => reached >= *limit,
                _ => reached > *limit,
            }
        })
    }
}

/// A part during a step: its start and its stops. A part that yields only has to come back.
struct Part {
    start: (i32, i32),
    stops: Vec<(i32, i32)>,
    merges: bool,
}

struct Stage<'a> {
    task: &'a Task,
    still: Vec<(i32, i32)>,
    parts: Vec<Part>,
}

/// Column, row, number of stops passed, and whether it has arrived for good.
type At = (i32, i32, usize, bool);

impl<'a> Stage<'a> {
    fn new(task: &'a Task, step: &Step, at: &[Option<(i32, i32)>]) -> Stage<'a> {
        let mut stage = Stage { task, still: vec![], parts: vec![] };
        for (index, start) in at.iter().enumerate().filter_map(|(index, at)| Some((index, (*at)?))) {
            let asked = step.moves.iter().find(|(part, _)| *part == index);
            let merging = step.merge.filter(|(one, other, _)| *one == index || *other == index);
            match (asked, merging) {
                (Some((_, stops)), _) => stage.parts.push(Part { start, stops: stops.clone(), merges: false }),
                (_, Some((_, _, goal))) => stage.parts.push(Part { start, stops: vec![goal], merges: true }),
                _ if task.may_yield => stage.parts.push(Part { start, stops: vec![start], merges: false }),
                _ => stage.still.push(start),
            }
        }
        stage
    }

    /// The states of a part that comes to a cell: under way or, at its goal, arrived for good.
    fn come(&self, part: usize, cell: (i32, i32), done: usize, from: Option<At>) -> Vec<At> {
        let Part { stops, merges, .. } = &self.parts[part];
        let mut done = done;
        while done + 1 < stops.len() && stops[done] == cell {
            done += 1;
        }
        let is_home = done + 1 == stops.len() && cell == stops[done];
        let was_home = from.is_some_and(|(column, row, before, _)| (column, row) == cell && before == done);
        let mut ways = vec![];
        if !(is_home && *merges) {
            ways.push((cell.0, cell.1, done, false));
        }
        if is_home && !was_home {
            ways.push((cell.0, cell.1, done, true));
        }
        ways
    }

    fn next(&self, part: usize, at: At) -> Vec<At> {
        let (column, row, done, arrived) = at;
        if arrived {
            return vec![at];
        }
        let cells = [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)].map(|(right, up)| (column + right, row + up));
        let free = |cell: &(i32, i32)| {
            self.task.is_free(*cell) && self.still.iter().all(|other| apart(*cell, *other) >= self.task.kind.separation)
        };
        cells.into_iter().filter(free).flat_map(|cell| self.come(part, cell, done, Some(at))).collect()
    }

    fn clash(&self, one: usize, at: At, other: usize, by: At) -> bool {
        let (cell, beside) = ((at.0, at.1), (by.0, by.1));
        let goal = self.parts[one].stops[0];
        let excused = self.parts[one].merges && self.parts[other].merges && (cell == goal || beside == goal);
        apart(cell, beside) < self.task.kind.separation && !excused
    }

    /// All joint positions one step later.
    fn after(&self, from: &[At]) -> Vec<Vec<At>> {
        let mut heads: Vec<Vec<At>> = vec![vec![]];
        for part in 0..from.len() {
            let mut longer = vec![];
            for head in &heads {
                for to in self.next(part, from[part]) {
                    let fits = head.iter().enumerate().all(|(other, by)| {
                        [from[part], to]
                            .iter()
                            .all(|at| [from[other], *by].iter().all(|by| !self.clash(part, *at, other, *by)))
                    });
                    if fits {
                        longer.push(head.iter().copied().chain([to]).collect());
                    }
                }
            }
            heads = longer;
        }
        heads.retain(|to| self.task.allows(&self.droplets(from, to)));
        heads
    }

    /// All droplets in a step, including those that stay.
    fn droplets(&self, from: &[At], to: &[At]) -> Vec<Droplet> {
        let of_part = |part: usize| {
            let others = (0..to.len()).filter(|other| *other != part && self.parts[*other].merges);
            let partner = others.map(|other| (to[other].0, to[other].1)).next().filter(|_| self.parts[part].merges);
            Droplet { from: (from[part].0, from[part].1), to: (to[part].0, to[part].1), partner, is_split: false }
        };
        let still = self.still.iter().map(|at| Droplet { from: *at, to: *at, partner: None, is_split: false });
        (0..to.len()).map(of_part).chain(still).collect()
    }

    fn all(&self) -> BTreeSet<Figures> {
        let mut first: Vec<Vec<At>> = vec![vec![]];
        for (part, asked) in self.parts.iter().enumerate() {
            let ways = self.come(part, asked.start, 0, None);
            first = first.iter().flat_map(|head| ways.iter().map(|at| [head.as_slice(), &[*at]].concat())).collect();
        }
        let mut layer: HashSet<(Vec<At>, u64, u64)> = first.into_iter().map(|head| (head, 0, 0)).collect();
        let mut found = BTreeSet::new();
        for steps in 0..=MOST_STEPS {
            let mut later = HashSet::new();
            for (at, sum, moves) in &layer {
                if at.iter().all(|part| part.3) {
                    found.insert([steps, *sum, *moves]);
                    continue;
                }
                if steps == MOST_STEPS {
                    continue;
                }
                let under_way = at.iter().filter(|part| !part.3).count() as u64;
                for next in self.after(at) {
                    let moved =
                        at.iter().zip(&next).filter(|(one, other)| (one.0, one.1) != (other.0, other.1)).count();
                    later.insert((next, sum + under_way, moves + moved as u64));
                }
            }
            layer = later;
        }
        found
    }
}

/// A random limit near the figures of an existing plan.
fn limit(all: &BTreeSet<Figures>, chance: &mut Random) -> (&'static str, &'static str, u64) {
    let near = all.iter().nth(chance.below(all.len().clamp(1, 30) as u32) as usize).copied().unwrap_or([3, 5, 5]);
    let outcome = ["steps", "time", "sum_of_costs", "moves"][chance.below(4) as usize];
    let relation = ["<=", "<=", "<=", "<", "==", ">=", ">"][chance.below(7) as usize];
    let reached = near[NAMES.iter().position(|name| *name == outcome).unwrap_or(0)];
    (outcome, relation, (reached + u64::from(chance.below(3))).saturating_sub(1))
}

fn figures(plan: &Plan<()>) -> Figures {
    NAMES.map(|name| plan.outcomes[name] as u64)
}

/// Counts of outcomes: a proven plan, an open one, a proof that there is none, nothing.
#[derive(Default, Debug)]
struct Seen {
    proven: usize,
    open: usize,
    refuted: usize,
    none: usize,
    unknown: usize,
    /// Number of helps that say what the task would cost without some obstacles.
    remedies: usize,
}

fn compare(task: &Task, all: &BTreeSet<Figures>, seen: &mut Seen) {
    let text = task.text();
    let kept: Vec<&Figures> = all.iter().filter(|figures| task.keeps(figures)).collect();
    let first = usize::from(task.by_sum);
    let best = kept.iter().map(|figures| figures[first]).min();
    match answered(&text) {
        Answered::Unfit => seen.unknown += 1,
        Answered::Plan(plan) => {
            let reached = figures(&plan);
            let is_long = reached[0] > MOST_STEPS;
            assert!(is_long || kept.contains(&&reached), "{reached:?} is no plan\n{text}");
            assert!(task.keeps(&reached), "{reached:?}\n{text}");
            // A cheaper plan would be within the steps considered.
            let truth = best.filter(|best| *best <= MOST_STEPS);
            assert!(
                truth.is_none_or(|truth| plan.bound as u64 <= truth),
                "bound {} above {truth:?}\n{text}",
                plan.bound
            );
            assert_eq!(plan.cost as u64, reached[first], "{text}");
            let other = if task.by_sum { "steps" } else { "sum_of_costs" };
            let least = all.iter().map(|figures| figures[1 - first]).min();
            assert!(
                least.is_none_or(|least| plan.bounds[other] as u64 <= least),
                "{:?} {least:?}\n{text}",
                plan.bounds
            );
            match plan.proof {
                Optimality::Proven => {
                    assert!(truth.is_none_or(|truth| truth == plan.cost as u64), "{} for {truth:?}\n{text}", plan.cost);
                    seen.proven += 1;
                }
                Optimality::Open => seen.open += 1,
            }
        }
        Answered::Errors(errors) => {
            let reported = errors.join("\n");
            if reported.contains("E0601") {
                assert!(all.is_empty(), "{reported}\n{text}");
                seen.remedies += usize::from(remedied(task, &reported));
                seen.refuted += 1;
            } else if reported.contains("E0603: no plan keeps") {
                assert!(kept.is_empty(), "{reported}\n{kept:?}\n{text}");
                advice(task, &reported);
                seen.refuted += 1;
            } else {
                assert!(
                    reported.contains("E0603: no plan was found") || reported.contains("E0602"),
                    "{reported}\n{text}"
                );
                seen.none += 1;
            }
        }
    }
}

#[test]
fn tasks_agree_with_all_their_plans() {
    let cases = cases(30);
    let mut chance = Random::new(0x7461_736b);
    let (mut seen, mut done) = (Seen::default(), 0);
    let (mut kinds, mut yields, mut merges) = ([0; 5], 0, 0);
    while done < 2 * cases {
        let Some(mut task) = Task::random(&mut chance) else { continue };
        // Equal numbers of both objectives.
        task.by_sum = done % 2 == 1;
        if matches!(answered(&task.text()), Answered::Unfit) {
            continue;
        }
        let all = task.all();
        compare(&task, &all, &mut seen);
        for _ in 0..3 {
            task.limits = (0..1 + chance.below(3)).map(|_| limit(&all, &mut chance)).collect();
            compare(&task, &all, &mut seen);
        }
        kinds[task.kind.separation as usize] += 1;
        yields += usize::from(task.may_yield);
        merges += usize::from(task.steps.iter().any(|step| step.merge.is_some()));
        done += 1;
    }
    println!("{seen:?}, by separation {kinds:?}, {yields} with yielding, {merges} with merges");
    assert!(seen.proven >= done && seen.refuted >= done / 4, "{seen:?}");
    assert!(seen.none + seen.open <= done, "{seen:?}");
}
