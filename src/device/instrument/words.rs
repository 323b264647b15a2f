//! The vocabulary of instruments and of wires.

use super::{AXIS_LETTERS, Direction, Level, MAX_OUTPUTS, Protocol, StageProtocol, Start};
use crate::device::{DefaultFigure, Need, Range, Sort, VocabularyField, defaulted, optional, positive, required};
use crate::quantity::Dimension;

/// Most points in a generator's memory.
const MAX_POINTS: u32 = 1 << 30;

/// Most bits of a sample: codes are transferred as 16 bits.
const MAX_BITS: u32 = 16;

/// Most lines of a port: a port is played as 32-bit words.
const MAX_LINES: u32 = 32;

const PEAK: VocabularyField = required(
    "peak",
    positive(Dimension::VOLTAGE),
    "greatest voltage of an output on either side of zero, into an open circuit",
);

const START: VocabularyField = optional(
    "start",
    Sort::Word(Start::CHOICES),
    "sender",
    "what starts it; the sender starts one of several instruments",
);

const fn count(name: &'static str, least: u32, most: u32, doc: &'static str) -> VocabularyField {
    VocabularyField { name, sort: Sort::Count { least, most }, need: Need::Required, doc }
}

pub const WAVEFORM_GENERATOR: &[VocabularyField] = &[
    count("outputs", 1, MAX_OUTPUTS, "outputs that play at the same time, `ch1`, `ch2`, …"),
    PEAK,
    count("bits", 2, MAX_BITS, "bits of a sample"),
    required("rate", positive(Dimension::FREQUENCY), "greatest number of samples per second without a filter"),
    count("least_points", 1, MAX_POINTS, "least number of points of a waveform"),
    count("most_points", 1, MAX_POINTS, "greatest number of points in the memory of an output"),
    count("most_steps", 3, MAX_POINTS, "greatest number of steps of a sequence"),
    START,
];

pub const DATA_ACQUISITION: &[VocabularyField] = &[
    count("ports", 0, MAX_OUTPUTS, "digital ports, `port0`, `port1`, …"),
    count("lines", 0, MAX_LINES, "lines of each port, `port0.line0`, …"),
    optional(
        "digital_rate",
        positive(Dimension::FREQUENCY),
        "without a sample clock",
        "greatest number of samples per second of the digital lines",
    ),
    defaulted(
        "analog_outputs",
        Sort::Count { least: 0, most: MAX_OUTPUTS },
        DefaultFigure::count(0),
        "voltage outputs, `ao0`, `ao1`, …",
    ),
    optional("peak", positive(Dimension::VOLTAGE), "required with analog outputs", PEAK.doc),
    VocabularyField {
        name: "bits",
        sort: Sort::Count { least: 2, most: MAX_BITS },
        need: Need::Optional("required with analog outputs"),
        doc: "bits of an analog sample",
    },
    optional(
        "rate",
        positive(Dimension::FREQUENCY),
        "required with analog outputs",
        "greatest number of samples per second of the analog outputs",
    ),
    START,
];

/// The fields for the heaters of a driver, by their numbers from 1; its outputs have the same names.
pub const HEATERS: [&str; 3] = ["heater1", "heater2", "heater3"];

const fn heater(name: &'static str) -> VocabularyField {
    let doc = "temperature of this heater of an OpenDrop while its output of the same name is on, in whole degC";
    optional(name, positive(Dimension::TEMPERATURE), "no such output", doc)
}

pub const ELECTRODE_DRIVER: &[VocabularyField] = &[
    required("protocol", Sort::Word(Protocol::CHOICES), "protocol of the instrument"),
    count(
        "channels",
        1,
        MAX_OUTPUTS,
        "channels, `c0`, `c1`, …, at most as many as the protocol allows; each drives an electrode",
    ),
    defaulted(
        "least_potential",
        positive(Dimension::VOLTAGE),
        DefaultFigure::new(0.0, "V"),
        "least voltage to which it can be set",
    ),
    required("most_potential", positive(Dimension::VOLTAGE), "greatest voltage to which it can be set"),
    required("least_frame", positive(Dimension::TIME), "shortest time from one frame to the next"),
    optional(
        "frequency",
        positive(Dimension::FREQUENCY),
        "as set on the driver",
        "frequency of its voltage, to which a DropBot is set",
    ),
    heater(HEATERS[0]),
    heater(HEATERS[1]),
    heater(HEATERS[2]),
    START,
];

pub const STAGE_CONTROLLER: &[VocabularyField] = &[
    required("protocol", Sort::Word(StageProtocol::CHOICES), "protocol of the instrument"),
    count("axes", 1, MAX_OUTPUTS, "stages that it moves at the same time, `axis1`, `axis2`, …"),
    required("rate", positive(Dimension::FREQUENCY), "positions per second, between which it moves on straight lines"),
    VocabularyField {
        name: "most_points",
        sort: Sort::Count { least: 2, most: MAX_POINTS },
        need: Need::Optional("no table: positions are sent while they are played"),
        doc: "greatest number of points in the table of an axis",
    },
    START,
];

