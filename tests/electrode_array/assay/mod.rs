//! Assays compared with brute force: random programs on tiny boards, and every possible plan of each.
//!
//! The truth is found without the planner and the verifier: instant by instant, all joint positions with what each part
//! has done by then, until everything is done. `TWEEZE_ORACLE_CASES=1000` runs 1000 assays.

mod crowds;
mod program;
mod traces;

use crate::pins::Droplet;
use crate::programs::{Answered, answered};
use crate::scenes::Random;
use crate::scenes::random::cases;
use program::{Assay, Cell, NOWHERE, Operation, apart};
use std::collections::HashSet;
use traces::Traces;
use tweeze::plan::Optimality;

/// Greatest number of joint states at one instant; a board with more is not searched.
const MOST_STATES: usize = 60_000;

/// Longer plans are not considered.
const MOST_STEPS: u64 = 40;

/// Number of steps after the shortest plan in which plans with a smaller sum of costs are searched for.
const LATER_STEPS: u64 = 2;

/// The next thing that a part must do: where, for how many steps, and, for a merge, its number and the other part.
#[derive(Clone, Copy, Debug)]
struct Due {
    at: Cell,
    stay: u64,
    merge: Option<(usize, usize)>,
    is_gone: bool,
    is_dispensed: bool,
    /// It is mixed for these steps instead of resting.
    is_mixed: bool,
    /// A half that comes out of it on the way: the cell of the split, the half's part, and the half's destination.
    split: Option<(Cell, usize, Cell)>,
    /// A part, and how many of its dues must be done before this one begins.
    after: Option<(usize, usize)>,
}

impl Due {
    fn at(at: Cell) -> Due {
        Due { at, stay: 0, merge: None, is_gone: false, is_dispensed: false, is_mixed: false, split: None, after: None }
    }

    /// Whether the part that it comes after is far enough; a part that is gone has done everything.
    fn may_begin(&self, stands: &[Stand]) -> bool {
        self.after.is_none_or(|(part, count)| stands[part].is_none_or(|(_, done, ..)| done >= count))
    }
}

/// A part at an instant: its cell, the number of dues done, the steps spent at the place of the next due, and the
/// instant of its last move; `None` once it is gone.
type Stand = Option<(Cell, usize, u64, u64)>;

/// A joint state: where all parts are; the traces on the cells, if they matter; for each [`Wait`] the steps since it
/// began, if it has; and the sum of the last move instants of the parts that are gone.
#[derive(Clone, PartialEq, Eq, Hash)]
struct AssayPosition {
    stands: Vec<Stand>,
    left: Vec<u32>,
    waiting: Vec<Option<u64>>,
    gone: u64,
}

/// A time limit: at most `most` steps from the instant at which a part has done a number of dues (`from`) to the
/// instant at which another one has (`to`).
#[derive(Clone, Copy, Debug)]
struct Wait {
    from: (usize, usize),
    to: (usize, usize),
    most: u64,
}

/// A split in a step: the part, the half that comes out of it, and the half's start and destination.
type Pulled = (usize, usize, [Cell; 2]);

/// Action of a part in a step.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    /// Goes to a cell, or stays.
    To(Cell),
    /// Continues or begins its mixing loop.
    Round(Cell),
    /// Is split, and goes to a cell.
    Split(Cell),
}

impl Way {
    fn end(self) -> Cell {
        match self {
            Way::To(cell) | Way::Round(cell) | Way::Split(cell) => cell,
        }
    }
}

