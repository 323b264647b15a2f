//! Independence detection: agents that do not conflict are searched separately (Standley, AAAI 2010).
//!
//! Every agent begins as its own group. Where the paths of two groups clash, the groups are merged and searched again. At any time
//! the bounds of the groups add up to a bound for all, and once no paths clash the union of the plans is optimal.

use super::split::clashes;
use super::tables::ExactTables;
use super::tree::{self, ConstraintTreeTask, TreeAnswer};
use crate::plan::electrode_array::board::{CellIndex, Paths};
use crate::plan::search::Meter;

/// Bounds on everyone's arrival, and the ceiling on the sum of costs.
#[derive(Clone, Copy)]
pub struct WantedBounds {
    /// No arrival counts before this instant.
    pub least: u32,
    /// Latest arrival for everyone, or `ALWAYS`.
    pub most: u32,
    /// Only sums of costs below this matter.
    pub ceiling: u64,
}

/// 1/N of the remaining budget for the first attempt at a group.
const FIRST_SHARE: u64 = 4;

/// Searches for all agents; equivalent to one search for all.
pub fn search(tables: &ExactTables, wanted: WantedBounds, meter: &mut Meter) -> TreeAnswer {
    let mut groups = Groups { tables, wanted, groups: vec![] };
    for agent in 0..tables.agents() {
        let cost = tables.least(agent).max(wanted.least);
        groups.groups.push(Group {
            members: vec![agent],
            bound: u64::from(cost),
            paths: None,
            is_stuck: false,
            is_checked: false,
        });
    }
    groups.run(meter)
}

struct Group {
    members: Vec<usize>,
    /// Lower bound on the sum of costs of the members.
    bound: u64,
    /// An optimal plan, if found.
    paths: Option<Paths>,
    /// Whether its first share of the budget did not suffice.
    is_stuck: bool,
    /// Whether its paths clash with those of no other group.
    is_checked: bool,
}

struct Groups<'a> {
    tables: &'a ExactTables<'a>,
    wanted: WantedBounds,
    groups: Vec<Group>,
}

impl Groups<'_> {
    fn run(&mut self, meter: &mut Meter) -> TreeAnswer {
        loop {
            if self.bound() >= self.wanted.ceiling {
                return TreeAnswer::Nothing;
            }
            if let Some(index) = self.groups.iter().position(|group| group.paths.is_none() && !group.is_stuck) {
                if self.solve(index, meter.left().steps / FIRST_SHARE, meter) {
                    return TreeAnswer::Nothing;
                }
            } else if let Some((one, other)) = self.clashing(meter) {
                self.unite(one, other);
            } else if let Some(index) = self.groups.iter().position(|group| group.paths.is_none()) {
                let before = self.groups[index].bound;
                if self.solve(index, meter.left().steps, meter) {
                    return TreeAnswer::Nothing;
                }
                if self.groups[index].paths.is_none() {
                    self.groups[index].bound = self.groups[index].bound.max(before);
                    return TreeAnswer::GaveUp { bound: self.bound() };
                }
            } else {
                return TreeAnswer::Found { paths: self.all_paths(), cost: self.bound() };
            }
        }
    }

    fn bound(&self) -> u64 {
        self.groups.iter().map(|group| group.bound).sum()
    }

    /// Searches for a plan of one group; returns `true` if it has none below the ceiling.
    fn solve(&mut self, index: usize, steps: u64, meter: &mut Meter) -> bool {
        let group = &self.groups[index];
        let outside: Vec<(usize, &[CellIndex])> = self
            .groups
            .iter()
            .enumerate()
            .filter(|(other, _)| *other != index)
            .filter_map(|(_, group)| Some((group, group.paths.as_ref()?)))
            .flat_map(|(group, paths)| group.members.iter().copied().zip(paths.iter().map(Vec::as_slice)))
            .collect();
        let elsewhere = self.bound() - group.bound;
        let ceiling = if self.wanted.ceiling == u64::MAX { u64::MAX } else { self.wanted.ceiling - elsewhere };
        let WantedBounds { least, most, .. } = self.wanted;
        let task = ConstraintTreeTask {
            tables: self.tables,
            group: &group.members,
            least,
            most,
            ceiling,
            floor: group.bound,
            outside: &outside,
        };
        let end = meter.share(steps, |meter| tree::search(task, meter));
        let group = &mut self.groups[index];
        match end {
            TreeAnswer::Found { paths, cost } => {
                (group.paths, group.bound, group.is_checked) = (Some(paths), cost, false)
            }
            TreeAnswer::Nothing => return true,
            TreeAnswer::GaveUp { bound } => (group.is_stuck, group.bound) = (true, group.bound.max(bound)),
        }
        false
    }

    /// The first two groups whose paths clash, the smaller index first, so that one cluster grows.
    fn clashing(&mut self, meter: &mut Meter) -> Option<(usize, usize)> {
        let mut first: Option<(usize, usize)> = None;
        for one in (0..self.groups.len()).filter(|one| !self.groups[*one].is_checked).collect::<Vec<usize>>() {
            let mut clashes = false;
            for other in (0..self.groups.len()).filter(|other| *other != one) {
                let sizes = [one, other].map(|group| self.groups[group].members.len());
                meter.charge((sizes[0] * sizes[1]) as u64);
                if self.clash(&self.groups[one], &self.groups[other]) {
                    let found = (one.max(other), one.min(other));
                    first = Some(first.map_or(found, |known| known.min(found)));
                    clashes = true;
                }
            }
            self.groups[one].is_checked = !clashes;
        }
        first.map(|(other, one)| (one, other))
    }

    fn clash(&self, one: &Group, other: &Group) -> bool {
        let (Some(paths), Some(ways)) = (&one.paths, &other.paths) else { return false };
        one.members.iter().zip(paths).any(|(agent, path)| {
            let mut others = other.members.iter().zip(ways);
            others.any(|(other, way)| clashes(self.tables, [*agent, *other], [path, way]).next().is_some())
        })
    }

    fn unite(&mut self, one: usize, other: usize) {
        let Group { members, bound, .. } = self.groups.swap_remove(other);
        let group = &mut self.groups[one];
        group.members.extend(members);
        group.members.sort_unstable();
        group.bound += bound;
        group.paths = None;
        group.is_stuck = false;
        group.is_checked = false;
    }

    fn all_paths(&self) -> Paths {
        let mut paths = vec![vec![]; self.tables.agents()];
        for group in &self.groups {
            for (agent, path) in group.members.iter().zip(group.paths.iter().flatten()) {
                paths[*agent] = path.clone();
            }
        }
        paths
    }
}
