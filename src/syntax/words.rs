//! Words: which characters form a name, which names are reserved, and which words begin a declaration.

/// Reserved words, which cannot be names.
pub const RESERVED: [&str; 26] = [
    "use", "as", "let", "device", "instrument", "output", "scene", "task", "program", "wiring", "table", "true",
    "false", "to", "from", "by", "about", "after", "for", "at", "among", "via", "with", "within", "in", "on",
];

/// The prepositions of a step. `for` and `in` also stand in the head of a loop.
pub(crate) const PREPOSITIONS: [&str; 13] =
    ["to", "from", "by", "about", "after", "for", "at", "among", "via", "with", "within", "in", "on"];

/// Sorts of parameters other than objects of a scene.
pub(crate) const PARAMETER_SORTS: [&str; 11] =
    ["length", "time", "angle", "voltage", "force", "speed", "number", "cell", "place", "pose", "word"];

/// The preposition that a word differs from by one letter; prepositions of two letters are excluded, since almost any
/// short word is near them.
pub(super) fn meant_preposition(word: &str) -> Option<&'static str> {
    PREPOSITIONS.into_iter().find(|known| known.len() > 2 && strsim::osa_distance(word, known) == 1)
}

/// Whether a character may be part of a name.
pub(crate) fn is_word(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_' || (!c.is_ascii() && c.is_alphabetic())
}

/// Whether a text is a name, reserved or not.
pub(super) fn is_name(text: &str) -> bool {
    text.starts_with(|c: char| is_word(c) && !c.is_ascii_digit()) && text.chars().all(is_word)
}

/// Where the run of name characters at an offset ends.
pub(super) fn end_of_word(text: &str, at: usize) -> usize {
    text[at..].find(|c| !is_word(c)).map_or(text.len(), |length| at + length)
}

/// Whether a line begins a declaration: a reserved word followed by something other than a field's colon.
pub(super) fn starts_item(line: &str) -> bool {
    let words = ["use", "let", "device", "instrument", "output", "scene", "task", "program", "wiring"];
    words.iter().any(|word| {
        line.strip_prefix(word).is_some_and(|rest| {
            let name = rest.trim_start_matches([' ', '\t']);
            name.len() < rest.len() && name.starts_with(|c| is_word(c) || c == '"')
        })
    })
}

/// Whether the declaration that begins with this text has a block.
pub(super) fn takes_block(item: &str) -> bool {
    ["scene", "task", "program", "wiring"].iter().any(|word| item.starts_with(word))
}

/// Whether the declaration that begins with this text may have fields.
pub(super) fn takes_fields(item: &str) -> bool {
    ["device", "instrument", "output"].iter().any(|word| item.starts_with(word))
}

/// Whether a character is a control character or one that steers the layout of text.
pub(super) fn is_invisible(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{ad}' | '\u{200b}'..='\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}')
}
