//! Runs one text or log through the compiler and detects the forbidden outcomes.

use tweeze::check::Options;
use tweeze::check::imports::{FileFault, Library};
use tweeze::compile::{self, CompileObserver, CompileOutcome, ProgramSource};
use tweeze::diagnostic::{Sink, SourceEdit, machine, render};
use tweeze::emit::{self, EmitError, FailedProgram, Format, Provenance, mcap};
use tweeze::log;
use tweeze::schedule::SourceRef;
use tweeze::source::{FileId, Origin, Sources, beside};
use tweeze::verify::{self, Verdict, Verified};

/// The name of every program.
const NAME: &str = "fuzz.twz";

const LOOK: render::Look =
    render::Look { colour: render::Colour::Plain, characters: render::Characters::Unicode, width: 100 };

/// Files by name, as a log carries them.
struct Carried<'a>(&'a [(String, String)]);

impl Library for Carried<'_> {
    fn read(&self, from: &str, path: &str) -> Result<(String, String), FileFault> {
        let name = beside(from, path);
        let text = self.0.iter().find(|file| file.0 == name).map(|file| file.1.clone());
        text.map(|text| (name, text)).ok_or_else(|| "there is no such file".into())
    }
}

/// Outcome of a build.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Built {
    /// The program has errors; the code of the first one.
    Errors(&'static str),
    /// It was written and its logs verified.
    Verified,
    /// A forbidden outcome.
    Fault(String),
}

/// Parses a text.
pub fn parse(text: &str) {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let file = sources.add(NAME, text);
    tweeze::syntax::parse(file, text, &mut sink);
    draw(&sink, &sources);
    if text.len().is_multiple_of(4) {
        format(text, sink.errors());
    }
}

/// Formats a text: the canonical text must be its own canonical form and have as many errors.
fn format(text: &str, errors: usize) {
    let mut sink = Sink::default();
    let once = tweeze::format::format(FileId(0), text, &mut Sink::default());
    let twice = tweeze::format::format(FileId(0), &once, &mut sink);
    assert_eq!(once, twice, "another canonical text");
    assert_eq!(errors, sink.errors(), "another number of errors");
}

fn draw(sink: &Sink, sources: &Sources) {
    for diagnostic in sink.sorted().into_iter().take(20) {
        render::human(diagnostic, sources, LOOK);
        machine::json_line(diagnostic, sources);
    }
}

/// Checks a board with a map, given by file name and text.
pub fn check_map(name: &str, map: &str) -> Result<bool, String> {
    let program = format!(
        "use std.electrode_array as ea\ndevice chip : ea.droplet_chip {{ map: \"{name}\" }}\n\
         scene bench {{ part drop : ea.droplet at (1, 1) }}\ntask go on chip in bench {{ move drop to (2, 1) }}\n"
    );
    check(&program, &[(name.to_owned(), map.to_owned())])
}

/// Checks a text with other files beside it: a program is returned if and only if no error was reported.
pub fn check(text: &str, files: &[(String, String)]) -> Result<bool, String> {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let options = Options::default();
    let program = ProgramSource { name: NAME, text, library: &Carried(files), options: &options };
    let checked = compile::check_program(&program, &mut sources, &mut sink);
    draw(&sink, &sources);
    let own = |edit: &SourceEdit| sources.file(edit.span.file).name == NAME;
    let wrong = sink.sorted().into_iter().find(|one| one.fix.iter().any(own) && one.apply_fix(text).is_none());
    if let Some(wrong) = wrong {
        return Err(format!("edits that cannot be made: {wrong:?}"));
    }
    match checked.is_some() == (sink.errors() == 0) {
        true => Ok(checked.is_some()),
        false => Err(format!("{} errors, and a program {}", sink.errors(), checked.is_some())),
    }
}

/// Reports the number of each task when its planning begins.
struct CountedTasks<'a> {
    begun: u64,
    next: &'a mut dyn FnMut(u64),
}

impl CompileObserver for CountedTasks<'_> {
    fn planning(&mut self, _: usize, _: usize, _: &str) {
        self.begun += 1;
        (self.next)(self.begun);
    }
}

