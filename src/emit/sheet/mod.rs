//! Bench sheets in Markdown: what to load before a schedule runs, what happens when, and what is there afterwards.
//!
//! `<name>.sheet.md` is for the person at the bench and for the notebook. No instrument reads it.

mod electrode_array;
mod holds;

use super::error::{EmitError, MAX_TEXT_BYTES};
use super::{Format, Provenance};
use crate::quantity::Quantity;
use crate::verify::Verified;
use std::fmt::Write as _;

/// The sheet of a schedule.
///
/// # Errors
/// [`EmitError::NothingToLoad`] for a schedule without droplets, [`EmitError::TooLarge`].
pub(super) fn write(verified: &Verified, provenance: &Provenance) -> Result<Vec<u8>, EmitError> {
    let schedule = verified.schedule();
    let boards = electrode_array::boards(verified);
    if boards.is_empty() {
        return Err(EmitError::NothingToLoad { name: schedule.name.clone() });
    }
    let mut sheet = Sheet::default();
    sheet.line(&format!("# {}", schedule.name));
    let with: String = schedule.source.settings.iter().map(|setting| format!(" with `{setting}`,")).collect();
    let file = provenance.files.first().map_or(String::new(), |(name, _)| format!("`{name}`,{with} "));
    let (lasts, version) = (time(schedule.duration_ns), env!("CARGO_PKG_VERSION"));
    sheet.paragraph(&format!(
        "{file}{lasts}, verified by tweeze {version}. Droplets are counted as reservoirs dispense them."
    ));
    for board in &boards {
        board.load(&mut sheet);
    }
    sheet.line("\n## Run");
    if let Some(text) = holds::of_times(&schedule.holds) {
        sheet.paragraph(&text);
    }
    sheet.table(["from", "to", "on", "what happens"], electrode_array::run(verified, &boards));
    for board in &boards {
        board.leave(&mut sheet);
    }
    EmitError::refuse_size(Format::Sheet, sheet.text.len() as u64, MAX_TEXT_BYTES)?;
    Ok(sheet.text.into_bytes())
}

/// An event on a device.
struct SheetRow<'v> {
    /// Start and end on the clock, in nanoseconds.
    times: [u64; 2],
    /// The end as written.
    end: String,
    device: &'v str,
    text: String,
}

/// A Markdown text in progress.
#[derive(Debug, Default)]
struct Sheet {
    text: String,
}

impl Sheet {
    fn line(&mut self, line: &str) {
        let _ = writeln!(self.text, "{line}");
    }

    fn paragraph(&mut self, text: &str) {
        let _ = writeln!(self.text, "\n{text}");
    }

    /// Writes a table with as many columns as its head.
    fn table<const COLUMNS: usize>(
        &mut self,
        head: [&str; COLUMNS],
        rows: impl IntoIterator<Item = [String; COLUMNS]>,
    ) {
        let _ = writeln!(self.text, "\n| {} |", head.join(" | "));
        let _ = writeln!(self.text, "|{}", "---|".repeat(COLUMNS));
        for row in rows {
            let _ = writeln!(self.text, "| {} |", row.join(" | "));
        }
    }
}

/// `20.4 s`
fn time(ns: u64) -> String {
    Quantity::time_ns(ns).to_string()
}
