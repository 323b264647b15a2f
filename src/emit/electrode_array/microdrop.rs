//! Files for MicroDrop 1.9, which drives DropBot and OpenDrop: the protocol and the device of each driver.
//!
//! `<name>.<driver>.microdrop.json` has a step for each frame: the electrodes that are on, and the duration in seconds.
//! For a DropBot each step also has voltage and frequency. A `prompt` becomes the message of the step after it:
//! MicroDrop shows it before that step and keeps the electrodes of the previous step on. Where a schedule begins or
//! ends with a prompt, a step of 0 s stands before or after it.
//!
//! `<name>.<driver>.microdrop.svg` is the device: a path for each electrode that is wired to the driver, named by the
//! number of its channel (with a suffix if it shares the channel), and a line for each pair of neighbours. Reservoir
//! pads, whose places a device does not have, stand in a row below the board without neighbours. Its unit is the pixel
//! of 96 to the inch; sizes are those of the board.

use super::super::error::{EmitError, MAX_TEXT_BYTES};
use super::super::frames::FramedBoard;
use super::super::wired::{WiredInstrument, wired};
use super::super::{Format, Verified};
use super::dispensed;
use crate::claims::Claims;
use crate::claims::electrode_array::ElectrodeArrayOrder;
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell};
use crate::device::instrument::{Awaited, Family, InstrumentFacts, number_after};
use crate::schedule::{Schedule, sha256};
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

/// Version of the file format.
const SCHEMA_VERSION: u32 = 1;

/// Python modules that declare MicroDrop's columns.
const BUILT_IN: &str = "pluggable_protocol_tree.builtins";
const OF_DROPBOT: &str = "dropbot_protocol_controls.protocol_columns";

/// Pixels per micrometre, at 96 to the inch.
const PX_PER_UM: f64 = 96.0 / 25_400.0;

/// Hexadecimal digits in the unique id of a step.
const UUID_DIGITS: usize = 32;

/// Estimated bytes of a step without its electrodes, and of an electrode.
const STEP_BYTES: u64 = 120;
const ELECTRODE_BYTES: u64 = 15;

/// The files, each with its ending.
///
/// # Errors
/// [`EmitError::NotWired`], [`EmitError::OtherProtocol`], [`EmitError::Ramp`], [`EmitError::Unsupported`],
/// [`EmitError::TooLarge`].
pub fn write(verified: &Verified) -> Result<Vec<(String, Vec<u8>)>, EmitError> {
    let schedule = verified.schedule();
    let mut files = Vec::new();
    for wired in wired(Format::Microdrop, schedule, Family::ElectrodeDriver)? {
        let InstrumentFacts::ElectrodeDriver(facts) = &wired.instrument.facts else { continue };
        if !facts.protocol.has_microdrop() {
            continue;
        }
        let board = FramedBoard::new(&wired, facts)?;
        board.refuse_rest(Format::Microdrop)?;
        let chips = chips(&wired, schedule, verified.claims())?;
        files.push((format!("{}.microdrop.json", wired.name), protocol(&board, &chips, verified)?.into_bytes()));
        files.push((format!("{}.microdrop.svg", wired.name), device(&chips).into_bytes()));
    }
    let none = || EmitError::OtherProtocol { format: Format::Microdrop, name: schedule.name.clone() };
    if files.is_empty() { Err(none()) } else { Ok(files) }
}

/// A board, as far as a driver switches its electrodes.
struct WiredChip<'a> {
    facts: &'a ElectrodeArrayFacts,
    /// Channel number of each electrode that is wired to the driver.
    numbers: BTreeMap<ElectrodeCell, u32>,
    /// Channels of its reservoir pads.
    pads: BTreeSet<u32>,
}

impl WiredChip<'_> {
    /// The channels of its electrodes and pads.
    fn channels(&self) -> impl Iterator<Item = u32> {
        self.numbers.values().chain(&self.pads).copied()
    }

    /// The electrodes with their channel numbers and their names in the files.
    fn named(&self) -> impl Iterator<Item = (ElectrodeCell, u32, String)> {
        let mut cells: Vec<(ElectrodeCell, u32)> = self.numbers.iter().map(|(cell, number)| (*cell, *number)).collect();
        cells.sort_by_key(|(cell, number)| (*number, cell.row, cell.column));
        let mut met: BTreeMap<u32, usize> = BTreeMap::new();
        cells.into_iter().map(move |(cell, number)| {
            let nth = met.entry(number).or_default();
            *nth += 1;
            (cell, number, shared_id(number, *nth))
        })
    }

    /// Columns and rows that it takes in the picture; pads stand in the second row below the board.
    fn size(&self) -> [u32; 2] {
        let (columns, rows) = (self.facts.columns, self.facts.rows);
        if self.pads.is_empty() { [columns, rows] } else { [columns.max(self.pads.len() as u32), rows + 2] }
    }
}

