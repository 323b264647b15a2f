//! Reservoirs with pads: the frames that dispense a droplet, and the droplets nearby meanwhile.

use super::build::{BEAT, alone, assay, cell, chip, dispense, go, operation, order, schedule, without_places};
use super::{one_step, rules, why};
use crate::claims::Claims;
use crate::claims::electrode_array::{AssayOperation, ElectrodeArrayAction, ElectrodeArrayOrder};
use crate::device::electrode_array::{
    DispenseFrame, DispenseSequence, ElectrodeArrayFacts, ElectrodeMap, ReservoirPads,
};
use crate::schedule::{Actuation, Channel, ChannelUnit, Schedule};
use crate::verify::Rule;
use std::sync::Arc;

/// Frames of two beats each; in the first two the outlet is off, and in the last one it holds the droplet alone.
const FRAMES: [(&[u32], bool); 4] = [(&[500], false), (&[500, 501], false), (&[501], true), (&[], true)];

fn sequence(outlet: (u32, u32), frames: &[(&[u32], bool)]) -> DispenseSequence {
    let frame = |(pads, outlet): &(&[u32], bool)| DispenseFrame { pads: pads.to_vec(), outlet: *outlet };
    DispenseSequence { outlet: cell(outlet.0, outlet.1), frames: frames.iter().map(frame).collect() }
}

fn facts(pads: ReservoirPads) -> ElectrodeArrayFacts {
    let map = ElectrodeMap { columns: 14, channels: (0..196).map(Some).collect(), disabled: Vec::new() };
    ElectrodeArrayFacts { map: Some(Arc::new(map)), reservoirs: Some(Arc::new(pads)), ..chip(14, 14) }
}

/// `a` is dispensed at (4, 4) in eight beats; `then` has the later operations. `b` stays far away.
fn made(then: Vec<AssayOperation>) -> ElectrodeArrayOrder {
    let operations: Vec<AssayOperation> = std::iter::once(dispense(0, (4, 4), 8)).chain(then).collect();
    let pads = ReservoirPads { frame_ns: 2 * BEAT, sequences: vec![sequence((4, 4), &FRAMES)] };
    let order = assay(&[("a", 1, 1), ("b", 10, 10)], operations);
    without_places(ElectrodeArrayOrder { facts: facts(pads), ..order }, &[0])
}

