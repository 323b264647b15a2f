//! Diagnostics of files: E080x.

use super::difference::Difference;
use crate::diagnostic::{Code, Diagnostic, Sink};
use crate::log::LogError;
use std::io;
use std::path::Path;

pub fn unreadable(path: &Path, error: &io::Error) -> Diagnostic {
    let with_ending = path.with_extension("twz");
    let near = error.kind() == io::ErrorKind::NotFound && path.extension().is_none() && with_ending.exists();
    Diagnostic::new(Code::E0801, format!("cannot read `{}`: {}", path.display(), reason(error)))
        .help_if(near.then(|| format!("did you mean `{}`?", with_ending.display())))
}

pub fn no_program_to_show(path: &Path) -> Diagnostic {
    Diagnostic::new(Code::E0801, format!("`{}` contains no program that a page could show", path.display()))
        .help("give the program, `FILE.twz`, or its log, `FILE.mcap`; a schedule in JSON contains neither the program text nor the scene")
}

pub fn is_a_folder(path: &Path) -> Diagnostic {
    Diagnostic::new(Code::E0801, format!("cannot read `{}`: it is a folder", path.display()))
        .help("give a file in it, such as `fetch.twz`")
}

pub fn too_large(path: &Path, limit: usize) -> Diagnostic {
    Diagnostic::new(Code::E0802, format!("`{}` is larger than {} MiB", path.display(), limit / (1024 * 1024)))
}

pub fn not_utf8(path: &Path, bytes: &[u8], at: usize) -> Diagnostic {
    let line = bytes[..at].iter().filter(|byte| **byte == b'\n').count() + 1;
    let is_wide = bytes.starts_with(&[0xFF, 0xFE]) || bytes.starts_with(&[0xFE, 0xFF]) || bytes[at] == 0;
    let guess = match bytes[at] {
        _ if is_wide => "it is UTF-16, as some shells write with `>`: ",
        0xB5 => "this byte is `µ` in Latin-1: ",
        0xB0 => "this byte is `°` in Latin-1: ",
        0xB1 => "this byte is `±` in Latin-1: ",
        _ => "",
    };
    Diagnostic::new(Code::E0803, format!("`{}` is not UTF-8 at byte {at}, in line {line}", path.display()))
        .help(format!("{guess}save it as UTF-8 in your editor; if it is not a Tweeze program, give the right file"))
}

pub fn unwritable(path: &Path, error: &io::Error) -> Diagnostic {
    Diagnostic::new(Code::E0804, format!("cannot write `{}`: {}", path.display(), reason(error)))
        .help("nothing was written; choose another folder with `-o DIR`")
}

pub fn not_made(folder: &Path, error: &io::Error) -> Diagnostic {
    let exists = error.kind() == io::ErrorKind::AlreadyExists;
    let help = if exists { "nothing was changed; choose another name" } else { "choose a writable folder" };
    Diagnostic::new(Code::E0804, format!("cannot create `{}`: {}", folder.display(), reason(error))).help(help)
}

pub fn no_name_for_a_project(folder: &Path) -> Diagnostic {
    Diagnostic::new(Code::E0804, format!("`{}` is not a valid name for a folder", folder.display()))
        .help("write the name of a new one, such as `tweeze new fetch`")
}

pub fn program_for_a_folder(name: &str, stem: &str) -> Diagnostic {
    Diagnostic::new(Code::E0804, format!("`{name}` would be a folder but is the name of a program"))
        .help(format!("`tweeze new {stem}` creates the folder `{stem}` with `{name}` in it"))
}

pub fn not_recorded(path: &Path, error: &io::Error) -> Diagnostic {
    let exists = error.kind() == io::ErrorKind::AlreadyExists;
    let help = if exists { "recordings are never overwritten: choose another name" } else { "choose another folder" };
    Diagnostic::new(Code::E0804, format!("cannot record in `{}`: {}", path.display(), reason(error))).help(help)
}

/// A recording that cannot be continued.
pub fn not_recorded_on(path: &Path, error: &io::Error) -> Diagnostic {
    Diagnostic::new(Code::E0804, format!("cannot continue recording in `{}`: {}", path.display(), reason(error)))
        .help("the run was stopped and the file is incomplete: `mcap recover` saves its contents")
}

