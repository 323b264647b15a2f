//! Numbers of another magnitude are reported at their place, or build: no endless search, and no plan that the verifier
//! refuses.

use super::bench::{root, tweeze};

/// The codes that the build of a program in `tests/found` reports.
fn codes(name: &str) -> Vec<String> {
    let out = tempfile::tempdir().expect("a folder");
    let program = root().join("tests/found").join(name).with_extension("twz");
    let mut command = tweeze(root());
    command.arg("build").arg(program).args(["--format", "json", "-o"]).arg(out.path());
    let output = command.output().expect("the program starts");
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    let code = |line: &str| serde_json::from_str::<serde_json::Value>(line).ok()?["code"].as_str().map(str::to_owned);
    text.lines().filter_map(code).filter(|code| code.starts_with('E')).collect()
}

#[test]
fn figures_out_of_range_are_errors_of_the_program() {
    for (name, expected) in [
        ("hang-assemble-slow-robots", "E0403"),
        ("hang-place-error", "E0403"),
        ("refused-apply-far", "E0501"),
        ("refused-fingers-precision", "E0403"),
    ] {
        let codes = codes(name);
        assert!(!codes.is_empty() && codes.iter().all(|code| code == expected), "{name}: {codes:?}");
    }
}

#[test]
fn headings_of_many_turns_are_headings() {
    assert_eq!(codes("refused-heading"), Vec::<String>::new());
    // Any answer will do, as long as it is not the verifier's.
    assert!(codes("hang-heading").iter().all(|code| !code.starts_with("E07")));
}
