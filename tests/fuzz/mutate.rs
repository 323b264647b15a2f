//! Texts mutated from other texts: tokens removed, doubled, swapped, or replaced by tokens of other texts or by extreme
//! ones.

use super::random::Random;

/// Tokens that tend to break parsers, checkers and arithmetic.
const EXTREMES: [&str; 44] = [
    "0", "-1", "1e308", "1e-308", "9007199254740993", "4294967296", "18446744073709551616", "0b1", "0b", "1..2", "(",
    ")", "[", "]", "{", "}", "\"", "\"{", "//", "///", "//!", "/*", "|", "->", "=", ":", ";", "^", "..", "\u{feff}",
    "\r\n", "\t", "µ", "\u{0}", "\u{1}", "e", "t", "table", "for i in 0..", "let a = a", "pose(", "1 um^-9",
    "quaternion(0, 0, 0, 0)", "-",
];

/// A text with up to eight changes of its tokens; at most 16 kB long.
pub fn mutated(random: &mut Random, texts: &[String]) -> String {
    let pick = |random: &mut Random| texts[random.below(texts.len() as u32) as usize].as_str();
    let own = pick(random);
    let mut tokens: Vec<&str> = tokens(own);
    let other = self::tokens(pick(random));
    for _ in 0..=random.below(8) {
        if tokens.is_empty() {
            break;
        }
        let at = random.below(tokens.len() as u32) as usize;
        let with = random.below(tokens.len() as u32) as usize;
        match random.below(8) {
            0 => drop(tokens.remove(at)),
            1 => tokens.insert(at, tokens[with]),
            2 => tokens.swap(at, with),
            3 => tokens[at] = EXTREMES[random.below(EXTREMES.len() as u32) as usize],
            4 => tokens.insert(at, EXTREMES[random.below(EXTREMES.len() as u32) as usize]),
            5 if !other.is_empty() => tokens[at] = other[random.below(other.len() as u32) as usize],
            6 if !other.is_empty() => {
                let from = random.below(other.len() as u32) as usize;
                let to = (from + 1 + random.below(40) as usize).min(other.len());
                tokens.splice(at..at, other[from..to].iter().copied());
            }
            _ => {
                let count = 1 << random.below(9);
                let token = tokens[at];
                tokens.splice(at..at, std::iter::repeat_n(token, count));
            }
        }
    }
    let mut text: String = tokens.concat();
    let limit = (0..=16_384.min(text.len())).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0);
    text.truncate(limit);
    text
}

/// Splits a text into words, numbers, runs of spaces, and other characters one by one.
fn tokens(text: &str) -> Vec<&str> {
    let class = |c: char| match c {
        c if c.is_alphanumeric() || c == '_' => 0,
        ' ' => 1,
        _ => 2,
    };
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let length = match class(first) {
            2 => first.len_utf8(),
            kind => rest.find(|c| class(c) != kind).unwrap_or(rest.len()),
        };
        let (token, after) = rest.split_at(length);
        tokens.push(token);
        rest = after;
    }
    tokens
}
