//! The source map: each step of a schedule records its place and text in the program, and both are compared with the
//! source.
//!
//! Input: a schedule in which the other rules found nothing, and the files from which its claims, and their spans,
//! were derived. A viewer's `/log` and every reader of `schedule.json` take these texts for the program's own.

use super::rule::{Findings, Rule, Violation};
use crate::claims::{Claims, Job};
use crate::schedule::Schedule;
use crate::source::{FileId, SourceFile, Sources, Span};

/// A text of the program as recorded in a schedule.
struct RecordedText<'s> {
    step: usize,
    /// `step 2`, or `operation 3 of step 2`.
    what: String,
    start_ns: u64,
    text: &'s str,
    file: &'s str,
    line: u32,
    column: u32,
}

/// Compares the text and the place of every step, and of every operation in it, with the file.
pub(super) fn check(schedule: &Schedule, claims: &Claims, sources: &Sources, findings: &mut Findings) {
    let mut written = texts(schedule, claims);
    written.sort_by_key(|(span, _)| *span);
    let mut walk = LineCounter::default();
    findings.count_checks(Rule::SourceMap, written.len());
    for (span, recorded) in written {
        let RecordedText { step, ref what, start_ns, .. } = recorded;
        let Some((_, file)) = sources.files().find(|(id, _)| *id == span.file) else {
            let title = format!("{what} is from no file of the program");
            findings.push(Violation::new(Rule::SourceMap, start_ns, title).step(step));
            continue;
        };
        let (line, column) = walk.position(file, span);
        for (which, recorded, written) in differences(&recorded, file, span, line, column) {
            let title = format!("{what} has the {which} `{recorded}`, but the program has `{written}`");
            findings.push(
                Violation::new(Rule::SourceMap, start_ns, title).step(step).label(span, "as written in the program"),
            );
        }
    }
}

/// All texts of a schedule, each with its span in the program.
fn texts<'s>(schedule: &'s Schedule, claims: &Claims) -> Vec<(Span, RecordedText<'s>)> {
    let mut nth = vec![0; claims.jobs.len()];
    let spans: Vec<Vec<Span>> = claims.jobs.iter().map(Job::step_spans).collect();
    let mut written = Vec::with_capacity(schedule.steps.len());
    for (index, step) in schedule.steps.iter().enumerate() {
        let (plan, file) = (step.plan as usize, step.file.as_str());
        let operations = claims.jobs[plan].operation_spans(nth[plan]);
        let own = spans[plan][nth[plan]];
        nth[plan] += 1;
        let (text, what) = (step.text.as_str(), format!("step {index}"));
        let (start_ns, line, column) = (step.start_ns, step.line, step.column);
        written.push((own, RecordedText { step: index, what, start_ns, text, file, line, column }));
        for (place, (span, operation)) in operations.into_iter().zip(&step.operations).enumerate() {
            let (text, what) = (operation.text.as_str(), format!("operation {place} of step {index}"));
            let (start_ns, line, column) = (operation.start_ns, operation.line, operation.column);
            written.push((span, RecordedText { step: index, what, start_ns, text, file, line, column }));
        }
    }
    written
}

/// Line and column counter for spans in sorted order. It visits each character of a file once, since a line may be as
/// long as the file.
#[derive(Default)]
struct LineCounter {
    file: Option<FileId>,
    at: usize,
    /// From 0.
    line: usize,
    column: usize,
}

impl LineCounter {
    /// Line and column of a span's beginning, from 1; spans must come sorted.
    fn position(&mut self, file: &SourceFile, span: Span) -> (usize, usize) {
        if self.file != Some(span.file) {
            *self = LineCounter { file: Some(span.file), ..LineCounter::default() };
        }
        for c in file.text[self.at..span.start as usize].chars() {
            self.column = if c == '\n' { 0 } else { self.column + 1 };
            self.line += usize::from(c == '\n');
        }
        self.at = span.start as usize;
        (self.line + 1, self.column + 1)
    }
}

