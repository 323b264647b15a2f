//! Auxiliary outputs: high when the steps of the program say so, and at no other time.
//!
//! Each output is replayed by itself: the edges that its steps make, put in order of time, are walked from low to low, and every stretch
//! in which it is high must be in the schedule, by the step that began it; nothing else may be there.

use super::clock::JudgedRun;
use super::form::is_auxiliary;
use super::rule::{Findings, Rule, Violation, ms};
use crate::claims::Claims;
use crate::claims::auxiliary::AuxiliaryAction;
use crate::schedule::{Actuation, Schedule};
use std::collections::BTreeMap;

/// A stretch in which an output is high, with the step that makes it so.
type HighStretch = (u64, u64, usize);

/// Holds every auxiliary output against the steps of the program.
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
        let claimed = stretches(&events, output.pulse_ns, schedule.duration_ns);
        findings.asked(Rule::Output, found.len() + claimed.len() + events.len());
        let is_claimed = |actuation: &&&Actuation| {
            let is_level = actuation.from == output.high_v && actuation.to == output.high_v;
            let stretch = (actuation.start_ns, actuation.end_ns(), actuation.step as usize);
            is_level && actuation.swing.is_none() && claimed.contains(&stretch)
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
        let is_found = |stretch: &&HighStretch| found.iter().any(|actuation| actuation.start_ns == stretch.0);
        if let Some((start_ns, end_ns, step)) = claimed.iter().find(|stretch| !is_found(stretch)) {
            let title = format!("`{name}` is not high from {} to {}", ms(*start_ns), ms(*end_ns));
            findings.push(Violation::new(Rule::Output, *start_ns, title).step(*step));
        }
        let apart = events.windows(2).find(|pair| {
            let gap_ns = pair[1].0 - pair[0].0;
            output.pulse_ns.map_or(gap_ns == 0, |pulse_ns| gap_ns <= pulse_ns)
        });
        if let Some([_, (t_ns, step, _)]) = apart {
            let title = format!("`{name}` is switched at {} while the step before still has it", ms(*t_ns));
            findings.push(Violation::new(Rule::Output, *t_ns, title).step(*step));
        }
    }
}

/// When an output is high, from its events in order of time.
fn stretches(events: &[(u64, usize, AuxiliaryAction)], pulse_ns: Option<u64>, end_ns: u64) -> Vec<HighStretch> {
    let mut high = Vec::new();
    let mut since: Option<(u64, usize)> = None;
    for (t_ns, step, action) in events {
        if let Some((start_ns, by)) = since.take() {
            high.push((start_ns, *t_ns, by));
        }
        match action {
            AuxiliaryAction::Pulse => high.push((*t_ns, t_ns.saturating_add(pulse_ns.unwrap_or_default()), *step)),
            AuxiliaryAction::High => since = Some((*t_ns, *step)),
            AuxiliaryAction::Low => {}
        }
    }
    high.extend(since.map(|(start_ns, by)| (start_ns, end_ns, by)));
    high
}
