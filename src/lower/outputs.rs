//! Places the actions on auxiliary outputs on the clock.

use crate::claims::Claims;
use crate::claims::auxiliary::AuxiliaryAction;
use crate::device::instrument::{AuxiliaryOutput, AuxiliarySort};
use crate::diagnostic::{Code, Diagnostic, Sink};
use crate::quantity::Quantity;
use crate::schedule::{Actuation, Channel, ChannelUnit, Schedule};

/// A switching of an output: its instant, the step that causes it, and the action.
#[derive(Clone, Copy)]
struct TimedEvent {
    t_ns: u64,
    step: usize,
    action: AuxiliaryAction,
}

/// Adds a channel for each auxiliary output of a program, with the actions of its steps. A pulse begins with its
/// step; a level lasts until the next step of the output, or until the end of the schedule, which is not before the
/// end of the last pulse. While an output is at rest, there is no actuation.
///
/// `None` after an error: an output is switched again during a pulse, or twice at the same instant.
pub fn add(schedule: &mut Schedule, claims: &Claims, sink: &mut Sink) -> Option<()> {
    let mut events: Vec<Vec<TimedEvent>> = vec![Vec::new(); claims.outputs.len()];
    let mut first_step = 0;
    for job in &claims.jobs {
        for event in &job.events {
            let step = first_step + event.step;
            let t_ns = schedule.steps[step].start_ns;
            let output = claims.outputs.keys().position(|name| *name == event.output);
            events[output.expect("the checker lists every output")].push(TimedEvent {
                t_ns,
                step,
                action: event.action,
            });
        }
        first_step += job.steps();
    }
    let errors = sink.errors();
    for ((name, output), events) in claims.outputs.iter().zip(&mut events) {
        events.sort_by_key(|event| (event.t_ns, event.step));
        let switched = events.windows(2).find_map(|pair| too_soon(schedule, name, output, [pair[0], pair[1]]));
        switched.into_iter().for_each(|finding| sink.push(finding));
        if let Some((last, pulse_ns)) = events.last().zip(output.pulse_ns) {
            schedule.duration_ns = schedule.duration_ns.max(last.t_ns + pulse_ns);
        }
    }
    for ((name, output), events) in claims.outputs.iter().zip(&events) {
        let channel = add_channel(schedule, claims, name, output);
        let ends = events.iter().skip(1).map(|next| next.t_ns).chain([schedule.duration_ns]);
        for (event, end_ns) in events.iter().zip(ends) {
            let volts = voltage(output, event.action);
            if volts == output.rest_v {
                continue;
            }
            let duration_ns = output.pulse_ns.unwrap_or(end_ns - event.t_ns);
            if duration_ns == 0 {
                if end_ns == schedule.duration_ns {
                    sink.push(set_at_the_end(schedule, name, *event));
                }
                continue;
            }
            schedule.actuations.push(Actuation {
                channel,
                start_ns: event.t_ns,
                duration_ns,
                from: volts,
                to: volts,
                swing: None,
                step: event.step as u32,
            });
        }
    }
    schedule.actuations.sort_by_key(|actuation| (actuation.start_ns, actuation.channel));
    (sink.errors() == errors).then_some(())
}

/// The voltage that an action gives to an output.
fn voltage(output: &AuxiliaryOutput, action: AuxiliaryAction) -> f64 {
    match action {
        AuxiliaryAction::Pulse if output.rest_v == output.high_v => output.low_v,
        AuxiliaryAction::Pulse | AuxiliaryAction::High => output.high_v,
        AuxiliaryAction::Low => output.low_v,
        AuxiliaryAction::Volts(volts) => volts,
    }
}

fn add_channel(schedule: &mut Schedule, claims: &Claims, name: &str, output: &AuxiliaryOutput) -> u32 {
    let full = format!("{name}.{}", AuxiliarySort::CHANNEL);
    let wire = claims.wires.get(&full).cloned();
    let (device, rest_v) = (name.to_owned(), output.rest_v);
    schedule.channels.push(Channel { name: full, device, unit: ChannelUnit::Volt, wire, rest_v });
    schedule.channels.len() as u32 - 1
}

/// The diagnostic of two steps that switch an output, if the second follows too soon.
fn too_soon(
    schedule: &Schedule,
    name: &str,
    output: &AuxiliaryOutput,
    [first, second]: [TimedEvent; 2],
) -> Option<Diagnostic> {
    let [earlier, later] = [first, second].map(|event| &schedule.steps[event.step]);
    let gap_ns = second.t_ns - first.t_ns;
    let (title, help) = match output.pulse_ns {
        // Two pulses without a gap between them would merge into one.
        Some(pulse_ns) if gap_ns <= pulse_ns => (
            format!(
                "`{name}` is pulsed again {} after a pulse of {} began",
                Quantity::time_ns(gap_ns),
                Quantity::time_ns(pulse_ns)
            ),
            format!(
                "leave more than {} between the two instead of {}, or write a shorter `duration`",
                Quantity::time_ns(pulse_ns),
                Quantity::time_ns(gap_ns)
            ),
        ),
        None if gap_ns == 0 => (
            format!("`{name}` is set twice at {}", Quantity::time_ns(second.t_ns)),
            "write a `wait` between the two".to_owned(),
        ),
        Some(_) | None => return None,
    };
    let diagnostic = Diagnostic::new(Code::E0607, title).label(later.span, "this one comes too soon");
    Some(diagnostic.label_elsewhere(earlier.span, later.span, "after this one").help(help))
}

/// The diagnostic of a level that is set only at the end of the schedule, and so never appears.
fn set_at_the_end(schedule: &Schedule, name: &str, event: TimedEvent) -> Diagnostic {
    Diagnostic::new(Code::E0607, format!("`{name}` is set as the schedule ends, and goes back to rest at once"))
        .label(schedule.steps[event.step].span, "nothing comes after it")
        .help("write it before the step that it is for, or a `wait` after it: outputs rest when the schedule has ended")
}
