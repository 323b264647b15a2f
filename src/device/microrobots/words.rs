//! The vocabulary of the STRING microrobots.

use super::MAX_LEVELS;
use crate::device::shape::ShapeForm;
use crate::device::words::words;
use crate::device::{
    Assay, Block, Count, DefaultFigure, Frames, Noun, Outcome, OutcomeUnit, Planner, Sort, Together, Verb, Vocabulary,
    VocabularyField, VocabularyPhrase, defaulted, expansions, not_negative, optional, outcome, planner, positive,
    required, verb,
};
use crate::quantity::Dimension;

words! {
    /// Objective.
    pub enum MicrorobotsObjective {
        Time = "time": "from the beginning of the task to the end of its last step",
        Switches = "switches": "control cycles",
        Failures = "failures": "share of simulated assemblies that fail with the errors of the device",
    }
}

impl MicrorobotsObjective {
    /// Unit of cost and bound; empty for counts and shares.
    pub fn unit(self) -> &'static str {
        match self {
            MicrorobotsObjective::Time => "s",
            MicrorobotsObjective::Switches | MicrorobotsObjective::Failures => "",
        }
    }

    /// The outcome that it minimises; `None` for an estimate, which no replay can derive.
    pub fn outcome(self) -> Option<MicrorobotsOutcome> {
        match self {
            MicrorobotsObjective::Time => Some(MicrorobotsOutcome::Time),
            MicrorobotsObjective::Switches => Some(MicrorobotsOutcome::Switches),
            MicrorobotsObjective::Failures => None,
        }
    }
}

words! {
    /// An outcome of a plan.
    pub enum MicrorobotsOutcome {
        Time = "time": "from the beginning of the task to the end of its last step",
        Switches = "switches": "control cycles",
        Strokes = "strokes": "strokes of the drive train",
    }
}

words! {
    /// Search method.
    pub enum MicrorobotsPlanner {
        OneWayDubins = "one_way_dubins": "shortest paths of turns to one side and straight lines, searched over the centres of the turns; for assemblies the paper's two stages, with a search over the order and the phase of the orbits",
    }
}

words! {
    /// Turning direction of a robot.
    pub enum Turning {
        Clockwise = "clockwise": "its heading decreases while its arm is down",
        Counterclockwise = "counterclockwise": "its heading increases while its arm is down",
    }
}

const ROBOTS: [VocabularyField; 8] = [
    required("robot", Sort::Name, "its name in scenes and tasks"),
    required("snap_down", positive(Dimension::VOLTAGE), "voltage at or above which the arm goes down"),
    required("release", positive(Dimension::VOLTAGE), "voltage at or below which the arm goes up"),
    required("turning_radius", positive(Dimension::LENGTH), "radius of its circle while the arm is down"),
    optional("speed", positive(Dimension::SPEED), "`step_size` times `drive_frequency`", "while the bed is driven"),
    optional("turns", Sort::Word(Turning::CHOICES), "clockwise", "the side to which it turns"),
    optional("length", positive(Dimension::LENGTH), "the device's", "length of its body, along its heading"),
    optional("width", positive(Dimension::LENGTH), "the device's", "width of its body, across its heading"),
];

const FIELDS: &[VocabularyField] = &[
    required("robots", Sort::Table(&ROBOTS), "one row for each robot"),
    required("margin", positive(Dimension::VOLTAGE), "uncertainty (plus or minus) of each transition voltage"),
    required("max_voltage", positive(Dimension::VOLTAGE), "greatest voltage of the source"),
    required("relax", positive(Dimension::VOLTAGE), "the level between the strokes of the drive train"),
    required("flex", positive(Dimension::VOLTAGE), "the level of the strokes of the drive train"),
    required("drive_frequency", positive(Dimension::FREQUENCY), "strokes of the drive train"),
    required("step_size", positive(Dimension::LENGTH), "distance that a robot moves in one stroke"),
    required("dwell", positive(Dimension::TIME), "duration of each level of a control cycle"),
    defaulted(
        "levels",
        Sort::Count { least: 1, most: MAX_LEVELS },
        DefaultFigure::count(8),
        "greatest number of levels in a control cycle",
    ),
    optional(
        "non_string",
        Sort::Flag,
        "false",
        "whether a table with nested gaps may be used, if every task can still be planned",
    ),
    required("length", positive(Dimension::LENGTH), "length of a robot's body, along its heading"),
    required("width", positive(Dimension::LENGTH), "width of a robot's body, across its heading"),
    required(
        "clearance",
        not_negative(Dimension::LENGTH),
        "least distance of a moving body from obstacles and other bodies",
    ),
    required(
        "orbit_clearance",
        not_negative(Dimension::LENGTH),
        "least distance of everything from the disc that an orbiting robot sweeps",
    ),
    required(
        "self_aligning_angle",
        positive(Dimension::ANGLE),
        "greatest angle between the axes of two robots that meet head on and still align themselves",
    ),
    required(
        "self_aligning_offset",
        positive(Dimension::LENGTH),
        "greatest distance between the axes of two robots that meet head on and still align themselves",
    ),
    required(
        "sticking_angle",
        positive(Dimension::ANGLE),
        "greatest angle from the normal of an edge at which a robot that meets a structure sticks to it",
    ),
    required("docking_tolerance", positive(Dimension::LENGTH), "greatest gap or overlap between docked bodies"),
    required("fine_length", positive(Dimension::LENGTH), "path length of the fine motion before a goal"),
    required("fine_cycle", positive(Dimension::LENGTH), "path length in which a fine motion runs each primitive once"),
    optional(
        "speed_error",
        not_negative(Dimension::NUMBER),
        "unknown",
        "bound on the error of a speed, as a share of the speed",
    ),
    optional(
        "turning_error",
        not_negative(Dimension::ANGLE_PER_LENGTH),
        "unknown",
        "bound on the error of a heading, per distance driven",
    ),
    optional("place_error", not_negative(Dimension::LENGTH), "unknown", "bound on the error of a measured place"),
    optional("heading_error", not_negative(Dimension::ANGLE), "unknown", "bound on the error of a measured heading"),
    optional("replan_interval", positive(Dimension::TIME), "unknown", "time from one measurement to the next"),
    optional(
        "watchdog",
        positive(Dimension::TIME),
        "five times `replan_interval`",
        "`tweeze control` stops if no measurement arrives for this long after the end of a command",
    ),
];

