//! Files: reads programs and logs, and writes complete sets of files or nothing.

mod commit;
mod manifest;

use super::file_snapshots::FileSnapshots;
use super::{errors, signals};
use crate::diagnostic::Diagnosed;
use crate::emit::OutputFile;
use crate::source::MAX_FILE_BYTES;
use commit::{DiskFault, Folder, JOURNAL, RealDisk};
use manifest::Manifest;
use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

/// The largest log that is read, in bytes.
pub const MAX_LOG_BYTES: usize = 1024 * 1024 * 1024;

/// Reads a program's text.
///
/// # Errors
/// A diagnostic: the file cannot be read, is too large, or is not UTF-8.
pub fn read_program(path: &Path) -> Diagnosed<String> {
    text_of(path, read_bytes(path, MAX_FILE_BYTES)?)
}

/// Decodes a file. Alternating zero bytes mean UTF-16, although such bytes are valid UTF-8 too.
fn text_of(name: &Path, bytes: Vec<u8>) -> Diagnosed<String> {
    let zeros = bytes.first_chunk::<4>().map(|first| first.map(|byte| byte == 0));
    if let Some([false, true, false, true] | [true, false, true, false]) = zeros {
        let at = bytes.iter().position(|byte| *byte == 0).unwrap_or(0);
        return Err(Box::new(errors::not_utf8(name, &bytes, at)));
    }
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        Box::new(errors::not_utf8(name, error.as_bytes(), at))
    })
}

/// Reads a file of at most `limit` bytes.
///
/// # Errors
/// A diagnostic: the file cannot be read or is too large.
pub fn read_bytes(path: &Path, limit: usize) -> Diagnosed<Vec<u8>> {
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

/// The argument for standard input, and the name of standard input in messages and outputs.
const STANDARD_INPUT: &str = "-";
const STANDARD_INPUT_NAME: &str = "<stdin>";

/// Whether an argument stands for standard input.
pub fn is_standard_input(argument: &Path) -> bool {
    argument.as_os_str() == STANDARD_INPUT
}

/// Reads the program that an argument names; also returns its path, or the name of standard input.
///
/// # Errors
/// A diagnostic: it cannot be read, is too large, or is not UTF-8.
pub fn read_argument(argument: &Path) -> Diagnosed<(PathBuf, String)> {
    match is_standard_input(argument) {
        true => read_standard_input().map(|text| (PathBuf::from(STANDARD_INPUT_NAME), text)),
        false => read_program(argument).map(|text| (argument.to_owned(), text)),
    }
}

fn read_standard_input() -> Diagnosed<String> {
    let name = Path::new(STANDARD_INPUT_NAME);
    let mut bytes = Vec::new();
    let read = io::stdin().lock().take(MAX_FILE_BYTES as u64 + 1).read_to_end(&mut bytes);
    read.map_err(|error| Box::new(errors::unreadable(name, &error)))?;
    if bytes.len() > MAX_FILE_BYTES {
        return Err(Box::new(errors::too_large(name, MAX_FILE_BYTES)));
    }
    text_of(name, bytes)
}

/// The `.twz` files in a folder and its subfolders, by path; hidden folders and links to folders are skipped.
///
/// # Errors
/// A diagnostic: a folder cannot be read.
pub fn programs_in(folder: &Path) -> Diagnosed<Vec<PathBuf>> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(folder) = open.pop() {
        let unreadable = |error: io::Error| Box::new(errors::unreadable(&folder, &error));
        for entry in fs::read_dir(&folder).map_err(unreadable)? {
            let entry = entry.map_err(unreadable)?;
            let path = entry.path();
            let is_hidden = entry.file_name().to_string_lossy().starts_with('.');
            if entry.file_type().map_err(unreadable)?.is_dir() {
                open.extend((!is_hidden).then_some(path));
            } else if path.extension().is_some_and(|ending| ending == "twz") {
                found.push(path);
            }
        }
    }
    found.sort();
    Ok(found)
}

/// Replaces the text of a file atomically: a reader finds the old text or the new one. Its permissions are kept, and so
/// is a link to it.
///
/// # Errors
/// A diagnostic: the file is read-only, or its folder cannot be written to.
pub fn replace(path: &Path, text: &str) -> Diagnosed {
    replaced(path, text).map_err(|error| Box::new(errors::not_replaced(path, &error)))
}

fn replaced(path: &Path, text: &str) -> io::Result<()> {
    let target = fs::canonicalize(path)?;
    let permissions = fs::metadata(&target)?.permissions();
    if permissions.readonly() {
        return Err(io::Error::new(io::ErrorKind::PermissionDenied, "it is read-only"));
    }
    let folder = target.parent().unwrap_or(Path::new("."));
    let mut file = tempfile::Builder::new().prefix(".tweeze-fmt-").tempfile_in(folder)?;
    file.write_all(text.as_bytes())?;
    file.as_file().set_permissions(permissions)?;
    file.as_file().sync_all()?;
    file.persist(&target).map(drop).map_err(|error| error.error)
}

/// Destination of a set of files.
pub struct Destination<'a> {
    pub folder: &'a Path,
    /// The program that the files are built from, or the log that they show.
    pub program: &'a Path,
    /// For a log: the name in the log of the program that it was built from.
    pub logged: Option<&'a str>,
    /// Whether files of other programs are replaced.
    pub force: bool,
    /// Input files, which are never replaced.
    pub inputs: &'a FileSnapshots,
}

