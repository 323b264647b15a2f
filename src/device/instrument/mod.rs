//! Instruments: the hardware behind a channel, from the computer to the actuator.
//!
//! A program declares the instruments of its bench, each of one of the families here, and wires channels to their
//! outputs. As with device kinds, the words are tables: the checker reads them and `tweeze devices` prints them.
//! Facts only; `check` reads them from a program, `lower` checks a schedule against them, `emit` writes the files
//! that the instruments play.

mod auxiliary;
mod machine;
mod stages;
mod words;

pub(crate) use auxiliary::is_zero;
pub use auxiliary::{AuxiliaryOutput, AuxiliarySort, Awaited, HoldTerms};
pub use machine::{AXIS_LETTERS, MachineControllerFacts};
pub use stages::{Direction, StageControllerFacts, StageLimits, StageProtocol, corner_cut_um};
pub use words::{ANY_WIRE, HEATERS};

use crate::device::{VocabularyField, words::words};
use crate::quantity::{CELSIUS, Quantity};
use crate::source::Span;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::RangeInclusive;

/// Most outputs of one instrument.
pub const MAX_OUTPUTS: u32 = 4096;

/// Temperatures to which MicroDrop 1.9 sets the heaters of an OpenDrop, in degrees Celsius; a frame has one byte for
/// each heater.
pub const DRIVER_HEATER_DEGC: RangeInclusive<u32> = 20..=120;

/// Rounding error that is accepted in a temperature written as whole degrees, in degrees.
const ROUNDING_DEGC: f64 = 1e-6;

/// Heater setting of an OpenDrop for a temperature, in degrees Celsius; `None` if its frames cannot express it.
pub fn heater_setting(temperature: Quantity) -> Option<u32> {
    let degrees = temperature.in_unit(CELSIUS);
    DRIVER_HEATER_DEGC.into_iter().find(|whole| (degrees - f64::from(*whole)).abs() < ROUNDING_DEGC)
}

words! {
    /// The families of instruments, in the order of the handbook.
    pub enum Family {
        WaveformGenerator = "waveform_generator": "an arbitrary-waveform generator of the Keysight 33500 and 33600 series, or one that accepts their commands",
        DataAcquisition = "data_acquisition": "a card with digital lines and analog outputs on a sample clock, played by NI-DAQmx",
        ElectrodeDriver = "electrode_driver": "the driver of a board of electrodes, which plays frames of those that are on: OpenDrop, PurpleDrop, DropBot",
        StageController = "stage_controller": "a controller that moves stages along a table of positions: from PI with GCS commands, from SmarAct with the streams of an MCS2",
        MachineController = "machine_controller": "a controller whose stages are the axes of a machine that runs G-code: LinuxCNC",
    }
}

impl Family {
    /// A published instrument to start from: its name, and the module that it is in.
    pub fn library(self) -> (&'static str, &'static str) {
        let name = match self {
            Family::WaveformGenerator => "instruments.keysight_33500b",
            Family::DataAcquisition => "instruments.ni_usb_6343",
            Family::ElectrodeDriver => "instruments.opendrop_v4",
            Family::StageController => "instruments.pi_e727",
            Family::MachineController => "instruments.linuxcnc",
        };
        ("std.instruments", name)
    }

