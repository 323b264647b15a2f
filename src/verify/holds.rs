//! Waits for inputs and people: a schedule remains valid whenever each of them ends.
//!
//! Such a wait may be cut short at any instant, and everything after it then starts earlier. That changes nothing but
//! the length of the wait if every channel keeps one value throughout it, and if nothing timed reaches into it: no
//! other run, no wait of the program, no pulse. What is played afterwards is then what was verified, at the same
//! distances. Physical changes on the bench during the wait, such as evaporation of droplets, are not modelled.

use super::clock::{DueStretch, JudgedRun};
use super::rule::{Findings, Rule, Violation, ms};
use crate::claims::Claims;
use crate::claims::auxiliary::Hold;
use crate::schedule::{Schedule, ScheduledHold};

/// Checks every wait of the schedule against those of the claims, and against everything that runs at the same time.
pub(super) fn check(
    schedule: &Schedule,
    runs: &[JudgedRun],
    stretches: &[DueStretch],
    claims: &Claims,
    findings: &mut Findings,
) {
    let mut due: Vec<(ScheduledHold, usize)> = Vec::new();
    for (index, run) in runs.iter().enumerate() {
        let of_run = |hold: &Hold| ScheduledHold {
            step: run.steps[hold.step] as u32,
            start_ns: run.step(hold.step).start_ns,
            terms: hold.terms.clone(),
        };
        due.extend(run.job.holds.iter().map(|hold| (of_run(hold), index)));
    }
    due.sort_by_key(|(hold, _)| (hold.start_ns, hold.step));
    findings.count_checks(Rule::Held, due.len().max(schedule.holds.len()));
    if !schedule.holds.iter().eq(due.iter().map(|(hold, _)| hold)) {
        let title = "the waits for inputs and people are not those of the program's steps".to_owned();
        let time_ns = schedule.holds.first().or(due.first().map(|(hold, _)| hold)).map_or(0, |hold| hold.start_ns);
        findings.push(Violation::new(Rule::Held, time_ns, title));
        return;
    }
    for (hold, run) in &due {
        let find = |title: String| Violation::new(Rule::Held, hold.start_ns, title).step(hold.step as usize);
        let step = &schedule.steps[hold.step as usize];
        if step.duration_ns != hold.terms.duration_ns {
            let [lasts, due] = [step.duration_ns, hold.terms.duration_ns].map(ms);
            findings.push(find(format!("the wait lasts {lasts} on the clock, but {due} in the program")));
        }
        let meets = |start_ns: u64, end_ns: u64| start_ns < hold.end_ns() && hold.start_ns < end_ns;
        let is_other = |one: &&DueStretch| one.job != Some(*run) && meets(one.start_ns, one.end_ns);
        if let Some(DueStretch { start_ns, end_ns, .. }) = stretches.iter().find(is_other) {
            let (start, end) = (ms(*start_ns), ms(*end_ns));
            findings.push(find(format!(
                "something else runs from {start} to {end}, during a wait that may end at any instant"
            )));
        }
        findings.count_checks(Rule::Held, schedule.actuations.len());
        for actuation in schedule.actuations.iter().filter(|actuation| meets(actuation.start_ns, actuation.end_ns())) {
            let channel = &schedule.channels[actuation.channel as usize];
            let is_pulse = claims.outputs.get(&channel.device).is_some_and(|output| output.pulse_ns.is_some());
            let is_steady = actuation.swing.is_none() && actuation.from == actuation.to;
            let lasts = actuation.start_ns <= hold.start_ns && hold.end_ns() <= actuation.end_ns();
            if is_pulse || !is_steady || !lasts {
                let start = ms(actuation.start_ns);
                findings.push(find(format!(
                    "`{}` changes during the wait, by the actuation that begins at {start}",
                    channel.name
                )));
                break;
            }
        }
    }
}
