//! Columns: padding of the parts of lines, indentation, and columns of comments.

use super::layout::{Alignment, CanonicalLine, Indent};
use super::token::{FormatToken, TokenKind};
use unicode_width::UnicodeWidthStr;

/// Column of comments after code, counted from 0, if the code leaves room.
const COMMENT_COLUMN: usize = 38;

/// Least number of spaces before a comment in that column.
const LEAST_GAP: usize = 2;

/// Spaces between the longest code and the comments if they do not fit into that column.
const WIDE_GAP: usize = 4;

/// Prints lines as text.
pub(super) fn print(lines: &[CanonicalLine]) -> String {
    let widths = part_widths(lines);
    let mut indents: Vec<usize> = Vec::with_capacity(lines.len());
    for line in lines {
        let indent = match line.indent {
            Indent::Margin => 0,
            Indent::Beyond { line, blanks } => indents[line] + blanks,
            Indent::Below { line, part, byte } => indents[line] + column(&lines[line], &widths[line], part, byte),
        };
        indents.push(indent);
    }
    let code_width = |index: usize| {
        let parts = &lines[index].parts;
        let last = parts.len().saturating_sub(1);
        indents[index] + column(&lines[index], &widths[index], last, parts.last().map_or(0, String::len))
    };
    let comments = comment_columns(lines, code_width);
    let mut text = String::new();
    for (index, line) in lines.iter().enumerate() {
        if line.after_gap {
            text.push('\n');
        }
        if let Some(kept) = line.kept {
            text.push_str(kept);
            text.push('\n');
            continue;
        }
        let start = text.len();
        pad(&mut text, indents[index]);
        print_parts(&mut text, line, &widths[index]);
        if let Some(comment) = line.comment {
            if !line.parts.is_empty() {
                text.truncate(text.trim_end().len());
                let printed = text[start..].width();
                pad(&mut text, comments[index].saturating_sub(printed).max(1));
            }
            text.push_str(&comment.text);
        }
        text.truncate(text.trim_end_matches(' ').len());
        text.push('\n');
    }
    text
}

fn pad(text: &mut String, blanks: usize) {
    text.extend(std::iter::repeat_n(' ', blanks));
}

fn print_parts(text: &mut String, line: &CanonicalLine, widths: &[usize]) {
    for (index, part) in line.parts.iter().enumerate() {
        if index > 0 {
            text.push_str(line.separator);
        }
        text.push_str(part);
        if index + 1 < line.parts.len() {
            pad(text, widths.get(index).copied().unwrap_or(0).saturating_sub(part.width()));
        }
    }
}

/// The column of a byte of a line, counted from its indent.
fn column(line: &CanonicalLine, widths: &[usize], part: usize, byte: usize) -> usize {
    let before = line.parts.iter().take(part).enumerate();
    let before: usize = before
        .map(|(index, text)| text.width().max(widths.get(index).copied().unwrap_or(0)) + line.separator.len())
        .sum();
    before + line.parts.get(part).map_or(0, |text| text[..byte].width())
}

/// The width to which each part of each line is padded.
fn part_widths(lines: &[CanonicalLine]) -> Vec<Vec<usize>> {
    let mut widths: Vec<Vec<usize>> = vec![Vec::new(); lines.len()];
    let mut tables: Vec<Vec<usize>> = Vec::new();
    let mut runs: Vec<Vec<usize>> = Vec::new();
    let mut is_open = false;
    for (index, line) in lines.iter().enumerate() {
        match line.alignment {
            Alignment::Table(number) => {
                tables.resize_with(tables.len().max(number + 1), Vec::new);
                tables[number].push(index);
                is_open = false;
            }
            Alignment::Alone => is_open &= line.goes_on && !line.after_gap,
            Alignment::Field | Alignment::Object(_) | Alignment::Device | Alignment::Wire => {
                let first = runs.last().and_then(|run| run.first()).map(|first| &lines[*first]);
                let continues = is_open
                    && !line.after_gap
                    && first.is_some_and(|first| first.alignment == line.alignment && first.indent == line.indent);
                match runs.last_mut().filter(|_| continues) {
                    Some(run) => run.push(index),
                    None => runs.push(vec![index]),
                }
                is_open = true;
            }
        }
    }
    // Entries with a doc comment of their own are not a list to be read down, so they are not aligned.
    let is_doc = |line: &CanonicalLine| is_doc_alone(line);
    runs.retain(|run| run[0] == 0 || lines[run[0]].after_gap || !is_doc(&lines[run[0] - 1]));
    for group in tables.iter().chain(&runs) {
        let parts = group.iter().map(|line| lines[*line].parts.len()).max().unwrap_or(0);
        let width = |part: usize| group.iter().filter_map(|line| lines[*line].parts.get(part)).map(|p| p.width()).max();
        let wide: Vec<usize> = (0..parts).map(|part| width(part).unwrap_or(0)).collect();
        for line in group {
            widths[*line].clone_from(&wide);
        }
    }
    widths
}

fn is_doc_alone(line: &CanonicalLine) -> bool {
    let is_doc = |comment: &FormatToken| comment.kind == TokenKind::Doc;
    line.parts.is_empty() && line.comment.is_some_and(is_doc)
}

/// The column of the comment after each line: the same for consecutive lines.
fn comment_columns(lines: &[CanonicalLine], code_width: impl Fn(usize) -> usize) -> Vec<usize> {
    let mut columns = vec![0; lines.len()];
    let mut start = 0;
    while start < lines.len() {
        let has_both = |line: &CanonicalLine| line.comment.is_some() && !line.parts.is_empty();
        let length = lines[start..]
            .iter()
            .enumerate()
            .take_while(|(index, line)| has_both(line) && (*index == 0 || !line.after_gap))
            .count();
        let run = start..start + length;
        let widest = run.clone().map(&code_width).max().unwrap_or(0);
        let column = if widest + LEAST_GAP <= COMMENT_COLUMN { COMMENT_COLUMN } else { widest + WIDE_GAP };
        columns[run].fill(column);
        start += length.max(1);
    }
    columns
}