impl Destination<'_> {
    /// The first of some output files that would replace an input file.
    fn replaced_input(&self, files: &[OutputFile]) -> Option<PathBuf> {
        let inputs: Vec<PathBuf> = self.inputs.files().filter_map(|input| input.canonicalize().ok()).collect();
        let mut paths = files.iter().map(|file| shown(self.folder, &file.name));
        paths.find(|path| path.canonicalize().is_ok_and(|path| inputs.contains(&path)))
    }
}

/// Path of a file in a folder, as the user would write it.
pub fn shown(folder: &Path, name: &str) -> PathBuf {
    if folder == Path::new(".") { PathBuf::from(name) } else { folder.join(name) }
}

/// Writes a set of files into a folder: all of them or none; see [`commit`] for the effect of a kill. Files that were
/// built from another program are replaced only if requested.
///
/// # Errors
/// A diagnostic that names the file or folder and why.
pub fn write_all(to: &Destination, files: &[OutputFile]) -> Diagnosed {
    let folder = to.folder;
    let fail = |path: &Path| {
        let path = path.to_owned();
        move |error: io::Error| Box::new(errors::unwritable(&path, &error))
    };
    if let Some(name) = commit::first_name_collision(files.iter().map(|file| file.name.as_str())) {
        return Err(Box::new(errors::written_twice(name)));
    }
    if let Some(input) = to.replaced_input(files) {
        return Err(Box::new(errors::would_replace_input(&input)));
    }
    let mut in_place = signals::changing_files();
    let made = !folder.exists();
    if folder.is_file() {
        return Err(fail(folder)(no_folder()));
    }
    fs::create_dir_all(folder).map_err(fail(folder))?;
    let written = write_set(to, files);
    if written.is_err() && made {
        // Succeeds only if the folder is empty, as intended.
        let _ = fs::remove_dir(folder);
    }
    *in_place = written.is_ok();
    drop(in_place);
    if signals::is_asked() {
        signals::wait_for_end();
    }
    written
}

/// Removes a file from a folder if it is there and was built from this program.
///
/// # Errors
/// A diagnostic that names the file or folder and why.
pub fn remove_own(to: &Destination, name: &str) -> Diagnosed {
    let path = to.folder.join(name);
    if path.symlink_metadata().is_err() || !Manifest::read(to.folder)?.is_own(to, name) {
        return Ok(());
    }
    fs::remove_file(&path).map_err(|error| Box::new(errors::unwritable(&path, &error)))
}

/// Checks whether files can be written into a folder, or into its nearest existing ancestor, before a long search for a
/// plan.
///
/// # Errors
/// A diagnostic that names the folder and why.
pub fn try_folder(folder: &Path) -> Diagnosed {
    let is_there = |folder: &&Path| !folder.as_os_str().is_empty() && folder.symlink_metadata().is_ok();
    let existing = folder.ancestors().find(is_there).unwrap_or(Path::new("."));
    let tried = if existing.is_file() { Err(no_folder()) } else { tempfile::tempfile_in(existing).map(drop) };
    tried.map_err(|error| Box::new(errors::unwritable(existing, &error)))
}

fn no_folder() -> io::Error {
    io::Error::new(io::ErrorKind::NotADirectory, "it is a file, not a folder")
}

/// Creates a folder with files in it, by name: completely or not at all. Missing parent folders are created.
///
/// # Errors
/// A diagnostic: something of that name exists, or it cannot be written.
pub fn make_folder(folder: &Path, files: &[(&str, String)]) -> Diagnosed {
    made(folder, files).map_err(|error| Box::new(errors::not_made(folder, &error)))
}

fn made(folder: &Path, files: &[(&str, String)]) -> io::Result<()> {
    if folder.symlink_metadata().is_ok() {
        return Err(io::Error::new(io::ErrorKind::AlreadyExists, "it already exists"));
    }
    let above = folder.parent().filter(|above| *above != Path::new("")).unwrap_or(Path::new("."));
    fs::create_dir_all(above)?;
    let draft = tempfile::Builder::new().prefix(".tweeze-new-").tempdir_in(above)?;
    // A temporary folder is private to its owner; a project should not be.
    let whole = draft.path().join("whole");
    fs::create_dir(&whole)?;
    files.iter().try_for_each(|(name, text)| fs::write(whole.join(name), text))?;
    fs::rename(&whole, folder)
}

/// Completes an interrupted build into the folder of a file, so that all files read there are of one build.
///
/// # Errors
/// A diagnostic: the build cannot be finished, or is not of this folder.
pub fn settle(file: &Path) -> Diagnosed {
    let folder = file.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
    if folder.join(JOURNAL).symlink_metadata().is_err() {
        return Ok(());
    }
    let unfinished = |why: &io::Error| Box::new(errors::unfinished(folder, JOURNAL, why));
    if !commit::KNOWS_FILES {
        let why = io::Error::new(io::ErrorKind::Unsupported, "this system does not report who owns the journal");
        return Err(unfinished(&why));
    }
    Folder::open(folder, &RealDisk).map(drop).map_err(|fault| unfinished(&fault.error))
}

fn write_set(to: &Destination, files: &[OutputFile]) -> Diagnosed {
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
