//! The third-party judges of `tests/oracles`, on what the built program writes for the examples.
//!
//! Not run by libtest, so that what is skipped is said aloud. `TWEEZE_ORACLE_PYTHON` names the Python that has the readers, else
//! `.venv-oracle/bin/python` or `python3` is tried; with `TWEEZE_REQUIRE_ORACLES=1` a missing judge is a failure.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

fn main() -> ExitCode {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = match tempfile::tempdir() {
        Ok(folder) => folder,
        Err(error) => return fail(&format!("no folder for the files to be judged: {error}")),
    };
    for example in examples(root) {
        let built = Command::new(env!("CARGO_BIN_EXE_tweeze"))
            .args(["build", "--emit", "mcap,json,csv,vcd,pwl,scpi", "-o"])
            .arg(folder.path())
            .arg(&example)
            .output();
        match built {
            Ok(output) if output.status.success() => {}
            Ok(output) => return fail(&String::from_utf8_lossy(&output.stderr)),
            Err(error) => return fail(&format!("the program does not start: {error}")),
        }
    }
    let judged = Command::new(python(root)).arg(root.join("tests/oracles/run.py")).arg(folder.path()).status();
    match judged {
        Ok(status) if status.success() => ExitCode::SUCCESS,
        Ok(status) => fail(&format!("the judges end with {status}")),
        Err(error) if std::env::var_os("TWEEZE_REQUIRE_ORACLES").is_none() => {
            println!("SKIPPED: the third-party judges need Python: {error}");
            ExitCode::SUCCESS
        }
        Err(error) => fail(&format!("Python does not start: {error}")),
    }
}

fn fail(why: &str) -> ExitCode {
    eprintln!("judges: {why}");
    ExitCode::FAILURE
}

/// The examples with tasks of their own, in a fixed order.
fn examples(root: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(root.join("examples")).into_iter().flatten().flatten();
    let is_program = |path: &PathBuf| {
        let text = std::fs::read_to_string(path).unwrap_or_default();
        text.lines().any(|line| line.starts_with("task ") || line.starts_with("program "))
    };
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(is_program).collect();
    paths.sort();
    paths
}

fn python(root: &Path) -> PathBuf {
    let own = root.join(".venv-oracle/bin/python");
    match std::env::var_os("TWEEZE_ORACLE_PYTHON") {
        Some(python) => python.into(),
        None if own.exists() => own,
        None => "python3".into(),
    }
}
