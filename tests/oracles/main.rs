//! Hands a folder of written files to the judges in Python, which are no part of Tweeze: `run.py` for the files, pytest for
//! the judges themselves.
//!
//! `TWEEZE_FIXTURES` names the folder, `TWEEZE_PYTHON` the Python that has the packages of `requirements.txt` (without it
//! `.venv-oracle/bin/python`, then `python3`). What is not there is said aloud and skipped, unless `TWEEZE_REQUIRE_ORACLES` is 1.

use std::path::{Path, PathBuf};
use std::process::Command;

#[test]
fn the_judges_find_every_file_right() {
    let Some(folder) = fixtures() else { return };
    judge(&["run.py", &folder]);
}

#[test]
fn the_judges_find_faults() {
    let Some(_) = fixtures() else { return };
    judge(&["-m", "pytest", "-p", "no:cacheprovider", "-q", "."]);
}

/// The folder to judge, or nothing where it may be skipped.
fn fixtures() -> Option<String> {
    let folder = std::env::var("TWEEZE_FIXTURES").ok();
    if folder.is_none() {
        assert!(!required(), "TWEEZE_FIXTURES names no folder to judge");
        eprintln!("SKIPPED: TWEEZE_FIXTURES names no folder to judge");
    }
    folder
}

fn judge(arguments: &[&str]) {
    let home = Path::new(env!("CARGO_MANIFEST_DIR"));
    let run = Command::new(python(home)).arg("-B").args(arguments).current_dir(home.join("tests/oracles")).output();
    match run {
        Ok(output) => {
            let said = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
            println!("{said}");
            let absent = said.contains("No module named pytest") && !required();
            assert!(output.status.success() || absent, "{said}");
        }
        Err(error) => assert!(!required(), "Python cannot be run: {error}"),
    }
}

fn python(home: &Path) -> PathBuf {
    let own = home.join(".venv-oracle/bin/python");
    match std::env::var_os("TWEEZE_PYTHON") {
        Some(python) => python.into(),
        None if own.exists() => own,
        None => "python3".into(),
    }
}

fn required() -> bool {
    std::env::var("TWEEZE_REQUIRE_ORACLES").is_ok_and(|value| value == "1")
}
