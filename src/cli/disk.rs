//! Files: reading programs and logs, writing whole sets or nothing.

use super::errors;
use crate::diagnostic::Diagnostic;
use crate::emit::OutputFile;
use crate::source::MAX_FILE_BYTES;
use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

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
        let line = error.as_bytes()[..at].iter().filter(|byte| **byte == b'\n').count() + 1;
        Box::new(errors::not_utf8(path, at, line))
    })
}

/// Reads a file of at most so many bytes.
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

/// Writes a set of files into a folder: all of them, or none.
///
/// Each is written beside its place and synchronised first; only then are all renamed. If a rename fails, those done before it are
/// taken back.
///
/// # Errors
/// A diagnostic that names the file or folder and why.
pub fn write_all(folder: &Path, files: &[OutputFile]) -> Result<(), Box<Diagnostic>> {
    let fail = |path: &Path| {
        let path = path.to_owned();
        move |error: io::Error| Box::new(errors::unwritable(&path, &error))
    };
    let made = !folder.exists();
    if folder.is_file() {
        let in_the_way = io::Error::new(io::ErrorKind::NotADirectory, "it is a file, and no folder");
        return Err(fail(folder)(in_the_way));
    }
    fs::create_dir_all(folder).map_err(fail(folder))?;
    let written = stage(folder, files).and_then(|staged| commit(folder, staged));
    if written.is_err() && made {
        // Only succeeds while it is empty, which is what is wanted.
        let _ = fs::remove_dir(folder);
    }
    written
}

type Staged = Vec<(NamedTempFile, PathBuf)>;

fn stage(folder: &Path, files: &[OutputFile]) -> Result<Staged, Box<Diagnostic>> {
    files
        .iter()
        .map(|file| {
            let target = folder.join(&file.name);
            let staged = stage_one(folder, &file.bytes, &target);
            staged.map(|staged| (staged, target.clone())).map_err(|error| Box::new(errors::unwritable(&target, &error)))
        })
        .collect()
}

fn stage_one(folder: &Path, bytes: &[u8], target: &Path) -> io::Result<NamedTempFile> {
    if target.is_dir() {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "a folder of that name is in the way"));
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(".tweeze-");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut staged = builder.tempfile_in(folder)?;
    staged.write_all(bytes)?;
    staged.as_file().sync_all()?;
    Ok(staged)
}

/// A file that was put in place, and what stood there before.
struct Replaced {
    target: PathBuf,
    before: Option<tempfile::TempPath>,
}

fn commit(folder: &Path, staged: Staged) -> Result<(), Box<Diagnostic>> {
    let mut done: Vec<Replaced> = Vec::with_capacity(staged.len());
    for (file, target) in staged {
        match replace(folder, file, &target) {
            Ok(replaced) => done.push(replaced),
            Err(error) => {
                take_back(done);
                return Err(Box::new(errors::unwritable(&target, &error)));
            }
        }
    }
    Ok(())
}

fn replace(folder: &Path, file: NamedTempFile, target: &Path) -> io::Result<Replaced> {
    let before = if target.exists() {
        let aside = tempfile::Builder::new().prefix(".tweeze-").tempfile_in(folder)?.into_temp_path();
        fs::rename(target, &aside)?;
        Some(aside)
    } else {
        None
    };
    match file.persist(target) {
        Ok(_) => Ok(Replaced { target: target.to_owned(), before }),
        Err(error) => {
            take_back(vec![Replaced { target: target.to_owned(), before }]);
            Err(error.error)
        }
    }
}

/// Undoes replacements as far as the disk lets it; the first error is the one to be told.
fn take_back(done: Vec<Replaced>) {
    for Replaced { target, before } in done.into_iter().rev() {
        match before {
            Some(before) => drop(fs::rename(&before, &target)),
            None => drop(fs::remove_file(&target)),
        }
    }
}
