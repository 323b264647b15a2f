//! Whether several agents can take least-cost paths together: a joint search of their multi-value decision diagrams.
//!
//! First, nodes that are compatible with no path of some other member are removed from the layers, until nothing changes: the
//! remaining paths of two members may be incompatible although some pair of paths was compatible before (arc consistency over pairs
//! of layers, a generalisation of the mutex propagation of Zhang, Li, Surynek, Kumar, Koenig, "Multi-agent path finding with mutex
//! propagation", ICAPS 2020). Then depth-first search over the tuples of all members' places at one instant, each tuple once; a
//! pair that has no joint path to the end prunes the tuple (compare the increasing cost tree search, Sharon et al., Artificial
//! Intelligence 195, 2013).

use super::constraint::AgentConstraint;
use super::mdd::MultiValueDecisionDiagram;
use super::pair::{CompatiblePairs, PairSide};
use super::tables::ExactTables;
use crate::plan::electrode_array::board::CellIndex;
use crate::plan::search::Meter;
use rustc_hash::FxHashSet;
use std::rc::Rc;

/// Larger groups are not searched jointly.
pub const MOST_MEMBERS: usize = 8;

/// Bits of a place in the key of a tuple.
const PLACE_BITS: u32 = 14;

/// A member of a joint search.
pub struct Member<'a> {
    pub agent: usize,
    pub mdd: Rc<MultiValueDecisionDiagram>,
    /// Its current path; the next position on it is tried first.
    pub path: &'a [CellIndex],
}

/// Result of a joint search.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum JointMddAnswer {
    /// Compatible paths, in the order of the members.
    Compatible(Vec<Vec<CellIndex>>),
    /// Proven: there are no compatible paths of these costs.
    Incompatible,
    /// Not decided: too many tuples, too large layers, or the budget ran out.
    Unknown,
}

/// Rounds of making the layers of each pair consistent.
const ROUNDS: usize = 4;

/// Budget of member moves in the search for paths.
const MOST_MOVES: u64 = 20_000;

/// Searches for compatible paths of the members.
pub fn search(tables: &ExactTables, members: &[Member], meter: &mut Meter) -> JointMddAnswer {
    let end = members.iter().map(|member| member.mdd.cost()).max().unwrap_or(0);
    let too_wide = |member: &Member| (0..=end).any(|instant| member.mdd.at(instant).len() >= 1 << PLACE_BITS);
    if members.len() > MOST_MEMBERS || end >= 1 << 16 || members.iter().any(too_wide) {
        return JointMddAnswer::Unknown;
    }
    let Some(rest) = Consistent::new(tables, members, meter) else { return JointMddAnswer::Incompatible };
    let mut search = JointMddSearch {
        tables,
        members,
        rest: &rest,
        trail: vec![vec![0; members.len()]],
        seen: FxHashSet::default(),
        moves: 0,
    };
    let mut stack = vec![search.followers(0)];
    while let Some(choices) = stack.last_mut() {
        let instant = stack_instant(&search.trail);
        if instant == end {
            return JointMddAnswer::Compatible(search.paths());
        }
        let Some(next) = choices.pop() else {
            stack.pop();
            search.trail.pop();
            continue;
        };
        if !search.seen.insert(key(instant + 1, &next)) {
            continue;
        }
        if search.moves > MOST_MOVES || meter.left().steps == 0 {
            return JointMddAnswer::Unknown;
        }
        meter.charge(members.len() as u64);
        search.trail.push(next);
        stack.push(if instant + 1 == end { vec![] } else { search.followers(instant + 1) });
    }
    JointMddAnswer::Incompatible
}

/// Whether the diagrams prove that there is no plan in which all agents arrive within `steps` steps. Agents with the
/// least slack come first; agents for whose diagrams the budget does not suffice are left out.
pub fn excludes(tables: &ExactTables, steps: u32, meter: &mut Meter) -> bool {
    let mut agents: Vec<usize> = (0..tables.agents()).collect();
    agents.sort_by_key(|agent| std::cmp::Reverse(tables.least(*agent)));
    let constraint = AgentConstraint { bans: Vec::new(), least: steps, most: steps };
    let mut mdd_of = |agent| MultiValueDecisionDiagram::new(tables, agent, &constraint, steps, meter).ok();
    let mdds: Vec<_> = agents.iter().map_while(|agent| mdd_of(*agent)).collect();
    let member = |(agent, mdd)| Member { agent, mdd: Rc::new(mdd), path: &[] };
    let members: Vec<Member> = agents.into_iter().zip(mdds).map(member).collect();
    Consistent::new(tables, &members, meter).is_none()
}

fn stack_instant(trail: &[Vec<u16>]) -> u32 {
    trail.len() as u32 - 1
}

fn key(instant: u32, places: &[u16]) -> u128 {
    places.iter().fold(u128::from(instant), |key, place| key << PLACE_BITS | u128::from(*place))
}

/// The diagrams after arc consistency, with their compatibility tables.
struct Consistent {
    mdds: Vec<Rc<MultiValueDecisionDiagram>>,
    /// Indexed by the greater member, then by the smaller one.
    pair_tables: Vec<Vec<CompatiblePairs>>,
}

