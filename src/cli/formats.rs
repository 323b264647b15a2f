//! Values of `--emit`.

use crate::check::scope::nearest;
use crate::emit::Format;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::error::{ContextKind, ContextValue};
use clap::{Arg, Command, Error};
use std::collections::BTreeSet;
use std::ffi::OsStr;

/// One value of `--emit`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EmitChoice {
    One(Format),
    /// Every format that can represent the schedule.
    All,
}

/// The word for [`EmitChoice::All`].
const ALL: &str = "all";

/// The formats to write.
#[derive(Debug)]
pub struct ChosenFormats {
    pub formats: BTreeSet<Format>,
    /// Formats named explicitly; any other is skipped if it cannot represent the schedule.
    named: BTreeSet<Format>,
}

impl ChosenFormats {
    pub fn of(choices: &[EmitChoice]) -> ChosenFormats {
        let named: BTreeSet<Format> = choices
            .iter()
            .filter_map(|choice| match choice {
                EmitChoice::One(format) => Some(*format),
                EmitChoice::All => None,
            })
            .collect();
        let formats = match choices.contains(&EmitChoice::All) {
            true => Format::ALL.iter().copied().collect(),
            false => named.clone(),
        };
        ChosenFormats { formats, named }
    }

    /// Whether a format was named explicitly, and not only included in `all`.
    pub fn is_named(&self, format: Format) -> bool {
        self.named.contains(&format)
    }
}

/// Parser of format names; for a near miss the error suggests a name.
pub fn parser() -> impl TypedValueParser<Value = EmitChoice> {
    FormatParser(PossibleValuesParser::new(names()))
}

fn names() -> impl Iterator<Item = &'static str> + Clone {
    Format::ALL.iter().map(|format| format.name()).chain([ALL])
}

#[derive(Clone)]
struct FormatParser(PossibleValuesParser);

impl TypedValueParser for FormatParser {
    type Value = EmitChoice;

    fn parse_ref(&self, command: &Command, argument: Option<&Arg>, value: &OsStr) -> Result<EmitChoice, Error> {
        let name = self.0.parse_ref(command, argument, value).map_err(|mut error| {
            let written = value.to_string_lossy();
            if let Some(near) = nearest(&written, names()) {
                error.insert(ContextKind::SuggestedValue, ContextValue::String(near.to_owned()));
            }
            error
        })?;
        // The accepted names are those of the formats, and `all`.
        Ok(Format::find(&name).map_or(EmitChoice::All, EmitChoice::One))
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        self.0.possible_values()
    }
}
