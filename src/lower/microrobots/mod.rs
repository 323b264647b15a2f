//! Lowers a plan of microrobots to the voltage of the bed, on a clock of its own.
//!
//! Each leg is the control cycle of its state, level by level, followed by a single actuation, however long, that
//! swings between the flex and the relax level, one period per stroke. There are no gaps between the levels, because
//! at 0 V all arms would go up.

pub mod command;

use super::Lowered;
use super::clock::LoweredRun;
use crate::claims::microrobots::MicrorobotsOrder;
use crate::device::microrobots::{Arm, CHANNEL};
use crate::plan::Planned;
use crate::plan::microrobots::{Crew, Leg, MicrorobotsMotion, MicrorobotsStepMotion, RobotDocking};
use crate::schedule::microrobots::{MicrorobotsState, RecordedPose};
use crate::schedule::{Actuation, ChannelUnit, State, Swing, TimedState};

impl Lowered for Planned<'_, MicrorobotsOrder, MicrorobotsMotion> {
    fn run(&self) -> Option<LoweredRun> {
        let Planned { order, motion } = self;
        let mut bed = LoweringBed { order, run: LoweredRun::default(), crew: motion.start.clone() };
        for (index, (step, motion)) in order.steps.iter().zip(&motion.steps).enumerate() {
            let start_ns = bed.run.duration_ns;
            match motion {
                MicrorobotsStepMotion::Wait(duration_ns) => {
                    bed.record_rest();
                    bed.run.duration_ns = start_ns.checked_add(*duration_ns)?;
                }
                MicrorobotsStepMotion::Legs { legs, docks, .. } => bed.follow(legs, docks, index)?,
            }
            bed.run.steps.push((step.span, start_ns, bed.run.duration_ns - start_ns));
        }
        bed.record_rest();
        Some(bed.run)
    }

    fn channels(&self, _own: &mut dyn Iterator<Item = &LoweredRun>) -> Vec<(String, ChannelUnit)> {
        vec![(CHANNEL.to_owned(), ChannelUnit::Volt)]
    }
}

/// State of the bed while its plan is lowered.
struct LoweringBed<'a> {
    order: &'a MicrorobotsOrder,
    run: LoweredRun,
    crew: Crew,
}

impl LoweringBed<'_> {
    fn follow(&mut self, legs: &[Leg], docks: &[RobotDocking], step: usize) -> Option<()> {
        for (index, leg) in legs.iter().enumerate() {
            self.record(leg.state);
            self.drive(leg, step)?;
            self.crew.follow(self.order, index, leg, docks);
        }
        Some(())
    }

    /// Adds the control cycle and the drive train of a leg.
    fn drive(&mut self, leg: &Leg, step: usize) -> Option<()> {
        let facts = &self.order.facts;
        for &level_v in &self.order.states[leg.state].levels_v {
            self.add(facts.dwell_ns, [level_v; 2], None, step)?;
        }
        let levels = [facts.flex_v, facts.relax_v];
        let swing = Swing { period_ns: facts.period_ns, levels };
        self.add(leg.strokes.checked_mul(facts.period_ns)?, levels, Some(swing), step)
    }

    fn add(&mut self, duration_ns: u64, [from, to]: [f64; 2], swing: Option<Swing>, step: usize) -> Option<()> {
        let start_ns = self.run.duration_ns;
        let (channel, step) = (self.run.channel(CHANNEL), step as u32);
        self.run.actuations.push(Actuation { channel, start_ns, duration_ns, from, to, swing, step });
        self.run.duration_ns = start_ns.checked_add(duration_ns)?;
        Some(())
    }

    /// Records the state of a leg that begins now.
    fn record(&mut self, control: usize) {
        let arms: Vec<u8> = self.order.states[control].arms.iter().map(|arm| arm.digit()).collect();
        let name = |robot: usize| self.order.robot(robot).name.clone();
        let mut docked: Vec<String> =
            (0..self.crew.docked.len()).filter(|robot| self.crew.docked[*robot]).map(name).collect();
        docked.sort_unstable();
        let poses =
            self.crew.poses.iter().enumerate().map(|(robot, pose)| (name(robot), RecordedPose::from(*pose))).collect();
        let state = State::Microrobots(MicrorobotsState { control, arms, docked, poses });
        self.run.states.push(TimedState { t_ns: self.run.duration_ns, state });
    }

    /// Records the state of a bed without voltage: all arms are up.
    fn record_rest(&mut self) {
        let up = self.order.states.iter().position(|state| state.arms.iter().all(|arm| *arm == Arm::Up));
        self.record(up.unwrap_or(0));
    }
}

#[cfg(test)]
pub(crate) mod tests;
