//! Context of the cursor in blocks and entries. The text may be incomplete; nothing after the cursor is read.

use crate::syntax::{PREPOSITIONS, is_word};

/// Context of a cursor: what is open before it.
#[derive(Debug, Default, PartialEq)]
pub struct CursorPlace<'t> {
    /// The tokens before each open brace, outermost first: `task go on bot`, then `using exact`.
    pub heads: Vec<Vec<&'t str>>,
    /// The tokens of the entry before the cursor, up to an open bracket and without the name that is being written.
    pub entry: Vec<&'t str>,
    /// Inside an open round or square bracket, the tokens since the bracket or its last comma.
    pub in_brackets: Option<Vec<&'t str>>,
    /// The names before the dots of the name that is being written: `std` of `std.di`.
    pub path: Vec<&'t str>,
}

impl<'t> CursorPlace<'t> {
    /// The context at the end of a text; `None` in comments, strings and numbers, where no word begins.
    pub fn behind(text: &'t str) -> Option<CursorPlace<'t>> {
        let whole = text.trim_end_matches(|c| is_word(c) || c == '.');
        // The two dots of a loop's range do not belong to a name.
        let range = text[whole.len()..].rfind("..").map_or(0, |at| at + 2);
        let (before, written) = text.split_at(whole.len() + range);
        if written.starts_with(|first: char| first.is_ascii_digit() || first == '.') {
            return None;
        }
        let mut path: Vec<&str> = written.split('.').collect();
        path.pop();
        let mut blocks = OpenBlocks::default();
        let mut at = 0;
        while at < before.len() {
            let end = end_of_token(before, at);
            let token = &before[at..end];
            let is_ended = if token.starts_with("//") {
                end < before.len()
            } else if token.starts_with('"') {
                end < before.len() || token.len() > 1 && token.ends_with('"')
            } else {
                true
            };
            if !is_ended {
                return None;
            }
            blocks.take(before, at..end);
            at = end;
        }
        Some(blocks.place(before, path))
    }
}

/// Open braces and brackets, and where entries began.
#[derive(Debug, Default)]
struct OpenBlocks<'t> {
    /// The tokens before each open brace, with the entry beginnings at that time.
    heads: Vec<(Vec<&'t str>, [usize; 2])>,
    /// Beginnings of the last entry and of the one before it, which is continued if the last one begins with a
    /// preposition.
    entries: [usize; 2],
    /// For each open bracket of the entry, where it stands and where its last argument begins.
    brackets: Vec<[usize; 2]>,
}

impl<'t> OpenBlocks<'t> {
    fn take(&mut self, text: &'t str, token: std::ops::Range<usize>) {
        match &text[token.clone()] {
            "{" => {
                self.heads.push((self.entry(text, token.start), self.entries));
                self.begin([token.end; 2]);
            }
            // What follows on the same line continues the entry before the braces.
            "}" => {
                let head = self.heads.pop();
                self.begin(head.map_or([token.end; 2], |head| head.1));
            }
            "(" | "[" => self.brackets.push([token.start, token.end]),
            ")" | "]" => {
                self.brackets.pop();
            }
            "," if let Some([_, argument]) = self.brackets.last_mut() => *argument = token.end,
            "," if self.is_counted_loop(text, token.start) => {}
            "," => self.begin([token.end; 2]),
            "\n" if self.brackets.is_empty() => self.entries = [token.end, self.entries[0]],
            _ => {}
        }
    }

    fn begin(&mut self, entries: [usize; 2]) {
        self.entries = entries;
        self.brackets.clear();
    }

    /// Whether a comma separates the two names of a loop.
    fn is_counted_loop(&self, text: &str, comma: usize) -> bool {
        text[self.entries[0]..comma].trim_start().starts_with("for ") && self.entry(text, comma).len() == 2
    }

    fn entry<'a>(&self, text: &'a str, end: usize) -> Vec<&'a str> {
        let own = tokens(&text[self.entries[0]..end]);
        let goes_on = match own.as_slice() {
            // `for` begins a loop, unless `at most` or a duration follows.
            ["for", next, ..] => *next == "at" || next.starts_with(|first: char| first.is_ascii_digit()),
            ["for"] | [] => false,
            [first, ..] => PREPOSITIONS.contains(first),
        };
        if goes_on { tokens(&text[self.entries[1]..end]) } else { own }
    }

    fn place(self, text: &'t str, path: Vec<&'t str>) -> CursorPlace<'t> {
        let end = self.brackets.first().map_or(text.len(), |[start, _]| *start);
        let entry = self.entry(text, end);
        let in_brackets = self.brackets.last().map(|[_, argument]| tokens(&text[*argument..]));
        CursorPlace { heads: self.heads.into_iter().map(|head| head.0).collect(), entry, in_brackets, path }
    }
}

