//! Assays against brute force: random programs on tiny boards, and every possible plan of each.
//!
//! The truth is found without the planner and the verifier: instant by instant, all joint positions with what each part has done by
//! then, until all is done. `TWEEZE_ORACLE_CASES=1000` runs 1000 assays.

use crate::programs::{Answered, answered};
use crate::scenes::Random;
use std::collections::HashSet;
use tweeze::plan::Optimality;

type Cell = (i32, i32);

/// A board with more joint states than this at one instant is not searched.
const MOST_STATES: usize = 60_000;

/// Longer plans are not looked at.
const MOST_STEPS: u64 = 40;

/// Steps after the shortest plan in which plans of a smaller sum of costs are looked for.
const LATER_STEPS: u64 = 2;

/// Where a part is that no reservoir has dispensed yet: off the board, whose cells count from 1.
const NOWHERE: Cell = (0, 0);

/// A step of the board of `droplet_chip`.
const STEP_MS: u64 = 60;

#[derive(Clone, Debug)]
enum Operation {
    Move(usize, Vec<Cell>),
    Merge(usize, usize, Cell),
    /// A part, where if not where it is, and for how many steps.
    Incubate(usize, Option<Cell>, u64),
    Discard(usize, Cell),
    /// A part, and the number of the reservoir.
    Dispense(usize, usize),
}

#[derive(Clone, Debug)]
struct Assay {
    size: Cell,
    separation: i32,
    blocks: Vec<Cell>,
    parts: Vec<Cell>,
    /// Their outlets.
    reservoirs: Vec<Cell>,
    /// Steps in which a droplet is dispensed.
    dispensing: u64,
    may_yield: bool,
    by_sum: bool,
    operations: Vec<Operation>,
}

/// What a part is to do next: where, for how many steps, and the operation with its number if it merges.
#[derive(Clone, Copy, Debug)]
struct Due {
    at: Cell,
    stay: u64,
    merge: Option<(usize, usize)>,
    is_gone: bool,
    is_dispensed: bool,
}

impl Due {
    fn at(at: Cell) -> Due {
        Due { at, stay: 0, merge: None, is_gone: false, is_dispensed: false }
    }
}

/// A part at an instant: its cell, the number of things done, the steps for which it has been where the next one is, and the instant at
/// which it moved last.
type Stand = Option<(Cell, usize, u64, u64)>;

fn apart(one: Cell, other: Cell) -> i32 {
    (one.0 - other.0).abs().max((one.1 - other.1).abs())
}

impl Assay {
    fn random(chance: &mut Random) -> Option<Assay> {
        let separation = if chance.below(4) == 0 { 3 } else { 2 };
        let sizes = match separation {
            2 => [(4, 4), (5, 3), (6, 2), (5, 4), (7, 2)],
            _ => [(5, 5), (6, 4), (7, 3), (4, 4), (8, 2)],
        };
        let size = sizes[chance.below(5) as usize];
        let by_sum = chance.below(3) == 0;
        let mut assay = Assay {
            size,
            separation,
            blocks: vec![],
            parts: vec![],
            reservoirs: vec![],
            dispensing: u64::from(1 + chance.below(3)),
            may_yield: false,
            by_sum,
            operations: vec![],
        };
        assay.furnish(chance)?;
        (assay.parts.len() >= 2).then_some(())?;
        assay.may_yield = chance.below(2) == 0;
        if !assay.reservoirs.is_empty() && chance.below(3) == 0 {
            return assay.served(chance);
        }
        let mut left: Vec<usize> = (0..assay.parts.len()).collect();
        let mut ends = assay.parts.clone();
        for _ in 0..1 + chance.below(5) {
            let Some(part) = left.get(chance.below(left.len().max(1) as u32) as usize).copied() else { break };
            assay.dispense(chance, &mut ends, part);
            let operation = match chance.below(10) {
                0..=2 => Operation::Move(part, vec![assay.far(chance, &[])?]),
                3 => Operation::Move(part, vec![assay.far(chance, &[])?, assay.far(chance, &[])?]),
                4 => Operation::Incubate(part, None, u64::from(chance.below(5))),
                5 => Operation::Incubate(part, Some(assay.far(chance, &[])?), u64::from(chance.below(5))),
                6..=7 => {
                    // Often where it is, or where another has been.
                    let known: Vec<Cell> = ends.iter().copied().filter(|cell| assay.is_free(*cell)).collect();
                    let at = if chance.below(2) == 0 {
                        Some(known[chance.below(known.len() as u32) as usize])
                    } else {
                        assay.far(chance, &[])
                    };
                    left.retain(|left| *left != part);
                    Operation::Discard(part, at?)
                }
                _ => {
                    let other = left[chance.below(left.len() as u32) as usize];
                    (other != part).then_some(())?;
                    assay.dispense(chance, &mut ends, other);
                    left.retain(|left| *left != other);
                    Operation::Merge(part, other, assay.far(chance, &[])?)
                }
            };
            ends[part] = match &operation {
                Operation::Move(_, stops) => stops[stops.len() - 1],
                Operation::Merge(_, _, at) | Operation::Discard(_, at) => *at,
                Operation::Incubate(part, at, _) => at.unwrap_or(ends[*part]),
                Operation::Dispense(_, reservoir) => assay.reservoirs[*reservoir],
            };
            assay.operations.push(operation);
        }
        let keep = |one: &usize, other: &usize| one == other || apart(ends[*one], ends[*other]) >= separation;
        left.iter().all(|one| left.iter().all(|other| keep(one, other))).then_some(assay)
    }

