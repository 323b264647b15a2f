//! The agents that can continue, in the order of their turns.

use super::{AssayProblem, Errand};
use rustc_hash::FxHashMap;
use std::collections::BTreeSet;

/// Most doublings of the turns for which an agent without a course stands back.
const MAX_DOUBLINGS: u32 = 10;

/// The order in which agents take their turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TurnOrder {
    /// By the list.
    Eager,
    /// By time.
    Patient,
}

/// By agent: those whose turns depend on what it does.
pub(super) struct TurnLinks {
    /// The agents that it meets or that split off from it.
    partners: Vec<Vec<usize>>,
    /// The agents with errands that come after some of its errands.
    successors: Vec<Vec<usize>>,
}

impl TurnLinks {
    pub(super) fn new(problem: &AssayProblem) -> TurnLinks {
        let partners = |errands: &Vec<Errand>| {
            let children = errands.iter().filter_map(|errand| errand.splits).map(|split| split.child);
            errands.iter().filter_map(|errand| errand.meets).chain(children).collect()
        };
        let mut successors: Vec<Vec<usize>> = vec![Vec::new(); problem.errands.len()];
        for (agent, afters) in problem.afters.iter().enumerate() {
            afters.iter().flatten().for_each(|before| successors[before.agent].push(agent));
        }
        TurnLinks { partners: problem.errands.iter().map(partners).collect(), successors }
    }

    /// The agents whose turns may change once an agent has continued: those that change themselves are the agent, the
    /// agents that it meets and its children. A turn depends on the agent, on its partners, and on their predecessors.
    pub(super) fn affected(&self, agent: usize) -> Vec<usize> {
        let mut affected = Vec::new();
        for changed in std::iter::once(&agent).chain(&self.partners[agent]) {
            for own in std::iter::once(changed).chain(&self.successors[*changed]) {
                affected.push(*own);
                affected.extend(&self.partners[*own]);
            }
        }
        affected.sort_unstable();
        affected.dedup();
        affected
    }
}

/// Whether an agent can continue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum AgentTurn {
    No,
    /// It can, but its partner at the next meeting comes first.
    Able,
    /// It is its turn; the least key comes first.
    Its((bool, u32)),
}

/// The agents that can continue, kept up to date turn by turn: an assay may have thousands that have not entered yet.
pub(super) struct TurnQueue<'l> {
    list: &'l [usize],
    /// By agent: its index in the list.
    places: Vec<usize>,
    /// By agent: its key in `in_turn`, if it is there.
    keys: Vec<Option<(bool, u32)>>,
    /// Keys and places of the agents whose turn it is at their next meeting.
    in_turn: BTreeSet<((bool, u32), usize)>,
    /// Places of all agents that can continue.
    able: BTreeSet<usize>,
    /// Number of turns so far, and that of the last one in which an agent continued.
    turn: u64,
    last_success: u64,
    /// The agents that found no course in their turn.
    postponed: FxHashMap<usize, PostponedTurn>,
}

/// An agent that found no course: how often, and in which turn last.
#[derive(Clone, Copy)]
struct PostponedTurn {
    tries: u32,
    last: u64,
}

impl<'l> TurnQueue<'l> {
    /// A queue in which no agent can continue yet.
    pub(super) fn new(list: &'l [usize]) -> TurnQueue<'l> {
        let mut places = vec![0; list.len()];
        list.iter().enumerate().for_each(|(place, agent)| places[*agent] = place);
        TurnQueue {
            list,
            places,
            keys: vec![None; list.len()],
            in_turn: BTreeSet::new(),
            able: BTreeSet::new(),
            turn: 0,
            last_success: 0,
            postponed: FxHashMap::default(),
        }
    }

    /// The agent that continues next: among those that can, preferably one whose turn it is at its next meeting.
    pub(super) fn next(&self) -> Option<usize> {
        let place = self.in_turn.first().map(|(_, place)| place).or(self.able.first())?;
        self.list.get(*place).copied()
    }

    /// As [`Self::next`], without the agents that found no course lately. Each further failure doubles the number of
    /// turns that an agent stands back; when there is no other agent, it comes earlier.
    pub(super) fn next_due(&self) -> Option<usize> {
        if self.postponed.is_empty() {
            return self.next();
        }
        let in_turn = self.in_turn.iter().map(|(_, place)| place);
        let all = || in_turn.clone().chain(&self.able).map(|place| self.list[*place]);
        let is_due = |agent: &usize| {
            self.postponed.get(agent).is_none_or(|one| self.turn - one.last >= 1 << one.tries.min(MAX_DOUBLINGS))
        };
        let may_succeed = |agent: &usize| self.postponed.get(agent).is_none_or(|one| one.last < self.last_success);
        all().find(is_due).or_else(|| all().find(may_succeed)).or_else(|| all().next())
    }

    /// Notes that an agent found no course in its turn. The error is the agent if nobody has continued since its last
    /// try, or nobody else can.
    pub(super) fn postpone(&mut self, agent: usize) -> Result<(), usize> {
        self.turn += 1;
        let before = self.postponed.get(&agent).copied();
        if self.able.len() < 2 || before.is_some_and(|before| before.last > self.last_success) {
            return Err(agent);
        }
        let tries = before.map_or(0, |before| before.tries) + 1;
        self.postponed.insert(agent, PostponedTurn { tries, last: self.turn });
        Ok(())
    }

    /// Notes that an agent has continued.
    pub(super) fn went_on(&mut self, agent: usize) {
        self.turn += 1;
        self.last_success = self.turn;
        self.postponed.remove(&agent);
    }

    /// Notes whether an agent can continue.
    pub(super) fn note(&mut self, agent: usize, turn: AgentTurn) {
        let place = self.places[agent];
        let (is_able, key) = match turn {
            AgentTurn::No => (false, None),
            AgentTurn::Able => (true, None),
            AgentTurn::Its(key) => (true, Some(key)),
        };
        match is_able {
            true => self.able.insert(place),
            false => self.able.remove(&place),
        };
        let before = std::mem::replace(&mut self.keys[agent], key);
        if before != key {
            if let Some(before) = before {
                self.in_turn.remove(&(before, place));
            }
            self.in_turn.extend(key.map(|key| (key, place)));
        }
    }
}
