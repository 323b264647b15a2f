//! What goes wrong with files: E080x.

use crate::diagnostic::{Code, Diagnostic};
use std::io;
use std::path::Path;

pub fn unreadable(path: &Path, error: &io::Error) -> Diagnostic {
    let with_ending = path.with_extension("twz");
    let near = error.kind() == io::ErrorKind::NotFound && path.extension().is_none() && with_ending.exists();
    Diagnostic::new(Code::E0801, format!("cannot read `{}`: {}", path.display(), reason(error)))
        .help_if(near.then(|| format!("did you mean `{}`?", with_ending.display())))
}

pub fn is_a_folder(path: &Path) -> Diagnostic {
    Diagnostic::new(Code::E0801, format!("cannot read `{}`: it is a folder", path.display()))
        .help("name a file in it, as `fetch.twz`")
}

pub fn too_large(path: &Path, limit: usize) -> Diagnostic {
    Diagnostic::new(Code::E0802, format!("`{}` is larger than {} MiB", path.display(), limit / (1024 * 1024)))
}

pub fn not_utf8(path: &Path, at: usize, line: usize) -> Diagnostic {
    Diagnostic::new(Code::E0803, format!("`{}` is not UTF-8 at byte {at}, in line {line}", path.display()))
        .help("save it as UTF-8 in your editor; if it is no Tweeze program, name the right file")
}

pub fn unwritable(path: &Path, error: &io::Error) -> Diagnostic {
    Diagnostic::new(Code::E0804, format!("cannot write `{}`: {}", path.display(), reason(error)))
        .help("nothing was written; choose another folder with `-o DIR`")
}

/// The system's reason without its number.
fn reason(error: &io::Error) -> String {
    let text = error.to_string();
    let text = text.split(" (os error").next().unwrap_or(&text);
    let mut characters = text.chars();
    let first = characters.next().map(|first| first.to_lowercase().to_string()).unwrap_or_default();
    format!("{first}{}", characters.as_str())
}

pub fn parts_disagree(log: &Path, what: &str) -> Diagnostic {
    Diagnostic::new(Code::E0741, format!("{what} of `{}` is not that of the program in it", log.display()))
        .help("the log was edited after it was written: build the program again")
}

pub fn other_program(log: &Path, program: &Path) -> Diagnostic {
    let title =
        format!("`{}` was built from a program that claims something else than `{}`", log.display(), program.display());
    Diagnostic::new(Code::E0742, title).help("build the trusted program again and use that log")
}

pub fn program_in_log_has_errors(log: &Path) -> Diagnostic {
    Diagnostic::new(Code::E0743, format!("the program in `{}` has errors", log.display()))
        .help("the log was edited after it was written: build the program again")
}