const SETTINGS: &[VocabularyField] = &[
    defaulted(
        "precision",
        positive(Dimension::LENGTH),
        DefaultFigure::new(0.5, "um"),
        "greatest distance from its goal at which a robot may end",
    ),
    defaulted(
        "heading_precision",
        positive(Dimension::ANGLE),
        DefaultFigure::new(0.5, "deg"),
        "greatest deviation of its heading from that of the goal",
    ),
    optional("guaranteed", Sort::Flag, "false", "whether a goal that cannot be guaranteed is an error"),
];

const TO_POSE: VocabularyPhrase = VocabularyPhrase { preposition: "to", sort: Sort::Pose, count: Count::Once };

words! {
    /// A step of a bed of robots.
    pub enum MicrorobotsVerb {
        Apply = "apply": "sets the arms of a control state, then drives for this time",
        Drive = "drive": "brings one robot to a pose, via others in the order written; the other robots move along",
        Assemble = "assemble": "brings robots together: the two that snap last at the same time, then the others one by one",
    }
}

const VERBS: &[Verb] = &[
    Verb {
        noun: Some("state"),
        object: Some(Sort::Control),
        phrases: &[VocabularyPhrase { preposition: "for", sort: positive(Dimension::TIME), count: Count::Once }],
        example: "apply state 2 for 3 s",
        ..verb(MicrorobotsVerb::Apply.choice())
    },
    Verb {
        object: Some(Sort::Object("robot")),
        phrases: &[TO_POSE, VocabularyPhrase { preposition: "via", sort: Sort::Pose, count: Count::AnyNumber }],
        example: "drive D3 to pose(1.8 mm, 1.5 mm, 90 deg)",
        ..verb(MicrorobotsVerb::Drive.choice())
    },
    Verb {
        block: Some(&Block { object: Sort::Object("robot"), phrases: &[TO_POSE] }),
        example: "assemble { D2 to pose(1.8 mm, 1.5 mm, 90 deg), D1 to pose(1.8 mm, 1.76 mm, 270 deg) }",
        ..verb(MicrorobotsVerb::Assemble.choice())
    },
];

const BUDGET: [VocabularyField; 1] =
    [expansions(200_000, "number of paths the search of one step may expand before it gives up")];

const PLANNERS: &[Planner] = &[planner(MicrorobotsPlanner::OneWayDubins.choice(), &BUDGET)];

const OUTCOMES: &[Outcome] = &[
    outcome(MicrorobotsOutcome::Time.choice(), OutcomeUnit::Nanosecond),
    outcome(MicrorobotsOutcome::Switches.choice(), OutcomeUnit::Count),
    outcome(MicrorobotsOutcome::Strokes.choice(), OutcomeUnit::Count),
];

words! {
    /// A noun of a bed's scene.
    pub enum BedNoun {
        Robot = "robot": "a robot of the device's table, at its start",
        Obstacle = "obstacle": "an obstacle that no robot may come near",
    }
}

/// The vocabulary of the kind.
pub const VOCABULARY: Vocabulary = Vocabulary {
    name: "microrobots",
    summary: "scratch-drive robots on one bed, all driven by the same voltage",
    library: ("std.microrobots", "microrobots.bed"),
    fields: FIELDS,
    nouns: &[
        Noun::of(BedNoun::Robot.choice(), &[]),
        Noun::of(
            BedNoun::Obstacle.choice(),
            &[ShapeForm::Disc, ShapeForm::Box, ShapeForm::Polygon, ShapeForm::Capsule],
        ),
    ],
    settings: SETTINGS,
    state: None,
    together: Together::No("one voltage drives all robots; goals at the same time are an assembly"),
    assay: Assay::No,
    frames: Frames::No,
    verbs: VERBS,
    conditions: &[],
    objectives: MicrorobotsObjective::CHOICES,
    planners: PLANNERS,
    outcomes: OUTCOMES,
    channels: "<device>.bed: the voltage of the whole bed",
};
