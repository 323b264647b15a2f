//! The corpus: programs with the report that a person sees, beside each.
//!
//! `corpus/<stage>/*.twz` is compiled; the report, plain and 100 columns wide, must be the `.txt` of the same name. Its last line says
//! what the page of the failed build shows.
//! `TWEEZE_UPDATE=1` rewrites the reports: read the changes before committing them.
//!
//! A first line `// set=name=value task=name` gives the options of `build`. A line `// file lab.twz` ends the program, and
//! the rest is a file beside it.

#[path = "support/case.rs"]
mod case;

use case::Case;
use std::fs;
use std::path::{Path, PathBuf};
use tweeze::compile::partial;
use tweeze::diagnostic::render::{Characters, Colour, Look, human};
use tweeze::diagnostic::{Diagnostic, PlaceUnit, Sink, WrittenPlace};
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
    let told: String = sink.sorted().into_iter().map(|diagnostic| human(diagnostic, &sources, LOOK)).collect();
    told + &page(case, &sources, &sink)
}

/// What the page of a failed build shows: the steps that could be built, and the places that are marked.
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
    line + "\n"
}

fn hold(stage: &str, least: usize) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus").join(stage);
    let entries =
        fs::read_dir(&folder).expect("the corpus is there").map(|entry| entry.expect("it can be listed").path());
    let is_program = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "twz");
    let mut programs: Vec<PathBuf> = entries.filter(is_program).collect();
    programs.sort();
    assert!(programs.len() >= least, "{} cases in `{stage}`", programs.len());
    let update = std::env::var_os("TWEEZE_UPDATE").is_some();
    let mut wrong = String::new();
    for path in programs {
        let (told, kept) = (report(&case(&path)), path.with_extension("txt"));
        if update {
            fs::write(&kept, &told).expect("the corpus can be written");
        }
        let expected = fs::read_to_string(&kept).unwrap_or_default();
        if told != expected {
            wrong.push_str(&format!("{}: expected\n{expected}\nbut told\n{told}\n", path.display()));
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

/// Each word that a help asks for is put where the diagnostic points: the diagnostic is gone then.
#[test]
fn near_words_mend_what_they_are_near() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus/check");
    let paths = fs::read_dir(folder).expect("the corpus is there").map(|entry| entry.expect("it can be listed").path());
    let mut mended = 0;
    for path in paths.filter(|path| path.extension().is_some_and(|extension| extension == "twz")) {
        let broken = case(&path);
        let (_, sink) = broken.compile();
        let found = sink.sorted();
        let count = |all: &[&Diagnostic], one: &Diagnostic| all.iter().filter(|other| other.title == one.title).count();
        for diagnostic in &found {
            let Some(mend) = diagnostic.mend.as_ref().filter(|mend| mend.span.file.0 == 0) else { continue };
            let mut text = broken.text.clone();
            text.replace_range(mend.span.range(), &mend.word);
            let (_, again) = Case { text: text.clone(), ..broken.clone() }.compile();
            let left = count(&again.sorted(), diagnostic);
            assert!(left < count(&found, diagnostic), "{}: {}\n{text}", path.display(), diagnostic.title);
            mended += 1;
        }
    }
    assert!(mended >= 25, "{mended} words");
}
