//! Boards in JSON: definitions of PurpleDrop, and lists of electrodes of OpenDrop's program.

use super::{DrawnElectrode, MAX_ELECTRODES};
use crate::device::BoardLimits;
use serde::Deserialize;

/// A board definition of PurpleDrop: one grid of pins, or several with a pitch each, and the peripherals beside them.
#[derive(Deserialize)]
struct PurpledropFile {
    layout: PurpledropLayout,
}

#[derive(Deserialize)]
struct PurpledropLayout {
    grid: Option<PinGrid>,
    #[serde(default)]
    grids: Vec<PitchedGrid>,
    #[serde(default)]
    peripherals: Vec<Peripheral>,
}

/// Rows from the top, with a pin or nothing in each column.
type PinGrid = Vec<Vec<Option<u32>>>;

#[derive(Deserialize)]
struct PitchedGrid {
    origin: [f64; 2],
    /// Pitch of the grid.
    #[serde(rename = "pitch")]
    spacing: f64,
    pins: PinGrid,
}

#[derive(Deserialize)]
struct Peripheral {
    #[serde(default)]
    class: String,
    #[serde(default)]
    id: serde_json::Value,
    #[serde(default)]
    electrodes: Vec<PeripheralElectrode>,
}

#[derive(Deserialize)]
struct PeripheralElectrode {
    #[serde(default)]
    id: serde_json::Value,
    pin: u32,
}

/// An electrode of OpenDrop's program: its left and top edge, its width and height, and its channel.
#[derive(Deserialize)]
struct OpendropElectrode {
    x: f64,
    y: f64,
    h: f64,
    v: f64,
    e: u32,
}

/// The electrodes of a text.
///
/// # Errors
/// What is wrong with it, as the rest of a sentence.
pub(super) fn read(text: &str, BoardLimits { most_channel, .. }: BoardLimits) -> Result<Vec<DrawnElectrode>, String> {
    let text = without_last_commas(text.trim_start_matches('\u{feff}'));
    let electrodes = match text.trim_start().starts_with('[') {
        true => opendrop(serde_json::from_str(&text).map_err(|error| fault(&error, "OpenDrop's electrodes"))?),
        false => purpledrop(serde_json::from_str(&text).map_err(|error| fault(&error, "a board of PurpleDrop"))?)?,
    };
    if electrodes.len() > MAX_ELECTRODES {
        return Err(format!("has {} electrodes; at most {MAX_ELECTRODES} are allowed", electrodes.len()));
    }
    if let Some(far) = electrodes.iter().find(|electrode| electrode.channel > most_channel) {
        return Err(format!("has a channel {}, but the last known channel is {most_channel}", far.channel));
    }
    let is_sound = |bounds: &[f64; 4]| {
        bounds.iter().all(|side| side.is_finite()) && bounds[0] < bounds[2] && bounds[1] < bounds[3]
    };
    if let Some(flat) = electrodes.iter().find(|electrode| !electrode.bounds.as_ref().is_none_or(is_sound)) {
        return Err(format!("has an electrode without an area, {}", flat.name));
    }
    Ok(electrodes)
}

/// Type names in errors of the JSON reader, each with a wording for users.
const EXPECTED: [(&str, &str); 9] = [
    ("expected u32", "expected a whole number from 0"),
    ("expected f64", "expected a number"),
    ("expected a sequence", "expected a list"),
    ("expected struct PurpledropFile", "expected an object with `layout`"),
    ("expected struct PurpledropLayout", "expected an object with `grid` or `grids`"),
    ("expected struct OpendropElectrode", "expected an object with `x`, `y`, `h`, `v` and `e`"),
    ("expected struct PitchedGrid", "expected an object with `origin`, `pitch` and `pins`"),
    ("expected struct PeripheralElectrode", "expected an object with `pin`"),
    ("expected struct Peripheral", "expected an object with `electrodes`"),
];

/// Fault of a text, with its line and column.
fn fault(error: &serde_json::Error, what: &str) -> String {
    let text = error.to_string();
    let why = text.rsplit_once(" at line ").map_or(text.as_str(), |(why, _)| why);
    let why = EXPECTED.iter().fold(why.to_owned(), |why, (word, plain)| why.replace(word, plain));
    format!("is not {what}, line {}, column {}: {why}", error.line(), error.column())
}

/// The same text with a blank for each trailing comma of a list or an object, as files of OpenDrop's program have them.
fn without_last_commas(text: &str) -> String {
    let mut kept = String::with_capacity(text.len());
    let (mut is_quoted, mut is_escaped) = (false, false);
    // Blanks after a comma that may be a trailing one.
    let mut held: Option<String> = None;
    for c in text.chars() {
        if let Some(blanks) = &mut held {
            if c.is_ascii_whitespace() {
                blanks.push(c);
                continue;
            }
            kept.push(if c == ']' || c == '}' { ' ' } else { ',' });
            kept.push_str(blanks);
            held = None;
        }
        if c == ',' && !is_quoted {
            held = Some(String::new());
            continue;
        }
        is_quoted ^= c == '"' && !is_escaped;
        is_escaped = is_quoted && c == '\\' && !is_escaped;
        kept.push(c);
    }
    if let Some(blanks) = held {
        kept.push(',');
        kept.push_str(&blanks);
    }
    kept
}

fn opendrop(list: Vec<OpendropElectrode>) -> Vec<DrawnElectrode> {
    let drawn = |OpendropElectrode { x, y, h, v, e }: OpendropElectrode| DrawnElectrode {
        name: format!("channel {e}"),
        channel: e,
        bounds: Some([x, y, x + h, y + v]),
    };
    list.into_iter().map(drawn).collect()
}

fn purpledrop(file: PurpledropFile) -> Result<Vec<DrawnElectrode>, String> {
    let PurpledropLayout { grid, grids, peripherals } = file.layout;
    let one = grid.map(|pins| PitchedGrid { origin: [0.0; 2], spacing: 1.0, pins });
    let mut electrodes = Vec::new();
    for PitchedGrid { origin: [left, top], spacing, pins } in one.into_iter().chain(grids) {
        let width = pins.first().map_or(0, Vec::len);
        // A forgotten place would shift all after it.
        if let Some((row, cells)) = pins.iter().enumerate().find(|(_, cells)| cells.len() != width) {
            let [row, places] = [row + 1, cells.len()];
            return Err(format!(
                "has a grid whose row {row} has a length of {places}, but its first row has {width}: write `null` where there is no electrode"
            ));
        }
        for (row, cells) in pins.into_iter().enumerate() {
            let pins = cells.into_iter().enumerate().filter_map(|(column, pin)| Some((column, pin?)));
            electrodes.extend(pins.map(|(column, pin)| {
                let [x, y] = [left + column as f64 * spacing, top + row as f64 * spacing];
                DrawnElectrode {
                    name: format!("pin {pin}"),
                    channel: pin,
                    bounds: Some([x, y, x + spacing, y + spacing]),
                }
            }));
        }
    }
    for Peripheral { class, id, electrodes: own } in peripherals {
        electrodes.extend(own.into_iter().map(|electrode| DrawnElectrode {
            name: format!("pin {} ({class} {} {})", electrode.pin, shown(&id), shown(&electrode.id)),
            channel: electrode.pin,
            bounds: None,
        }));
    }
    Ok(electrodes)
}

/// An identifier, which is a number or a string.
fn shown(id: &serde_json::Value) -> String {
    id.as_str().map_or_else(|| id.to_string(), str::to_owned)
}
