//! Reservation table: for each cell, the spans of instants in which a path of another agent forbids it.
//!
//! A position forbids the box of cells nearer than the separation at its own instant and at both neighbouring ones. While an agent
//! moves one cell, only one row or column of the box changes, so a path of `L` moves has about `(2s - 1) (2s - 1 + L)` spans, and
//! adding or removing it costs no more than that.

use crate::plan::electrode_array::board::{CellIndex, Instance};

/// The instant after all others.
pub(super) const NEVER: u32 = u32::MAX;

/// Mark of the spans of an agent on the goal where it merges.
const PARKED: u32 = 1 << 31;

/// Mark of the spans around the start of an agent without a path yet.
const HAZARD: u32 = 1 << 30;

/// A span of instants `from..to` in which its owner forbids a cell. The owner is twice the agent, plus one for the second of the
/// two paths that it can have while it is replanned, plus a mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct ReservedSpan {
    from: u32,
    to: u32,
    owner: u32,
}

impl ReservedSpan {
    #[inline]
    fn agent(self) -> u32 {
        self.version() as u32 / 2
    }

    /// Index of the path: agent and which of its two.
    #[inline]
    fn version(self) -> usize {
        (self.owner & !(PARKED | HAZARD)) as usize
    }
}

/// Instants `from..to` in which an agent may be on a cell, at a cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct SafeInterval {
    pub(super) from: u32,
    pub(super) to: u32,
    /// Weight of the conflicts with others; 0 where all of them are hard.
    pub(super) cost: u32,
}

/// How the paths of the others constrain a query.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Others {
    /// Conflicts are forbidden.
    Hard,
    /// Conflicts are allowed at a cost.
    Soft,
}

/// The agent for which safe intervals are listed, and what it may ignore.
#[derive(Debug, Clone, Copy)]
pub(super) struct IntervalQuery<'a> {
    pub(super) goal: CellIndex,
    /// The agents with which it merges on its goal.
    pub(super) partners: &'a [u32],
    pub(super) others: Others,
    /// Cost of a soft conflict with each agent; 1 for agents beyond the end of the slice.
    pub(super) weights: &'a [u32],
}

impl IntervalQuery<'_> {
    /// Whether a span is ignored: that of a merge partner, on the common goal or parked on it.
    #[inline]
    fn ignores(&self, cell: CellIndex, span: ReservedSpan) -> bool {
        !self.partners.is_empty()
            && self.partners.contains(&span.agent())
            && (cell == self.goal || span.owner & PARKED != 0)
    }
}

/// The spans of all paths on a board.
#[derive(Debug)]
pub(super) struct Reservations {
    width: u32,
    height: u32,
    reach: u32,
    /// By cell, in order of `from`.
    spans: Vec<Vec<ReservedSpan>>,
    merges: Vec<bool>,
    /// By agent: which of its two owners is its path.
    current: Vec<u32>,
    /// By owner: whether its spans are in force.
    counts: Vec<bool>,
    hazards: usize,
    /// Scratch of [`Reservations::trace`]: the instant at which the cell with these remainders entered the box.
    entered: Vec<u32>,
    /// Masks the remainders: a power of two minus one.
    mask: u32,
    /// Number of bits of the mask.
    bits: u32,
    /// Scratch: the spans of one path.
    traced: Vec<(CellIndex, u32, u32)>,
    /// Scratch: changes of the cost of one cell.
    events: Vec<(u32, i64)>,
}

/// More than the sum of all soft costs of a cell.
const HARD: i64 = 1 << 32;

impl Reservations {
    pub(super) fn new(instance: &Instance) -> Reservations {
        let mut merges = vec![false; instance.agents.len()];
        for agent in instance.merges.iter().flatten() {
            merges[*agent] = true;
        }
        let reach = (instance.separation.max(1) - 1).min(instance.board.width().max(instance.board.height()));
        let ring = (2 * reach + 1).next_power_of_two();
        Reservations {
            width: instance.board.width(),
            height: instance.board.height(),
            reach,
            spans: vec![Vec::new(); instance.board.cells()],
            merges,
            current: (0..instance.agents.len() as u32).map(|agent| 2 * agent).collect(),
            counts: vec![true; 2 * instance.agents.len()],
            hazards: 0,
            entered: vec![0; ring as usize * ring as usize],
            mask: ring - 1,
            bits: ring.trailing_zeros(),
            traced: Vec::new(),
            events: Vec::new(),
        }
    }

