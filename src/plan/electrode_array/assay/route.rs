//! Plans the course of one agent through some of its errands, around the courses of the others.
//!
//! Method: safe-interval path planning (Phillips and Likhachev, ICRA 2011) over free spans and the number of errands
//! done. The earliest arrival in a span with the same errands done dominates all later ones. An errand is done as soon
//! as its time has passed at its stop, as a replay of the course sees it too. Among courses that end at the same
//! instant, it prefers those that spend less time where agents enter or are mixed. Guaranteed: the course is legal. Not
//! guaranteed: that a course is found if all of them leave a stop early and do the errand later. Cost: one step for
//! each expanded node.

use super::bookings::{Bookings, FreeSpan, NEVER, SpanQuery};
use super::{AssayProblem, Errand, SplitErrand};
use crate::plan::electrode_array::board::CellIndex;
use crate::plan::electrode_array::fast::{DistanceField, Distances, UNREACHABLE};
use crate::plan::search::Meter;
use fixedbitset::FixedBitSet;
use rustc_hash::FxHashMap;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// No node, and no loop.
const NONE: u32 = u32::MAX;

/// Steps, per unit of separation, for which the parent keeps away from the child's start after a split.
const KEPT_SEPARATIONS: u32 = 3;

/// The distances to the stops of all agents.
pub(super) struct StopDistances {
    /// By agent and errand.
    fields: Vec<Vec<DistanceField>>,
}

impl StopDistances {
    pub(super) fn new(problem: &AssayProblem, distances: &mut Distances, meter: &mut Meter) -> StopDistances {
        let board = &problem.instance.board;
        let mut field = |errand: &Errand| distances.to(board, errand.stop, meter);
        StopDistances {
            fields: problem.errands.iter().map(|errands| errands.iter().map(&mut field).collect()).collect(),
        }
    }

    /// Least steps from a cell to the stop of an errand; a lower bound, since other agents are ignored.
    pub(super) fn steps(&self, agent: usize, errand: usize, from: CellIndex) -> u32 {
        self.fields[agent][errand].from(from)
    }
}

/// Query for one course.
#[derive(Clone, Copy)]
pub(super) struct RouteQuery<'q> {
    pub agent: usize,
    pub start: CellIndex,
    /// The instant at which it is at `start`.
    pub since: u32,
    /// The first errand that is not done yet.
    pub first: usize,
    /// For each errand to do, from `first` on: the instant since which the agent that it meets there has been waiting.
    /// Only the last errand may meet an agent that is not waiting yet.
    pub waits: &'q [Option<u32>],
    /// For each of these errands: the instant at which all its predecessors are done; 0 if it has none.
    pub begins: &'q [u32],
    /// For each of these errands: the earliest arrival at its stop. It holds back an errand that nothing else would
    /// delay.
    pub held: &'q [u32],
    /// The agents with which it has merged already.
    pub past: &'q [usize],
    /// Whether the agent is gone where the course ends.
    pub is_gone: bool,
    /// Whether it enters the board at an instant, not before `since`, that the search chooses.
    pub enters: bool,
    /// Whether it keeps to lanes ([`super::lanes`]) where it can.
    pub keeps_lanes: bool,
    /// Latest end.
    pub limit: u32,
}

/// A course found.
pub(super) struct Course {
    /// The instant at which it enters the board or continues, at its first cell.
    pub since: u32,
    pub cells: Vec<CellIndex>,
    pub ready: u32,
    /// The agents that split off, in order, each with the instant at which it appears.
    pub splits: Vec<(usize, u32)>,
}

impl Course {
    /// Its last instant.
    pub(super) fn end(&self) -> u32 {
        self.since + self.cells.len() as u32 - 1
    }
}

/// Estimated end, time in the way, remaining steps, and index of a node.
type OpenNode = (u32, u32, u32, Reverse<u32>);

