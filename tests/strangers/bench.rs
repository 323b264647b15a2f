//! Runs the built program in a temporary folder.

use assert_cmd::Command;
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

pub const DONE: i32 = 0;
pub const ERRORS: i32 = 1;
pub const USAGE: i32 = 2;
pub const REFUSED: i32 = 3;
pub const FILES: i32 = 4;

/// A program in `tests/found`.
pub fn found(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/found").join(name);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Result of a run.
#[derive(Debug)]
pub struct Ended {
    /// Exit status; `None` after a signal.
    pub code: Option<i32>,
    /// The signal that ended it.
    pub signal: Option<i32>,
    pub out: String,
    pub err: String,
}

impl Ended {
    /// Asserts the exit status.
    #[track_caller]
    pub fn code(self, code: i32) -> Ended {
        assert_eq!(self.code, Some(code), "{}\n{}", self.out, self.err);
        self
    }
}

/// A temporary folder.
pub struct Bench {
    folder: TempDir,
}

impl Bench {
    pub fn new() -> Bench {
        Bench { folder: tempfile::tempdir().expect("a folder for the test") }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> &Bench {
        fs::write(self.path(name), bytes).expect("a file is written");
        self
    }

    pub fn run(&self, arguments: &[&str]) -> Ended {
        self.run_with(&[], arguments)
    }

    /// As [`Bench::run`], with further environment variables.
    pub fn run_with(&self, variables: &[(&str, &str)], arguments: &[&str]) -> Ended {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tweeze"));
        command.envs(variables.iter().copied());
        self.ended(command, arguments)
    }

    /// As [`Bench::run`], with a memory limit where the shell supports one.
    pub fn run_in_mib(&self, mib: u64, arguments: &[&str]) -> Ended {
        let limited = format!("ulimit -v {}; exec '{}' \"$@\"", mib * 1024, env!("CARGO_BIN_EXE_tweeze"));
        let all: Vec<&str> = ["-c", &limited, "sh"].into_iter().chain(arguments.iter().copied()).collect();
        self.ended(Command::new("sh"), &all)
    }

    /// The names in the folder, including hidden ones.
    pub fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.folder.path()).expect("a folder").flatten();
        let mut names: Vec<String> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    fn ended(&self, mut command: Command, arguments: &[&str]) -> Ended {
        let output = command.current_dir(self.folder.path()).env("COLUMNS", "1000").args(arguments).output();
        let output = output.expect("the program starts");
        let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
        #[cfg(unix)]
        let signal = std::os::unix::process::ExitStatusExt::signal(&output.status);
        #[cfg(not(unix))]
        let signal = None;
        Ended { code: output.status.code(), signal, out: text(output.stdout), err: text(output.stderr) }
    }
}

#[track_caller]
pub fn says(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "`{part}` is not in:\n{text}");
    }
}