    /// All parts out of reservoirs, each to stay at one of two places and to leave: places wait for reservoirs, and parts for places.
    fn served(mut self, chance: &mut Random) -> Option<Assay> {
        let first = self.far(chance, &self.reservoirs)?;
        let second = self.far(chance, &[self.reservoirs.as_slice(), &[first]].concat())?;
        for part in 0..self.parts.len() {
            self.parts[part] = NOWHERE;
            let reservoir = chance.below(self.reservoirs.len() as u32) as usize;
            let place = if part < 2 { [first, second][part] } else { [first, second][chance.below(2) as usize] };
            let out = self.far(chance, &[])?;
            self.operations.push(Operation::Dispense(part, reservoir));
            self.operations.push(Operation::Incubate(part, Some(place), u64::from(1 + chance.below(7))));
            self.operations.push(Operation::Discard(part, if chance.below(2) == 0 { place } else { out }));
        }
        Some(self)
    }

    /// Adds obstacles, reservoirs and parts.
    fn furnish(&mut self, chance: &mut Random) -> Option<()> {
        for _ in 0..chance.below(3) {
            let block = self.cell(chance);
            self.blocks.push(block);
        }
        for _ in 0..chance.below(3) {
            let outlet = self.far(chance, &[])?;
            if !self.reservoirs.contains(&outlet) {
                self.reservoirs.push(outlet);
            }
        }
        for _ in 0..2 + chance.below(2) {
            let is_dispensed = !self.reservoirs.is_empty() && chance.below(2) == 0;
            let cell = if is_dispensed { Some(NOWHERE) } else { self.far(chance, &self.parts) };
            self.parts.extend(cell);
        }
        Some(())
    }

    /// Has a part dispensed that is nowhere yet.
    fn dispense(&mut self, chance: &mut Random, ends: &mut [Cell], part: usize) {
        if ends[part] == NOWHERE {
            let reservoir = chance.below(self.reservoirs.len() as u32) as usize;
            ends[part] = self.reservoirs[reservoir];
            self.operations.push(Operation::Dispense(part, reservoir));
        }
    }

    fn cell(&self, chance: &mut Random) -> Cell {
        (1 + chance.below(self.size.0 as u32) as i32, 1 + chance.below(self.size.1 as u32) as i32)
    }

    fn is_free(&self, (column, row): Cell) -> bool {
        (1..=self.size.0).contains(&column) && (1..=self.size.1).contains(&row) && !self.blocks.contains(&(column, row))
    }

    fn far(&self, chance: &mut Random, taken: &[Cell]) -> Option<Cell> {
        let keeps = |cell: Cell| taken.iter().all(|other| apart(cell, *other) >= self.separation);
        (0..40).map(|_| self.cell(chance)).find(|cell| self.is_free(*cell) && keeps(*cell))
    }

