//! Puts the waits for inputs and people on the clock.
//!
//! Such a wait ends when what it waits for has come, and what comes after it moves with its end. So nothing else may go on in it, whose
//! end would then depend on it: no other run, no wait of the program, and no pulse of an output.

use crate::claims::{Claims, Timeline};
use crate::diagnostic::{Code, Diagnostic, Sink};
use crate::quantity::{Dimension, Quantity};
use crate::schedule::{Schedule, ScheduledHold};
use crate::source::Span;

/// Something that takes its time beside a wait.
struct Other {
    start_ns: u64,
    end_ns: u64,
    what: String,
    /// Where it is written, if it is known.
    span: Option<Span>,
}

/// Adds the waits of all runs to a schedule.
///
/// `None` after an error: something else goes on in the stretch of a wait.
pub fn add(schedule: &mut Schedule, claims: &Claims, sink: &mut Sink) -> Option<()> {
    let mut holds = Vec::new();
    let mut first_step = 0;
    let errors = sink.errors();
    let mut leaves = Vec::new();
    leaves_of(&claims.timeline, 0, schedule, &mut leaves);
    for (index, job) in claims.jobs.iter().enumerate() {
        for hold in &job.holds {
            let step = first_step + hold.step;
            let (start_ns, span) = (schedule.steps[step].start_ns, schedule.steps[step].span);
            let hold = ScheduledHold { step: step as u32, start_ns, terms: hold.terms.clone() };
            let others = others(schedule, claims, index, &leaves);
            let beside = others.into_iter().find(|other| other.start_ns < hold.end_ns() && start_ns < other.end_ns);
            if let Some(other) = beside {
                sink.push(goes_on(&hold, span, &other));
            }
            holds.push(hold);
        }
        first_step += job.steps();
    }
    holds.sort_by_key(|hold| (hold.start_ns, hold.step));
    schedule.holds = holds;
    (sink.errors() == errors).then_some(())
}

/// When each run and each wait of the program takes place; returns where the part ends.
fn leaves_of(part: &Timeline, at_ns: u64, schedule: &Schedule, leaves: &mut Vec<(u64, u64, Option<usize>)>) -> u64 {
    match part {
        Timeline::Run(job) => {
            let end_ns = at_ns + schedule.plans[*job].duration_ns;
            leaves.push((at_ns, end_ns, Some(*job)));
            end_ns
        }
        Timeline::Wait(duration_ns) => {
            leaves.push((at_ns, at_ns + duration_ns, None));
            at_ns + duration_ns
        }
        Timeline::Sequence(parts) => parts.iter().fold(at_ns, |at_ns, part| leaves_of(part, at_ns, schedule, leaves)),
        Timeline::Together(parts) => {
            parts.iter().map(|part| leaves_of(part, at_ns, schedule, leaves)).fold(at_ns, u64::max)
        }
    }
}

/// All that takes its time but for one run: other runs, waits of the program, pulses.
fn others(schedule: &Schedule, claims: &Claims, job: usize, leaves: &[(u64, u64, Option<usize>)]) -> Vec<Other> {
    let beside = leaves.iter().filter(|(.., run)| *run != Some(job)).map(|(start_ns, end_ns, run)| {
        let (what, span) = match run.map(|run| &claims.jobs[run]) {
            Some(other) => (format!("the run of `{}` goes on", other.task), Some(other.run_span)),
            None => ("a `wait` of the program goes on".to_owned(), None),
        };
        Other { start_ns: *start_ns, end_ns: *end_ns, what, span }
    });
    let pulses = schedule.actuations.iter().filter_map(|actuation| {
        let device = &schedule.channels[actuation.channel as usize].device;
        claims.outputs.get(device)?.pulse_ns?;
        let span = schedule.steps[actuation.step as usize].span;
        let what = format!("the pulse of `{device}` goes on");
        Some(Other { start_ns: actuation.start_ns, end_ns: actuation.end_ns(), what, span: Some(span) })
    });
    beside.chain(pulses).collect()
}

/// The diagnostic of something that would end before, in or after a wait, as that ends.
fn goes_on(hold: &ScheduledHold, span: Span, other: &Other) -> Diagnostic {
    let time = |ns: u64| Quantity::new(ns as f64 / 1e9, Dimension::TIME);
    let title = format!("{} while the program waits for {}", other.what, hold.terms.awaited.shown());
    let place = format!("from {}, and nobody knows until when", time(hold.start_ns));
    let finding = Diagnostic::new(Code::E0608, title).label(span, place);
    let finding = match other.span {
        Some(other_span) => finding.label_elsewhere(other_span, span, "this goes on"),
        None => finding,
    };
    finding.help(format!(
        "let it end before, at {}: write a `wait` before the step, or run the two one after the other",
        time(hold.start_ns)
    ))
}
