//! The electrodes, or the reservoir pads, that are on in each beat.
//!
//! Input: the beats from which and until which each is on. Output: the set of those that are on, beat by beat. Cost: n
//! log n for n actuations.

use crate::claims::electrode_array::ElectrodeArrayOrder;
use crate::device::electrode_array::ElectrodeCell;
use crate::schedule::Actuation;
use crate::verify::clock::JudgedRun;
use crate::verify::rule::{Rule, Violation};
use rustc_hash::{FxHashMap, FxHashSet};
use std::hash::Hash;

/// An electrode or a pad that is on from beat `from` until the start of beat `to`.
#[derive(Debug, Clone, Copy)]
pub(super) struct SwitchPulse<E> {
    pub switch: E,
    pub from: u64,
    pub to: u64,
}

/// A change at the beginning of a beat; off is ordered before on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Change {
    Off,
    On,
}

/// The electrodes or pads that are on, beat by beat during a step of the task.
#[derive(Debug)]
pub(super) struct Switching<E> {
    /// By step of the board, from the last to the first.
    changes: Vec<(u64, Change, E)>,
    pub on: FxHashSet<E>,
}

impl<E: Copy + Ord + Hash> Switching<E> {
    /// The state before the first beat.
    pub fn new(pulses: &[SwitchPulse<E>]) -> Switching<E> {
        let both =
            |pulse: &SwitchPulse<E>| [(pulse.from, Change::On, pulse.switch), (pulse.to, Change::Off, pulse.switch)];
        let mut changes: Vec<_> = pulses.iter().flat_map(both).collect();
        changes.sort_unstable_by(|one, other| other.cmp(one));
        Switching { changes, on: FxHashSet::default() }
    }

    /// Advances to a beat, which must not be earlier than the present one.
    pub fn advance(&mut self, beat: u64) {
        while let Some((_, change, switch)) = self.changes.pop_if(|(at, ..)| *at <= beat) {
            match change {
                Change::On => self.on.insert(switch),
                Change::Off => self.on.remove(&switch),
            };
        }
    }
}

/// Electrodes or pads of each step of a run, with their actuations.
pub(super) type StepPulses<'a, E> = Vec<Vec<(E, &'a Actuation)>>;

/// The electrode or pad that a channel switches.
#[derive(Clone, Copy)]
enum JudgedSwitch {
    Electrode(ElectrodeCell),
    Pad(u32),
}

/// The actuations of each step of a run: those on electrodes, and those on pads.
pub(super) fn pulses<'a>(
    run: &JudgedRun<'a>,
    order: &ElectrodeArrayOrder,
) -> Result<(StepPulses<'a, ElectrodeCell>, StepPulses<'a, u32>), Violation> {
    let mut switches: FxHashMap<u32, JudgedSwitch> = FxHashMap::default();
    let (mut electrodes, mut pads) = (vec![Vec::new(); run.steps.len()], vec![Vec::new(); run.steps.len()]);
    for actuation in &run.actuations {
        let switch = match switches.get(&actuation.channel) {
            Some(switch) => *switch,
            None => {
                let name = &run.schedule.channels[actuation.channel as usize].name;
                let own = name.strip_prefix(&run.job.device).and_then(|name| name.strip_prefix('.'));
                let electrode = |name: &str| order.facts.electrode(name).map(JudgedSwitch::Electrode);
                let pad = |name: &str| order.facts.pad(name).map(JudgedSwitch::Pad);
                let switch = own.and_then(|name| electrode(name).or_else(|| pad(name))).ok_or_else(|| {
                    let title = format!("the device `{}` has no channel `{name}`", run.job.device);
                    Violation::new(Rule::Channel, actuation.start_ns, title)
                })?;
                switches.insert(actuation.channel, switch);
                switch
            }
        };
        if let Ok(nth) = run.steps.binary_search(&(actuation.step as usize)) {
            match switch {
                JudgedSwitch::Electrode(cell) => electrodes[nth].push((cell, *actuation)),
                JudgedSwitch::Pad(pad) => pads[nth].push((pad, *actuation)),
            }
        }
    }
    Ok((electrodes, pads))
}
