//! Diagnostics of the checker, one function for each finding.

mod devices;
mod frames;
mod names;
mod shapes;
mod tasks;
mod values;

pub use devices::*;
pub use frames::*;
pub use names::*;
pub use shapes::*;
pub use tasks::*;
pub use values::*;

/// A list of words for a message: "`a`, `b` and `c`".
pub fn listed<'a>(words: impl IntoIterator<Item = &'a str>) -> String {
    let words: Vec<String> = words.into_iter().map(|word| format!("`{word}`")).collect();
    match words.split_last() {
        None => "nothing".to_owned(),
        Some((only, [])) => only.clone(),
        Some((last, rest)) => format!("{} and {last}", rest.join(", ")),
    }
}

/// A choice of words for a message: "`a`, `b` or `c`".
fn either(words: &[&str]) -> String {
    let list = listed(words.iter().copied());
    match list.rsplit_once(" and ") {
        Some((rest, last)) => format!("{rest} or {last}"),
        None => list,
    }
}

/// A word after its article: "a dimibot", "an electrode_array", "a device of microrobots".
fn with_article(word: &str) -> String {
    if word.ends_with('s') {
        return format!("a device of {word}");
    }
    let article = if word.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" };
    format!("{article} {word}")
}
