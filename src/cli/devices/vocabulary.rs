//! The checker's tables, printed for people.

use crate::device::instrument::{AuxiliarySort, Family};
use crate::device::{Assay, Kind, Together, Verb, Vocabulary, VocabularyField, WordChoice, shape::ShapeForm};
use crate::quantity::Dimension;
use std::fmt::Write;

/// The kinds, each with a first device to use.
pub fn kinds() -> String {
    let mut text = String::new();
    for kind in Kind::ALL {
        let vocabulary = kind.vocabulary();
        let (file, device) = vocabulary.library;
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{:<16} {}\n{:<16} use {file}, then `device bot : {device} {{ … }}`",
            vocabulary.name, vocabulary.summary, ""
        );
    }
    text.push_str("\nInstruments to which channels are wired:\n\n");
    for family in Family::ALL {
        let (file, instrument) = family.library();
        let _ = writeln!(
            text,
            "{:<18} {}\n{:<18} use {file}, then `instrument NAME : {instrument}`",
            family.name(),
            wrapped(family.choice().doc, PAGE_WIDTH - 19).join(&format!("\n{:<18} ", "")),
            ""
        );
    }
    text.push_str("\nOther outputs of a bench, which steps of any task switch:\n");
    for sort in AuxiliarySort::ALL {
        let fields = sort.fields().iter().map(|field| format!("`{}`: {}", field.name, field.doc));
        let meaning =
            wrapped(&format!("{}; {}", sort.choice().doc, fields.collect::<Vec<_>>().join("; ")), PAGE_WIDTH - 19);
        let _ = writeln!(
            text,
            "\n{:<18} {}\n{:<18} {}",
            sort.name(),
            meaning.join(&format!("\n{:<18} ", "")),
            "",
            sort.example()
        );
    }
    text.push_str(
        "\n`tweeze devices KIND` lists fields, verbs, shapes and planners; `tweeze devices FAMILY` fields, outputs and wires.\n",
    );
    text
}

/// Everything that a kind offers.
pub fn page(vocabulary: &'static Vocabulary) -> String {
    let mut page = Page::default();
    page.text(&format!("{}: {}", vocabulary.name, vocabulary.summary));
    page.section("Fields of a device", vocabulary.fields.iter().map(field));
    page.section(
        "Settings of a task",
        common_settings(vocabulary)
            .into_iter()
            .chain(vocabulary.conditions.iter().map(verb))
            .chain(vocabulary.settings.iter().map(field)),
    );
    page.section(
        "Steps of a task",
        vocabulary.verbs.iter().map(verb).chain(together(vocabulary)).chain(assay(vocabulary)).chain(waits()),
    );
    page.section("minimize", vocabulary.objectives.iter().map(choice));
    page.section(
        "require",
        vocabulary
            .outcomes
            .iter()
            .map(|outcome| (outcome.name.to_owned(), format!("{}: {}", outcome.unit.dimension().name(), outcome.doc))),
    );
    page.section("using", vocabulary.planners.iter().map(|planner| (planner.name.to_owned(), planner.doc.to_owned())));
    page.section("In a scene", vocabulary.nouns.iter().map(|noun| (noun.name.to_owned(), noun.doc.to_owned())));
    let used = |form: &&ShapeForm| vocabulary.nouns.iter().any(|noun| noun.shapes.contains(form));
    page.section("Shapes", ShapeForm::ALL.iter().filter(used).map(|form| (shape(*form), form.choice().doc.to_owned())));
    page.text("\nChannels");
    for line in wrapped(vocabulary.channels, PAGE_WIDTH - 2) {
        page.text(&format!("  {line}"));
    }
    page.text
}

/// Everything that a family of instruments offers.
pub fn family_page(family: Family) -> String {
    let mut page = Page::default();
    page.text(&format!("{}: {}", family.name(), family.choice().doc));
    page.section("Fields of an instrument", family.fields().iter().map(field));
    page.text(&format!("\nOutputs\n  {}", family.outputs()));
    for (sort, to) in family.links() {
        page.section(&format!("Fields of a wire, or of all wires of a wiring: {to}"), sort.fields().iter().map(field));
    }
    let (file, instrument) = family.library();
    page.text(&format!("\nTo begin with: use {file}, then `instrument NAME : {instrument}`"));
    page.text(&format!("Played by: `tweeze build FILE.twz --emit {}`", family.format()));
    page.text
}

