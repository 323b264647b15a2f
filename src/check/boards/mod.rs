//! Board files: finds those that a program names, reads each once, and turns its electrodes into cells.
//!
//! Three formats are recognised by their content: board definitions of PurpleDrop, the list of electrodes of OpenDrop's
//! program, and device files of MicroDrop. The largest connected set of electrodes on one lattice becomes the cells.
//! Electrodes off the lattice or disconnected from that set are left out, and so are all that share a channel with one
//! of these.

mod json;
mod lattice;
mod paths;
mod svg;

use super::scope::Scope;
use super::value::{BoardFile, Value};
use super::{Checker, errors};
use crate::device::BoardLimits;
use crate::syntax::tree::{self, Expr, ExprKind, Item, Text};
use std::rc::Rc;

/// Field that names a board file.
const FIELD: &str = "map";

/// Most electrodes of a file, shared channels included.
const MAX_ELECTRODES: usize = 8192;

/// An electrode as a file draws it.
#[derive(Debug, Clone, PartialEq)]
struct DrawnElectrode {
    name: String,
    channel: u32,
    /// Left, top, right and bottom in a unit of the file, y downwards; `None` where the file lists it apart from its
    /// lattice.
    bounds: Option<[f64; 4]>,
}

/// The strings of a file that name boards: those after `map:` in its devices.
pub fn named(tree: &tree::Tree) -> Vec<&Text> {
    let devices = tree.items.iter().filter_map(|item| {
        let Item::Device(device) = item else { return None };
        Some(device)
    });
    let fields = devices.flat_map(|device| &device.fields).filter(|field| field.name.text == FIELD);
    fields
        .filter_map(|field| match &field.value.kind {
            ExprKind::Text(text) => Some(text),
            _ => None,
        })
        .collect()
}

/// The board of a file.
///
/// # Errors
/// What is wrong with the file, as the rest of a sentence that begins with its name.
fn read(path: &str, text: &str, limits: BoardLimits) -> Result<BoardFile, String> {
    let written = text.trim_start_matches('\u{feff}').trim_start();
    if written.is_empty() {
        return Err("is empty".to_owned());
    }
    let is_svg = written.starts_with('<');
    let electrodes = if is_svg { svg::read(text, limits)? } else { json::read(text, limits)? };
    if electrodes.is_empty() {
        let looked_for = match is_svg {
            true => "no path with `data-channels`",
            false => "neither a `grid` or `grids` of pins in its `layout`, nor a list of electrodes",
        };
        return Err(format!("has no electrode with a channel: {looked_for}"));
    }
    lattice::board(path, electrodes, limits)
}

impl Checker<'_> {
    /// The board of a file that was read with the program; `None` after an error.
    pub fn accept_board(&mut self, limits: BoardLimits, expr: &Expr, scope: &Scope) -> Option<Value> {
        let key = self.named_file(expr, scope, errors::board_file_not_plain)?;
        if !self.boards.contains_key(&key) {
            // A file that could not be read was reported where the program was loaded.
            let text = self.modules[scope.module].named_files.get(&key.1)?;
            let board = match read(&key.1, text, limits) {
                Ok(board) => Some(Rc::new(board)),
                Err(fault) => {
                    self.sink.push(errors::bad_board(expr.span, &key.1, &fault));
                    None
                }
            };
            self.boards.insert(key.clone(), board);
        }
        self.boards.get(&key).cloned().flatten().map(Value::Board)
    }
}

#[cfg(test)]
mod tests;
