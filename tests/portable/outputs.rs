//! Fingerprints of all outputs of all examples, in `tests/data/outputs.sha256` in the format of `sha256sum`: a change
//! of any byte, on some platform or by a change of the compiler, fails here.
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

fn digest(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The fingerprints of all outputs of all examples, built with some environment variables.
pub fn fingerprints(environment: &[(&str, &Path)]) -> String {
    let mut text = String::new();
    for example in examples() {
        let stem = example.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let out = tempfile::tempdir().expect("a folder");
        let mut command = tweeze(root());
        command.arg("build").arg(&example).args(["--emit", "all", "-o"]).arg(out.path());
        command.envs(environment.iter().copied());
        done(&mut command);
        for (name, bytes) in files(out.path()) {
            let _ = writeln!(text, "{}  {stem}/{name}", digest(&bytes));
        }
    }
    text
}

fn place() -> PathBuf {
    root().join("tests/data/outputs.sha256")
}

/// The stored fingerprints; empty if there are none yet.
pub fn kept() -> String {
    std::fs::read_to_string(place()).unwrap_or_default()
}

/// The pictures at the head of the README, each with the example's picture that it is a copy of.
const PICTURES: [(&str, &str); 4] = [
    ("dimibot.svg", "dimibot_fetch/fetch.svg"),
    ("electrode_array.svg", "electrode_array_swap/swap.svg"),
    ("microrobots.svg", "microrobots_four/quartet.svg"),
    ("fingers.svg", "fingers_ellipsoid/flip.svg"),
];

/// The other test compares these fingerprints with the current outputs.
#[test]
fn pictures_of_the_readme_are_those_of_the_examples() {
    let fingerprints = kept();
    for (name, of) in PICTURES {
        let bytes = std::fs::read(root().join("docs/pictures").join(name)).expect("the picture is there");
        let line = format!("{}  {of}", digest(&bytes));
        assert!(
            fingerprints.lines().any(|kept| kept == line),
            "docs/pictures/{name} is not {of} as it is written today"
        );
    }
}

#[test]
fn outputs_of_the_examples_are_those_of_every_platform() {
    let built = fingerprints(&[]);
    if std::env::var_os("TWEEZE_UPDATE").is_some() {
        std::fs::write(place(), &built).expect("it can be written");
    }
    let kept = kept();
    let other: Vec<&str> = built.lines().filter(|line| !kept.contains(line)).collect();
    assert!(built == kept, "these differ from {}, or are new or gone:\n{}", place().display(), other.join("\n"));
}
