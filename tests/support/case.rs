//! Programs in memory, compiled as far as possible; shared by the tests of pages and of the corpus.

#![allow(dead_code, reason = "each test uses the part that it needs")]

use std::collections::BTreeMap;
use tweeze::check::Options;
use tweeze::check::imports::{FileFault, Library};
use tweeze::compile::{ProgramSource, compile};
use tweeze::diagnostic::Sink;
use tweeze::source::Sources;

/// A program and the files beside it.
#[derive(Clone, Default)]
pub struct Case {
    pub name: String,
    pub text: String,
    pub files: BTreeMap<String, String>,
    pub options: Options,
}

/// Library of files by name; a path means the same wherever it is used.
pub struct Shelf<'a>(pub &'a Case);

impl Library for Shelf<'_> {
    fn read(&self, _from: &str, path: &str) -> Result<(String, String), FileFault> {
        let own = (path == self.0.name).then_some(&self.0.text);
        let text = own.or_else(|| self.0.files.get(path)).ok_or("there is no such file")?;
        Ok((path.to_owned(), text.clone()))
    }
}

impl Case {
    /// Compiles the program up to the verified schedules, or as far as it goes.
    pub fn compile(&self) -> (Sources, Sink) {
        let (mut sources, mut sink) = (Sources::default(), Sink::default());
        self.request(|program| compile(program, &mut sources, &mut sink, &mut ()));
        (sources, sink)
    }

    /// Calls `act` with the program as the compiler's input.
    pub fn request<T>(&self, act: impl FnOnce(&ProgramSource) -> T) -> T {
        act(&ProgramSource { name: &self.name, text: &self.text, library: &Shelf(self), options: &self.options })
    }

    /// Takes `set=name=value` and `task=name` as options; returns any other word.
    pub fn take<'w>(&mut self, word: &'w str) -> Option<&'w str> {
        if let Some(setting) = word.strip_prefix("set=") {
            self.options.settings.push(setting.to_owned());
        } else if let Some(task) = word.strip_prefix("task=") {
            self.options.only = Some(task.to_owned());
        } else {
            return Some(word);
        }
        None
    }
}
