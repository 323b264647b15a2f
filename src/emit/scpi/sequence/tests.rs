use super::*;
use proptest::prelude::*;

/// An instrument with little of everything.
fn small(most_points: u64, most_repeats: u64) -> Limits {
    Limits { least_points: 8, most_points, most_repeats }
}

fn composed(pieces: &[(Vec<i16>, u64)], limits: Limits, written_out: u64) -> Option<Sequence> {
    let pieces: Vec<SamplePiece> =
        pieces.iter().map(|(samples, count)| SamplePiece { samples: samples.clone(), count: *count }).collect();
    SequenceBuilder::compose(&[Score { ends: [0; 2], pieces }], limits, written_out)
}

/// The samples between the wait and the rest.
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
