//! A remedy for a part that is cut off, tried on the whole task before it is advised.
//!
//! Input: a task, and the blockers without which the part alone has a path. Output: the task without the obstacles
//! among them and, if a part that stays is one of them, with `may_yield: true`, to be planned with all its steps and
//! limits; then the help. Guaranteed: the help mentions a plan only where one was found; otherwise it states what is
//! known of the part alone. Cost: each step of the task may expand one [`SHARE`]th of its budget again.

use crate::claims::electrode_array::{Bystanders, ElectrodeArrayMethod, ElectrodeArrayOrder, ElectrodeArrayPlanner};
use crate::plan::electrode_array::stage::BoardStage;
use crate::plan::errors::{Removal, listed};
use crate::quantity::count;
use std::sync::Arc;

/// 1/N of a step's budget for trying a remedy.
const SHARE: u64 = 4;

/// Most blockers named in a help.
const MAX_NAMED: usize = 6;

/// A task with a part that blockers cut off.
pub struct CutOffPart<'a> {
    pub order: &'a ElectrodeArrayOrder,
    pub stage: &'a BoardStage<'a>,
    /// Indices of the stage's blockers.
    pub blamed: &'a [usize],
    pub removal: Removal,
    /// Name of the part that is cut off.
    pub part: &'a str,
}

/// Result of planning the task with a remedy.
pub enum RemedyOutcome {
    Planned,
    /// Proven: it has no plan with the remedy either.
    Impossible,
    /// Not found within this many expansions for each step.
    NotFound(u64),
    /// Not tried: the planner proves nothing, or a remedy was tried already.
    LeftOut,
}

impl CutOffPart<'_> {
    /// The help of the report; `None` if no blocker is known.
    pub fn help(&self, outcome: RemedyOutcome) -> Option<String> {
        if self.blamed.is_empty() {
            return None;
        }
        let alone = format!("without {} `{}` has a path", self.names(self.blamed), self.part);
        Some(match outcome {
            RemedyOutcome::Planned => format!("{} there is a plan{}", self.remedy(), self.extent()),
            RemedyOutcome::Impossible => {
                format!("{alone}{}; but {} the task has no plan either", self.extent(), self.then())
            }
            RemedyOutcome::NotFound(budget) => {
                let within = format!("within {} per step", count(budget, "expansion"));
                format!("{alone}{}; no plan of the task was found {} {within}", self.extent(), self.then())
            }
            RemedyOutcome::LeftOut => format!("{alone}{}; the other parts were not considered", self.extent()),
        })
    }

    fn obstacles(&self) -> Vec<usize> {
        self.blamed.iter().copied().filter(|index| *index < self.order.obstacles.len()).collect()
    }

    fn has_part(&self) -> bool {
        self.obstacles().len() < self.blamed.len()
    }

    /// The remedy that was tried, as text.
    fn remedy(&self) -> String {
        let obstacles = self.obstacles();
        let without = (!obstacles.is_empty()).then(|| format!("without {}", self.names(&obstacles)));
        let yields = self.has_part().then(|| "with `may_yield: true`".to_owned());
        without.into_iter().chain(yields).collect::<Vec<_>>().join(" and ")
    }

    /// The remedy, named where it differs from what opens a path for the part alone: a part that stays is not removed.
    fn then(&self) -> String {
        match self.has_part() {
            true => self.remedy(),
            false => "then".to_owned(),
        }
    }

    fn names(&self, blamed: &[usize]) -> String {
        let names: Vec<String> = self.stage.blockers().map(|blocker| blocker.name()).collect();
        listed(blamed.iter().map(|index| format!("`{}`", names[*index])), MAX_NAMED)
    }

    fn extent(&self) -> &'static str {
        match self.removal {
            Removal::OpensAndIsSmallest | Removal::Unknown => "",
            Removal::Opens => " (the smallest set found)",
        }
    }

    /// The task with the remedy; `None` if no blocker is known, or the planner proves nothing.
    pub fn remedied(&self) -> Option<ElectrodeArrayOrder> {
        if self.blamed.is_empty() || self.order.planner.method != ElectrodeArrayMethod::Portfolio {
            return None;
        }
        let gone = self.obstacles();
        let kept = self.order.obstacles.iter().enumerate().filter(|(index, _)| !gone.contains(index));
        let expansions = self.order.planner.expansions / SHARE;
        Some(ElectrodeArrayOrder {
            obstacles: Arc::new(kept.map(|(_, obstacle)| obstacle.clone()).collect()),
            bystanders: if self.has_part() { Bystanders::Yield } else { self.order.bystanders },
            planner: ElectrodeArrayPlanner { expansions, ..self.order.planner.clone() },
            ..self.order.clone()
        })
    }
}
