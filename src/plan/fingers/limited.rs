//! Plans within limits on reconfigurations and on time.
//!
//! Problem: the least effort of a task whose stretches share a limit on reconfigurations. Method: for each stretch the
//! paths of least effort under decreasing limits on reconfigurations (the ε-constraint method: Haimes, Lasdon, Wismer,
//! IEEE Transactions on Systems, Man and Cybernetics 1, 1971), then the best combination of one path per stretch.
//! Guaranteed: if every path is proven optimal, so is the combination.
//!
//! The duration of a plan also depends on where free fingers wait, which is not part of a grasp. A plan that takes too
//! long is therefore replaced by plans with fewer and fewer reconfigurations, which take most of the time, until one is
//! fast enough. Not guaranteed: that no other plan is, unless the limit is below [`least_s`].

use super::FingersMotion;
use super::Stance;
use super::routes::routes;
use super::sections::Sections;
use super::stretches::{PlannedTask, TaskRequest, TaskStretch, plan_task, stretches};
use crate::claims::fingers::{FingersAction, FingersOrder};
use crate::claims::{Job, Relation};
use crate::device::fingers::FingersOutcome;
use crate::plan::requirements::{Kept, is_upper, keeps};
use crate::plan::{Optimality, Plan};

/// Result of a search within a limit.
pub enum WithinGaits {
    /// A plan that keeps the limit; its bound holds for all plans that do.
    Found(Box<PlannedTask>),
    None {
        is_proven: bool,
    },
}

/// Tightest upper limit on reconfigurations, if a job has one.
pub fn most_gaits(job: &Job) -> Option<u32> {
    let limits = job.requirements.iter().filter(|limit| limit.outcome == FingersOutcome::Reconfigurations.name());
    let most = limits.filter_map(|limit| match limit.relation {
        Relation::AtMost | Relation::Equal => Some(limit.limit.floor()),
        Relation::Less => Some(limit.limit.ceil() - 1.0),
        Relation::AtLeast | Relation::More => None,
    });
    most.min_by(f64::total_cmp).map(|most| most.clamp(0.0, f64::from(u32::MAX)) as u32)
}

/// Result of a search within a limit on time.
pub enum WithinTime {
    /// A plan that keeps all limits.
    Kept(Box<PlannedTask>),
    /// The fastest other plan found.
    Missed(Option<Box<Plan<FingersMotion>>>),
}

/// Most plans with fewer reconfigurations tried for a limit on time.
const MOST_TRIED: u32 = 16;

fn is_kept(job: &Job, plan: &Plan<FingersMotion>, outcome: &str) -> bool {
    let mut limits = job.requirements.iter().filter(|limit| limit.outcome == outcome && is_upper(limit));
    limits.all(|limit| plan.outcomes.get(outcome).is_none_or(|reached| keeps(limit, *reached) == Kept::Yes))
}

/// Whether a plan exceeds a limit on time.
pub fn misses_time(job: &Job, plan: &Plan<FingersMotion>) -> bool {
    !is_kept(job, plan, FingersOutcome::Time.name())
}

/// Searches a plan that is fast enough, given one that is not.
pub fn within_time(sections: &mut Sections, request: &TaskRequest, done: &PlannedTask) -> WithinTime {
    let mut fastest: Option<Plan<FingersMotion>> = None;
    let mut gaits = done.gaits();
    for _ in 0..MOST_TRIED {
        let Some(fewer) = gaits.checked_sub(1) else { break };
        let WithinGaits::Found(mut next) =
            within_gaits(sections, request, done, u32::try_from(fewer).unwrap_or(u32::MAX))
        else {
            break;
        };
        gaits = next.gaits();
        if [FingersOutcome::Time, FingersOutcome::Effort]
            .iter()
            .all(|outcome| is_kept(request.job, &next.plan, outcome.name()))
        {
            // Another plan with as many or more reconfigurations might be fast enough with less effort.
            next.plan.bound = done.plan.bound.min(next.plan.cost);
            next.plan.proof = if next.plan.bound >= next.plan.cost { Optimality::Proven } else { Optimality::Open };
            return WithinTime::Kept(next);
        }
        let time_s = |plan: &Plan<FingersMotion>| {
            plan.outcomes.get(FingersOutcome::Time.name()).copied().unwrap_or(f64::INFINITY)
        };
        if fastest.as_ref().is_none_or(|known| time_s(&next.plan) < time_s(known)) {
            fastest = Some(next.plan);
        }
    }
    WithinTime::Missed(fastest.map(Box::new))
}

