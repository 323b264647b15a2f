//! Describes the vocabulary in words, for `tweeze devices` and for editors.

use super::{Count, NONE, Need, Outcome, Sort, Verb, VocabularyField};
use crate::quantity::Dimension;

impl Sort {
    /// The values of the sort, in words.
    pub fn text(self) -> String {
        match self {
            Sort::Count { least, most } => format!("{least} to {most}"),
            Sort::Quantity { dimension, range } if dimension == Dimension::NUMBER => {
                format!("a number {}", range.text())
            }
            Sort::Quantity { dimension, range } => {
                format!("{} [{}], {}", dimension.name(), dimension.example_unit(), range.text())
            }
            Sort::Word(choices) => choices.iter().map(|choice| choice.name).collect::<Vec<_>>().join(" | "),
            Sort::State => "word, cell or place".to_owned(),
            Sort::Target => "cell, place or word".to_owned(),
            Sort::Targets => "list of cells and places".to_owned(),
            Sort::Cell => "cell".to_owned(),
            Sort::Cells => "list of cells".to_owned(),
            Sort::CountRows { most } => format!("list of rows, each a list of 0 to {most} | {NONE}"),
            Sort::CountTables { most } => format!("list of lists, each of lists of 0 to {most}"),
            Sort::Size => "(length, length)".to_owned(),
            Sort::Pixel => "(x, y) [px]".to_owned(),
            Sort::Places => "list of places".to_owned(),
            Sort::CountOrWord { least, most, words } => {
                let words: Vec<&str> = words.iter().map(|choice| choice.name).collect();
                format!("{least} to {most} | {}", words.join(" | "))
            }
            Sort::Flag => "true | false".to_owned(),
            Sort::Shape(form) => form.name().to_owned(),
            Sort::Table(columns) => {
                let columns: Vec<String> = columns.iter().map(|column| column.name.to_owned()).collect();
                format!("table of {}", columns.join(" | "))
            }
            Sort::Object(noun) => noun.to_owned(),
            Sort::Site(noun) => format!("{noun} or cell"),
            Sort::Sites(noun) => format!("list of {noun}s and cells"),
            Sort::Name => "name".to_owned(),
            Sort::Pose => "pose".to_owned(),
            Sort::Control => "number, or word of arms".to_owned(),
            Sort::Vector { dimension, .. } => {
                let unit = dimension.example_unit();
                format!("(x, y, z) [{unit}]")
            }
            Sort::Contacts => "(contact, contact, …)".to_owned(),
            Sort::Orientation => "euler(…) or quaternion(…)".to_owned(),
            Sort::Curve => "length, of the angle t".to_owned(),
            Sort::Text | Sort::Board(_) => "string".to_owned(),
        }
    }
}

impl VocabularyField {
    /// The field's name and the values it takes.
    pub fn term(&self) -> String {
        format!("{}: {}", self.name, self.sort.text())
    }

    /// The field's purpose, and what applies if it is missing.
    pub fn meaning(&self) -> String {
        match self.need {
            Need::Required => self.doc.to_owned(),
            Need::Default(figure) => format!("{} (else {figure})", self.doc),
            Need::Optional(otherwise) => format!("{} (else {otherwise})", self.doc),
        }
    }
}

impl Sort {
    /// The dimension of its numbers, if all have the same.
    pub fn dimension(&self) -> Option<Dimension> {
        match self {
            Sort::Quantity { dimension, .. } | Sort::Vector { dimension, .. } => Some(*dimension),
            Sort::Target | Sort::Targets | Sort::Places | Sort::Pose | Sort::Size | Sort::Curve => {
                Some(Dimension::LENGTH)
            }
            Sort::Orientation => Some(Dimension::ANGLE),
            Sort::Pixel => Some(Dimension::PIXELS),
            Sort::Count { .. }
            | Sort::Word(_)
            | Sort::State
            | Sort::Cell
            | Sort::Cells
            | Sort::CountRows { .. }
            | Sort::CountTables { .. }
            | Sort::CountOrWord { .. }
            | Sort::Flag
            | Sort::Shape(_)
            | Sort::Table(_)
            | Sort::Object(_)
            | Sort::Site(_)
            | Sort::Sites(_)
            | Sort::Name
            | Sort::Control
            | Sort::Contacts
            | Sort::Text
            | Sort::Board(_) => None,
        }
    }
}

impl Verb {
    /// The verb's effect, and the prepositions it takes.
    pub fn meaning(&self) -> String {
        let phrases = self.phrases.iter().map(|phrase| {
            let often = match phrase.count {
                Count::Once => "once".to_owned(),
                Count::OnceUnless(other) => format!("once, unless `{other}` is given"),
                Count::AtMostOnce => "at most once".to_owned(),
                Count::AnyNumber => "any number of times".to_owned(),
            };
            format!("`{}` {} {often}", phrase.preposition, phrase.sort.text())
        });
        let phrases: Vec<String> = phrases.collect();
        if phrases.is_empty() { self.doc.to_owned() } else { format!("{} ({})", self.doc, phrases.join(", ")) }
    }
}

impl Outcome {
    /// The form of a condition on it, with the dimension of its limit: `require time: a time`.
    pub fn condition(&self) -> String {
        format!("require {}: {}", self.name, self.unit.dimension().name())
    }
}
