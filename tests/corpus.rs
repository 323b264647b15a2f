//! The corpus: programs with the report that a person sees beside each.
//!
//! `corpus/<stage>/*.twz` is compiled; the report, plain and 100 columns wide, must be the `.txt` file of the same
//! name. Its last line says what the page of the failed build shows. `TWEEZE_UPDATE=1` rewrites the reports: read the
//! changes before committing them.
//!
//! A first line `// set=name=value task=name` gives the options of `build`. A line `// file lab.twz` ends the program;
//! the rest is a file beside it.

#[path = "support/case.rs"]
mod case;

use case::Case;
use std::fs;
use std::path::{Path, PathBuf};
use tweeze::compile::partial;
use tweeze::diagnostic::render::{Characters, Colour, Look, human};
use tweeze::diagnostic::{CellRun, Diagnostic, PlaceUnit, Reach, ReachExtent, Sink, WrittenPlace};
use tweeze::emit::{FailedProgram, Provenance, failed_page};
use tweeze::source::Sources;

const LOOK: Look = Look { colour: Colour::Plain, characters: Characters::Unicode, width: 100 };

fn case(path: &Path) -> Case {
    let text = fs::read_to_string(path).expect("a case is a text");
    let mut parts = text.split("\n// file ");
    let own = parts.next().unwrap_or_default();
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut case = Case { name, text: own.to_owned(), ..Case::default() };
    for part in parts {
        let (name, text) = part.split_once('\n').unwrap_or((part, ""));
        case.files.insert(name.trim().to_owned(), text.to_owned());
    }
    let options = own.lines().next().and_then(|line| line.strip_prefix("// ")).unwrap_or_default();
    for word in options.split_whitespace() {
        case.take(word);
    }
    case
}

fn report(case: &Case) -> String {
    let (sources, sink) = case.compile();
    let reported: String = sink.sorted().into_iter().map(|diagnostic| human(diagnostic, &sources, LOOK)).collect();
    reported + &page(case, &sources, &sink)
}

/// Summary of the page of a failed build: the steps that could be built, and the marked places.
fn page(case: &Case, sources: &Sources, errors: &Sink) -> String {
    if errors.errors() == 0 {
        return String::new();
    }
    let part = case.request(|program| partial(program, errors));
    let places = part.as_ref().map_or(&[][..], |part| &part.places);
    let built = part.as_ref().map(|part| (&part.verified, part.whole.as_ref()));
    let failed = FailedProgram { part: built, errors, places, sources };
    let page = failed_page("failed", &failed, &Provenance::default()).expect("a page");
    let html = String::from_utf8(page.bytes).expect("a page is text");
    let first = errors.sorted().into_iter().find(|error| error.is_error()).expect("an error");
    assert!(html.contains(first.code.name()), "{}", first.title);
    let Some(part) = part else { return "page without a scene\n".to_owned() };
    let schedule = part.verified.schedule();
    let mut line = format!("page of `{}`, {} steps built", schedule.name, schedule.steps.len());
    for WrittenPlace { device, unit, at: [x, y], .. } in &part.places {
        let unit = if *unit == PlaceUnit::Cells { "" } else { " um" };
        let device = device.as_ref().map_or("scene", String::as_str);
        line.push_str(&format!(", ({x}, {y}){unit} of {device}"));
    }
    for Reach { what, extent } in errors.sorted().into_iter().flat_map(|error| &error.reaches) {
        let far = match extent {
            ReachExtent::Cells(runs) => {
                let cells: u32 = runs.iter().map(|CellRun { columns: [first, last], .. }| last - first + 1).sum();
                format!("reaches {cells} cells")
            }
            ReachExtent::Turn { reached_deg, asked_deg, .. } => format!("turns {reached_deg} of {asked_deg} deg"),
            ReachExtent::Pose([x_um, y_um, _]) => format!("comes to ({x_um:.1}, {y_um:.1}) um"),
        };
        line.push_str(&format!(", `{what}` {far}"));
    }
    line + "\n"
}

/// The programs of a stage, by path.
fn programs(stage: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus").join(stage);
    let entries =
        fs::read_dir(&folder).expect("the corpus is there").map(|entry| entry.expect("it can be listed").path());
    let is_program = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "twz");
    let mut programs: Vec<PathBuf> = entries.filter(is_program).collect();
    programs.sort();
    programs
}

