//! Output to the terminal: diagnostics, report lines, results.

use super::Exit;
use super::arguments::{ColourChoice, QuietArgument, ReportFormat};
use crate::diagnostic::plain::{plain, shortened};
use crate::diagnostic::render::{self, Characters, Colour, Look};
use crate::diagnostic::{Diagnostic, Sink, machine};
use crate::source::Sources;
use std::io::{self, IsTerminal, Write};
use std::sync::OnceLock;

/// Width of a report that does not go to a terminal.
const PIPE_WIDTH: usize = 100;

/// Least width of a report.
const LEAST_WIDTH: usize = 40;

/// The choice made on the command line, once it is parsed.
static COLOUR: OnceLock<ColourChoice> = OnceLock::new();

/// Sets when colours are used; until then they depend on the terminal.
pub fn choose_colour(choice: ColourChoice) {
    // Set only once, because the command line is parsed once.
    let _ = COLOUR.set(choice);
}

/// Whether a stream gets colours.
fn is_coloured(stream: &impl IsTerminal) -> bool {
    let is_wanted = || std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty()) && !is_dumb();
    match COLOUR.get().copied().unwrap_or(ColourChoice::Auto) {
        ColourChoice::Auto => stream.is_terminal() && is_wanted(),
        ColourChoice::Always => true,
        ColourChoice::Never => false,
    }
}

/// Writes every diagnostic of a sink to standard error.
pub fn report(sink: &Sink, sources: &Sources, format: ReportFormat) {
    let mut text = String::new();
    let look = look();
    for diagnostic in sink.sorted() {
        text.push_str(&match format {
            ReportFormat::Human => render::human(diagnostic, sources, look),
            ReportFormat::Short => machine::short_line(diagnostic, sources),
            ReportFormat::Json => machine::json_line(diagnostic, sources),
            ReportFormat::Github => machine::github_line(diagnostic, sources),
        });
        text.push('\n');
    }
    if sink.dropped() > 0 && matches!(format, ReportFormat::Human | ReportFormat::Short) {
        text.push_str(&format!("and {} more\n", sink.dropped()));
    }
    if let Some(counted) = render::counted(sink).filter(|_| format == ReportFormat::Human) {
        text.push_str(&format!("{counted}\n"));
    }
    to_stderr(&text);
}

/// Writes one diagnostic that belongs to no program.
pub fn report_one(diagnostic: Diagnostic, format: ReportFormat) {
    let mut sink = Sink::default();
    sink.push(diagnostic);
    report(&sink, &Sources::default(), format);
}

fn look() -> Look {
    let width = columns().unwrap_or(PIPE_WIDTH).max(LEAST_WIDTH);
    Look {
        colour: if is_coloured(&io::stderr()) { Colour::Ansi } else { Colour::Plain },
        characters: if is_dumb() { Characters::Ascii } else { Characters::Unicode },
        width,
    }
}

fn is_dumb() -> bool {
    std::env::var_os("TERM").is_some_and(|term| term == "dumb")
}

/// The width set by `COLUMNS`, otherwise that of the terminal on standard error.
fn columns() -> Option<usize> {
    let from_environment = std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok());
    from_environment.or_else(|| console::Term::stderr().size_checked().map(|(_, columns)| usize::from(columns)))
}

/// Writes a text to standard error.
pub fn to_stderr(text: &str) {
    // If standard error is gone, the failure cannot be reported either.
    let _ = io::stderr().lock().write_all(text.as_bytes());
}

/// Reports that Tweeze itself failed.
pub fn fault(what: &str) -> Exit {
    to_stderr(&format!(
        "tweeze: {what}; this is a fault of Tweeze, not of the program: please report it with the program\n"
    ));
    Exit::Fault
}

/// Writes an answer to standard output; a reader that has gone away, such as `head`, is not an error.
pub fn answer(text: &str) -> Exit {
    match io::stdout().lock().write_all(text.as_bytes()).and_then(|()| io::stdout().flush()) {
        Ok(()) => Exit::Done,
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Exit::Done,
        Err(error) => {
            to_stderr(&format!("tweeze: standard output cannot be written: {error}\n"));
            Exit::Files
        }
    }
}

/// Writes a report of success to standard output, unless only errors and warnings are wanted.
pub fn success(text: &str, quiet: QuietArgument) -> Exit {
    if quiet.is_quiet { Exit::Done } else { answer(text) }
}

/// Greatest number of characters of a name in a report.
const MAX_NAME_CHARACTERS: usize = 200;

/// A name as a report shows it: it cannot control the terminal or begin a new line.
pub fn name(text: &str) -> String {
    plain(&shortened(text, MAX_NAME_CHARACTERS)).into_owned()
}

/// A line of a build report: action, object and result.
pub fn line(verb: &str, subject: &str, subject_width: usize, text: &str) -> String {
    let verb = format!("{verb:>9}");
    let verb = if is_coloured(&io::stdout()) { format!("\x1b[1;32m{verb}\x1b[0m") } else { verb };
    let (subject, text) = (name(subject), plain(text));
    let line = format!("{verb}  {subject:<subject_width$}  {text}");
    format!("{}\n", line.trim_end())
}

/// Rows in columns, each as wide as its widest entry, separated by two spaces and indented by two; numbers are
/// right-aligned, except in the last column.
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
