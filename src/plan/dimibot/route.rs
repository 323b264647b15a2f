//! Planner of a whole task: the best sequence of legs over all stages, including the order of the visits.
//!
//! Problem: from a start through stages, each a cell or a set of cells to be visited in any order; least by an
//! objective, ties broken by the other figures, within limits on all figures. Method: a dynamic programme over the
//! stages, whose state is the cell in which a stage ends; a visit of up to [`super::EXACT_PLACES`] places is solved by
//! the dynamic programme of Held and Karp (1962) over sets. Without limits one best route is kept per state, with
//! limits the Pareto front of routes. Larger visits are ordered by [`super::tour`], and bounded by the same dynamic
//! programme over the bounds of the legs. Guaranteed: `bound` holds for the whole task; optimal where it equals the
//! cost.

use super::field::LatticeField;
use super::lattice::{LatticeCell, ModulePulse};
use super::legs::{Legs, Meters};
use super::programme::{MissingLeg, Mode, NONE, Programme, RouteStage, StageEnd};
use super::tally::MotionTally;
use crate::claims::dimibot::{DimibotMethod, DimibotObjective};
use crate::plan::search::{Meter, SearchBudget};
use rustc_hash::FxHashMap;

/// A task to be planned.
pub struct RouteRequest<'a> {
    pub field: &'a LatticeField,
    pub start: LatticeCell,
    pub stages: &'a [RouteStage],
    pub method: DimibotMethod,
    /// Whether several modules may switch in one pulse.
    pub with_pulses: bool,
    /// Step budget of the searches of one stage.
    pub expansions: u64,
}

/// A planned task.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Route {
    /// The pulses of each stage.
    pub pulses: Vec<Vec<ModulePulse>>,
    /// Figures of the route.
    pub tally: MotionTally,
    /// Lower bound on the objective's figure.
    pub bound: u64,
    /// Whether no route of equal cost is better in the other figures.
    pub is_exact: bool,
}

/// Result of the search for the best route within limits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RouteWithin {
    pub route: Option<Route>,
    /// Whether the search was exhaustive: then `route` is optimal, or `None` proves that there is none.
    pub is_complete: bool,
}

/// Plans a task, for several objectives and limits if necessary.
pub struct Router<'a> {
    request: RouteRequest<'a>,
    legs: Legs<'a>,
}

impl<'a> Router<'a> {
    pub fn new(request: RouteRequest<'a>) -> Self {
        let legs = Legs::new(request.field, request.method, request.with_pulses);
        Router { request, legs }
    }

    /// The best route by an objective.
    ///
    /// # Errors
    /// For each stage, the first leg from the last cell of the stage before that is impossible or was not found.
    pub fn best(&mut self, objective: DimibotObjective) -> Result<Route, Vec<MissingLeg>> {
        let mut meters = self.meters();
        self.reach(objective, &mut meters)?;
        let costs = self.programme(Mode::Best(objective), &mut meters).map_err(|failure| vec![failure])?;
        let Some((tally, last)) = costs.least(objective) else { return Err(Vec::new()) };
        let bound = match costs.is_proven {
            true => tally.of_objective(objective),
            false => {
                let bounds = self.programme(Mode::Bound(objective), &mut meters).map_err(|failure| vec![failure])?;
                let bound = bounds.least(objective).map_or(0, |(tally, _)| tally.of_objective(objective));
                bound.min(tally.of_objective(objective))
            }
        };
        let pulses = self.pulses(&costs, last, &mut meters);
        Ok(Route { pulses, tally, bound, is_exact: costs.is_exact })
    }

    /// The best route by an objective in which no figure exceeds its limit.
    pub fn within(&mut self, objective: DimibotObjective, limits: MotionTally) -> RouteWithin {
        let mut meters = self.meters();
        let Some(least) = self.least(&mut meters) else { return RouteWithin { route: None, is_complete: false } };
        let all = least.iter().fold(MotionTally::default(), |sum, stage| sum.plus(*stage));
        if !all.is_within(limits) {
            return RouteWithin { route: None, is_complete: true };
        }
        let Ok(ways) = self.programme(Mode::Front { limits, least: &least }, &mut meters) else {
            return RouteWithin { route: None, is_complete: false };
        };
        let route = ways.least(objective).map(|(tally, last)| {
            let pulses = self.pulses(&ways, last, &mut meters);
            let bound = if ways.is_exact { tally.of_objective(objective) } else { 0 };
            Route { pulses, tally, bound, is_exact: ways.is_exact }
        });
        RouteWithin { route, is_complete: ways.is_exact }
    }

