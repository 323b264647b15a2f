use super::dimibot::build::*;
use super::*;
use crate::claims::Timeline;
use crate::claims::auxiliary::{AuxiliaryAction, AuxiliaryEvent};
use crate::claims::dimibot::DimibotAction;
use crate::device::instrument::AuxiliaryOutput;
use crate::schedule::{Actuation, Channel, ChannelUnit};

fn event(step: usize, output: &str, action: AuxiliaryAction) -> AuxiliaryEvent {
    AuxiliaryEvent { step, output: output.into(), action }
}

/// An output with two levels, at rest at 0 V.
fn low() -> AuxiliaryOutput {
    AuxiliaryOutput { high_v: 5.0, low_v: 0.0, rest_v: 0.0, pulse_ns: None, is_graded: false }
}

/// `set light to high`, 2 ms, `pulse camera`, 2 ms, `set light to low`, and `pulse camera` at the end; with its
/// schedule.
fn look() -> (Schedule, Claims) {
    look_after(2 * MS)
}

/// The same with `gap_ns` between the two pulses, in nanoseconds.
fn look_after(gap_ns: u64) -> (Schedule, Claims) {
    let steps = [0, 2 * MS, 0, gap_ns, 0, 0].map(DimibotAction::Wait).to_vec();
    let mut claims = claims(vec![job("look", "bot", order(facts(3, 3), steps))], Timeline::Run(0));
    claims.outputs.insert("camera".into(), AuxiliaryOutput { high_v: 5.0, pulse_ns: Some(MS), ..low() });
    claims.outputs.insert("light".into(), AuxiliaryOutput { high_v: 3.3, ..low() });
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
        schedule.channels.push(Channel {
            name,
            device: output.into(),
            unit: ChannelUnit::Volt,
            wire: None,
            rest_v: 0.0,
        });
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

/// A heater that rests at 2 V and is set to 4 V and then to 2 V, and a shutter that rests high and is pulsed.
fn warm() -> (Schedule, Claims) {
    let steps = [0, 0, 2 * MS, 0, 2 * MS].map(DimibotAction::Wait).to_vec();
    let mut claims = claims(vec![job("look", "bot", order(facts(3, 3), steps))], Timeline::Run(0));
    let heater = AuxiliaryOutput { high_v: 6.0, low_v: 1.0, rest_v: 2.0, is_graded: true, ..low() };
    claims.outputs.insert("heater".into(), heater);
    claims.outputs.insert("shutter".into(), AuxiliaryOutput { rest_v: 5.0, pulse_ns: Some(MS), ..low() });
    claims.jobs[0].events = vec![
        event(0, "heater", AuxiliaryAction::Volts(4.0)),
        event(1, "shutter", AuxiliaryAction::Pulse),
        event(3, "heater", AuxiliaryAction::Volts(2.0)),
    ];
    let mut schedule = schedule(&claims, &[&[&[], &[], &[], &[], &[]]]);
    let channel = schedule.channels.len() as u32;
    for (output, rest_v) in [("heater", 2.0), ("shutter", 5.0)] {
        let name = format!("{output}.out");
        schedule.channels.push(Channel { name, device: output.into(), unit: ChannelUnit::Volt, wire: None, rest_v });
    }
    let of = |channel, duration_ns, volts, step| Actuation {
        channel,
        start_ns: 0,
        duration_ns,
        from: volts,
        to: volts,
        swing: None,
        step,
    };
    schedule.actuations = vec![of(channel, 2 * MS, 4.0, 0), of(channel + 1, MS, 0.0, 1)];
    (schedule, claims)
}

#[test]
fn levels_are_those_of_the_steps_and_outputs_rest_where_the_program_has_them() {
    let (sound, claims) = warm();
    passes(&sound, &claims);
    let edits: [fn(&mut Schedule); 7] = [
        |schedule| {
            schedule.actuations[0].from = 4.5;
            schedule.actuations[0].to = 4.5;
        },
        |schedule| schedule.actuations[0].from = 3.0,
        |schedule| schedule.actuations[0].duration_ns += MS,
        |schedule| schedule.actuations[1].to = 5.0,
        |schedule| {
            schedule.actuations.remove(1);
        },
        |schedule| schedule.channels.iter_mut().for_each(|channel| channel.rest_v = 0.0),
        |schedule| schedule.channels[0].rest_v = 20.0,
    ];
    for (nth, edit) in edits.into_iter().enumerate() {
        let mut wrong = sound.clone();
        edit(&mut wrong);
        let found: std::collections::BTreeSet<Rule> = rules(&wrong, &claims).into_iter().collect();
        assert_eq!(found.into_iter().collect::<Vec<_>>(), [Rule::Output], "edit {nth}");
    }
}

#[test]
fn levels_and_rests_that_an_output_does_not_have_are_not_judged_by() {
    let (sound, claims) = warm();
    let edits: [fn(&mut Claims); 5] = [
        |claims| claims.jobs[0].events[0].action = AuxiliaryAction::Volts(6.5),
        |claims| claims.jobs[0].events[0].action = AuxiliaryAction::High,
        |claims| claims.jobs[0].events[1].action = AuxiliaryAction::Volts(3.0),
        |claims| claims.outputs.get_mut("shutter").expect("it is there").rest_v = 3.0,
        |claims| claims.outputs.get_mut("heater").expect("it is there").rest_v = f64::NAN,
    ];
    for (nth, edit) in edits.into_iter().enumerate() {
        let mut wrong = claims.clone();
        edit(&mut wrong);
        assert!(matches!(verify(sound.clone(), &wrong), Verdict::Inconclusive { .. }), "edit {nth}");
    }
}
