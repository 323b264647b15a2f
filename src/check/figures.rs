//! Figures (numbers and words) of a device, a task or a shape, read from its accepted fields.
//!
//! Sorts and ranges have been checked against the vocabulary. A figure that was not given is the vocabulary's default,
//! or `None` where it has none; no number stands for "missing".

use super::clock_ns;
use super::value::{Accepted, Value, whole};
use crate::diagnostic::Sink;
use crate::quantity::Quantity;

/// Access to accepted fields by the sort of figure that they hold.
pub trait Figures {
    /// A quantity as it was written, or its default.
    fn quantity(&self, name: &str) -> Option<Quantity>;

    /// A word, as `safe`.
    fn word(&self, name: &str) -> Option<&str>;

    /// Whether a flag is given and true.
    fn is_set(&self, name: &str) -> bool;

    /// A time on the clock, in nanoseconds; out of the clock's range it is `None` after an error.
    fn clock_ns(&self, name: &str, sink: &mut Sink) -> Option<u64>;

    /// A length in micrometres.
    fn length_um(&self, name: &str) -> Option<f64> {
        self.quantity(name).map(|length| length.in_unit("um"))
    }

    /// A quantity in SI units, or a plain number.
    fn si(&self, name: &str) -> Option<f64> {
        self.quantity(name).map(|quantity| quantity.si)
    }

    /// A whole number of 0 or above.
    fn count(&self, name: &str) -> Option<u32> {
        self.quantity(name).and_then(whole).and_then(|number| u32::try_from(number).ok())
    }

    /// A quantity for a message, as it was written; empty where it was not given.
    fn text(&self, name: &str) -> String {
        self.quantity(name).map_or(String::new(), |quantity| quantity.to_string())
    }
}

impl Figures for Accepted {
    fn quantity(&self, name: &str) -> Option<Quantity> {
        match self.get(name).map(|field| &field.value) {
            Some(Value::Quantity(quantity)) => Some(*quantity),
            Some(_) => None,
            None => self.default_of(name),
        }
    }

    fn word(&self, name: &str) -> Option<&str> {
        match self.get(name).map(|field| &field.value) {
            Some(Value::Text(word)) => Some(word),
            _ => None,
        }
    }

    fn is_set(&self, name: &str) -> bool {
        matches!(self.get(name).map(|field| &field.value), Some(Value::Bool(true)))
    }

    fn clock_ns(&self, name: &str, sink: &mut Sink) -> Option<u64> {
        clock_ns(self.quantity(name)?, self.get(name)?.span, &format!("`{name}`"), sink)
    }
}