    fn text(&self) -> String {
        let ((columns, rows), separation) = (self.size, self.separation);
        let mut lines = vec![
            "use std.electrode_array as ea".to_owned(),
            format!(
                "device chip : ea.droplet_chip {{ columns: {columns}, rows: {rows}, separation: {separation}, clearance: 1, dispense_duration: {} ms }}",
                self.dispensing * STEP_MS
            ),
            "scene tray {".to_owned(),
        ];
        lines.extend(self.blocks.iter().enumerate().map(|(index, at)| format!("obstacle o{index} at {at:?}")));
        lines.extend(self.reservoirs.iter().enumerate().map(|(index, at)| format!("reservoir r{index} at {at:?}")));
        lines.extend(self.parts.iter().enumerate().map(|(index, at)| match *at {
            NOWHERE => format!("part d{index} : ea.droplet"),
            at => format!("part d{index} : ea.droplet at {at:?}"),
        }));
        lines.push("}\ntask go on chip in tray {".to_owned());
        lines.push(format!("minimize {}", if self.by_sum { "sum_of_costs" } else { "makespan" }));
        if self.may_yield {
            lines.push("may_yield: true".to_owned());
        }
        lines.push("assay {".to_owned());
        for operation in &self.operations {
            lines.push(match operation {
                Operation::Move(part, stops) => {
                    let vias: String = stops[..stops.len() - 1].iter().map(|stop| format!(" via {stop:?}")).collect();
                    format!("move d{part} to {:?}{vias}", stops[stops.len() - 1])
                }
                Operation::Merge(part, with, at) => format!("merge d{part} with d{with} at {at:?}"),
                Operation::Discard(part, at) => format!("discard d{part} at {at:?}"),
                Operation::Dispense(part, reservoir) => format!("dispense d{part} from r{reservoir}"),
                Operation::Incubate(part, at, stay) => {
                    let place = at.map(|at| format!(" at {at:?}")).unwrap_or_default();
                    format!("incubate d{part}{place} for {} ms", stay * STEP_MS)
                }
            });
        }
        lines.push("}\n}".to_owned());
        lines.join("\n")
    }

    /// What each part is to do, in its order.
    fn dues(&self) -> Vec<Vec<Due>> {
        let mut dues: Vec<Vec<Due>> = vec![Vec::new(); self.parts.len()];
        for (number, operation) in self.operations.iter().enumerate() {
            match operation {
                Operation::Move(part, stops) => {
                    dues[*part].extend(stops.iter().map(|at| Due::at(*at)));
                }
                Operation::Incubate(part, at, stay) => {
                    let here = dues[*part].last().map_or(self.parts[*part], |due| due.at);
                    dues[*part].push(Due { stay: *stay, ..Due::at(at.unwrap_or(here)) });
                }
                Operation::Discard(part, at) => {
                    dues[*part].push(Due { is_gone: true, ..Due::at(*at) });
                }
                Operation::Dispense(part, reservoir) => {
                    let due = Due { stay: self.dispensing, is_dispensed: true, ..Due::at(self.reservoirs[*reservoir]) };
                    dues[*part].push(due);
                }
                Operation::Merge(part, with, at) => {
                    let due = |other, is_gone| Due { merge: Some((number, other)), is_gone, ..Due::at(*at) };
                    dues[*part].push(due(*with, false));
                    dues[*with].push(due(*part, true));
                }
            }
        }
        dues
    }

    /// The fewest steps of any plan, and the smallest sum of costs of those that take few more. An error if there is none, and none if
    /// there are too many states or steps.
    fn least(&self) -> Option<Result<(u64, u64), ()>> {
        let dues = self.dues();
        let start: Vec<Stand> = self.parts.iter().map(|cell| Some((*cell, 0, 0, 0))).collect();
        let (mut now, mut met) = (HashSet::from_iter(self.settled(&dues, start)), HashSet::new());
        let (mut fewest, mut sum) = (None, u64::MAX);
        for step in 0..=MOST_STEPS {
            let ended = now.iter().filter(|stands| self.is_end(&dues, stands));
            let sums = ended.map(|stands| stands.iter().flatten().map(|(_, _, _, moved)| moved).sum::<u64>());
            // Parts that are gone moved last when they merged, which is noted with the dues done.
            let best = sums.min();
            if let Some(best) = best {
                fewest = fewest.or(Some(step));
                sum = sum.min(best);
            }
            if fewest.is_some_and(|fewest| step >= fewest + if self.by_sum { LATER_STEPS } else { 0 }) {
                break;
            }
            let mut next: HashSet<Vec<Stand>> = HashSet::new();
            for stands in &now {
                for moved in self.moves(&dues, stands, step + 1) {
                    // With sums, the same places with later last moves are other states.
                    if self.by_sum || met.insert(moved.clone()) {
                        next.insert(moved);
                    }
                }
                if next.len() > MOST_STATES {
                    return None;
                }
            }
            if next.is_empty() {
                return Some(fewest.map(|fewest| (fewest, sum)).ok_or(()));
            }
            now = next;
        }
        if fewest.is_none() && self.by_sum {
            // The instants of moves make every state a new one; without them it is known whether there is any plan.
            let by_steps = Assay { by_sum: false, ..self.clone() };
            return by_steps.least().filter(Result::is_err);
        }
        fewest.map(|fewest| Ok((fewest, sum)))
    }

