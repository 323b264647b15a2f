use super::*;
use proptest::prelude::*;

/// Limits of a small instrument.
fn small(most_points: u64, most_repeats: u64) -> Limits {
    Limits { least_points: 8, most_points, most_repeats }
}

fn composed(pieces: &[(Vec<i16>, u64)], limits: Limits, written_out: u64) -> Option<Sequence> {
    let pieces: Vec<SamplePiece> =
        pieces.iter().map(|(samples, count)| SamplePiece { samples: samples.clone(), count: *count }).collect();
    SequenceBuilder::compose(&[OutputSignal { ends: [0; 2], pieces }], limits, written_out)
}

/// The samples between the first and the last step.
fn played(sequence: &Sequence) -> Vec<i16> {
    let inner = &sequence.steps[1..sequence.steps.len() - 1];
    inner.iter().flat_map(|step| sequence.segments[step.segment].repeat(step.repeats as usize)).collect()
}

#[test]
fn a_train_of_an_hour_is_a_few_samples() {
    let hour = [(vec![7], 40), (vec![5, -5], 72_000_000), (vec![0], 3)];
    let sequence = composed(&hour, small(1_000_000, MOST_REPEATS), WRITTEN_OUT).unwrap();
    let words: Vec<(usize, u64, &str)> = sequence
        .steps
        .iter()
        .map(|step| (sequence.segments[step.segment].len(), step.repeats, step.control.word()))
        .collect();
    let expected =
        [(8, 1, "onceWaitTrig"), (8, 5, "repeat"), (144, 1_000_000, "repeat"), (8, 1, "once"), (8, 1, "repeatInf")];
    assert_eq!(words, expected);
}

#[test]
fn what_does_not_fit_is_said() {
    let long = [(vec![1; 40], 3)];
    assert!(composed(&long, small(48, 10), 0).is_some());
    assert!(composed(&long, small(47, 10), 0).is_none());
    let many = [(vec![1], 1000)];
    assert!(composed(&many, small(108, 10), 0).is_some());
    assert!(composed(&many, small(107, 10), 0).is_none());
}

proptest! {
    #[test]
    fn playback_is_what_was_asked_for(
        pieces in prop::collection::vec((prop::collection::vec(-3i16..3, 1..12), 0u64..40), 0..12),
        written_out in 0u64..60,
    ) {
        let sequence = composed(&pieces, small(1_000_000, 7), written_out).unwrap();
        let asked: Vec<i16> = pieces.iter().flat_map(|(samples, count)| samples.repeat(*count as usize)).collect();
        let mut found = played(&sequence);
        prop_assert!(found.len() >= asked.len() && found.len() < asked.len() + 8);
        prop_assert!(found.drain(asked.len()..).all(|sample| sample == 0));
        prop_assert_eq!(found, asked);
        prop_assert!(sequence.segments.iter().all(|segment| segment.len() >= 8));
        prop_assert!(sequence.steps.iter().all(|step| (1..=7).contains(&step.repeats)));
    }
}

mod waits {
    use super::*;
    use crate::device::instrument::{Awaited, Family, HoldTerms};
    use crate::emit::Format;
    use crate::emit::fixture::{self, FixtureSchedule};
    use crate::emit::scpi::{Generator, Playing};
    use crate::emit::tests::bench::{generator, on_generators};
    use crate::emit::wired::wired;
    use crate::schedule::{Actuation, Channel, ChannelUnit, ScheduledHold};

    /// Levels and waits, each with its length in units of 50 ms; `None` is rest.
    #[derive(Debug, Clone)]
    enum Stretch {
        Level(Option<f64>, u64),
        Wait(u64),
    }

    const UNIT_NS: u64 = 50_000_000;

    fn stretch() -> impl Strategy<Value = Stretch> {
        prop_oneof![
            (prop::option::of(prop_oneof![Just(2.0), Just(5.0)]), 1u64..40)
                .prop_map(|(v, units)| Stretch::Level(v, units)),
            (1u64..40).prop_map(Stretch::Wait),
        ]
    }

