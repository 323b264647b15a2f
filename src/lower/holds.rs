//! Places the waits for inputs and persons on the clock.
//!
//! Such a wait ends when the awaited event comes, and everything after it shifts with its end. So nothing else may be
//! in progress during it, because its end would depend on the wait: no other run, no wait of the program, and no
//! pulse of an output.

use super::timeline::PlacedStretch;
use crate::claims::Claims;
use crate::diagnostic::{Code, Diagnostic, Sink};
use crate::quantity::Quantity;
use crate::schedule::{Actuation, Schedule, ScheduledHold};
use crate::source::Span;

/// Something in progress during a wait.
struct OngoingActivity {
    what: String,
    /// Its place in the source, if known.
    span: Option<Span>,
}

/// Adds the waits of all runs to a schedule.
///
/// `None` after an error: something else is in progress during a wait.
pub fn add(schedule: &mut Schedule, placed: &[PlacedStretch], claims: &Claims, sink: &mut Sink) -> Option<()> {
    let mut holds = Vec::new();
    let mut first_step = 0;
    let errors = sink.errors();
    for (index, job) in claims.jobs.iter().enumerate() {
        for hold in &job.holds {
            let step = first_step + hold.step;
            let (start_ns, span) = (schedule.steps[step].start_ns, schedule.steps[step].span);
            let hold = ScheduledHold { step: step as u32, start_ns, terms: hold.terms.clone() };
            if let Some(other) = concurrent_activity(schedule, placed, claims, index, &hold) {
                sink.push(ongoing_during_hold(&hold, span, &other));
            }
            holds.push(hold);
        }
        first_step += job.steps();
    }
    holds.sort_by_key(|hold| (hold.start_ns, hold.step));
    schedule.holds = holds;
    (sink.errors() == errors).then_some(())
}

/// Something in progress during a wait of a run: another run, a wait of the program, or a pulse.
fn concurrent_activity(
    schedule: &Schedule,
    placed: &[PlacedStretch],
    claims: &Claims,
    job: usize,
    hold: &ScheduledHold,
) -> Option<OngoingActivity> {
    let meets = |start_ns: u64, end_ns: u64| start_ns < hold.end_ns() && hold.start_ns < end_ns;
    let is_other = |stretch: &&PlacedStretch| stretch.job != Some(job) && meets(stretch.start_ns, stretch.end_ns);
    if let Some(stretch) = placed.iter().find(is_other) {
        return Some(match stretch.job.map(|run| &claims.jobs[run]) {
            Some(other) => OngoingActivity {
                what: format!("the run of `{}` is in progress", other.task),
                span: Some(other.run_span),
            },
            None => OngoingActivity { what: "a `wait` of the program is in progress".to_owned(), span: None },
        });
    }
    let device = |actuation: &Actuation| &schedule.channels[actuation.channel as usize].device;
    let is_pulse =
        |actuation: &Actuation| claims.outputs.get(device(actuation)).is_some_and(|output| output.pulse_ns.is_some());
    let mut pulses = schedule.actuations.iter().filter(|one| meets(one.start_ns, one.end_ns()) && is_pulse(one));
    pulses.next().map(|pulse| OngoingActivity {
        what: format!("the pulse of `{}` is in progress", device(pulse)),
        span: Some(schedule.steps[pulse.step as usize].span),
    })
}

/// The diagnostic of something in progress during a wait: when it would end depends on the end of the wait.
fn ongoing_during_hold(hold: &ScheduledHold, span: Span, other: &OngoingActivity) -> Diagnostic {
    let title = format!("{} while the program waits for {}", other.what, hold.terms.awaited.shown());
    let place = format!("from {}, for an unknown time", Quantity::time_ns(hold.start_ns));
    let finding = Diagnostic::new(Code::E0608, title).label(span, place);
    let finding = match other.span {
        Some(other_span) => finding.label_elsewhere(other_span, span, "in progress at that time"),
        None => finding,
    };
    finding.help(format!(
        "end it by {}: write a `wait` before the step, or run the two one after the other",
        Quantity::time_ns(hold.start_ns)
    ))
}