    fn is_end(&self, dues: &[Vec<Due>], stands: &[Stand]) -> bool {
        stands.iter().enumerate().all(|(part, stand)| match stand {
            None => true,
            Some((cell, done, _, _)) => {
                let home = dues[part].last().map_or(self.parts[part], |due| due.at);
                *done == dues[part].len() && *cell == home
            }
        })
    }

    /// All places of all parts after one step.
    fn moves(&self, dues: &[Vec<Due>], stands: &[Stand], instant: u64) -> Vec<Vec<Stand>> {
        let mut all: Vec<Vec<Stand>> = vec![Vec::new()];
        for (part, stand) in stands.iter().enumerate() {
            let mut grown = Vec::new();
            for before in &all {
                for cell in self.targets(dues, part, *stand) {
                    let free =
                        (0..part).all(|other| self.keep_apart(dues, stands, (part, cell), (other, before[other])));
                    if !free {
                        continue;
                    }
                    let next = stand.zip(cell).map(|((from, done, rested, moved), to)| {
                        let moved = if from != to && self.by_sum { instant } else { moved };
                        let rested = if from == to { rested + 1 } else { 0 };
                        (to, done, rested, moved)
                    });
                    let mut after = before.clone();
                    after.push(next);
                    grown.push(after);
                }
            }
            all = grown;
        }
        all.into_iter().flat_map(|after| self.settled(dues, after)).collect()
    }

    /// What is done by now, in all ways in which reservoirs then begin to dispense, where nothing is near their outlets.
    fn settled(&self, dues: &[Vec<Due>], mut stands: Vec<Stand>) -> Vec<Vec<Stand>> {
        settle(dues, &mut stands);
        let mut all = vec![stands];
        for (part, dues) in dues.iter().enumerate() {
            let Some(outlet) = dues.first().filter(|due| due.is_dispensed).map(|due| due.at) else { continue };
            for before in all.clone() {
                let is_due = before[part].is_some_and(|(cell, ..)| cell == NOWHERE);
                let mut there = before.iter().flatten().filter(|(cell, ..)| *cell != NOWHERE);
                if is_due && there.all(|(cell, ..)| apart(*cell, outlet) >= self.separation) {
                    let mut after = before;
                    after[part] = Some((outlet, 0, 0, 0));
                    all.push(after);
                }
            }
        }
        all
    }

    fn targets(&self, dues: &[Vec<Due>], part: usize, stand: Stand) -> Vec<Option<Cell>> {
        let Some((cell, ..)) = stand else { return vec![None] };
        let next = dues[part].get(stand.map_or(0, |(_, done, ..)| done));
        // A droplet comes out of its reservoir first, and stays where it is to merge.
        let stays = next.is_some_and(|due| due.is_dispensed || (due.merge.is_some() && due.at == cell));
        if cell == NOWHERE || stays || (dues[part].is_empty() && !self.may_yield) {
            return vec![Some(cell)];
        }
        let beside = [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)].map(|(c, r)| (cell.0 + c, cell.1 + r));
        beside.into_iter().filter(|cell| self.is_free(*cell)).map(Some).collect()
    }

    /// Whether two parts keep apart wherever they are in a step, but where they merge.
    fn keep_apart(
        &self,
        dues: &[Vec<Due>],
        stands: &[Stand],
        (part, to): (usize, Option<Cell>),
        (other, other_to): (usize, Stand),
    ) -> bool {
        let (Some((from, done, ..)), Some((other_from, other_done, ..))) = (stands[part], stands[other]) else {
            return true;
        };
        let (Some(to), Some((other_to, ..))) = (to, other_to) else { return true };
        if from == NOWHERE || other_from == NOWHERE {
            return true;
        }
        let due = |part: usize, done: usize| dues[part].get(done).and_then(|due| Some((due.at, due.merge?.0)));
        let meet = due(part, done).filter(|own| due(other, other_done) == Some(*own));
        let ways = |from: Cell, to: Cell| match meet {
            Some((at, _)) => [from, to].into_iter().filter(|cell| *cell != at).collect(),
            None => vec![from, to],
        };
        let others: Vec<Cell> = ways(other_from, other_to);
        ways(from, to).iter().all(|one| others.iter().all(|other| apart(*one, *other) >= self.separation))
    }
}

