//! Checks that a schedule can be checked against the claims at all.
//!
//! Input: claims. Output: nothing, or the reason why not. Claims of the checker always pass; those of a hostile log
//! may not, and the rules rely on these checks.

use super::{InvalidClaims, judge_of};
use crate::claims::auxiliary::AuxiliaryAction;
use crate::claims::{Claims, Job, Relation, SharedScene, Timeline};
use crate::device::Frames;
use crate::geometry::shape::{MAX_EXTENT_UM, Pose};
use std::collections::BTreeMap;

/// Greatest depth of a timeline.
const MAX_DEPTH: usize = 256;

/// Checks the assumptions of all rules.
pub(super) fn check(claims: &Claims) -> Result<(), InvalidClaims> {
    let mut runs = vec![0; claims.jobs.len()];
    count_runs(&claims.timeline, MAX_DEPTH, &mut runs)?;
    if let Some(job) = runs.iter().position(|runs| *runs != 1) {
        return Err(InvalidClaims(format!(
            "the claims' timeline runs job {job} {} times; it must run it once",
            runs[job]
        )));
    }
    claims.shared.iter().try_for_each(|scene| shared(scene, claims))?;
    let mut devices = BTreeMap::new();
    for job in &claims.jobs {
        requirements(job)?;
        outputs(job, claims)?;
        holds(job)?;
        let judge = judge_of(&job.order);
        judge.premise()?;
        let first = devices.entry(job.device.as_str()).or_insert(job);
        if !judge.has_facts_of(&first.order) {
            return Err(InvalidClaims(format!(
                "the claims have two different sets of facts about the device `{}`",
                job.device
            )));
        }
        if !judge.has_parts_of(&first.order) {
            return Err(InvalidClaims(format!(
                "the claims have two different sets of parts on the device `{}`",
                job.device
            )));
        }
    }
    Ok(())
}

/// Waits for inputs are at steps of the job, at most one per step, and no job with waits has a lower limit on its
/// time, since its run may be shorter.
fn holds(job: &Job) -> Result<(), InvalidClaims> {
    let invalid = |why: &str| Err(InvalidClaims(format!("the claims have `{}` wait {why}", job.task)));
    if job.holds.iter().any(|hold| hold.step >= job.steps() || hold.terms.duration_ns == 0) {
        return invalid("at a step that does not exist, or for no time");
    }
    if job.holds.windows(2).any(|pair| pair[0].step >= pair[1].step) {
        return invalid("twice at one step");
    }
    let from_below = |relation: Relation| !matches!(relation, Relation::Less | Relation::AtMost);
    let asks = job.requirements.iter().any(|asked| asked.outcome == "time" && from_below(asked.relation));
    if asks && !job.holds.is_empty() { invalid("and limit its time from below") } else { Ok(()) }
}

/// The steps that switch outputs are steps of the job, and each output supports its action.
fn outputs(job: &Job, claims: &Claims) -> Result<(), InvalidClaims> {
    for event in &job.events {
        let invalid = |why: &str| Err(InvalidClaims(format!("the claims switch the output `{}` {why}", event.output)));
        let Some(output) = claims.outputs.get(&event.output) else { return invalid("but do not define it") };
        if event.step >= job.steps() {
            return invalid("at a step that does not exist");
        }
        let levels = [output.low_v, output.high_v, output.rest_v];
        let between = |volts: f64| output.low_v.min(output.high_v) <= volts && volts <= output.low_v.max(output.high_v);
        let is_graded = output.is_graded && output.pulse_ns.is_none();
        let is_of_its_sort = match event.action {
            AuxiliaryAction::Pulse => output.pulse_ns.is_some() && !output.is_graded,
            AuxiliaryAction::High | AuxiliaryAction::Low => output.pulse_ns.is_none() && !output.is_graded,
            AuxiliaryAction::Volts(volts) => is_graded && between(volts),
        };
        let rests = between(output.rest_v)
            && (output.is_graded || output.rest_v == output.low_v || output.rest_v == output.high_v);
        if !levels.into_iter().all(f64::is_finite) || !rests || !is_of_its_sort {
            return invalid("in a way that it does not support");
        }
    }
    Ok(())
}

/// Whether a frame's numbers are finite and in range.
pub(super) fn is_frame(frame: &Pose) -> bool {
    [frame.x_um, frame.y_um, frame.heading_rad].iter().all(|value| value.abs() <= MAX_EXTENT_UM)
}

/// A shared scene places robots of the program, each where all its orders place it.
fn shared(scene: &SharedScene, claims: &Claims) -> Result<(), InvalidClaims> {
    for (device, frame) in &scene.frames {
        let invalid =
            |why: &str| Err(InvalidClaims(format!("the claims' scene `{}` places `{device}` {why}", scene.scene)));
        let jobs = || claims.jobs.iter().filter(|job| job.device == *device);
        if !is_frame(frame) {
            return invalid("out of range");
        }
        if jobs().next().is_none() || jobs().any(|job| job.kind().vocabulary().frames == Frames::No) {
            return invalid("as a robot that the program does not run");
        }
        let places = jobs().filter_map(|job| job.order.as_kind().frame());
        if places.chain(claims.frame(device)).any(|other| other != *frame) {
            return invalid("at two places");
        }
    }
    Ok(())
}

fn count_runs(timeline: &Timeline, depth: usize, runs: &mut [u64]) -> Result<(), InvalidClaims> {
    if depth == 0 {
        return Err(InvalidClaims(format!("the claims' timeline nests deeper than {MAX_DEPTH} levels")));
    }
    match timeline {
        Timeline::Wait(_) => Ok(()),
        Timeline::Sequence(parts) | Timeline::Together(parts) => {
            parts.iter().try_for_each(|part| count_runs(part, depth - 1, runs))
        }
        Timeline::Run(job) => {
            let known = runs.len();
            let count = runs.get_mut(*job).ok_or_else(|| {
                InvalidClaims(format!(
                    "the claims' timeline runs job {job}, but they have {known} jobs, counted from 0"
                ))
            })?;
            *count += 1;
            Ok(())
        }
    }
}

fn requirements(job: &Job) -> Result<(), InvalidClaims> {
    let outcomes = job.kind().vocabulary().outcomes;
    for requirement in &job.requirements {
        if !outcomes.iter().any(|outcome| outcome.name == requirement.outcome) {
            return Err(InvalidClaims(format!("the claims limit `{}`, which is not an outcome", requirement.outcome)));
        }
        if !requirement.limit.is_finite() {
            return Err(InvalidClaims(format!("the claims' limit of `{}` is not finite", requirement.outcome)));
        }
    }
    Ok(())
}
