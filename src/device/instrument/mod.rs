//! Instruments: what stands behind a channel, from the computer to the actuator.
//!
//! A program declares the instruments of its bench, each of one of the families here, and wires channels to their outputs. As with
//! device kinds, the words are tables: the checker reads them and `tweeze devices` prints them. Facts only; `check` reads
//! them from a program, `lower` holds a schedule against them, `emit` writes the files that they play.

mod auxiliary;
mod machine;
mod stages;
mod words;

pub(crate) use auxiliary::is_zero;
pub use auxiliary::{AuxiliaryOutput, AuxiliarySort, Awaited, HoldTerms};
pub use machine::{AXIS_LETTERS, MachineControllerFacts};
pub use stages::{Direction, StageControllerFacts, StageLimits, StageProtocol, cut_um};
pub use words::{ANY_WIRE, HEATERS};

use crate::device::{VocabularyField, words::words};
use crate::quantity::{CELSIUS, Quantity};
use crate::source::Span;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::RangeInclusive;

/// Most outputs of one instrument.
pub const MAX_OUTPUTS: u32 = 4096;

/// Temperatures to which MicroDrop 1.9 sets the heaters of an OpenDrop, in degrees Celsius; its frames have a byte for each.
pub const DRIVER_HEATER_DEGC: RangeInclusive<u32> = 20..=120;

/// How far a temperature that is written as whole degrees may be off by rounding, in degrees.
const ROUNDING_DEGC: f64 = 1e-6;

/// How a heater of an OpenDrop is set to a temperature, in degrees Celsius; `None` where its frames cannot say it.
pub fn heater_setting(temperature: Quantity) -> Option<u32> {
    let degrees = temperature.in_unit(CELSIUS);
    DRIVER_HEATER_DEGC.into_iter().find(|whole| (degrees - f64::from(*whole)).abs() < ROUNDING_DEGC)
}

words! {
    /// The families of instruments, in the order of the handbook.
    pub enum Family {
        WaveformGenerator = "waveform_generator": "an arbitrary-waveform generator of the Keysight 33500 and 33600 series, or one that takes their commands",
        DataAcquisition = "data_acquisition": "a card with digital lines and analog outputs on a sample clock, played by NI-DAQmx",
        ElectrodeDriver = "electrode_driver": "the driver of a board of electrodes, which takes frame after frame of those that are on: OpenDrop, PurpleDrop, DropBot",
        StageController = "stage_controller": "a controller that moves stages along a table of places: of PI by its commands GCS, of SmarAct by the streams of an MCS2",
        MachineController = "machine_controller": "a controller whose stages are the axes of a machine that runs G-code: LinuxCNC",
    }
}

impl Family {
    /// A published instrument to start from: the file, and its name there.
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

    /// The names of its outputs, and what they carry.
    pub fn outputs(self) -> &'static str {
        match self {
            Family::WaveformGenerator => "`ch1`, `ch2`, …: a voltage each",
            Family::DataAcquisition => "`port0.line0`, …: a digital line each; `ao0`, …: a voltage each",
            Family::ElectrodeDriver => {
                "`c0`, `c1`, …: an electrode each; `electrodes -> NAME` wires all that the `channels` of a board number. An OpenDrop has `magnet1` and `magnet2`, and `heater1` to `heater3` where a temperature is given, for outputs of the bench"
            }
            Family::StageController => "`axis1`, `axis2`, …: a stage each",
            Family::MachineController => "`X`, `Y`, `Z`, `U`, `V`, `W`, `A`, `B`, `C`: a stage each",
        }
    }

    /// What its outputs may drive, with the fields of such a wire.
    pub fn links(self) -> &'static [(LinkSort, &'static str)] {
        match self {
            Family::WaveformGenerator => &[AMPLIFIED, PLACED],
            Family::DataAcquisition => &[SWITCHED, AMPLIFIED, PLACED],
            Family::ElectrodeDriver => &[SWITCHED],
            Family::StageController | Family::MachineController => &[MOVED],
        }
    }

    /// The format that plays it.
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
    /// Its base as the program writes it: `instruments.keysight_33500b`.
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
    /// Level of an output or an input that has two.
    pub enum Level {
        Low = "low": "at 0 V",
        High = "high": "at the voltage of the output",
    }
}

words! {
    /// What starts an instrument.
    pub enum Start {
        Sender = "sender": "the program that sends its file",
        Trigger = "trigger": "a pulse at its trigger input, from the instrument that the sender starts, or from your own source",
    }
}

words! {
    /// How an electrode driver is spoken to.
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
    /// Points of a waveform: no fewer, and of all waveforms of an output no more.
    pub least_points: u32,
    pub most_points: u32,
    /// Most steps of a sequence.
    pub most_steps: u32,
    pub start: Start,
}

