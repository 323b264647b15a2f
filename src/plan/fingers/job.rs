//! Planner of one job of a hand: first without limits, then within the limits that this plan exceeds.

use super::limited::{self, WithinTime};
use super::looks::LooksBudget;
use super::sections::Sections;
use super::stretches::{FirstCriterion, LeftOpen, PlannedTask, TaskRequest, most_looks, plan_task};
use super::why::{no_plan, not_followed};
use super::{FingersMotion, Stance};
use crate::claims::fingers::FingersOrder;
use crate::claims::{Job, Requirement};
use crate::device::fingers::FingersOutcome;
use crate::diagnostic::Sink;
use crate::plan::requirements::{Kept, KnownLimit, require};
use crate::plan::{KindPlanner, Optimality, Plan};
use std::collections::BTreeMap;
use std::rc::Rc;

/// Stance of the hand and its part after a job, and the choices that the plan left open.
#[derive(Clone)]
struct LeftStance {
    stance: Stance,
    open: LeftOpen,
}

/// State carried from job to job of a schedule.
#[derive(Default)]
pub struct HandStandings {
    /// By device; `None` after a job without a plan, since the pose of the part is then unknown.
    stances: BTreeMap<String, Option<LeftStance>>,
}

impl KindPlanner for FingersOrder {
    /// `false`: a task takes into account every grasp with which the one before could have ended, see [`LeftOpen`].
    fn chooses_its_end(&self) -> bool {
        false
    }
}

/// Plans a job. `None` after an error was pushed, for this job or an earlier one of the same hand.
pub fn plan(
    job: &Job,
    order: &FingersOrder,
    standing: &mut HandStandings,
    sink: &mut Sink,
) -> Option<Plan<FingersMotion>> {
    let known = standing.stances.get(&job.device).cloned();
    let planned = match known {
        Some(None) => None,
        Some(Some(left)) => planned(job, order, Some(left), sink),
        None => planned(job, order, None, sink),
    };
    let (plan, left) = planned.map_or((None, None), |(plan, left)| (plan, Some(left)));
    standing.stances.insert(job.device.clone(), left);
    plan
}

/// A plan, and the stance that it leaves.
fn planned(
    job: &Job,
    order: &FingersOrder,
    left: Option<LeftStance>,
    sink: &mut Sink,
) -> Option<(Option<Plan<FingersMotion>>, LeftStance)> {
    let open = left.as_ref().map_or(LeftOpen::default(), |left| left.open);
    let stance = left.map(|left| left.stance);
    let looks = Rc::new(LooksBudget::of(most_looks(order)));
    let Ok(mut sections) = Sections::of(order, looks) else {
        sink.push(not_followed(order));
        return None;
    };
    let mut request =
        TaskRequest { job, order, stance: stance.as_ref(), open, first: FirstCriterion::Effort, gaits: Vec::new() };
    let mut done = match plan_task(&mut sections, &request) {
        Ok(done) => done,
        Err(none) => {
            sink.push(no_plan(&request, *none));
            return None;
        }
    };
    let (mut fewest, mut none_keeps_all) = (None, false);
    if let Some(most) = limited::most_gaits(job).filter(|most| u64::from(*most) < done.gaits()) {
        match limited::within_gaits(&mut sections, &request, &done, most) {
            limited::WithinGaits::Found(within) => done = *within,
            limited::WithinGaits::None { is_proven } => {
                none_keeps_all = is_proven;
                request.first = FirstCriterion::Reconfigurations;
                let least = plan_task(&mut sections, &request).ok();
                fewest = least.map(|least| least.plan).filter(|plan| plan.proof == Optimality::Proven);
            }
        }
    }
    let mut fastest = None;
    if limited::misses_time(job, &done.plan) {
        match limited::within_time(
            &mut sections,
            &TaskRequest { first: FirstCriterion::Effort, ..request.clone() },
            &done,
        ) {
            WithinTime::Kept(faster) => done = *faster,
            WithinTime::Missed(plan) => fastest = plan.map(|plan| *plan),
        }
    }
    let PlannedTask { plan, end, open, .. } = done;
    let least_effort_rad = plan.bound.to_radians();
    let least_s = limited::least_s(&sections, order, stance.as_ref());
    let known = &mut |limit: &Requirement| KnownLimit {
        none_keeps_all,
        least: FingersOutcome::find(&limit.outcome).and_then(|outcome| match outcome {
            FingersOutcome::Effort => Some(least_effort_rad),
            FingersOutcome::Reconfigurations => fewest.as_ref().map(|plan| plan.outcomes[outcome.name()]),
            FingersOutcome::Time => Some(least_s),
        }),
        other: if limit.outcome == FingersOutcome::Time.name() { &fastest } else { &fewest }
            .clone()
            .map(|plan| plan.map(drop)),
        ..KnownLimit::default()
    };
    let kept = require(job, &plan, known, sink);
    Some(((kept == Kept::Yes).then_some(plan), LeftStance { stance: end, open }))
}