/// A pulse on a channel: its name, and the beats from which and until which it is on.
type PadPulse = (&'static str, u64, u64);

/// The pads as the frames demand, for a droplet that is dispensed from the first beat on.
const SOUND: [PadPulse; 2] = [("pad500", 0, 4), ("pad501", 2, 6)];

/// The schedule of an order like [`made`], with some pads on, and with the outlet off before a beat.
fn played(order: ElectrodeArrayOrder, words: &[&str], outlet_from: u64, pads: &[PadPulse]) -> (Schedule, Claims) {
    let (mut schedule, claims) = one_step(order, words);
    let begins = words[0].find('o').unwrap_or_default() as u64;
    let outlet = schedule.channels.iter().position(|channel| channel.name.ends_with(".e4_4")).expect("the outlet");
    let is_first = |own: &&mut Actuation| own.channel as usize == outlet && own.start_ns == begins * BEAT;
    let first = schedule.actuations.iter_mut().find(is_first).expect("it holds the droplet");
    first.start_ns += outlet_from * BEAT;
    first.duration_ns -= outlet_from * BEAT;
    let like = *first;
    let device = schedule.channels[outlet].device.clone();
    for (name, from, to) in pads {
        let name = format!("{device}.{name}");
        let known = schedule.channels.iter().position(|channel| channel.name == name);
        let channel = known.unwrap_or(schedule.channels.len());
        if known.is_none() {
            let channel = Channel { name, device: device.clone(), unit: ChannelUnit::Volt, wire: None, rest_v: 0.0 };
            schedule.channels.push(channel);
        }
        let (start_ns, duration_ns) = (from * BEAT, (to - from) * BEAT);
        schedule.actuations.push(Actuation { channel: channel as u32, start_ns, duration_ns, ..like });
    }
    schedule.actuations.sort_by_key(|actuation| (actuation.start_ns, actuation.channel));
    (schedule, claims)
}

#[track_caller]
fn found(words: &[&str], outlet_from: u64, pads: &[PadPulse], expected: &[Rule]) {
    let (schedule, claims) = played(made(vec![operation(go(0, &[(5, 4)]))]), words, outlet_from, pads);
    assert_eq!(rules(&schedule, &claims), expected, "{words:?} {outlet_from} {pads:?}");
}

const WORDS: [&str; 2] = ["o.......R", "........."];

#[test]
fn a_droplet_is_made_by_its_frames() {
    found(&WORDS, 4, &SOUND, &[]);
    found(&["__o.......R", "..........."], 4, &[("pad500", 2, 6), ("pad501", 4, 8)], &[]);
    // Without the first frame no droplet comes.
    found(&WORDS, 4, &[], &[Rule::State]);
    found(&WORDS, 4, &[("pad501", 2, 6)], &[Rule::State]);
}

#[test]
fn pads_and_outlets_follow_the_frames_and_nothing_else() {
    // Too short, too long, too early, too late; and the outlet on too early.
    found(&WORDS, 4, &[("pad500", 0, 3), ("pad501", 2, 6)], &[Rule::Reservoir]);
    found(&WORDS, 4, &[("pad500", 0, 5), ("pad501", 2, 6)], &[Rule::Reservoir]);
    found(&WORDS, 4, &[("pad500", 0, 4), ("pad501", 1, 6)], &[Rule::Reservoir]);
    found(&WORDS, 4, &[("pad500", 0, 4), ("pad501", 3, 6)], &[Rule::Reservoir]);
    found(&WORDS, 4, &[("pad500", 0, 4)], &[Rule::Reservoir]);
    found(&WORDS, 4, &[("pad500", 0, 4), ("pad500", 7, 8), ("pad501", 2, 6)], &[Rule::Reservoir]);
    found(&WORDS, 4, &[("pad500", 0, 4), ("pad501", 2, 6), ("pad501", 8, 9)], &[Rule::Reservoir]);
    for early in [0, 2, 3] {
        found(&WORDS, early, &SOUND, &[Rule::Reservoir]);
    }
    // If the outlet is on too late, the droplet rests on an electrode that is off.
    found(&WORDS, 5, &SOUND, &[Rule::Hold]);
}

#[test]
fn pads_have_the_potential_of_the_device_and_are_switched_between_beats() {
    let sound = || played(made(vec![operation(go(0, &[(5, 4)]))]), &WORDS, 4, &SOUND);
    let pad = |schedule: &mut Schedule, edit: &dyn Fn(&mut Actuation)| {
        let index = schedule.channels.iter().position(|channel| channel.name.ends_with("pad500")).expect("a pad");
        schedule.actuations.iter_mut().filter(|own| own.channel as usize == index).for_each(edit);
    };
    let (mut schedule, claims) = sound();
    pad(&mut schedule, &|own| (own.from, own.to) = (99.0, 99.0));
    assert_eq!(rules(&schedule, &claims), [Rule::Potential]);
    let (mut schedule, claims) = sound();
    pad(&mut schedule, &|own| own.duration_ns -= 1);
    assert_eq!(rules(&schedule, &claims), [Rule::Beat]);
    // A channel that belongs to no reservoir.
    let (mut schedule, claims) = sound();
    schedule.channels.iter_mut().filter(|own| own.name.ends_with("pad500")).for_each(|own| own.name.push('0'));
    assert_eq!(rules(&schedule, &claims), [Rule::Channel]);
}

#[test]
fn no_pad_is_on_outside_of_assays() {
    let pads = ReservoirPads { frame_ns: 2 * BEAT, sequences: vec![sequence((4, 4), &FRAMES)] };
    for action in [ElectrodeArrayAction::Move(vec![go(0, &[(5, 4)])]), ElectrodeArrayAction::Wait(BEAT)] {
        let word = if matches!(action, ElectrodeArrayAction::Wait(_)) { "" } else { "R" };
        let (schedule, claims) = one_step(order(facts(pads.clone()), &[("a", 4, 4)], vec![action]), &[word]);
        assert!(rules(&schedule, &claims).is_empty());
        let mut schedule = schedule;
        let device = schedule.channels[0].device.clone();
        let channel = schedule.channels.len() as u32;
        let like = schedule.actuations[0];
        let name = format!("{device}.pad500");
        schedule.channels.push(Channel { name, device, unit: ChannelUnit::Volt, wire: None, rest_v: 0.0 });
        schedule.actuations.push(Actuation { channel, ..like });
        assert_eq!(rules(&schedule, &claims), [Rule::Reservoir]);
    }
}

#[test]
fn claims_of_reservoirs_are_sound() {
    let judged = |pads: ReservoirPads, beats: u64| {
        let order = assay(&[("a", 1, 1)], vec![dispense(0, (4, 4), beats)]);
        let claims = alone(without_places(ElectrodeArrayOrder { facts: facts(pads), ..order }, &[0]));
        why(&schedule(&claims, &[&[&["o"]]]), &claims).is_none()
    };
    let pads = |frame_ns, sequences| ReservoirPads { frame_ns, sequences };
    let own = || sequence((4, 4), &FRAMES);
    assert!(judged(pads(2 * BEAT, vec![own()]), 8));
    assert!(!judged(pads(2 * BEAT, vec![own()]), 7), "another time than the frames take");
    assert!(!judged(pads(0, vec![own()]), 8) && !judged(pads(BEAT / 2, vec![own()]), 2));
    assert!(!judged(pads(2 * BEAT, vec![own(), own()]), 8), "one outlet twice");
    assert!(!judged(pads(2 * BEAT, vec![own(), sequence((4, 8), &FRAMES)]), 8), "one pad twice");
    assert!(!judged(pads(2 * BEAT, vec![sequence((4, 15), &FRAMES)]), 8), "off the board");
    assert!(!judged(pads(2 * BEAT, vec![sequence((4, 4), &[])]), 8));
    assert!(!judged(pads(2 * BEAT, vec![sequence((4, 4), &[(&[], true)])]), 2), "no pad at first");
    assert!(!judged(pads(2 * BEAT, vec![sequence((4, 4), &[(&[500], false)])]), 2), "no droplet at last");
}