/// Lower bound on the duration of any plan, in seconds: its waits, its translations, the least rolling, and the time of
/// two fingers to come and to leave wherever the part is taken and released.
pub fn least_s(sections: &Sections, order: &FingersOrder, stance: Option<&Stance>) -> f64 {
    let facts = &order.facts;
    let come_s = 2.0 * facts.slow_um() / facts.approach_um_per_s;
    let mut is_held = stance.is_some_and(|stance| stance.hold.grasp.iter().any(|contact| *contact != 0));
    let mut sum_s = 0.0;
    for stretch in stretches(order) {
        let mut takes = false;
        for step in &order.steps[stretch.clone()] {
            match &step.action {
                FingersAction::Wait(duration_ns) => sum_s += *duration_ns as f64 / 1e9,
                FingersAction::Translate(by_um) => {
                    sum_s += nalgebra::Vector3::from(*by_um).norm() / facts.rolling_um_per_s;
                    takes = true;
                }
                FingersAction::Release => sum_s += if takes || is_held { come_s } else { 0.0 },
                FingersAction::Grasp(_) | FingersAction::Rotate { .. } | FingersAction::Orient { .. } => takes = true,
            }
        }
        sum_s += if takes && !is_held { come_s } else { 0.0 };
        let planned = routes(order, stretch, None);
        let way_um = |route: &crate::plan::fingers::routes::TurnRoute| {
            let ways = route.iter().map(|turning| {
                f64::from(turning.turn.steps.unsigned_abs()) * sections.least_way_um(turning.turn.plane)
            });
            ways.sum::<f64>()
        };
        let searched_um = planned.routes.iter().map(way_um).fold(f64::INFINITY, f64::min);
        // Routes that were left out may roll in any plane, so their bound is 0.
        let left_out_um = planned.left_out.map_or(f64::INFINITY, |_| 0.0);
        sum_s += searched_um.min(left_out_um) / facts.rolling_um_per_s;
        is_held = false;
    }
    // Allows for rounding in the sums.
    sum_s * (1.0 - 1e-9)
}

/// Candidate paths of one stretch.
struct Front {
    /// In order of decreasing numbers of reconfigurations.
    ways: Vec<TaskStretch>,
    /// Whether each of them is proven best, and no other path can be part of a best plan.
    is_whole: bool,
}

/// The plan of least effort with at most `most` reconfigurations, given one that has more.
pub fn within_gaits(sections: &mut Sections, request: &TaskRequest, any: &PlannedTask, most: u32) -> WithinGaits {
    let count = any.stretches.len();
    let fronts: Vec<Front> = (0..count).map(|at| front(sections, request, any, at, most)).collect();
    let is_whole = fronts.iter().all(|front| front.is_whole);
    let Some((cost, gaits)) = choice(&fronts, most) else { return WithinGaits::None { is_proven: is_whole } };
    let gaits = gaits.into_iter().map(Some).collect();
    let Ok(mut done) = plan_task(sections, &TaskRequest { gaits, ..request.clone() }) else {
        return WithinGaits::None { is_proven: false };
    };
    if done.gaits() > u64::from(most) {
        return WithinGaits::None { is_proven: false };
    }
    let plan = &mut done.plan;
    plan.proof = Optimality::Open;
    if is_whole && done.stretches.iter().map(|stretch| stretch.cost).sum::<u64>() == cost {
        plan.bound = plan.cost;
        plan.proof = Optimality::Proven;
    } else {
        plan.bound = any.plan.bound.min(plan.cost);
    }
    WithinGaits::Found(Box::new(done))
}

/// Finds the candidate paths of a stretch.
fn front(sections: &mut Sections, request: &TaskRequest, any: &PlannedTask, at: usize, most: u32) -> Front {
    let mut front = Front { ways: vec![any.stretches[at]], is_whole: any.stretches[at].is_best };
    let is_only = any.stretches.len() == 1;
    loop {
        let last = front.ways[front.ways.len() - 1].gaits;
        if last == 0 || is_only && last <= u64::from(most) {
            return front;
        }
        let fewer = u32::try_from(last - 1).unwrap_or(u32::MAX).min(most);
        let mut gaits = vec![None; at];
        gaits.push(Some(fewer));
        match plan_task(sections, &TaskRequest { gaits, ..request.clone() }) {
            // The greedy planner ignores limits.
            Ok(done) if done.stretches[at].gaits >= last => {
                front.is_whole = false;
                return front;
            }
            Ok(done) => {
                let way = done.stretches[at];
                front.is_whole &= way.is_best;
                front.ways.push(way);
            }
            Err(none) => {
                front.is_whole &= none.is_proven(request.order);
                return front;
            }
        }
    }
}

/// The least cost of one path per stretch, and the reconfigurations of each; `None` if every combination has too many.
fn choice(fronts: &[Front], most: u32) -> Option<(u64, Vec<u32>)> {
    let most = u64::from(most);
    // Partial choices as (reconfigurations, cost, reconfigurations of each stretch), none of which dominates another.
    let mut chosen: Vec<(u64, u64, Vec<u32>)> = vec![(0, 0, Vec::new())];
    for front in fronts {
        let mut longer: Vec<(u64, u64, Vec<u32>)> = Vec::new();
        for (gaits, cost, ways) in &chosen {
            for way in front.ways.iter().filter(|way| gaits + way.gaits <= most) {
                let own = u32::try_from(way.gaits).unwrap_or(u32::MAX);
                let ways = ways.iter().copied().chain([own]).collect();
                longer.push((gaits + way.gaits, cost + way.cost, ways));
            }
        }
        longer.sort();
        let mut least = u64::MAX;
        longer.retain(|(_, cost, _)| {
            let is_less = *cost < least;
            least = least.min(*cost);
            is_less
        });
        chosen = longer;
    }
    chosen.into_iter().min_by_key(|(gaits, cost, _)| (*cost, *gaits)).map(|(_, cost, ways)| (cost, ways))
}
