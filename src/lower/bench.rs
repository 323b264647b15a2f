//! Checks a schedule against the instruments that its channels are wired to.
//!
//! Input: a schedule and the claims with the program's bench. Promise, for a schedule that passes: every level is
//! within the range of the output that plays it and of the amplifier behind it; a switched channel has only the two
//! levels of its switch; no amplifier needs longer for a change than the new level lasts; stages can follow their
//! channels ([`super::stages`]); every edge falls on a sample of its instrument's clock, and levels are as fine as
//! the device needs ([`super::sampled`]). Faults are reported at the wire, together with the step that causes them.

use super::wired_channel::WiredChannel;
use super::{sampled, stages};
use crate::claims::Claims;
use crate::device::instrument::{InstrumentFacts, Link, OutputSort, QUOTIENT_ROOM};
use crate::diagnostic::{Code, Diagnostic, Sink};
use crate::quantity::{Dimension, Quantity};
use crate::schedule::levels::joined;
use crate::schedule::{Actuation, Schedule};
use std::collections::BTreeMap;

/// Whether all instruments can play the schedule; if not, errors were pushed.
pub fn check(schedule: &Schedule, claims: &Claims, sink: &mut Sink) -> bool {
    let before = sink.errors();
    let wired = schedule.channels.iter().zip(schedule.by_channel()).enumerate();
    let wired = wired.filter_map(|(index, (channel, actuations))| {
        let (drive, instrument) = claims.bench.drive(&channel.name)?;
        Some(WiredChannel { schedule, channel, index, drive, instrument, actuations })
    });
    let wired: Vec<WiredChannel> = wired.collect();
    for channel in &wired {
        let finding = channel.beyond_range().or_else(|| channel.unswitched()).or_else(|| channel.beyond_driver());
        let finding = finding.or_else(|| channel.rests_beyond()).or_else(|| channel.too_fast());
        let finding = finding.or_else(|| stages::beyond_stage(channel, &wired, claims));
        let finding = finding.or_else(|| sampled::coarser_than_its_use(channel, claims));
        finding.into_iter().for_each(|finding| sink.push(finding));
    }
    sampled::finer_than_a_sample(&wired).into_iter().for_each(|finding| sink.push(finding));
    shorter_than_a_frame(&wired).into_iter().for_each(|finding| sink.push(finding));
    sink.errors() == before
}

