//! Text widths, estimated for the widest font that `sans-serif` commonly stands for.

/// The fonts of all texts; the last one is generic.
pub const FONTS: &str = "Helvetica, Arial, Liberation Sans, DejaVu Sans, sans-serif";

/// Height of a text above its baseline and depth below it, as shares of its size.
pub const ASCENT: f64 = 0.98;
pub const DESCENT: f64 = 0.28;

/// Width factor of bold letters.
const BOLD: f64 = 1.12;

/// Width of a text, as a share of its size.
pub fn width_em(text: &str, is_bold: bool) -> f64 {
    let width_em: f64 = text.chars().map(letter_em).sum();
    if is_bold { width_em * BOLD } else { width_em }
}

/// Width of a letter of DejaVu Sans, which is a wide font; other scripts by their kind.
fn letter_em(letter: char) -> f64 {
    match letter {
        'i' | 'j' | 'l' | 'I' | 'J' | '\'' | '|' => 0.3,
        ' ' | '\u{a0}' | ',' | '.' | ':' | ';' | '/' | '·' => 0.34,
        'f' | 'r' | 't' | '(' | ')' | '[' | ']' | '-' => 0.42,
        'm' | 'w' | 'W' | '%' | '@' | '→' => 1.0,
        'M' | '+' | '=' | '<' | '>' | '×' | '±' => 0.87,
        'a'..='z' | '0'..='9' | '_' | '"' | 'µ' | '°' | '–' | '*' => 0.64,
        'A'..='Z' => 0.79,
        // Letters of other scripts are at most as wide as they are high.
        _ => 1.05,
    }
}

/// The lines of a text wrapped at blanks, each at most `most_em` times its size wide; a wider word is broken.
pub fn wrapped(text: &str, most_em: f64, is_bold: bool) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    let mut line = String::new();
    let fits = |line: &str| width_em(line, is_bold) <= most_em;
    for word in text.split(' ') {
        let joined = if line.is_empty() { word.to_owned() } else { format!("{line} {word}") };
        if fits(&joined) {
            line = joined;
            continue;
        }
        if !line.is_empty() {
            lines.push(std::mem::take(&mut line));
        }
        for letter in word.chars() {
            line.push(letter);
            if !fits(&line) && line.chars().count() > 1 {
                line.pop();
                lines.push(std::mem::replace(&mut line, letter.to_string()));
            }
        }
    }
    lines.push(line);
    lines
}

/// A text cut to a width of `most_em` times its size, with three dots where something is cut off.
pub fn cut(text: &str, most_em: f64, is_bold: bool) -> String {
    if width_em(text, is_bold) <= most_em {
        return text.to_owned();
    }
    let mut short = text.to_owned();
    while !short.is_empty() && width_em(&format!("{short}..."), is_bold) > most_em {
        short.pop();
    }
    format!("{short}...")
}
