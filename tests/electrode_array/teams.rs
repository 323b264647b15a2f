//! Interchangeable goals compared with brute force: random programs with `move any` on tiny boards, before and beside
//! other moves.
//!
//! The truth is found without the planner, by Dijkstra's algorithm over the joint positions of all parts, in which a
//! part of a team may arrive at any goal of its team. It runs once for each figure, to every arrangement in which a
//! step can end. `TWEEZE_ORACLE_CASES=2000` runs 2000 programs, each for both objectives and with a limit.

use crate::programs::{Answered, answered};
use crate::scenes::Random;
use crate::scenes::random::cases;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap, HashMap};
use tweeze::plan::Optimality;

const FIGURES: [&str; 3] = ["steps", "sum_of_costs", "moves"];

type Place = (i32, i32);

/// Kind of parts: separation of their centres, and clearance from obstacles and the rim.
#[derive(Clone, Copy, Debug)]
struct Kind {
    device: &'static str,
    part: &'static str,
    separation: i32,
    clearance: i32,
    rim: i32,
}

const DROPLETS: Kind = Kind { device: "droplet_chip", part: "droplet", separation: 2, clearance: 1, rim: 0 };
const WIDE_DROPLETS: Kind = Kind { separation: 3, clearance: 2, ..DROPLETS };
const MICROPARTS: Kind = Kind { device: "smart_platform", part: "micropart", separation: 4, clearance: 3, rim: 1 };

/// Goals of a step: for each part the cells at one of which it must end, or nothing.
#[derive(Clone, Debug)]
struct Step {
    /// The goals of the whole team `m`.
    team: Option<Vec<Place>>,
    /// Parts with their own goals.
    moves: Vec<(usize, Place)>,
}

#[derive(Clone, Debug)]
struct Case {
    kind: Kind,
    size: Place,
    blocked: Vec<Place>,
    /// The team's parts `m0`, `m1`, …, then perhaps one other part, `a`.
    parts: Vec<Place>,
    team: usize,
    may_yield: bool,
    steps: Vec<Step>,
}

fn apart(one: Place, other: Place) -> i32 {
    (one.0 - other.0).abs().max((one.1 - other.1).abs())
}

impl Case {
    fn random(chance: &mut Random) -> Option<Case> {
        let kind = [DROPLETS, DROPLETS, DROPLETS, WIDE_DROPLETS, MICROPARTS][chance.below(5) as usize];
        let sizes = match kind.separation {
            2 => [(4, 4), (5, 3), (7, 1), (6, 2), (5, 4)],
            3 => [(5, 5), (6, 4), (9, 1), (7, 3), (4, 4)],
            _ => [(8, 5), (7, 7), (11, 3), (8, 6), (11, 4)],
        };
        let size = sizes[chance.below(5) as usize];
        let mut case = Case {
            kind,
            size,
            blocked: vec![],
            parts: vec![],
            team: 0,
            may_yield: chance.below(3) == 0,
            steps: vec![],
        };
        for _ in 0..chance.below(4) {
            let cell = case.cell(chance);
            case.blocked.push(cell);
        }
        case.team = 2 + usize::from(kind.separation == 2 && chance.below(3) == 0);
        let others = usize::from(case.team == 2 && chance.below(2) == 0);
        case.parts = case.scattered(case.team + others, &[], chance)?;
        for _ in 0..1 + chance.below(2) {
            let step = case.step(chance)?;
            case.steps.push(step);
        }
        case.steps.iter().any(|step| step.team.is_some()).then_some(case)
    }

    fn step(&self, chance: &mut Random) -> Option<Step> {
        let count = self.parts.len();
        let mut step = Step { team: None, moves: vec![] };
        let goals = self.scattered(count, &[], chance)?;
        if chance.below(4) > 0 {
            step.team = Some(goals[..self.team].to_vec());
            if count > self.team && chance.below(2) == 0 {
                step.moves.push((self.team, goals[self.team]));
            }
            return Some(step);
        }
        for (part, goal) in goals.into_iter().enumerate().filter(|_| chance.below(2) == 0) {
            step.moves.push((part, goal));
        }
        (!step.moves.is_empty()).then_some(step)
    }

