//! Files, spans and line/column arithmetic; no other module does this arithmetic.
//!
//! A [`Span`] is a range of bytes in one file of a [`Sources`]; everything else in the compiler carries spans and
//! converts them here to the lines and columns of messages.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::Arc;

/// Largest file that is read, in bytes: spans count bytes in `u32`, and a script of this size is a mistake.
pub const MAX_FILE_BYTES: usize = 16 * 1024 * 1024;

/// Prefix of the file name of a setting.
const SETTING: &str = "--set ";

/// Identifies one file of a [`Sources`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
pub struct FileId(pub u32);

/// A range of bytes `start..end` in one file; `start <= end`, both on character boundaries.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
pub struct Span {
    pub file: FileId,
    pub start: u32,
    pub end: u32,
}

impl fmt::Debug for Span {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}..{}", self.file.0, self.start, self.end)
    }
}

impl Span {
    /// The bytes `start..end` of `file`. Offsets beyond `u32` cannot occur: files are limited to [`MAX_FILE_BYTES`].
    pub fn new(file: FileId, start: usize, end: usize) -> Self {
        Span { file, start: start as u32, end: end as u32 }
    }

    /// The smallest span that holds both; `other` must be of the same file.
    pub fn to(self, other: Span) -> Span {
        assert_eq!(self.file, other.file);
        Span { file: self.file, start: self.start.min(other.start), end: self.end.max(other.end) }
    }

    /// The empty span at this one's end.
    pub fn after(self) -> Span {
        Span { start: self.end, ..self }
    }

    /// Whether `other` lies within this span.
    pub fn contains(self, other: Span) -> bool {
        self.file == other.file && self.start <= other.start && other.end <= self.end
    }

    /// The byte range, for slicing the file's text.
    pub fn range(self) -> std::ops::Range<usize> {
        self.start as usize..self.end as usize
    }
}

/// A line and a column, both from 1; columns count characters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Position {
    pub line: u32,
    pub column: u32,
}

/// Origin of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Origin {
    User,
    /// The standard library: taken as it is, without warnings.
    Library,
    /// The value of a `--set`.
    Setting,
}

/// One file of a program.
#[derive(Debug, Clone)]
pub struct SourceFile {
    /// The name in outputs: relative to the program's folder (`bench.twz`, `../lab/bench.twz`), with `/` on every
    /// system, so that outputs do not depend on where the program is; `std.dimibot` for the standard library.
    pub name: String,
    /// The name in messages: the path as it was typed, or derived from that.
    pub shown: String,
    pub origin: Origin,
    pub text: Arc<str>,
    line_starts: Vec<u32>,
}

impl SourceFile {
    fn new(name: String, shown: String, origin: Origin, text: Arc<str>) -> Self {
        let starts = text.bytes().enumerate().filter(|&(_, byte)| byte == b'\n').map(|(at, _)| at as u32 + 1);
        let line_starts = std::iter::once(0).chain(starts).collect();
        SourceFile { name, shown, origin, text, line_starts }
    }

    /// The line and column of a byte offset; an offset past the end counts as the end.
    pub fn position(&self, offset: u32) -> Position {
        let offset = offset.min(self.text.len() as u32);
        let line = self.line_starts.partition_point(|&start| start <= offset) - 1;
        let start = (self.line_starts[line] as usize).max(self.start()).min(offset as usize);
        let column = self.text[start..offset as usize].chars().count() as u32 + 1;
        Position { line: line as u32 + 1, column }
    }

    /// Offset of the text that editors show: after a byte order mark.
    pub fn start(&self) -> usize {
        if self.text.starts_with('\u{feff}') { '\u{feff}'.len_utf8() } else { 0 }
    }

    /// The byte range of a line, counted from 1, as editors show it, without its line end; `None` past the last line.
    pub fn line(&self, number: u32) -> Option<std::ops::Range<usize>> {
        let index = (number as usize).checked_sub(1)?;
        let start = (*self.line_starts.get(index)? as usize).max(self.start());
        let end = self.line_starts.get(index + 1).map_or(self.text.len(), |next| *next as usize - 1);
        let is_crlf = end > start && self.text.as_bytes()[end - 1] == b'\r';
        Some(start..end - usize::from(is_crlf))
    }
}

