use crate::diagnostic::render::{Characters, Colour, Look, human};
use crate::diagnostic::{Code, Diagnostic};
use crate::source::{Sources, Span};

const LOOK: Look = Look { colour: Colour::Plain, characters: Characters::Unicode, width: 100 };

fn report(text: &str, labels: &[(usize, usize, &str)]) -> String {
    let mut sources = Sources::default();
    let file = sources.add("a.twz", text);
    let diagnostic = Diagnostic::new(Code::E0201, "a title");
    let add = |diagnostic: Diagnostic, (start, end, text): &(usize, usize, &str)| {
        diagnostic.label(Span::new(file, *start, *end), *text)
    };
    human(&labels.iter().fold(diagnostic, add), &sources, LOOK)
}

#[test]
fn a_megabyte_line_prints_a_few_words_round_the_label() {
    let text = format!("{}HERE{}\n", "ä ".repeat(300_000), " b".repeat(300_000));
    let at = text.find("HERE").expect("it was put there");
    let report = report(&text, &[(at, at + 4, "look")]);
    assert!(report.len() < 2_000, "{} bytes", report.len());
    assert!(report.contains("HERE") && report.contains("look") && report.contains('…'));
    assert!(report.contains("a.twz:1:600001"), "{report}");
}

#[test]
fn a_label_of_a_megabyte_is_cropped() {
    let text = "x".repeat(1_000_000);
    let report = report(&text, &[(0, text.len(), "all of it")]);
    assert!(report.len() < 2_000, "{} bytes", report.len());
    assert!(report.contains("all of it"));
}

#[test]
fn a_line_that_is_just_short_enough_is_shown_whole() {
    let text = "y".repeat(super::MAX_LINE_CHARACTERS);
    assert!(report(&text, &[(0, 1, "here")]).contains(&text));
    let longer = format!("{text}y");
    assert!(!report(&longer, &[(0, 1, "here")]).contains(&longer));
}

#[test]
fn far_labels_are_shown_apart_with_their_own_line_numbers() {
    let text = "line\n".repeat(5_000);
    let report = report(&text, &[(4_000 * 5, 4_000 * 5 + 4, "second"), (0, 4, "first")]);
    assert!(report.contains("4001 │ line") && report.contains(" 1 │ line"), "{report}");
    assert!(!report.contains("2500 │"), "{report}");
    assert!(report.contains("a.twz:4001:1"), "{report}");
}

#[test]
fn two_labels_far_apart_on_one_long_line_are_both_shown() {
    let text = format!("FIRST{}SECOND", " .".repeat(10_000));
    let at = text.len() - 6;
    let report = report(&text, &[(0, 5, "one"), (at, at + 6, "two")]);
    assert!(report.contains("FIRST") && report.contains("SECOND"), "{report}");
    assert!(report.contains("one") && report.contains("two"), "{report}");
}

#[test]
fn labels_in_one_another_are_put_apart() {
    let report = report("move to (1, 2)\n", &[(0, 14, "the step"), (8, 14, "the cell"), (8, 14, "again")]);
    assert!(report.contains("the step") && report.contains("the cell; again"), "{report}");
}

#[test]
fn characters_that_command_the_terminal_are_replaced() {
    let report = report("let \u{1b}[31m = 1\n", &[(4, 5, "here")]);
    assert!(!report.contains('\u{1b}'), "{report}");
}

#[test]
fn an_empty_label_at_the_end_of_a_file_is_shown() {
    assert!(report("task\n", &[(5, 5, "ends here")]).contains("ends here"));
    assert!(report("task", &[(4, 4, "ends here")]).contains("ends here"));
    assert!(report("", &[(0, 0, "nothing")]).contains("a title"));
}
