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
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::hash::Hash;

/// An electrode or a pad that is on from beat `from` until the start of beat `to`.
#[derive(Debug, Clone, Copy)]
pub(super) struct SwitchPulse<E> {
    pub switch: E,
    pub from: u64,
    pub to: u64,
}

/// The electrodes or pads that are on, beat by beat during a step of the task.
#[derive(Debug)]
pub(super) struct Switching<E> {
    /// Those that are still to come, from the last to the first.
    coming: Vec<SwitchPulse<E>>,
    /// Ends of those that have begun.
    ends: BinaryHeap<Reverse<(u64, E)>>,
    pub on: FxHashSet<E>,
}

impl<E: Copy + Ord + Hash> Switching<E> {
    /// The state before the first beat.
    pub fn new(mut coming: Vec<SwitchPulse<E>>) -> Switching<E> {
        coming.sort_by_key(|pulse| Reverse(pulse.from));
        Switching { coming, ends: BinaryHeap::new(), on: FxHashSet::default() }
    }

    /// Advances to a beat, which must not be earlier than the present one.
    pub fn advance(&mut self, beat: u64) {
        loop {
            let (next_end, next) = (self.ends.peek().map(|Reverse((at, _))| *at), self.coming.last());
            // At the beginning of a beat, off comes before on.
            if next_end.is_some_and(|at| at <= beat && next.is_none_or(|next| at <= next.from)) {
                if let Some(Reverse((_, switch))) = self.ends.pop() {
                    self.on.remove(&switch);
                }
            } else if let Some(pulse) = self.coming.pop_if(|pulse| pulse.from <= beat) {
                self.on.insert(pulse.switch);
                self.ends.push(Reverse((pulse.to, pulse.switch)));
            } else {
                break;
            }
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
