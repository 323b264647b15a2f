//! Files: reading programs and logs, writing whole sets or nothing.

mod commit;
mod manifest;

use super::{errors, signals};
use crate::diagnostic::Diagnostic;
use crate::emit::OutputFile;
use crate::source::MAX_FILE_BYTES;
use commit::{DiskFault, Folder, JOURNAL, RealDisk};
use manifest::Manifest;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

/// The largest log that is read, in bytes.
pub const MAX_LOG_BYTES: usize = 1024 * 1024 * 1024;

/// Reads a program's text.
///
/// # Errors
/// A diagnostic: the file cannot be read, is too large, or is not UTF-8.
pub fn read_program(path: &Path) -> Result<String, Box<Diagnostic>> {
    let bytes = read_bytes(path, MAX_FILE_BYTES)?;
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        Box::new(errors::not_utf8(path, error.as_bytes(), at))
    })
}

/// Reads a file of at most `limit` bytes.
///
/// # Errors
/// A diagnostic: the file cannot be read or is too large.
pub fn read_bytes(path: &Path, limit: usize) -> Result<Vec<u8>, Box<Diagnostic>> {
    let unreadable = |error: io::Error| Box::new(errors::unreadable(path, &error));
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(unreadable)?;
    if file.metadata().map_err(unreadable)?.is_dir() {
        return Err(Box::new(errors::is_a_folder(path)));
    }
    file.take(limit as u64 + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() > limit {
        return Err(Box::new(errors::too_large(path, limit)));
    }
    Ok(bytes)
}

/// Target of a set of files.
pub struct Destination<'a> {
    pub folder: &'a Path,
    /// The program that the files are built from.
    pub program: &'a Path,
    /// Whether files of other programs are replaced.
    pub force: bool,
}

/// Writes a set of files into a folder: all of them, or none; see [`commit`] for the effect of a kill. Files that another program was
/// built to are replaced only if that is requested.
///
/// # Errors
/// A diagnostic that names the file or folder and why.
pub fn write_all(to: &Destination, files: &[OutputFile]) -> Result<(), Box<Diagnostic>> {
    let folder = to.folder;
    let fail = |path: &Path| {
        let path = path.to_owned();
        move |error: io::Error| Box::new(errors::unwritable(&path, &error))
    };
    if let Some(name) = commit::twice(files.iter().map(|file| file.name.as_str())) {
        return Err(Box::new(errors::written_twice(name)));
    }
    let mut in_place = signals::changing_files();
    let made = !folder.exists();
    if folder.is_file() {
        let in_the_way = io::Error::new(io::ErrorKind::NotADirectory, "it is a file, and no folder");
        return Err(fail(folder)(in_the_way));
    }
    fs::create_dir_all(folder).map_err(fail(folder))?;
    let written = write_set(to, files);
    if written.is_err() && made {
        // Only succeeds while it is empty, as intended.
        let _ = fs::remove_dir(folder);
    }
    *in_place = written.is_ok();
    drop(in_place);
    if signals::is_asked() {
        signals::wait_for_end();
    }
    written
}

/// Finishes an interrupted build into the folder of a file, so that all files read there are of one build.
///
/// # Errors
/// A diagnostic: the build cannot be finished, or is not of this folder.
pub fn settle(file: &Path) -> Result<(), Box<Diagnostic>> {
    let folder = file.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
    if folder.join(JOURNAL).symlink_metadata().is_err() {
        return Ok(());
    }
    let unfinished = |why: &io::Error| Box::new(errors::unfinished(folder, JOURNAL, why));
    if !commit::KNOWS_FILES {
        let why = io::Error::new(io::ErrorKind::Unsupported, "this system does not tell whose journal it is");
        return Err(unfinished(&why));
    }
    Folder::open(folder, &RealDisk).map(drop).map_err(|fault| unfinished(&fault.error))
}

fn write_set(to: &Destination, files: &[OutputFile]) -> Result<(), Box<Diagnostic>> {
    let fail = |fault: DiskFault| {
        let is_foreign = fault.path.ends_with(JOURNAL) && fault.error.kind() == io::ErrorKind::InvalidData;
        Box::new(match is_foreign {
            true => errors::unfinished(to.folder, JOURNAL, &fault.error),
            false => errors::unwritable(&fault.path, &fault.error),
        })
    };
    let folder = Folder::open(to.folder, &RealDisk).map_err(fail)?;
    let mut manifest = Manifest::read(to.folder)?;
    let changed = manifest.enter(to, files)?;
    let manifest = changed.then(|| manifest.bytes());
    let own = manifest.iter().map(|bytes| (manifest::NAME, bytes.as_slice()));
    let set: Vec<(&str, &[u8])> =
        files.iter().map(|file| (file.name.as_str(), file.bytes.as_slice())).chain(own).collect();
    folder.replace(&set).map_err(fail)
}
