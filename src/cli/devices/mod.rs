//! `tweeze devices`: the kinds, the vocabulary of one kind, the devices of a program, and suggested voltage tables.

mod program;
mod vocabulary;

use super::arguments::DevicesArguments;
use super::{Exit, report, terminal};
use crate::check::scope::nearest;
use crate::device::Kind;
use crate::device::instrument::Family;
use std::path::Path;

/// Lists the kinds, everything that one kind offers, or the devices of a program; or suggests a voltage table.
pub fn run(arguments: &DevicesArguments) -> Exit {
    if arguments.suggest.is_some() {
        return report::suggest(arguments);
    }
    let Some(subject) = &arguments.subject else { return terminal::answer(&vocabulary::kinds()) };
    if let Some(kind) = Kind::find(subject) {
        return terminal::answer(&vocabulary::page(kind.vocabulary()));
    }
    if let Some(family) = Family::find(subject) {
        return terminal::answer(&vocabulary::family_page(family));
    }
    if is_file(subject) {
        return program::run(Path::new(subject), arguments);
    }
    let kinds = Kind::ALL.iter().map(|kind| kind.name());
    let near = nearest(subject, kinds.chain(Family::ALL.iter().map(|family| family.name())));
    let near = match (crate::stdlib::declaring("device", subject), near) {
        (Some(file), _) => format!(
            "; it is a device of `std.{file}`: start from it with `device mine : {file}.{subject}`; `tweeze devices {file}` lists its words"
        ),
        (None, Some(near)) => format!("; did you mean `{near}`?"),
        (None, None) => String::new(),
    };
    eprintln!("no device kind or family of instruments is named `{subject}`{near}\n`tweeze devices` lists them all");
    Exit::Usage
}

/// Whether a word names a file rather than a kind.
fn is_file(subject: &str) -> bool {
    let path = Path::new(subject);
    path.extension().is_some() || path.components().count() > 1 || path.is_file()
}