/// Name, recorded value and actual value of each field that differs.
fn differences(
    recorded: &RecordedText,
    file: &SourceFile,
    span: Span,
    line: usize,
    column: usize,
) -> Vec<(&'static str, String, String)> {
    let text: Vec<&str> = file.text[span.range()].split_whitespace().collect();
    let pairs = [
        ("text", recorded.text.to_owned(), text.join(" ")),
        ("file", recorded.file.to_owned(), file.name.clone()),
        ("line", recorded.line.to_string(), line.to_string()),
        ("column", recorded.column.to_string(), column.to_string()),
    ];
    pairs.into_iter().filter(|(_, recorded, written)| recorded != written).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{Verdict, verify_program};
    use super::*;
    use crate::check::Options;
    use crate::check::imports::NoFiles;
    use crate::compile::{CompileOutcome, ProgramSource, compile};
    use crate::diagnostic::Sink;
    use crate::schedule::{ScheduledOperation, ScheduledStep};

    const TEXT: &str =
        "use std.dimibot\ndevice bot : dimibot.femto_st\ntask go on bot {\n  wait 1 ms\n  move to (1,\n    1)\n}\n";

    /// A sound schedule with its claims and files.
    fn built(text: &str) -> (Schedule, Claims, Sources) {
        let (mut sources, mut sink) = (Sources::default(), Sink::default());
        let options = Options::default();
        let program = ProgramSource { name: "a.twz", text, library: &NoFiles, options: &options };
        let CompileOutcome::Compiled(compiled) = compile(&program, &mut sources, &mut sink, &mut ()) else {
            panic!("{:?}", sink.sorted())
        };
        let verified = &compiled.schedules[0];
        (verified.schedule().clone(), verified.claims().clone(), sources)
    }

    fn rules(schedule: &Schedule, claims: &Claims, sources: &Sources) -> Vec<Rule> {
        match verify_program(schedule.clone(), claims, sources) {
            Verdict::Accepted(_) => Vec::new(),
            Verdict::Rejected(violations) => violations.into_iter().map(|violation| violation.rule).collect(),
            Verdict::Inconclusive { why } => panic!("{why}"),
        }
    }

    #[test]
    fn each_word_of_an_operation_is_read_again_in_the_program() {
        let (sound, claims, sources) = built(
            "use std.electrode_array as ea\ndevice chip : ea.droplet_chip\nscene s {\n  part a : ea.droplet at (3, 3)\n}\n\
             task go on chip in s {\n  assay {\n    for i in 0..2 { move a to (4 + i, 3) }\n    incubate a at (5,\n      3) for 1 s\n  }\n}\n",
        );
        assert_eq!(rules(&sound, &claims, &sources), []);
        let places = sound.steps[0].operations.iter().map(|own| (own.text.as_str(), own.line, own.column));
        let expected =
            [("move a to (4 + i, 3)", 8, 21), ("move a to (4 + i, 3)", 8, 21), ("incubate a at (5, 3) for 1 s", 9, 5)];
        assert_eq!(places.collect::<Vec<_>>(), expected);
        let edits: [fn(&mut ScheduledOperation); 4] =
            [|own| own.text = "wash".to_owned(), |own| own.text.push(' '), |own| own.line += 1, |own| own.column -= 1];
        for (nth, edit) in edits.iter().enumerate() {
            for index in 0..3 {
                let mut forged = sound.clone();
                edit(&mut forged.steps[0].operations[index]);
                assert_eq!(rules(&forged, &claims, &sources), [Rule::SourceMap], "edit {nth} of operation {index}");
            }
        }
    }

    #[test]
    fn each_word_of_a_step_is_read_again_in_the_program() {
        let (sound, claims, sources) = built(TEXT);
        assert_eq!(rules(&sound, &claims, &sources), []);
        assert_eq!(sound.steps[1].text, "move to (1, 1)");
        let edits: [fn(&mut ScheduledStep); 6] = [
            |step| step.text = "move to safety".to_owned(),
            |step| step.text.push(' '),
            |step| step.file = "/etc/passwd".to_owned(),
            |step| step.line += 1,
            |step| step.column += 1,
            |step| step.column -= 1,
        ];
        for (nth, edit) in edits.iter().enumerate() {
            for index in 0..sound.steps.len() {
                let mut forged = sound.clone();
                edit(&mut forged.steps[index]);
                assert_eq!(rules(&forged, &claims, &sources), [Rule::SourceMap], "edit {nth} of step {index}");
            }
        }
    }
}
