//! Excerpt of a file for a report: the lines around the labels, with long lines cropped and overlapping labels
//! separated.
//!
//! A report is drawn from this small copy instead of the file, so that a line of a megabyte prints as a few words and
//! the cost of a report depends only on what it shows.

use super::Label;
use super::plain::{is_unprintable, plain, shortened};
use crate::source::SourceFile;
use miette::{LabeledSpan, MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents};
use std::collections::BTreeSet;
use std::ops::Range;

/// Lines shown above and below each label.
pub const CONTEXT_LINES: usize = 1;

/// Longer lines are cropped, in characters.
const MAX_LINE_CHARACTERS: usize = 160;

/// Characters of a cropped line that are shown on each side of a label.
const AROUND: usize = 40;

/// Characters of a label that are shown on a cropped line.
const MAX_LABEL_CHARACTERS: usize = 60;

/// Greatest number of characters of a file's name that are shown.
const MAX_NAME_CHARACTERS: usize = 400;

/// Some lines of one file.
pub struct Excerpt {
    name: String,
    text: String,
    lines: Vec<ExcerptLine>,
    /// For each mark, its byte in `text` and its column in the file, both from 0.
    columns: Vec<(usize, usize)>,
}

/// One line of an excerpt.
struct ExcerptLine {
    /// Line number, from 1.
    number: u32,
    /// Its range in the excerpt's text, including the line end.
    place: Range<usize>,
}

/// A label on one line; its range is first in the file's bytes, later in the excerpt's.
struct Mark {
    place: Range<usize>,
    text: String,
    rank: MarkRank,
}

/// Whether the diagnostic points at this mark.
#[derive(Clone, Copy, PartialEq, Eq)]
enum MarkRank {
    First,
    Further,
}

impl Excerpt {
    /// The excerpt around some labels, which must be in this file, and the labels at their places in the excerpt.
    pub fn of(file: &SourceFile, labels: &[&Label]) -> (Excerpt, Vec<LabeledSpan>) {
        let mut marks = apart(labels.iter().enumerate().map(|(index, label)| mark(file, label, index)).collect());
        let mut excerpt = Excerpt {
            name: plain(&shortened(&file.shown, MAX_NAME_CHARACTERS)).into_owned(),
            text: String::new(),
            lines: Vec::new(),
            columns: Vec::with_capacity(marks.len()),
        };
        let mut numbers: BTreeSet<u32> = BTreeSet::new();
        for mark in &marks {
            let line = file.position(mark.place.start as u32).line;
            numbers.extend(line.saturating_sub(CONTEXT_LINES as u32).max(1)..=line + CONTEXT_LINES as u32);
        }
        let places: Vec<Range<usize>> = marks.iter().map(|mark| mark.place.clone()).collect();
        for number in numbers {
            let Some(line) = file.line(number) else { continue };
            let inside = |place: &Range<usize>| line.start <= place.start && place.start <= line.end;
            let here: Vec<usize> = (0..places.len()).filter(|index| inside(&places[*index])).collect();
            excerpt.push(file, number, line, &here, &places, &mut marks);
        }
        let spans = marks.into_iter().map(|mark| {
            let span = SourceSpan::from((mark.place.start, mark.place.len()));
            match mark.rank {
                MarkRank::First => LabeledSpan::new_primary_with_span(Some(mark.text), span),
                MarkRank::Further => LabeledSpan::new_with_span(Some(mark.text), span),
            }
        });
        let spans = spans.collect();
        (excerpt, spans)
    }

    /// Adds a line, or the part of it that is kept, and moves its marks to the excerpt.
    fn push(
        &mut self,
        file: &SourceFile,
        number: u32,
        line: Range<usize>,
        here: &[usize],
        places: &[Range<usize>],
        marks: &mut [Mark],
    ) {
        let start = self.text.len();
        let marked: Vec<Range<usize>> = here.iter().map(|index| places[*index].clone()).collect();
        let kept = kept(&file.text, &line, &marked);
        for window in &kept {
            if window.start > line.start {
                self.text.push('…');
            }
            for index in
                here.iter().copied().filter(|index| (window.start..=window.end).contains(&places[*index].start))
            {
                let place = &places[index];
                let before = shown(&file.text[window.start..place.start]);
                let end = place.end.min(window.end);
                let at = self.text.len() + before.len();
                marks[index].place = at..at + shown(&file.text[place.start..end]).len();
                self.columns.push((at, file.position(place.start as u32).column as usize - 1));
            }
            self.text.push_str(&shown(&file.text[window.clone()]));
        }
        if kept.last().is_some_and(|window| window.end < line.end) {
            self.text.push('…');
        }
        self.text.push('\n');
        self.lines.push(ExcerptLine { number, place: start..self.text.len() });
    }

    fn line_at(&self, offset: usize) -> Option<usize> {
        let line = self.lines.partition_point(|line| line.place.end <= offset);
        (line < self.lines.len()).then_some(line)
    }

