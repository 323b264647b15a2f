//! Statistics of the trials.

use super::area::AreaMatch;
use super::trial::{ContactRecord, EndedTrial, FailureReason, TrialFailure};
use crate::plan::microrobots::control::ControlPhase;
use serde::Serialize;

/// Quantile of the normal distribution for a two-sided 95 %.
const Z: f64 = 1.959_963_984_540_054;

/// Mean, 95th percentile and maximum of a quantity.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Spread {
    pub mean: f64,
    pub p95: f64,
    pub max: f64,
}

/// How a robot reached its place, over all trials in which it at least met its structure; absolute errors.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DockingStatistics {
    /// Index into the order's robots.
    pub robot: usize,
    /// Number of times that it met its structure.
    pub count: u64,
    /// Sideways, once it lies flat; for a pair, between the axes.
    pub across_um: Spread,
    /// Along its heading; for a pair, the displacement of the structure.
    pub along_um: Spread,
    /// Between its heading and the normal of the edge at contact; for a pair, between the axes.
    pub incidence_rad: Spread,
    /// Error of its heading in the world, once it lies flat.
    pub heading_rad: Spread,
}

/// Mean, 5th percentile and minimum of a share.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct ShareSpread {
    pub mean: f64,
    pub p5: f64,
    pub min: f64,
}

impl ShareSpread {
    /// Spread of any numbers, in any order; all 0 for none.
    pub fn of(values: Vec<f64>) -> Self {
        let Spread { mean, p95, max } = Spread::of(values.into_iter().map(|value| -value).collect());
        ShareSpread { mean: 0.0 - mean, p5: 0.0 - p95, min: 0.0 - max }
    }
}

/// A kind of failure, with its number of trials.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Failures {
    /// Index into the order's robots.
    pub robot: usize,
    pub reason: FailureReason,
    /// Index into the order's steps.
    pub step: usize,
    /// Phase of the controller.
    pub phase: ControlPhase,
    pub count: u64,
}

/// Outcome of the trials.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SimulationReport {
    /// Names of the order's robots, by index.
    pub names: Vec<String>,
    pub trials: u64,
    pub successes: u64,
    /// 95 % confidence interval of the share of successes.
    pub wilson: [f64; 2],
    /// In the order in which the robots are driven.
    pub dockings: Vec<DockingStatistics>,
    /// Times of the successful trials, in seconds.
    pub time_s: Spread,
    /// Share of the goal structure's area that the robots cover in the successful trials, where they stick.
    pub area_in_place: ShareSpread,
    /// The same once the structure is moved as a whole, so that its first two robots match.
    pub area_of_shape: ShareSpread,
    /// The most frequent first.
    pub failures: Vec<Failures>,
}

/// 95 % confidence interval of the share of successes.
///
/// Source: Wilson, *Probable inference, the law of succession, and statistical inference*, JASA 22 (1927).
pub fn wilson(successes: u64, trials: u64) -> [f64; 2] {
    if trials == 0 {
        return [0.0, 1.0];
    }
    let count = trials as f64;
    let share = successes as f64 / count;
    let scale = 1.0 + Z * Z / count;
    let middle = (share + Z * Z / (2.0 * count)) / scale;
    let half = Z / scale * (share * (1.0 - share) / count + Z * Z / (4.0 * count * count)).sqrt();
    [(middle - half).max(0.0), (middle + half).min(1.0)]
}

impl Spread {
    /// Spread of any numbers, in any order; all 0 for none.
    pub fn of(mut values: Vec<f64>) -> Self {
        if values.is_empty() {
            return Spread::default();
        }
        values.sort_by(f64::total_cmp);
        let rank = (0.95 * values.len() as f64).ceil() as usize;
        Spread {
            mean: values.iter().sum::<f64>() / values.len() as f64,
            p95: values[rank.clamp(1, values.len()) - 1],
            max: values[values.len() - 1],
        }
    }
}

impl SimulationReport {
    /// Report on trials in their order.
    pub fn new(names: Vec<String>, trials: &[EndedTrial]) -> Self {
        let successes = trials.iter().filter(|trial| trial.failure.is_none()).count() as u64;
        let area = |of: fn(&AreaMatch) -> f64| {
            ShareSpread::of(trials.iter().filter_map(|trial| trial.area.as_ref().map(of)).collect())
        };
        let time_s = |trial: &EndedTrial| trial.failure.is_none().then_some(trial.time_ns as f64 / 1e9);
        SimulationReport {
            names,
            trials: trials.len() as u64,
            successes,
            wilson: wilson(successes, trials.len() as u64),
            dockings: dockings(trials),
            area_in_place: area(|area| area.in_place),
            area_of_shape: area(|area| area.of_shape),
            time_s: Spread::of(trials.iter().filter_map(time_s).collect()),
            failures: failures(trials),
        }
    }
}

fn dockings(trials: &[EndedTrial]) -> Vec<DockingStatistics> {
    let mut robots: Vec<usize> = Vec::new();
    for contact in trials.iter().flat_map(|trial| &trial.contacts) {
        if !robots.contains(&contact.robot) {
            robots.push(contact.robot);
        }
    }
    robots.into_iter().map(|robot| docking(robot, trials)).collect()
}

fn docking(robot: usize, trials: &[EndedTrial]) -> DockingStatistics {
    let all: Vec<&ContactRecord> =
        trials.iter().flat_map(|trial| &trial.contacts).filter(|contact| contact.robot == robot).collect();
    let spread = |of: fn(&ContactRecord) -> f64| Spread::of(all.iter().map(|contact| of(contact).abs()).collect());
    DockingStatistics {
        robot,
        count: all.len() as u64,
        across_um: spread(|contact| contact.across_um),
        along_um: spread(|contact| contact.along_um),
        incidence_rad: spread(|contact| contact.incidence_rad),
        heading_rad: spread(|contact| contact.heading_rad),
    }
}

fn failures(trials: &[EndedTrial]) -> Vec<Failures> {
    let mut found: Vec<Failures> = Vec::new();
    for failure in trials.iter().filter_map(|trial| trial.failure.clone()) {
        let TrialFailure { robot, reason, step, phase } = failure;
        let is_same = |known: &&mut Failures| {
            known.robot == robot && known.reason == reason && known.step == step && known.phase == phase
        };
        match found.iter_mut().find(is_same) {
            Some(known) => known.count += 1,
            None => found.push(Failures { robot, reason, step, phase, count: 1 }),
        }
    }
    let key = |failure: &Failures| (failure.step, failure.robot, failure.phase, failure.reason.clone());
    found.sort_by(|a, b| b.count.cmp(&a.count).then_with(|| key(a).cmp(&key(b))));
    found
}
