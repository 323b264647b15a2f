//! Lower bounds on every plan of an assay.
//!
//! There are three. Critical path: each errand ends no earlier than its agent alone could have done it, and agents that
//! meet wait for one another. Turns: agents that stay at one stop take turns, and between two of them lie the steps in
//! which the first makes room. The same holds for agents in a mixing loop in which any two block each other before a
//! round is over, and for agents that stay at its corner for a whole round. First arrivals: of several stops whose
//! agents enter the board at few places, one has to wait for its first agent.

use super::route::StopDistances;
use super::{AssayProblem, Errand, ErrandPlace};
use crate::plan::electrode_array::board::{BoardCosts, BoardGrid, CellIndex};
use rustc_hash::FxHashSet;
use std::collections::{BTreeMap, BTreeSet};

/// An errand with its earliest start, and the least time from its end to the end of the assay.
#[derive(Debug, Clone, Copy)]
struct TimedErrand {
    errand: Errand,
    /// Its agent's earliest arrival at the stop, if nothing blocks the way.
    arrival: u64,
    /// Its earliest start: the agent that it meets is there too, and its predecessors are done.
    head: u64,
    tail: u64,
}

/// Lower bounds on every plan.
pub(super) struct AssayBounds {
    /// Lower bounds on the makespan and the sum of costs.
    pub costs: BoardCosts,
    /// By agent and errand: least steps from its end to the end of everything that must follow.
    pub after: Vec<Vec<u32>>,
    /// By agent and errand: the earliest instant at which it can begin.
    pub heads: Vec<Vec<u32>>,
}

pub(super) fn least(problem: &AssayProblem, ahead: &StopDistances) -> AssayBounds {
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
    let droplet_of = droplet_of(problem);
    let turns = stays.iter().map(|(place, stays)| in_turns(problem, *place, stays, &droplet_of)).max().unwrap_or(0);
    let turns =
        turns.max(stays.iter().map(|(place, stays)| entering_in_turns(problem, *place, stays)).max().unwrap_or(0));
    let turns = turns.max(firsts(problem, ahead, &stays, &droplet_of));
    let arrivals = timed.iter().enumerate().map(|(agent, errands)| last_arrival(problem, agent, errands));
    let costs = BoardCosts { makespan: alone.max(turns), sum_of_costs: arrivals.sum() };
    let each = |of: &dyn Fn(&TimedErrand) -> u64| {
        let steps = |one: &TimedErrand| u32::try_from(of(one)).unwrap_or(u32::MAX);
        timed.iter().map(|errands| errands.iter().map(steps).collect()).collect()
    };
    AssayBounds { costs, after: each(&|one| one.tail), heads: each(&|one| one.head) }
}

