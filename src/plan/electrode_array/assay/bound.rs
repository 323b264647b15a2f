//! Lower bounds on every plan of an assay.
//!
//! Three of them. Each errand ends no earlier than its agent alone could have done it, and those that meet wait for one another (the
//! critical path). Agents that stay at one stop take turns: between two of them lie the steps in which the first moves out of the way.
//! So do those that are moved round a loop in which two are always in each other's way before the round is over, also with those that
//! stay at its corner for as long as that. And of several stops whose agents come at few places, one has to wait for its first.

use super::route::Ahead;
use super::{AssayProblem, Errand, ErrandPlace};
use crate::plan::electrode_array::board::{BoardCosts, BoardGrid, CellIndex};
use std::collections::{BTreeMap, BTreeSet};

/// An errand with its earliest start and end, and the least time from its end to the end of the assay.
#[derive(Debug, Clone, Copy)]
struct TimedErrand {
    errand: Errand,
    /// Its agent's first instant at the stop, if nothing stands in the way,
    arrival: u64,
    /// and the first at which the one that it meets there can be there too.
    head: u64,
    tail: u64,
}

/// What holds for every plan.
pub(super) struct AssayBounds {
    /// Lower bounds of the steps and of the sum of costs.
    pub costs: BoardCosts,
    /// By agent and errand: least steps from the end of it to the end of all that must come after it.
    pub after: Vec<Vec<u32>>,
    /// By agent and errand: the earliest instant at which it can begin.
    pub heads: Vec<Vec<u32>>,
}

pub(super) fn least(problem: &AssayProblem, ahead: &Ahead) -> AssayBounds {
    let timed = timed(problem, ahead);
    let alone = timed.iter().flatten().map(|one| one.head + u64::from(one.errand.stay)).max().unwrap_or(0);
    let room = |around: &Vec<CellIndex>| LoopRoom::of(&problem.instance.board, problem.instance.separation, around);
    let rooms: Vec<LoopRoom> = problem.loops.iter().map(room).collect();
    let mut stays: BTreeMap<TurnPlace, Vec<(usize, TimedErrand)>> = BTreeMap::new();
    for (agent, errands) in timed.iter().enumerate() {
        for one in errands.iter().filter(|one| one.errand.stay > 0) {
            for place in TurnPlace::all(problem, &one.errand, &rooms) {
                stays.entry(place).or_default().push((agent, *one));
            }
        }
    }
    let drops = drops(problem);
    let turns = stays.iter().map(|(place, stays)| in_turns(problem, *place, stays, &drops)).max().unwrap_or(0);
    let turns = turns.max(stays.iter().map(|(place, stays)| comings(problem, *place, stays)).max().unwrap_or(0));
    let turns = turns.max(firsts(problem, ahead, &stays, &drops));
    let arrivals = timed.iter().enumerate().map(|(agent, errands)| last_arrival(problem, agent, errands));
    let costs = BoardCosts { makespan: alone.max(turns), sum_of_costs: arrivals.sum() };
    let each = |of: &dyn Fn(&TimedErrand) -> u64| {
        let steps = |one: &TimedErrand| u32::try_from(of(one)).unwrap_or(u32::MAX);
        timed.iter().map(|errands| errands.iter().map(steps).collect()).collect()
    };
    AssayBounds { costs, after: each(&|one| one.tail), heads: each(&|one| one.head) }
}

