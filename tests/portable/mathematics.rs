//! Nothing on the way from a program to its outputs calls the platform's mathematics: with a C library whose functions
//! are all off by one unit in the last place, the outputs are the same.

use super::bench::{done, root, tweeze};
use super::outputs::{fingerprints, kept};
use super::system::is_there;
use std::path::Path;
use std::process::Command;

/// Functions that dependencies still call: `microlp` the logarithms that it rounds to powers of two for scaling the
/// rows and columns of the judge of hands; `indicatif` the speed of a progress line, which goes to the terminal only.
const ASKED_BY_OTHERS: [&str; 2] = ["log2", "pow"];

/// The functions that the other library replaces, read from its source.
fn replaced() -> Vec<String> {
    let text = std::fs::read_to_string(root().join("tests/data/other_mathematics.c")).expect("it is there");
    let of = |line: &str| {
        let (head, rest) = line.split_once('(')?;
        let name = rest.split([',', ')']).next()?;
        ["ONE", "TWO", "BOTH"].contains(&head).then(|| name.trim().to_owned())
    };
    text.lines().filter_map(of).collect()
}

#[cfg(target_os = "linux")]
#[test]
fn outputs_do_not_hang_on_the_mathematics_of_the_platform() {
    // The other test is rewriting the file that this one reads.
    if !is_there("cc") || std::env::var_os("TWEEZE_UPDATE").is_some() {
        return;
    }
    let bench = tempfile::tempdir().expect("a folder");
    let library = bench.path().join("other_mathematics.so");
    let source = root().join("tests/data/other_mathematics.c");
    done(Command::new("cc").args(["-shared", "-fPIC", "-fno-builtin", "-O1", "-o"]).arg(&library).arg(&source));
    works(bench.path(), &library);
    // The other test compares the same fingerprints with outputs built without the library.
    let wrong = fingerprints(&[("LD_PRELOAD", &library)]);
    assert_eq!(wrong, kept());
}

/// Checks that the other library has an effect: a program that calls the platform's functions gets different numbers
/// with it.
fn works(folder: &Path, library: &Path) {
    let text = "#include <math.h>\n#include <stdio.h>\n#include <stdlib.h>\n\
                int main(int n, char **v) { double x = atof(v[1]); printf(\"%a %a %a\", sin(x), pow(x, 1.7), hypot(x, 2)); }\n";
    let (source, probe) = (folder.join("probe.c"), folder.join("probe"));
    std::fs::write(&source, text).expect("written");
    done(Command::new("cc").args(["-fno-builtin", "-o"]).arg(&probe).arg(&source).arg("-lm"));
    let own = done(Command::new(&probe).arg("0.7"));
    let other = done(Command::new(&probe).arg("0.7").env("LD_PRELOAD", library));
    let words = |output: &[u8]| String::from_utf8_lossy(output).split(' ').map(str::to_owned).collect::<Vec<_>>();
    let differ = words(&own.stdout).iter().zip(words(&other.stdout)).all(|(own, other)| *own != other);
    assert!(differ && own.stdout.len() > 20, "{own:?} {other:?}");
}

#[cfg(target_os = "linux")]
#[test]
fn the_program_asks_the_platform_for_no_elementary_function_of_its_own() {
    if !is_there("nm") {
        return;
    }
    let names = replaced();
    assert!(names.len() > 40 && names.iter().any(|name| name == "sincos"), "{names:?}");
    let list = done(Command::new("nm").args(["-D", "--undefined-only", env!("CARGO_BIN_EXE_tweeze")]));
    let list = String::from_utf8_lossy(&list.stdout).into_owned();
    let asked = |line: &str| line.split_whitespace().last().and_then(|name| name.split('@').next()).map(str::to_owned);
    let asked: Vec<String> = list.lines().filter_map(asked).collect();
    assert!(asked.iter().any(|name| name == "malloc"), "`nm` lists nothing: {list}");
    let is_new = |name: &&String| names.contains(name) && !ASKED_BY_OTHERS.contains(&name.as_str());
    let of_mathematics: Vec<&String> = asked.iter().filter(is_new).collect();
    assert!(of_mathematics.is_empty(), "{of_mathematics:?}");
    // The program runs with it at all.
    done(tweeze(root()).arg("--version"));
}