    /// Enters the path of an agent.
    pub(super) fn add(&mut self, agent: usize, path: &[CellIndex]) {
        self.each_part(agent, self.current[agent], path, Reservations::insert);
    }

    /// Removes the path that [`Reservations::add`] entered.
    pub(super) fn remove(&mut self, agent: usize, path: &[CellIndex]) {
        self.each_part(agent, self.current[agent], path, Reservations::delete);
    }

    /// Suspends the path of an agent until [`Reservations::accept`] or [`Reservations::reject`].
    pub(super) fn hide(&mut self, agent: usize) {
        self.counts[self.current[agent] as usize] = false;
    }

    /// Enters a second path of an agent whose path is hidden.
    pub(super) fn add_instead(&mut self, agent: usize, path: &[CellIndex]) {
        self.each_part(agent, self.current[agent] ^ 1, path, Reservations::insert);
    }

    /// Removes the hidden path of an agent for good and keeps the second one.
    pub(super) fn accept(&mut self, agent: usize, hidden: &[CellIndex]) {
        self.remove(agent, hidden);
        self.counts[self.current[agent] as usize] = true;
        self.current[agent] ^= 1;
    }

    /// Restores the hidden path of an agent and removes the second one, if any.
    pub(super) fn reject(&mut self, agent: usize, instead: Option<&[CellIndex]>) {
        if let Some(path) = instead {
            self.each_part(agent, self.current[agent] ^ 1, path, Reservations::delete);
        }
        self.counts[self.current[agent] as usize] = true;
    }

    /// Enters the start of an agent as a soft hazard for instants before `to`.
    pub(super) fn add_hazard(&mut self, agent: usize, start: CellIndex, to: u32) {
        self.hazards += 1;
        self.trace(&[start], 0, to);
        self.insert(self.current[agent] | HAZARD);
    }

    /// Removes the hazard that [`Reservations::add_hazard`] entered.
    pub(super) fn remove_hazard(&mut self, agent: usize, start: CellIndex) {
        self.hazards -= 1;
        self.trace(&[start], 0, NEVER);
        self.delete(self.current[agent] | HAZARD);
    }

    /// Traces a path, with the stay on a common goal as a separate part, and applies `act` to each part.
    fn each_part(&mut self, agent: usize, owner: u32, path: &[CellIndex], act: impl Fn(&mut Reservations, u32)) {
        if !self.merges[agent] {
            self.trace(path, 0, NEVER);
            return act(self, owner);
        }
        let (goal, way) = path.split_last().expect("a path has a position");
        if !way.is_empty() {
            self.trace(way, 0, path.len() as u32);
            act(self, owner);
        }
        self.trace(&[*goal], (path.len() as u32 - 1).saturating_sub(1), NEVER);
        act(self, owner | PARKED);
    }

    /// Lists the spans of a path: those of its first position begin at `from`, those of its last end at `to`.
    fn trace(&mut self, path: &[CellIndex], from: u32, to: u32) {
        self.traced.clear();
        let mut at = path[0];
        self.enter(self.rectangle(at), from);
        for (instant, cell) in path.iter().enumerate().skip(1) {
            if *cell == at {
                continue;
            }
            let (old, new) = (self.rectangle(at), self.rectangle(*cell));
            self.leave(strips(old, new), instant as u32 + 1);
            self.enter(strips(new, old), instant as u32 - 1);
            at = *cell;
        }
        self.leave(self.rectangle(at), to);
    }

    /// The cells of the board that a part at a cell forbids.
    fn rectangle(&self, cell: CellIndex) -> CellRectangle {
        let (column, row) = (cell % self.width, cell / self.width);
        CellRectangle {
            columns: (column.saturating_sub(self.reach), (column + self.reach).min(self.width - 1) + 1),
            rows: (row.saturating_sub(self.reach), (row + self.reach).min(self.height - 1) + 1),
        }
    }

    /// Index in `entered` of a cell of the box: the box is no wider than the ring of remainders.
    #[inline]
    fn slot(&self, column: u32, row: u32) -> usize {
        ((row & self.mask) << self.bits | column & self.mask) as usize
    }

    fn enter(&mut self, cells: CellRectangle, instant: u32) {
        for row in cells.rows.0..cells.rows.1 {
            for column in cells.columns.0..cells.columns.1 {
                let slot = self.slot(column, row);
                self.entered[slot] = instant;
            }
        }
    }

