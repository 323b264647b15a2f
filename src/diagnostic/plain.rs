//! Sanitising of text from elsewhere for output: a name must not control the terminal, forge a line, or fill the
//! screen.

use std::borrow::Cow;

/// Stands for a character that is not shown.
const REPLACEMENT: char = '\u{fffd}';

/// Whether a character affects the terminal or the order of text instead of being visible: control characters, line and
/// paragraph separators, marks that change the direction of writing, and zero-width characters.
pub fn is_unprintable(character: char) -> bool {
    character.is_control()
        || matches!(character,
            '\u{61c}' | '\u{180e}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{2069}' | '\u{feff}')
}

/// The text on one line, with [`char::REPLACEMENT_CHARACTER`] for every character that [`is_unprintable`] accepts.
pub fn plain(text: &str) -> Cow<'_, str> {
    match text.contains(is_unprintable) {
        true => Cow::Owned(text.chars().map(|c| if is_unprintable(c) { REPLACEMENT } else { c }).collect()),
        false => Cow::Borrowed(text),
    }
}

/// As [`plain`], but keeps line ends.
pub fn plain_lines(text: &str) -> String {
    text.split('\n').map(plain).collect::<Vec<_>>().join("\n")
}

/// The text, or its beginning and its end if it has more than `limit` characters.
pub fn shortened(text: &str, limit: usize) -> Cow<'_, str> {
    if text.len() <= limit || text.chars().nth(limit).is_none() {
        return Cow::Borrowed(text);
    }
    let at = |nth: usize| text.char_indices().nth(nth).map_or(text.len(), |(at, _)| at);
    let count = text.chars().count();
    let tail = limit / 4;
    let (head_end, tail_start) = (at(limit - tail), at(count - tail));
    Cow::Owned(format!("{}… ({count} characters) …{}", &text[..head_end], &text[tail_start..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unprintable_characters_are_replaced_and_nothing_else() {
        assert_eq!(plain("a\n\x1b]0;x\x07\u{202e}b\u{9b}"), "a\u{fffd}\u{fffd}]0;x\u{fffd}\u{fffd}b\u{fffd}");
        assert!(matches!(plain("Prüfung 35 µm → „x“"), Cow::Borrowed(_)));
        assert_eq!(plain_lines("a\r\nb"), "a\u{fffd}\nb");
    }

    #[test]
    fn a_long_text_keeps_both_ends() {
        assert_eq!(shortened("µµµµ", 4), "µµµµ");
        assert_eq!(shortened("µµµµ5", 4), "µµµ… (5 characters) …5");
    }
}