    /// The fields of an instrument.
    pub fn fields(self) -> &'static [VocabularyField] {
        match self {
            Family::WaveformGenerator => words::WAVEFORM_GENERATOR,
            Family::DataAcquisition => words::DATA_ACQUISITION,
            Family::ElectrodeDriver => words::ELECTRODE_DRIVER,
            Family::StageController => words::STAGE_CONTROLLER,
            Family::MachineController => words::MACHINE_CONTROLLER,
        }
    }

    /// The names of its outputs, and their signals.
    pub fn outputs(self) -> &'static str {
        match self {
            Family::WaveformGenerator => "`ch1`, `ch2`, …: one voltage each",
            Family::DataAcquisition => "`port0.line0`, …: one digital line each; `ao0`, …: one voltage each",
            Family::ElectrodeDriver => {
                "`c0`, `c1`, …: one electrode each; `electrodes -> NAME` wires all those that have a number in the `channels` of a board. An OpenDrop has `magnet1` and `magnet2`, and `heater1` to `heater3` where a temperature is given, for outputs of the bench"
            }
            Family::StageController => "`axis1`, `axis2`, …: one stage each",
            Family::MachineController => "`X`, `Y`, `Z`, `U`, `V`, `W`, `A`, `B`, `C`: one stage each",
        }
    }

    /// The links that its outputs may drive, with the fields of such a wire.
    pub fn links(self) -> &'static [(LinkSort, &'static str)] {
        match self {
            Family::WaveformGenerator => &[AMPLIFIED, PLACED],
            Family::DataAcquisition => &[SWITCHED, AMPLIFIED, PLACED],
            Family::ElectrodeDriver => &[SWITCHED],
            Family::StageController | Family::MachineController => &[MOVED],
        }
    }

    /// The file format that plays it.
    pub fn format(self) -> &'static str {
        match self {
            Family::WaveformGenerator => "scpi",
            Family::DataAcquisition => "nidaqmx",
            Family::ElectrodeDriver => "frames",
            Family::StageController => "stages",
            Family::MachineController => "gcode",
        }
    }
}

/// A declared instrument.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Instrument {
    /// The base that the program gives it: `instruments.keysight_33500b`.
    pub model: String,
    pub facts: InstrumentFacts,
}

/// The facts of an instrument in its family's own type.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InstrumentFacts {
    WaveformGenerator(WaveformGeneratorFacts),
    DataAcquisition(DataAcquisitionFacts),
    ElectrodeDriver(ElectrodeDriverFacts),
    StageController(StageControllerFacts),
    MachineController(MachineControllerFacts),
}

words! {
    /// Level of a two-level output or input.
    pub enum Level {
        Low = "low": "at 0 V",
        High = "high": "at the voltage of the output",
    }
}

words! {
    /// Start signal of an instrument.
    pub enum Start {
        Sender = "sender": "the program that sends its file",
        Trigger = "trigger": "a pulse at its trigger input, from the instrument that the sender starts, or from your own source",
    }
}

words! {
    /// Protocol of an electrode driver.
    pub enum Protocol {
        Opendrop = "opendrop": "OpenDrop 4: a frame of 32 bytes over USB, a bit for each of 128 channels",
        Purpledrop = "purpledrop": "PurpleDrop: JSON-RPC calls to its server, with the pins that are on",
        Dropbot = "dropbot": "DropBot 3: its Python package `dropbot`, with a state for each of 120 channels",
    }
}

/// An arbitrary-waveform generator.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WaveformGeneratorFacts {
    /// At most [`MAX_OUTPUTS`].
    pub outputs: u32,
    pub voltage: VoltageOutput,
    /// Least points of one waveform, and most points of all waveforms of an output together.
    pub least_points: u32,
    pub most_points: u32,
    /// Most steps in a sequence.
    pub most_steps: u32,
    pub start: Start,
}

/// A card with digital lines and analog outputs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DataAcquisitionFacts {
    /// Digital ports, and lines of each port: at most 32, as a port is played as one word.
    pub ports: u32,
    pub lines: u32,
    /// Highest sample rate of its digital lines, in hertz; 0 without a sample clock.
    pub digital_rate_hz: f64,
    pub analog_outputs: u32,
    /// `None` without analog outputs.
    pub voltage: Option<VoltageOutput>,
    pub start: Start,
}