/// End of the token at a byte: a name with its dots, a number, a comment, a string, an operator, spaces or one
/// character.
fn end_of_token(text: &str, at: usize) -> usize {
    let rest = &text[at..];
    let first = rest.chars().next().unwrap_or_default();
    let run = |is_of: fn(char) -> bool| at + rest.find(|c| !is_of(c)).unwrap_or(rest.len());
    match first {
        '/' if rest.starts_with("//") => at + rest.find('\n').unwrap_or(rest.len()),
        '"' => {
            at + rest[1..]
                .find(['"', '\n'])
                .map_or(rest.len(), |end| end + 1 + usize::from(rest[1 + end..].starts_with('"')))
        }
        ' ' | '\t' | '\r' => run(|c| matches!(c, ' ' | '\t' | '\r')),
        '.' if rest.starts_with("..") => at + 2,
        '-' if rest.starts_with("->") => at + 2,
        '<' | '>' | '=' | '!' => run(|c| matches!(c, '<' | '>' | '=' | '!')),
        c if is_word(c) => {
            let end = run(|c| is_word(c) || c == '.');
            rest[..end - at].find("..").map_or(end, |range| at + range)
        }
        c => at + c.len_utf8(),
    }
}

/// The tokens of a text without spaces and comments; a bracket or brace with its content is one token.
fn tokens(text: &str) -> Vec<&str> {
    let mut tokens = Vec::new();
    let (mut at, mut depth, mut group) = (0, 0_usize, 0);
    while at < text.len() {
        let end = end_of_token(text, at);
        let token = &text[at..end];
        match token {
            "(" | "[" | "{" => {
                group = if depth == 0 { at } else { group };
                depth += 1;
            }
            ")" | "]" | "}" => {
                depth = depth.saturating_sub(1);
                if depth == 0 {
                    tokens.push(&text[group..end]);
                }
            }
            _ if depth > 0 || token.trim().is_empty() || token.starts_with("//") => {}
            _ => tokens.push(token),
        }
        at = end;
    }
    tokens
}

#[cfg(test)]
mod tests {
    use super::*;

    fn behind(text: &str) -> String {
        let Some(place) = CursorPlace::behind(text) else { return "nowhere".to_owned() };
        let heads: Vec<String> = place.heads.iter().map(|head| head.join("_")).collect();
        let brackets = place.in_brackets.map(|tokens| format!(" ( {}", tokens.join("_"))).unwrap_or_default();
        format!("{} | {}{brackets} | {}", heads.join(" { "), place.entry.join("_"), place.path.join("."))
    }

    #[test]
    fn what_is_open_before_the_cursor() {
        assert_eq!(behind(""), " |  | ");
        assert_eq!(behind("use std."), " | use | std");
        assert_eq!(behind("// a {\ndevice b : db.fem"), " | device_b_: | db");
        assert_eq!(behind("device b : db.x { left: 5, rig"), "device_b_:_db.x |  | ");
        assert_eq!(
            behind("device b : db.x { left: 5 }\ntask go on b { using exact { exp"),
            "task_go_on_b { using_exact |  | "
        );
        assert_eq!(behind("task go on b {\n  move to (1, 2)\n    via "), "task_go_on_b | move_to_(1, 2)_via | ");
        assert_eq!(behind("task go on b {\n  move to (1, 2), wa"), "task_go_on_b |  | ");
        assert_eq!(behind("task go on b {\n  move s[i + 1] to "), "task_go_on_b | move_s_[i + 1]_to | ");
        assert_eq!(behind("task go on b { move to (a + 1, "), "task_go_on_b | move_to (  | ");
        assert_eq!(behind("let a = max((1, 2) + "), " | let_a_=_max ( (1, 2)_+ | ");
        assert_eq!(behind("task go on b { move to (a + "), "task_go_on_b | move_to ( a_+ | ");
        assert_eq!(behind("task go on b { prompt \"a { (\"\n mo"), "task_go_on_b |  | ");
        assert_eq!(behind("scene s { part a : disc { radius: 2 um } a"), "scene_s | part_a_:_disc_{ radius: 2 um } | ");
        assert_eq!(behind("task go on b { for i, p in l { mo"), "task_go_on_b { for_i_,_p_in_l |  | ");
        assert_eq!(
            behind("task go on b {\n minimize time\n for i in 0..n { mo"),
            "task_go_on_b { for_i_in_0_.._n |  | "
        );
        assert_eq!(
            behind("task go on b {\n incubate a at c\n for 3 s af"),
            "task_go_on_b | incubate_a_at_c_for_3_s | "
        );
        assert_eq!(behind("for i in 0..co"), " | for_i_in_0_.. | ");
        assert_eq!(behind("wiring b { bl0.set -> car"), "wiring_b | bl0.set_-> | ");
        assert_eq!(behind("require time <= "), " | require_time_<= | ");
        for nowhere in ["// a", "a \"b", "x: 5", "x: 5.", "x: 0..5", "x: 1e", "prompt \"", "prompt \"ab"] {
            assert_eq!(behind(nowhere), "nowhere", "{nowhere}");
        }
        assert_eq!(behind("prompt \"a\" "), " | prompt_\"a\" | ");
        assert_eq!(behind("prompt \"\""), " | prompt_\"\" | ");
    }
}
