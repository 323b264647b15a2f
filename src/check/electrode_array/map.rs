//! The electrode map of a board, from the fields of the device: its channels and its disabled electrodes.

use super::cells::{on_board, whole_cell};
use super::errors;
use crate::check::devices::CheckedDevice;
use crate::check::figures::Figures;
use crate::check::labels::DeviceLabel;
use crate::check::value::{BoardFile, LeftOut, ListValue, Value, whole};
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell, ElectrodeMap, Electrodes, MAX_SHARING};
use crate::diagnostic::Sink;
use crate::quantity::count;
use std::collections::BTreeSet;
use std::rc::Rc;
use std::sync::Arc;

/// The board file that the device names.
fn board_file(device: &CheckedDevice) -> Option<&BoardFile> {
    match &device.fields.get("map")?.value {
        Value::Board(board) => Some(board),
        _ => None,
    }
}

/// Whether a field stands in the file that names the board; one inherited from a base in another file gives way to the
/// board.
fn stands_beside_map(name: &str, device: &CheckedDevice) -> bool {
    let file = |name: &str| device.fields.get(name).map(|field| field.span.file);
    file(name).is_some() && file(name) == file("map")
}

/// Columns and rows, from the board file if there is one, otherwise from the device's own fields; `None` after an
/// error.
pub fn sides(device: &CheckedDevice, sink: &mut Sink) -> Option<[u32; 2]> {
    let given = |name: &str| device.fields.count(name);
    let Some(board) = board_file(device) else { return Some([given("columns")?, given("rows")?]) };
    for (name, side) in [("columns", board.columns), ("rows", board.rows)] {
        let other = given(name).filter(|given| *given != side && stands_beside_map(name, device));
        if let Some(given) = other {
            let labels = [DeviceLabel::field(name, "differs from the file"), DeviceLabel::field("map", "this file")];
            sink.push(device.labelled(errors::side_of_map(name, given, board), labels));
            return None;
        }
    }
    Some([board.columns, board.rows])
}

/// The channel numbers of the board file; `None` after an error.
fn numbers(board: &BoardFile, device: &CheckedDevice, sink: &mut Sink) -> Option<Vec<Option<u32>>> {
    if stands_beside_map("channels", device) {
        let labels = [DeviceLabel::field("map", "here"), DeviceLabel::field("channels", "and here")];
        sink.push(device.labelled(errors::two_maps(), labels));
        return None;
    }
    if board.left_out != LeftOut::default() {
        let label = DeviceLabel::field("map", errors::names_left_out(&board.left_out));
        sink.push(device.labelled(errors::left_out(board), [label]));
    }
    Some(board.channels.clone())
}

/// The map of a device that has fields for one; `facts` are its facts without it. `None` after an error.
pub fn of(facts: &ElectrodeArrayFacts, device: &CheckedDevice, sink: &mut Sink) -> Option<Option<Arc<ElectrodeMap>>> {
    let list = |name: &str| match device.fields.get(name).map(|field| &field.value) {
        Some(Value::List(list)) => Some(Rc::clone(list)),
        _ => None,
    };
    if ["channels", "disabled", "map"].iter().any(|name| device.fields.get(*name).is_some_and(|f| f.value.is_unknown()))
    {
        return None;
    }
    let mut map = ElectrodeMap { columns: facts.columns, ..ElectrodeMap::default() };
    let (rows, disabled) = (list("channels"), list("disabled"));
    let board = board_file(device);
    if let Some(board) = board {
        map.channels = numbers(board, device, sink)?;
    } else if let Some(rows) = &rows {
        map.channels = channels(facts, rows, device, sink)?;
    }
    if let Some(disabled) = &disabled {
        map.disabled = dead(facts, &map, disabled, device, sink)?;
    }
    let has_gaps = map.channels.iter().any(Option::is_none) || !map.disabled.is_empty();
    sharing(facts, &map, device, sink)?;
    if facts.layout.electrodes == Electrodes::Quad && has_gaps {
        let gaps = if board.is_some() { "map" } else { "channels" };
        let field = if map.disabled.is_empty() { gaps } else { "disabled" };
        let label = DeviceLabel::field(field, "leaves electrodes out");
        sink.push(device.labelled(errors::microparts_need_all(), [label]));
        return None;
    }
    Some((board.is_some() || rows.is_some() || !map.disabled.is_empty()).then(|| Arc::new(map)))
}