/// The driver of a board of electrodes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ElectrodeDriverFacts {
    pub protocol: Protocol,
    /// Channels, numbered from 0: at most [`Protocol::channels`].
    pub channels: u32,
    /// Range of voltages that it can be set to.
    pub least_v: f64,
    pub most_v: f64,
    /// Shortest time from one frame to the next, in nanoseconds.
    pub least_frame_ns: u64,
    /// Frequency of its voltage, in hertz; `None` if the driver keeps its own setting.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frequency_hz: Option<f64>,
    /// The heaters that the bench uses, by their numbers from 1: temperature of each while its output is on, in
    /// degrees Celsius.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub heaters_degc: BTreeMap<u32, u32>,
    pub start: Start,
}

impl Protocol {
    /// Number of channels in a frame.
    pub fn channels(self) -> u32 {
        match self {
            Protocol::Opendrop | Protocol::Purpledrop => 128,
            Protocol::Dropbot => 120,
        }
    }

    /// Whether the player of the frames sets voltage and frequency; otherwise they are set on the driver itself.
    pub fn sets_voltage(self) -> bool {
        match self {
            Protocol::Dropbot => true,
            Protocol::Opendrop | Protocol::Purpledrop => false,
        }
    }

    /// Number of magnets that its frames raise and lower.
    pub fn magnets(self) -> u32 {
        match self {
            Protocol::Opendrop => 2,
            Protocol::Purpledrop | Protocol::Dropbot => 0,
        }
    }

    /// Number of heaters whose temperatures are in its frames.
    pub fn heaters(self) -> u32 {
        match self {
            Protocol::Opendrop => 3,
            Protocol::Purpledrop | Protocol::Dropbot => 0,
        }
    }

    /// Whether MicroDrop can drive it.
    pub fn has_microdrop(self) -> bool {
        match self {
            Protocol::Opendrop | Protocol::Dropbot => true,
            Protocol::Purpledrop => false,
        }
    }
}

impl ElectrodeDriverFacts {
    /// The names of its outputs that switch no electrode: `magnet1`, and `heater1` if the bench states that heater's
    /// temperature.
    pub fn accessories(&self) -> impl Iterator<Item = String> {
        self.magnet_outputs().chain(self.heaters_degc.keys().map(|number| format!("heater{number}")))
    }

    /// The names of its outputs that raise a magnet.
    pub fn magnet_outputs(&self) -> impl Iterator<Item = String> {
        (1..=self.protocol.magnets()).map(|number| format!("magnet{number}"))
    }

    /// Temperature of the heater behind an output while the output is on, in degrees Celsius.
    pub fn heats_to_degc(&self, output: &str) -> Option<u32> {
        self.heaters_degc.get(&number_after("heater", output)?).copied()
    }
}

/// Factor for the rounding of a quotient of two figures of the program that is compared with a limit of an
/// instrument.
pub const QUOTIENT_ROOM: f64 = 1.0 + 1e-12;

/// Capabilities of the voltage outputs of an instrument.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct VoltageOutput {
    /// Greatest voltage on either side of zero, into an open circuit.
    pub peak_v: f64,
    /// Bits of a sample, from the negative peak to the positive one.
    pub bits: u32,
    /// Highest sample rate, in hertz, unfiltered.
    pub rate_hz: f64,
}

/// Sort of an output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OutputSort {
    Voltage,
    Digital,
    Position,
    /// Another output of an electrode driver: a magnet or a heater.
    Accessory,
}

impl OutputSort {
    /// The link from an output to a channel of voltages or, with `is_stage`, to a stage; `None` if the output cannot
    /// drive it.
    pub fn link(self, is_stage: bool) -> Option<LinkSort> {
        match (self, is_stage) {
            (OutputSort::Voltage, false) => Some(LinkSort::Amplifier),
            (OutputSort::Voltage, true) => Some(LinkSort::StageDriver),
            (OutputSort::Digital | OutputSort::Accessory, false) => Some(LinkSort::Switch),
            (OutputSort::Position, true) => Some(LinkSort::Axis),
            (OutputSort::Digital | OutputSort::Accessory, true) | (OutputSort::Position, false) => None,
        }
    }
}