/// What is done by now.
fn settle(dues: &[Vec<Due>], stands: &mut [Stand]) {
    let due = |stand: Stand, part: usize| stand.and_then(|(_, done, _, _)| dues[part].get(done).copied());
    loop {
        let ready = (0..stands.len()).find_map(|part| {
            let (cell, _, rested, _) = stands[part]?;
            let own = due(stands[part], part).filter(|own| own.at == cell && rested >= own.stay)?;
            let other = match own.merge {
                None => None,
                Some((number, other)) => {
                    let theirs = due(stands[other], other)?;
                    let there = stands[other].is_some_and(|(at, ..)| at == cell);
                    Some((theirs.merge?.0 == number && there).then_some(other)?)
                }
            };
            Some((part, own, other))
        });
        let Some((part, own, other)) = ready else { break };
        for (one, is_gone) in std::iter::once((part, own.is_gone)).chain(other.map(|other| (other, !own.is_gone))) {
            stands[one] = stands[one].filter(|_| !is_gone).map(|(cell, done, _, moved)| (cell, done + 1, 0, moved));
        }
    }
    for (part, stand) in stands.iter_mut().enumerate() {
        let next = due(*stand, part);
        if let Some((cell, _, rested, _)) = stand {
            // Rest counts only where the next thing is to be done, and no longer than that takes.
            *rested = next.filter(|next| next.at == *cell).map_or(0, |next| (*rested).min(next.stay));
        }
    }
}

#[test]
fn no_plan_of_an_assay_beats_its_bound() {
    let cases = std::env::var("TWEEZE_ORACLE_CASES").ok().and_then(|cases| cases.parse().ok()).unwrap_or(60);
    let (mut chance, mut judged, mut planned, mut missed, mut optimal) = (Random(5), 0, 0, 0, 0);
    let (mut none, mut proven) = (0, 0);
    let mut tries = 0;
    while judged < cases && tries < 60 * cases {
        tries += 1;
        let Some(assay) = Assay::random(&mut chance) else { continue };
        let text = assay.text();
        let answer = answered(&text);
        if matches!(answer, Answered::Unfit) {
            continue;
        }
        let Some(truth) = assay.least() else { continue };
        judged += 1;
        match (answer, truth) {
            (Answered::Plan(plan), Ok((steps, sum))) => {
                planned += 1;
                let reached = plan.outcomes["steps"] as u64;
                assert!(reached >= steps, "{reached} steps, the fewest are {steps}: {text}");
                let (least, truth) = if assay.by_sum { (plan.bound, sum) } else { (plan.bound, steps) };
                // The sums of the oracle leave out parts that are gone.
                let stays = |due: &Due| due.merge.is_none() && !due.is_gone;
                let has_sum = assay.by_sum && assay.dues().iter().flatten().all(stays);
                if !assay.by_sum || has_sum {
                    assert!(least <= truth as f64, "bound {least}, but there is a plan of {truth}: {text}");
                }
                let other = plan.bounds.get("steps").copied().unwrap_or(0.0);
                assert!(other <= steps as f64, "bound {other} of the steps, {steps} do: {text}");
                optimal += usize::from(plan.proof == Optimality::Proven);
            }
            (Answered::Plan(plan), Err(())) => {
                panic!("a plan of {} steps where there is none: {text}", plan.outcomes["steps"])
            }
            (Answered::Errors(errors), Ok((steps, _))) => {
                assert!(errors.iter().all(|error| error.starts_with("E0602")), "{errors:?}, {steps} steps do: {text}");
                missed += 1;
            }
            (Answered::Errors(errors), Err(())) => {
                none += 1;
                proven += usize::from(errors.iter().any(|error| error.starts_with("E0601")));
            }
            (Answered::Unfit, _) => {}
        }
    }
    println!(
        "{judged} assays: {planned} planned, {optimal} proven optimal, {missed} missed, {none} without a plan, {proven} of them proven"
    );
    assert!(judged >= cases, "{judged} judged");
    assert_eq!(missed, 0, "{missed} of {planned} assays that have a plan got none");
    assert_eq!(proven, none, "{proven} of {none} assays without a plan proven to have none");
    assert!(optimal * 4 >= planned * 3, "{optimal} of {planned} plans proven optimal");
}