#[derive(Debug, Clone, Copy)]
struct RouteNode {
    cell: CellIndex,
    span: u32,
    /// Number of errands done.
    done: u32,
    /// The instant at which it enters the cell, and the later one at which it has done what it can there.
    entered: u32,
    at: u32,
    /// The instant at which the last errand but one was done.
    ready: u32,
    /// Steps spent where another agent may enter or be mixed.
    in_the_way: u32,
    /// The loop in which it was mixed since it entered the cell, and until when; [`NONE`] if it was not mixed.
    mixing: u32,
    mixed: u32,
    /// The instant of its last split; 0 if there was none.
    split: u32,
    parent: u32,
}

/// The search, with buffers that consecutive searches reuse.
pub(super) struct Router<'a> {
    problem: &'a AssayProblem<'a>,
    ahead: &'a StopDistances,
    spans: Vec<FreeSpan>,
    /// By cell and stage of the search: the range of its spans in `spans`.
    listed: FxHashMap<(CellIndex, u32), (u32, u32)>,
    /// The earliest instant, by span and number of errands done.
    earliest: FxHashMap<(u32, u32), u32>,
    /// By cell: whether it is too near to a cell where agents enter or are mixed.
    is_wanted: Vec<bool>,
    nodes: Vec<RouteNode>,
    open: BinaryHeap<Reverse<OpenNode>>,
}

