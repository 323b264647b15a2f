//! Dynamic programme over the stages of a task. Its state is the cell in which a stage ends; for each state it keeps
//! the partial routes that may be part of a best route.

use super::labels::LabelFront;
use super::lattice::{LatticeCell, ModulePulse};
use super::legs::{Legs, Meters, NoLeg};
use super::tally::{MotionTally, add_to_front};
use super::tour::{TourCosts, ascent, improved};
use crate::claims::dimibot::DimibotObjective;
use crate::plan::search::Meter;
use rustc_hash::FxHashMap;

/// Most places of a visit whose order is proven best.
pub const EXACT_PLACES: usize = 12;

pub(super) const NONE: u32 = u32::MAX;
/// Table cost of a leg that the limits forbid.
const FORBIDDEN: u64 = 1 << 44;

/// One stage of a task.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RouteStage {
    /// To this cell.
    To(LatticeCell),
    /// To all these cells, in the best order.
    All(Vec<LatticeCell>),
}

impl RouteStage {
    pub(super) fn cells(&self) -> &[LatticeCell] {
        match self {
            RouteStage::To(cell) => std::slice::from_ref(cell),
            RouteStage::All(cells) => cells,
        }
    }

    /// The cell written last.
    pub(super) fn last(&self) -> Option<LatticeCell> {
        self.cells().last().copied()
    }

    fn is_large(&self) -> bool {
        self.cells().len() > EXACT_PLACES
    }
}

/// A leg that was not found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MissingLeg {
    pub stage: usize,
    /// Index into the stage's cells.
    pub place: usize,
    pub from: LatticeCell,
    pub reason: NoLeg,
}

/// Rule for the partial routes that a state keeps.
#[derive(Clone, Copy)]
pub(super) enum Mode<'m> {
    /// The best one.
    Best(DimibotObjective),
    /// A lower bound on all of them, in the objective's figure only.
    Bound(DimibotObjective),
    /// The Pareto front within the limits. `least` is a lower bound for each stage.
    Front { limits: MotionTally, least: &'m [MotionTally] },
}

/// A leg of a partial route, and the node of the legs before it.
pub(super) struct ProgrammeNode {
    pub(super) before: u32,
    pub(super) stage: usize,
    pub(super) ends: [LatticeCell; 2],
    /// Index into the alternatives of this leg.
    pub(super) choice: usize,
}

/// Figures of a partial route, and its last node.
pub(super) type WayFigures = (MotionTally, u32);

/// A cell in which a stage may end.
pub(super) struct StageEnd {
    pub(super) cell: LatticeCell,
    pub(super) ways: Vec<WayFigures>,
}

pub(super) struct Programme<'p> {
    pub(super) mode: Mode<'p>,
    pub(super) stages: &'p [RouteStage],
    pub(super) nodes: Vec<ProgrammeNode>,
    pub(super) states: Vec<StageEnd>,
    pub(super) fronts: FxHashMap<(usize, LatticeCell, LatticeCell), LabelFront<Vec<ModulePulse>>>,
    /// Budget of joins of partial routes and legs within limits.
    pub(super) steps: Meter,
    /// Whether nothing was pruned that may be better in any figure.
    pub(super) is_exact: bool,
    /// Whether nothing was pruned that may be better in the objective's figure.
    pub(super) is_proven: bool,
}

/// Leg searches, budgets and limits of one stage.
struct Searches<'s, 'f> {
    stage: usize,
    legs: &'s mut Legs<'f>,
    meters: &'s mut Meters,
    /// Limits on one leg of this stage.
    leg_limits: MotionTally,
    /// Limits on a partial route to the end of this stage.
    way_limits: MotionTally,
}

/// Indexed by the two places: figures of the alternative legs between them.
type Between = Vec<Vec<Vec<MotionTally>>>;

