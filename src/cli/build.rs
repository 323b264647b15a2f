//! `tweeze build`.

use super::arguments::{BuildArguments, Invocation, ReportFormat};
use super::disk::{self, Destination};
use super::failed::{self, FailedBuild};
use super::file_snapshots::FileSnapshots;
use super::formats::ChosenFormats;
use super::loaded::Loaded;
use super::report::{Detail, LiveReport, ReportedBuild, Totals, WrittenSchedule};
use super::{Exit, errors, report, signals, terminal, verify, watch};
use crate::check::Options;
use crate::compile::{self, CompileOutcome, Compiled};
use crate::diagnostic::Sink;
use crate::emit::{self, Format, OutputFile, Provenance};
use crate::source::{Origin, Sources};
use crate::verify::Verified;
use clap::CommandFactory;
use clap::error::ErrorKind;
use std::path::{Path, PathBuf};

/// Builds each program and writes its complete set of files, or nothing; returns the gravest exit status.
pub fn run(arguments: &BuildArguments) -> Exit {
    if arguments.files.iter().filter(|file| disk::is_standard_input(file)).count() > 1 {
        return misused("build", "standard input contains one program: `-` can be given only once");
    }
    if !arguments.watch {
        return build(arguments, &mut FileSnapshots::default());
    }
    if arguments.files.iter().any(|file| disk::is_standard_input(file)) {
        return misused("build", "standard input contains one program, which does not change: --watch needs a file");
    }
    watch::watch(&arguments.files, arguments.quiet, |needed| build(arguments, needed))
}

/// Builds each program; adds the files that they need to `needed`.
fn build(arguments: &BuildArguments, needed: &mut FileSnapshots) -> Exit {
    let mut totals = Totals::of(arguments.files.len());
    let one = |file: &PathBuf| match built(file, arguments, needed) {
        Ok(built) => {
            totals.add(built.schedules, built.files.len());
            built.exit
        }
        Err(FailedBuild { exit, page }) => {
            failed::tell(file, page.as_deref(), arguments);
            exit
        }
    };
    let exit = arguments.files.iter().map(one).fold(Exit::Done, Exit::max);
    match arguments.report.format {
        ReportFormat::Json => exit,
        ReportFormat::Human | ReportFormat::Short | ReportFormat::Github => {
            exit.max(terminal::success(&totals.line(), arguments.quiet))
        }
    }
}

/// A program that was built and whose files were written.
pub struct BuiltProgram {
    /// Exit status of printing the report.
    pub exit: Exit,
    pub schedules: usize,
    /// Paths of the files.
    pub files: Vec<PathBuf>,
}

/// Builds a program, writes its files and reports both as it proceeds; adds the files that it needs to `needed`.
///
/// # Errors
/// The exit status, once the diagnostics were reported, with the page that shows them if pages were requested.
pub fn built(file: &Path, arguments: &BuildArguments, needed: &mut FileSnapshots) -> Result<BuiltProgram, FailedBuild> {
    signals::catch();
    let format = arguments.report.format;
    let chosen = ChosenFormats::of(&arguments.emit);
    if arguments.at.is_some() && !chosen.formats.contains(&Format::Svg) {
        return Err(misused("build", "--at draws one instant of a picture: it needs --emit svg").into());
    }
    disk::try_folder(&arguments.output).map_err(|diagnostic| {
        terminal::report_one(*diagnostic, format);
        Exit::Files
    })?;
    let options = Options { settings: arguments.settings.set.clone(), only: arguments.task.clone() };
    let loaded = match Loaded::open(file, options) {
        Ok(loaded) => loaded,
        Err(why) => return Err(failed::unread(file, *why, arguments, needed)),
    };
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let mut live = LiveReport::begin(ReportedBuild {
        program: loaded.path(),
        settings: &loaded.options.settings,
        output: &arguments.output,
        formats: &chosen.formats,
        is_printed: !arguments.quiet.is_quiet && format != ReportFormat::Json,
        detail: if arguments.verbose { Detail::Full } else { Detail::Usual },
    });
    let disk = loaded.disk();
    let search = live.search();
    let kept = arguments.keep_best.then(|| signals::keep_best(&search));
    let outcome = search.over(|| compile::compile(&loaded.program(&disk), &mut sources, &mut sink, &mut live));
    drop(kept);
    needed.add(disk.asked());
    live.end_planning();
    terminal::report(&sink, &sources, format);
    let provenance = provenance(&sources, &loaded.options);
    let exit = match outcome {
        CompileOutcome::Compiled(compiled) => {
            let written = write(loaded.path(), arguments, &chosen, live, compiled, &provenance, needed)?;
            failed::forget(loaded.path(), arguments)?;
            return Ok(written);
        }
        CompileOutcome::Errors => Exit::Errors,
        CompileOutcome::Refused => Exit::Refused,
    };
    let is_shown = chosen.formats.contains(&Format::Html);
    let page = is_shown.then(|| failed::write(&loaded, arguments, &sources, &sink, &provenance, needed)).transpose()?;
    Err(FailedBuild { exit, page })
}