impl<'a> Router<'a> {
    pub(super) fn new(problem: &'a AssayProblem<'a>, ahead: &'a StopDistances) -> Router<'a> {
        let instance = problem.instance;
        let mut is_wanted = vec![false; instance.board.cells()];
        let enters = instance.agents.iter().zip(&problem.enters).filter(|(_, enters)| **enters);
        let loops = problem.loops.iter().flatten().copied();
        for cell in enters.map(|(agent, _)| agent.start).chain(loops) {
            for near in instance.board.around(cell, instance.separation) {
                is_wanted[near as usize] = true;
            }
        }
        Router {
            problem,
            ahead,
            is_wanted,
            spans: Vec::new(),
            listed: FxHashMap::default(),
            earliest: FxHashMap::default(),
            nodes: Vec::new(),
            open: BinaryHeap::new(),
        }
    }

    /// The first instant at which the agent of a query can no longer stay at its start.
    pub(super) fn start_is_free_until(&mut self, query: &RouteQuery, bookings: &Bookings) -> u32 {
        self.clear();
        let search = RouteSearch::new(self.problem, self.ahead, query);
        let span = self.span_at(&search, bookings, query.start, 0, query.since);
        span.map_or(0, |span| self.spans[span as usize].to)
    }

    fn clear(&mut self) {
        self.spans.clear();
        self.listed.clear();
        self.earliest.clear();
        self.nodes.clear();
        self.open.clear();
    }

    /// A course that ends as early as possible; `None` if none is found within the limit or the meter runs out.
    /// It enters no cell of `closed`.
    pub(super) fn course(
        &mut self,
        query: &RouteQuery,
        bookings: &Bookings,
        closed: Option<&FixedBitSet>,
        meter: &mut Meter,
    ) -> Option<Course> {
        self.clear();
        let search = RouteSearch::new(self.problem, self.ahead, query);
        for (span, at) in self.starts(&search, bookings) {
            let (mixing, mixed) = (NONE, 0);
            let start = RouteNode {
                cell: query.start,
                span,
                done: 0,
                entered: at,
                at,
                ready: at,
                in_the_way: 0,
                mixing,
                mixed,
                split: 0,
                parent: NONE,
            };
            self.enter(&search, bookings, start);
        }
        while let Some(Reverse((.., Reverse(index)))) = self.open.pop() {
            let node = self.nodes[index as usize];
            if self.earliest.get(&(node.span, node.done)).is_some_and(|known| *known < node.at) {
                continue;
            }
            meter.step()?;
            if self.is_end(&search, &node) {
                return Some(self.found(index, &search));
            }
            self.expand(&search, bookings, closed, index);
        }
        None
    }

    /// The free spans in which a course may begin, each with its first possible instant.
    fn starts(&mut self, search: &RouteSearch, bookings: &Bookings) -> Vec<(u32, u32)> {
        let RouteQuery { start, since, enters, .. } = *search.query;
        if !enters {
            return self.span_at(search, bookings, start, 0, since).map(|span| (span, since)).into_iter().collect();
        }
        let (first, end) = self.list(search, bookings, start, 0);
        // An agent may enter in the step in which another one leaves: it is on no cell before. But then both are on the
        // cell at that instant, and one may contaminate the other.
        let earliest = |span: u32| {
            let from = self.spans[span as usize].from;
            let at_once = from.saturating_sub(1).max(since);
            if bookings.does_harm(start, search.span_query(self.problem, 0), at_once) {
                from.max(since)
            } else {
                at_once
            }
        };
        (first..end).map(|span| (span, earliest(span))).collect()
    }

    fn is_end(&self, search: &RouteSearch, node: &RouteNode) -> bool {
        node.done == search.last()
            && node.cell == search.goal()
            && (search.query.is_gone || self.spans[node.span as usize].to == NEVER)
    }

    /// The free spans of a cell for an agent that has done `done` errands, as a range in `spans`.
    fn list(&mut self, search: &RouteSearch, bookings: &Bookings, cell: CellIndex, done: u32) -> (u32, u32) {
        let stage = search.stage(done);
        if let Some(known) = self.listed.get(&(cell, stage)) {
            return *known;
        }
        let first = self.spans.len() as u32;
        bookings.free(cell, search.span_query(self.problem, done), &mut self.spans);
        let range = (first, self.spans.len() as u32);
        self.listed.insert((cell, stage), range);
        range
    }

    /// The span of a cell that contains an instant.
    fn span_at(
        &mut self,
        search: &RouteSearch,
        bookings: &Bookings,
        cell: CellIndex,
        done: u32,
        instant: u32,
    ) -> Option<u32> {
        let (first, end) = self.list(search, bookings, cell, done);
        (first..end).find(|span| {
            let FreeSpan { from, to } = self.spans[*span as usize];
            (from..to).contains(&instant)
        })
    }

    fn expand(&mut self, search: &RouteSearch, bookings: &Bookings, closed: Option<&FixedBitSet>, index: u32) {
        let node = self.nodes[index as usize];
        let leave = self.spans[node.span as usize].to;
        for cell in self.problem.instance.board.neighbours(node.cell) {
            if closed.is_some_and(|closed| closed.contains(cell as usize)) {
                continue;
            }
            let (first, end) = self.list(search, bookings, cell, node.done);
            let past = self.spans[first as usize..end as usize].partition_point(|span| span.to <= node.at + 1);
            for span in first + past as u32..end {
                let FreeSpan { from, to } = self.spans[span as usize];
                let at = from.max(node.at + 1);
                if at > leave {
                    break;
                }
                let kept = search.kept_until(self.problem, &node, cell);
                let at = at.max(kept).max(search.held_until(self.problem, node.done, cell));
                if at > leave || at >= to {
                    continue;
                }
                let was_there = if self.is_wanted[node.cell as usize] { at - node.at } else { 0 };
                let in_the_way = node.in_the_way + was_there;
                let next = RouteNode { cell, span, entered: at, at, in_the_way, mixing: NONE, parent: index, ..node };
                self.enter(search, bookings, next);
            }
        }
    }

    /// Does all errands that can be done at once, then adds the node, unless a known node dominates it.
    fn enter(&mut self, search: &RouteSearch, bookings: &Bookings, mut node: RouteNode) {
        while node.done < search.last() {
            let errand = search.errand(node.done);
            if let Some(split) = errand.splits.filter(|split| split.from == node.cell) {
                self.split(search, bookings, &node, errand, split);
                break;
            }
            if search.held_until(self.problem, node.done, node.cell) > node.at {
                return;
            }
            if errand.splits.is_some() || node.cell != errand.stop {
                break;
            }
            if let Some(around) = errand.mixes {
                let Some(mixed) = self.mixed(search, bookings, &node, around, errand.stay) else { break };
                node = mixed;
                continue;
            }
            let to = self.spans[node.span as usize].to;
            let from = node.at.max(search.begins(node.done));
            let at = match (errand.meets, search.query.waits[node.done as usize]) {
                // Where it meets an agent it arrives once, and stays until the other one is there.
                (Some(_), Some(since)) if node.at.max(since) < to => node.at.max(since),
                (Some(_), None) if to == NEVER => node.at,
                (Some(_), Some(_) | None) => return,
                (None, _) if from.saturating_add(errand.stay) < to => from + errand.stay,
                // An agent that enters must be dispensed first.
                (None, _) if search.query.enters && node.done == 0 => return,
                (None, _) => break,
            };
            let Some(span) = self.span_at(search, bookings, node.cell, node.done + 1, at) else { return };
            if node.done + 1 < search.last() {
                node.ready = at;
            }
            (node.span, node.done, node.at) = (span, node.done + 1, at);
        }
        let ahead = search.ahead(node.cell, node.done);
        let total = node.at.saturating_add(ahead);
        if total > search.query.limit {
            return;
        }
        let earliest = self.earliest.entry((node.span, node.done)).or_insert(NEVER);
        if *earliest <= node.at {
            return;
        }
        *earliest = node.at;
        let index = self.nodes.len() as u32;
        self.nodes.push(node);
        self.open.push(Reverse((total, node.in_the_way, ahead, Reverse(index))));
    }

    /// The first instant from which an agent at the corner of a loop can follow it for `steps` steps. It requires all
    /// cells of the loop to be free all that time, which is more than necessary.
    fn loop_window(
        &mut self,
        search: &RouteSearch,
        bookings: &Bookings,
        node: &RouteNode,
        around: &[CellIndex],
        steps: u32,
    ) -> Option<u32> {
        let to = self.spans[node.span as usize].to;
        let mut from = node.at.max(search.begins(node.done));
        let mut checked = 0;
        while checked < around.len() {
            let until = from.saturating_add(steps);
            if until >= to || self.problem.instance.board.is_blocked(around[checked]) {
                return None;
            }
            let (first, end) = self.list(search, bookings, around[checked], node.done);
            let span = (first..end).map(|span| self.spans[span as usize]).find(|span| span.to > until)?;
            checked = if span.from > from { 0 } else { checked + 1 };
            from = from.max(span.from);
        }
        Some(from)
    }

    /// From a node at the corner of a mixing loop, the node after mixing.
    fn mixed(
        &mut self,
        search: &RouteSearch,
        bookings: &Bookings,
        node: &RouteNode,
        around: usize,
        steps: u32,
    ) -> Option<RouteNode> {
        let problem = self.problem;
        let from = self.loop_window(search, bookings, node, &problem.loops[around], steps)?;
        let at = from + steps;
        let span = self.span_at(search, bookings, node.cell, node.done + 1, at)?;
        let parent = self.nodes.len() as u32;
        self.nodes.push(*node);
        let ready = if node.done + 1 < search.last() { at } else { node.ready };
        let (done, entered, mixing) = (node.done + 1, from + 1, around as u32);
        Some(RouteNode { span, done, entered, at, ready, mixing, mixed: at, parent, ..*node })
    }

    /// Adds the nodes after a split, from a node where it begins: one for each free span of the cell to which the
    /// parent goes.
    fn split(
        &mut self,
        search: &RouteSearch,
        bookings: &Bookings,
        node: &RouteNode,
        errand: Errand,
        split: SplitErrand,
    ) {
        let leave = self.spans[node.span as usize].to;
        let child_start = self.problem.instance.agents[split.child].start;
        let parent = self.nodes.len() as u32;
        self.nodes.push(*node);
        // An agent that it meets next keeps away until the split is done.
        let (first, end) = self.list(search, bookings, errand.stop, node.done);
        for span in first..end {
            let FreeSpan { from, to } = self.spans[span as usize];
            let (first, end) = self.list(search, bookings, child_start, node.done);
            let both = (first..end).map(|child| self.spans[child as usize]).find_map(|child| {
                let at = from.max(child.from).max(node.at + 1).max(search.begins(node.done).saturating_add(1));
                (at < to.min(child.to)).then_some(at)
            });
            let Some(at) = both.filter(|at| *at <= leave) else { continue };
            let Some(span) = self.span_at(search, bookings, errand.stop, node.done + 1, at) else { continue };
            let ready = if node.done + 1 < search.last() { at } else { node.ready };
            let (cell, done) = (errand.stop, node.done + 1);
            let next = RouteNode { cell, span, done, entered: at, at, ready, mixing: NONE, split: at, parent, ..*node };
            self.enter(search, bookings, next);
        }
    }

    /// The latest instant at which an entering agent can be dispensed in the span of its first node; before it has
    /// been, the agents that it meets later keep away. If it does more errands there at once, no later than it does
    /// them.
    fn latest_dispensed(&self, search: &RouteSearch, first: &RouteNode) -> u32 {
        let listed = self.listed.get(&(first.cell, search.stage(0))).filter(|_| first.done == 1);
        let spans = listed.map_or([].as_slice(), |(first, end)| &self.spans[*first as usize..*end as usize]);
        let holds = |span: &&FreeSpan| (span.from.saturating_sub(1)..span.to).contains(&first.entered);
        spans.iter().find(holds).map_or(first.at, |span| (span.to - 1).max(first.at))
    }

    fn found(&self, end: u32, search: &RouteSearch) -> Course {
        let RouteQuery { since, enters, .. } = *search.query;
        let mut chain = vec![self.nodes[end as usize]];
        while let Some(node) = chain.last().filter(|node| node.parent != NONE) {
            chain.push(self.nodes[node.parent as usize]);
        }
        // An agent enters no earlier than it must to leave its start when it does.
        let (mut came, mut ready) = (since, chain[0].ready);
        if let ([.., next, first], true) = (chain.as_slice(), enters) {
            let idle = (next.entered - 1 - first.at).min(self.latest_dispensed(search, first) - first.at);
            ready += if ready <= first.at { idle } else { 0 };
            came = first.entered + idle;
        } else if enters {
            came = chain[0].entered;
        }
        let mut cells: Vec<CellIndex> = Vec::new();
        let pairs = chain.windows(2).rev().filter(|pair| pair[0].split != pair[1].split);
        let split = |pair: &[RouteNode]| {
            let split = search.errand(pair[1].done).splits?;
            Some((split.child, pair[0].split))
        };
        let splits = pairs.filter_map(split).collect();
        for node in chain.iter().rev() {
            let before = cells.last().copied().unwrap_or(search.query.start);
            cells.resize(node.entered.saturating_sub(came) as usize, before);
            if let Some(around) = self.problem.loops.get(node.mixing as usize) {
                let steps = node.mixed + 1 - node.entered;
                cells.extend((1..=steps as usize).map(|step| around[step % around.len()]));
            }
            cells.resize((node.at + 1).saturating_sub(came) as usize, node.cell);
        }
        Course { since: came, cells, ready, splits }
    }
}

/// A query with the data that the search derives from it.
struct RouteSearch<'q> {
    query: &'q RouteQuery<'q>,
    ahead: &'q StopDistances,
    errands: &'q [Errand],
    /// Least steps from the end of each errand to the end of the course.
    rest: Vec<u32>,
    /// The waiting agents that it meets, in order, each with the cell of the meeting.
    meetings: Vec<(usize, CellIndex)>,
    /// By errands done: number of `meetings` that are under way or over.
    met: Vec<usize>,
    /// By errands done: the stage of the search. Within one stage, the same cells are free at the same instants.
    stages: Vec<u32>,
}