impl Programme<'_> {
    /// Extends the partial routes by one stage.
    pub(super) fn extend(&mut self, stage: usize, legs: &mut Legs, meters: &mut Meters) -> Result<(), MissingLeg> {
        let (leg_limits, way_limits) = self.limits(stage);
        let mut searches = Searches { stage, legs, meters, leg_limits, way_limits };
        let stages = self.stages;
        let places = stages[stage].cells();
        if places.is_empty() {
            return Ok(());
        }
        let entries = self.entries(places, &mut searches)?;
        self.states = match &stages[stage] {
            RouteStage::To(cell) => entries.into_iter().map(|ways| StageEnd { cell: *cell, ways }).collect(),
            RouteStage::All(_) => {
                let between = self.between(places, &mut searches)?;
                match stages[stage].is_large() {
                    false => self.in_best_order(places, entries, &between, &searches),
                    true => self.in_some_order(places, &entries, &between, &mut searches)?,
                }
            }
        };
        Ok(())
    }

    /// The best partial route by an objective.
    pub(super) fn least(&self, objective: DimibotObjective) -> Option<WayFigures> {
        let ways = self.states.iter().flat_map(|state| &state.ways).copied();
        ways.min_by_key(|(tally, _)| tally.key(objective))
    }

    /// Limits on a leg of a stage, and on a partial route to its end.
    fn limits(&self, stage: usize) -> (MotionTally, MotionTally) {
        let Mode::Front { limits, least } = self.mode else { return (MotionTally::MAX, MotionTally::MAX) };
        let sum = |stages: &[MotionTally]| stages.iter().fold(MotionTally::default(), |sum, stage| sum.plus(*stage));
        let (before, after) = (sum(&least[..stage]), sum(&least[stage + 1..]));
        let without = |taken: MotionTally| limits.minus(taken).unwrap_or_default();
        (without(before.plus(after)), without(after))
    }

    /// Figures of the alternative legs from one cell to another.
    fn options(
        &mut self,
        ends: [LatticeCell; 2],
        place: usize,
        searches: &mut Searches,
    ) -> Result<Vec<MotionTally>, MissingLeg> {
        let stage = searches.stage;
        let fail = |reason| MissingLeg { stage, place, from: ends[0], reason };
        match self.mode {
            Mode::Best(objective) => {
                let best = searches.legs.best(ends, objective, searches.meters).map_err(fail)?;
                self.is_exact &= best.is_exact;
                self.is_proven &= best.bound == best.tally.of_objective(objective);
                Ok(vec![best.tally])
            }
            Mode::Bound(objective) => {
                let best = searches.legs.best(ends, objective, searches.meters).map_err(fail)?;
                Ok(vec![MotionTally::only(objective, best.bound)])
            }
            Mode::Front { .. } => {
                let key = (stage, ends[0], ends[1]);
                if let Some(front) = self.fronts.get(&key) {
                    return Ok(front.ways.iter().map(|(tally, _)| *tally).collect());
                }
                let back = self.fronts.get(&(stage, ends[1], ends[0])).cloned().map(|mut front| {
                    front.ways.iter_mut().for_each(|(_, pulses)| pulses.reverse());
                    front
                });
                let front = match back {
                    Some(front) => front,
                    None => searches.legs.front(ends, searches.leg_limits, searches.meters).map_err(fail)?,
                };
                self.is_exact &= front.is_complete;
                let tallies = front.ways.iter().map(|(tally, _)| *tally).collect();
                self.fronts.insert(key, front);
                Ok(tallies)
            }
        }
    }

    /// For each place, the partial routes that visit it first in the stage.
    fn entries(&mut self, places: &[LatticeCell], searches: &mut Searches) -> Result<Vec<Vec<WayFigures>>, MissingLeg> {
        let states = std::mem::take(&mut self.states);
        let mut entries = Vec::with_capacity(places.len());
        for (place, cell) in places.iter().enumerate() {
            let mut ways = Vec::new();
            for state in &states {
                let ends = [state.cell, *cell];
                let options = self.options(ends, place, searches)?;
                self.join(&mut ways, &state.ways, ends, &options, searches);
            }
            entries.push(ways);
        }
        Ok(entries)
    }

    fn between(&mut self, places: &[LatticeCell], searches: &mut Searches) -> Result<Between, MissingLeg> {
        let mut between = vec![vec![Vec::new(); places.len()]; places.len()];
        for (a, from) in places.iter().enumerate() {
            for (b, to) in places.iter().enumerate().filter(|(b, _)| *b != a) {
                between[a][b] = self.options([*from, *to], b, searches)?;
            }
        }
        Ok(between)
    }

    /// Extends every route by every leg and adds the results to the routes of a state.
    fn join(
        &mut self,
        ways: &mut Vec<WayFigures>,
        from: &[WayFigures],
        ends: [LatticeCell; 2],
        legs: &[MotionTally],
        searches: &Searches,
    ) {
        for (so_far, before) in from {
            for (choice, leg) in legs.iter().enumerate() {
                let tally = so_far.plus(*leg);
                let node = self.nodes.len() as u32;
                let is_kept = match self.mode {
                    Mode::Best(objective) | Mode::Bound(objective) => {
                        let is_better = ways.first().is_none_or(|(best, _)| tally.key(objective) < best.key(objective));
                        if is_better {
                            *ways = vec![(tally, node)];
                        }
                        is_better
                    }
                    Mode::Front { .. } => {
                        if self.steps.step().is_none() {
                            self.is_exact = false;
                            return;
                        }
                        tally.is_within(searches.way_limits) && add_to_front(ways, tally, node)
                    }
                };
                if is_kept {
                    self.nodes.push(ProgrammeNode { before: *before, stage: searches.stage, ends, choice });
                }
            }
        }
    }

    /// Dynamic programme over sets of places and the last place (Held and Karp).
    fn in_best_order(
        &mut self,
        places: &[LatticeCell],
        entries: Vec<Vec<WayFigures>>,
        between: &Between,
        searches: &Searches,
    ) -> Vec<StageEnd> {
        let n = places.len();
        let all = (1_usize << n) - 1;
        let mut table: Vec<Vec<WayFigures>> = vec![Vec::new(); n << n];
        for (last, ways) in entries.into_iter().enumerate() {
            table[(1 << last) * n + last] = ways;
        }
        for set in 1..all {
            for last in (0..n).filter(|last| set >> last & 1 == 1) {
                let ways = std::mem::take(&mut table[set * n + last]);
                for next in (0..n).filter(|next| set >> next & 1 == 0) {
                    let to = &mut table[(set | 1 << next) * n + next];
                    self.join(to, &ways, [places[last], places[next]], &between[last][next], searches);
                }
            }
        }
        let ends = table.drain(all * n..);
        places.iter().zip(ends).map(|(cell, ways)| StageEnd { cell: *cell, ways }).collect()
    }

    /// A good order of many places, or a lower bound on all orders.
    fn in_some_order(
        &mut self,
        places: &[LatticeCell],
        entries: &[Vec<WayFigures>],
        between: &Between,
        searches: &mut Searches,
    ) -> Result<Vec<StageEnd>, MissingLeg> {
        (self.is_exact, self.is_proven) = (false, false);
        let onward = self.onward(places, searches)?;
        let objectives = match self.mode {
            Mode::Best(objective) => vec![objective],
            Mode::Bound(objective) => {
                return Ok(bounds(places, entries, between, onward.as_deref(), objective));
            }
            Mode::Front { .. } => searches.legs.objectives().to_vec(),
        };
        let mut states: Vec<StageEnd> = Vec::new();
        for objective in objectives {
            let order = improved(&table(entries, between, onward.as_deref(), objective));
            let Some(last) = order.last().map(|node| node - 1) else { continue };
            if let Some(way) = self.along(places, entries, between, &order, objective, searches) {
                states.push(StageEnd { cell: places[last], ways: vec![way] });
            }
        }
        Ok(states)
    }

    /// Figures of the legs to the next stage, if that is a single cell.
    fn onward(
        &mut self,
        places: &[LatticeCell],
        searches: &mut Searches,
    ) -> Result<Option<Vec<Vec<MotionTally>>>, MissingLeg> {
        let Some(RouteStage::To(next)) = self.stages.get(searches.stage + 1) else { return Ok(None) };
        let mut legs = Vec::with_capacity(places.len());
        for (place, cell) in places.iter().enumerate() {
            legs.push(self.options([*cell, *next], place, searches)?);
        }
        Ok(Some(legs))
    }

    /// The route through the places in an order (of nodes of the table).
    fn along(
        &mut self,
        places: &[LatticeCell],
        entries: &[Vec<WayFigures>],
        between: &Between,
        order: &[usize],
        objective: DimibotObjective,
        searches: &Searches,
    ) -> Option<WayFigures> {
        let first = order.first()? - 1;
        let mut way = *entries[first].iter().min_by_key(|(tally, _)| tally.key(objective))?;
        for pair in order.windows(2) {
            let [a, b] = [pair[0] - 1, pair[1] - 1];
            let legs = between[a][b].iter().enumerate();
            let (choice, leg) = legs.min_by_key(|(_, tally)| tally.key(objective))?;
            let node = ProgrammeNode { before: way.1, stage: searches.stage, ends: [places[a], places[b]], choice };
            way = (way.0.plus(*leg), self.nodes.len() as u32);
            self.nodes.push(node);
        }
        way.0.is_within(searches.way_limits).then_some(way)
    }
}

