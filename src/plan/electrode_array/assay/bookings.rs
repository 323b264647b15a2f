//! Reservation table: the instants at which courses of agents forbid the cells around them.
//!
//! A position at instant `t` forbids the cells nearer than the separation at `t - 1`, `t` and `t + 1`
//! ([`crate::plan::electrode_array::board`]).

use super::AgentCourse;
use super::traces::{Touch, Traces};
use crate::plan::electrode_array::board::{BoardGrid, CellIndex};

/// The instant after all others.
pub(super) const NEVER: u32 = u32::MAX;

/// Activity of an agent while it forbids a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Doing {
    /// It does errands.
    Busy,
    /// It is on its way to the agent that it meets next.
    Approaching,
    /// It waits at the stop where they meet.
    Waiting,
}

/// Instants `from..to` in which an agent forbids a cell.
#[derive(Debug, Clone, Copy)]
struct Booking {
    from: u32,
    to: u32,
    agent: u32,
    doing: Doing,
}

/// The bookings of one cell.
#[derive(Debug, Clone, Default)]
struct CellBookings {
    /// In order of `from`.
    all: Vec<Booking>,
    /// For each of them, the latest end among it and all before it.
    latest: Vec<u32>,
}

impl CellBookings {
    fn insert(&mut self, booking: Booking) {
        let place = self.all.partition_point(|known| known.from <= booking.from);
        let before = place.checked_sub(1).map_or(0, |before| self.latest[before]);
        self.all.insert(place, booking);
        self.latest.insert(place, before.max(booking.to));
        let later = self.latest[place + 1..].iter_mut();
        later.take_while(|latest| **latest < booking.to).for_each(|latest| *latest = booking.to);
    }

    /// Removes the bookings of an agent; none of them begins before `from`.
    fn remove(&mut self, agent: usize, from: u32) {
        let first = self.all.partition_point(|booking| booking.from < from);
        let mut kept = first;
        for index in first..self.all.len() {
            if self.all[index].agent as usize != agent {
                self.all[kept] = self.all[index];
                kept += 1;
            }
        }
        self.all.truncate(kept);
        self.latest.truncate(first);
        let mut latest = first.checked_sub(1).map_or(0, |before| self.latest[before]);
        for booking in &self.all[first..] {
            latest = latest.max(booking.to);
            self.latest.push(latest);
        }
    }

    /// All bookings that end after an instant, and some that end before.
    fn since(&self, instant: u32) -> &[Booking] {
        &self.all[self.latest.partition_point(|latest| *latest <= instant)..]
    }
}

/// Instants `from..to` in which a cell is free.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct FreeSpan {
    pub from: u32,
    pub to: u32,
}

/// The course of an agent.
#[derive(Debug, Clone, Default)]
pub(super) struct BookedCourse {
    pub own: AgentCourse,
    /// The instant from which it only approaches the agent that it meets next.
    pub ready: Option<u32>,
    /// Whether it is gone after the last cell.
    pub is_gone: bool,
    /// Whether it splits off from another agent in the step before its first cell.
    pub is_split_off: bool,
    /// The instants before its splits, in order: each split takes the step that follows.
    pub splits: Vec<u32>,
}

/// The bookings of all courses on a board.
#[derive(Debug)]
pub(super) struct Bookings<'a> {
    board: &'a BoardGrid,
    separation: u32,
    /// By cell.
    bookings: Vec<CellBookings>,
    /// By agent: the cells that it books, in order of booking, possibly repeated.
    touched: Vec<Vec<CellIndex>>,
    /// By agent: the part of its bookings that longer courses do not change.
    firm: Vec<FirmPart>,
    traces: Option<&'a Traces>,
    /// By cell, where traces matter: its visits in order of `from`; and by agent, the cells that it visits.
    touches: Vec<Vec<Touch>>,
    trodden: Vec<Vec<CellIndex>>,
}

/// The part of an agent's bookings that longer courses do not change: all before the last cell, and before the agent is
/// ready for a meeting.
#[derive(Debug, Clone, Copy, Default)]
struct FirmPart {
    /// Number of cells touched.
    touched: usize,
    /// The instant at which it enters the first cell that does not belong to the part.
    until: u32,
}

