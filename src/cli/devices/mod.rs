//! `tweeze devices`: the kinds, the vocabulary of one of them, the devices of a program, and suggested voltage tables.

mod beds;
mod hands;
mod program;
mod vocabulary;

use super::arguments::DevicesArguments;
use super::{Exit, terminal};
use crate::check::scope::nearest;
use crate::device::Kind;
use std::path::Path;

/// Lists the kinds, all that one offers, or the devices of a program; or finds a table.
pub fn run(arguments: &DevicesArguments) -> Exit {
    if arguments.suggest.is_some() {
        return beds::suggest(arguments);
    }
    let Some(subject) = &arguments.subject else { return terminal::answer(&vocabulary::kinds()) };
    if let Some(kind) = Kind::find(subject) {
        return terminal::answer(&vocabulary::page(kind.vocabulary()));
    }
    if is_file(subject) {
        return program::run(Path::new(subject), arguments);
    }
    let near = nearest(subject, Kind::ALL.iter().map(|kind| kind.name()));
    let near = near.map_or(String::new(), |near| format!("; did you mean `{near}`?"));
    eprintln!("no device kind is named `{subject}`{near}\n`tweeze devices` lists them all");
    Exit::Usage
}

/// Whether a word is meant as a file and not as a kind.
fn is_file(subject: &str) -> bool {
    let path = Path::new(subject);
    path.extension().is_some() || path.components().count() > 1 || path.is_file()
}

/// Rows in columns, each as wide as its widest entry, two blanks apart and two from the margin; numbers stand at the right, but
/// for those of the last column.
pub fn aligned(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let entries = |column: usize| rows.iter().filter_map(move |row| row.get(column));
    let width = |column: usize| entries(column).map(|entry| entry.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut text = String::new();
    for row in rows {
        let mut line = String::new();
        for (column, (entry, &width)) in row.iter().zip(&widths).enumerate() {
            let is_number = entry.starts_with(|c: char| c.is_ascii_digit()) && column + 1 < columns;
            line.push_str("  ");
            line.push_str(&if is_number { format!("{entry:>width$}") } else { format!("{entry:<width$}") });
        }
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}
