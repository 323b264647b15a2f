//! Description of a script, for the person who connects the instrument.

use super::sequence::Sequence;
use super::{ASK_ERROR, BEGIN, Generator, Playing, REST, SWITCH_OFF, numbered, segment_name};
use crate::device::instrument::{Link, Start};
use crate::emit::csv::one_line;
use crate::quantity::significant;
use crate::schedule::ChannelUnit;
use std::fmt::Write as _;

impl Generator<'_> {
    /// The text file beside the script.
    pub(super) fn description(&self) -> String {
        let schedule = self.signals.schedule;
        let (name, instrument) = (&schedule.name, self.wired.name);
        let start = match self.facts.start {
            Start::Sender => format!("The last message, {BEGIN}, starts all outputs."),
            Start::Trigger => "It waits for a rising edge at its trigger input, which starts all outputs.".to_owned(),
        };
        let leads =
            if self.wired.leads { " Its trigger output rises then: lead it to the other instruments." } else { "" };
        let mut text = format!(
            "{name}.{instrument}.scpi holds what to send to `{instrument}` ({model}), message by message, each ended by a line feed.\n\
             {name}.scpi.py does so. By hand: read the answer to every {ASK_ERROR}, where anything but 0 means that a message was\n\
             refused, and {at_end} when all is played. {start}{leads}\n\
             Compare the commands with the manual of your instrument, connect the actuators last, and try at a low voltage first.\n\n\
             Voltages are those of an output without load, filters are off. {playback}\n{stages}\n\
             output\tlow [V]\thigh [V]\tchannel\tbehind the output\tleast step of the channel\twire\n",
            at_end = self.at_end(),
            model = one_line(&self.wired.instrument.model),
            playback = self.playback(),
            stages = self.stages(),
        );
        for (channel, output) in self.signals.schedule.channels.iter().zip(&self.outputs) {
            let wire = channel.wire.as_deref().map_or_else(|| "-".to_owned(), one_line);
            let _ = writeln!(
                text,
                "ch{}\t{}\t{}\t{}\t{}\t{} {}\t{wire}",
                output.number,
                output.low_v,
                output.high_v,
                channel.name,
                behind(output.link),
                self.least_step(output.span_v(), output.link),
                channel.unit.symbol(),
            );
        }
        if self.outputs.iter().any(|output| matches!(output.playing, Playing::Sequence(_))) {
            text.push_str("\noutput\tstep\tsegment\tpoints\ttimes\tgoes on\tfirst sample\n");
        }
        for output in &self.outputs {
            if let Playing::Sequence(sequence) = &output.playing {
                list(&mut text, output.number, sequence);
            }
        }
        text
    }

    /// Manual steps at the end; without the voltage of its output a stage would run to its zero.
    fn at_end(&self) -> String {
        let off =
            self.outputs.iter().enumerate().filter(|(_, output)| !matches!(output.link, Link::StageDriver { .. }));
        let off: Vec<String> = off
            .map(|(channel, output)| match self.signals.rest_v(channel).unwrap_or_default() {
                0.0 => numbered(SWITCH_OFF, output.number),
                rest_v => numbered(REST, output.number).replace("{rest}", &output.link.at_output(rest_v).to_string()),
            })
            .collect();
        match off.is_empty() {
            true => "leave the outputs on, which hold the stages,".to_owned(),
            false => format!("send {}", off.join(" and ")),
        }
    }

    /// Step between two neighbouring codes at the instrument's resolution, in the channel's unit.
    fn least_step(&self, span_v: f64, link: Link) -> f64 {
        let codes = f64::from(2_u32.saturating_pow(self.facts.voltage.bits) - 2);
        let step_v = span_v / codes;
        significant((link.value(step_v) - link.value(0.0)).abs(), 3)
    }

    /// Sampling of the position outputs.
    fn stages(&self) -> String {
        let Some(step_um) = self.sampling.step_um(&self.signals) else { return String::new() };
        format!(
            "Outputs of positions wait at the first position and rest at the last one. Straight lines are sampled: a stage moves by\n\
             {step_um} um at the most from one sample to the next.\n"
        )
    }

    /// Duration of the playback, and how the outputs wait and rest.
    fn playback(&self) -> String {
        let (period_ns, duration) = (self.sampling.period_ns, seconds(self.signals.schedule.duration_ns));
        let of_volts = self.signals.in_unit(ChannelUnit::Volt).next().is_some();
        let is_off = |channel: usize| self.signals.rest_v(channel) == Some(0.0);
        let rest = match of_volts {
            true if self.signals.in_unit(ChannelUnit::Volt).all(is_off) => "0 V",
            true => "what the channel rests at",
            false => "where the stage is",
        };
        match self.outputs.iter().any(|output| matches!(output.playing, Playing::Sequence(_))) {
            false => format!(
                "A sample lasts {period_ns} ns, a waveform {points}\nsamples. The schedule lasts {duration} s and begins at the second \
                 sample: the first and the last are {rest}, because an output waits at\nits first sample and rests at its last.",
                points = self.sampling.points,
            ),
            true => format!(
                "Each output plays a sequence: segments one\nafter the other, each so many times, as the table at the end lists them. A \
                 sample lasts {period_ns} ns. The schedule lasts {duration} s\nand begins when the trigger comes, at the second step: the \
                 first and the last segment are {rest}; there an output waits for its\ntrigger and rests when all is played."
            ),
        }
    }
}

/// The link between an output and its channel.
fn behind(link: Link) -> String {
    match link {
        Link::Amplifier { gain: 1.0, .. } => "nothing".to_owned(),
        Link::Amplifier { gain, .. } => format!("amplifier x {gain}"),
        Link::StageDriver { zero_v, scale_v_per_um } => {
            format!("stage driver, {scale_v_per_um} V/um from {zero_v} V on")
        }
        Link::Switch { on_v } => format!("switch of {on_v} V"),
        Link::Axis { .. } => "stage".to_owned(),
    }
}

fn seconds(t_ns: u64) -> String {
    format!("{}.{:09}", t_ns / 1_000_000_000, t_ns % 1_000_000_000)
}

/// Lists the steps of a sequence; samples count from the trigger.
fn list(text: &mut String, output: u32, sequence: &Sequence) {
    let mut sample = 0;
    for (number, step) in (1..).zip(&sequence.steps) {
        let (name, points) = (segment_name(output, step.segment), sequence.segments[step.segment].len() as u64);
        let first = if number == 1 { "-".to_owned() } else { sample.to_string() };
        let (times, way_on) = (step.repeats, step.control.word());
        let _ = writeln!(text, "ch{output}\t{number}\t{name}\t{points}\t{times}\t{way_on}\t{first}");
        sample += if number == 1 { 0 } else { points * step.repeats };
    }
}