/// Least figure among some legs.
fn least(legs: impl Iterator<Item = MotionTally>, objective: DimibotObjective) -> u64 {
    legs.map(|tally| tally.of_objective(objective)).min().unwrap_or(FORBIDDEN)
}

/// Costs of a tour from the states before the stage to the cell after it.
fn table(
    entries: &[Vec<WayFigures>],
    between: &Between,
    onward: Option<&[Vec<MotionTally>]>,
    objective: DimibotObjective,
) -> TourCosts {
    let n = entries.len();
    let nodes = n + 1 + usize::from(onward.is_some());
    let mut costs = vec![vec![0; nodes]; nodes];
    for a in 0..n {
        costs[0][a + 1] = least(entries[a].iter().map(|(tally, _)| *tally), objective);
        costs[a + 1][0] = costs[0][a + 1];
        for b in (0..n).filter(|b| *b != a) {
            costs[a + 1][b + 1] = least(between[a][b].iter().copied(), objective);
        }
        if let Some(onward) = onward {
            costs[a + 1][n + 1] = least(onward[a].iter().copied(), objective);
            costs[n + 1][a + 1] = costs[a + 1][n + 1];
        }
    }
    let end = onward.map(|_| n + 1);
    if let Some(end) = end {
        // A path must visit the places: no edge leads from the start straight to the end.
        (costs[0][end], costs[end][0]) = (FORBIDDEN, FORBIDDEN);
    }
    TourCosts { costs, end }
}

/// For each place, a lower bound on the routes through all places that end there. If the next stage is a single cell,
/// the bound on the routes up to that cell, minus the leg to it, is used where it is larger. It need not bound the
/// stage alone; only its sum with that leg is claimed to be a bound.
fn bounds(
    places: &[LatticeCell],
    entries: &[Vec<WayFigures>],
    between: &Between,
    onward: Option<&[Vec<MotionTally>]>,
    objective: DimibotObjective,
) -> Vec<StageEnd> {
    let bound = |onward| {
        let table = table(entries, between, onward, objective);
        ascent(&table, table.length(&improved(&table)))
    };
    let free = bound(None);
    let with_end = onward.map(|onward| bound(Some(onward)));
    let of_place = |(place, cell): (usize, &LatticeCell)| {
        let last = onward.map_or(0, |onward| least(onward[place].iter().copied(), objective));
        let figure = free.max(with_end.map_or(0, |bound| bound.saturating_sub(last)));
        StageEnd { cell: *cell, ways: vec![(MotionTally::only(objective, figure), NONE)] }
    };
    places.iter().enumerate().map(of_place).collect()
}
