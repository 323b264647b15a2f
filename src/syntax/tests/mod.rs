use super::tree::*;
use super::*;
use crate::diagnostic::Code;
use crate::source::Span;
use proptest::prelude::*;

mod forms;
mod mistakes;
mod spans;

/// Parses a text; returns its tree and its findings by place.
fn read(text: &str) -> (Tree, Vec<crate::diagnostic::Diagnostic>) {
    let mut sink = Sink::default();
    let tree = parse(FileId(0), text, &mut sink);
    let findings = sink.sorted().into_iter().cloned().collect();
    (tree, findings)
}

/// The codes of a text's findings, with the text that each points at.
fn found(text: &str) -> Vec<(&'static str, String)> {
    let (_, findings) = read(text);
    let place = |span: Option<Span>| span.map_or(String::new(), |span| text[span.range()].to_owned());
    findings.iter().map(|finding| (finding.code.name(), place(finding.span()))).collect()
}

/// The tree of a text that must have no findings.
fn sound(text: &str) -> Tree {
    let (tree, findings) = read(text);
    assert!(findings.is_empty(), "{text}\n{findings:#?}");
    tree
}

/// The blocks of a page that are fenced with a given info string.
fn fenced<'p>(page: &'p str, info: &str) -> Vec<&'p str> {
    let opening = format!("```{info}\n");
    page.split(opening.as_str()).skip(1).filter_map(|rest| rest.split("\n```").next()).collect()
}

#[test]
fn every_page_of_a_code_fails_with_it_and_is_mended() {
    for &code in Code::ALL.iter().filter(|code| code.name().starts_with("E01")) {
        let page = code.page();
        assert!(page.starts_with(&format!("# {code}: {}\n", code.summary())), "{code} has another title");
        let (fails, mended) = (fenced(page, "twz fails"), fenced(page, "twz mended"));
        assert_eq!((fails.len(), mended.len()), (1, 1), "{code}");
        let codes: Vec<_> = read(fails[0]).1.iter().map(|finding| finding.code).collect();
        assert_eq!(codes, [code], "{}", fails[0]);
        sound(mended[0]);
    }
}