/// A page of sections, each a list of terms and their meanings.
#[derive(Default)]
struct Page {
    text: String,
}

/// Terms longer than this get a line of their own.
const TERM_WIDTH: usize = 30;

/// Width of a page, in characters.
const PAGE_WIDTH: usize = 100;

impl Page {
    fn text(&mut self, text: &str) {
        self.text.push_str(text);
        self.text.push('\n');
    }

    fn section(&mut self, title: &str, entries: impl IntoIterator<Item = (String, String)>) {
        self.text(&format!("\n{title}"));
        for (term, meaning) in entries {
            let mut lines = wrapped(&meaning, PAGE_WIDTH - TERM_WIDTH - 4).into_iter();
            if term.chars().count() > TERM_WIDTH {
                self.text(&format!("  {term}"));
            } else {
                let first = lines.next().unwrap_or_default();
                self.text(&format!("  {term:TERM_WIDTH$}  {first}"));
            }
            for line in lines {
                self.text(&format!("  {:TERM_WIDTH$}  {line}", ""));
            }
        }
    }
}

/// Wraps a text to lines of at most `width` characters, broken at spaces.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ') {
        match lines.last_mut().filter(|line| line.chars().count() + 1 + word.chars().count() <= width) {
            Some(line) => *line = format!("{line} {word}"),
            None => lines.push(word.to_owned()),
        }
    }
    lines
}

fn field(field: &VocabularyField) -> (String, String) {
    (field.term(), field.meaning())
}

fn verb(verb: &Verb) -> (String, String) {
    (verb.example.to_owned(), verb.meaning())
}

fn choice(choice: &WordChoice) -> (String, String) {
    (choice.name.to_owned(), choice.doc.to_owned())
}

fn together(vocabulary: &Vocabulary) -> Option<(String, String)> {
    let entry = || ("together { … }".to_owned(), "the goals in the braces at the same time".to_owned());
    match vocabulary.together {
        Together::Yes => Some(entry()),
        Together::No(_) => None,
    }
}

fn assay(vocabulary: &Vocabulary) -> Option<(String, String)> {
    let meaning =
        "the operations in the braces: those of one part follow each other; parts do not wait for one another";
    match vocabulary.assay {
        Assay::Yes => Some(("assay { … }".to_owned(), meaning.to_owned())),
        Assay::No => None,
    }
}

fn waits() -> [(String, String); 3] {
    [
        ("wait 10 ms", "nothing is switched for this time"),
        (
            "wait until card.port0.line5 for at most 5 s",
            "until a digital input is high, or low with `at low`; if it is not in time, the run is aborted",
        ),
        (
            "prompt \"add the sample\"",
            "asks the person at the bench and waits for the answer; `for at most 10 min` limits the wait",
        ),
    ]
    .map(|(form, meaning)| (form.to_owned(), meaning.to_owned()))
}

fn common_settings(vocabulary: &Vocabulary) -> Vec<(String, String)> {
    let default = vocabulary.objectives.first().map_or("", |objective| objective.name);
    let planner = vocabulary.planners.first().map_or("", |planner| planner.name);
    let mut settings = vec![
        ("minimize WHAT".to_owned(), format!("figure that the plan minimises (default {default})")),
        (
            "using PLANNER".to_owned(),
            format!("how the plan is searched; `using {planner} {{ expansions: 5000000 }}` sets its budget"),
        ),
    ];
    if vocabulary.state.is_some() {
        settings.push((
            "start at STATE".to_owned(),
            "where the device is (else where its last task left it, or its home)".to_owned(),
        ));
    }
    let outcome = vocabulary.outcomes.iter().find(|outcome| outcome.unit.dimension() == Dimension::TIME);
    let outcome = outcome.map_or("cost", |outcome| outcome.name);
    settings.push((
        "require CONDITION".to_owned(),
        format!("a limit that the plan must keep, such as `require {outcome} <= 400 ms`"),
    ));
    settings
}

fn shape(form: ShapeForm) -> String {
    let fields: Vec<String> =
        form.fields().iter().map(|field| format!("{}: {}", field.name, field.sort.text())).collect();
    format!("{} {{ {} }}", form.name(), fields.join(", "))
}