    /// A schedule of stretches in order; a wait holds the level before it.
    fn scheduled(stretches: &[Stretch]) -> FixtureSchedule {
        fixture::idle().changed(|schedule| {
            let channel = Channel {
                name: "lamp.out".into(),
                device: "lamp".into(),
                unit: ChannelUnit::Volt,
                wire: None,
                rest_v: 0.0,
            };
            (schedule.channels, schedule.actuations, schedule.duration_ns) = (vec![channel], Vec::new(), 0);
            let mut level_v = None;
            for stretch in stretches {
                let (start_ns, units) = match *stretch {
                    Stretch::Level(v, units) => {
                        level_v = v;
                        (schedule.duration_ns, units)
                    }
                    Stretch::Wait(units) => {
                        let awaited = Awaited::Person { prompt: "go".to_owned() };
                        let terms = HoldTerms { awaited, duration_ns: units * UNIT_NS, is_bounded: false };
                        schedule.holds.push(ScheduledHold { step: 0, start_ns: schedule.duration_ns, terms });
                        (schedule.duration_ns, units)
                    }
                };
                schedule.duration_ns += units * UNIT_NS;
                let Some(v) = level_v else { continue };
                match schedule.actuations.last_mut() {
                    Some(last) if last.from == v && last.end_ns() == start_ns => last.duration_ns += units * UNIT_NS,
                    Some(_) | None => schedule.actuations.push(Actuation {
                        channel: 0,
                        start_ns,
                        duration_ns: units * UNIT_NS,
                        from: v,
                        to: v,
                        swing: None,
                        step: 0,
                    }),
                }
            }
        })
    }

    proptest! {
        /// From each trigger on, a generator plays what the schedule has from there on, and no waiting segment is long.
        #[test]
        fn between_waits_a_generator_plays_the_schedule(stretches in prop::collection::vec(stretch(), 1..12)) {
            let verified = on_generators(scheduled(&stretches)).verified;
            let schedule = verified.schedule();
            let all = wired(Format::Scpi, schedule, Family::WaveformGenerator).expect("it is wired");
            let facts = generator();
            let made = Generator::new(&all[0], &facts, verified.claims()).expect("it can be played");
            let Playing::Sequence(sequence) = &made.outputs[0].playing else {
                prop_assert!(schedule.holds.is_empty() || schedule.actuations.is_empty()
                    || made.outputs[0].span_v() <= 0.0);
                return Ok(());
            };
            let period_ns = made.sampling.period_ns;
            let signals = Signals::new(schedule);
            let starts = std::iter::once(0).chain(schedule.holds.iter().map(|hold| hold.end_ns()));
            let ends = schedule.holds.iter().map(|hold| hold.start_ns).chain([schedule.duration_ns]);
            let mut steps = sequence.steps.iter().peekable();
            for (start_ns, end_ns) in starts.zip(ends) {
                let waiting = steps.next().expect("a part begins with a trigger");
                if waiting.control == Control::RepeatForever {
                    prop_assert_eq!((start_ns, end_ns), (schedule.duration_ns, schedule.duration_ns));
                    break;
                }
                prop_assert_eq!(waiting.control, Control::OnceWaitTrigger);
                prop_assert!(sequence.segments[waiting.segment].len() as u64 * period_ns <= 1_000_000);
                let mut t_ns = start_ns;
                while let Some(step) = steps.next_if(|step| matches!(step.control, Control::Once | Control::Repeat)) {
                    for code in sequence.segments[step.segment].repeat(step.repeats as usize) {
                        // The wait holds the value at its beginning; padding lasts no longer than a waiting segment.
                        let due_v = signals.value(0, t_ns.min(end_ns.max(start_ns + 1) - 1));
                        let is_due = t_ns >= end_ns || code == made.outputs[0].code(due_v);
                        prop_assert!(is_due, "{} ns after {} ns", t_ns - start_ns, start_ns);
                        t_ns += period_ns;
                    }
                }
                prop_assert!(t_ns >= end_ns && t_ns <= end_ns + 2_000_000, "{} to {}", t_ns, end_ns);
            }
        }
    }
}