/// Wrong usage that clap cannot detect.
pub fn misused(name: &str, what: &str) -> Exit {
    let mut command = Invocation::command();
    let own = command.find_subcommand_mut(name).map(std::mem::take).unwrap_or(command);
    // A closed pipe is ignored, as with all wrong usage.
    let _ = own.bin_name(format!("tweeze {name}")).error(ErrorKind::MissingRequiredArgument, what).print();
    Exit::Usage
}

/// The user's files of a program; the standard library comes with the compiler, and settings are not files.
pub fn provenance(sources: &Sources, options: &Options) -> Provenance {
    let own = sources.files().filter(|(_, file)| file.origin == Origin::User);
    let files = own.map(|(_, file)| (file.name.clone(), file.text.to_string())).collect();
    Provenance { files, settings: options.settings.clone(), is_recorded: false }
}

fn write(
    program: &Path,
    arguments: &BuildArguments,
    chosen: &ChosenFormats,
    live: LiveReport,
    compiled: Compiled,
    provenance: &Provenance,
    inputs: &FileSnapshots,
) -> Result<BuiltProgram, Exit> {
    let report_format = arguments.report.format;
    let mut files: Vec<OutputFile> = Vec::new();
    let mut written: Vec<WrittenSchedule> = Vec::new();
    let mut schedules = Vec::with_capacity(compiled.schedules.len());
    for verified in compiled.schedules {
        let mut own: Vec<OutputFile> = Vec::new();
        let mut left_out: Vec<(Format, String)> = Vec::new();
        for format in &chosen.formats {
            let set = match (format, arguments.at) {
                (Format::Svg, Some(t_ns)) => emit::picture_at(&verified, t_ns),
                (_, _) => emit::emit(*format, &verified, provenance),
            };
            match set {
                Ok(set) => own.extend(set),
                Err(error) if !chosen.is_named(*format) && error.is_unsupported_by_format() => {
                    left_out.push((*format, error.diagnostic().title));
                }
                Err(error) => {
                    terminal::report_one(error.diagnostic(), report_format);
                    return Err(Exit::Errors);
                }
            }
        }
        schedules.push(read_back(verified, &own, report_format)?);
        let paths = own.iter().map(|file| disk::shown(&arguments.output, &file.name)).collect();
        written.push(WrittenSchedule { paths, left_out });
        files.extend(own);
    }
    if arguments.watch {
        emit::follow(&mut files, &failed::follower(program), provenance);
    }
    let compiled = Compiled { tally: compiled.tally, schedules };
    let to = Destination { folder: &arguments.output, program, logged: None, force: arguments.force, inputs };
    if let Err(diagnostic) = disk::write_all(&to, &files) {
        terminal::report_one(*diagnostic, report_format);
        return Err(Exit::Files);
    }
    let mut exit = live.wrote(&compiled.schedules, &written);
    if report_format == ReportFormat::Json {
        let settings = &arguments.settings.set;
        let report = report::json::built(&program.to_string_lossy(), &compiled, settings, &written);
        exit = exit.max(terminal::success(&format!("{report}\n"), arguments.quiet));
    }
    let files = written.into_iter().flat_map(|written| written.paths).collect();
    Ok(BuiltProgram { exit, schedules: compiled.schedules.len(), files })
}

/// Verifies the log of a schedule from its bytes, as `tweeze verify` would, so that whatever is written can be read.
/// The schedule read back replaces the one written, so that only one is in memory at a time.
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
