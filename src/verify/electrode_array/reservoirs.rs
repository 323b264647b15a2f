//! Reservoir pads: on in the frames that dispense a droplet, and at no other time.
//!
//! Input: the pads that are on, beat by beat, and the droplets that are due. A droplet is being dispensed from the
//! beat in which the pads of its reservoir's first frame are on until its last frame is over. All that time it counts
//! as a droplet on the outlet's electrode, since it is unknown from which frame on liquid is there. Output: the outlet
//! electrodes that must be off, and the first pad or outlet that differs from the frames.

use super::JudgedBoard;
use super::switching::{SwitchPulse, Switching};
use crate::device::electrode_array::{DispenseFrame, DispenseSequence, ElectrodeCell, ReservoirPads};
use crate::schedule::Actuation;
use crate::verify::rule::{Rule, Violation, ms};
use rustc_hash::FxHashSet;
use std::collections::BTreeSet;

/// A droplet that is being dispensed.
struct Dispensing<'o> {
    part: usize,
    sequence: &'o DispenseSequence,
    since: u64,
}

/// A difference between the pads and outlets that are on and the frames.
pub(super) enum PadFault {
    /// A pad is on that no frame in progress needs.
    Needless(u32),
    /// A pad is off in a frame that has it on; with the part, and the number of the frame from 1.
    Missing { pad: u32, part: usize, frame: u64 },
    /// An outlet's electrode is on in a frame that has it off.
    Outlet { outlet: ElectrodeCell, part: usize, frame: u64 },
}

/// The reservoirs of a board during an assay.
pub(super) struct JudgedReservoirs<'o> {
    pads: &'o ReservoirPads,
    switching: Switching<u32>,
    beat_ns: u64,
    dispensing: Vec<Dispensing<'o>>,
}

