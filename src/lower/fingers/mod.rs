//! Lowers a hand's plan to positions of its stages, on a clock of its own.
//!
//! Each axis of each finger has a value at every instant of a run: ramps while it moves, and one constant actuation
//! while it rests, both within their steps. A step in which nothing happens takes no time and has no actuation.

use super::Lowered;
use super::clock::LoweredRun;
use crate::claims::fingers::FingersOrder;
use crate::device::fingers::{AXES, channel};
use crate::plan::Planned;
use crate::plan::fingers::{FingersMotion, HeldGrasp, TipsMove};
use crate::schedule::fingers::FingersState;
use crate::schedule::{Actuation, ChannelUnit, State, TimedState};

impl Lowered for Planned<'_, FingersOrder, FingersMotion> {
    fn run(&self) -> Option<LoweredRun> {
        let Planned { order, motion } = self;
        let start = &motion.start;
        let axes = |finger: usize| (0..AXES.len()).map(move |axis| channel(finger, axis));
        let channels = (0..start.tips_um.len()).flat_map(axes).collect();
        let mut hand =
            Lowering { run: LoweredRun { channels, ..LoweredRun::default() }, tips_um: start.tips_um.clone() };
        hand.record(&start.hold);
        for (index, (step, moves)) in order.steps.iter().zip(&motion.steps).enumerate() {
            let start_ns = hand.run.duration_ns;
            hand.follow(moves, index)?;
            hand.run.steps.push((step.span, start_ns, hand.run.duration_ns - start_ns));
        }
        Some(hand.run)
    }

    fn channels(&self, _own: &mut dyn Iterator<Item = &LoweredRun>) -> Vec<(String, ChannelUnit)> {
        self.order.facts.channels().into_iter().map(|name| (name, ChannelUnit::Micrometre)).collect()
    }
}

/// State of the hand while its plan is lowered.
struct Lowering {
    run: LoweredRun,
    /// Current position of each tip.
    tips_um: Vec<[f64; 3]>,
}

/// A segment of a channel within a step.
struct ChannelStretch {
    start_ns: u64,
    end_ns: u64,
    from_um: f64,
    to_um: f64,
}

impl Lowering {
    /// Adds the moves of a step.
    fn follow(&mut self, moves: &[TipsMove], step: usize) -> Option<()> {
        let mut channels: Vec<Vec<ChannelStretch>> = (0..self.tips_um.len() * AXES.len()).map(|_| Vec::new()).collect();
        for stretch in moves {
            let start_ns = self.run.duration_ns;
            let end_ns = start_ns.checked_add(stretch.duration_ns)?;
            for (index, stretches) in channels.iter_mut().enumerate() {
                let (finger, axis) = (index / AXES.len(), index % AXES.len());
                let (from_um, to_um) = (self.tips_um[finger][axis], stretch.tips_um[finger][axis]);
                extend(stretches, ChannelStretch { start_ns, end_ns, from_um, to_um });
            }
            self.run.duration_ns = end_ns;
            self.tips_um.clone_from(&stretch.tips_um);
            if let Some(hold) = &stretch.state {
                self.record(hold);
            }
        }
        self.add(channels, step);
        Some(())
    }

    /// Adds the segments of all channels as actuations, sorted by start and then in the order of the channels.
    fn add(&mut self, channels: Vec<Vec<ChannelStretch>>, step: usize) {
        let all = (0..).zip(channels).flat_map(|(channel, stretches)| {
            stretches.into_iter().map(move |stretch| stretch.actuation(channel, step as u32))
        });
        let mut actuations: Vec<Actuation> = all.collect();
        actuations.sort_by_key(|actuation| actuation.start_ns);
        self.run.actuations.append(&mut actuations);
    }

    /// Records a state that begins now, with the current positions of the tips.
    fn record(&mut self, hold: &HeldGrasp) {
        let held = |(finger, contact): (usize, &u32)| (*contact != 0).then(|| self.tips_um[finger]);
        let state = State::Fingers(FingersState {
            grasp: hold.grasp.clone(),
            angle_index: hold.angle_index,
            plane: hold.plane,
            tips_um: hold.grasp.iter().enumerate().map(held).collect(),
            position_um: hold.position_um,
            orientation: hold.orientation,
        });
        self.run.states.push(TimedState { t_ns: self.run.duration_ns, state });
    }
}

impl ChannelStretch {
    fn is_rest(&self) -> bool {
        self.from_um == self.to_um
    }

    fn actuation(&self, channel: u32, step: u32) -> Actuation {
        Actuation {
            channel,
            start_ns: self.start_ns,
            duration_ns: self.end_ns - self.start_ns,
            from: self.from_um,
            to: self.to_um,
            swing: None,
            step,
        }
    }
}

/// Appends a segment, or extends the last one if both are at rest.
fn extend(stretches: &mut Vec<ChannelStretch>, next: ChannelStretch) {
    match stretches.last_mut() {
        Some(last) if last.is_rest() && next.is_rest() => last.end_ns = next.end_ns,
        Some(_) | None => stretches.push(next),
    }
}

#[cfg(test)]
mod tests;
