//! `tweeze build`.

use super::arguments::{BuildArguments, Invocation, ReportFormat};
use super::disk::{self, Destination};
use super::loaded::Loaded;
use super::waiting::ProgressLine;
use super::{Exit, errors, report, signals, terminal, verify};
use crate::check::Options;
use crate::compile::{self, CompileOutcome, Compiled};
use crate::diagnostic::Sink;
use crate::emit::{self, Format, OutputFile, Provenance};
use crate::source::{Origin, Sources};
use crate::verify::Verified;
use clap::CommandFactory;
use clap::error::ErrorKind;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Builds a program and writes the whole set of its files, or nothing.
pub fn run(arguments: &BuildArguments) -> Exit {
    built(arguments).map_or_else(|exit| exit, |(report, _)| terminal::answer(&report))
}

/// Builds a program and writes its files; the report, and where the files stand.
///
/// # Errors
/// The exit status, once the diagnostics were reported.
pub fn built(arguments: &BuildArguments) -> Result<(String, Vec<PathBuf>), Exit> {
    signals::catch();
    let format = arguments.report.format;
    if arguments.at.is_some() && !arguments.emit.contains(&Format::Svg) {
        return Err(misused("--at draws one instant of a picture: it needs --emit svg"));
    }
    let options = Options { settings: arguments.settings.set.clone(), only: arguments.task.clone() };
    let loaded = Loaded::read(&arguments.file, options, &arguments.report)?;
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let waiting = ProgressLine::begin();
    let outcome =
        compile::compile(&loaded.program(&loaded.disk()), &mut sources, &mut sink, &mut |index, count, task| {
            waiting.at(index, count, task)
        });
    drop(waiting);
    terminal::report(&sink, &sources, format);
    match outcome {
        CompileOutcome::Errors => Err(Exit::Errors),
        CompileOutcome::Refused => Err(Exit::Refused),
        CompileOutcome::Compiled(compiled) => write(arguments, compiled, &provenance(&sources, &loaded.options)),
    }
}

/// Wrong usage that the command line's own grammar does not know.
fn misused(what: &str) -> Exit {
    let mut command = Invocation::command();
    let build = command.find_subcommand_mut("build").map(std::mem::take);
    // A closed pipe is ignored, as with all wrong usage.
    let _ = build.unwrap_or(command).bin_name("tweeze build").error(ErrorKind::MissingRequiredArgument, what).print();
    Exit::Usage
}

/// The user's files of a program; the standard library comes with the compiler, and settings are no files.
pub fn provenance(sources: &Sources, options: &Options) -> Provenance {
    let own = sources.files().filter(|(_, file)| file.origin == Origin::User);
    let files = own.map(|(_, file)| (file.name.clone(), file.text.to_string())).collect();
    Provenance { files, settings: options.settings.clone() }
}

fn write(
    arguments: &BuildArguments,
    compiled: Compiled,
    provenance: &Provenance,
) -> Result<(String, Vec<PathBuf>), Exit> {
    let formats: BTreeSet<Format> = arguments.emit.iter().copied().collect();
    let mut files: Vec<OutputFile> = Vec::new();
    let mut written: Vec<Vec<PathBuf>> = Vec::new();
    let mut schedules = Vec::with_capacity(compiled.schedules.len());
    for verified in compiled.schedules {
        let mut own: Vec<OutputFile> = Vec::new();
        for format in &formats {
            let set = match (format, arguments.at) {
                (Format::Svg, Some(t_ns)) => emit::picture_at(&verified, t_ns),
                (_, _) => emit::emit(*format, &verified, provenance),
            };
            match set {
                Ok(set) => own.extend(set),
                Err(error) => {
                    terminal::report_one(error.diagnostic(), arguments.report.format);
                    return Err(Exit::Errors);
                }
            }
        }
        schedules.push(read_back(verified, &own, arguments.report.format)?);
        written.push(own.iter().map(|file| shown(&arguments.output, &file.name)).collect());
        files.extend(own);
    }
    let compiled = Compiled { tally: compiled.tally, schedules };
    let to = Destination { folder: &arguments.output, program: &arguments.file, force: arguments.force };
    if let Err(diagnostic) = disk::write_all(&to, &files) {
        terminal::report_one(*diagnostic, arguments.report.format);
        return Err(Exit::Files);
    }
    let settings = &arguments.settings.set;
    let names = |paths: &Vec<PathBuf>| paths.iter().map(|path| path.to_string_lossy().into_owned()).collect();
    let names: Vec<Vec<String>> = written.iter().map(names).collect();
    let report = match arguments.report.format {
        ReportFormat::Json => {
            let file = arguments.file.to_string_lossy();
            format!("{}\n", report::json::built(&file, &compiled, settings, &names))
        }
        ReportFormat::Human | ReportFormat::Short | ReportFormat::Github => {
            report::build(&arguments.file, &compiled, settings, &names)
        }
    };
    Ok((report, written.concat()))
}

/// Verifies the log of a schedule from its bytes, as `tweeze verify` would: whatever is written can be read. The schedule read back replaces
/// the one written, so that only one is in memory at a time.
fn read_back(verified: Verified, set: &[OutputFile], report: ReportFormat) -> Result<Verified, Exit> {
    let Some(file) = set.iter().find(|file| file.name.ends_with(".mcap")) else { return Ok(verified) };
    drop(verified);
    match verify::judge_bytes(Path::new(&file.name), &file.bytes) {
        Ok(judged) => Ok(judged.verified),
        Err(refusal) => {
            terminal::report(&refusal.sink, &refusal.sources, report);
            terminal::report_one(errors::unverifiable(&file.name), report);
            Err(Exit::Fault)
        }
    }
}

/// Where a file stands, as the user would write it.
pub fn shown(folder: &Path, name: &str) -> PathBuf {
    if folder == Path::new(".") { PathBuf::from(name) } else { folder.join(name) }
}
