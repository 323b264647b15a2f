//! Machine controllers: stages as the axes of a machine that runs G-code.

use serde::{Deserialize, Serialize};

/// The letters of a machine's axes, three for each finger: LinuxCNC's nine, in the order of precedence for a line's
/// feed.
pub const AXIS_LETTERS: [char; 9] = ['X', 'Y', 'Z', 'U', 'V', 'W', 'A', 'B', 'C'];

/// A controller that runs G-code.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MachineControllerFacts {
    /// Number of axes that it moves: the first of [`AXIS_LETTERS`].
    pub axes: u32,
    /// Servo cycles per second.
    pub rate_hz: f64,
}

impl MachineControllerFacts {
    /// The letters of its axes.
    pub fn letters(&self) -> impl Iterator<Item = char> {
        AXIS_LETTERS.into_iter().take(self.axes as usize)
    }
}