/// The boards behind a driver, by device name.
fn chips<'a>(
    wired: &WiredInstrument,
    schedule: &Schedule,
    claims: &'a Claims,
) -> Result<Vec<WiredChip<'a>>, EmitError> {
    let boards: BTreeMap<&str, &ElectrodeArrayFacts> = (claims.jobs.iter())
        .filter_map(|job| Some((job.device.as_str(), &ElectrodeArrayOrder::of(&job.order)?.facts)))
        .collect();
    let mut chips: BTreeMap<&str, WiredChip> = BTreeMap::new();
    for (channel, drive) in schedule.bench.drives.iter().filter(|(_, drive)| drive.instrument == wired.name) {
        let board = channel.split_once('.').and_then(|(device, name)| {
            let (device, facts) = boards.get_key_value(device)?;
            Some((*device, *facts, facts.electrode(name), facts.pad(name)))
        });
        let board = board.filter(|(_, _, cell, pad)| cell.is_some() || pad.is_some());
        let (Some((device, facts, cell, _)), Some(number)) = (board, number_after("c", &drive.output)) else {
            let what = format!("`{channel}`, which is not an electrode of a board");
            let help =
                "wire it to another instrument, or write `--emit frames`, which supports every channel of a driver";
            return Err(EmitError::Unsupported { format: Format::Microdrop, what, help: help.to_owned() });
        };
        let new = || WiredChip { facts, numbers: BTreeMap::new(), pads: BTreeSet::new() };
        let chip = chips.entry(device).or_insert_with(new);
        match cell {
            Some(cell) => chip.numbers.extend(facts.on_channel_of(cell).into_iter().map(|cell| (cell, number))),
            None => drop(chip.pads.insert(number)),
        }
    }
    Ok(chips.into_values().collect())
}

/// Identifier of an electrode by the number of its channel: `electrode012`.
fn electrode_id(number: u32) -> String {
    format!("electrode{number:03}")
}

/// Identifier of the electrodes on a channel after the first: `electrode012_2`.
fn shared_id(number: u32, nth: usize) -> String {
    if nth == 1 { electrode_id(number) } else { format!("{}_{nth}", electrode_id(number)) }
}

/// The names of the electrodes and pads on each channel.
fn names_by_channel(chips: &[WiredChip]) -> BTreeMap<u32, Vec<String>> {
    let mut uses: BTreeMap<u32, usize> = BTreeMap::new();
    chips.iter().flat_map(WiredChip::channels).for_each(|number| *uses.entry(number).or_default() += 1);
    uses.into_iter().map(|(number, count)| (number, (1..=count).map(|nth| shared_id(number, nth)).collect())).collect()
}

/// A step of the protocol.
struct ProtocolStep<'a> {
    start_ns: u64,
    duration_ns: u64,
    on: &'a BTreeSet<u32>,
    /// Prompt for the person at the bench before the step; empty for none.
    prompt: String,
}

/// The steps from the start of the schedule to its end, without the waits.
fn steps<'a>(board: &'a FramedBoard, schedule: &Schedule) -> Vec<ProtocolStep<'a>> {
    let mut steps = Vec::new();
    let mut from_ns = 0;
    let mut prompt = String::new();
    for hold in &schedule.holds {
        stretch(board, [from_ns, hold.start_ns], &mut prompt, &mut steps);
        prompt = match &hold.terms.awaited {
            Awaited::Person { prompt } => prompt.clone(),
            Awaited::Input { name, .. } => name.clone(),
        };
        from_ns = hold.end_ns();
    }
    stretch(board, [from_ns, schedule.duration_ns], &mut prompt, &mut steps);
    steps
}

/// The steps between two instants; the first one takes the prompt, if there is one.
fn stretch<'a>(
    board: &'a FramedBoard,
    [from_ns, to_ns]: [u64; 2],
    prompt: &mut String,
    steps: &mut Vec<ProtocolStep<'a>>,
) {
    let frames = || board.frames.iter();
    if from_ns == to_ns {
        // Nothing lies between two waits: a step of 0 s has the electrodes that are on meanwhile.
        let here = frames().find(|frame| frame.end_ns > from_ns).or(board.frames.last());
        steps.extend(here.map(|frame| ProtocolStep {
            start_ns: from_ns,
            duration_ns: 0,
            on: &frame.on,
            prompt: std::mem::take(prompt),
        }));
    }
    for frame in frames().filter(|frame| frame.start_ns < to_ns && frame.end_ns > from_ns) {
        let start_ns = frame.start_ns.max(from_ns);
        let duration_ns = frame.end_ns.min(to_ns) - start_ns;
        steps.push(ProtocolStep { start_ns, duration_ns, on: &frame.on, prompt: std::mem::take(prompt) });
    }
}