/// An agent that asks for the free spans of cells.
#[derive(Debug, Clone, Copy)]
pub(super) struct SpanQuery<'q> {
    /// Its own bookings do not block it.
    pub agent: usize,
    /// Agents that it has merged with.
    pub past: &'q [usize],
    /// Agents that it meets, each with the cell where it does.
    pub met: &'q [(usize, CellIndex)],
    /// Its contents by then, where traces matter.
    pub content: Option<usize>,
    /// Instants before this one do not matter to it.
    pub since: u32,
}

impl Bookings<'_> {
    pub(super) fn new<'b>(
        board: &'b BoardGrid,
        separation: u32,
        agents: usize,
        traces: Option<&'b Traces>,
    ) -> Bookings<'b> {
        let bookings = vec![CellBookings::default(); board.cells()];
        let (touched, firm) = (vec![Vec::new(); agents], vec![FirmPart::default(); agents]);
        let (cells, treading) = traces.map_or((0, 0), |_| (board.cells(), agents));
        let (touches, trodden) = (vec![Vec::new(); cells], vec![Vec::new(); treading]);
        Bookings { board, separation, bookings, touched, firm, traces, touches, trodden }
    }

    /// Removes what would block an agent itself before its next search: its traces. Its bookings do not.
    pub(super) fn lift(&mut self, agent: usize) {
        if self.traces.is_some() {
            self.clear(agent);
        }
    }

    /// Removes all bookings of an agent.
    fn clear(&mut self, agent: usize) {
        self.firm[agent] = FirmPart::default();
        self.loosen(agent);
        for cell in self.trodden.get_mut(agent).map(std::mem::take).into_iter().flatten() {
            self.touches[cell as usize].retain(|touch| touch.agent != agent);
        }
    }

    /// Removes the bookings of an agent that are not firm.
    fn loosen(&mut self, agent: usize) {
        let FirmPart { touched, until } = self.firm[agent];
        let mut loose = self.touched[agent].split_off(touched);
        loose.sort_unstable();
        loose.dedup();
        for cell in loose {
            self.bookings[cell as usize].remove(agent, until.saturating_sub(1));
        }
    }

    /// Reserves a cell for an agent without a course at the instants `from..to`; its trace begins and ends at `since`.
    pub(super) fn keep(&mut self, agent: usize, cell: CellIndex, since: u32, from: u32, to: u32) {
        self.clear(agent);
        self.book(agent, cell, from, to, Doing::Busy);
        if let Some(traces) = self.traces {
            let touch = Touch { agent, from: since, to: since, content: traces.contents[agent][0] };
            self.touch(cell, touch);
        }
    }

    /// Records the cells that an agent visits, with its contents.
    fn tread(&mut self, agent: usize, course: &AgentCourse, done_at: &[u32]) {
        let Some(traces) = self.traces else { return };
        for (cell, touch) in traces.touches(agent, course, done_at) {
            self.touch(cell, touch);
        }
    }

    fn touch(&mut self, cell: CellIndex, touch: Touch) {
        let of_cell = &mut self.touches[cell as usize];
        let place = of_cell.partition_point(|known| known.from <= touch.from);
        of_cell.insert(place, touch);
        self.trodden[touch.agent].push(cell);
    }

    /// Replaces the bookings of an agent by those of a course.
    pub(super) fn enter(&mut self, agent: usize, course: &BookedCourse, done_at: &[u32]) {
        match self.traces {
            Some(_) => self.clear(agent),
            None => self.loosen(agent),
        }
        self.tread(agent, &course.own, done_at);
        let AgentCourse { since: first, ref cells } = course.own;
        let ready = course.ready.unwrap_or(NEVER);
        let mut from = first.max(self.firm[agent].until);
        for next in from + 1..=course.own.until() {
            let (is_last, gets_ready) = (next == course.own.until(), next - 1 == ready);
            let cell = cells[(from - first) as usize];
            // Consecutive positions on one cell are one booking, unless the agent's activity changes.
            if !is_last && cells[(next - first) as usize] == cell && !gets_ready {
                continue;
            }
            // A dispensed agent was on no cell in the step before; an agent that splits off was on its way then.
            let since = if from == first && !course.is_split_off { from } else { from.saturating_sub(1) };
            let until = next + 1;
            // An agent that is gone occupies no cell in the step after its last instant. In the step of a split both
            // halves move away; their new cells keep others away then.
            let is_split = course.splits.binary_search(&(until - 2)).is_ok();
            let to = match (is_last, course.is_gone) {
                (true, true) => until - 1,
                (true, false) => NEVER,
                (false, _) if is_split => until - 1,
                (false, _) => until,
            };
            match (from > ready, gets_ready) {
                (true, _) if is_last => self.book(agent, cell, since, to, Doing::Waiting),
                (true, _) => self.book(agent, cell, since, to, Doing::Approaching),
                // The position at which it gets ready counts as part of its approach in the next step.
                (false, true) => {
                    let doing = if is_last { Doing::Waiting } else { Doing::Approaching };
                    self.book(agent, cell, since, until - 1, Doing::Busy);
                    self.book(agent, cell, until - 1, to, doing);
                }
                (false, false) => self.book(agent, cell, since, to, Doing::Busy),
            }
            from = next;
            // The bookings of an agent's first two cells may begin at the same instant.
            if !is_last && from <= ready && from > first + 1 {
                self.firm[agent] = FirmPart { touched: self.touched[agent].len(), until: from };
            }
        }
    }

    fn book(&mut self, agent: usize, cell: CellIndex, from: u32, to: u32, doing: Doing) {
        for near in self.board.around(cell, self.separation) {
            self.bookings[near as usize].insert(Booking { from, to, agent: agent as u32, doing });
            self.touched[agent].push(near);
        }
    }

    /// Appends the free spans of a cell, in order. Spans that end before `since` may be missing or reach too far back.
    pub(super) fn free(&self, cell: CellIndex, query: SpanQuery, out: &mut Vec<FreeSpan>) {
        let SpanQuery { agent, past, met, content, since } = query;
        let is_met = |booking: &Booking| {
            booking.agent as usize == agent
                || past.contains(&(booking.agent as usize))
                || met.iter().any(|(agent, at)| {
                    *agent == booking.agent as usize
                        && match booking.doing {
                            Doing::Busy => false,
                            Doing::Approaching => cell == *at,
                            Doing::Waiting => true,
                        }
                })
        };
        let booked = self.bookings[cell as usize].since(since).iter().filter(|booking| !is_met(booking));
        let booked = booked.map(|booking| (booking.from, booking.to));
        let Some((traces, content)) = self.traces.zip(content) else { return between(booked, out) };
        let mut closed: Vec<(u32, u32)> = booked.collect();
        self.append_closed(cell, traces, content, met, &mut closed);
        closed.sort_unstable();
        between(closed.into_iter(), out);
    }

    /// Whether a visit to a cell at an instant contaminates the agent or, later or at that instant, others.
    pub(super) fn does_harm(&self, cell: CellIndex, SpanQuery { met, content, .. }: SpanQuery, at: u32) -> bool {
        let Some((traces, content)) = self.traces.zip(content) else { return false };
        let mut closed = Vec::new();
        self.append_closed(cell, traces, content, met, &mut closed);
        closed.iter().any(|(from, to)| (*from..*to).contains(&at))
    }

    /// Appends the instants `from..to` at which a content may not be on a cell because of traces.
    fn append_closed(
        &self,
        cell: CellIndex,
        traces: &Traces,
        content: usize,
        met: &[(usize, CellIndex)],
        closed: &mut Vec<(u32, u32)>,
    ) {
        let here = &self.touches[cell as usize];
        let is_other = |touch: &&Touch| !met.contains(&(touch.agent, cell));
        let touches: Vec<Touch> = here.iter().filter(is_other).copied().collect();
        traces.append_closed(&touches, content, closed);
        // At a meeting, the agent comes to the other one itself, not to the trace that it has just left. But a trace
        // that the other one left there before it came back contaminates until then.
        for (other, _) in met.iter().filter(|(_, at)| *at == cell) {
            let Some(back) = here.iter().rfind(|touch| touch.agent == *other) else { continue };
            let is_before =
                |touch: &&Touch| touch.from < back.from && (touch.agent == *other || traces.washes[touch.content]);
            let before: Vec<Touch> = here.iter().filter(is_before).copied().collect();
            let mut dirty = Vec::new();
            traces.append_closed(&before, content, &mut dirty);
            closed.extend(dirty.into_iter().map(|(from, to)| (from, to.min(back.from))));
        }
    }
}

/// Appends the gaps between spans `from..to`, which are in order of `from`.
fn between(closed: impl Iterator<Item = (u32, u32)>, out: &mut Vec<FreeSpan>) {
    let mut free = 0;
    for (from, to) in closed {
        if from > free {
            out.push(FreeSpan { from: free, to: from });
        }
        free = free.max(to);
    }
    if free != NEVER {
        out.push(FreeSpan { from: free, to: NEVER });
    }
}
