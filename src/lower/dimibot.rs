//! Lowers a DiMiBot's plan to pulses, on a clock of its own.
//!
//! A pulse has the device's pulse duration; the rest that follows is part of it, so that the modules are settled for
//! whatever comes next.

use super::Lowered;
use super::clock::LoweredRun;
use crate::claims::dimibot::DimibotOrder;
use crate::device::dimibot::{DimibotFacts, LatticeCell, Side, Switch};
use crate::plan::Planned;
use crate::plan::dimibot::{DimibotMotion, DimibotStepMotion, ModulePulse};
use crate::schedule::dimibot::DimibotState;
use crate::schedule::{Actuation, ChannelUnit, State, TimedState};

impl Lowered for Planned<'_, DimibotOrder, DimibotMotion> {
    fn run(&self) -> Option<LoweredRun> {
        let Planned { order, motion } = self;
        let facts = &order.facts;
        let mut run = LoweredRun::default();
        let mut cell = motion.start;
        let mut delays = motion.delays.iter();
        run.states.push(TimedState { t_ns: 0, state: state(facts, cell) });
        for (index, (step, motion)) in order.steps.iter().zip(&motion.steps).enumerate() {
            let start_ns = run.duration_ns;
            match motion {
                DimibotStepMotion::Wait(duration_ns) => run.duration_ns = run.duration_ns.checked_add(*duration_ns)?,
                DimibotStepMotion::Pulses(pulses) => {
                    for pulse in pulses {
                        run.duration_ns = run.duration_ns.checked_add(delays.next().copied().unwrap_or(0))?;
                        cell = fire(&mut run, facts, cell, *pulse, index)?;
                    }
                }
            }
            run.steps.push((step.span, start_ns, run.duration_ns - start_ns));
        }
        Some(run)
    }

    fn channels(&self, _own: &mut dyn Iterator<Item = &LoweredRun>) -> Vec<(String, ChannelUnit)> {
        self.order.facts.channels().into_iter().map(|name| (name, ChannelUnit::Volt)).collect()
    }
}

/// Adds one pulse, its rest, and the resulting state.
fn fire(
    run: &mut LoweredRun,
    facts: &DimibotFacts,
    cell: LatticeCell,
    pulse: ModulePulse,
    step: usize,
) -> Option<LatticeCell> {
    let (start_ns, duration_ns) = (run.duration_ns, facts.pulse_duration_ns);
    let end_ns = start_ns.checked_add(duration_ns)?;
    for (side, mask, bits) in [(Side::Left, pulse.left, cell.x), (Side::Right, pulse.right, cell.y)] {
        for module in (0..facts.modules(side)).filter(|module| mask >> module & 1 == 1) {
            let switch = if bits >> module & 1 == 1 { Switch::Reset } else { Switch::Set };
            let volts = facts.pulse_voltage_v;
            let (from, to, step) = (volts, volts, step as u32);
            let channel = run.channel(&DimibotFacts::channel(side, module, switch));
            run.actuations.push(Actuation { channel, start_ns, duration_ns, from, to, swing: None, step });
        }
    }
    run.duration_ns = end_ns.checked_add(facts.rest_ns)?;
    let after = LatticeCell::new(cell.x ^ pulse.left, cell.y ^ pulse.right);
    run.states.push(TimedState { t_ns: end_ns, state: state(facts, after) });
    Some(after)
}

fn state(facts: &DimibotFacts, cell: LatticeCell) -> State {
    State::Dimibot(DimibotState { word: facts.word(cell), cell: cell.pair(), position_um: facts.place_um(cell) })
}