impl Assay {
    /// The dues of each part, in order.
    fn dues(&self) -> Vec<Vec<Due>> {
        let mut dues: Vec<Vec<Due>> = vec![Vec::new(); self.parts.len()];
        for (number, operation) in self.operations.iter().enumerate() {
            let before: Vec<usize> = dues.iter().map(Vec::len).collect();
            match operation {
                Operation::Move(part, stops) => {
                    dues[*part].extend(stops.iter().map(|at| Due::at(*at)));
                }
                Operation::Incubate(part, at, stay) => {
                    let here = dues[*part].last().map_or(self.parts[*part], |due| due.at);
                    dues[*part].push(Due { stay: *stay, ..Due::at(at.unwrap_or(here)) });
                }
                Operation::Mix(part, at, steps) => {
                    let here = dues[*part].last().map_or(self.parts[*part], |due| due.at);
                    let round = 2 * (self.mixer.0 + self.mixer.1 - 2) as u64;
                    let stay = (1..).map(|rounds| rounds * round).find(|stay| stay >= steps).unwrap_or(round);
                    dues[*part].push(Due { stay, is_mixed: true, ..Due::at(at.unwrap_or(here)) });
                }
                Operation::Split(half, part, at, to) => {
                    let opposite = (2 * at.0 - to.0, 2 * at.1 - to.1);
                    dues[*part].push(Due::at(*at));
                    dues[*part].push(Due { split: Some((*at, *half, *to)), ..Due::at(opposite) });
                    dues[*half].push(Due::at(*to));
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
            let after = self.afters[number].map(|part| (part, before[part]));
            for part in operation.parts() {
                if let Some(last) = dues[part].last_mut() {
                    last.after = after;
                }
            }
        }
        dues
    }

    /// The time limits of the assay.
    fn waits(&self, dues: &[Vec<Due>]) -> Vec<Wait> {
        let mut counts = vec![0; self.parts.len()];
        let mut waits = Vec::new();
        for (number, operation) in self.operations.iter().enumerate() {
            let before = counts.clone();
            match operation {
                Operation::Move(part, stops) => counts[*part] += stops.len(),
                Operation::Split(half, part, ..) => {
                    counts[*part] += 2;
                    counts[*half] += 1;
                }
                Operation::Merge(part, with, _) => [*part, *with].iter().for_each(|part| counts[*part] += 1),
                Operation::Incubate(part, ..)
                | Operation::Mix(part, ..)
                | Operation::Discard(part, _)
                | Operation::Dispense(part, _) => counts[*part] += 1,
            }
            let Some((first, most)) = self.withins.get(number).copied().flatten() else { continue };
            let own = operation.parts()[0];
            let due = dues[own][counts[own] - 1];
            let takes = if due.split.is_some() { 1 } else { due.stay };
            waits.push(Wait { from: (first, before[first]), to: (own, counts[own]), most: most + takes });
        }
        waits
    }

    /// The fewest steps of any plan, and the smallest sum of costs of plans that take few more steps. The inner result
    /// is an error if there is no plan; the outer is `None` if there are too many states or steps.
    fn least(&self) -> Option<Result<(u64, u64), ()>> {
        let (dues, traces) = (self.dues(), Traces::of(self));
        let start: Vec<Stand> = self.parts.iter().map(|cell| Some((*cell, 0, 0, 0))).collect();
        let waits = self.waits(&dues);
        let clean =
            AssayPosition { stands: start.clone(), left: traces.clean(), waiting: vec![None; waits.len()], gone: 0 };
        let start = self.arrived(&dues, &traces, &waits, &clean, start);
        let (mut now, mut met) = (HashSet::from_iter(start), HashSet::new());
        let (mut fewest, mut sum) = (None, u64::MAX);
        for step in 0..=MOST_STEPS {
            let ended = now.iter().filter(|position| self.is_end(&dues, &position.stands));
            let best = ended.map(|position| position.gone + moved_last(&position.stands)).min();
            if let Some(best) = best {
                fewest = fewest.or(Some(step));
                sum = sum.min(best);
            }
            if fewest.is_some_and(|fewest| step >= fewest + if self.by_sum { LATER_STEPS } else { 0 }) {
                break;
            }
            let mut next: HashSet<AssayPosition> = HashSet::new();
            for position in &now {
                for moved in self.moves(&dues, &position.stands, step + 1) {
                    for there in self.arrived(&dues, &traces, &waits, position, moved) {
                        // For the sum of costs, the same places with later last moves are different states.
                        if self.by_sum || met.insert(there.clone()) {
                            next.insert(there);
                        }
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
            // The instants of moves make every state a new one; without them the search can decide whether there is any
            // plan.
            let by_steps = Assay { by_sum: false, ..self.clone() };
            return by_steps.least().filter(Result::is_err);
        }
        fewest.map(|fewest| Ok((fewest, sum)))
    }

    /// As [`Self::least`] over all choices of places: the fewest steps of any, and the smallest sum of any.
    fn least_of_all(&self) -> Option<Result<(u64, u64), ()>> {
        let each: Option<Vec<Result<(u64, u64), ()>>> = self.arrangements().iter().map(Assay::least).collect();
        let least = |one: (u64, u64), other: (u64, u64)| (one.0.min(other.0), one.1.min(other.1));
        Some(each?.into_iter().filter_map(Result::ok).reduce(least).ok_or(()))
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

    /// The positions after parts have moved and done what they do there, for each choice of reservoirs that begin to
    /// dispense; those with contamination are dropped.
    fn arrived(
        &self,
        dues: &[Vec<Due>],
        traces: &Traces,
        waits: &[Wait],
        before: &AssayPosition,
        stands: Vec<Stand>,
    ) -> Vec<AssayPosition> {
        let cells: Vec<Option<Cell>> = stands.iter().map(|stand| stand.map(|(cell, ..)| cell)).collect();
        let moved = moved_last(&stands);
        let settled = self.settled(dues, stands).into_iter();
        let position = |stands: Vec<Stand>| {
            let waiting = still_waiting(waits, &stands, &before.waiting)?;
            let gone = before.gone + moved - moved_last(&stands);
            let left = traces.left(&cells, &stands, &before.left)?;
            Some(AssayPosition { stands, left, waiting, gone })
        };
        settled.filter_map(position).collect()
    }

    /// All places of all parts after one step, before anything is done there.
    fn moves(&self, dues: &[Vec<Due>], stands: &[Stand], instant: u64) -> Vec<Vec<Stand>> {
        let mut all: Vec<(Vec<Stand>, Vec<Pulled>)> = vec![(Vec::new(), Vec::new())];
        for (part, stand) in stands.iter().enumerate() {
            let mut grown = Vec::new();
            for (before, splits) in &all {
                for way in self.targets(dues, stands, part) {
                    let cell = way.map(Way::end);
                    let free = (0..part).all(|other| self.keep_apart(dues, stands, part, cell, other, before[other]));
                    if !free {
                        continue;
                    }
                    let next = stand.zip(way).map(|((from, done, rested, moved), way)| {
                        let to = way.end();
                        let moved = if from != to && self.by_sum { instant } else { moved };
                        // A rest does not count while the parts that it comes after are not far enough.
                        let counts = |due: &Due| !due.is_mixed && due.may_begin(stands);
                        let counts = dues[part].get(done).is_none_or(counts);
                        match way {
                            Way::To(_) if from == to && counts => (to, done, rested + 1, moved),
                            Way::To(_) => (to, done, 0, moved),
                            Way::Round(_) => (to, done, rested + 1, moved),
                            Way::Split(_) => (to, done + 1, 0, moved),
                        }
                    });
                    let (mut after, mut splits) = (before.clone(), splits.clone());
                    if let (Some(Way::Split(_)), Some((_, done, ..))) = (way, *stand)
                        && let Some((from, half, to)) = dues[part][done].split
                    {
                        splits.push((part, half, [from, to]));
                    }
                    after.push(next);
                    grown.push((after, splits));
                }
            }
            all = grown;
        }
        let allowed = |(after, splits): (Vec<Stand>, Vec<Pulled>)| {
            let after = self.with_halves(stands, after, &splits)?;
            let droplets = self.pins.as_ref().map(|pins| (pins, self.droplets(dues, stands, &after, &splits)));
            droplets.is_none_or(|(pins, droplets)| pins.allow(&droplets, |_| true)).then_some(after)
        };
        all.into_iter().filter_map(allowed).collect()
    }

    /// All droplets on the board in a step, in the form for shared channels.
    fn droplets(&self, dues: &[Vec<Due>], stands: &[Stand], after: &[Stand], splits: &[Pulled]) -> Vec<Droplet> {
        let end = |part: usize| after[part].map(|(cell, ..)| cell);
        let meet = |part: usize| {
            let due = dues[part].get(stands[part]?.1).filter(|due| due.may_begin(stands))?;
            due.merge
        };
        let of_part = |part: usize| {
            let to = end(part).filter(|cell| *cell != NOWHERE)?;
            if let Some((own, _, [from, _])) = splits.iter().find(|(_, half, _)| *half == part) {
                return Some(Droplet { from: *from, to, partner: end(*own), is_split: true });
            }
            let from = stands[part].map(|(cell, ..)| cell).filter(|cell| *cell != NOWHERE)?;
            if let Some((_, half, _)) = splits.iter().find(|(own, ..)| *own == part) {
                return Some(Droplet { from, to, partner: end(*half), is_split: true });
            }
            let other = meet(part).filter(|(number, other)| meet(*other).is_some_and(|theirs| theirs.0 == *number));
            Some(Droplet { from, to, partner: other.and_then(|(_, other)| end(other)), is_split: false })
        };
        (0..after.len()).filter_map(of_part).collect()
    }

    /// The places after a step with splits; `None` unless the halves keep the separation from all other parts
    /// throughout the step.
    fn with_halves(&self, stands: &[Stand], mut after: Vec<Stand>, splits: &[Pulled]) -> Option<Vec<Stand>> {
        for (part, half, ways) in splits {
            for other in (0..after.len()).filter(|other| other != part && other != half) {
                let of_split = splits.iter().find(|(_, half, _)| *half == other).map(|(.., ways)| *ways);
                let there = [stands[other], after[other]].map(|stand| stand.map(|(cell, ..)| cell));
                let theirs = of_split.or(there[0].zip(there[1]).map(|(from, to)| [from, to]));
                let theirs = theirs.into_iter().flatten().filter(|cell| *cell != NOWHERE);
                if theirs.into_iter().any(|cell| ways.iter().any(|own| apart(*own, cell) < self.separation)) {
                    return None;
                }
            }
        }
        for (_, half, [_, to]) in splits {
            after[*half] = Some((*to, 0, 0, 0));
        }
        Some(after)
    }

    /// Completes all dues, for each choice of reservoirs that then begin to dispense; a reservoir begins only if
    /// nothing is near its outlet.
    fn settled(&self, dues: &[Vec<Due>], mut stands: Vec<Stand>) -> Vec<Vec<Stand>> {
        settle(dues, &mut stands);
        let mut all = vec![stands];
        for (part, dues) in dues.iter().enumerate() {
            let Some(outlet) = dues.first().filter(|due| due.is_dispensed).map(|due| due.at) else { continue };
            for before in all.clone() {
                let may_begin = dues[0].may_begin(&before);
                let is_due = may_begin && before[part].is_some_and(|(cell, ..)| cell == NOWHERE);
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

    fn targets(&self, dues: &[Vec<Due>], stands: &[Stand], part: usize) -> Vec<Option<Way>> {
        let stand = stands[part];
        let Some((cell, _, rested, _)) = stand else { return vec![None] };
        let next = dues[part].get(stand.map_or(0, |(_, done, ..)| done));
        // A dispensed droplet stays until it has come out of its reservoir.
        let stays = next.is_some_and(|due| due.is_dispensed);
        if cell == NOWHERE || stays || (dues[part].is_empty() && !self.may_yield) {
            return vec![Some(Way::To(cell))];
        }
        let round = next.filter(|due| due.is_mixed && (rested > 0 || due.at == cell)).map(|due| {
            // Right, up, left and down, around the loop.
            let (c, r) = (cell.0 - due.at.0, cell.1 - due.at.1);
            let (columns, rows) = (self.mixer.0 - 1, self.mixer.1 - 1);
            match (c, r) {
                (c, 0) if c < columns => (cell.0 + 1, cell.1),
                (c, r) if c == columns && r < rows => (cell.0, cell.1 + 1),
                (c, r) if r == rows && c > 0 => (cell.0 - 1, cell.1),
                _ => (cell.0, cell.1 - 1),
            }
        });
        let may_begin = next.is_none_or(|due| due.may_begin(stands));
        let round = round.filter(|to| may_begin && self.is_free(to.0, to.1)).map(Way::Round);
        if rested > 0 && next.is_some_and(|due| due.is_mixed) {
            return round.into_iter().map(Some).collect();
        }
        let split = next.filter(|due| may_begin && due.split.is_some_and(|(from, ..)| from == cell));
        let split = split.map(|due| Way::Split(due.at));
        let beside = [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)].map(|(c, r)| (cell.0 + c, cell.1 + r));
        let plain = beside.into_iter().filter(|(column, row)| self.is_free(*column, *row)).map(Way::To);
        plain.chain(round).chain(split).map(Some).collect()
    }

    /// Whether two parts keep the separation throughout a step, except where they merge. A part that leaves that place
    /// again keeps the separation there too.
    fn keep_apart(
        &self,
        dues: &[Vec<Due>],
        stands: &[Stand],
        part: usize,
        to: Option<Cell>,
        other: usize,
        other_to: Stand,
    ) -> bool {
        let (Some((from, done, ..)), Some((other_from, other_done, ..))) = (stands[part], stands[other]) else {
            return true;
        };
        let (Some(to), Some((other_to, ..))) = (to, other_to) else { return true };
        if from == NOWHERE || other_from == NOWHERE {
            return true;
        }
        let due = |part: usize, done: usize| {
            let due = dues[part].get(done).filter(|due| due.may_begin(stands))?;
            Some((due.at, due.merge?.0))
        };
        let meet = due(part, done).filter(|own| due(other, other_done) == Some(*own));
        let ways = |from: Cell, to: Cell| match meet {
            Some((at, _)) if to == at => [from].into_iter().filter(|cell| *cell != at).collect(),
            Some(_) | None => vec![from, to],
        };
        let others: Vec<Cell> = ways(other_from, other_to);
        ways(from, to).iter().all(|one| others.iter().all(|other| apart(*one, *other) >= self.separation))
    }
}

/// The steps since each wait began, one step later; `None` if a time limit is exceeded.
fn still_waiting(waits: &[Wait], stands: &[Stand], before: &[Option<u64>]) -> Option<Vec<Option<u64>>> {
    let has = |(part, count): (usize, usize)| stands[part].is_none_or(|(_, done, ..)| done >= count);
    let step = |(wait, before): (&Wait, &Option<u64>)| {
        if has(wait.to) || !has(wait.from) {
            return Some(None);
        }
        let now = before.map_or(0, |before| before + 1);
        (now < wait.most).then_some(Some(now))
    };
    waits.iter().zip(before).map(step).collect()
}

/// Marks all dues as done that are complete by now.
fn settle(dues: &[Vec<Due>], stands: &mut [Stand]) {
    let due = |stand: Stand, part: usize| stand.and_then(|(_, done, _, _)| dues[part].get(done).copied());
    loop {
        let ready = (0..stands.len()).find_map(|part| {
            let (cell, _, rested, _) = stands[part]?;
            let is_done = |own: &Due| own.at == cell && rested >= own.stay && own.split.is_none();
            let own = due(stands[part], part).filter(is_done).filter(|own| own.may_begin(stands))?;
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
            // A rest counts only at the place of the next due, and at most for its duration.
            *rested = next.filter(|next| next.is_mixed || next.at == *cell).map_or(0, |next| (*rested).min(next.stay));
        }
    }
}

/// The sum of the instants of the parts' last moves.
fn moved_last(stands: &[Stand]) -> u64 {
    stands.iter().flatten().map(|(_, _, _, moved)| moved).sum()
}

#[test]
fn no_plan_of_an_assay_beats_its_bound() {
    let [planned, split, mixed, clean] = agree(Random::new(5), 20, |_, assay| assay);
    assert!(20 * split > planned && 20 * mixed > planned, "{split} with splits, {mixed} with mixing");
    assert!(20 * clean > planned, "{clean} with `avoid`");
}

/// As above, with operations that must begin soon after others.
#[test]
fn assays_in_a_hurry_agree_with_brute_force() {
    agree(Random::new(11), 10, |chance, assay| assay.hurried(chance));
}

/// As above, on boards whose channels switch several electrodes.
#[test]
fn assays_on_shared_channels_agree_with_brute_force() {
    agree(Random::new(17), 30, |chance, assay| assay.pinned(chance));
}

/// As above, on boards on which parts leave at outlets where others are dispensed.
#[test]
fn assays_that_leave_at_outlets_agree_with_brute_force() {
    let [planned, .., clean] = agree(Random::new(41), 12, |chance, assay| assay.at_outlets(chance));
    assert!(2 * clean > planned, "{clean} with `avoid`");
}

/// As above, with places that the plan chooses: the truth is the best over all choices.
#[test]
fn assays_at_places_of_choice_agree_with_brute_force() {
    agree(Random::new(29), 5, |chance, assay| assay.opened(chance));
}

/// Compares `usual` assays, or as many as requested, with brute force; returns the numbers of plans found, and of those
/// with splits, with mixing, and with avoided traces.
fn agree(mut chance: Random, usual: usize, changed: fn(&mut Random, Assay) -> Assay) -> [usize; 4] {
    let cases = cases(usual);
    let (mut judged, mut planned, mut missed, mut optimal) = (0, 0, 0, 0);
    let (mut none, mut proven, mut split, mut mixed, mut ordered, mut clean, mut summed) = (0, 0, 0, 0, 0, 0, 0);
    let mut tries = 0;
    while judged < cases && tries < 60 * cases {
        tries += 1;
        let Some(assay) = Assay::random(&mut chance) else { continue };
        let assay = changed(&mut chance, assay);
        if !assay.among.is_empty() && assay.among.iter().all(Vec::is_empty) {
            continue;
        }
        let text = assay.text();
        let answer = answered(&text);
        if matches!(answer, Answered::Unfit) {
            continue;
        }
        let Some(truth) = assay.least_of_all() else { continue };
        judged += 1;
        match (answer, truth) {
            (Answered::Plan(plan), Ok((steps, sum))) => {
                planned += 1;
                let has = |is: fn(&Operation) -> bool| usize::from(assay.operations.iter().any(is));
                split += has(|operation| matches!(operation, Operation::Split(..)));
                mixed += has(|operation| matches!(operation, Operation::Mix(..)));
                ordered += usize::from(assay.afters.iter().any(Option::is_some));
                clean += usize::from(!assay.avoided.is_empty());
                let reached = plan.outcomes["steps"] as u64;
                assert!(reached >= steps, "{reached} steps, the fewest are {steps}: {text}");
                let (least, truth) = if assay.by_sum { (plan.bound, sum) } else { (plan.bound, steps) };
                assert!(least <= truth as f64, "bound {least}, but there is a plan of {truth}: {text}");
                summed += usize::from(assay.by_sum && plan.proof == Optimality::Proven);
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
        "{judged} assays: {planned} planned, {split} with splits, {mixed} with mixing, {ordered} with `after`, {clean} with `avoid`, {optimal} proven optimal, {summed} of them by their sum, {missed} missed, {none} without a plan, {proven} of them proven"
    );
    assert!(judged >= cases, "{judged} judged");
    assert!(20 * ordered > planned, "{ordered} with `after`");
    assert_eq!(missed, 0, "{missed} of {planned} assays that have a plan got none");
    assert_eq!(proven, none, "{proven} of {none} assays without a plan proven to have none");
    assert!(optimal * 4 >= planned * 3, "{optimal} of {planned} plans proven optimal");
    [planned, split, mixed, clean]
}
