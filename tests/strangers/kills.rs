//! Kills and signals at every call that names, writes or synchronises a file: the set of files that a build leaves is
//! entirely old or entirely new.
//!
//! `tests/data/last_call.c`, preloaded, ends the process at a chosen call.

use super::bench::{Bench, DONE, FILES, says};
use super::ignored::{SIGHUP, SIGINT, SIGTERM, is_ignored};
use super::system::is_there;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const OLD: &str = "use std.dimibot\ndevice bot : dimibot.femto_st\ntask go on bot { move to (1, 1) }\n";
const NEW: &str = "use std.dimibot\ndevice bot : dimibot.femto_st\ntask go on bot { move to (2, 1) }\n";
const THIRD: &str = "use std.dimibot\ndevice bot : dimibot.femto_st\ntask third on bot { move to (1, 2) }\n";

const SIGKILL: i32 = 9;

/// The journal; it exists in the folder exactly while the files there may be of two builds.
const JOURNAL: &str = ".tweeze-journal";

/// Files by name.
type Set = BTreeMap<String, Vec<u8>>;

/// A folder `out` into which the same two builds are made repeatedly.
struct Scene {
    bench: Bench,
    library: PathBuf,
    /// The files before the build that is interrupted, and the files after it.
    old: Set,
    new: Set,
    /// Number of calls of that build.
    calls: usize,
}

const BUILD: [&str; 7] = ["build", "new.twz", "--emit", "mcap,csv,json,vcd", "-o", "out", "--force"];

impl Scene {
    /// A scene with the files of another program in the folder, or with an empty folder.
    fn new(with_old_set: bool) -> Scene {
        let bench = Bench::new();
        bench.write("old.twz", OLD).write("new.twz", NEW).write("third.twz", THIRD);
        let library = bench.path("last_call.so");
        compile(&library);
        fs::create_dir(bench.path("out")).expect("a folder");
        if with_old_set {
            bench.run(&["build", "old.twz", "--emit", "mcap,csv,json,vcd", "-o", "out"]).code(DONE);
        }
        let mut scene = Scene { bench, library, old: Set::new(), new: Set::new(), calls: 0 };
        scene.old = scene.set();
        let count = scene.bench.path("count");
        scene.bench.run_with(&[scene.preload(), ("LAST_COUNT", text(&count))], &BUILD).code(DONE);
        let calls = fs::read_to_string(&count).expect("the calls were counted");
        scene.calls = calls.parse().expect("a number");
        scene.new = scene.set();
        assert!(scene.calls > 40 && scene.new != scene.old && scene.new.len() == 7, "{} calls", scene.calls);
        scene
    }

    fn preload(&self) -> (&str, &str) {
        ("LD_PRELOAD", text(&self.library))
    }

    /// All files in the folder.
    fn set(&self) -> Set {
        let entries = fs::read_dir(self.bench.path("out")).expect("a folder").flatten();
        let named = |entry: fs::DirEntry| {
            (entry.file_name().to_string_lossy().into_owned(), fs::read(entry.path()).expect("read"))
        };
        entries.map(named).collect()
    }

    /// The files that a user sees: without those that a build stages.
    fn seen(&self) -> Set {
        self.set().into_iter().filter(|(name, _)| !name.starts_with(".tweeze-")).collect()
    }

    /// Runs the new build over the old set and ends it by a signal at a call; returns the files that are then seen, and
    /// whether there is a journal.
    fn end(&self, call: usize, signal: i32) -> (Set, bool) {
        let out = self.bench.path("out");
        fs::remove_dir_all(&out).and_then(|()| fs::create_dir(&out)).expect("an empty folder");
        for (name, bytes) in &self.old {
            fs::write(out.join(name), bytes).expect("written");
        }
        let (call, number) = (call.to_string(), signal.to_string());
        let variables = [self.preload(), ("LAST_CALL", call.as_str()), ("LAST_SIGNAL", number.as_str())];
        let ended = self.bench.run_with(&variables, &BUILD);
        assert_eq!(ended.signal, Some(signal), "call {call}: {ended:?}");
        (self.seen(), out.join(JOURNAL).exists())
    }

    /// Which of the two sets these files are: 0 the old one, 1 the new one.
    #[track_caller]
    fn which(&self, set: &Set, call: usize) -> usize {
        let names: Vec<_> = set.iter().map(|(name, bytes)| (name, bytes.len())).collect();
        assert!(*set == self.old || *set == self.new, "mixed after call {call}: {names:?}");
        usize::from(*set == self.new)
    }
}

fn text(path: &Path) -> &str {
    path.to_str().expect("the folder for tests has a plain name")
}

fn compile(library: &Path) {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/last_call.c");
    let status = Command::new("cc").args(["-shared", "-fPIC", "-O1", "-o"]).arg(library).arg(source).status();
    assert!(status.expect("it starts").success(), "the library is not compiled");
}

/// After a kill, the files are of one build unless there is a journal. The next command that looks at them, `verify` or
/// another build, always leaves them of one build.
#[test]
fn after_a_kill_at_any_call_the_set_is_old_or_new() {
    if !is_there("cc") {
        return;
    }
    for with_old_set in [true, false] {
        let scene = Scene::new(with_old_set);
        let mut counts = [0, 0];
        let mut journals = 0;
        for call in 0..scene.calls {
            let (seen, has_journal) = scene.end(call, SIGKILL);
            let direct = (!has_journal).then(|| scene.which(&seen, call));
            journals += usize::from(has_journal);
            let has_log = has_journal || seen.contains_key("go.mcap");
            let verified = scene.bench.run(&["verify", "out/go.mcap"]).code(if has_log { DONE } else { FILES });
            if !has_log {
                says(&verified.err, &["E0801"]);
            }
            let which = scene.which(&scene.seen(), call);
            assert!(direct.is_none_or(|direct| direct == which), "call {call}");
            assert!(!has_journal || which == 1, "call {call}: a journal makes the set the new one");
            counts[which] += 1;
            // Another build removes what was staged, and adds its own files.
            scene.bench.run(&["build", "third.twz", "--emit", "vcd", "-o", "out"]).code(DONE);
            let mut set = scene.set();
            for name in ["third.vcd", "third.gtkw"] {
                set.remove(name).expect("it was built");
            }
            let own = |set: &Set| {
                set.iter()
                    .filter(|(name, _)| *name != ".tweeze.json")
                    .map(|(n, b)| (n.clone(), b.clone()))
                    .collect::<Set>()
            };
            assert_eq!(own(&set), own(if which == 0 { &scene.old } else { &scene.new }), "call {call}");
        }
        assert!(counts[0] > 20 && counts[1] > 5 && journals > 4, "{counts:?}, {journals} journals");
        println!("{} kills: {} old, {} new, {journals} by way of the journal", scene.calls, counts[0], counts[1]);
    }
}

/// After a signal that can be caught, nothing is left to clean up.
#[test]
fn after_a_signal_at_any_call_the_folder_is_clean() {
    if !is_there("cc") {
        return;
    }
    let signals: Vec<i32> = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|signal| !is_ignored(*signal)).collect();
    let scene = Scene::new(true);
    let mut counts = [0, 0];
    for call in 0..scene.calls {
        let (seen, _) = scene.end(call, signals[call % signals.len()]);
        assert_eq!(scene.set(), seen, "call {call}");
        counts[scene.which(&seen, call)] += 1;
    }
    assert!(counts[0] > 20 && counts[1] > 5, "{counts:?}");
}
