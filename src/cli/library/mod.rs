//! Libraries that used files are read from: the disk, or a log.
//!
//! Files are named by paths relative to the program's folder, so that outputs do not depend on where a program is
//! stored or how its path was typed; messages show the path that was typed.

use super::disk;
use super::file_snapshots::FileSnapshots;
use crate::check::imports::{FileFault, Library};
use crate::diagnostic::Code;
use crate::geometry::mesh::Mesh;
use crate::source::{MAX_FILE_BYTES, beside};
use std::cell::RefCell;
use std::path::{Path, PathBuf};

/// Library of the files around a program on the disk.
pub struct Disk<'a> {
    program: &'a Path,
    /// Snapshots of all requested files, existing or not, taken before they were read.
    asked: RefCell<FileSnapshots>,
}

impl<'a> Disk<'a> {
    /// Library for the program at a path, as it was typed.
    pub fn around(program: &'a Path) -> Self {
        Disk { program, asked: RefCell::default() }
    }

    /// Snapshots of all files requested so far, existing or not, taken before they were read.
    pub fn asked(&self) -> FileSnapshots {
        self.asked.borrow().clone()
    }

    /// Path of a requested file; records its snapshot.
    fn ask(&self, name: &str) -> PathBuf {
        let path = self.path(name);
        self.asked.borrow_mut().record(&path);
        path
    }

    /// Name of the program itself: its file name.
    pub fn program_name(&self) -> String {
        self.program.file_name().unwrap_or(self.program.as_os_str()).to_string_lossy().into_owned()
    }

    fn path(&self, name: &str) -> PathBuf {
        match name == self.program_name() {
            true => self.program.to_owned(),
            false => self.program.parent().unwrap_or(Path::new("")).join(name),
        }
    }
}

impl Library for Disk<'_> {
    fn read(&self, from: &str, path: &str) -> Result<(String, String), FileFault> {
        let name = beside(from, path);
        let text = disk::read_program(&self.ask(&name)).map_err(|fault| match fault.code {
            Code::E0803 => FileFault::NotText(fault.title),
            _ => FileFault::Unread(fault.title),
        })?;
        Ok((name, text))
    }

    fn read_mesh(&self, from: &str, path: &str) -> Result<(String, String), FileFault> {
        let name = beside(from, path);
        let bytes = disk::read_bytes(&self.ask(&name), MAX_FILE_BYTES).map_err(|diagnostic| diagnostic.title)?;
        let is_text = bytes.trim_ascii_start().starts_with(b"solid");
        let text = match String::from_utf8(bytes) {
            Ok(text) if is_text => text,
            Ok(text) => mesh_text(text.as_bytes())?,
            Err(error) => mesh_text(error.as_bytes())?,
        };
        if text.len() > MAX_FILE_BYTES {
            return Err(FileFault::LongMesh(format!("it is larger than {} MiB as text", MAX_FILE_BYTES >> 20)));
        }
        Ok((name, text))
    }

    fn shown(&self, name: &str) -> String {
        self.path(name).to_string_lossy().into_owned()
    }
}

/// Text form of a binary mesh file.
fn mesh_text(bytes: &[u8]) -> Result<String, FileFault> {
    Mesh::read(bytes).map(|mesh| mesh.to_text()).map_err(|fault| FileFault::NoSurface(fault.to_string()))
}

/// Library of the files that a log contains.
pub struct Embedded<'a>(pub &'a [(String, String)]);

impl Library for Embedded<'_> {
    fn read(&self, from: &str, path: &str) -> Result<(String, String), FileFault> {
        let name = beside(from, path);
        let text = self.0.iter().find(|file| file.0 == name).map(|file| file.1.clone());
        text.map(|text| (name, text)).ok_or_else(|| "the log does not carry it".into())
    }
}

#[cfg(test)]
mod tests;