/// Checks shared channels: they are for droplets only, since a pair of electrodes moves a micropart, and for at most
/// `MAX_SHARING` electrodes of a board.
fn sharing(facts: &ElectrodeArrayFacts, map: &ElectrodeMap, device: &CheckedDevice, sink: &mut Sink) -> Option<()> {
    let field = if board_file(device).is_some() { "map" } else { "channels" };
    let shared = || map.by_channel().into_iter().filter(|(_, cells)| cells.len() > 1);
    if facts.layout.electrodes == Electrodes::Quad
        && let Some((channel, cells)) = shared().next()
    {
        let label = DeviceLabel::field(field, format!("channel {channel} at {} and {}", cells[0], cells[1]));
        sink.push(device.labelled(errors::microparts_on_shared_channel(channel), [label]));
        return None;
    }
    let electrodes = shared().map(|(_, cells)| cells.len()).sum();
    if electrodes > MAX_SHARING {
        let label = DeviceLabel::field(field, format!("{electrodes} electrodes"));
        sink.push(device.labelled(errors::too_many_sharing(electrodes), [label]));
        return None;
    }
    Some(())
}

/// Channel number of each cell, row by row from row 1.
fn channels(
    facts: &ElectrodeArrayFacts,
    rows: &ListValue,
    device: &CheckedDevice,
    sink: &mut Sink,
) -> Option<Vec<Option<u32>>> {
    if rows.len() != facts.rows as usize {
        let labels =
            [DeviceLabel::field("channels", count(rows.len(), "row")), DeviceLabel::field("rows", "must match this")];
        sink.push(device.labelled(errors::rows_of_map(rows.len(), facts.rows), labels));
        return None;
    }
    let mut numbers = Vec::with_capacity(facts.columns as usize * facts.rows as usize);
    // The top row is written first.
    for (row, number) in rows.iter().rev().zip(1..) {
        let Value::List(cells) = &row.value else { return None };
        if cells.len() != facts.columns as usize {
            let labels = [
                DeviceLabel::cell(row.span, format!("row {number}")),
                DeviceLabel::field("columns", "must match this"),
            ];
            sink.push(device.labelled(errors::row_of_map(number, cells.len(), facts.columns), labels));
            return None;
        }
        for cell in cells.iter() {
            let channel = match &cell.value {
                Value::Quantity(count) => Some(u32::try_from(whole(*count)?).ok()?),
                _ => None,
            };
            numbers.push(channel);
        }
    }
    if numbers.iter().all(Option::is_none) {
        sink.push(device.labelled(errors::no_electrode(), [DeviceLabel::field("channels", "`none` at every place")]));
        return None;
    }
    Some(numbers)
}

/// The disabled electrodes, in order.
fn dead(
    facts: &ElectrodeArrayFacts,
    map: &ElectrodeMap,
    disabled: &ListValue,
    device: &CheckedDevice,
    sink: &mut Sink,
) -> Option<Vec<ElectrodeCell>> {
    let mut cells = BTreeSet::new();
    for element in disabled.iter() {
        let pair = whole_cell(&element.value);
        let cell = pair.and_then(|pair| on_board(pair, facts)).filter(|cell| map.has_electrode(*cell));
        let Some(cell) = cell else {
            let finding = errors::nothing_to_disable(facts, &element.value);
            sink.push(device.labelled(finding, [DeviceLabel::cell(element.span, "no electrode here")]));
            return None;
        };
        cells.insert(cell);
    }
    Some(cells.into_iter().collect())
}