/// A card with digital lines and analog outputs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DataAcquisitionFacts {
    /// Digital ports, and the lines of each: at most 32, a word of a port.
    pub ports: u32,
    pub lines: u32,
    /// Greatest number of samples in a second of its digital lines, in hertz; 0 without a sample clock.
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
    /// The voltages that it can be set to.
    pub least_v: f64,
    pub most_v: f64,
    /// Shortest time from one frame to the next, in nanoseconds.
    pub least_frame_ns: u64,
    /// Frequency of its voltage, in hertz; `None` where it stays as it is set on the driver.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frequency_hz: Option<f64>,
    /// Its heaters that the bench uses, by their numbers from 1: the temperature of each while its output is on, in degrees Celsius.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub heaters_degc: BTreeMap<u32, u32>,
    pub start: Start,
}

impl Protocol {
    /// Most channels that its frames have room for.
    pub fn channels(self) -> u32 {
        match self {
            Protocol::Opendrop | Protocol::Purpledrop => 128,
            Protocol::Dropbot => 120,
        }
    }

    /// Whether voltage and frequency are set by who plays frames, and not on the driver itself.
    pub fn sets_voltage(self) -> bool {
        match self {
            Protocol::Dropbot => true,
            Protocol::Opendrop | Protocol::Purpledrop => false,
        }
    }

    /// Magnets that its frames raise and lower.
    pub fn magnets(self) -> u32 {
        match self {
            Protocol::Opendrop => 2,
            Protocol::Purpledrop | Protocol::Dropbot => 0,
        }
    }

    /// Heaters whose temperatures are in its frames.
    pub fn heaters(self) -> u32 {
        match self {
            Protocol::Opendrop => 3,
            Protocol::Purpledrop | Protocol::Dropbot => 0,
        }
    }

    /// Whether MicroDrop drives it.
    pub fn has_microdrop(self) -> bool {
        match self {
            Protocol::Opendrop | Protocol::Dropbot => true,
            Protocol::Purpledrop => false,
        }
    }
}

impl ElectrodeDriverFacts {
    /// The names of its outputs that switch no electrode: `magnet1`, and `heater1` where the bench says how warm that is.
    pub fn accessories(&self) -> impl Iterator<Item = String> {
        self.magnet_outputs().chain(self.heaters_degc.keys().map(|number| format!("heater{number}")))
    }

    /// The names of its outputs that raise a magnet.
    pub fn magnet_outputs(&self) -> impl Iterator<Item = String> {
        (1..=self.protocol.magnets()).map(|number| format!("magnet{number}"))
    }

    /// The temperature of the heater behind an output while that is on, in degrees Celsius.
    pub fn heats_to_degc(&self, output: &str) -> Option<u32> {
        self.heaters_degc.get(&number_after("heater", output)?).copied()
    }
}

/// Room for the rounding of a quotient of two figures of the program, where one is held against an instrument.
pub const QUOTIENT_ROOM: f64 = 1.0 + 1e-12;

/// What the voltage outputs of an instrument can do.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct VoltageOutput {
    /// Greatest voltage to either side of zero, into an open circuit.
    pub peak_v: f64,
    /// Bits of a sample, from the negative peak to the positive one.
    pub bits: u32,
    /// Greatest number of samples in a second, in hertz, unfiltered.
    pub rate_hz: f64,
}

/// Sort of an output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OutputSort {
    Voltage,
    Digital,
    Position,
    /// What a driver of electrodes switches beside these: a magnet, a heater.
    Accessory,
}

impl OutputSort {
    /// What stands behind an output that drives a channel of voltages or, with `is_stage`, a stage; `None` where it cannot.
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

/// Sorts of links, as help describes them.
const AMPLIFIED: (LinkSort, &str) = (LinkSort::Amplifier, "a channel of voltages, behind an amplifier");
const PLACED: (LinkSort, &str) = (LinkSort::StageDriver, "the position of a stage, behind its driver");
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

    /// Where such a wire leads, in the plural.
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
    /// The port and the line that a name as `port0.line3` stands for, or no port and the number of an analog output.
    pub fn place(name: &str) -> Option<(Option<u32>, u32)> {
        match name.split_once('.') {
            Some((port, line)) => Some((Some(number_after("port", port)?), number_after("line", line)?)),
            None => Some((None, number_after("ao", name)?)),
        }
    }
}

impl InstrumentFacts {
    /// The family that it is of.
    pub fn family(&self) -> Family {
        match self {
            InstrumentFacts::WaveformGenerator(_) => Family::WaveformGenerator,
            InstrumentFacts::DataAcquisition(_) => Family::DataAcquisition,
            InstrumentFacts::ElectrodeDriver(_) => Family::ElectrodeDriver,
            InstrumentFacts::StageController(_) => Family::StageController,
            InstrumentFacts::MachineController(_) => Family::MachineController,
        }
    }

    /// The sort of an output by its name, as `ch1` or `port0.line3`; `None` if there is no such output.
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

    /// The names of all its outputs to which channels may be spread, in their order: all but accessories.
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

