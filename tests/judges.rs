//! The third-party readers of `tests/oracles`, applied to the files that the built program writes for the examples.
//!
//! Not run by libtest, so that skipped tests are reported. `TWEEZE_ORACLE_PYTHON` names the Python that has the
//! readers; otherwise `.venv-oracle/bin/python` or `python3` is tried. With `TWEEZE_REQUIRE_ORACLES=1` a missing judge
//! is a failure.

use serde_json::Value;
use std::collections::BTreeSet;
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

fn main() -> ExitCode {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = match tempfile::tempdir() {
        Ok(folder) => folder,
        Err(error) => return fail(&format!("no folder for the files to be judged: {error}")),
    };
    if let Err(why) = write_all(&examples(root), folder.path()) {
        return fail(&why);
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

/// Writes the files of all examples, each into its own folder, because programs of different examples may have the same
/// name.
fn write_all(examples: &[PathBuf], folder: &Path) -> Result<(), String> {
    let next = AtomicUsize::new(0);
    let work = || {
        while let Some(example) = examples.get(next.fetch_add(1, Ordering::Relaxed)) {
            write(example, &folder.join(example.file_stem().unwrap_or_default()))?;
        }
        Ok(())
    };
    let workers = thread::available_parallelism().map_or(1, NonZero::get);
    thread::scope(|scope| {
        let workers: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        workers.into_iter().try_for_each(|worker| worker.join().unwrap_or_else(|_| Err("a worker panicked".to_owned())))
    })
}

/// Writes the files of an example, in all formats that its channels and instruments support.
fn write(example: &Path, folder: &Path) -> Result<(), String> {
    // Tables and waveforms have a single clock and cannot wait.
    let waits = std::fs::read_to_string(example).unwrap_or_default().contains("  prompt ");
    let formats = if waits { "mcap,json,svg" } else { "mcap,json,csv,vcd,pwl,svg" };
    build(example, formats, folder)?;
    let written: Vec<Value> = schedules(folder).iter().map(|path| document(path)).collect();
    let are_all = |fits: &dyn Fn(&Value) -> bool| !written.is_empty() && written.iter().all(fits);
    for (family, format) in [
        ("waveform_generator", "scpi"),
        ("data_acquisition", "nidaqmx"),
        ("electrode_driver", "frames"),
        ("stage_controller", "stages"),
    ] {
        if are_all(&|schedule| has_instrument(schedule, family)) {
            build(example, format, folder)?;
        }
    }
    if are_all(&is_of_microdrop) {
        build(example, "microdrop", folder)?;
    }
    if are_all(&is_of_stages) {
        build(example, "gcode", folder)?;
    }
    Ok(())
}

/// Builds an example with the built program.
fn build(example: &Path, formats: &str, folder: &Path) -> Result<(), String> {
    let program = env!("CARGO_BIN_EXE_tweeze");
    let built = Command::new(program).args(["build", "--emit", formats, "-o"]).arg(folder).arg(example).output();
    match built {
        Ok(output) if output.status.success() => Ok(()),
        Ok(output) => Err(String::from_utf8_lossy(&output.stderr).into_owned()),
        Err(error) => Err(format!("the program does not start: {error}")),
    }
}

/// The schedules in a folder.
fn schedules(folder: &Path) -> BTreeSet<PathBuf> {
    let paths = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let is_schedule = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let is_other = name.starts_with('.') || name.ends_with(".lichtblick.json") || name.ends_with(".microdrop.json");
        !is_other && path.extension().is_some_and(|ending| ending == "json")
    };
    paths.filter(is_schedule).collect()
}

fn document(path: &Path) -> Value {
    std::fs::read(path).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok()).unwrap_or_default()
}

/// Whether all channels of a schedule are positions, so that it can be written as G-code.
fn is_of_stages(schedule: &Value) -> bool {
    schedule["channels"].as_array().is_some_and(|channels| channels.iter().all(|channel| channel["unit"] == "um"))
}

/// Whether MicroDrop drives a board of a schedule and no magnet or heater; the examples wait only for people.
fn is_of_microdrop(schedule: &Value) -> bool {
    let drives = schedule["bench"]["drives"].as_object();
    let is_accessory = |drive: &Value| drive["output"].as_str().is_some_and(|output| output.starts_with(['m', 'h']));
    if drives.is_some_and(|drives| drives.values().any(is_accessory)) {
        return false;
    }
    let instruments = schedule["bench"]["instruments"].as_object();
    let is_driven = |one: &Value| {
        let protocol = &one["facts"]["electrode_driver"]["protocol"];
        protocol == "opendrop" || protocol == "dropbot"
    };
    instruments.is_some_and(|instruments| instruments.values().any(is_driven))
}

/// Whether channels of a schedule are wired to an instrument of a family.
fn has_instrument(schedule: &Value, family: &str) -> bool {
    let instruments = schedule["bench"]["instruments"].as_object();
    instruments.is_some_and(|instruments| instruments.values().any(|one| one["facts"].get(family).is_some()))
}

fn fail(why: &str) -> ExitCode {
    eprintln!("judges: {why}");
    ExitCode::FAILURE
}

/// The examples with their own tasks, in a fixed order.
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
