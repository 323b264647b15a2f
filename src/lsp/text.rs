//! Texts as they are in the editor, and positions in them: lines from 0, columns in the unit that the client counts.

use lsp_types::{Position, Range, Uri};
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// Unit of columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnUnit {
    Byte,
    /// UTF-16 code units: an emoji is two, `µ` is one.
    Utf16,
}

/// A text with its lines.
#[derive(Debug, Clone)]
pub struct EditedText {
    text: String,
    /// Where each line begins, in bytes.
    lines: Vec<usize>,
}

impl EditedText {
    pub fn new(text: String) -> EditedText {
        // Editors also end a line at a CR alone.
        let ends =
            text.match_indices(['\n', '\r']).filter(|(at, end)| *end == "\n" || !text[at + 1..].starts_with('\n'));
        let lines = std::iter::once(0).chain(ends.map(|(at, _)| at + 1)).collect();
        EditedText { text, lines }
    }

    pub fn as_str(&self) -> &str {
        &self.text
    }

    /// Replaces a range, or the whole text if there is no range.
    pub fn change(&mut self, range: Option<Range>, new: &str, unit: ColumnUnit) {
        let Some(range) = range else {
            *self = EditedText::new(new.to_owned());
            return;
        };
        let [one, other] = [range.start, range.end].map(|place| self.offset(place, unit));
        let mut text = std::mem::take(&mut self.text);
        text.replace_range(one.min(other)..one.max(other), new);
        *self = EditedText::new(text);
    }

    /// Byte offset of a position: the end of the line for a column beyond it, the end of the text for a line beyond the
    /// last, and the beginning of the character for a column inside one.
    pub fn offset(&self, place: Position, unit: ColumnUnit) -> usize {
        let Some(&start) = self.lines.get(place.line as usize) else { return self.text.len() };
        let line = self.text[start..].split(['\n', '\r']).next().unwrap_or_default();
        let mut column = 0;
        for (at, character) in line.char_indices() {
            column += match unit {
                ColumnUnit::Byte => character.len_utf8(),
                ColumnUnit::Utf16 => character.len_utf16(),
            };
            if column > place.character as usize {
                return start + at;
            }
        }
        start + line.len()
    }

    /// Byte offset of a line and a column in characters, both from 0; positions beyond the text are treated as in
    /// [`Self::offset`].
    pub fn offset_of_character(&self, line: usize, column: usize) -> usize {
        let Some(&start) = self.lines.get(line) else { return self.text.len() };
        let line = self.text[start..].split(['\n', '\r']).next().unwrap_or_default();
        line.char_indices().nth(column).map_or(start + line.len(), |(at, _)| start + at)
    }

    /// Position of a byte offset, which must be a character boundary.
    pub fn position(&self, offset: usize, unit: ColumnUnit) -> Position {
        let line = self.lines.partition_point(|start| *start <= offset).saturating_sub(1);
        let before = self.text.get(self.lines[line]..offset).unwrap_or_default();
        let column = match unit {
            ColumnUnit::Byte => before.len(),
            ColumnUnit::Utf16 => before.encode_utf16().count(),
        };
        Position { line: line as u32, character: column as u32 }
    }

    pub fn range(&self, bytes: std::ops::Range<usize>, unit: ColumnUnit) -> Range {
        Range { start: self.position(bytes.start, unit), end: self.position(bytes.end, unit) }
    }
}

/// The name of a file without its folder.
pub fn file_name(path: &Path) -> Cow<'_, str> {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy()
}

/// Path of a document on the disk; an unsaved document has only a name.
pub fn path(uri: &Uri) -> Option<PathBuf> {
    let path = uri.path().as_estr().decode().into_string().ok()?.into_owned();
    // `file:///C:/a.twz` names the path `C:/a.twz`.
    let is_drive = path.as_bytes().get(2) == Some(&b':') && path.starts_with('/');
    Some(PathBuf::from(if is_drive { &path[1..] } else { path.as_str() }))
}

/// URI of a file on the disk with an absolute path.
pub fn uri(path: &Path) -> Option<Uri> {
    let path = path.to_str()?.replace('\\', "/");
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~/:".contains(&byte);
    let mut text = if path.starts_with('/') { "file://".to_owned() } else { "file:///".to_owned() };
    for byte in path.bytes() {
        if plain(byte) { text.push(byte as char) } else { text.push_str(&format!("%{byte:02X}")) }
    }
    text.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_those_of_the_client() {
        let text = EditedText::new("let a = \"中😀\" // 35 µm\r\nlet b = 2".to_owned());
        let bytes = text.as_str().find("//").expect("it is there");
        for (unit, column) in [(ColumnUnit::Utf16, 14), (ColumnUnit::Byte, 18)] {
            let place = Position { line: 0, character: column };
            assert_eq!((text.position(bytes, unit), text.offset(place, unit)), (place, bytes));
        }
        // Inside the emoji, beyond the line, beyond the text.
        let at = |line, character| text.offset(Position { line, character }, ColumnUnit::Utf16);
        assert_eq!(at(0, 11), text.as_str().find('😀').expect("it is there"));
        assert_eq!(at(0, 999), text.as_str().find('\r').expect("it is there"));
        assert_eq!([at(7, 0), at(1, 99), at(u32::MAX, u32::MAX)], [text.as_str().len(); 3]);
    }

    #[test]
    fn a_cr_ends_a_line() {
        let text = EditedText::new("a\rb\r\nc\n\rd".to_owned());
        let begins: Vec<usize> =
            (0..6).map(|line| text.offset(Position { line, character: 0 }, ColumnUnit::Utf16)).collect();
        assert_eq!(begins, [0, 2, 5, 7, 8, 9]);
    }

    #[test]
    fn changes_are_made_where_they_are_meant() {
        let mut text = EditedText::new("move to (1, 2)\nwait 1 µs\n".to_owned());
        let range = |from: (u32, u32), to: (u32, u32)| {
            let [start, end] = [from, to].map(|(line, character)| Position { line, character });
            Some(Range { start, end })
        };
        text.change(range((1, 7), (1, 9)), "ms", ColumnUnit::Utf16);
        text.change(range((0, 9), (0, 10)), "17", ColumnUnit::Utf16);
        assert_eq!(text.as_str(), "move to (17, 2)\nwait 1 ms\n");
        // A reversed range, and one outside the text.
        text.change(range((9, 9), (1, 4)), "", ColumnUnit::Utf16);
        assert_eq!(text.as_str(), "move to (17, 2)\nwait");
        text.change(None, "", ColumnUnit::Utf16);
        assert_eq!((text.as_str(), text.position(0, ColumnUnit::Utf16)), ("", Position::default()));
    }

    #[test]
    fn paths_are_decoded() {
        let of = |uri: &str| path(&uri.parse().expect("it is a URI")).expect("it is text");
        assert_eq!(of("file:///data/%C2%B5%20bench.twz"), PathBuf::from("/data/µ bench.twz"));
        assert_eq!(of("file:///C:/a.twz"), PathBuf::from("C:/a.twz"));
        assert_eq!(of("untitled:Untitled-1"), PathBuf::from("Untitled-1"));
        for path_text in ["/data/µ bench.twz", "C:/a.twz", "/50 %/a#b?.twz"] {
            assert_eq!(path(&uri(Path::new(path_text)).expect("it is a URI")), Some(PathBuf::from(path_text)));
        }
    }
}
