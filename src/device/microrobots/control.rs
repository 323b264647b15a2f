//! Words of a controlled run: what a controller is doing, and why it gave a task up.

use serde::{Deserialize, Serialize};

/// What a controller is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ControlPhase {
    /// Legs are carried out as the plan has them.
    Legs,
    /// The bed is without voltage.
    Wait,
    /// A robot is driven to a pose.
    Approach,
    /// The first of two robots is driven until it is in time with the second, which orbits.
    Timing,
    /// The first of two robots runs straight, the second is driven to its approach.
    Meeting,
    /// The last stretch before a goal.
    Fine,
    /// A robot was pushed against its structure, and the next measurement tells whether it docked.
    Contact,
    /// Nothing is left to do.
    Over,
}

/// Why a task was given up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StopReason {
    /// After the greatest number of rounds it had still not reached the start of the fine motion, or its pose.
    LeftCylinder,
    /// The goal was not within the reach of the fine motion.
    MissedCone,
    /// It is at its structure, and farther from its place than the docking tolerance.
    Misplaced,
    /// It took too long.
    TimeLimit,
    /// A robot was not seen too many times in a row.
    Unseen,
    /// A robot was measured too many times in a row where it cannot have come to.
    Doubtful,
    /// A robot was measured too many times in a row where its commands cannot have brought it.
    Astray,
    /// A robot was measured twice in a row at a place to which it cannot have come.
    Moved,
    /// What would have to be driven next brings a robot into an obstacle or into another robot.
    Blocked,
    /// No measurement came in time.
    Silence,
    /// The measurements ended.
    Closed,
    /// The time of a measurement lies before that of the one before.
    Clock,
    /// Too many lines could not be understood.
    Garbled,
    /// A signal asked the controller to end.
    Interrupted,
    /// A command could not be handed over in time.
    Unread,
    /// The recording could not be written.
    Unrecorded,
}
