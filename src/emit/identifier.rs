//! Names that the narrower grammars of other programs take.

use std::collections::BTreeSet;

/// The words as identifiers of ASCII letters, digits and `_` that do not begin with a digit; no two are the same, nor the same
/// but for upper and lower case.
pub fn distinct<'a>(words: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    distinct_by(words, plain)
}

/// As [`distinct`], in a wider grammar: `plain` gives each word in it.
pub fn distinct_by<'a>(words: impl IntoIterator<Item = &'a str>, plain: impl Fn(&str) -> String) -> Vec<String> {
    let mut taken = BTreeSet::new();
    let mut names = Vec::new();
    for word in words {
        let plain = plain(word);
        let mut name = plain.clone();
        let mut number = 2;
        while !taken.insert(name.to_ascii_lowercase()) {
            name = format!("{plain}_{number}");
            number += 1;
        }
        names.push(name);
    }
    names
}

fn plain(word: &str) -> String {
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
}