pub const MACHINE_CONTROLLER: &[VocabularyField] = &[
    count("axes", 1, AXIS_LETTERS.len() as u32, "its axes, the first of `X`, `Y`, `Z`, `U`, `V`, `W`, `A`, `B`, `C`"),
    required(
        "rate",
        positive(Dimension::FREQUENCY),
        "servo cycles per second, between which axes move on straight lines",
    ),
];

const HIGH: VocabularyField = defaulted(
    "voltage",
    positive(Dimension::VOLTAGE),
    // TTL, and the level of most digital lines.
    DefaultFigure::new(5.0, "V"),
    "voltage of the high level; low is 0 V",
);

const RESTS: VocabularyField =
    optional("rest", Sort::Word(Level::CHOICES), "low", "level before and after a schedule, and when it is aborted");

const fn voltage(range: Range) -> Sort {
    Sort::Quantity { dimension: Dimension::VOLTAGE, range }
}

pub const TRIGGER: &[VocabularyField] =
    &[required("duration", positive(Dimension::TIME), "length of a pulse, which begins at its step"), HIGH, RESTS];
pub const DIGITAL: &[VocabularyField] = &[HIGH, RESTS];
pub const LEVEL: &[VocabularyField] = &[
    defaulted("from", voltage(Range::Any), DefaultFigure::new(0.0, "V"), "voltage at 0 %"),
    required("to", voltage(Range::Any), "voltage at 100 %"),
    defaulted(
        "rest",
        Sort::Quantity { dimension: Dimension::NUMBER, range: Range::Share },
        DefaultFigure::new(0.0, "%"),
        RESTS.doc,
    ),
];

const GAIN: VocabularyField = defaulted(
    "gain",
    Sort::Quantity { dimension: Dimension::NUMBER, range: Range::NotZero },
    DefaultFigure::new(1.0, ""),
    "gain of the amplifier: voltage of the channel divided by that of the output",
);
const LIMIT: VocabularyField = optional(
    "limit",
    positive(Dimension::VOLTAGE),
    "not checked",
    "greatest voltage of the amplifier, on either side of zero",
);
const SLEW: VocabularyField =
    optional("slew", positive(Dimension::SLEW_RATE), "not checked", "fastest change of the amplifier's voltage");
const SCALE: VocabularyField = required(
    "scale",
    Sort::Quantity { dimension: Dimension::VOLTAGE_PER_LENGTH, range: Range::NotZero },
    "voltage of the stage's driver per length",
);
const ZERO: VocabularyField = defaulted(
    "zero",
    Sort::Quantity { dimension: Dimension::VOLTAGE, range: Range::Any },
    DefaultFigure::new(0.0, "V"),
    "voltage of the stage's driver at position 0",
);
const SWITCHES: VocabularyField = required(
    "switches",
    Sort::Quantity { dimension: Dimension::VOLTAGE, range: Range::NotZero },
    "voltage that the driver on the line switches to the channel",
);

const ORIGIN: VocabularyField =
    defaulted("origin", length(Range::Any), DefaultFigure::new(0.0, "um"), "where the stage itself is at position 0");
const TRAVEL_FROM: VocabularyField =
    defaulted("travel_from", length(Range::Any), DefaultFigure::new(0.0, "um"), "where the stage's own travel begins");
const TRAVEL_TO: VocabularyField = required("travel_to", length(Range::Any), "where the stage's own travel ends");
const DIRECTION: VocabularyField =
    optional("direction", Sort::Word(Direction::CHOICES), "forward", "direction in which the stage counts");
const SPEED: VocabularyField =
    optional("speed", positive(Dimension::SPEED), "not checked", "greatest speed that the stage can follow");
const ACCELERATION: VocabularyField = optional(
    "acceleration",
    positive(Dimension::ACCELERATION),
    "not checked",
    "greatest acceleration of the stage, which rounds the corners of its path",
);

const fn length(range: Range) -> Sort {
    Sort::Quantity { dimension: Dimension::LENGTH, range }
}

pub const AMPLIFIER: &[VocabularyField] = &[GAIN, LIMIT, SLEW];
pub const STAGE_DRIVER: &[VocabularyField] = &[SCALE, ZERO, SPEED, ACCELERATION];
pub const SWITCH: &[VocabularyField] = &[SWITCHES];
pub const AXIS: &[VocabularyField] = &[ORIGIN, TRAVEL_FROM, TRAVEL_TO, DIRECTION, SPEED, ACCELERATION];

/// The fields of all wires, each once.
pub const ANY_WIRE: &[VocabularyField] =
    &[GAIN, LIMIT, SLEW, SCALE, ZERO, SWITCHES, ORIGIN, TRAVEL_FROM, TRAVEL_TO, DIRECTION, SPEED, ACCELERATION];