    /// The names of its outputs, for a message.
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

    /// Whether it would have an output of this name if the bench said how warm the heater behind it is.
    pub fn lacks_temperature(&self, output: &str) -> bool {
        let InstrumentFacts::ElectrodeDriver(facts) = self else { return false };
        number_after("heater", output).is_some_and(|number| (1..=facts.protocol.heaters()).contains(&number))
    }

    /// What starts it.
    pub fn start(&self) -> Start {
        match self {
            InstrumentFacts::WaveformGenerator(facts) => facts.start,
            InstrumentFacts::DataAcquisition(facts) => facts.start,
            InstrumentFacts::ElectrodeDriver(facts) => facts.start,
            InstrumentFacts::StageController(facts) => facts.start,
            InstrumentFacts::MachineController(_) => Start::Sender,
        }
    }

    /// What its voltage outputs can do, if it has any.
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

/// The number behind a word, written without leading zeros: 3 of `line3`.
pub fn number_after(word: &str, name: &str) -> Option<u32> {
    let digits = name.strip_prefix(word)?;
    let is_plain = digits.bytes().all(|byte| byte.is_ascii_digit()) && (digits == "0" || !digits.starts_with('0'));
    digits.parse().ok().filter(|_| is_plain)
}

/// The instruments of a program, and what they drive.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Bench {
    /// By their names in the program.
    pub instruments: BTreeMap<String, Instrument>,
    /// By the full names of the channels that are wired to them.
    pub drives: BTreeMap<String, Drive>,
}

impl Bench {
    /// Whether it has no instrument.
    pub fn is_empty(&self) -> bool {
        self.instruments.is_empty() && self.drives.is_empty()
    }

    /// The instrument that drives a channel, and how.
    pub fn drive(&self, channel: &str) -> Option<(&Drive, &Instrument)> {
        let drive = self.drives.get(channel)?;
        Some((drive, self.instruments.get(&drive.instrument)?))
    }

    /// Whether another bench has the same instruments and drives, wherever they are written.
    pub fn is_same(&self, other: &Bench) -> bool {
        let parts = |drive: &Drive| (drive.instrument.clone(), drive.output.clone(), drive.link, drive.limits);
        let drives = |bench: &Bench| bench.drives.iter().map(|(name, drive)| (name.clone(), parts(drive))).collect();
        let [own, others]: [Vec<_>; 2] = [drives(self), drives(other)];
        self.instruments == other.instruments && own == others
    }
}

/// What stands between a channel and the output of an instrument.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Drive {
    /// The instrument's name in the program.
    pub instrument: String,
    /// The output's name on the instrument.
    pub output: String,
    pub link: Link,
    /// Of the stage behind it.
    #[serde(default, skip_serializing_if = "StageLimits::is_empty")]
    pub limits: StageLimits,
    /// The wire in the program.
    #[serde(skip)]
    pub span: Span,
}

/// How the value of a channel becomes that of an output.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Link {
    /// A voltage behind an amplifier: the channel's volts are those of the output, times the gain.
    Amplifier {
        /// Not 0; below 0 it inverts.
        gain: f64,
        /// Greatest voltage to either side that the amplifier gives.
        limit_v: Option<f64>,
        /// Fastest change of its voltage, in volts per second.
        slew_v_per_s: Option<f64>,
    },
    /// The driver of a stage: the output gives `zero_v`, and `scale_v_per_um` more for each micrometre.
    StageDriver { zero_v: f64, scale_v_per_um: f64 },
    /// A switch that a digital line closes: on, the channel has this voltage.
    Switch { on_v: f64 },
    /// A stage that its controller moves: it is at `origin_um` of its own travel where the channel is at 0, and counts on from there
    /// or back.
    Axis { origin_um: f64, direction: Direction, least_um: f64, most_um: f64 },
}

impl Link {
    /// Voltage of the instrument's output at a value of the channel, in volts or micrometres; for a switch the level of
    /// its line, 0 or 1; for an axis the place of the stage, in micrometres.
    pub fn at_output(self, value: f64) -> f64 {
        match self {
            Link::Amplifier { gain, .. } => value / gain,
            Link::StageDriver { zero_v, scale_v_per_um } => zero_v + value * scale_v_per_um,
            Link::Switch { .. } => f64::from(u8::from(value != 0.0)),
            Link::Axis { origin_um, direction, .. } => origin_um + direction.sign() * value,
        }
    }

    /// Value of the channel at a voltage of the instrument's output.
    pub fn value(self, output_v: f64) -> f64 {
        match self {
            Link::Amplifier { gain, .. } => output_v * gain,
            Link::StageDriver { zero_v, scale_v_per_um } => (output_v - zero_v) / scale_v_per_um,
            Link::Switch { on_v } => output_v * on_v,
            Link::Axis { origin_um, direction, .. } => direction.sign() * (output_v - origin_um),
        }
    }
}
