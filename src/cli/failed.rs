//! Page of a program that could not be built.

use super::arguments::{BuildArguments, ReportFormat};
use super::disk::{self, Destination};
use super::file_snapshots::FileSnapshots;
use super::formats::ChosenFormats;
use super::library::Disk;
use super::loaded::Loaded;
use super::{Exit, report, terminal};
use crate::compile;
use crate::diagnostic::{Diagnostic, Sink};
use crate::emit::{self, FAILED_ENDING, FailedProgram, Format, OutputFile, Provenance};
use crate::source::Sources;
use std::path::{Path, PathBuf};

/// Result of a failed build.
pub struct FailedBuild {
    pub exit: Exit,
    /// Path of the page that shows why.
    pub page: Option<PathBuf>,
}

impl From<Exit> for FailedBuild {
    fn from(exit: Exit) -> FailedBuild {
        FailedBuild { exit, page: None }
    }
}

/// Writes the page of a program whose errors were reported; returns its path.
pub fn write(
    loaded: &Loaded,
    arguments: &BuildArguments,
    sources: &Sources,
    errors: &Sink,
    provenance: &Provenance,
    inputs: &FileSnapshots,
) -> Result<PathBuf, Exit> {
    let part = compile::partial(&loaded.program(&loaded.disk()), errors);
    let failed = FailedProgram {
        part: part.as_ref().map(|part| (&part.verified, part.whole.as_ref())),
        errors,
        places: part.as_ref().map_or(&[], |part| &part.places),
        sources,
    };
    put_page(loaded.path(), &failed, arguments, provenance, inputs)
}

/// Reports that a program cannot be read. If open pages follow the program, writes a page that shows the error.
pub fn unread(program: &Path, why: Diagnostic, arguments: &BuildArguments, inputs: &FileSnapshots) -> FailedBuild {
    let (mut errors, sources) = (Sink::default(), Sources::default());
    errors.push(why);
    terminal::report(&errors, &sources, arguments.report.format);
    let has_pages = ChosenFormats::of(&arguments.emit).formats.contains(&Format::Html);
    let is_followed = arguments.watch && has_pages && arguments.output.join(follower(program)).is_file();
    let failed = FailedProgram { part: None, errors: &errors, places: &[], sources: &sources };
    let files = [(Disk::around(program).program_name(), String::new())].into();
    let provenance = Provenance { files, ..Provenance::default() };
    let page = is_followed.then(|| put_page(program, &failed, arguments, &provenance, inputs)).transpose();
    match page {
        Ok(page) => FailedBuild { exit: Exit::Files, page },
        Err(exit) => exit.into(),
    }
}

fn put_page(
    program: &Path,
    failed: &FailedProgram,
    arguments: &BuildArguments,
    provenance: &Provenance,
    inputs: &FileSnapshots,
) -> Result<PathBuf, Exit> {
    let report_format = arguments.report.format;
    let page = emit::failed_page(&stem(program), failed, provenance).map_err(|error| {
        terminal::report_one(error.diagnostic(), report_format);
        Exit::Errors
    })?;
    let mut files = vec![page];
    if arguments.watch {
        emit::follow(&mut files, &follower(program), provenance);
    }
    put(&files, &destination(program, arguments, inputs), report_format).map(|mut names| names.swap_remove(0))
}

/// Writes files; returns the path of each.
///
/// # Errors
/// The exit status, once the failure was reported.
pub fn put(files: &[OutputFile], to: &Destination, report_format: ReportFormat) -> Result<Vec<PathBuf>, Exit> {
    disk::write_all(to, files).map_err(|diagnostic| {
        terminal::report_one(*diagnostic, report_format);
        Exit::Files
    })?;
    Ok(files.iter().map(|file| disk::shown(to.folder, &file.name)).collect())
}

/// Reports the path of the page.
pub fn tell(program: &Path, page: Option<&Path>, arguments: &BuildArguments) {
    let Some(page) = page else { return };
    let page = page.to_string_lossy();
    let text = match arguments.report.format {
        ReportFormat::Json => format!("{}\n", report::json::failed(&program.to_string_lossy(), &page)),
        ReportFormat::Human | ReportFormat::Short | ReportFormat::Github => {
            terminal::line("Wrote", &page, 0, "what went wrong, and where")
        }
    };
    // The errors decide the exit status.
    let _ = terminal::success(&text, arguments.quiet);
}

/// Removes the page of an earlier failed build, because the program has now been built.
///
/// # Errors
/// The exit status, once it was reported that the page cannot be removed.
pub fn forget(program: &Path, arguments: &BuildArguments) -> Result<(), Exit> {
    let name = format!("{}.{FAILED_ENDING}", stem(program));
    disk::remove_own(&destination(program, arguments, &FileSnapshots::default()), &name).map_err(|diagnostic| {
        terminal::report_one(*diagnostic, arguments.report.format);
        Exit::Files
    })
}

fn destination<'a>(program: &'a Path, arguments: &'a BuildArguments, inputs: &'a FileSnapshots) -> Destination<'a> {
    Destination { folder: &arguments.output, program, logged: None, force: arguments.force, inputs }
}

/// Name of the script through which open pages follow a program.
pub fn follower(program: &Path) -> String {
    format!("{}.latest.js", stem(program))
}

/// Name of a program's file without its extension; `stdin` for standard input.
pub fn stem(program: &Path) -> String {
    let stem = program.file_stem().unwrap_or_default().to_string_lossy();
    stem.trim_matches(['<', '>']).to_owned()
}