/// The earliest start of each errand, with those that meet at the same instant.
fn timed(problem: &AssayProblem, ahead: &Ahead) -> Vec<Vec<TimedErrand>> {
    let agents = &problem.instance.agents;
    let mut arrivals: Vec<Vec<u64>> = vec![Vec::new(); agents.len()];
    let mut heads = arrivals.clone();
    let changes = changes(problem);
    let way = |agent: usize, index: usize| way(problem, ahead, agent, index);
    // An agent waits for the other where they meet; every round completes at least one errand.
    let mut order: Vec<(usize, usize)> = Vec::new();
    loop {
        let before = order.len();
        for agent in 0..agents.len() {
            let Some(comes) = given_off(problem, agent, &heads) else { continue };
            while heads[agent].len() < problem.errands[agent].len() {
                let index = heads[agent].len();
                let since = index
                    .checked_sub(1)
                    .map_or(comes, |last| heads[agent][last] + u64::from(problem.errands[agent][last].stay));
                let arrival = since + way(agent, index);
                let Some(begins) = begins(problem, agent, index, &heads, &changes) else { break };
                let mut head = arrival.max(begins);
                if let Some(other) = problem.errands[agent][index].meets {
                    let partner = problem.partner(ErrandPlace { agent, errand: index });
                    // Known once all before it are timed.
                    let theirs = partner.map(|place| place.errand).filter(|place| heads[other].len() >= *place);
                    let Some(theirs) = theirs else { break };
                    let Some(comes) = given_off(problem, other, &heads) else { break };
                    let since = theirs
                        .checked_sub(1)
                        .map_or(comes, |last| heads[other][last] + u64::from(problem.errands[other][last].stay));
                    head = head.max(since + way(other, theirs));
                }
                arrivals[agent].push(arrival);
                heads[agent].push(head);
                order.push((agent, index));
            }
        }
        if order.len() == before {
            break;
        }
    }
    order.sort_by_key(|(agent, index)| heads[*agent][*index]);
    let tails = tails(problem, ahead, &order, &changes);
    let of = |agent: usize| {
        let timed = |(index, errand): (usize, &Errand)| TimedErrand {
            errand: *errand,
            arrival: arrivals[agent][index],
            head: heads[agent][index],
            tail: tails[agent][index],
        };
        problem.errands[agent].iter().enumerate().map(timed).collect()
    };
    (0..agents.len()).map(of).collect()
}

/// The earliest instant at which all is done that an errand comes after; `None` while that is not known.
fn begins(
    problem: &AssayProblem,
    agent: usize,
    index: usize,
    heads: &[Vec<u64>],
    changes: &ErrandChanges,
) -> Option<u64> {
    let done = |before: &ErrandPlace| {
        let head = heads[before.agent].get(before.errand)?;
        Some(head + u64::from(problem.errands[before.agent][before.errand].stay))
    };
    let mut before = problem.afters[agent][index].iter().zip(&changes[agent][index]);
    before.try_fold(0, |last, (before, change)| Some(last.max(done(before)? + change)))
}

/// By agent and errand, for each errand that it comes after, the least steps from the end of that one to its beginning: who is done at the
/// stop of the next one has to make room.
type ErrandChanges = Vec<Vec<Vec<u64>>>;

fn changes(problem: &AssayProblem) -> ErrandChanges {
    let drops = drops(problem);
    let mut at_stop: BTreeMap<CellIndex, u64> = BTreeMap::new();
    let mut between = |before: &ErrandPlace, (agent, index): (usize, usize)| {
        let (done, next) = (problem.errands[before.agent][before.errand], problem.errands[agent][index]);
        let leaves = problem.is_gone[before.agent] && before.errand + 1 == problem.errands[before.agent].len();
        let makes_room = done.stop == next.stop && drops[before.agent] != drops[agent];
        if !makes_room || leaves || done.splits.is_some() {
            return 0;
        }
        *at_stop.entry(next.stop).or_insert_with(|| change(problem, next.stop))
    };
    let mut of = |agent: usize, index: usize, afters: &Vec<ErrandPlace>| -> Vec<u64> {
        afters.iter().map(|before| between(before, (agent, index))).collect()
    };
    let of_agent = |(agent, afters): (usize, &Vec<Vec<ErrandPlace>>)| {
        afters.iter().enumerate().map(|(index, afters)| of(agent, index, afters)).collect()
    };
    problem.afters.iter().enumerate().map(of_agent).collect()
}

/// Least steps of an agent to the stop of an errand from that of the one before.
fn way(problem: &AssayProblem, ahead: &Ahead, agent: usize, index: usize) -> u64 {
    let before = index.checked_sub(1).map(|before| problem.errands[agent][before].stop);
    u64::from(ahead.steps(agent, index, before.unwrap_or(problem.instance.agents[agent].start)))
}