/// A column of the protocol: its id, and the module and name of its class.
type ColumnClass = (&'static str, (&'static str, &'static str));

/// The protocol as MicroDrop loads it.
fn protocol(board: &FramedBoard, chips: &[WiredChip], verified: &Verified) -> Result<String, EmitError> {
    let schedule = verified.schedule();
    let steps = steps(board, schedule);
    let on: usize = steps.iter().map(|step| step.on.len()).sum();
    let bytes = steps.len() as u64 * STEP_BYTES + on as u64 * ELECTRODE_BYTES;
    EmitError::refuse_size(Format::Microdrop, bytes, MAX_TEXT_BYTES)?;
    let mut columns: Vec<ColumnClass> = vec![
        ("duration_s", (BUILT_IN, "duration_column.DurationColumnModel")),
        ("electrodes", (BUILT_IN, "electrodes_column.ElectrodesColumnModel")),
    ];
    let mut settings = Vec::new();
    if board.facts.protocol.sets_voltage() {
        columns.push(("voltage", (OF_DROPBOT, "voltage_column.VoltageColumnModel")));
        settings.push(json!(whole(board.voltage_v(Format::Microdrop)?, "V")?));
        if let Some(frequency_hz) = board.facts.frequency_hz {
            columns.push(("frequency", (OF_DROPBOT, "frequency_column.FrequencyColumnModel")));
            settings.push(json!(whole(frequency_hz, "Hz")?));
        }
    }
    let has_prompts = !schedule.holds.is_empty();
    if has_prompts {
        columns.push(("message_prompt", (BUILT_IN, "message_prompt_column.MsgPromptColumnModel")));
    }
    let names = step_names(&steps, &dispensed(verified));
    let electrodes = names_by_channel(chips);
    let rows = steps.iter().zip(&names).zip(1..).map(|((step, name), number)| {
        let on: Vec<&String> = step.on.iter().filter_map(|number| electrodes.get(number)).flatten().collect();
        let mut row = vec![json!(0), json!(own_name(board, schedule, number)), json!("step"), json!(name)];
        row.extend([json!(step.duration_ns as f64 / 1e9), json!(on)]);
        row.extend(settings.iter().cloned());
        row.extend(has_prompts.then(|| json!(step.prompt)));
        Value::Array(row)
    });
    Ok(document(&columns, chips, rows.collect()))
}

/// The text of the file, with a line per step.
fn document(columns: &[ColumnClass], chips: &[WiredChip], rows: Vec<Value>) -> String {
    let names = names_by_channel(chips).into_iter();
    let channels: BTreeMap<String, u32> =
        names.flat_map(|(number, names)| names.into_iter().map(move |name| (name, number))).collect();
    let classes = columns.iter().map(|(id, (package, class))| json!({ "id": id, "cls": format!("{package}.{class}") }));
    let fields = ["depth", "uuid", "type", "name"].into_iter().chain(columns.iter().map(|(id, _)| *id));
    let mut text = format!("{{\n  \"schema_version\": {SCHEMA_VERSION},\n");
    let _ = writeln!(text, "  \"protocol_metadata\": {},", json!({ "electrode_to_channel": channels }));
    let _ = writeln!(text, "  \"row_flags\": {{}},\n  \"columns\": {},", Value::Array(classes.collect()));
    let _ = writeln!(text, "  \"fields\": {},\n  \"rows\": [", json!(fields.collect::<Vec<_>>()));
    let lines: Vec<String> = rows.iter().map(|row| format!("    {row}")).collect();
    text + &lines.join(",\n") + "\n  ]\n}\n"
}

/// Names of the steps in MicroDrop's list: a number, and the droplets that are due at an outlet.
fn step_names(steps: &[ProtocolStep], dispensed: &[Value]) -> Vec<String> {
    let mut names: Vec<String> = (1..=steps.len()).map(|number| format!("Step {number}")).collect();
    for due in dispensed {
        let at_ns = (due["at_s"].as_f64().unwrap_or(0.0) * 1e9).round() as u64;
        let index = steps.partition_point(|step| step.start_ns <= at_ns).saturating_sub(1);
        let Some(name) = names.get_mut(index) else { continue };
        let (droplet, [column, row]) =
            (due["droplet"].as_str().unwrap_or_default(), [0, 1].map(|at| &due["outlet"][at]));
        let _ = write!(name, "; droplet {droplet} is due at ({column}, {row})");
    }
    names
}

/// A unique id of a step, always the same for the same program.
fn own_name(board: &FramedBoard, schedule: &Schedule, number: usize) -> String {
    let text = format!("{}\n{}\n{}\n{number}", schedule.source.sha256, schedule.name, board.wired.name);
    sha256(&text).chars().take(UUID_DIGITS).collect()
}

/// A setting of a step as a whole number.
fn whole(value: f64, unit: &str) -> Result<u64, EmitError> {
    if value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value) {
        return Ok(value as u64);
    }
    let what = format!("a step of {value} {unit}: its settings are whole numbers");
    let help = format!("round it to whole {unit} in the program, or write `--emit frames`");
    Err(EmitError::Unsupported { format: Format::Microdrop, what, help })
}