impl<'o> JudgedReservoirs<'o> {
    /// The reservoirs before the first beat.
    pub fn new(pads: &'o ReservoirPads, pulses: Vec<SwitchPulse<u32>>, beat_ns: u64) -> JudgedReservoirs<'o> {
        JudgedReservoirs { pads, switching: Switching::new(pulses), beat_ns, dispensing: Vec::new() }
    }

    /// Advances to a beat and drops the droplets that are finished by then.
    pub fn advance(&mut self, beat: u64) {
        self.switching.advance(beat);
        let (pads, beat_ns) = (self.pads, self.beat_ns);
        let lasts = |dispensing: &Dispensing| pads.frame_ns.saturating_mul(dispensing.sequence.frames.len() as u64);
        self.dispensing.retain(|dispensing| (beat - dispensing.since) * beat_ns < lasts(dispensing));
    }

    /// Whether the pads of the first frame at an outlet are on; `None` for an outlet without pads.
    pub fn begins_at(&self, outlet: ElectrodeCell) -> Option<bool> {
        let first = self.pads.at(outlet)?.frames.first()?;
        Some(first.pads.iter().all(|pad| self.switching.on.contains(pad)))
    }

    /// Starts the dispensing of a part at a beat.
    pub fn begin(&mut self, part: usize, outlet: ElectrodeCell, beat: u64) {
        let sequence = self.pads.at(outlet);
        self.dispensing.extend(sequence.map(|sequence| Dispensing { part, sequence, since: beat }));
    }

    /// The frame of a droplet in a beat, with its number from 1.
    fn frame(&self, dispensing: &Dispensing<'o>, beat: u64) -> Option<(u64, &'o DispenseFrame)> {
        let passed = (beat - dispensing.since) * self.beat_ns / self.pads.frame_ns;
        Some((passed + 1, dispensing.sequence.frames.get(usize::try_from(passed).ok()?)?))
    }

    fn frames(&self, beat: u64) -> impl Iterator<Item = (&Dispensing<'o>, u64, &'o DispenseFrame)> {
        self.dispensing.iter().filter_map(move |dispensing| {
            let (number, frame) = self.frame(dispensing, beat)?;
            Some((dispensing, number, frame))
        })
    }

    /// The parts whose electrode is off in a beat, as their frame demands.
    pub fn released_at_outlet(&self, beat: u64) -> Vec<usize> {
        self.frames(beat).filter(|(_, _, frame)| !frame.outlet).map(|(dispensing, ..)| dispensing.part).collect()
    }

    /// The first fault of a beat, given the electrodes that are on in it.
    pub fn fault(&self, beat: u64, on: &FxHashSet<ElectrodeCell>) -> Option<PadFault> {
        let mut needed = BTreeSet::new();
        for (Dispensing { part, sequence, .. }, frame, due) in self.frames(beat) {
            let (part, outlet) = (*part, sequence.outlet);
            if let Some(pad) = due.pads.iter().find(|pad| !self.switching.on.contains(pad)) {
                return Some(PadFault::Missing { pad: *pad, part, frame });
            }
            if !due.outlet && on.contains(&outlet) {
                return Some(PadFault::Outlet { outlet, part, frame });
            }
            needed.extend(due.pads.iter().copied());
        }
        let needless = self.switching.on.iter().filter(|pad| !needed.contains(*pad)).min();
        needless.map(|pad| PadFault::Needless(*pad))
    }
}

impl<'r> JudgedBoard<'r, '_> {
    /// The reservoirs of a step of an assay; `None` for a board whose reservoirs have no pads.
    pub(super) fn reservoirs(&self, nth: usize) -> Result<Option<JudgedReservoirs<'r>>, Violation> {
        let Some(pads) = &self.order.facts.reservoirs else { return Ok(None) };
        let beat_ns = self.order.facts.step_ns;
        let pulse = |(pad, part): &(u32, &Actuation)| self.in_beats(nth, *pad, part, beat_ns, || format!("pad {pad}"));
        let pulses: Result<Vec<SwitchPulse<u32>>, Violation> = self.pads[nth].iter().map(pulse).collect();
        Ok(Some(JudgedReservoirs::new(pads, pulses?, beat_ns)))
    }

    /// Outside of assays no pad is on.
    pub(super) fn pads_rest(&self, nth: usize) -> Result<(), Violation> {
        self.run.tally.count_checks(Rule::Reservoir, self.pads[nth].len());
        match self.pads[nth].first() {
            Some((pad, part)) => Err(self.pad_fault(nth, part.start_ns, &PadFault::Needless(*pad))),
            None => Ok(()),
        }
    }

    /// The parts whose electrode is off in a beat, as their reservoir demands; or the violation if a pad or an outlet
    /// differs from the frames.
    pub(super) fn released_at_outlet(
        &self,
        nth: usize,
        at_ns: u64,
        beat: u64,
        reservoirs: Option<&JudgedReservoirs>,
        on: &FxHashSet<ElectrodeCell>,
    ) -> Result<Vec<usize>, Violation> {
        let Some(reservoirs) = reservoirs else { return Ok(Vec::new()) };
        self.run.tally.count_checks(Rule::Reservoir, 1);
        match reservoirs.fault(beat, on) {
            Some(fault) => Err(self.pad_fault(nth, at_ns, &fault)),
            None => Ok(reservoirs.released_at_outlet(beat)),
        }
    }

    fn pad_fault(&self, nth: usize, at_ns: u64, fault: &PadFault) -> Violation {
        let (at, name) = (ms(at_ns), |part: usize| self.order.parts[part].name.as_str());
        let title = match fault {
            PadFault::Needless(pad) => {
                format!("pad {pad} is on at {at}, but no reservoir dispenses a droplet with it then")
            }
            PadFault::Missing { pad, part, frame } => {
                format!(
                    "pad {pad} is off at {at}, but must be on in frame {frame} of the dispensing of `{}`",
                    name(*part)
                )
            }
            PadFault::Outlet { outlet, part, frame } => {
                format!(
                    "electrode {outlet} is on at {at}, but must be off in frame {frame} of the dispensing of `{}`",
                    name(*part)
                )
            }
        };
        self.run.violation(Rule::Reservoir, nth, at_ns, title)
    }
}
