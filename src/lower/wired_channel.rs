//! A channel of a schedule with the output that plays it.

use crate::device::instrument::{Drive, Instrument};
use crate::quantity::{Dimension, Quantity};
use crate::schedule::{Actuation, Channel, ChannelUnit, Schedule};

/// A channel with what plays it.
pub struct WiredChannel<'a> {
    pub schedule: &'a Schedule,
    pub channel: &'a Channel,
    /// Of the schedule's channels.
    pub index: usize,
    pub drive: &'a Drive,
    pub instrument: &'a Instrument,
    /// In order of time.
    pub actuations: Vec<&'a Actuation>,
}

pub fn volts(value: f64) -> Quantity {
    Quantity::new(value, Dimension::VOLTAGE)
}

pub fn seconds(ns: f64) -> Quantity {
    Quantity::new(ns / 1e9, Dimension::TIME)
}

impl WiredChannel<'_> {
    /// A value of the channel with its unit.
    pub fn shown(&self, value: f64) -> String {
        match self.channel.unit {
            ChannelUnit::Volt => volts(value).to_string(),
            ChannelUnit::Micrometre => Quantity::new(value / 1e6, Dimension::LENGTH).to_string(),
        }
    }
}