    fn meters(&self) -> Vec<Meters> {
        self.request.stages.iter().map(|_| Meters::new(self.request.expansions)).collect()
    }

    /// Searches a leg from the last cell of each stage to the cells of the next one, so that the report covers each
    /// part of the task.
    fn reach(&mut self, objective: DimibotObjective, meters: &mut [Meters]) -> Result<(), Vec<MissingLeg>> {
        let mut failures = Vec::new();
        let mut from = self.request.start;
        for (stage, all) in self.request.stages.iter().enumerate() {
            for (place, cell) in all.cells().iter().enumerate() {
                if let Err(reason) = self.legs.best([from, *cell], objective, &mut meters[stage]) {
                    failures.push(MissingLeg { stage, place, from, reason });
                    break;
                }
            }
            from = all.last().unwrap_or(from);
        }
        if failures.is_empty() { Ok(()) } else { Err(failures) }
    }

    /// Lower bound on every figure of each stage; `None` if a leg was not found.
    fn least(&mut self, meters: &mut [Meters]) -> Option<Vec<MotionTally>> {
        let mut from = vec![self.request.start];
        let mut least = Vec::with_capacity(self.request.stages.len());
        for (stage, all) in self.request.stages.iter().enumerate() {
            let mut of_stage = MotionTally::default();
            for place in all.cells() {
                let mut nearest = MotionTally::MAX;
                for cell in &from {
                    nearest = nearest.least(self.least_of_leg([*cell, *place], &mut meters[stage])?);
                }
                of_stage = MotionTally {
                    distance: of_stage.distance.max(nearest.distance),
                    switches: of_stage.switches.max(nearest.switches),
                    pulses: of_stage.pulses.max(nearest.pulses),
                };
            }
            least.push(of_stage);
            if !all.cells().is_empty() {
                from = all.cells().to_vec();
            }
        }
        Some(least)
    }

    fn least_of_leg(&mut self, ends: [LatticeCell; 2], meters: &mut Meters) -> Option<MotionTally> {
        let mut least = MotionTally::default();
        for objective in self.legs.objectives() {
            let bound = self.legs.best(ends, *objective, meters).ok()?.bound;
            let only = MotionTally::only(*objective, bound);
            least = least.plus(only);
        }
        if !self.request.with_pulses {
            least.pulses = least.switches;
        }
        Some(least)
    }

    fn programme<'m>(&mut self, mode: Mode<'m>, meters: &mut [Meters]) -> Result<Programme<'m>, MissingLeg>
    where
        'a: 'm,
    {
        let mut programme = Programme {
            mode,
            stages: self.request.stages,
            nodes: Vec::new(),
            states: vec![StageEnd { cell: self.request.start, ways: vec![(MotionTally::default(), NONE)] }],
            fronts: FxHashMap::default(),
            steps: Meter::new(SearchBudget::of(self.request.expansions)),
            is_exact: true,
            is_proven: true,
        };
        for (stage, meters) in meters.iter_mut().enumerate() {
            programme.extend(stage, &mut self.legs, meters)?;
        }
        Ok(programme)
    }

    /// The pulses of a route, by stage.
    fn pulses(&mut self, programme: &Programme, last: u32, meters: &mut [Meters]) -> Vec<Vec<ModulePulse>> {
        let mut pulses = vec![Vec::new(); self.request.stages.len()];
        let mut at = last;
        while let Some(node) = programme.nodes.get(at as usize) {
            let leg = match programme.mode {
                Mode::Best(objective) | Mode::Bound(objective) => {
                    let best = self.legs.best(node.ends, objective, &mut meters[node.stage]);
                    best.expect("each leg of a route is cached").pulses
                }
                Mode::Front { .. } => {
                    programme.fronts[&(node.stage, node.ends[0], node.ends[1])].ways[node.choice].1.clone()
                }
            };
            pulses[node.stage].extend(leg.into_iter().rev());
            at = node.before;
        }
        pulses.iter_mut().for_each(|stage| stage.reverse());
        pulses
    }
}