/// Least steps from the end of each errand to the end of all that must come after it. `order` has them by their earliest starts, so that
/// one round is mostly enough: what comes later is rarely listed before.
fn tails(problem: &AssayProblem, ahead: &Ahead, order: &[(usize, usize)], changes: &ErrandChanges) -> Vec<Vec<u64>> {
    let mut tails: Vec<Vec<u64>> = problem.errands.iter().map(|errands| vec![0; errands.len()]).collect();
    let way = |agent: usize, index: usize| way(problem, ahead, agent, index);
    let mut is_complete = false;
    while !std::mem::replace(&mut is_complete, true) {
        for (agent, index) in order.iter().rev().copied() {
            let errands = &problem.errands[agent];
            let own = errands
                .get(index + 1)
                .map(|next| way(agent, index + 1) + u64::from(next.stay) + tails[agent][index + 1]);
            // What is gone lives on in the other.
            let is_gone = problem.is_gone[agent] && index + 1 == errands.len();
            let others = problem.partner(ErrandPlace { agent, errand: index }).filter(|_| is_gone);
            let lives_on = others.and_then(|ErrandPlace { agent: other, errand: place }| {
                let next = problem.errands[other].get(place + 1)?;
                Some(way(other, place + 1) + u64::from(next.stay) + tails[other][place + 1])
            });
            // What it gives off has its own errands from then on.
            let child = errands[index].splits.map(|split| split.child);
            let lives_apart = child.map(|child| u64::from(problem.errands[child][0].stay) + tails[child][0]);
            let tail = own.max(lives_on).max(lives_apart).unwrap_or(0);
            if tail > tails[agent][index] {
                (tails[agent][index], is_complete) = (tail, false);
            }
            let own = u64::from(errands[index].stay) + tails[agent][index];
            for (before, change) in problem.afters[agent][index].iter().zip(&changes[agent][index]) {
                let tail = &mut tails[before.agent][before.errand];
                if own + change > *tail {
                    (*tail, is_complete) = (own + change, false);
                }
            }
        }
    }
    tails
}

/// The first instant at which an agent can be there: 0, or when another one gives it off; `None` while that is not known.
fn given_off(problem: &AssayProblem, agent: usize, heads: &[Vec<u64>]) -> Option<u64> {
    match problem.given_off_by(agent) {
        Some(place) => heads[place.agent].get(place.errand).copied(),
        None => Some(0),
    }
}

/// Where agents take turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct TurnPlace {
    stop: CellIndex,
    /// Whether it is the corner of a loop without room for two, for those that are moved round it or stay there for a whole round: who
    /// stays for less may do so while another one is at the far end.
    is_loop: bool,
}

/// Whether two agents can be in a loop at the same time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoopRoom {
    /// All of its cells are as near to each other as if it were one.
    Cell,
    /// Whenever one begins, it gets in the way of the other before that one is back at the corner.
    One,
    Two,
}

impl LoopRoom {
    /// By the cells of the loop, from the corner on.
    pub fn of(board: &BoardGrid, separation: u32, around: &[CellIndex]) -> LoopRoom {
        let cells = around.len();
        let keep_apart = |one: usize, other: usize| {
            let [one, other] = [one, other].map(|place| around[place % cells]);
            board.apart(one, other) >= separation
        };
        if !(0..cells).any(|one| (0..cells).any(|other| keep_apart(one, other))) {
            return LoopRoom::Cell;
        }
        // One begins, and the other is some cells ahead of it: until that one ends, both go on.
        let is_clear = |ahead: usize| {
            let steps = 0..cells - ahead;
            let mut ways = steps.flat_map(|step| [(step, step + ahead + 1), (step + 1, step + ahead)]);
            (0..=cells - ahead).all(|step| keep_apart(step, step + ahead))
                && ways.all(|(own, its)| keep_apart(own, its))
        };
        if (1..cells).any(is_clear) { LoopRoom::Two } else { LoopRoom::One }
    }

    /// What is taken for a stay, or for being mixed in a loop with this room: the stop, and the loop from there on. Who stays takes a loop
    /// without room for two where the stay fills a round.
    pub fn taken(mixes: Option<LoopRoom>, fills_loop: impl FnOnce() -> bool) -> (bool, bool) {
        match mixes {
            None => (true, fills_loop()),
            Some(LoopRoom::Cell) => (true, false),
            Some(LoopRoom::One) => (false, true),
            Some(LoopRoom::Two) => (false, false),
        }
    }
}

impl TurnPlace {
    /// Where an errand takes turns with others; nowhere if it need not.
    fn all(problem: &AssayProblem, errand: &Errand, rooms: &[LoopRoom]) -> impl Iterator<Item = TurnPlace> + use<> {
        let fills = |around: &Vec<CellIndex>| around[0] == errand.stop && errand.stay as usize >= around.len();
        let fills_loop =
            || problem.loops.iter().zip(rooms).any(|(around, room)| *room == LoopRoom::One && fills(around));
        let (stays, turns) = LoopRoom::taken(errand.mixes.map(|around| rooms[around]), fills_loop);
        let stop = errand.stop;
        [stays.then_some(false), turns.then_some(true)]
            .into_iter()
            .flatten()
            .map(move |is_loop| TurnPlace { stop, is_loop })
    }
}