pub fn not_replaced(path: &Path, error: &io::Error) -> Diagnostic {
    Diagnostic::new(Code::E0804, format!("cannot write `{}`: {}", path.display(), reason(error)))
        .help("the file is unchanged; `tweeze fmt - < FILE` writes the canonical form to standard output")
}

pub fn nothing_to_format(folder: &Path) -> Diagnostic {
    Diagnostic::new(Code::E0801, format!("`{}` contains no `.twz` file", folder.display()))
        .help("give a file, or a folder with programs")
}

pub fn of_another_program(file: &Path, program: &str) -> Diagnostic {
    let title = format!("`{}` was built from another program, `{program}`", file.display());
    Diagnostic::new(Code::E0806, title).help("choose another folder with `-o DIR`, or replace it with `--force`")
}

pub fn would_replace_input(file: &Path) -> Diagnostic {
    let title = format!("output `{}` would overwrite an input of this build", file.display());
    Diagnostic::new(Code::E0809, title)
        .help("choose another folder with `-o DIR`, or give the task or the program another name: outputs are named after them")
}

pub fn written_twice(name: &str) -> Diagnostic {
    Diagnostic::new(Code::E0807, format!("two files of this build are named `{name}`, apart from upper and lower case"))
        .help("some file systems treat them as one file: give one of the tasks another name, or build it alone with `--task`")
}

pub fn bad_manifest(path: &Path, why: &str) -> Diagnostic {
    Diagnostic::new(
        Code::E0801,
        format!("`{}` does not list the programs that built the files there: {why}", path.display()),
    )
    .help("delete it; the next build writes it again")
}

pub fn unfinished(folder: &Path, journal: &str, why: &io::Error) -> Diagnostic {
    let title = format!(
        "`{}` contains a build that was interrupted and cannot be completed: {}",
        folder.display(),
        reason(why)
    );
    Diagnostic::new(Code::E0808, title)
        .help(format!("files there may come from two builds: delete `{journal}` in that folder and build again"))
}

pub fn unverifiable(file: &str) -> Diagnostic {
    Diagnostic::new(Code::E0850, format!("`{file}` would be a log that `tweeze verify` refuses, for the reason above"))
        .help("nothing was written; this is a fault of Tweeze, not of the program: please report it with the program")
}

/// The system's error message without its number.
fn reason(error: &io::Error) -> String {
    let text = error.to_string();
    let text = text.split(" (os error").next().unwrap_or(&text);
    let mut characters = text.chars();
    let first = characters.next().map(|first| first.to_lowercase().to_string()).unwrap_or_default();
    format!("{first}{}", characters.as_str())
}

pub fn parts_disagree(log: &Path, what: &str) -> Diagnostic {
    Diagnostic::new(Code::E0741, format!("{what} in `{}` does not belong to the program in it", log.display()))
        .help("the log was edited after it was written: build the program again")
}

pub fn recording_differs(path: &Path) -> Diagnostic {
    let title = format!("`{}` differs from what recording its lines would give", path.display());
    Diagnostic::new(Code::E0847, title).help("the recording was edited after it was written: use the original file")
}

/// Origin of a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LogOrigin {
    /// `tweeze build`.
    Build,
    /// `tweeze control --record`: it cannot be repeated.
    Run,
}

pub fn other_program(log: &Path, program: &Path, first: Option<Difference>, origin: LogOrigin) -> Diagnostic {
    let (made, help) = match origin {
        LogOrigin::Build => ("built from", "build the trusted program again and use that log"),
        LogOrigin::Run => (
            "recorded with",
            "the run follows the program that it was recorded with, as `tweeze verify` without `--against` shows",
        ),
    };
    let title = format!("`{}` was {made} a program with other claims than `{}`", log.display(), program.display());
    let first = first.map_or(String::new(), |Difference { place, of_log, of_program }| {
        let program = program.file_name().unwrap_or_default().to_string_lossy();
        format!("the first difference is in `{place}`: {of_log} in the log, {of_program} in `{program}`; ")
    });
    Diagnostic::new(Code::E0742, title).help(format!("{first}{help}"))
}

