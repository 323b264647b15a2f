//! The fingerprints of all outputs of all examples are in `tests/data/outputs.sha256`, in the form of `sha256sum`: any change of
//! a byte on some platform, or by a change of the compiler, fails here.
//!
//! `TWEEZE_UPDATE=1 cargo test --test portable outputs` rewrites them after an intended change.

use super::bench::{done, files, root, tweeze};
use sha2::{Digest, Sha256};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// The examples that have something to build, by name.
fn examples() -> Vec<PathBuf> {
    let entries = std::fs::read_dir(root().join("examples")).expect("the examples are there").flatten();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    paths.retain(|path| std::fs::read_to_string(path).is_ok_and(|text| text.contains("\ntask ")));
    paths.sort();
    assert!(paths.len() >= 14);
    paths
}

/// The fingerprints of all outputs of all examples, built with some variables in the environment.
pub fn fingerprints(environment: &[(&str, &Path)]) -> String {
    let mut text = String::new();
    for example in examples() {
        let stem = example.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let out = tempfile::tempdir().expect("a folder");
        // G-code is of stages only.
        let last = if stem.starts_with("fingers") { ",gcode" } else { "" };
        let formats = format!("mcap,json,csv,vcd,pwl,scpi{last}");
        let mut command = tweeze(root());
        command.arg("build").arg(&example).args(["--emit", &formats, "-o"]).arg(out.path());
        command.envs(environment.iter().copied());
        done(&mut command);
        for (name, bytes) in files(out.path()) {
            let digest: String = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
            let _ = writeln!(text, "{digest}  {stem}/{name}");
        }
    }
    text
}

#[test]
fn outputs_of_the_examples_are_those_of_every_platform() {
    let place = root().join("tests/data/outputs.sha256");
    let built = fingerprints(&[]);
    if std::env::var_os("TWEEZE_UPDATE").is_some() {
        std::fs::write(&place, &built).expect("it can be written");
    }
    let kept = std::fs::read_to_string(&place).unwrap_or_default();
    let other: Vec<&str> = built.lines().filter(|line| !kept.contains(line)).collect();
    assert!(built == kept, "these differ from {}, or are new or gone:\n{}", place.display(), other.join("\n"));
}
