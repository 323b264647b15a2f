//! Numbers in a text, and their replacement by other magnitudes.

use std::ops::Range;

/// Factors that a number is multiplied by.
pub const MAGNITUDES: [f64; 12] = [0.0, -1.0, 1e-18, 1e-9, 1e-6, 1e-3, 0.1, 10.0, 1e3, 1e6, 1e9, 1e18];

/// Ranges of the numbers in a text, except those in comments, strings and words such as `0b101`.
pub fn places(text: &str) -> Vec<Range<usize>> {
    let bytes = text.as_bytes();
    let mut found = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let is_word = at > 0 && (bytes[at - 1].is_ascii_alphanumeric() || matches!(bytes[at - 1], b'_' | b'^'));
        match bytes[at] {
            b'/' if bytes.get(at + 1) == Some(&b'/') => at += text[at..].find('\n').unwrap_or(text.len() - at),
            b'"' => at += text[at + 1..].find('"').map_or(text.len() - at, |length| length + 2),
            b'0' if bytes.get(at + 1) == Some(&b'b') => at += 2,
            b'0'..=b'9' if !is_word => {
                let length = number(&bytes[at..]);
                found.push(at..at + length);
                at += length;
            }
            _ => at += 1,
        }
    }
    found
}

/// Length of the number at the beginning: digits, a point and digits, an exponent.
fn number(bytes: &[u8]) -> usize {
    let digits = |from: usize| bytes[from..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let mut end = digits(0);
    if bytes.get(end) == Some(&b'.') && bytes.get(end + 1).is_some_and(u8::is_ascii_digit) {
        end += 1 + digits(end + 1);
    }
    if bytes.get(end).is_some_and(|byte| byte.eq_ignore_ascii_case(&b'e')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'-' | b'+')));
        let exponent = digits((end + 1 + sign).min(bytes.len()));
        if exponent > 0 {
            end += 1 + sign + exponent;
        }
    }
    end
}

/// A text with one of its numbers multiplied.
pub fn scaled(text: &str, place: &Range<usize>, factor: f64) -> String {
    let value: f64 = text[place.clone()].parse().unwrap_or(1.0);
    let value = if value == 0.0 { factor } else { value * factor };
    let number = match value {
        value if value == value.trunc() && value.abs() < 1e15 => format!("{value}"),
        value => format!("{value:e}"),
    };
    format!("{}{number}{}", &text[..place.start], &text[place.end..])
}