    /// The lines `first..=last`, extended by up to `before` and `after` lines while they are consecutive in the file.
    fn widened(&self, first: usize, last: usize, before: usize, after: usize) -> (usize, usize) {
        let follows = |line: usize| self.lines[line].number == self.lines[line - 1].number + 1;
        let (mut first, mut last) = (first, last);
        for _ in 0..before {
            first -= usize::from(first > 0 && follows(first));
        }
        for _ in 0..after {
            last += usize::from(last + 1 < self.lines.len() && follows(last + 1));
        }
        (first, last)
    }
}

impl SourceCode for Excerpt {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        before: usize,
        after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let end = span.offset() + span.len().saturating_sub(1);
        let (Some(first), Some(last)) = (self.line_at(span.offset()), self.line_at(end)) else {
            return Err(MietteError::OutOfBounds);
        };
        if self.lines[last].number - self.lines[first].number != (last - first) as u32 {
            return Err(MietteError::OutOfBounds);
        }
        let (first, last) = self.widened(first, last, before, after);
        let place = self.lines[first].place.start..self.lines[last].place.end;
        let column = self.columns.iter().find(|(at, _)| *at == span.offset()).map_or(0, |(_, column)| *column);
        let column = if before == 0 { column } else { 0 };
        Ok(Box::new(MietteSpanContents::new_named(
            self.name.clone(),
            &self.text.as_bytes()[place.clone()],
            SourceSpan::from((place.start, place.len())),
            self.lines[first].number as usize - 1,
            column,
            last - first + 1,
        )))
    }
}

/// A label cut to its first line. An empty span, and one at the end of the file, would draw nothing; they are widened
/// to the nearest character.
fn mark(file: &SourceFile, label: &Label, index: usize) -> Mark {
    let text = &file.text;
    let start = (label.span.start as usize).max(file.start());
    let (mut start, end) = (start, (label.span.end as usize).max(start));
    let first_line = text[start..end].find('\n').map_or(end, |at| start + at);
    let mut end = first_line.max(start);
    if start == end {
        end += text[start..].chars().next().filter(|next| *next != '\n').map_or(0, char::len_utf8);
    }
    if start == end && start > file.start() {
        start -= text[..start].chars().next_back().map_or(0, char::len_utf8);
    }
    let rank = if index == 0 { MarkRank::First } else { MarkRank::Further };
    Mark { place: start..end, text: plain(&label.text).into_owned(), rank }
}

/// Separates nested labels, which the renderer draws wrongly: the outer one is shortened in favour of the inner one,
/// and two at the same place are merged.
fn apart(mut marks: Vec<Mark>) -> Vec<Mark> {
    marks.sort_by_key(|mark| (mark.place.start, mark.place.end));
    let mut result: Vec<Mark> = Vec::with_capacity(marks.len());
    for mut mark in marks {
        match result.last_mut() {
            Some(last) if mark.place.start < last.place.end => {
                if mark.place.start > last.place.start {
                    last.place.end = mark.place.start;
                    result.push(mark);
                } else if mark.place.end > last.place.end {
                    mark.place.start = last.place.end;
                    result.push(mark);
                } else {
                    last.text = format!("{}; {}", last.text, mark.text);
                    last.rank = if mark.rank == MarkRank::First { MarkRank::First } else { last.rank };
                }
            }
            Some(_) | None => result.push(mark),
        }
    }
    result
}

/// The parts of a line that are shown: the whole line, or a window around each mark.
fn kept(text: &str, line: &Range<usize>, marks: &[Range<usize>]) -> Vec<Range<usize>> {
    let is_short = text[line.clone()].chars().nth(MAX_LINE_CHARACTERS).is_none();
    if is_short {
        return vec![line.clone()];
    }
    let mut kept: Vec<Range<usize>> = Vec::with_capacity(marks.len().max(1));
    if marks.is_empty() {
        kept.push(line.start..forward(text, line.start, MAX_LINE_CHARACTERS, line.end));
    }
    for mark in marks {
        let label_end = mark.end.min(forward(text, mark.start, MAX_LABEL_CHARACTERS, line.end));
        let window = backward(text, mark.start, AROUND, line.start)..forward(text, label_end, AROUND, line.end);
        match kept.last_mut() {
            Some(last) if window.start <= last.end => last.end = window.end.max(last.end),
            Some(_) | None => kept.push(window),
        }
    }
    kept
}

/// The offset `characters` further on, but at most `limit`.
fn forward(text: &str, from: usize, characters: usize, limit: usize) -> usize {
    text[from..limit].char_indices().nth(characters).map_or(limit, |(at, _)| from + at)
}

/// The offset `characters` back, but at least `limit`.
fn backward(text: &str, from: usize, characters: usize, limit: usize) -> usize {
    text[limit..from].char_indices().rev().nth(characters.saturating_sub(1)).map_or(limit, |(at, _)| limit + at)
}

/// The text with characters that would control the terminal replaced.
fn shown(text: &str) -> String {
    let replace = |character: char| if is_unprintable(character) && character != '\t' { '\u{fffd}' } else { character };
    text.chars().map(replace).collect()
}

#[cfg(test)]
mod tests;
