//! Constraints of one agent in a node of the constraint tree, and the least cost at which the agent alone meets them.

use super::tables::{CellPlace, ExactTables, FAR, StagedCell};
use crate::plan::electrode_array::board::CellIndex;
use crate::plan::search::Meter;
use rustc_hash::FxHashSet;

/// No last instant.
pub const ALWAYS: u32 = u32::MAX;

/// A box of cells forbidden to an agent during some instants, all ends included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ban {
    pub columns: (i32, i32),
    pub rows: (i32, i32),
    /// First instant.
    pub from: u32,
    /// Last instant, or [`ALWAYS`].
    pub until: u32,
    /// A cell of the box that stays allowed.
    pub except: Option<CellIndex>,
}

impl Ban {
    /// Whether it forbids a cell while it is in force.
    #[inline]
    pub fn covers(&self, tables: &ExactTables, cell: CellIndex) -> bool {
        let CellPlace { column, row } = tables.place(cell);
        (self.columns.0..=self.columns.1).contains(&column)
            && (self.rows.0..=self.rows.1).contains(&row)
            && self.except != Some(cell)
    }

    /// Whether it is in force at an instant.
    #[inline]
    pub fn holds_at(&self, instant: u32) -> bool {
        self.from <= instant && instant <= self.until
    }
}

/// Constraints of one agent.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AgentConstraint {
    pub bans: Vec<Ban>,
    /// Its arrival does not count before this instant.
    pub least: u32,
    /// Latest arrival, or [`ALWAYS`].
    pub most: u32,
}

impl AgentConstraint {
    /// Instant from which the constraints no longer change.
    fn settled_from(&self) -> u32 {
        let end = |ban: &Ban| if ban.until == ALWAYS { ban.from } else { ban.until + 1 };
        self.bans.iter().map(end).max().unwrap_or(0).max(self.least)
    }

    /// First instant from which it may stay on its goal for good; `None` if never.
    fn may_stay_from(&self, tables: &ExactTables, agent: usize) -> Option<u32> {
        let goal = tables.cell(tables.goal(agent));
        let closing = self.bans.iter().filter(|ban| ban.covers(tables, goal));
        closing.map(|ban| ban.until.checked_add(1)).try_fold(self.least, |least, end| Some(least.max(end?)))
    }

    fn forbids(&self, tables: &ExactTables, cell: CellIndex, instant: u32) -> bool {
        self.bans.iter().any(|ban| ban.holds_at(instant) && ban.covers(tables, cell))
    }

    /// The bans in force at an instant.
    pub fn bans_at(&self, instant: u32) -> impl Iterator<Item = &Ban> {
        self.bans.iter().filter(move |ban| ban.holds_at(instant))
    }
}

/// The budget of a search is spent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OutOfSteps;

/// The least cost at which an agent alone meets its constraints; `None` if it cannot. A* over nodes and instants; once
/// the constraints no longer change, the instant is dropped from the state, so that the search is finite. Charges one
/// step for each expanded node.
pub fn least_cost(
    tables: &ExactTables,
    agent: usize,
    constraint: &AgentConstraint,
    meter: &mut Meter,
) -> Result<Option<u32>, OutOfSteps> {
    let Some(stay_from) = constraint.may_stay_from(tables, agent) else { return Ok(None) };
    let start = tables.start(agent);
    let cost = |node: StagedCell, instant: u32| match tables.distance(agent, node) {
        FAR => None,
        distance => Some((instant + distance).max(stay_from)).filter(|cost| *cost <= constraint.most),
    };
    let Some(first) = cost(start, 0) else { return Ok(None) };
    if constraint.forbids(tables, tables.cell(start), 0) {
        return Ok(None);
    }
    let settled_from = constraint.settled_from();
    let mut open: Vec<Vec<(StagedCell, u32)>> = vec![vec![(start, 0)]];
    let mut closed = FxHashSet::default();
    let mut bucket = 0;
    while bucket < open.len() {
        let Some((node, instant)) = open[bucket].pop() else {
            bucket += 1;
            continue;
        };
        if !closed.insert((node, instant.min(settled_from))) {
            continue;
        }
        meter.step().ok_or(OutOfSteps)?;
        if node == tables.goal(agent) && instant >= stay_from {
            return Ok(Some(instant));
        }
        for next in tables.next(agent, node) {
            let Some(whole) = cost(next, instant + 1) else { continue };
            if constraint.forbids(tables, tables.cell(next), instant + 1)
                || closed.contains(&(next, (instant + 1).min(settled_from)))
            {
                continue;
            }
            let place = (whole - first) as usize;
            if open.len() <= place {
                open.resize_with(place + 1, Vec::new);
            }
            open[place].push((next, instant + 1));
        }
    }
    Ok(None)
}