/// Agents that stay at one stop take turns: for each set of those that can begin no earlier than one of them, the earliest start of the
/// first, all stays with the changes between them, and the shortest way of the last to the end; first and last are two, where there are
/// two. Agents that merge, with each other or with a third, may follow each other as one and without a change; `drops` has one number
/// for all of them. What leaves the board at the stop need not move out of the way.
fn in_turns(problem: &AssayProblem, place: TurnPlace, stays: &[(usize, TimedErrand)], drops: &[usize]) -> u64 {
    let change = change(problem, place.stop);
    let set_from = |least: u64| {
        let of: Vec<(usize, TimedErrand)> = stays.iter().filter(|(_, one)| one.head >= least).copied().collect();
        one_after_another(&of, |nth| of[nth].1.head, drops, change)
    };
    stays.iter().map(|(_, one)| set_from(one.head)).max().unwrap_or(0)
}

/// Least steps until all is done, for agents that stay at one stop, each from its own head on.
fn one_after_another(of: &[(usize, TimedErrand)], head: impl Fn(usize) -> u64, drops: &[usize], change: u64) -> u64 {
    let all: u64 = of.iter().map(|(_, one)| u64::from(one.errand.stay)).sum();
    let apart: BTreeSet<usize> = of.iter().map(|(agent, _)| drops[*agent]).collect();
    let with_last = |first: usize| {
        let others = of.iter().enumerate().filter(|(nth, _)| *nth != first || of.len() == 1);
        head(first) + others.map(|(_, (_, one))| one.tail).min().unwrap_or(0)
    };
    let around = (0..of.len()).map(with_last).min().unwrap_or(0);
    around + all + change * (apart.len() as u64).saturating_sub(1)
}

/// Steps between the stays of two agents at a stop.
fn change(problem: &AssayProblem, stop: CellIndex) -> u64 {
    let exit = |(errands, is_gone): (&Vec<Errand>, &bool)| {
        let last = errands.last().filter(|last| *is_gone && last.meets.is_none())?;
        Some(problem.instance.board.manhattan(stop, last.stop))
    };
    let nearest = problem.errands.iter().zip(&problem.is_gone).filter_map(exit).min();
    let mut agents = problem.instance.agents.iter().zip(&problem.comes);
    let comes = agents.any(|(agent, comes)| *comes && agent.start == stop);
    steps_between(problem.instance.separation, nearest, comes)
}

/// Least steps between the stays of two agents at a stop, by the steps from there to the nearest cell at which any leave the board, and
/// whether any come at the stop.
pub fn steps_between(separation: u32, exit: Option<u32>, comes: bool) -> u64 {
    match (exit, comes) {
        // One is gone at the instant at which the other comes.
        (Some(steps), true) => u64::from(steps.min(separation)),
        (Some(0), false) | (None, true) => u64::from(separation),
        (_, false) => u64::from(separation) + 1,
    }
}

/// As [`in_turns`], for the agents that come at a stop: each needs it for itself, whatever it merges with later.
fn comings(problem: &AssayProblem, place: TurnPlace, stays: &[(usize, TimedErrand)]) -> u64 {
    // Nobody is moved round a loop before it is all there.
    if place.is_loop {
        return 0;
    }
    let mut own: Vec<(usize, TimedErrand)> = Vec::new();
    for (agent, one) in stays {
        let is_first = problem.comes[*agent] && problem.instance.agents[*agent].start == one.errand.stop;
        if is_first && own.last().is_none_or(|(last, _)| last != agent) {
            own.push((*agent, *one));
        }
    }
    let apart: Vec<usize> = (0..problem.errands.len()).collect();
    in_turns(problem, place, &own, &apart)
}