    fn cell(&self, chance: &mut Random) -> Place {
        (1 + chance.below(self.size.0 as u32) as i32, 1 + chance.below(self.size.1 as u32) as i32)
    }

    fn is_free(&self, cell: Place) -> bool {
        let within = |at: i32, size: i32| at > self.kind.rim && at <= size - self.kind.rim;
        within(cell.0, self.size.0)
            && within(cell.1, self.size.1)
            && self.blocked.iter().all(|other| apart(*other, cell) >= self.kind.clearance)
    }

    /// Random free cells that keep the separation from each other and from `from`.
    fn scattered(&self, count: usize, from: &[Place], chance: &mut Random) -> Option<Vec<Place>> {
        let mut found: Vec<Place> = vec![];
        for _ in 0..60 {
            let cell = self.cell(chance);
            let keeps = found.iter().chain(from).all(|other| apart(*other, cell) >= self.kind.separation);
            if found.len() < count && self.is_free(cell) && keeps {
                found.push(cell);
            }
        }
        (found.len() == count).then_some(found)
    }

    fn name(&self, part: usize) -> String {
        if part < self.team { format!("m[{part}]") } else { "a".to_owned() }
    }

    fn text(&self, objective: &str, limit: &str) -> String {
        let Kind { device, part, separation, clearance, .. } = self.kind;
        let (columns, rows) = self.size;
        let mut lines = vec![
            "use std.electrode_array as ea".to_owned(),
            format!(
                "device chip : ea.{device} {{ columns: {columns}, rows: {rows}, separation: {separation}, clearance: {clearance} }}"
            ),
            format!("let starts = {:?}", &self.parts[..self.team]),
        ];
        lines.push("scene tray {".to_owned());
        lines.extend(self.blocked.iter().enumerate().map(|(index, at)| format!("obstacle o{index} at {at:?}")));
        lines.push(format!("for i in 0..{} {{ part m[i] : ea.{part} at starts[i] }}", self.team));
        lines.extend(self.parts[self.team..].iter().map(|at| format!("part a : ea.{part} at {at:?}")));
        lines.push(format!("}}\ntask go on chip in tray {{\nminimize {objective}\n{limit}"));
        if self.may_yield {
            lines.push("may_yield: true".to_owned());
        }
        for step in &self.steps {
            lines.push("together {".to_owned());
            lines.extend(step.team.iter().map(|goals| format!("move any m to {goals:?}")));
            lines.extend(step.moves.iter().map(|(part, goal)| format!("move {} to {goal:?}", self.name(*part))));
            lines.push("}".to_owned());
        }
        lines.push("}".to_owned());
        lines.join("\n")
    }

    /// The least of each figure over all plans of all steps; `None` if there is no plan.
    fn truth(&self) -> [Option<u64>; 3] {
        [0, 1, 2].map(|figure| {
            let mut ends = BTreeMap::from([(self.parts.clone(), 0)]);
            for step in &self.steps {
                let mut later: BTreeMap<Vec<Place>, u64> = BTreeMap::new();
                for (from, cost) in &ends {
                    for (to, more) in Stage::new(self, step, from).ends(figure) {
                        let least = later.entry(to).or_insert(u64::MAX);
                        *least = (*least).min(cost + more);
                    }
                }
                ends = later;
            }
            ends.into_values().min()
        })
    }
}

/// One step; `goals` are the cells where each part may end, `None` for a part that does not move at all.
struct Stage<'a> {
    case: &'a Case,
    from: &'a [Place],
    goals: Vec<Option<Vec<Place>>>,
}

/// A cell, and whether the part has arrived for good.
type At = (Place, bool);