    fn leave(&mut self, cells: CellRectangle, to: u32) {
        for row in cells.rows.0..cells.rows.1 {
            for column in cells.columns.0..cells.columns.1 {
                let from = self.entered[self.slot(column, row)];
                self.traced.push((row * self.width + column, from, to));
            }
        }
    }

    fn insert(&mut self, owner: u32) {
        for &(cell, from, to) in &self.traced {
            let spans = &mut self.spans[cell as usize];
            let place = spans.iter().rposition(|span| span.from <= from).map_or(0, |before| before + 1);
            spans.insert(place, ReservedSpan { from, to, owner });
        }
    }

    fn delete(&mut self, owner: u32) {
        for &(cell, from, _) in &self.traced {
            let spans = &mut self.spans[cell as usize];
            if let Some(place) = spans.iter().position(|span| span.owner == owner && span.from == from) {
                spans.remove(place);
            }
        }
    }

    /// Appends the safe intervals of a cell, in order; they contain no hard instants.
    pub(super) fn segments(&mut self, cell: CellIndex, query: &IntervalQuery, out: &mut Vec<SafeInterval>) {
        match query.others {
            Others::Hard if self.hazards == 0 => self.gaps(cell, query, out),
            Others::Hard | Others::Soft => self.levels(cell, query, out),
        }
    }

    fn gaps(&self, cell: CellIndex, query: &IntervalQuery, out: &mut Vec<SafeInterval>) {
        let mut from = 0;
        for span in &self.spans[cell as usize] {
            if !self.counts[span.version()] || query.ignores(cell, *span) {
                continue;
            }
            if span.from > from {
                out.push(SafeInterval { from, to: span.from, cost: 0 });
            }
            from = from.max(span.to);
        }
        if from != NEVER {
            out.push(SafeInterval { from, to: NEVER, cost: 0 });
        }
    }

    fn levels(&mut self, cell: CellIndex, query: &IntervalQuery, out: &mut Vec<SafeInterval>) {
        self.events.clear();
        for span in &self.spans[cell as usize] {
            if !self.counts[span.version()] || query.ignores(cell, *span) {
                continue;
            }
            let soft = query.others == Others::Soft || span.owner & HAZARD != 0;
            let own = || query.weights.get(span.agent() as usize).map_or(1, |weight| i64::from(*weight));
            let weight = if soft { own() } else { HARD };
            self.events.push((span.from, weight));
            self.events.push((span.to, -weight));
        }
        self.events.sort_unstable_by_key(|(instant, _)| *instant);
        let (mut from, mut level) = (0, 0);
        let ends = self.events.iter().copied().chain([(NEVER, 0)]);
        for (instant, change) in ends {
            if instant > from {
                if level < HARD {
                    out.push(SafeInterval { from, to: instant, cost: level as u32 });
                }
                from = instant;
            }
            level += change;
        }
    }

    /// Calls `found` with each agent that conflicts with a path, at least once.
    pub(super) fn conflicts(&self, path: &[CellIndex], query: &IntervalQuery, mut found: impl FnMut(usize)) {
        let mut start = 0;
        while start < path.len() {
            let cell = path[start];
            let stay = path[start..].iter().take_while(|at| **at == cell).count();
            let end = if start + stay == path.len() { NEVER } else { (start + stay) as u32 };
            for span in &self.spans[cell as usize] {
                if span.from >= end {
                    break;
                }
                if span.to > start as u32 && self.counts[span.version()] && !query.ignores(cell, *span) {
                    found(span.agent() as usize);
                }
            }
            start += stay;
        }
    }

    /// The agents whose paths forbid a cell at some instant, in order of the first such instant.
    pub(super) fn visitors(&self, cell: CellIndex) -> impl Iterator<Item = usize> + '_ {
        self.spans[cell as usize].iter().map(|span| span.agent() as usize)
    }
}

/// Columns and rows `from..to`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct CellRectangle {
    columns: (u32, u32),
    rows: (u32, u32),
}

/// The part of the first rectangle outside the second, which is the first moved by one cell.
fn strips(first: CellRectangle, second: CellRectangle) -> CellRectangle {
    let side = |(low, high): (u32, u32), (other_low, other_high): (u32, u32)| {
        if low < other_low { (low, other_low) } else { (other_high, high.max(other_high)) }
    };
    if first.columns != second.columns {
        CellRectangle { columns: side(first.columns, second.columns), rows: first.rows }
    } else {
        CellRectangle { columns: first.columns, rows: side(first.rows, second.rows) }
    }
}

#[cfg(test)]
mod tests;