/// Sorts of links, as the help describes them.
const AMPLIFIED: (LinkSort, &str) = (LinkSort::Amplifier, "a channel of voltages, through an amplifier");
const PLACED: (LinkSort, &str) = (LinkSort::StageDriver, "the position of a stage, through its driver");
const SWITCHED: (LinkSort, &str) = (LinkSort::Switch, "a digital line, which closes a switch");
const MOVED: (LinkSort, &str) = (LinkSort::Axis, "the position of a stage, which the controller moves");

/// Sort of a [`Link`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LinkSort {
    Amplifier,
    StageDriver,
    Switch,
    Axis,
}

impl LinkSort {
    pub const ALL: [LinkSort; 4] = [LinkSort::Amplifier, LinkSort::StageDriver, LinkSort::Switch, LinkSort::Axis];

    /// Description of the outputs that drive such a link, in the plural.
    pub fn described(self) -> &'static str {
        match self {
            LinkSort::Amplifier => "outputs of voltage that feed amplifiers",
            LinkSort::StageDriver => "outputs of voltage that drive stages",
            LinkSort::Switch => "digital lines",
            LinkSort::Axis => "axes of stage controllers",
        }
    }

    /// The fields of such a wire.
    pub fn fields(self) -> &'static [VocabularyField] {
        match self {
            LinkSort::Amplifier => words::AMPLIFIER,
            LinkSort::StageDriver => words::STAGE_DRIVER,
            LinkSort::Switch => words::SWITCH,
            LinkSort::Axis => words::AXIS,
        }
    }
}

impl DataAcquisitionFacts {
    /// The port and line of a name such as `port0.line3`, or no port and the number of an analog output.
    pub fn place(name: &str) -> Option<(Option<u32>, u32)> {
        match name.split_once('.') {
            Some((port, line)) => Some((Some(number_after("port", port)?), number_after("line", line)?)),
            None => Some((None, number_after("ao", name)?)),
        }
    }
}

impl InstrumentFacts {
    /// Its family.
    pub fn family(&self) -> Family {
        match self {
            InstrumentFacts::WaveformGenerator(_) => Family::WaveformGenerator,
            InstrumentFacts::DataAcquisition(_) => Family::DataAcquisition,
            InstrumentFacts::ElectrodeDriver(_) => Family::ElectrodeDriver,
            InstrumentFacts::StageController(_) => Family::StageController,
            InstrumentFacts::MachineController(_) => Family::MachineController,
        }
    }

    /// The sort of the output with this name, such as `ch1` or `port0.line3`; `None` if there is no such output.
    pub fn output(&self, name: &str) -> Option<OutputSort> {
        match self {
            InstrumentFacts::WaveformGenerator(facts) => {
                let number = number_after("ch", name)?;
                (1..=facts.outputs).contains(&number).then_some(OutputSort::Voltage)
            }
            InstrumentFacts::DataAcquisition(facts) => match DataAcquisitionFacts::place(name)? {
                (Some(port), line) => (port < facts.ports && line < facts.lines).then_some(OutputSort::Digital),
                (None, output) => (output < facts.analog_outputs).then_some(OutputSort::Voltage),
            },
            InstrumentFacts::ElectrodeDriver(facts) => match number_after("c", name) {
                Some(number) => (number < facts.channels).then_some(OutputSort::Digital),
                None => facts.accessories().any(|accessory| accessory == name).then_some(OutputSort::Accessory),
            },
            InstrumentFacts::StageController(facts) => {
                let number = number_after("axis", name)?;
                (1..=facts.axes).contains(&number).then_some(OutputSort::Position)
            }
            InstrumentFacts::MachineController(facts) => {
                facts.letters().any(|letter| letter.to_string() == name).then_some(OutputSort::Position)
            }
        }
    }