impl<'a> Stage<'a> {
    fn new(case: &'a Case, step: &Step, from: &'a [Place]) -> Stage<'a> {
        let goals = (0..from.len()).map(|part| match (&step.team, step.moves.iter().find(|(own, _)| *own == part)) {
            (_, Some((_, goal))) => Some(vec![*goal]),
            (Some(goals), None) if part < case.team => Some(goals.clone()),
            _ => case.may_yield.then(|| vec![from[part]]),
        });
        Stage { case, from, goals: goals.collect() }
    }

    /// The arrangements in which the step can end, each with the least figure.
    fn ends(&self, figure: usize) -> BTreeMap<Vec<Place>, u64> {
        let mut found = BTreeMap::new();
        let mut least: HashMap<Vec<At>, u64> = HashMap::new();
        let mut open = BinaryHeap::new();
        for first in self.settled(&self.from.iter().map(|at| (*at, false)).collect::<Vec<At>>()) {
            least.insert(first.clone(), 0);
            open.push(Reverse((0, first)));
        }
        while let Some(Reverse((cost, at))) = open.pop() {
            if least[&at] < cost {
                continue;
            }
            if at.iter().all(|part| part.1) {
                found.entry(at.iter().map(|part| part.0).collect()).or_insert(cost);
                continue;
            }
            let under_way = at.iter().filter(|part| !part.1).count() as u64;
            for moved in self.moved(&at) {
                let moves = at.iter().zip(&moved).filter(|(one, other)| one.0 != other.0).count() as u64;
                let later = cost + [1, under_way, moves][figure];
                for next in self.settled(&moved) {
                    if least.get(&next).is_none_or(|known| later < *known) {
                        least.insert(next.clone(), later);
                        open.push(Reverse((later, next)));
                    }
                }
            }
        }
        found
    }

    /// A joint position with each choice of the parts that have arrived for good by then.
    fn settled(&self, at: &[At]) -> Vec<Vec<At>> {
        let mut all: Vec<Vec<At>> = vec![vec![]];
        for (part, (place, done)) in at.iter().enumerate() {
            let may = self.goals[part].as_ref().is_none_or(|goals| goals.contains(place));
            let must = self.goals[part].is_none();
            let mut ways = vec![];
            if !done && !must {
                ways.push(false);
            }
            if *done || may {
                ways.push(true);
            }
            all = all
                .iter()
                .flat_map(|head| ways.iter().map(|way| [head.as_slice(), &[(*place, *way)]].concat()))
                .collect();
        }
        all
    }

    /// All joint positions one step later.
    fn moved(&self, from: &[At]) -> Vec<Vec<At>> {
        let mut heads: Vec<Vec<At>> = vec![vec![]];
        for (part, ((column, row), done)) in from.iter().enumerate() {
            let beside = [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)].map(|(right, up)| (column + right, row + up));
            let ways: Vec<Place> = match done {
                true => vec![(*column, *row)],
                false => beside.into_iter().filter(|cell| self.case.is_free(*cell)).collect(),
            };
            let mut longer = vec![];
            for head in &heads {
                for to in &ways {
                    let keeps = |other: usize| {
                        let theirs = [from[other].0, head[other].0];
                        let own = [(*column, *row), *to];
                        own.iter().all(|at| theirs.iter().all(|by| apart(*at, *by) >= self.case.kind.separation))
                    };
                    if (0..part).all(keeps) {
                        longer.push([head.as_slice(), &[(*to, *done)]].concat());
                    }
                }
            }
            heads = longer;
        }
        heads
    }
}

#[derive(Default, Debug)]
struct Seen {
    proven: usize,
    open: usize,
    refuted: usize,
    none: usize,
    unfit: usize,
    limits: usize,
}

