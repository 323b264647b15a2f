//! Crash-safe replacement of a set of files in a folder: after a kill at any instant, the next build finds the complete
//! old set or completes the new one.
//!
//! 1. The files are staged beside their targets, under names that begin with `.tweeze-`, and synchronised.
//! 2. A journal that lists them is written under a draft name, synchronised, and renamed to [`JOURNAL`]. From then on
//!    the new set is valid.
//! 3. Each file is renamed over its target, so that a reader never finds it missing; then the journal is removed.
//!
//! The next build into the folder, or the verification of a log in it, first completes a journal that was left behind.
//! The next build also removes staged files without a journal. A set of one file needs no journal: its single rename is
//! the commit. If a rename fails, a journal that restores the old files is written; they were kept by hard links. The
//! folder is locked all the time. If the process is asked to end, it removes staged files before the journal is valid,
//! and completes the journal afterwards.

use super::signals;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Prefix of all temporary files.
const PREFIX: &str = ".tweeze-";

/// The journal's name.
pub const JOURNAL: &str = ".tweeze-journal";

/// Name of the journal before it is valid.
const DRAFT: &str = ".tweeze-draft";

/// Polling interval for a folder that another build has locked.
const PAUSE: Duration = Duration::from_millis(10);

/// Whether a journal can identify its own files by inode number, so that other files with the same names are not
/// touched.
pub const KNOWS_FILES: bool = cfg!(unix);

/// A failed operation and the file that it was for.
#[derive(Debug)]
pub struct DiskFault {
    pub path: PathBuf,
    pub error: io::Error,
}

/// File operations that change a folder; a trait, so that tests can end a process before any of them.
pub trait DiskOps {
    /// Writes a file and synchronises it.
    fn write(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        let mut options = OpenOptions::new();
        options.write(true).create(true).truncate(true);
        let mut file = options.open(path)?;
        file.write_all(bytes)?;
        file.sync_all()
    }

    /// An error once the process is asked to end. Operations that must be completed do not call it.
    fn check_interrupt(&self) -> io::Result<()> {
        Ok(())
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        fs::rename(from, to)
    }

    fn link(&self, from: &Path, to: &Path) -> io::Result<()> {
        fs::hard_link(from, to)
    }

    fn remove(&self, path: &Path) -> io::Result<()> {
        fs::remove_file(path)
    }

    /// Synchronises the directory entries of a folder, on systems where folders can be opened.
    fn sync(&self, folder: &Path) -> io::Result<()> {
        if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
    }
}

/// The disk as it is.
pub struct RealDisk;

impl DiskOps for RealDisk {
    fn check_interrupt(&self) -> io::Result<()> {
        if signals::is_asked() { Err(io::ErrorKind::Interrupted.into()) } else { Ok(()) }
    }
}

/// Pending operations, by names in the folder.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Journal {
    /// Moves whose source files are gone have already been made.
    moves: Vec<Move>,
    remove: Vec<FileRemoval>,
}

/// A rename within the folder.
#[derive(Debug, Serialize, Deserialize)]
struct Move {
    from: String,
    to: String,
    /// Inode number of the file, from [`number`]: a journal that was copied with a folder from elsewhere moves nothing.
    number: Option<u64>,
}

/// Removal of a file that did not exist before the build.
#[derive(Debug, Serialize, Deserialize)]
struct FileRemoval {
    name: String,
    number: Option<u64>,
}

impl Journal {
    /// Whether it names only files in the folder, and moves only files that a build staged there; the folder may come
    /// from anywhere.
    fn is_sound(&self) -> bool {
        let is_name = |name: &str| Path::new(name).file_name().is_some_and(|plain| plain == name);
        let removed = self.remove.iter().map(|removal| &removal.name);
        self.moves.iter().all(|step| is_name(&step.from) && step.from.starts_with(PREFIX))
            && self.moves.iter().map(|step| &step.to).chain(removed).all(|to| is_name(to) && !to.starts_with(PREFIX))
    }

    /// Whether the files that it moves are the ones that it was written for.
    fn is_of(&self, folder: &Path) -> bool {
        let is_own = |step: &Move| {
            let from = folder.join(&step.from);
            from.symlink_metadata().is_err() || number(&from) == step.number
        };
        self.moves.iter().all(is_own)
    }
}