/// A log whose plan differs from the one that its program gets.
pub fn plans_another(log: &Path, first: Option<Difference>) -> Diagnostic {
    let title = format!("the plan in `{}` differs from the one planned for its program", log.display());
    let first = first.map_or(String::new(), |Difference { place, of_log, of_program }| {
        format!("the first difference is in `{place}`: {of_log} in the log, {of_program} in the new plan; ")
    });
    Diagnostic::new(Code::E0779, title).help(format!(
        "{first}the schedule keeps its claims, but what the log states about its plans is not what Tweeze finds: build the program again and use that log"
    ))
}

/// A log whose program gets no plan.
pub fn plans_nothing(log: &Path) -> Diagnostic {
    let title = format!("`{}` contains a plan, but none was found for its program", log.display());
    Diagnostic::new(Code::E0779, title)
        .help("the schedule keeps its claims, but was not planned by this version of Tweeze; see the other errors")
}

/// A recording for which `--replan` was given.
pub fn no_plan_in(recording: &Path) -> Diagnostic {
    let title = format!("`{}` is the recording of a controlled run, which has no plan to compare", recording.display());
    Diagnostic::new(Code::E0779, title).help("omit `--replan`")
}

/// The first finding for each rule that a log's schedule breaks under another program, with the number of further
/// findings.
pub fn first_of_each_rule(broken: &Sink) -> Vec<Diagnostic> {
    let mut firsts: Vec<(Diagnostic, usize)> = Vec::new();
    for diagnostic in broken.sorted() {
        match firsts.iter_mut().find(|(first, _)| first.code == diagnostic.code) {
            Some((_, count)) => *count += 1,
            None => firsts.push((diagnostic.clone(), 1)),
        }
    }
    let counted = |(first, count): (Diagnostic, usize)| {
        let more = if count > 1 { format!("{} more violations of this rule; ", count - 1) } else { String::new() };
        let help = format!("{more}the schedule follows the program that it was built from, but not this one");
        Diagnostic { help: Some(help), ..first }
    };
    firsts.into_iter().map(counted).collect()
}

/// A file given to `tweeze verify` that is not a log.
pub fn not_a_log(path: &Path) -> Diagnostic {
    let shown = path.display();
    let is_program = path.extension().is_some_and(|extension| extension == "twz");
    let checked = is_program.then(|| {
        format!("a program is checked by `tweeze check {shown}`; `tweeze verify` reads the `.mcap` file of its build")
    });
    let title = format!("`{shown}` does not begin like an MCAP log");
    Diagnostic { title, ..LogError::NotALog.diagnostic() }.help_if(checked)
}

/// Warning that a log was built with other settings than the trusted program; `None` if they are the same.
pub fn other_settings(log: &Path, program: &Path, of_log: &[String], given: &[String]) -> Option<Diagnostic> {
    let lacking = |of: &[String], list: &[String]| -> Vec<String> {
        of.iter()
            .filter(|setting| !list.contains(setting))
            .map(|setting| format!("--set {}", quoted(setting)))
            .collect()
    };
    let (silent, added) = (lacking(of_log, given), lacking(given, of_log));
    let (title, help) = match (silent.is_empty(), added.is_empty()) {
        (true, true) => return None,
        (false, _) => (
            format!(
                "`{}` was built with `{}`, which changes what `{}` claims",
                log.display(),
                silent.join(" "),
                program.display()
            ),
            format!("if you trust it, repeat it: `--against {} {}`", program.display(), silent.join(" ")),
        ),
        (true, false) => (
            format!(
                "`{}` was built without `{}`, which changes what `{}` claims",
                log.display(),
                added.join(" "),
                program.display()
            ),
            "omit it, or build the program again with it".to_owned(),
        ),
    };
    Some(Diagnostic::new(Code::E0772, title).help(help))
}

/// A word quoted for a shell. A log may have any setting and a path any name, and the text is offered for copying.
pub fn quoted(word: &str) -> String {
    let is_safe = |c: char| c.is_ascii_alphanumeric() || "=._+-/".contains(c);
    if word.chars().all(is_safe) { word.to_owned() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}

pub fn program_in_log_has_errors(log: &Path) -> Diagnostic {
    Diagnostic::new(Code::E0743, format!("the program in `{}` has errors", log.display()))
        .help("the log was edited after it was written: build the program again")
}