fn compare(case: &Case, truth: [Option<u64>; 3], by_sum: bool, limit: Option<(usize, u64)>, seen: &mut Seen) {
    let own = usize::from(by_sum);
    let asked = limit.map_or(String::new(), |(figure, most)| format!("require {} <= {most}", FIGURES[figure]));
    let text = case.text(FIGURES[own].replace("steps", "makespan").as_str(), &asked);
    let can_keep = limit.is_none_or(|(figure, most)| truth[figure].is_some_and(|least| least <= most));
    match answered(&text) {
        Answered::Unfit => seen.unfit += 1,
        Answered::Plan(plan) => {
            let least = truth.map(|least| least.unwrap_or_else(|| panic!("there is no plan\n{text}")));
            let reached = FIGURES.map(|name| plan.outcomes[name] as u64);
            assert!((0..3).all(|figure| reached[figure] >= least[figure]), "{reached:?} {least:?}\n{text}");
            if let Some((figure, most)) = limit {
                assert!(reached[figure] <= most, "{reached:?}\n{text}");
                seen.limits += 1;
            }
            assert!(plan.bound as u64 <= least[own], "bound {} above {least:?}\n{text}", plan.bound);
            let other = plan.bounds[FIGURES[1 - own]];
            assert!(other as u64 <= least[1 - own], "bound {other} above {least:?}\n{text}");
            match plan.proof {
                Optimality::Proven => {
                    assert_eq!(plan.cost as u64, least[own], "{text}");
                    seen.proven += 1;
                }
                Optimality::Open => seen.open += 1,
            }
        }
        Answered::Errors(errors) => {
            let reported = errors.join("\n");
            if reported.contains("E0601") {
                assert_eq!(truth, [None; 3], "{reported}\n{text}");
                seen.refuted += 1;
            } else if reported.contains("E0603: no plan keeps") || reported.contains("E0603: no plan has") {
                assert!(!can_keep, "{reported}\n{truth:?}\n{text}");
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
fn goals_of_a_team_agree_with_brute_force() {
    let cases = cases(60);
    let mut chance = Random::new(0x7465_616d);
    let (mut seen, mut single, mut done) = (Seen::default(), Seen::default(), 0);
    while done < cases {
        let Some(case) = Case::random(&mut chance) else { continue };
        if matches!(answered(&case.text("makespan", "")), Answered::Unfit) {
            continue;
        }
        let truth = case.truth();
        let is_single = case.steps.len() == 1;
        let kept = if is_single { &mut single } else { &mut seen };
        for by_sum in [false, true] {
            compare(&case, truth, by_sum, None, kept);
        }
        let figure = chance.below(3) as usize;
        let limit = truth[figure].map(|least| (least + u64::from(chance.below(3))).saturating_sub(1));
        compare(&case, truth, chance.below(2) == 0, limit.map(|most| (figure, most)), kept);
        done += 1;
    }
    println!("one step: {single:?}; two steps: {seen:?}");
    // A single step is always decided, except for limits that are not searched for.
    assert!(single.open == 0 && single.proven >= cases / 2, "{single:?}");
    assert!(seen.proven > 0 && single.refuted > 0, "{seen:?} {single:?}");
}

/// The brute force itself, in a case that can be counted by hand.
#[test]
fn two_parts_in_a_row_do_not_pass_one_another() {
    let step = Step { team: Some(vec![(7, 1), (5, 1)]), moves: vec![] };
    let case = Case {
        kind: DROPLETS,
        size: (7, 1),
        blocked: vec![],
        parts: vec![(1, 1), (3, 1)],
        team: 2,
        may_yield: false,
        steps: vec![step],
    };
    // Each moves four cells to the right, the rear one a step later, because it must not come near a cell before the
    // other has left it.
    assert_eq!(case.truth(), [Some(5), Some(9), Some(8)]);
    let named = Step { team: None, moves: vec![(0, (7, 1)), (1, (5, 1))] };
    assert_eq!(Case { steps: vec![named], ..case }.truth(), [None; 3]);
}
