//! Waveforms as sequences: segments played one after the other, each repeated a number of times.
//!
//! Input: the pieces that an output plays. Output: a [`Sequence`] whose playback is the same, sample by sample, between
//! two stretches at rest, or at its first and its last position: the instrument waits for the trigger in the first one
//! and rests in the last one. Pieces with fewer samples than the minimum of a segment are merged with their neighbours.

use super::{GeneratorOutput, MOST_REPEATS, Sampling};
use crate::device::instrument::WaveformGeneratorFacts;
use crate::emit::Signals;
use crate::emit::hold_parts::parts;
use crate::emit::signal::half_ns;
use crate::schedule::Schedule;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Transition from a step to the next one; the words are those of the instruments.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Control {
    Once,
    /// Holds its last sample until the trigger comes.
    OnceWaitTrigger,
    Repeat,
    RepeatForever,
}

impl Control {
    pub fn word(self) -> &'static str {
        match self {
            Control::Once => "once",
            Control::OnceWaitTrigger => "onceWaitTrig",
            Control::Repeat => "repeat",
            Control::RepeatForever => "repeatInf",
        }
    }
}

/// One entry of a sequence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SequenceEntry {
    /// Index into the sequence's segments.
    pub segment: usize,
    pub repeats: u64,
    pub control: Control,
}

/// Segments and steps of one output.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Sequence {
    /// Distinct segments.
    pub segments: Vec<Vec<i16>>,
    pub steps: Vec<SequenceEntry>,
}

/// Limits of an instrument's memory.
#[derive(Debug, Clone, Copy)]
struct Limits {
    least_points: u64,
    most_points: u64,
    most_repeats: u64,
}

impl Limits {
    fn of(facts: &WaveformGeneratorFacts) -> Limits {
        let [least_points, most_points] = [facts.least_points, facts.most_points].map(u64::from);
        Limits { least_points, most_points, most_repeats: MOST_REPEATS }
    }
}

/// Samples with a number of repetitions.
struct SamplePiece {
    samples: Vec<i16>,
    count: u64,
}

/// The signal of an output: the level at which it waits, the pieces, and the level at which it rests.
struct OutputSignal {
    ends: [i16; 2],
    pieces: Vec<SamplePiece>,
}

/// Positions may be sampled this many times beyond the memory of an instrument before they are packed into it.
const MAX_PACKED: u64 = 16;

/// Pieces of at most this many samples are written out instead of repeated; four times as many if there are too few
/// steps.
const WRITTEN_OUT: u64 = 16;

/// The sequence of a channel; `None` if memory or steps of the instrument do not suffice.
pub fn sequence(
    signals: &Signals,
    channel: usize,
    output: &GeneratorOutput,
    facts: &WaveformGeneratorFacts,
    sampling: &Sampling,
) -> Option<Sequence> {
    let limits = Limits::of(facts);
    let parts = parts(signals.schedule);
    let of_part = |part: &Cow<Schedule>| output_signal(&Signals::new(part), channel, output, limits, sampling);
    let mut output_signals = parts.iter().map(of_part).collect::<Option<Vec<OutputSignal>>>()?;
    // After a wait at the end comes rest.
    if parts.len() == signals.schedule.holds.len() {
        let end = output_signals.last()?.ends[1];
        let rest = signals.rest_v(channel).map_or(end, |rest_v| output.code(rest_v));
        output_signals.push(OutputSignal { ends: [end, rest], pieces: Vec::new() });
    }
    // Each part waits at the level that the one before it holds.
    for at in 1..output_signals.len() {
        output_signals[at].ends[0] = output_signals[at - 1].ends[1];
    }
    let mut written_out = WRITTEN_OUT;
    while written_out < limits.most_points {
        // More samples written out fill the memory, so the loop ends once it is full.
        let sequence = SequenceBuilder::compose(&output_signals, limits, written_out)?;
        if sequence.steps.len() as u64 <= u64::from(facts.most_steps) {
            return Some(sequence);
        }
        written_out *= 4;
    }
    None
}

/// The signal of a part without waits.
fn output_signal(
    signals: &Signals,
    channel: usize,
    output: &GeneratorOutput,
    limits: Limits,
    sampling: &Sampling,
) -> Option<OutputSignal> {
    let Some(rest_v) = signals.rest_v(channel) else { return positions(signals, channel, output, limits, sampling) };
    let end = output.code(signals.value(channel, signals.schedule.duration_ns));
    Some(OutputSignal { ends: [output.code(rest_v), end], pieces: pieces(signals, channel, output, limits, sampling)? })
}