    /// The names of all outputs to which channels may be spread, in order: all but accessories.
    pub fn output_names(&self) -> Vec<String> {
        match self {
            InstrumentFacts::WaveformGenerator(facts) => (1..=facts.outputs).map(|n| format!("ch{n}")).collect(),
            InstrumentFacts::ElectrodeDriver(facts) => (0..facts.channels).map(|n| format!("c{n}")).collect(),
            InstrumentFacts::StageController(facts) => (1..=facts.axes).map(|n| format!("axis{n}")).collect(),
            InstrumentFacts::MachineController(facts) => facts.letters().map(String::from).collect(),
            InstrumentFacts::DataAcquisition(facts) => {
                let lines = |port: u32| (0..facts.lines).map(move |line| format!("port{port}.line{line}"));
                let analog = (0..facts.analog_outputs).map(|n| format!("ao{n}"));
                (0..facts.ports).flat_map(lines).chain(analog).collect()
            }
        }
    }

    /// The names of its outputs, for messages.
    pub fn outputs(&self) -> String {
        let range = |first: String, last: String| {
            if first == last { format!("`{first}`") } else { format!("`{first}` to `{last}`") }
        };
        match self {
            InstrumentFacts::WaveformGenerator(facts) => range("ch1".to_owned(), format!("ch{}", facts.outputs)),
            InstrumentFacts::ElectrodeDriver(facts) => {
                let electrodes = range("c0".to_owned(), format!("c{}", facts.channels.saturating_sub(1)));
                facts.accessories().fold(electrodes, |names, accessory| format!("{names}, `{accessory}`"))
            }
            InstrumentFacts::StageController(facts) => range("axis1".to_owned(), format!("axis{}", facts.axes)),
            InstrumentFacts::MachineController(facts) => {
                facts.letters().map(|letter| format!("`{letter}`")).collect::<Vec<_>>().join(", ")
            }
            InstrumentFacts::DataAcquisition(facts) => {
                let last = |count: u32| count.saturating_sub(1);
                let lines =
                    range("port0.line0".to_owned(), format!("port{}.line{}", last(facts.ports), last(facts.lines)));
                let analog = range("ao0".to_owned(), format!("ao{}", last(facts.analog_outputs)));
                let named = [(facts.ports * facts.lines, lines), (facts.analog_outputs, analog)];
                let named: Vec<String> =
                    named.into_iter().filter_map(|(count, names)| (count > 0).then_some(names)).collect();
                named.join(" and ")
            }
        }
    }

    /// Whether the output would exist if the bench stated the temperature of its heater.
    pub fn lacks_temperature(&self, output: &str) -> bool {
        let InstrumentFacts::ElectrodeDriver(facts) = self else { return false };
        number_after("heater", output).is_some_and(|number| (1..=facts.protocol.heaters()).contains(&number))
    }

    /// Its start signal.
    pub fn start(&self) -> Start {
        match self {
            InstrumentFacts::WaveformGenerator(facts) => facts.start,
            InstrumentFacts::DataAcquisition(facts) => facts.start,
            InstrumentFacts::ElectrodeDriver(facts) => facts.start,
            InstrumentFacts::StageController(facts) => facts.start,
            InstrumentFacts::MachineController(_) => Start::Sender,
        }
    }

    /// Capabilities of its voltage outputs, if it has any.
    pub fn voltage(&self) -> Option<VoltageOutput> {
        match self {
            InstrumentFacts::WaveformGenerator(facts) => Some(facts.voltage),
            InstrumentFacts::DataAcquisition(facts) => facts.voltage,
            InstrumentFacts::ElectrodeDriver(_)
            | InstrumentFacts::StageController(_)
            | InstrumentFacts::MachineController(_) => None,
        }
    }
}

/// The number after a word, written without leading zeros: 3 of `line3`.
pub fn number_after(word: &str, name: &str) -> Option<u32> {
    let digits = name.strip_prefix(word)?;
    let is_plain = digits.bytes().all(|byte| byte.is_ascii_digit()) && (digits == "0" || !digits.starts_with('0'));
    digits.parse().ok().filter(|_| is_plain)
}