/// Inode number of a file, on systems that have one; `None` if there is no such file.
#[cfg(unix)]
fn number(path: &Path) -> Option<u64> {
    path.symlink_metadata().ok().map(|about| std::os::unix::fs::MetadataExt::ino(&about))
}

/// Inode numbers are not available here.
#[cfg(not(unix))]
fn number(_path: &Path) -> Option<u64> {
    None
}

/// A folder locked for one build.
pub struct Folder<'a> {
    path: &'a Path,
    ops: &'a dyn DiskOps,
    /// Holds the lock.
    _lock: File,
}

impl<'a> Folder<'a> {
    /// Waits until no other build uses the folder, and completes the work of a build that was killed.
    pub fn open(path: &'a Path, ops: &'a dyn DiskOps) -> Result<Folder<'a>, DiskFault> {
        let lock = lock(path, ops).map_err(|error| DiskFault { path: path.to_owned(), error })?;
        let folder = Folder { path, ops, _lock: lock };
        folder.finish()?;
        Ok(folder)
    }

    fn fault(&self, name: &str) -> impl Fn(io::Error) -> DiskFault {
        let path = self.path.join(name);
        move |error| DiskFault { path: path.clone(), error }
    }

    /// Carries out a journal, and removes files of builds that did not get as far as a journal.
    fn finish(&self) -> Result<(), DiskFault> {
        let path = self.path.join(JOURNAL);
        match fs::read(&path) {
            Ok(bytes) => {
                let journal: Option<Journal> = serde_json::from_slice(&bytes).ok();
                let unsound = || {
                    io::Error::new(
                        io::ErrorKind::InvalidData,
                        "the journal does not belong to a build into this folder",
                    )
                };
                let is_own = |journal: &Journal| journal.is_sound() && journal.is_of(self.path);
                let journal = journal.filter(is_own).ok_or_else(unsound).map_err(self.fault(JOURNAL))?;
                self.carry_out(&journal)?;
                self.ops.remove(&path).map_err(self.fault(JOURNAL))?;
                self.ops.sync(self.path).map_err(self.fault(""))?;
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(self.fault(JOURNAL)(error)),
        }
        self.clear();
        Ok(())
    }

    fn carry_out(&self, journal: &Journal) -> Result<(), DiskFault> {
        for Move { from, to, .. } in &journal.moves {
            if self.path.join(from).symlink_metadata().is_ok() {
                self.ops.rename(&self.path.join(from), &self.path.join(to)).map_err(self.fault(to))?;
            }
        }
        for removal in &journal.remove {
            let path = self.path.join(&removal.name);
            if path.symlink_metadata().is_ok() && number(&path) == removal.number {
                self.ops.remove(&path).map_err(self.fault(&removal.name))?;
            }
        }
        self.ops.sync(self.path).map_err(self.fault(""))
    }

    /// Removes files that only a build can have left, unless a journal still needs them; one that cannot be removed
    /// does no harm.
    fn clear(&self) {
        if self.path.join(JOURNAL).symlink_metadata().is_ok() {
            return;
        }
        for entry in fs::read_dir(self.path).into_iter().flatten().flatten() {
            let is_left = entry.file_name().to_string_lossy().starts_with(PREFIX);
            // If a target was a symbolic link, the old file that was kept is one too.
            if is_left && entry.file_type().is_ok_and(|kind| kind.is_file() || kind.is_symlink()) {
                let _ = self.ops.remove(&entry.path());
            }
        }
    }

    /// Puts all files in place, or leaves all as they were.
    pub fn replace(&self, files: &[(&str, &[u8])]) -> Result<(), DiskFault> {
        let replaced = self.stage(files).and_then(|journal| match journal.moves.as_slice() {
            [Move { from, to, .. }] => {
                self.ops.rename(&self.path.join(from), &self.path.join(to)).map_err(self.fault(to))?;
                self.ops.sync(self.path).map_err(self.fault(""))
            }
            _ => self.commit(&journal),
        });
        self.clear();
        replaced
    }

    fn stage(&self, files: &[(&str, &[u8])]) -> Result<Journal, DiskFault> {
        let mut journal = Journal::default();
        for (index, (name, bytes)) in files.iter().enumerate() {
            self.ops.check_interrupt().map_err(self.fault(name))?;
            if self.path.join(name).is_dir() {
                let in_the_way = io::Error::new(io::ErrorKind::IsADirectory, "a folder has that name");
                return Err(self.fault(name)(in_the_way));
            }
            let staged = format!("{PREFIX}new-{index}");
            self.ops.write(&self.path.join(&staged), bytes).map_err(self.fault(name))?;
            let number = number(&self.path.join(&staged));
            journal.moves.push(Move { from: staged, to: (*name).to_owned(), number });
        }
        self.ops.check_interrupt().map_err(self.fault(""))?;
        Ok(journal)
    }

    fn commit(&self, journal: &Journal) -> Result<(), DiskFault> {
        let rollback = self.rollback_journal(journal)?;
        self.activate(journal)?;
        if let Err(fault) = self.carry_out(journal) {
            // The old set becomes valid again before the first of its files is moved back.
            self.activate(&rollback)?;
            self.finish()?;
            return Err(fault);
        }
        self.ops.remove(&self.path.join(JOURNAL)).map_err(self.fault(JOURNAL))?;
        self.ops.sync(self.path).map_err(self.fault(""))
    }

    /// Keeps the old files under second names, and returns the journal that would restore them.
    fn rollback_journal(&self, journal: &Journal) -> Result<Journal, DiskFault> {
        let mut back = Journal::default();
        for (index, Move { to: name, number: of_new, .. }) in journal.moves.iter().enumerate() {
            let kept = format!("{PREFIX}old-{index}");
            let (target, copy) = (self.path.join(name), self.path.join(&kept));
            match self.ops.link(&target, &copy) {
                Ok(()) => {}
                Err(error) if error.kind() == io::ErrorKind::NotFound => {
                    back.remove.push(FileRemoval { name: name.clone(), number: *of_new });
                    continue;
                }
                // Some file systems have no hard links; the old file is copied there.
                Err(_) => {
                    let bytes = fs::read(&target).map_err(self.fault(name))?;
                    self.ops.write(&copy, &bytes).map_err(self.fault(name))?;
                }
            }
            back.moves.push(Move { from: kept, to: name.clone(), number: number(&copy) });
        }
        Ok(back)
    }

    /// Makes a journal valid, replacing any other.
    fn activate(&self, journal: &Journal) -> Result<(), DiskFault> {
        let bytes = serde_json::to_vec(journal).expect("names are JSON");
        self.ops.write(&self.path.join(DRAFT), &bytes).map_err(self.fault(DRAFT))?;
        self.ops.sync(self.path).map_err(self.fault(""))?;
        self.ops.rename(&self.path.join(DRAFT), &self.path.join(JOURNAL)).map_err(self.fault(JOURNAL))?;
        self.ops.sync(self.path).map_err(self.fault(""))
    }
}

/// The first name that some file system would take for an earlier one.
pub fn first_name_collision<'n>(names: impl IntoIterator<Item = &'n str>) -> Option<&'n str> {
    let mut met = BTreeSet::new();
    names.into_iter().find(|name| !met.insert(name.to_lowercase()))
}

/// Locks a folder against other builds and waits for them. The system releases the lock when the process ends, however
/// it ends.
fn lock(folder: &Path, ops: &dyn DiskOps) -> io::Result<File> {
    let file = match cfg!(unix) {
        true => File::open(folder)?,
        false => OpenOptions::new().create(true).truncate(false).write(true).open(folder.join(".tweeze.lock"))?,
    };
    loop {
        match file.try_lock() {
            Ok(()) => return Ok(file),
            Err(TryLockError::WouldBlock) => ops.check_interrupt()?,
            // Some network file systems have no locks; concurrent builds are not separated there.
            Err(TryLockError::Error(error)) if error.kind() == io::ErrorKind::Unsupported => return Ok(file),
            Err(TryLockError::Error(error)) => return Err(error),
        }
        std::thread::sleep(PAUSE);
    }
}

#[cfg(test)]
mod tests;
