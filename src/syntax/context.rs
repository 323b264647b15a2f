//! Text around a mistake: the words, lines and spaces that messages repeat and edits replace.

use crate::source::Span;

/// The span of the bytes `start..end` of the file of `span`.
pub(super) fn part(span: Span, start: usize, end: usize) -> Span {
    Span::new(span.file, start, end)
}

/// The first word, number or other character at an offset; empty only at the end of the text.
pub(super) fn token_at(text: &str, offset: usize) -> &str {
    let rest = after(text, offset);
    let Some(first) = rest.chars().next() else { return "" };
    let in_word = |c: char| c.is_alphanumeric() || c == '_';
    let in_sign = |c: char| "+-*/^<>=!.:".contains(c);
    let length = if first == '"' {
        rest[1..].find(['"', '\r', '\n']).map(|length| length + 2)
    } else if in_word(first) {
        rest.find(|c| !in_word(c))
    } else if in_sign(first) {
        rest.find(|c| !in_sign(c))
    } else {
        Some(first.len_utf8())
    };
    &rest[..length.unwrap_or(rest.len())]
}

/// Bytes around a mistake in which a message looks for words to repeat: a line may be a megabyte long.
const SEARCH_WINDOW_BYTES: usize = 512;

/// The text before an offset, at most `SEARCH_WINDOW_BYTES`.
pub(super) fn before(text: &str, offset: usize) -> &str {
    &text[text.floor_char_boundary(offset.saturating_sub(SEARCH_WINDOW_BYTES))..offset]
}

/// The text from an offset on, at most `SEARCH_WINDOW_BYTES`.
pub(super) fn after(text: &str, offset: usize) -> &str {
    &text[offset..text.ceil_char_boundary((offset + SEARCH_WINDOW_BYTES).min(text.len()))]
}

/// End of the last code before an offset; spaces, line ends and comments are skipped.
pub(super) fn code_end_before(text: &str, offset: usize) -> usize {
    let mut end = offset;
    loop {
        end = text[..end].trim_end().len();
        let seen = before(text, end);
        let line = seen.rfind('\n').map_or(seen, |at| &seen[at + 1..]);
        match line.find("//") {
            Some(at) => end -= line.len() - at,
            None => return end,
        }
    }
}

/// The line of an offset, up to that offset and without its indentation.
pub(super) fn line_before(text: &str, offset: usize) -> &str {
    let seen = before(text, offset);
    seen.rfind('\n').map_or(seen, |at| &seen[at + 1..]).trim()
}

/// The line of an offset, from that offset on and without a comment.
pub(super) fn line_after(text: &str, offset: usize) -> &str {
    let line = after(text, offset).lines().next().unwrap_or("");
    line.split("//").next().unwrap_or("").trim()
}

/// The value at the beginning of a text, up to the comma or bracket that ends it.
pub(super) fn value_in(text: &str) -> &str {
    let mut depth = 0_usize;
    for (at, c) in text.char_indices() {
        match c {
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' if depth > 0 => depth -= 1,
            ')' | ']' | '}' | ',' | ';' if depth == 0 => return text[..at].trim_end(),
            _ => {}
        }
    }
    text
}

/// Greatest number of characters of the user's text that a message quotes.
const LONGEST_QUOTE: usize = 60;

/// Quotes a piece of the user's text for a message; long pieces are cut.
pub(super) fn quote(text: &str) -> String {
    let mut quoted: String = text.chars().take(LONGEST_QUOTE).collect();
    if text.chars().nth(LONGEST_QUOTE).is_some() {
        quoted.push('…');
    }
    quoted
}

/// End of the spaces and tabs that begin at an offset.
pub(super) fn blanks_end(text: &str, offset: usize) -> usize {
    text.len() - text[offset..].trim_start_matches([' ', '\t']).len()
}

/// A sign with the spaces and tabs around it.
pub(super) fn with_blanks(sign: Span, text: &str) -> Span {
    let start = text[..sign.start as usize].trim_end_matches([' ', '\t']).len();
    part(sign, start, blanks_end(text, sign.end as usize))
}

/// A span, extended to its whole line if nothing else stands on that line.
pub(super) fn line_part(span: Span, start: usize, end: usize, text: &str) -> Span {
    let before = text[..start].trim_end_matches([' ', '\t']);
    let behind = blanks_end(text, end);
    let above = before.strip_suffix('\n').map(|above| above.strip_suffix('\r').unwrap_or(above));
    match above.filter(|_| text[behind..].starts_with(['\r', '\n'])) {
        Some(above) => part(span, above.len(), behind),
        None => part(span, start, end),
    }
}

/// The word that ends before an offset.
pub(super) fn token_before(text: &str, offset: usize) -> &str {
    let head = before(text, offset).trim_end();
    let start = head.char_indices().rev().find(|(_, c)| !c.is_alphanumeric() && *c != '_');
    &head[start.map_or(0, |(at, c)| at + c.len_utf8())..]
}

/// The last word or other character of a text.
pub(super) fn token_before_sign(text: &str) -> &str {
    let text = before(text, text.len());
    let Some(last) = text.chars().next_back() else { return "" };
    let in_word = |c: char| c.is_alphanumeric() || c == '_';
    let in_sign = |c: char| "+-*/^<>=!.".contains(c);
    let start = if in_word(last) {
        text.char_indices().rev().find(|(_, c)| !in_word(*c))
    } else if in_sign(last) {
        text.char_indices().rev().find(|(_, c)| !in_sign(*c))
    } else {
        return &text[text.len() - last.len_utf8()..];
    };
    &text[start.map_or(0, |(at, c)| at + c.len_utf8())..]
}

/// A span without the spaces around it; if it contains only spaces, the word or character before it.
pub(super) fn visible(span: Span, text: &str) -> Span {
    let inside = &text[span.range()];
    let end = span.start as usize + inside.trim_end().len();
    let start = end - text[span.start as usize..end].trim_start().len();
    if start < end {
        return part(span, start, end);
    }
    let before = code_end_before(text, span.start as usize);
    part(span, before - token_before_sign(&text[..before]).len(), before)
}

/// The first word of a span; `length` is in bytes.
pub(super) fn first_word(span: Span, length: usize) -> Span {
    part(span, span.start as usize, span.start as usize + length)
}
