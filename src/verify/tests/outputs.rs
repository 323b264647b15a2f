use super::*;
use crate::claims::Timeline;
use crate::claims::auxiliary::{AuxiliaryAction, AuxiliaryEvent};
use crate::claims::dimibot::DimibotAction;
use crate::device::instrument::AuxiliaryOutput;
use crate::schedule::{Actuation, Channel, ChannelUnit};

fn event(step: usize, output: &str, action: AuxiliaryAction) -> AuxiliaryEvent {
    AuxiliaryEvent { step, output: output.into(), action }
}

/// `set light to high`, 2 ms, `pulse camera`, 2 ms, `set light to low`, `pulse camera` at the end; with its schedule.
fn look() -> (Schedule, Claims) {
    look_after(2 * MS)
}

/// The same with another time between the two pulses, in nanoseconds.
fn look_after(gap_ns: u64) -> (Schedule, Claims) {
    let steps = [0, 2 * MS, 0, gap_ns, 0, 0].map(DimibotAction::Wait).to_vec();
    let mut claims = claims(vec![job("look", "bot", order(facts(3, 3), steps))], Timeline::Run(0));
    claims.outputs.insert("camera".into(), AuxiliaryOutput { high_v: 5.0, pulse_ns: Some(MS) });
    claims.outputs.insert("light".into(), AuxiliaryOutput { high_v: 3.3, pulse_ns: None });
    claims.jobs[0].events = vec![
        event(0, "light", AuxiliaryAction::High),
        event(2, "camera", AuxiliaryAction::Pulse),
        event(4, "light", AuxiliaryAction::Low),
        event(5, "camera", AuxiliaryAction::Pulse),
    ];
    let mut schedule = schedule(&claims, &[&[&[], &[], &[], &[], &[], &[]]]);
    let first = schedule.channels.len() as u32;
    for output in ["camera", "light"] {
        let name = format!("{output}.out");
        schedule.channels.push(Channel { name, device: output.into(), unit: ChannelUnit::Volt, wire: None });
    }
    let last_ns = 2 * MS + gap_ns;
    for (output, start_ns, duration_ns, volts, step) in
        [(1, 0, last_ns, 3.3, 0), (0, 2 * MS, MS, 5.0, 2), (0, last_ns, MS, 5.0, 5)]
    {
        schedule.actuations.push(Actuation {
            channel: first + output,
            start_ns,
            duration_ns,
            from: volts,
            to: volts,
            swing: None,
            step,
        });
    }
    schedule.duration_ns = last_ns + MS;
    (schedule, claims)
}

#[test]
fn outputs_are_high_when_the_steps_say_so_and_at_no_other_time() {
    let (sound, claims) = look();
    passes(&sound, &claims);
    let edits: [fn(&mut Schedule); 8] = [
        |schedule| schedule.actuations[0].duration_ns -= 1,
        |schedule| schedule.actuations[0].from = 3.2,
        |schedule| schedule.actuations[0].to = 3.2,
        |schedule| schedule.actuations[1].start_ns += 1,
        |schedule| schedule.actuations[1].step = 3,
        |schedule| {
            schedule.actuations.remove(0);
        },
        |schedule| {
            schedule.actuations.remove(2);
        },
        |schedule| {
            let again = Actuation { start_ns: schedule.actuations[1].end_ns(), ..schedule.actuations[1] };
            schedule.actuations.insert(2, again);
        },
    ];
    for (nth, edit) in edits.into_iter().enumerate() {
        let mut wrong = sound.clone();
        edit(&mut wrong);
        assert_eq!(rules(&wrong, &claims), [Rule::Output], "edit {nth}");
    }
}

#[test]
fn a_schedule_ends_with_its_last_pulse() {
    let (sound, claims) = look();
    for duration_ns in [5 * MS - 1, 5 * MS + 1] {
        only(Rule::Timeline, &Schedule { duration_ns, ..sound.clone() }, &claims);
    }
}

#[test]
fn channels_of_outputs_are_those_of_the_program() {
    let (sound, claims) = look();
    let mut other = sound.clone();
    other.channels.last_mut().expect("a channel").name = "light.lamp".into();
    only(Rule::Channel, &other, &claims);
    let mut unknown = claims;
    unknown.jobs[0].events.clear();
    unknown.outputs.clear();
    only(Rule::Channel, &sound, &unknown);
}

#[test]
fn pulses_of_one_output_have_a_gap_between_them() {
    let (apart, claims) = look_after(MS + 1);
    passes(&apart, &claims);
    let (touching, claims) = look_after(MS);
    only(Rule::Output, &touching, &claims);
    let (within, claims) = look_after(MS - 1);
    only(Rule::Overlap, &within, &claims);
}

#[test]
fn claims_that_no_output_has_are_not_judged_by() {
    let (sound, claims) = look();
    let edits: [fn(&mut Claims); 4] = [
        |claims| claims.jobs[0].events[0].step = 6,
        |claims| claims.jobs[0].events[0].output = "lamp".into(),
        |claims| claims.jobs[0].events[0].action = AuxiliaryAction::Pulse,
        |claims| claims.jobs[0].events[1].action = AuxiliaryAction::Low,
    ];
    for (nth, edit) in edits.into_iter().enumerate() {
        let mut wrong = claims.clone();
        edit(&mut wrong);
        assert!(matches!(verify(sound.clone(), &wrong), Verdict::Inconclusive { .. }), "edit {nth}");
    }
}
