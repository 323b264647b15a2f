//! Auxiliary outputs: at the values that the program's steps set, and at rest at all other times.
//!
//! Each output is replayed alone: the events of its steps are sorted by time and give the stretches in which the
//! output is not at rest. Every stretch must be in the schedule, at its voltage and by the step that began it, and
//! nothing else may be.

use super::clock::JudgedRun;
use super::form::is_auxiliary;
use super::rule::{Findings, Rule, Violation, ms};
use crate::claims::Claims;
use crate::claims::auxiliary::AuxiliaryAction;
use crate::device::instrument::AuxiliaryOutput;
use crate::schedule::{Actuation, Schedule};
use std::collections::BTreeMap;

/// A stretch of time in which an output is not at rest, with its voltage and the step that set it.
#[derive(PartialEq)]
struct Stretch {
    start_ns: u64,
    end_ns: u64,
    volts: f64,
    step: usize,
}

/// Checks every auxiliary output against the steps of the program.
pub(super) fn check(schedule: &Schedule, runs: &[JudgedRun], claims: &Claims, findings: &mut Findings) {
    let mut due: BTreeMap<&str, Vec<(u64, usize, AuxiliaryAction)>> = BTreeMap::new();
    for run in runs {
        for event in &run.job.events {
            let steps = due.entry(&event.output).or_default();
            steps.push((run.step(event.step).start_ns, run.steps[event.step], event.action));
        }
    }
    for (name, output) in &claims.outputs {
        let mut events = due.remove(name.as_str()).unwrap_or_default();
        events.sort_by_key(|(t_ns, step, _)| (*t_ns, *step));
        let channel =
            schedule.channels.iter().position(|channel| channel.device == *name && is_auxiliary(channel, claims));
        let found: Vec<&Actuation> =
            schedule.actuations.iter().filter(|actuation| Some(actuation.channel as usize) == channel).collect();
        let claimed = stretches(&events, output, schedule.duration_ns);
        findings.count_checks(Rule::Output, found.len() + claimed.len() + events.len());
        let is_claimed = |actuation: &&&Actuation| {
            let (start_ns, end_ns, step) = (actuation.start_ns, actuation.end_ns(), actuation.step as usize);
            let is_level = actuation.from == actuation.to && actuation.swing.is_none();
            is_level && claimed.contains(&Stretch { start_ns, end_ns, volts: actuation.to, step })
        };
        if let Some(other) = found.iter().find(|actuation| !is_claimed(actuation)) {
            let title = format!(
                "`{name}` is at {} V from {} to {}, which no step of the program asks for",
                other.from,
                ms(other.start_ns),
                ms(other.end_ns())
            );
            findings.push(Violation::new(Rule::Output, other.start_ns, title).step(other.step as usize));
        }
        let is_found = |stretch: &&Stretch| found.iter().any(|actuation| actuation.start_ns == stretch.start_ns);
        if let Some(Stretch { start_ns, end_ns, volts, step }) = claimed.iter().find(|stretch| !is_found(stretch)) {
            let title = format!("`{name}` is not at {volts} V from {} to {}", ms(*start_ns), ms(*end_ns));
            findings.push(Violation::new(Rule::Output, *start_ns, title).step(*step));
        }
        let apart = events.windows(2).find(|pair| {
            let gap_ns = pair[1].0 - pair[0].0;
            output.pulse_ns.map_or(gap_ns == 0, |pulse_ns| gap_ns <= pulse_ns)
        });
        if let Some([_, (t_ns, step, _)]) = apart {
            let title = format!("`{name}` is switched at {} while the step before still uses it", ms(*t_ns));
            findings.push(Violation::new(Rule::Output, *t_ns, title).step(*step));
        }
    }
}

/// The stretches in which an output is not at rest, from its (time, step, action) events in order of time.
fn stretches(events: &[(u64, usize, AuxiliaryAction)], output: &AuxiliaryOutput, end_ns: u64) -> Vec<Stretch> {
    let mut found = Vec::new();
    for (nth, (start_ns, step, action)) in events.iter().enumerate() {
        let next_ns = events.get(nth + 1).map_or(end_ns, |(next_ns, ..)| *next_ns);
        let (volts, end_ns) = match action {
            AuxiliaryAction::Pulse => {
                let away_v = if output.rest_v == output.low_v { output.high_v } else { output.low_v };
                (away_v, start_ns.saturating_add(output.pulse_ns.unwrap_or_default()))
            }
            AuxiliaryAction::High => (output.high_v, next_ns),
            AuxiliaryAction::Low => (output.low_v, next_ns),
            AuxiliaryAction::Volts(volts) => (*volts, next_ns),
        };
        if volts != output.rest_v {
            found.push(Stretch { start_ns: *start_ns, end_ns, volts, step: *step });
        }
    }
    found
}