/// Resolves `path` relative to the file named `from`, both with `/`, and removes `.` and `folder/..`, so that one
/// file has one name. An absolute path stays absolute: it is part of the program's text, and so the same wherever the
/// program is.
pub fn beside(from: &str, path: &str) -> String {
    let is_absolute = path.starts_with('/') || std::path::Path::new(path).is_absolute();
    let folder = from.rfind('/').map_or("", |end| &from[..=end]);
    let whole = if is_absolute { path.to_owned() } else { format!("{folder}{path}") };
    let root = if whole.starts_with('/') { "/" } else { "" };
    let mut parts: Vec<&str> = Vec::new();
    for part in whole.split('/') {
        match part {
            "" | "." => {}
            ".." if parts.last().is_some_and(|last| *last != "..") => drop(parts.pop()),
            // The root's parent is the root.
            ".." if !root.is_empty() => {}
            part => parts.push(part),
        }
    }
    format!("{root}{}", parts.join("/"))
}

/// All files of one compilation, in the order in which they were loaded; the first is the program's own.
#[derive(Debug, Clone, Default)]
pub struct Sources {
    files: Vec<SourceFile>,
}

impl Sources {
    /// Adds a file of the user with one name for messages and outputs; returns its id.
    pub fn add(&mut self, name: impl Into<String>, text: impl Into<Arc<str>>) -> FileId {
        let name = name.into();
        self.add_as(name.clone(), name, Origin::User, text)
    }

    /// Adds a file with its name for outputs, its name for messages, and its origin; returns its id.
    pub fn add_as(&mut self, name: String, shown: String, origin: Origin, text: impl Into<Arc<str>>) -> FileId {
        self.files.push(SourceFile::new(name, shown, origin, text.into()));
        FileId(self.files.len() as u32 - 1)
    }

    /// The file of an id that this collection returned.
    pub fn file(&self, id: FileId) -> &SourceFile {
        &self.files[id.0 as usize]
    }

    /// Every file with its id, in order.
    pub fn files(&self) -> impl Iterator<Item = (FileId, &SourceFile)> {
        self.files.iter().enumerate().map(|(index, file)| (FileId(index as u32), file))
    }

    /// Adds the value of a `--set`, as a file of its own.
    pub fn add_setting(&mut self, name: &str, value: &str) -> FileId {
        let shown = format!("{SETTING}{name}");
        self.add_as(shown.clone(), shown, Origin::Setting, value)
    }

    /// The names and values of `--set`, in the order given.
    pub fn settings(&self) -> impl Iterator<Item = (&str, &str)> {
        let settings = self.files.iter().filter(|file| file.origin == Origin::Setting);
        settings.map(|file| (file.name.trim_start_matches(SETTING), &*file.text))
    }

    /// The text of a span.
    pub fn text(&self, span: Span) -> &str {
        &self.file(span.file).text[span.range()]
    }

    /// Line and column of the beginning of a span.
    pub fn position(&self, span: Span) -> Position {
        self.file(span.file).position(span.start)
    }
}

/// A value with its place in the source.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Spanned<T> {
    pub value: T,
    #[serde(skip)]
    pub span: Span,
}

impl<T> Spanned<T> {
    /// Pairs a value with its place.
    pub fn new(value: T, span: Span) -> Self {
        Spanned { value, span }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_count_characters_not_bytes() {
        let mut sources = Sources::default();
        let file = sources.add("a.twz", "let a = 1\nlet µ = 35 µm\n");
        let text = sources.file(file).text.clone();
        let offset = text.find("35").expect("the number is there");
        assert_eq!(sources.position(Span::new(file, offset, offset + 2)), Position { line: 2, column: 9 });
    }

    #[test]
    fn names_are_seen_from_the_programs_folder() {
        for (from, path, name) in [
            ("a.twz", "b.twz", "b.twz"),
            ("a.twz", "./lab//b.twz", "lab/b.twz"),
            ("lab/b.twz", "../a.twz", "a.twz"),
            ("lab/b.twz", "../../c.twz", "../c.twz"),
            ("../c.twz", "../d.twz", "../../d.twz"),
            ("../lab/c.twz", "d.twz", "../lab/d.twz"),
            ("lab/b.twz", "/opt/e.twz", "/opt/e.twz"),
            ("/opt/e.twz", "../../f.twz", "/f.twz"),
        ] {
            assert_eq!(beside(from, path), name, "{path} in {from}");
        }
    }

    #[test]
    fn an_offset_past_the_end_is_the_end() {
        let mut sources = Sources::default();
        let file = sources.add("a.twz", "x\n");
        assert_eq!(sources.file(file).position(99), Position { line: 2, column: 1 });
    }
}
