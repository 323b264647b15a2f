//! Diagnostics of the checker, one function for each finding.

mod devices;
mod electrode_array;
mod fingers;
mod frames;
mod microrobots;
mod names;
mod tasks;
mod values;

pub use devices::*;
pub use electrode_array::*;
pub use fingers::*;
pub use frames::*;
pub use microrobots::*;
pub use names::*;
pub use tasks::*;
pub use values::*;

/// A list of words for a message: "`a`, `b` and `c`".
fn listed<'a>(words: impl IntoIterator<Item = &'a str>) -> String {
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

/// "did you mean `x`?", where something is near.
fn meant(near: Option<&str>) -> Option<String> {
    near.map(|near| format!("did you mean `{near}`?"))
}