/// Runs a text through all stages; `next` is called before each task is planned, with its number from 1.
pub fn build(text: &str, next: &mut dyn FnMut(u64)) -> Built {
    let mut tasks = CountedTasks { begun: 0, next };
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let options = Options::default();
    let program = ProgramSource { name: NAME, text, library: &Carried(&[]), options: &options };
    let outcome = compile::compile(&program, &mut sources, &mut sink, &mut tasks);
    draw(&sink, &sources);
    let first = |sink: &Sink| {
        sink.sorted().into_iter().find(|diagnostic| diagnostic.is_error()).map(|d| (d.code.name(), d.title.clone()))
    };
    match outcome {
        CompileOutcome::Errors => match first(&sink) {
            Some((code, _)) if !code.starts_with("E07") => {
                tasks.planning(0, 0, "");
                shown(&program, &sources, &sink).map_or_else(Built::Fault, |()| Built::Errors(code))
            }
            other => Built::Fault(format!("no error of the program stops it: {other:?}")),
        },
        CompileOutcome::Refused => {
            let (code, title) = first(&sink).unwrap_or_default();
            Built::Fault(format!("refused: {code} {title}"))
        }
        CompileOutcome::Compiled(compiled) => {
            match compiled.schedules.iter().find_map(|one| written(one, &sources).err()) {
                Some(fault) => Built::Fault(fault),
                None => Built::Verified,
            }
        }
    }
}

/// Draws the page of a program with errors.
fn shown(program: &ProgramSource, sources: &Sources, errors: &Sink) -> Result<(), String> {
    let part = compile::partial(program, errors);
    let failed = FailedProgram {
        part: part.as_ref().map(|part| (&part.verified, part.whole.as_ref())),
        errors,
        places: part.as_ref().map_or(&[], |part| &part.places),
        sources,
    };
    match emit::failed_page("fuzz", &failed, &provenance(sources)) {
        Err(EmitError::Failed { detail, .. }) => Err(format!("no page: {detail}")),
        Err(EmitError::NotFinite) => Err("a number that is not finite in a part that was verified".to_owned()),
        // Only a program that is too large has no page.
        Ok(_) | Err(_) => Ok(()),
    }
}

/// Writes a schedule in every format and verifies its log.
fn written(verified: &Verified, sources: &Sources) -> Result<(), String> {
    let provenance = provenance(sources);
    for format in Format::ALL {
        match emit::emit(*format, verified, &provenance) {
            Ok(files) if *format == Format::Mcap => {
                let bytes = files.first().map(|file| file.bytes.as_slice()).unwrap_or_default();
                verify(bytes).map_err(|why| format!("own log: {why}"))?;
            }
            Ok(_) => {}
            Err(EmitError::Failed { format, detail }) => {
                return Err(format!("not written: {}: {detail}", format.name()));
            }
            Err(EmitError::NotFinite) => return Err("a number that is not finite in a verified schedule".to_owned()),
            // Each format reports what it cannot represent.
            Err(_) => {}
        }
    }
    Ok(())
}

/// The files and settings that a log of a build contains.
fn provenance(sources: &Sources) -> Provenance {
    let own = sources.files().filter(|(_, file)| file.origin == Origin::User);
    let files = own.map(|(_, file)| (file.name.clone(), file.text.to_string())).collect();
    Provenance { files, settings: Vec::new(), is_recorded: false }
}

/// The log of the first schedule of a text; `None` if it does not build.
pub fn log_of(text: &str) -> Option<Vec<u8>> {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let options = Options::default();
    let program = ProgramSource { name: NAME, text, library: &Carried(&[]), options: &options };
    let outcome = compile::compile(&program, &mut sources, &mut sink, &mut ());
    let CompileOutcome::Compiled(compiled) = outcome else { return None };
    let files = emit::emit(Format::Mcap, compiled.schedules.first()?, &provenance(&sources)).ok()?;
    Some(files.into_iter().next()?.bytes)
}

/// Verifies a log from its bytes alone.
pub fn verify(bytes: &[u8]) -> Result<(), String> {
    let log = log::read(bytes).map_err(|error| error.diagnostic().title)?;
    let (name, text) = &log.files[0];
    let options = Options { settings: log.settings.clone(), only: Some(log.schedule.name.clone()) };
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let program = ProgramSource { name, text, library: &Carried(&log.files), options: &options };
    let checked = compile::check_program(&program, &mut sources, &mut sink);
    draw(&sink, &sources);
    let claims = checked.and_then(|checked| checked.claims.into_iter().next()).ok_or("its program has errors")?;
    if log.schedule.source != SourceRef::of(&sources) {
        return Err("another fingerprint".to_owned());
    }
    if log::write_claims(&claims).ok().as_ref() != Some(&log.claims) {
        return Err("other claims".to_owned());
    }
    let verified = match verify::verify_program(log.schedule.clone(), &claims, &sources) {
        Verdict::Accepted(verified) => verified,
        Verdict::Rejected(violations) => {
            return Err(violations.into_iter().next().map_or_else(String::new, |first| first.title));
        }
        Verdict::Inconclusive { why } => return Err(why),
    };
    if let Some(fault) = log.series_fault() {
        return Err(fault.to_string());
    }
    let provenance = Provenance { files: log.files.clone(), settings: log.settings.clone(), is_recorded: true };
    mcap::difference(bytes, &verified, &provenance).map_or(Ok(()), Err)
}
