//! A program's file, read and with what the command line adds, ready for the compiler.

use super::arguments::Report;
use super::disk::{self, Disk};
use super::{Exit, terminal};
use crate::check::Options;
use crate::compile::Program;
use std::path::Path;

/// A program as a command was given it.
pub struct Loaded {
    name: String,
    text: String,
    pub options: Options,
}

impl Loaded {
    /// Reads a file; what is wrong with it is reported.
    ///
    /// # Errors
    /// The exit status where it cannot be read.
    pub fn read(file: &Path, options: Options, report: &Report) -> Result<Loaded, Exit> {
        match disk::read_program(file) {
            Ok(text) => Ok(Loaded { name: file.to_string_lossy().into_owned(), text, options }),
            Err(diagnostic) => {
                terminal::report_one(*diagnostic, report.format);
                Err(Exit::Files)
            }
        }
    }

    /// The name that messages show.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What the compiler takes.
    pub fn program(&self) -> Program<'_> {
        Program { name: &self.name, text: &self.text, library: &Disk, options: &self.options }
    }
}