impl WiredChannel<'_> {
    /// The level that exceeds the range of the output or of the amplifier by most.
    fn beyond_range(&self) -> Option<Diagnostic> {
        let Link::Amplifier { gain, limit_v, .. } = self.drive.link else { return self.beyond_stage_driver() };
        let largest = self.largest(|value| value.abs())?;
        let (value, actuation) = largest;
        let (name, output) = (&self.channel.name, format!("{}.{}", self.drive.instrument, self.drive.output));
        if let Some(limit_v) = limit_v.filter(|limit_v| value.abs() > *limit_v) {
            let title = format!(
                "`{name}` needs {}, but its amplifier gives up to {}",
                Quantity::voltage(value),
                Quantity::voltage(limit_v)
            );
            let finding =
                self.finding(Code::E0620, title, format!("`limit` of {}", Quantity::voltage(limit_v)), actuation.step);
            return Some(finding.help("use an amplifier with a higher voltage, or lower the voltages of the device"));
        }
        let peak_v = self.instrument.facts.voltage()?.peak_v;
        let needed_v = (value / gain).abs();
        (needed_v > peak_v * QUOTIENT_ROOM).then(|| {
            let title = format!(
                "`{name}` needs {}, which is {} at output `{output}`; it gives up to {}",
                Quantity::voltage(value),
                Quantity::voltage(needed_v),
                Quantity::voltage(peak_v)
            );
            let least = 10_f64.max((value.abs() / peak_v).ceil());
            let at_wire = if gain == 1.0 { "no amplifier here".to_owned() } else { format!("gain of {gain}") };
            let help = format!("put an amplifier behind the output and declare it: `-> {output} {{ gain: {least} }}`");
            self.finding(Code::E0620, title, at_wire, actuation.step).help(help)
        })
    }

    /// The position that exceeds the voltages of the output by most.
    fn beyond_stage_driver(&self) -> Option<Diagnostic> {
        let Link::StageDriver { zero_v, scale_v_per_um } = self.drive.link else { return None };
        let (value, actuation) = self.largest(|value| self.drive.link.at_output(value).abs())?;
        let peak_v = self.instrument.facts.voltage()?.peak_v;
        let needed_v = self.drive.link.at_output(value);
        (needed_v.abs() > peak_v * QUOTIENT_ROOM).then(|| {
            let (name, position) = (&self.channel.name, self.shown(value));
            let title = format!(
                "`{name}` at {position} needs {}, but the output gives up to {}",
                Quantity::voltage(needed_v),
                Quantity::voltage(peak_v)
            );
            let at_wire = format!("{zero_v} V at 0 um, {scale_v_per_um} V/um");
            let reach = |v: f64| self.shown(self.drive.link.value(v));
            let help =
                format!("check `scale` and `zero`: this output reaches from {} to {}", reach(-peak_v), reach(peak_v));
            self.finding(Code::E0620, title, at_wire, actuation.step).help(help)
        })
    }

    /// A rest voltage that the output or its switch cannot give.
    fn rests_beyond(&self) -> Option<Diagnostic> {
        let rest_v = self.channel.rest_v;
        let (code, given) = match self.drive.link {
            Link::Amplifier { gain, limit_v, .. } => {
                let peak_v = self.instrument.facts.voltage()?.peak_v * gain.abs();
                let given_v = limit_v.map_or(peak_v, |limit_v| limit_v.min(peak_v));
                (rest_v.abs() > given_v * QUOTIENT_ROOM)
                    .then(|| (Code::E0620, format!("up to {}", Quantity::voltage(given_v))))?
            }
            Link::Switch { on_v } => (rest_v != 0.0 && rest_v != on_v)
                .then(|| (Code::E0621, format!("0 V or {}", Quantity::voltage(on_v))))?,
            Link::StageDriver { .. } | Link::Axis { .. } => return None,
        };
        let title =
            format!("`{}` rests at {}, but its output gives {given}", self.channel.name, Quantity::voltage(rest_v));
        let diagnostic = Diagnostic::new(code, title).label(self.drive.span, given);
        Some(diagnostic.help("choose another `rest` of the output, or wire it to an output that gives that voltage"))
    }

    /// The value with the largest `size`, and its actuation.
    fn largest(&self, size: impl Fn(f64) -> f64) -> Option<(f64, &Actuation)> {
        let all = self.actuations.iter().flat_map(|actuation| actuation.levels().map(|value| (value, *actuation)));
        all.reduce(|best, next| if size(next.0) > size(best.0) { next } else { best })
    }

    /// A level that is not one of the two levels of a switch.
    fn unswitched(&self) -> Option<Diagnostic> {
        let Link::Switch { on_v } = self.drive.link else { return None };
        let other = |value: &f64| *value != 0.0 && *value != on_v;
        let found = self
            .actuations
            .iter()
            .find_map(|actuation| Some((actuation.levels().into_iter().find(other)?, *actuation)));
        let (value, actuation) = found?;
        let name = &self.channel.name;
        let title = format!("`{name}` needs {}, but its switch gives {}", self.shown(value), Quantity::voltage(on_v));
        let finding =
            self.finding(Code::E0621, title, format!("`switches` {}", Quantity::voltage(on_v)), actuation.step);
        let levels = self.actuations.iter().flat_map(|actuation| actuation.levels()).filter(|value| *value != 0.0);
        let has_several = levels.clone().any(|level| level != value);
        Some(finding.help(match has_several {
            true => "wire this channel to a voltage output: it has several voltages, but a switch gives one",
            false => "feed the switch with the voltage of the device, or set the device to that of the switch",
        }))
    }

    /// A level that an electrode driver cannot be set to.
    fn beyond_driver(&self) -> Option<Diagnostic> {
        let InstrumentFacts::ElectrodeDriver(facts) = &self.instrument.facts else { return None };
        // A magnet or a heater is on or off, whatever the level of the output that switches it.
        if self.instrument.facts.output(&self.drive.output) == Some(OutputSort::Accessory) {
            return None;
        }
        let (value, actuation) = self.largest(|value| value.abs())?;
        let range = facts.least_v / QUOTIENT_ROOM..=facts.most_v * QUOTIENT_ROOM;
        (!range.contains(&value.abs())).then(|| {
            let [least, most] = [facts.least_v, facts.most_v].map(Quantity::voltage);
            let range = if facts.least_v > 0.0 { format!("{least} to {most}") } else { format!("up to {most}") };
            let (name, driver) = (&self.channel.name, &self.drive.instrument);
            let title = format!("`{name}` needs {}, but `{driver}` gives {range}", self.shown(value));
            let help =
                "give the device a `potential` in this range that its droplets move at, or choose another driver";
            self.finding(Code::E0620, title, range, actuation.step).help(help)
        })
    }

    /// A change for which an amplifier needs longer than its new level lasts.
    fn too_fast(&self) -> Option<Diagnostic> {
        let Link::Amplifier { slew_v_per_s: Some(slew), .. } = self.drive.link else { return None };
        let mut last = (0, self.channel.rest_v);
        let mut slowest: Option<(f64, f64, &Actuation)> = None;
        let mut change = |step_v: f64, lasts_ns: u64, actuation| {
            let share = step_v.abs() / slew * 1e9 / lasts_ns as f64;
            if slowest.is_none_or(|(worst, ..)| share > worst) {
                slowest = Some((share, step_v, actuation));
            }
        };
        let joined = joined(self.actuations.iter().copied());
        for actuation in &joined {
            let from_v = if last.0 == actuation.start_ns { last.1 } else { self.channel.rest_v };
            match actuation.swing {
                None => change(actuation.from - from_v, actuation.duration_ns, actuation),
                Some(swing) => {
                    change(swing.levels[0] - from_v, swing.period_ns / 2, actuation);
                    change(swing.levels[1] - swing.levels[0], swing.period_ns / 2, actuation);
                }
            }
            last = (actuation.end_ns(), actuation.to);
        }
        let (share, step_v, actuation) = slowest.filter(|(share, ..)| *share > 1.0)?;
        let takes_ns = step_v.abs() / slew * 1e9;
        let [takes, lasts] = [takes_ns, takes_ns / share].map(|ns| Quantity::new(ns / 1e9, Dimension::TIME));
        let slew = Quantity::new(slew, Dimension::SLEW_RATE);
        let title = format!(
            "`{}` changes by {} and stays for {lasts}, but its amplifier takes {takes}",
            self.channel.name,
            Quantity::voltage(step_v.abs())
        );
        let finding = self.finding(Code::E0622, title, format!("`slew` of {slew}"), actuation.step);
        Some(finding.help("use a faster amplifier, or longer times of the device"))
    }
}

