//! Outputs do not depend on where a program is stored or how its path is typed; messages show the path as typed.

use super::bench::{done, files, tweeze};
use std::fs;
use std::path::Path;

const FORMATS: &str = "mcap,json,csv,vcd,pwl";

/// A program with a file beside it and one above it.
fn lay_out(folder: &Path) {
    fs::create_dir_all(folder.join("day/lab")).expect("a folder");
    let program = "use \"lab/bench.twz\" as lab\nuse \"../rooms.twz\" as rooms\ntask go on lab.bot in rooms.hall { move to (1, 1) }\n";
    fs::write(folder.join("day/go.twz"), program).expect("written");
    fs::write(folder.join("day/lab/bench.twz"), "use std.dimibot\ndevice bot : dimibot.femto_st\n").expect("written");
    fs::write(folder.join("rooms.twz"), "scene hall { obstacle post at (3, 3) }\n").expect("written");
}

#[test]
fn a_program_gives_the_same_bytes_wherever_it_lies() {
    let (one, other) = (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
    let far = other.path().join("far/away from µ");
    lay_out(one.path());
    lay_out(&far);
    let absolute = one.path().join("day/go.twz").to_string_lossy().into_owned();
    let ways: [(&Path, &str); 6] = [
        (&one.path().join("day"), "go.twz"),
        (one.path(), "day/go.twz"),
        (one.path(), "./day/../day/go.twz"),
        (other.path(), &absolute),
        (&far.join("day/lab"), "../go.twz"),
        (&far, "day/go.twz"),
    ];
    let mut first = None;
    for (at, (folder, path)) in ways.into_iter().enumerate() {
        let out = one.path().join(format!("out{at}"));
        done(tweeze(folder).args(["build", path, "--emit", FORMATS, "-o"]).arg(&out));
        let built = files(&out);
        assert_eq!(built.len(), 8);
        for (name, bytes) in &built {
            let text = String::from_utf8_lossy(bytes);
            let places = [one.path(), other.path()].map(|place| place.to_string_lossy().into_owned());
            assert!(!places.iter().any(|place| text.contains(place)), "{name} tells where the program lies");
        }
        assert!(*first.get_or_insert_with(|| built.clone()) == built, "{path} gives other bytes");
        done(tweeze(folder).arg("verify").arg(out.join("go.mcap")));
        done(tweeze(folder).arg("verify").arg(out.join("go.mcap")).args(["--against", path]));
    }
    let document = String::from_utf8(first.unwrap_or_default().remove("go.json").unwrap_or_default()).expect("text");
    assert!(document.contains("\"file\": \"go.twz\""), "{document}");
}

#[test]
fn messages_show_the_path_as_it_was_typed() {
    let bench = tempfile::tempdir().expect("a folder");
    lay_out(bench.path());
    fs::write(bench.path().join("rooms.twz"), "scene hall { obstacle post at (99, 3 V) }\n").expect("written");
    for (path, shown) in [("day/go.twz", "day/../rooms.twz:1:"), ("./day/go.twz", "./day/../rooms.twz:1:")] {
        let output = tweeze(bench.path()).args(["check", path]).output().expect("the program starts");
        let reported = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(reported.contains(shown), "{reported}");
    }
    fs::write(bench.path().join("day/go.twz"), "let a = 1 um + 1 V\n").expect("written");
    for path in ["day/go.twz", "./day/go.twz"] {
        let output = tweeze(bench.path()).args(["check", path, "--format", "json"]).output().expect("it starts");
        let reported = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(reported.contains(&format!("\"file\":\"{path}\"")), "{reported}");
    }
}