fn hold(stage: &str, least: usize) {
    let programs = programs(stage);
    assert!(programs.len() >= least, "{} cases in `{stage}`", programs.len());
    let update = std::env::var_os("TWEEZE_UPDATE").is_some();
    let mut wrong = String::new();
    for path in programs {
        let (reported, kept) = (report(&case(&path)), path.with_extension("txt"));
        if update {
            fs::write(&kept, &reported).expect("the corpus can be written");
        }
        let expected = fs::read_to_string(&kept).unwrap_or_default();
        if reported != expected {
            wrong.push_str(&format!("{}: expected\n{expected}\nbut told\n{reported}\n", path.display()));
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn what_the_checker_says() {
    hold("check", 30);
}

#[test]
fn what_the_planner_says() {
    hold("plan", 8);
}

/// Findings and edits do not depend on whether lines end in LF or CRLF.
#[test]
fn line_ends_change_no_report() {
    let reported = |case: &Case| {
        let (sources, sink) = case.compile();
        let edits = |diagnostic: &Diagnostic| diagnostic.fix.iter().map(|edit| edit.text.clone()).collect::<Vec<_>>();
        let one = |diagnostic: &Diagnostic| format!("{}{:?}\n", human(diagnostic, &sources, LOOK), edits(diagnostic));
        sink.sorted().into_iter().map(one).collect::<String>()
    };
    let checked = programs("check").into_iter().map(|path| case(&path));
    for case in checked.chain(habits().into_iter().map(|(case, _)| case)) {
        let ended = |text: &String| text.replace('\n', "\r\n");
        let files = case.files.iter().map(|(name, text)| (name.clone(), ended(text))).collect();
        let other = Case { text: ended(&case.text), files, ..case.clone() };
        assert_eq!(reported(&other), reported(&case), "{}", case.name);
    }
}

/// A file of short programs with typical mistakes of a second person, each with its report: `#### NAME`, the program,
/// `----`, the report.
const HABITS: &str = "tests/corpus/habits.txt";

/// The programs of [`HABITS`] with their reports.
fn habits() -> Vec<(Case, String)> {
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(HABITS)).expect("the file is there");
    let parts = text.split("#### ").filter(|part| !part.is_empty());
    let read = |part: &str| {
        let (name, rest) = part.split_once('\n').expect("a name");
        let (program, report) = rest.split_once("----\n").expect("a program and its report");
        (Case { name: name.to_owned(), text: program.to_owned(), ..Case::default() }, report.to_owned())
    };
    parts.map(read).collect()
}

#[test]
fn what_is_said_of_the_habits_of_other_languages() {
    let cases = habits();
    assert!(cases.len() >= 90, "{} cases", cases.len());
    let mut text = String::new();
    let mut single = 0;
    for (case, _) in &cases {
        let (sources, sink) = case.compile();
        let found = sink.sorted();
        assert!(sink.errors() > 0, "{} is no mistake", case.name);
        single += usize::from(sink.errors() == 1);
        let reported: String = found.into_iter().map(|diagnostic| human(diagnostic, &sources, LOOK)).collect();
        text.push_str(&format!("#### {}\n{}----\n{reported}", case.name, case.text));
    }
    if std::env::var_os("TWEEZE_UPDATE").is_some() {
        fs::write(Path::new(env!("CARGO_MANIFEST_DIR")).join(HABITS), &text).expect("the file can be written");
    }
    assert!(100 * single >= 98 * cases.len(), "{single} of {} mistakes are one diagnostic", cases.len());
    let expected: String =
        habits().iter().map(|(case, report)| format!("#### {}\n{}----\n{report}", case.name, case.text)).collect();
    assert_same_lines(&expected, &text);
}

/// Compares reports line by line, so that a difference is easy to find.
fn assert_same_lines(expected: &str, reported: &str) {
    for (nth, (expected, reported)) in expected.lines().zip(reported.lines()).enumerate() {
        assert_eq!(expected, reported, "line {} of {HABITS}", nth + 1);
    }
    assert_eq!(expected.len(), reported.len());
}

/// Applies the edits of one diagnostic at a time: afterwards it is gone, and there is no new finding.
#[test]
fn edits_mend_what_they_belong_to() {
    let (mut mended, mut wrong) = (0, String::new());
    for stage in ["check", "plan"] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus").join(stage);
        let entries = fs::read_dir(folder).expect("the corpus is there");
        let paths = entries.map(|entry| entry.expect("it can be listed").path());
        for path in paths.filter(|path| path.extension().is_some_and(|extension| extension == "twz")) {
            mended += mends(&case(&path), &mut wrong);
        }
    }
    mended += habits().iter().map(|(case, _)| mends(case, &mut wrong)).sum::<usize>();
    assert!(wrong.is_empty(), "{wrong}");
    assert!(mended >= 100, "{mended} diagnostics");
}

/// Programs in which a further mistake appears only once the first one is fixed.
const HIDES_MORE: [&str; 5] = [
    "k_use_file_noquote.twz",
    "slip_require_lt.twz",
    "slip_sphere.twz",
    "slip_unqualified.twz",
    "wire_misspelt_instrument.twz",
];

/// Fixes a program in each way that its diagnostics suggest; returns the number of ways.
fn mends(broken: &Case, wrong: &mut String) -> usize {
    let (_, sink) = broken.compile();
    let found = sink.sorted();
    let count = |all: &[&Diagnostic], one: &Diagnostic| all.iter().filter(|other| other.title == one.title).count();
    let own = |diagnostic: &&&Diagnostic| diagnostic.fix.first().is_some_and(|edit| edit.span.file.0 == 0);
    for diagnostic in found.iter().filter(own) {
        let text = diagnostic.apply_fix(&broken.text).expect("the edits are apart and in order");
        let (_, again) = Case { text: text.clone(), ..broken.clone() }.compile();
        let left = again.sorted();
        let case = format!("{}: {}\n{text}", broken.name, diagnostic.title);
        if count(&left, diagnostic) >= count(&found, diagnostic) {
            wrong.push_str(&format!("{case}\nis not mended\n"));
        }
        let new: Vec<&str> =
            left.iter().filter(|one| one.is_error() && count(&found, one) == 0).map(|one| one.title.as_str()).collect();
        let has_more = HIDES_MORE.contains(&broken.name.as_str());
        if new.is_empty() == has_more {
            wrong.push_str(&format!("{case}\n{new:?}\n"));
        }
    }
    found.iter().filter(own).count()
}
