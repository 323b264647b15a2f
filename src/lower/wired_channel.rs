//! A channel of a schedule with the output that plays it.

use crate::device::instrument::{Drive, Instrument};
use crate::diagnostic::{Code, Diagnostic};
use crate::quantity::Quantity;
use crate::schedule::levels::away_from_rest;
use crate::schedule::{Actuation, Channel, ChannelUnit, Schedule};

/// A channel with its wiring.
pub struct WiredChannel<'a> {
    pub schedule: &'a Schedule,
    pub channel: &'a Channel,
    /// Index into the schedule's channels.
    pub index: usize,
    pub drive: &'a Drive,
    pub instrument: &'a Instrument,
    /// In order of time.
    pub actuations: Vec<&'a Actuation>,
}

impl WiredChannel<'_> {
    /// The actuations away from rest, with equal levels joined: its value changes at their ends.
    pub fn away_from_rest(&self) -> Vec<Actuation> {
        away_from_rest(self.actuations.iter().copied(), self.channel.rest_v)
    }

    /// A diagnostic at the wire, for something that a step asks of it and that it cannot do.
    pub fn finding(&self, code: Code, title: String, at_wire: String, step: u32) -> Diagnostic {
        let step = &self.schedule.steps[step as usize];
        let begin = Quantity::time_ns(step.start_ns);
        Diagnostic::new(code, title).label(self.drive.span, at_wire).label_elsewhere(
            step.span,
            self.drive.span,
            format!("required by this step, from {begin} on"),
        )
    }

    /// A value of the channel with its unit.
    pub fn shown(&self, value: f64) -> String {
        match self.channel.unit {
            ChannelUnit::Volt => Quantity::voltage(value).to_string(),
            ChannelUnit::Micrometre => Quantity::length_um(value).to_string(),
        }
    }
}