impl<'q> RouteSearch<'q> {
    fn new(problem: &'q AssayProblem, ahead: &'q StopDistances, query: &'q RouteQuery<'q>) -> RouteSearch<'q> {
        let errands = &problem.errands[query.agent][query.first..query.first + query.waits.len()];
        let mut rest = vec![0u32; errands.len()];
        for index in (1..errands.len()).rev() {
            let way = ahead.steps(query.agent, query.first + index, errands[index - 1].stop);
            rest[index - 1] = rest[index].saturating_add(way).saturating_add(errands[index].stay);
        }
        let (mut meetings, mut met) = (Vec::new(), Vec::with_capacity(errands.len() + 1));
        for (errand, since) in errands.iter().zip(query.waits) {
            if let (Some(other), Some(_)) = (errand.meets, since) {
                meetings.push((other, errand.stop));
            }
            met.push(meetings.len());
        }
        met.push(meetings.len());
        let mut search = RouteSearch { query, ahead, errands, rest, meetings, met, stages: vec![0] };
        for done in 1..=errands.len() {
            let contents = [done - 1, done].map(|done| search.content(problem, done));
            let is_other = search.met[done] != search.met[done - 1] || contents[0] != contents[1];
            search.stages.push(search.stages[done - 1] + u32::from(is_other));
        }
        search
    }

    /// Its contents after `done` errands of the query; `None` where traces do not matter.
    fn content(&self, problem: &AssayProblem, done: usize) -> Option<usize> {
        let contents = &problem.traces.as_ref()?.contents[self.query.agent];
        contents.get(self.query.first + done).copied()
    }

    fn stage(&self, done: u32) -> u32 {
        self.stages[done as usize]
    }

    /// The query by which free spans are listed.
    fn span_query(&self, problem: &AssayProblem, done: u32) -> SpanQuery<'_> {
        let content = self.content(problem, done as usize);
        SpanQuery {
            agent: self.query.agent,
            past: self.query.past,
            met: &self.meetings[..self.met[done as usize]],
            content,
            since: self.query.since,
        }
    }

    fn last(&self) -> u32 {
        self.errands.len() as u32
    }

    fn errand(&self, index: u32) -> Errand {
        self.errands[index as usize]
    }

    /// The last cell of the course.
    fn goal(&self) -> CellIndex {
        self.errands.last().map_or(self.query.start, |errand| errand.stop)
    }

    /// The first instant at which a parent may come too near to the start of its child; the child goes first.
    fn kept_until(&self, problem: &AssayProblem, node: &RouteNode, cell: CellIndex) -> u32 {
        let separation = problem.instance.separation;
        let last = node.done.checked_sub(1).and_then(|last| self.errand(last).splits);
        let is_near = |split: SplitErrand| {
            problem.instance.board.apart(cell, problem.instance.agents[split.child].start) < separation
        };
        match last.filter(|split| is_near(*split)) {
            Some(_) => node.split.saturating_add(separation.saturating_mul(KEPT_SEPARATIONS)),
            None => 0,
        }
    }

    /// The instant from which the next errand may begin.
    fn begins(&self, done: u32) -> u32 {
        self.query.begins.get(done as usize).copied().unwrap_or(0)
    }

    /// The first instant at which an agent may enter a cell. It may enter its stop when that is no longer held back,
    /// and cells near a meeting not before the two may merge, since until then they keep their separation.
    fn held_until(&self, problem: &AssayProblem, done: u32, cell: CellIndex) -> u32 {
        let Some(errand) = self.errands.get(done as usize) else { return 0 };
        let held = if cell == errand.stop { self.query.held[done as usize] } else { 0 };
        let meets = || errand.meets.is_some() && self.query.waits[done as usize].is_some();
        let is_near = || problem.instance.board.apart(cell, errand.stop) < problem.instance.separation;
        match self.begins(done) {
            begins if begins > 0 && meets() && is_near() => held.max(begins + 1),
            _ => held,
        }
    }

    /// Least steps from a cell to the end of the course.
    fn ahead(&self, cell: CellIndex, done: u32) -> u32 {
        let index = done as usize;
        match self.errands.get(index) {
            Some(errand) => match self.ahead.steps(self.query.agent, self.query.first + index, cell) {
                UNREACHABLE => UNREACHABLE,
                steps => steps.saturating_add(errand.stay).saturating_add(self.rest[index]),
            },
            None => self.ahead.steps(self.query.agent, self.query.first + index - 1, cell),
        }
    }
}
