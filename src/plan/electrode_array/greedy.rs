//! A step of a job by the greedy algorithm of the paper ([`published`]), in the terms of the job.

use super::board::{CellIndex, Paths};
use super::channels;
use super::job::Tasks;
use super::published::{self, Heuristic, PairCheck, PaperReading, PublishedOutcome, Ties, Zero};
use super::stage::{self, BoardStage};
use crate::claims::electrode_array::ElectrodeArrayStep;
use crate::device::electrode_array::{ElectrodeCell, Separation};
use crate::plan::errors;

/// Horizon of the published planner as a multiple of half the board's perimeter; the paper uses 100 steps on a board of
/// 50 by 50 cells.
const PUBLISHED_HORIZON: usize = 4;

/// Pair checks of the published planner that take as long as one node expansion of another planner.
const CHECKS_PER_EXPANSION: u64 = 20;

impl Tasks<'_> {
    /// The paper's algorithm; it is greedy, so its failure proves nothing.
    pub(super) fn as_published(
        &mut self,
        step: &ElectrodeArrayStep,
        stage: &BoardStage,
        heuristic: Heuristic,
    ) -> Option<Paths> {
        let check = match self.order.facts.separation {
            Separation::Apart(_) => PairCheck::Clean,
            Separation::AsPublished => PairCheck::AsPublished(Zero::Printed),
        };
        let facts = &self.order.facts;
        let horizon = PUBLISHED_HORIZON * (facts.columns + facts.rows) as usize;
        let reading = PaperReading { heuristic, check, ties: Ties::default() };
        if !self.affords(stage, horizon) {
            let (what, to) = ("the greedy planner", stage.goals());
            let planner = self.order.planner.method.name();
            self.sink.push(errors::gave_up(step.span, &to, what, self.order.planner.expansions, "0 steps", planner));
            return None;
        }
        let bounds = match super::fast::bounds(&stage.instance) {
            Ok(bounds) => bounds,
            Err(why) => {
                self.impossible(step.span, stage, &why);
                return None;
            }
        };
        let mut paths = Vec::with_capacity(stage.agents.len());
        for (agent, outcome) in published::plan(&stage.instance, reading, horizon).into_iter().enumerate() {
            match outcome {
                PublishedOutcome::Arrived(path) => paths.push(path),
                PublishedOutcome::Stuck(path) => self.stuck(stage, agent, &path, "stuck"),
                PublishedOutcome::OutOfTime(path) => self.stuck(stage, agent, &path, "still on its way"),
            }
        }
        if paths.len() < stage.agents.len() {
            return None;
        }
        if !channels::are_kept_by_paths(&stage.instance, &paths) {
            self.sink.push(errors::heedless_of_channels(step.span));
            return None;
        }
        self.add(&paths, bounds);
        Some(paths)
    }

    /// Whether the budget allows the published planner, which checks every pair of parts at every instant up to its horizon.
    fn affords(&self, stage: &BoardStage, horizon: usize) -> bool {
        let agents = stage.agents.len() as u64;
        let checks = agents.saturating_mul(agents).saturating_mul(horizon as u64);
        checks / CHECKS_PER_EXPANSION <= self.order.planner.expansions
    }

    fn stuck(&mut self, stage: &BoardStage, agent: usize, path: &[CellIndex], how: &str) {
        let actor = &stage.agents[agent];
        let name = &self.order.parts[actor.part].name;
        let at = path.last().map(|cell| stage::cell(self.order, *cell)).unwrap_or(ElectrodeCell::new(1, 1));
        let span = actor.asked.map_or(self.job.run_span, |action| action.span);
        let first = match self.order.facts.separation {
            Separation::Apart(_) => "",
            Separation::AsPublished => "give the device `separation: 4` and ",
        };
        self.sink.push(errors::greedy_gave_up(span, name, &at.to_string(), path.len() - 1, how, first));
    }
}