/// The device: boards side by side, a pitch apart.
fn device(chips: &[WiredChip]) -> String {
    let (mut paths, mut lines) = (String::new(), Vec::new());
    let (mut left_um, mut height_um) = (0.0, 0.0_f64);
    for chip in chips {
        let facts = chip.facts;
        let pitch_um = facts.pitch_um();
        let place = |steps: [u32; 2]| {
            let [right, down] = steps.map(|steps| (f64::from(steps) + 0.5) * pitch_um);
            [left_um + right, down]
        };
        // The middle of an electrode; rows of a picture count downwards.
        let middle = |cell: ElectrodeCell| place([cell.column - 1, facts.rows - cell.row]);
        let electrodes = chip.named().map(|(cell, number, name)| (number, name, middle(cell)));
        let pads = chip.pads.iter().zip(0..);
        let pads = pads.map(|(pad, column)| (*pad, electrode_id(*pad), place([column, facts.rows + 1])));
        let mut by_number: Vec<(u32, String, [f64; 2])> = electrodes.chain(pads).collect();
        by_number.sort_by_key(|(number, ..)| *number);
        for (number, name, [x, y]) in by_number {
            let [left, right] = [x - facts.radius_um, x + facts.radius_um].map(px);
            let [top, bottom] = [y - facts.radius_um, y + facts.radius_um].map(px);
            let _ = writeln!(
                paths,
                "    <path id=\"{name}\" data-channels=\"{number}\" style=\"fill:#000000\" d=\"M {left},{top} H {right} V {bottom} H {left} Z\"/>",
            );
        }
        for cell in chip.numbers.keys() {
            let beside = [ElectrodeCell::new(cell.column + 1, cell.row), ElectrodeCell::new(cell.column, cell.row + 1)];
            let beside = beside.into_iter().filter(|other| chip.numbers.contains_key(other));
            lines.extend(beside.map(|other| [middle(*cell), middle(other)]));
        }
        let [columns, rows] = chip.size();
        left_um += f64::from(columns + 1) * pitch_um;
        height_um = height_um.max(f64::from(rows) * pitch_um);
    }
    let last_pitch_um = chips.last().map_or(0.0, |chip| chip.facts.pitch_um());
    picture([left_um - last_pitch_um, height_um], &paths, &lines)
}

/// The picture with its two layers.
fn picture(size_um: [f64; 2], paths: &str, connections: &[[[f64; 2]; 2]]) -> String {
    let [width, height] = size_um.map(px);
    let mut lines = String::new();
    for (index, ends) in connections.iter().enumerate() {
        let [[x1, y1], [x2, y2]] = ends.map(|end| end.map(px));
        let _ = writeln!(
            lines,
            "    <line id=\"line{index}\" style=\"stroke:#000000;stroke-width:0.1\" x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\"/>"
        );
    }
    // MicroDrop looks for a `scale` without a namespace: square millimetres per unit of area, which here is in
    // millimetres already.
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:inkscape=\"http://www.inkscape.org/namespaces/inkscape\" \
         version=\"1.1\" width=\"{width}\" height=\"{height}\">\n  \
         <metadata><scale xmlns=\"\">1</scale></metadata>\n  \
         <g id=\"layer1\" inkscape:groupmode=\"layer\" inkscape:label=\"Device\">\n{paths}  </g>\n  \
         <g id=\"layer2\" inkscape:groupmode=\"layer\" inkscape:label=\"Connections\">\n{lines}  </g>\n\
         </svg>\n"
    )
}

/// Micrometres as pixels, to a hundredth of a micrometre.
fn px(um: f64) -> String {
    let text = format!("{:.5}", um * PX_PER_UM);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