/// Stops whose agents all come, at few places: the first agents of `m` stops come at `n` places, so that one of them is the `m / n`th that
/// comes at its place, rounded up, and its stop is idle until then. Of each set of places the stops that need no others are taken, those
/// that take longest first; no agent stays at two of them.
fn firsts(
    problem: &AssayProblem,
    ahead: &Ahead,
    stays: &BTreeMap<TurnPlace, Vec<(usize, TimedErrand)>>,
    drops: &[usize],
) -> u64 {
    let start = |agent: usize| problem.instance.agents[agent].start;
    let mut stops: Vec<ServedStop> = Vec::new();
    for (place, stays) in stays {
        // Coming is no stay that an agent must come for first.
        if stays.iter().all(|(agent, _)| problem.comes[*agent] && start(*agent) != place.stop) {
            let head = |nth: usize| alone(problem, ahead, stays[nth].0, place.stop);
            let steps = one_after_another(stays, head, drops, change(problem, place.stop));
            let agents: BTreeSet<usize> = stays.iter().map(|(agent, _)| *agent).collect();
            stops.push(ServedStop { steps, from: agents.iter().map(|agent| start(*agent)).collect(), agents });
        }
    }
    stops.sort_by_key(|stop| std::cmp::Reverse(stop.steps));
    let mut most = 0;
    for from in stops.iter().map(|stop| &stop.from).collect::<BTreeSet<_>>() {
        let coming = (0..problem.errands.len()).filter(|agent| problem.comes[*agent] && from.contains(&start(*agent)));
        let takes = coming.map(|agent| problem.errands[agent].first().map_or(0, |first| first.stay)).min().unwrap_or(0);
        let turn = u64::from(takes) + from.iter().map(|place| change(problem, *place)).min().unwrap_or(0);
        let (mut taken, mut count) = (BTreeSet::new(), 0u64);
        for stop in stops.iter().filter(|stop| stop.from.is_subset(from)) {
            if stop.agents.is_disjoint(&taken) {
                taken.extend(&stop.agents);
                count += 1;
                most = most.max(stop.steps + (count.div_ceil(from.len() as u64) - 1) * turn);
            }
        }
    }
    most
}

/// A stop with the agents that stay there, which all come.
struct ServedStop {
    /// Least steps until all is done, from the instant on at which the first of them comes.
    steps: u64,
    agents: BTreeSet<usize>,
    /// Where they come.
    from: BTreeSet<CellIndex>,
}

/// The first instant at which an agent can stay at a stop, whatever others do.
fn alone(problem: &AssayProblem, ahead: &Ahead, agent: usize, stop: CellIndex) -> u64 {
    let (mut from, mut steps) = (problem.instance.agents[agent].start, 0);
    for (index, errand) in problem.errands[agent].iter().enumerate() {
        steps += u64::from(ahead.steps(agent, index, from));
        if errand.stop == stop && errand.stay > 0 {
            break;
        }
        steps += u64::from(errand.stay);
        from = errand.stop;
    }
    steps
}

/// For each agent a number that it has in common with those with which it ever merges, and those that it gives off, directly or by others.
pub(super) fn drops(problem: &AssayProblem) -> Vec<usize> {
    let joined = problem.errands.iter().enumerate().flat_map(|(agent, errands)| {
        let given_off = errands.iter().filter_map(|errand| errand.splits).map(|split| split.child);
        errands.iter().filter_map(|errand| errand.meets).chain(given_off).map(move |other| (agent, other))
    });
    families(problem.errands.len(), joined)
}

/// For each of some things a number that it has in common with those that it is joined with, directly or by others.
pub fn families(count: usize, joined: impl Iterator<Item = (usize, usize)>) -> Vec<usize> {
    let mut heads: Vec<usize> = (0..count).collect();
    let head = |heads: &[usize], mut one: usize| {
        while heads[one] != one {
            one = heads[one];
        }
        one
    };
    for (one, other) in joined {
        let (one, other) = (head(&heads, one), head(&heads, other));
        heads[one.max(other)] = one.min(other);
    }
    (0..count).map(|one| head(&heads, one)).collect()
}

/// The earliest instant of an agent's last arrival: stays at the end count no more.
fn last_arrival(problem: &AssayProblem, agent: usize, errands: &[TimedErrand]) -> u64 {
    let start = problem.instance.agents[agent].start;
    let Some(last) = errands.last() else { return 0 };
    let goal = last.errand.stop;
    let at_goal = errands.iter().rev().take_while(|one| one.errand.stop == goal);
    if let Some(mixed) = at_goal.into_iter().find(|one| one.errand.mixes.is_some()) {
        return mixed.head + u64::from(mixed.errand.stay);
    }
    let Some(other) = errands.iter().rposition(|one| one.errand.stop != goal) else {
        return if start == goal { 0 } else { errands.first().map_or(0, |one| one.arrival) };
    };
    // It comes from another stop.
    errands[other + 1].arrival
}
