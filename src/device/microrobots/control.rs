//! Vocabulary of a controlled run: the controller's phase, and the reason why it gave up a task.

use serde::{Deserialize, Serialize};

/// What the controller is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ControlPhase {
    /// Legs are executed as planned.
    Legs,
    /// The bed is without voltage.
    Wait,
    /// A robot is driven to a pose.
    Approach,
    /// The first of two robots is driven until its timing matches the second, which orbits.
    Timing,
    /// The first of two robots runs straight, the second is driven to its approach.
    Meeting,
    /// The last stretch before a goal.
    Fine,
    /// A robot was pushed against its structure; the next measurement shows whether it docked.
    Contact,
    /// Nothing is left to be done.
    Over,
}

/// Reason for giving up a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StopReason {
    /// After the greatest number of rounds the robot had still not reached the start of the fine motion, or its pose.
    LeftCylinder,
    /// The goal was not within reach of the fine motion.
    MissedCone,
    /// The robot is at its structure, but farther from its place than the docking tolerance.
    Misplaced,
    /// The task exceeded its time limit.
    TimeLimit,
    /// A robot was not seen for too many measurements in a row.
    Unseen,
    /// A robot was measured, for too many measurements in a row, where it cannot be.
    Doubtful,
    /// A robot was measured, for too many measurements in a row, where its commands cannot have brought it.
    Astray,
    /// A robot was measured twice in a row at a position that it cannot have reached.
    Moved,
    /// The next motion would bring a robot into an obstacle or into another robot.
    Blocked,
    /// No measurement came in time.
    Silence,
    /// The measurements ended.
    Closed,
    /// A measurement's time is before that of the previous one.
    Clock,
    /// Too many lines could not be parsed.
    Garbled,
    /// A signal asked the controller to end.
    Interrupted,
    /// A command could not be delivered in time.
    Unread,
    /// The recording could not be written.
    Unrecorded,
}
