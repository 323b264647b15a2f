//! Names within the narrower grammars of other programs.

use std::collections::BTreeSet;

/// The words as identifiers of ASCII letters, digits and `_` that do not begin with a digit. No two are the same, even
/// if case is ignored.
pub fn distinct<'a>(words: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    distinct_by(words, plain)
}

/// As [`distinct`], for the fields of one message: names also differ without `_`, which protobuf readers drop in JSON
/// names (`e1_13` and `e11_3` both become `e113`, and such a message is refused).
pub fn distinct_fields<'a>(words: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    distinct_in(words, plain, |name| name.to_ascii_lowercase().replace('_', ""))
}

/// As [`distinct`], in a wider grammar into which `plain` maps each word.
pub fn distinct_by<'a>(words: impl IntoIterator<Item = &'a str>, plain: impl Fn(&str) -> String) -> Vec<String> {
    distinct_in(words, plain, str::to_ascii_lowercase)
}

/// Makes names distinct by `key`.
fn distinct_in<'a>(
    words: impl IntoIterator<Item = &'a str>,
    plain: impl Fn(&str) -> String,
    key: impl Fn(&str) -> String,
) -> Vec<String> {
    let mut taken = BTreeSet::new();
    let mut names = Vec::new();
    for word in words {
        let plain = plain(word);
        let mut name = plain.clone();
        let mut number = 2;
        while !taken.insert(key(&name)) {
            name = format!("{plain}_{number}");
            number += 1;
        }
        names.push(name);
    }
    names
}

/// A word as an identifier; other words may give the same one.
pub fn plain(word: &str) -> String {
    let text: String = word.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    match text.as_bytes().first() {
        Some(first) if !first.is_ascii_digit() => text,
        Some(_) | None => format!("_{text}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifiers_differ_where_their_words_do() {
        let names = distinct(["bl4.set", "bl4_set", "BL4.set", "4µ", "", "bl4_set_2"]);
        assert_eq!(names, ["bl4_set", "bl4_set_2", "BL4_set_3", "_4_", "_", "bl4_set_2_2"]);
    }

    #[test]
    fn fields_differ_without_their_underscores() {
        assert_eq!(distinct_fields(["e1_13", "e11_3", "e11_32"]), ["e1_13", "e11_3_2", "e11_32_2"]);
    }
}
