use super::dimibot::build::*;
use super::*;
use crate::claims::auxiliary::{AuxiliaryAction, AuxiliaryEvent, Hold};
use crate::claims::dimibot::DimibotAction;
use crate::claims::{Relation, Requirement, Timeline};
use crate::device::instrument::{AuxiliaryOutput, Awaited, HoldTerms};
use crate::schedule::{Actuation, Channel, ChannelUnit, ScheduledHold};

fn terms() -> HoldTerms {
    HoldTerms { awaited: Awaited::Person { prompt: "look".into() }, duration_ns: 5 * MS, is_bounded: true }
}

fn output(pulse_ns: Option<u64>) -> AuxiliaryOutput {
    AuxiliaryOutput { high_v: 5.0, low_v: 0.0, rest_v: 0.0, pulse_ns, is_graded: false }
}

/// 2 ms, a wait of at most 5 ms with the light on, and 2 ms; at the same time a second robot waits for `other_ns`.
fn beside(other_ns: u64) -> (Schedule, Claims) {
    let steps = [0, 2 * MS, 5 * MS, 2 * MS].map(DimibotAction::Wait).to_vec();
    let other = job("other", "second", order(facts(3, 3), vec![DimibotAction::Wait(other_ns)]));
    let both = Timeline::Together(vec![Timeline::Run(0), Timeline::Run(1)]);
    let mut claims = claims(vec![job("look", "bot", order(facts(3, 3), steps)), other], both);
    claims.outputs.insert("light".into(), output(None));
    claims.jobs[0].events = vec![AuxiliaryEvent { step: 0, output: "light".into(), action: AuxiliaryAction::High }];
    claims.jobs[0].holds = vec![Hold { step: 2, terms: terms() }];
    let mut schedule = schedule(&claims, &[&[&[], &[], &[], &[]], &[&[]]]);
    let channel = schedule.channels.len() as u32;
    let (name, device) = ("light.out".into(), "light".into());
    schedule.channels.push(Channel { name, device, unit: ChannelUnit::Volt, wire: None, rest_v: 0.0 });
    let duration_ns = schedule.duration_ns;
    schedule.actuations =
        vec![Actuation { channel, start_ns: 0, duration_ns, from: 5.0, to: 5.0, swing: None, step: 0 }];
    schedule.holds = vec![ScheduledHold { step: 2, start_ns: 2 * MS, terms: terms() }];
    (schedule, claims)
}

#[test]
fn waits_are_those_of_the_steps() {
    let (sound, claims) = beside(2 * MS);
    passes(&sound, &claims);
    let edits: [fn(&mut Schedule); 6] = [
        |schedule| schedule.holds.clear(),
        |schedule| schedule.holds[0].start_ns += 1,
        |schedule| schedule.holds[0].step = 3,
        |schedule| schedule.holds[0].terms.duration_ns -= 1,
        |schedule| schedule.holds[0].terms.is_bounded = false,
        |schedule| schedule.holds[0].terms.awaited = Awaited::Person { prompt: "go".into() },
    ];
    for edit in edits {
        let mut wrong = sound.clone();
        edit(&mut wrong);
        only(Rule::Held, &wrong, &claims);
    }
    let mut late = sound;
    late.holds[0].start_ns = u64::MAX;
    only(Rule::Number, &late, &claims);
}

#[test]
fn nothing_else_goes_on_in_a_wait() {
    let (sound, claims) = beside(2 * MS);
    passes(&sound, &claims);
    let (longer, claims) = beside(2 * MS + 1);
    only(Rule::Held, &longer, &claims);
    // A wait of the program at the same time.
    let (sound, mut claims) = beside(2 * MS);
    claims.timeline = Timeline::Together(vec![Timeline::Run(0), Timeline::Run(1), Timeline::Wait(3 * MS)]);
    only(Rule::Held, &sound, &claims);
    claims.timeline = Timeline::Together(vec![Timeline::Run(0), Timeline::Run(1), Timeline::Wait(2 * MS)]);
    passes(&sound, &claims);
}

#[test]
fn no_pulse_lasts_into_a_wait() {
    let (mut schedule, mut claims) = beside(2 * MS);
    claims.outputs.insert("light".into(), output(Some(2 * MS)));
    claims.jobs[0].events[0].action = AuxiliaryAction::Pulse;
    schedule.actuations[0].duration_ns = 2 * MS;
    passes(&schedule, &claims);
    // Nor may it span the whole wait.
    for pulse_ns in [2 * MS + 1, 8 * MS] {
        claims.outputs.insert("light".into(), output(Some(pulse_ns)));
        schedule.actuations[0].duration_ns = pulse_ns;
        only(Rule::Held, &schedule, &claims);
    }
}

#[test]
fn waits_that_no_run_has_are_not_judged_by() {
    let (sound, claims) = beside(2 * MS);
    let at_least = |relation| Requirement { outcome: "time".into(), relation, limit: 1e-3, span: Span::default() };
    let edits: [fn(&mut Claims); 3] = [
        |claims| claims.jobs[0].holds[0].step = 4,
        |claims| claims.jobs[0].holds[0].terms.duration_ns = 0,
        |claims| claims.jobs[0].holds = vec![Hold { step: 2, terms: terms() }; 2],
    ];
    let mut wrong: Vec<Claims> = edits
        .into_iter()
        .map(|edit| {
            let mut wrong = claims.clone();
            edit(&mut wrong);
            wrong
        })
        .collect();
    for relation in [Relation::AtLeast, Relation::More, Relation::Equal] {
        let mut asking = claims.clone();
        asking.jobs[0].requirements = vec![at_least(relation)];
        wrong.push(asking);
    }
    for (nth, wrong) in wrong.iter().enumerate() {
        assert!(matches!(verify(sound.clone(), wrong), Verdict::Inconclusive { .. }), "edit {nth}");
    }
}