/// The instruments of a program, and the channels that they drive.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Bench {
    /// By their names in the program.
    pub instruments: BTreeMap<String, Instrument>,
    /// By the full names of the channels that are wired to instruments.
    pub drives: BTreeMap<String, Drive>,
}

impl Bench {
    /// Whether it has no instrument.
    pub fn is_empty(&self) -> bool {
        self.instruments.is_empty() && self.drives.is_empty()
    }

    /// The wiring of a channel and the instrument that drives it.
    pub fn drive(&self, channel: &str) -> Option<(&Drive, &Instrument)> {
        let drive = self.drives.get(channel)?;
        Some((drive, self.instruments.get(&drive.instrument)?))
    }

    /// Whether another bench has the same instruments and drives; spans are ignored.
    pub fn is_same(&self, other: &Bench) -> bool {
        let parts = |drive: &Drive| (drive.instrument.clone(), drive.output.clone(), drive.link, drive.limits);
        let drives = |bench: &Bench| bench.drives.iter().map(|(name, drive)| (name.clone(), parts(drive))).collect();
        let [own, others]: [Vec<_>; 2] = [drives(self), drives(other)];
        self.instruments == other.instruments && own == others
    }
}

/// Connection between a channel and an output of an instrument.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Drive {
    /// The instrument's name in the program.
    pub instrument: String,
    /// The output's name on the instrument.
    pub output: String,
    pub link: Link,
    /// Limits of the stage behind it.
    #[serde(default, skip_serializing_if = "StageLimits::is_empty")]
    pub limits: StageLimits,
    /// The wire's place in the program.
    #[serde(skip)]
    pub span: Span,
}

/// Conversion between the value of a channel and that of an output.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Link {
    /// A voltage behind an amplifier: the channel's volts are the output's volts times the gain.
    Amplifier {
        /// Not 0; a negative gain inverts.
        gain: f64,
        /// Greatest voltage of the amplifier on either side of zero.
        limit_v: Option<f64>,
        /// Greatest slew rate, in volts per second.
        slew_v_per_s: Option<f64>,
    },
    /// The driver of a stage: the output gives `zero_v` plus `scale_v_per_um` for each micrometre.
    StageDriver { zero_v: f64, scale_v_per_um: f64 },
    /// A switch that a digital line closes; the channel has this voltage while it is on.
    Switch { on_v: f64 },
    /// A stage that its controller moves: the channel's 0 is at `origin_um` of the stage's travel, and the stage
    /// counts forward or backward from there.
    Axis { origin_um: f64, direction: Direction, least_um: f64, most_um: f64 },
}

impl Link {
    /// Voltage of the output for a value of the channel, in volts or micrometres; for a switch the level of its line,
    /// 0 or 1; for an axis the position of the stage, in micrometres.
    pub fn at_output(self, value: f64) -> f64 {
        match self {
            Link::Amplifier { gain, .. } => value / gain,
            Link::StageDriver { zero_v, scale_v_per_um } => zero_v + value * scale_v_per_um,
            Link::Switch { .. } => f64::from(u8::from(value != 0.0)),
            Link::Axis { origin_um, direction, .. } => origin_um + direction.sign() * value,
        }
    }

    /// Value of the channel for a voltage of the output, for a switch from the level of its line, for an axis from
    /// the position of the stage.
    pub fn value(self, output_v: f64) -> f64 {
        match self {
            Link::Amplifier { gain, .. } => output_v * gain,
            Link::StageDriver { zero_v, scale_v_per_um } => (output_v - zero_v) / scale_v_per_um,
            Link::Switch { on_v } => output_v * on_v,
            Link::Axis { origin_um, direction, .. } => direction.sign() * (output_v - origin_um),
        }
    }
}
