//! Pages of `tweeze explain`: every code has one, and the programs on it do what the page says.
//!
//! A page has fenced blocks. ```` ```twz fails ```` is a program that reports the page's code and no other;
//! ```` ```twz mended ```` is the same program without an error or a warning. `set=name=value` and `task=name` after
//! either word are options of `build`. ```` ```twz file=lab.twz ```` is a file beside the program of the block before
//! it, which is itself named `main.twz`.

#[path = "book/mod.rs"]
mod book;
#[path = "support/case.rs"]
mod case;

use case::Case;
use std::fs;
use std::path::Path;
use tweeze::diagnostic::render::{Characters, Colour, Look, human};
use tweeze::diagnostic::{Code, Diagnostic};

/// Codes that a program alone cannot cause; they need a schedule broken by hand, or a file.
const WITHOUT_PROGRAMS: [&str; 2] = ["E07", "E08"];

/// What a program on a page demonstrates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Promise {
    Fails,
    Mended,
}

fn examples(code: Code) -> Vec<(Promise, Case)> {
    let mut examples: Vec<(Promise, Case)> = Vec::new();
    for block in code.page().split("\n```twz ").skip(1) {
        let (head, rest) = block.split_once('\n').unwrap_or_else(|| panic!("{code}: a fence without a block"));
        let (body, _) = rest.split_once("```").unwrap_or_else(|| panic!("{code}: a block that does not end"));
        let mut case = Case { name: "main.twz".to_owned(), text: body.to_owned(), ..Case::default() };
        let mut promise = None;
        for word in head.split_whitespace().filter_map(|word| case.take(word)).collect::<Vec<_>>() {
            match (word, word.strip_prefix("file=")) {
                ("fails", _) => promise = Some(Promise::Fails),
                ("mended", _) => promise = Some(Promise::Mended),
                (_, Some(name)) => {
                    let (_, owner) = examples.last_mut().unwrap_or_else(|| panic!("{code}: a file before its program"));
                    owner.files.insert(name.to_owned(), body.to_owned());
                }
                (other, None) => panic!("{code}: `{other}` means nothing after ```twz"),
            }
        }
        examples.extend(promise.map(|promise| (promise, case)));
    }
    examples
}

fn has_programs(code: Code) -> bool {
    !WITHOUT_PROGRAMS.iter().any(|prefix| code.name().starts_with(prefix))
}

#[test]
fn every_page_shows_a_program_that_fails_and_one_that_is_mended() {
    for code in Code::ALL.iter().copied().filter(|code| has_programs(*code)) {
        let promises: Vec<Promise> = examples(code).into_iter().map(|(promise, _)| promise).collect();
        assert_eq!(promises, [Promise::Fails, Promise::Mended], "{code}");
    }
}

#[test]
fn the_programs_do_what_their_page_says() {
    let look = Look { colour: Colour::Plain, characters: Characters::Unicode, width: 100 };
    let mut wrong = String::new();
    for code in Code::ALL.iter().copied() {
        for (promise, case) in examples(code) {
            let (sources, sink) = case.compile();
            let reported = sink.sorted();
            let is_kept = match promise {
                Promise::Fails => !reported.is_empty() && reported.iter().all(|diagnostic| diagnostic.code == code),
                Promise::Mended => reported.is_empty(),
            };
            if !is_kept {
                let reports: Vec<String> =
                    reported.iter().map(|diagnostic: &&Diagnostic| human(diagnostic, &sources, look)).collect();
                wrong.push_str(&format!("\n{code} {promise:?}:\n{}", reports.concat()));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn every_page_has_its_heading() {
    for code in Code::ALL.iter().copied() {
        let heading = format!("# {code}: {}\n", code.summary());
        assert!(code.page().starts_with(&heading), "the page of {code} begins with `{}`", heading.trim_end());
    }
}

#[test]
fn every_code_is_told_somewhere() {
    let mut text = String::new();
    read_all(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut text);
    // A verifier rule names its code in the table row of its sentence.
    for code in Code::ALL.iter() {
        let is_told = [format!("Code::{code}"), format!(" {code} \"")].iter().any(|reported| text.contains(reported));
        assert!(is_told, "nobody tells {code}");
    }
}

fn read_all(folder: &Path, text: &mut String) {
    for entry in fs::read_dir(folder).expect("the sources are there") {
        let path = entry.expect("the sources can be listed").path();
        if path.is_dir() {
            read_all(&path, text);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            text.push_str(&fs::read_to_string(&path).expect("sources are text"));
        }
    }
}