fn pieces(
    signals: &Signals,
    channel: usize,
    output: &GeneratorOutput,
    limits: Limits,
    sampling: &Sampling,
) -> Option<Vec<SamplePiece>> {
    let period_ns = sampling.period_ns;
    let code = |value: f64| output.code(value);
    let mut pieces = Vec::new();
    let rest_v = signals.rest_v(channel).unwrap_or_default();
    let rest = |from_ns: u64, to_ns: u64, pieces: &mut Vec<SamplePiece>| {
        pieces.push(SamplePiece { samples: vec![code(rest_v)], count: to_ns.saturating_sub(from_ns) / period_ns });
    };
    let mut at_ns = 0;
    for actuation in signals.away_from_rest(channel) {
        rest(at_ns, actuation.start_ns, &mut pieces);
        pieces.push(match actuation.swing {
            // A value that a wait holds extends beyond the end of its part.
            None => {
                let end_ns = actuation.end_ns().min(signals.schedule.duration_ns);
                let count = end_ns.saturating_sub(actuation.start_ns) / period_ns;
                SamplePiece { samples: vec![code(actuation.from)], count }
            }
            Some(swing) => {
                let half = half_ns(swing) / period_ns;
                if 2 * half > limits.most_points {
                    return None;
                }
                let [first, second] = swing.levels.map(|level| vec![code(level); half as usize]);
                SamplePiece { samples: [first, second].concat(), count: actuation.duration_ns / swing.period_ns.max(1) }
            }
        });
        at_ns = actuation.end_ns();
    }
    rest(at_ns, signals.schedule.duration_ns, &mut pieces);
    Some(pieces)
}

/// The signal of a stage: a piece for each run of equal samples.
fn positions(
    signals: &Signals,
    channel: usize,
    output: &GeneratorOutput,
    limits: Limits,
    sampling: &Sampling,
) -> Option<OutputSignal> {
    if sampling.points > MAX_PACKED * limits.most_points {
        return None;
    }
    let points = signals.schedule.duration_ns.div_ceil(sampling.period_ns) + 2;
    let own = Sampling { points: points.max(limits.least_points), ..*sampling };
    let codes: Vec<i16> = own.positions(signals, channel).map(|position_um| output.code(position_um)).collect();
    let piece = |run: &[i16]| SamplePiece { samples: vec![run[0]], count: run.len() as u64 };
    // The first sample is the one before the trigger.
    let pieces = codes[1..].chunk_by(|a, b| a == b).map(piece).collect();
    Some(OutputSignal { ends: [*codes.first()?, *codes.last()?], pieces })
}

/// Merges pieces into segments and steps.
struct SequenceBuilder {
    limits: Limits,
    sequence: Sequence,
    index: BTreeMap<Vec<i16>, usize>,
    /// Samples of all segments.
    points: u64,
    /// Samples to be played once, before whatever comes next.
    pending: Vec<i16>,
}

impl SequenceBuilder {
    /// The sequence; `None` if the segments are too large for the instrument's memory.
    fn compose(output_signals: &[OutputSignal], limits: Limits, written_out: u64) -> Option<Sequence> {
        let (sequence, index) = (Sequence::default(), BTreeMap::new());
        let mut builder = SequenceBuilder { limits, sequence, index, points: 0, pending: Vec::new() };
        let level = |code: i16| vec![code; limits.least_points as usize];
        for output_signal in output_signals {
            builder.step(level(output_signal.ends[0]), 1, Control::OnceWaitTrigger)?;
            for piece in &output_signal.pieces {
                builder.add(piece, written_out)?;
            }
            let rest = level(output_signal.ends[1]);
            let missing = rest.len().saturating_sub(builder.pending.len());
            if !builder.pending.is_empty() {
                builder.pending.extend(&rest[..missing]);
            }
            builder.flush()?;
        }
        builder.step(level(output_signals.last()?.ends[1]), 1, Control::RepeatForever)?;
        Some(builder.sequence)
    }

    fn add(&mut self, piece: &SamplePiece, written_out: u64) -> Option<()> {
        let (samples, mut count) = (&piece.samples, piece.count);
        let (least, length) = (self.limits.least_points, samples.len() as u64);
        if length.saturating_mul(count) <= written_out {
            return self.write_out(samples, count);
        }
        while !self.pending.is_empty() && (self.pending.len() as u64) < least && count > 0 {
            self.write_out(samples, 1)?;
            count -= 1;
        }
        if count == 0 {
            return Some(());
        }
        self.flush()?;
        let of_segment = least.div_ceil(length).max(count.div_ceil(self.limits.most_repeats));
        if of_segment.saturating_mul(length) > self.limits.most_points {
            return None;
        }
        match count / of_segment {
            0 => {}
            1 => self.step(samples.repeat(of_segment as usize), 1, Control::Once)?,
            repeats => self.step(samples.repeat(of_segment as usize), repeats, Control::Repeat)?,
        }
        self.write_out(samples, count % of_segment)
    }

    fn write_out(&mut self, samples: &[i16], count: u64) -> Option<()> {
        let length = self.pending.len() as u64 + samples.len() as u64 * count;
        if self.points + length > self.limits.most_points {
            return None;
        }
        (0..count).for_each(|_| self.pending.extend(samples));
        Some(())
    }

    fn flush(&mut self) -> Option<()> {
        match std::mem::take(&mut self.pending) {
            pending if pending.is_empty() => Some(()),
            pending => self.step(pending, 1, Control::Once),
        }
    }

    fn step(&mut self, samples: Vec<i16>, repeats: u64, control: Control) -> Option<()> {
        let segment = match self.index.get(&samples) {
            Some(known) => *known,
            None => {
                self.points += samples.len() as u64;
                self.index.insert(samples.clone(), self.sequence.segments.len());
                self.sequence.segments.push(samples);
                self.sequence.segments.len() - 1
            }
        };
        self.sequence.steps.push(SequenceEntry { segment, repeats, control });
        (self.points <= self.limits.most_points).then_some(())
    }
}

#[cfg(test)]
mod tests;