impl Consistent {
    /// `None` if some member has no path left.
    fn new(tables: &ExactTables, members: &[Member], meter: &mut Meter) -> Option<Consistent> {
        let mdds: Vec<Rc<MultiValueDecisionDiagram>> = members.iter().map(|member| member.mdd.clone()).collect();
        let pair_tables =
            (0..members.len()).map(|member| (0..member).map(|_| CompatiblePairs::open()).collect()).collect();
        let mut rest = Consistent { mdds, pair_tables };
        let mut is_stale: Vec<Vec<bool>> = (0..members.len()).map(|member| vec![true; member]).collect();
        for _ in 0..ROUNDS {
            let pairs = (0..members.len()).flat_map(|member| (0..member).map(move |other| (member, other)));
            for (member, other) in pairs {
                if std::mem::replace(&mut is_stale[member][other], false) {
                    let changed = rest.revise(tables, members, [other, member], meter)?;
                    for (end, _) in [other, member].iter().zip(changed).filter(|(_, changed)| *changed) {
                        is_stale[*end].fill(true);
                        is_stale.iter_mut().filter(|row| row.len() > *end).for_each(|row| row[*end] = true);
                    }
                }
            }
        }
        for (row, stale) in rest.pair_tables.iter_mut().zip(&is_stale) {
            row.iter_mut()
                .zip(stale)
                .filter(|(_, stale)| **stale)
                .for_each(|(table, _)| *table = CompatiblePairs::open());
        }
        Some(rest)
    }

    /// Removes from the layers of a pair the nodes that are compatible with no path of the other; returns which layers changed.
    fn revise(
        &mut self,
        tables: &ExactTables,
        members: &[Member],
        pair: [usize; 2],
        meter: &mut Meter,
    ) -> Option<[bool; 2]> {
        let [one, other] = pair.map(|member| PairSide { agent: members[member].agent, mdd: &self.mdds[member] });
        let table = CompatiblePairs::swept(tables, one, other, meter);
        let end = one.mdd.cost().max(other.mdd.cost());
        let stands = (0..=end).all(|instant| {
            let past = |side: PairSide| instant > side.mdd.cost();
            (!past(one) || table.allows_first(instant, 0)) && (!past(other) || table.allows_second(instant, 0))
        });
        if !stands {
            return None;
        }
        let first = one.mdd.filtered(tables, one.agent, |instant, place| table.allows_first(instant, place))?;
        let second = other.mdd.filtered(tables, other.agent, |instant, place| table.allows_second(instant, place))?;
        let changed = [first.size() < one.mdd.size(), second.size() < other.mdd.size()];
        for ((member, mdd), _) in pair.into_iter().zip([first, second]).zip(changed).filter(|(_, changed)| *changed) {
            self.mdds[member] = Rc::new(mdd);
        }
        self.pair_tables[pair[1]][pair[0]] = table;
        Some(changed)
    }
}

struct JointMddSearch<'a> {
    tables: &'a ExactTables<'a>,
    members: &'a [Member<'a>],
    rest: &'a Consistent,
    /// Places of all members, by instant.
    trail: Vec<Vec<u16>>,
    seen: FxHashSet<u128>,
    moves: u64,
}

impl JointMddSearch<'_> {
    /// Tuples of the next instant that are compatible with the last tuple of the trail; the one to try first comes
    /// last.
    fn followers(&mut self, instant: u32) -> Vec<Vec<u16>> {
        let here = &self.trail[self.trail.len() - 1];
        let mut partial: Vec<Vec<u16>> = vec![vec![]];
        let mut tried = 0;
        for (member, asked) in self.members.iter().enumerate() {
            let wanted = crate::plan::electrode_array::board::position(asked.path, instant as usize + 1);
            let mut edges: Vec<u16> =
                self.rest.mdds[member].edges(instant, here[member] as usize).iter().map(|to| *to as u16).collect();
            edges.sort_by_key(|to| self.cell(member, instant + 1, *to) == wanted);
            let longer = partial.iter().flat_map(|head| edges.iter().map(move |to| (head, *to)));
            let fitting = longer.filter(|(head, to)| self.fits(instant, here, head, *to));
            partial = fitting.map(|(head, to)| head.iter().copied().chain([to]).collect()).collect();
            tried += partial.len() as u64;
        }
        self.moves += tried;
        partial
    }

    fn cell(&self, member: usize, instant: u32, place: u16) -> CellIndex {
        self.tables.cell(self.rest.mdds[member].at(instant)[place as usize])
    }

    /// Whether the move of the next member is compatible with those before it.
    fn fits(&self, instant: u32, here: &[u16], head: &[u16], to: u16) -> bool {
        let member = head.len();
        let (from_cell, to_cell) = (self.cell(member, instant, here[member]), self.cell(member, instant + 1, to));
        head.iter().enumerate().all(|(other, other_to)| {
            let (other_from, other_next) =
                (self.cell(other, instant, here[other]), self.cell(other, instant + 1, *other_to));
            let agents = (self.members[member].agent, self.members[other].agent);
            let near = |at: CellIndex, other_at: CellIndex| self.tables.too_near(agents.0, at, agents.1, other_at);
            self.rest.pair_tables[member][other].allows(instant + 1, *other_to as usize, to as usize)
                && !near(to_cell, other_next)
                && !near(to_cell, other_from)
                && !near(from_cell, other_next)
        })
    }

    fn paths(&self) -> Vec<Vec<CellIndex>> {
        let path = |(member, asked): (usize, &Member)| {
            let instants = 0..=asked.mdd.cost();
            instants.map(|instant| self.cell(member, instant, self.trail[instant as usize][member])).collect()
        };
        self.members.iter().enumerate().map(path).collect()
    }
}