/// The errands with their earliest starts; errands in which two agents meet start at the same instant.
fn timed(problem: &AssayProblem, ahead: &StopDistances) -> Vec<Vec<TimedErrand>> {
    let agents = &problem.instance.agents;
    let mut arrivals: Vec<Vec<u64>> = vec![Vec::new(); agents.len()];
    let mut heads = arrivals.clone();
    let changes = changes(problem);
    let way = |agent: usize, index: usize| way(problem, ahead, agent, index);
    // Agents that meet wait for each other; every round completes at least one errand.
    let mut order: Vec<(usize, usize)> = Vec::new();
    loop {
        let before = order.len();
        for agent in 0..agents.len() {
            let Some(appears) = appears_at(problem, agent, &heads) else { continue };
            while heads[agent].len() < problem.errands[agent].len() {
                let index = heads[agent].len();
                let since = index
                    .checked_sub(1)
                    .map_or(appears, |last| heads[agent][last] + u64::from(problem.errands[agent][last].stay));
                let arrival = since + way(agent, index);
                let Some(begins) = begins(problem, agent, index, &heads, &changes) else { break };
                let mut head = arrival.max(begins);
                if let Some(other) = problem.errands[agent][index].meets {
                    let partner = problem.partner(ErrandPlace { agent, errand: index });
                    // Its earliest start is known once all its previous errands are timed.
                    let theirs = partner.map(|place| place.errand).filter(|place| heads[other].len() >= *place);
                    let Some(theirs) = theirs else { break };
                    let Some(appears) = appears_at(problem, other, &heads) else { break };
                    let since = theirs
                        .checked_sub(1)
                        .map_or(appears, |last| heads[other][last] + u64::from(problem.errands[other][last].stay));
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

/// The earliest instant at which all predecessors of an errand are done; `None` while it is not known.
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

/// By agent, errand and predecessor: least steps from the end of the predecessor to the beginning of the errand. If
/// both have the same stop, the first agent must make room.
type ErrandChanges = Vec<Vec<Vec<u64>>>;

fn changes(problem: &AssayProblem) -> ErrandChanges {
    let droplet_of = droplet_of(problem);
    let mut at_stop: BTreeMap<CellIndex, u64> = BTreeMap::new();
    let mut between = |before: &ErrandPlace, (agent, index): (usize, usize)| {
        let (done, next) = (problem.errands[before.agent][before.errand], problem.errands[agent][index]);
        let leaves = problem.is_gone[before.agent] && before.errand + 1 == problem.errands[before.agent].len();
        let makes_room = done.stop == next.stop && droplet_of[before.agent] != droplet_of[agent];
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

/// Least steps of an agent from the stop of its previous errand to that of an errand.
fn way(problem: &AssayProblem, ahead: &StopDistances, agent: usize, index: usize) -> u64 {
    let before = index.checked_sub(1).map(|before| problem.errands[agent][before].stop);
    u64::from(ahead.steps(agent, index, before.unwrap_or(problem.instance.agents[agent].start)))
}

/// Least steps from the end of each errand to the end of everything that must follow. `order` has the errands by their
/// earliest starts, so that one round is mostly enough: a successor is rarely listed before its predecessor.
fn tails(
    problem: &AssayProblem,
    ahead: &StopDistances,
    order: &[(usize, usize)],
    changes: &ErrandChanges,
) -> Vec<Vec<u64>> {
    let mut tails: Vec<Vec<u64>> = problem.errands.iter().map(|errands| vec![0; errands.len()]).collect();
    let way = |agent: usize, index: usize| way(problem, ahead, agent, index);
    let mut is_complete = false;
    while !std::mem::replace(&mut is_complete, true) {
        for (agent, index) in order.iter().rev().copied() {
            let errands = &problem.errands[agent];
            let own = errands
                .get(index + 1)
                .map(|next| way(agent, index + 1) + u64::from(next.stay) + tails[agent][index + 1]);
            // An agent that has merged continues in the other one.
            let is_gone = problem.is_gone[agent] && index + 1 == errands.len();
            let others = problem.partner(ErrandPlace { agent, errand: index }).filter(|_| is_gone);
            let lives_on = others.and_then(|ErrandPlace { agent: other, errand: place }| {
                let next = problem.errands[other].get(place + 1)?;
                Some(way(other, place + 1) + u64::from(next.stay) + tails[other][place + 1])
            });
            // A child has errands of its own from then on.
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

/// The first instant at which an agent can be on the board: 0, or that of the split from which it comes; `None` while
/// it is not known.
fn appears_at(problem: &AssayProblem, agent: usize, heads: &[Vec<u64>]) -> Option<u64> {
    match problem.split_of(agent) {
        Some(place) => heads[place.agent].get(place.errand).copied(),
        None => Some(0),
    }
}

/// A place where agents take turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct TurnPlace {
    stop: CellIndex,
    /// Whether it is the corner of a loop without room for two, taken by agents that are mixed in it or stay there for
    /// a whole round. A shorter stay is possible while another agent is at the far end.
    is_loop: bool,
}

/// Number of agents that can be in a mixing loop at the same time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoopRoom {
    /// One agent: all cells of the loop are closer to each other than the separation, as if it were one cell.
    Cell,
    /// One agent: whenever a second one begins, the two come too near to each other before the first is back at the
    /// corner.
    One,
    Two,
}

impl LoopRoom {
    /// The room of a loop, given by its cells from the corner on.
    pub fn of(board: &BoardGrid, separation: u32, around: &[CellIndex]) -> LoopRoom {
        let cells = around.len();
        let keep_apart = |one: usize, other: usize| {
            let [one, other] = [one, other].map(|place| around[place % cells]);
            board.apart(one, other) >= separation
        };
        if !(0..cells).any(|one| (0..cells).any(|other| keep_apart(one, other))) {
            return LoopRoom::Cell;
        }
        // One agent begins while the other is `ahead` cells further on; until the other one ends, both move on.
        let is_clear = |ahead: usize| {
            let steps = 0..cells - ahead;
            let mut ways = steps.flat_map(|step| [(step, step + ahead + 1), (step + 1, step + ahead)]);
            (0..=cells - ahead).all(|step| keep_apart(step, step + ahead))
                && ways.all(|(own, its)| keep_apart(own, its))
        };
        if (1..cells).any(is_clear) { LoopRoom::Two } else { LoopRoom::One }
    }

    /// Whether a stay, or mixing in a loop with this room, takes the stop, and whether it takes the loop from there on.
    /// A stay takes a loop without room for two if it lasts a whole round.
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
    /// The places where an errand takes turns with others; none if it need not.
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

/// Lower bound from agents that take turns at a place. For each set of stays that can begin no earlier than one of
/// them: the earliest start of the first, all stays with the changeovers between them, and the least time from the end
/// of the last to the end of the assay; first and last differ if there are two. Agents that merge, with each other or
/// with a third, may follow each other as one and without a changeover; they have the same number in `droplet_of`. An
/// agent that leaves the board at the stop need not make room.
fn in_turns(problem: &AssayProblem, place: TurnPlace, stays: &[(usize, TimedErrand)], droplet_of: &[usize]) -> u64 {
    let change = change(problem, place.stop);
    let mut stays: Vec<&(usize, TimedErrand)> = stays.iter().collect();
    stays.sort_by_key(|(_, one)| std::cmp::Reverse(one.head));
    let (mut least, mut set) = (0, StaysInTurn::default());
    // Each set contains the one before.
    for same_head in stays.chunk_by(|(_, one), (_, next)| one.head == next.head) {
        same_head.iter().for_each(|(agent, one)| set.add(one.head, one, droplet_of[*agent]));
        least = least.max(set.steps(change));
    }
    least
}

/// The stays of agents at one stop in turn, each from its own earliest start on.
#[derive(Default)]
struct StaysInTurn {
    /// Sum of their durations.
    all: u64,
    droplets: FxHashSet<usize>,
    /// The least earliest start, the least tail, and the least sum of the start of one stay and the tail of another.
    head: Option<u64>,
    tail: Option<u64>,
    around: Option<u64>,
}

impl StaysInTurn {
    fn add(&mut self, head: u64, one: &TimedErrand, droplet: usize) {
        self.all += u64::from(one.errand.stay);
        self.droplets.insert(droplet);
        let around = self.tail.map(|tail| head + tail).into_iter().chain(self.head.map(|first| first + one.tail));
        self.around = self.around.into_iter().chain(around).min();
        self.head = self.head.into_iter().chain([head]).min();
        self.tail = self.tail.into_iter().chain([one.tail]).min();
    }

    /// Least steps until everything is done.
    fn steps(&self, change: u64) -> u64 {
        // A single stay is first and last.
        let around = self.around.or(self.head.zip(self.tail).map(|(head, tail)| head + tail)).unwrap_or(0);
        around + self.all + change * (self.droplets.len() as u64).saturating_sub(1)
    }
}

/// Changeover: least steps between the stays of two agents at a stop.
fn change(problem: &AssayProblem, stop: CellIndex) -> u64 {
    let exit = |(errands, is_gone): (&Vec<Errand>, &bool)| {
        let last = errands.last().filter(|last| *is_gone && last.meets.is_none())?;
        Some(problem.instance.board.manhattan(stop, last.stop))
    };
    let nearest = problem.errands.iter().zip(&problem.is_gone).filter_map(exit).min();
    let mut agents = problem.instance.agents.iter().zip(&problem.enters);
    let enters = agents.any(|(agent, enters)| *enters && agent.start == stop);
    steps_between(problem.instance.separation, nearest, enters)
}

/// Least steps between the stays of two agents at a stop. `exit` are the steps from there to the nearest cell where an
/// agent leaves the board; `enters` is whether agents enter at the stop.
pub fn steps_between(separation: u32, exit: Option<u32>, enters: bool) -> u64 {
    match (exit, enters) {
        // One agent may be gone at the instant at which the other enters.
        (Some(steps), true) => u64::from(steps.min(separation)),
        (Some(0), false) | (None, true) => u64::from(separation),
        (_, false) => u64::from(separation) + 1,
    }
}

/// As [`in_turns`], for the agents that enter at a stop: each needs it alone, whatever it merges with later.
fn entering_in_turns(problem: &AssayProblem, place: TurnPlace, stays: &[(usize, TimedErrand)]) -> u64 {
    // No agent is mixed before it has entered.
    if place.is_loop {
        return 0;
    }
    let mut own: Vec<(usize, TimedErrand)> = Vec::new();
    for (agent, one) in stays {
        let is_first = problem.enters[*agent] && problem.instance.agents[*agent].start == one.errand.stop;
        if is_first && own.last().is_none_or(|(last, _)| last != agent) {
            own.push((*agent, *one));
        }
    }
    let apart: Vec<usize> = (0..problem.errands.len()).collect();
    in_turns(problem, place, &own, &apart)
}

/// Lower bound from stops all of whose agents enter the board, at few places. If the first agents of `m` stops enter at
/// `n` places, one of them is the `m / n`th (rounded up) that enters at its place, and its stop is idle until then. For
/// each set of places, the stops that need no other places are counted, those that take longest first; no agent stays
/// at two of them.
fn firsts(
    problem: &AssayProblem,
    ahead: &StopDistances,
    stays: &BTreeMap<TurnPlace, Vec<(usize, TimedErrand)>>,
    droplet_of: &[usize],
) -> u64 {
    let start = |agent: usize| problem.instance.agents[agent].start;
    let mut stops: Vec<ServedStop> = Vec::new();
    for (place, stays) in stays {
        // Entering is no stay that an agent must first travel to.
        if stays.iter().all(|(agent, _)| problem.enters[*agent] && start(*agent) != place.stop) {
            let mut set = StaysInTurn::default();
            for (agent, one) in stays {
                set.add(alone(problem, ahead, *agent, place.stop), one, droplet_of[*agent]);
            }
            let steps = set.steps(change(problem, place.stop));
            let agents: BTreeSet<usize> = stays.iter().map(|(agent, _)| *agent).collect();
            stops.push(ServedStop { steps, from: agents.iter().map(|agent| start(*agent)).collect(), agents });
        }
    }
    stops.sort_by_key(|stop| std::cmp::Reverse(stop.steps));
    let mut most = 0;
    for from in stops.iter().map(|stop| &stop.from).collect::<BTreeSet<_>>() {
        let coming = (0..problem.errands.len()).filter(|agent| problem.enters[*agent] && from.contains(&start(*agent)));
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

/// A stop whose agents all enter the board.
struct ServedStop {
    /// Least steps until everything is done, from the instant at which the first agent enters.
    steps: u64,
    agents: BTreeSet<usize>,
    /// The cells where they enter.
    from: BTreeSet<CellIndex>,
}

/// The first instant at which an agent can stay at a stop, whatever others do.
fn alone(problem: &AssayProblem, ahead: &StopDistances, agent: usize, stop: CellIndex) -> u64 {
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

/// Least steps of each agent alone, and at least one more than those of its children.
pub(super) fn lengths(problem: &AssayProblem, ahead: &StopDistances) -> Vec<u64> {
    let agents = 0..problem.errands.len();
    let mut lengths: Vec<u64> = agents.clone().map(|agent| length(problem, ahead, agent)).collect();
    // A parent comes earlier in the list than its children.
    for agent in agents.rev() {
        if let Some(parent) = problem.parents[agent] {
            lengths[parent] = lengths[parent].max(lengths[agent] + 1);
        }
    }
    lengths
}

/// Least steps of an agent alone.
fn length(problem: &AssayProblem, ahead: &StopDistances, agent: usize) -> u64 {
    let mut from = problem.instance.agents[agent].start;
    let mut steps = 0;
    for (index, errand) in problem.errands[agent].iter().enumerate() {
        steps += u64::from(ahead.steps(agent, index, from)) + u64::from(errand.stay);
        from = errand.stop;
    }
    steps
}

/// For each agent the number of its droplet: agents that merge or split, directly or through others, have the same
/// number.
pub(super) fn droplet_of(problem: &AssayProblem) -> Vec<usize> {
    let joined = problem.errands.iter().enumerate().flat_map(|(agent, errands)| {
        let children = errands.iter().filter_map(|errand| errand.splits).map(|split| split.child);
        errands.iter().filter_map(|errand| errand.meets).chain(children).map(move |other| (agent, other))
    });
    families(problem.errands.len(), joined)
}

/// Connected components: for each of `count` items, the least index in its component.
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

/// The earliest instant of an agent's last move; a stay at the end does not count.
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