/// For each electrode driver, compares the shortest time between two changes of its electrodes with that between its
/// frames.
fn shorter_than_a_frame(wired: &[WiredChannel]) -> Vec<Diagnostic> {
    let mut changes: BTreeMap<&str, (&WiredChannel, u64, BTreeMap<u64, Actuation>)> = BTreeMap::new();
    for wired in wired {
        let InstrumentFacts::ElectrodeDriver(facts) = &wired.instrument.facts else { continue };
        let (_, _, at) =
            changes.entry(&wired.drive.instrument).or_insert((wired, facts.least_frame_ns, BTreeMap::new()));
        for actuation in wired.away_from_rest() {
            at.extend([(actuation.start_ns, actuation), (actuation.end_ns(), actuation)]);
        }
    }
    let too_short = changes.into_values().filter_map(|(wired, least_ns, at)| {
        let drive = wired.drive;
        let instants = at.keys().zip(at.iter().skip(1));
        let (lasts_ns, actuation) =
            instants.map(|(from, (to, actuation))| (to - from, actuation)).min_by_key(|(ns, _)| *ns)?;
        (lasts_ns < least_ns).then(|| {
            let [lasts, least] = [lasts_ns, least_ns].map(Quantity::time_ns);
            let step = &wired.schedule.steps[actuation.step as usize];
            let title = format!("a frame lasts {lasts}, but `{}` needs {least} or more", drive.instrument);
            Diagnostic::new(Code::E0623, title)
                .label(drive.span, format!("`least_frame` of {least}"))
                .label_elsewhere(step.span, drive.span, "in this step")
                .help(format!("give the device a `step_duration` of {least} or more, and make waits at least as long"))
        })
    });
    too_short.collect()
}
