//! `/log`: the program as it is played. It has one line of text per step, one per operation of an assay, and one per
//! beat of a step in which many parts move.
//!
//! Viewers show the text of an entry but not its fields for file and line, so the text begins with both: `fetch.twz:20
//! move to (19, 28)`.

use super::{LogTopic, foxglove, pictures};
use crate::claims::Job;
use crate::schedule::{Reached, ScheduledStep};
use crate::verify::Verified;
use std::collections::BTreeMap;

/// The `/log` topic. Steps have the level Info, beats Debug.
pub fn topic(verified: &Verified) -> LogTopic {
    let schedule = verified.schedule();
    let step_words = |step: &ScheduledStep| {
        let words = std::iter::once(headline(step)).chain(step.reached.iter().map(Reached::to_string));
        entry(step, step.line, step.start_ns, foxglove::log::Level::Info, &words.collect::<Vec<_>>().join("; "))
    };
    let mut messages: Vec<(u64, Vec<u8>)> = schedule.steps.iter().map(step_words).collect();
    messages.extend(schedule.steps.iter().flat_map(of_operations));
    let devices: BTreeMap<&str, &Job> = verified.claims().jobs.iter().map(|job| (job.device.as_str(), job)).collect();
    let beats = devices.into_iter().map(|(device, job)| (device, pictures(&job.order).beats(verified, device)));
    let beats: BTreeMap<&str, Vec<(u64, String)>> = beats.collect();
    for step in &schedule.steps {
        let plan = schedule.plans.get(step.plan as usize);
        let own = plan.and_then(|plan| beats.get(plan.device.as_str())).map_or(&[][..], Vec::as_slice);
        messages.extend(of_step(own, step));
    }
    messages.sort_by_key(|(t_ns, _)| *t_ns);
    LogTopic::new::<foxglove::Log>("/log", messages)
}

fn entry(step: &ScheduledStep, line: u32, t_ns: u64, level: foxglove::log::Level, words: &str) -> (u64, Vec<u8>) {
    let line = foxglove::Log {
        timestamp: foxglove::timestamp(t_ns),
        level: level as i32,
        message: format!("{}:{line} {words}", step.file),
        name: step.task.clone(),
        file: step.file.clone(),
        line,
    };
    (t_ns, foxglove::encode(&line))
}

/// The text of a step; if its operations have lines of their own, its first word and their number.
fn headline(step: &ScheduledStep) -> String {
    match (step.operations.len(), step.text.split_once(" {")) {
        (0, _) | (_, None) => step.text.clone(),
        (count, Some((head, _))) => format!("{head}, {count} operations"),
    }
}

/// The lines of a step's operations, at their starts.
fn of_operations(step: &ScheduledStep) -> impl Iterator<Item = (u64, Vec<u8>)> + '_ {
    step.operations.iter().map(move |operation| {
        let words = format!("{}: {}", operation.parts.join(", "), operation.text);
        entry(step, operation.line, operation.start_ns, foxglove::log::Level::Info, &words)
    })
}

/// The lines of a step's beats, if it has several.
fn of_step(beats: &[(u64, String)], step: &ScheduledStep) -> Vec<(u64, Vec<u8>)> {
    let first = beats.partition_point(|(t_ns, _)| *t_ns < step.start_ns);
    let after = beats.partition_point(|(t_ns, _)| *t_ns < step.end_ns()).max(first);
    let own = &beats[first..after];
    let line = |(index, (t_ns, moves)): (usize, &(u64, String))| {
        let words = format!("beat {} of {}: {moves}", index + 1, own.len());
        entry(step, step.line, *t_ns, foxglove::log::Level::Debug, &words)
    };
    if own.len() > 1 { own.iter().enumerate().map(line).collect() } else { Vec::new() }
}
