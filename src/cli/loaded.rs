//! A program's text with the settings of the command line, ready for the compiler.

use super::arguments::ReportArguments;
use super::disk;
use super::library::Disk;
use super::{Exit, terminal};
use crate::check::Options;
use crate::compile::ProgramSource;
use crate::diagnostic::Diagnosed;
use std::path::{Path, PathBuf};

/// A program as given to a command.
pub struct Loaded {
    path: PathBuf,
    /// Name in outputs.
    name: String,
    text: String,
    pub options: Options,
}

impl Loaded {
    /// Reads a file; reports failures.
    ///
    /// # Errors
    /// The exit status if it cannot be read.
    pub fn read(file: &Path, options: Options, report: &ReportArguments) -> Result<Loaded, Exit> {
        Loaded::open(file, options).map_err(|diagnostic| {
            terminal::report_one(*diagnostic, report.format);
            Exit::Files
        })
    }

    /// Reads a file.
    ///
    /// # Errors
    /// A diagnostic: it cannot be read.
    pub fn open(file: &Path, options: Options) -> Diagnosed<Loaded> {
        let (path, text) = disk::read_argument(file)?;
        Ok(Loaded { name: Disk::around(&path).program_name(), path, text, options })
    }

    /// Path, or the name of standard input.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Name in messages: the path as it was typed.
    pub fn shown(&self) -> String {
        self.path.to_string_lossy().into_owned()
    }

    /// Library of the files around it.
    pub fn disk(&self) -> Disk<'_> {
        Disk::around(&self.path)
    }

    /// Input for the compiler.
    pub fn program<'a>(&'a self, disk: &'a Disk<'a>) -> ProgramSource<'a> {
        ProgramSource { name: &self.name, text: &self.text, library: disk, options: &self.options }
    }
}
