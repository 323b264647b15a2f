//! File snapshots: modification time and length, for detecting changes without reading the files.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Modification time and length of a file; `None` if there is no file.
type FileSnapshot = Option<(Option<SystemTime>, u64)>;

/// Snapshots of files, each taken when the file was first looked at. A caller that takes the snapshot before it reads
/// the file misses no change.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FileSnapshots(BTreeMap<PathBuf, FileSnapshot>);

impl FileSnapshots {
    /// Takes snapshots of files now.
    pub fn of<'f>(files: impl IntoIterator<Item = &'f PathBuf>) -> FileSnapshots {
        FileSnapshots(files.into_iter().map(|file| (file.clone(), snapshot(file))).collect())
    }

    /// Takes a snapshot of a file, unless there is one already.
    pub fn record(&mut self, file: &Path) {
        self.0.entry(file.to_owned()).or_insert_with(|| snapshot(file));
    }

    /// Adds the snapshots of other files; for a file in both, the snapshot here stays.
    pub fn add(&mut self, others: FileSnapshots) {
        others.0.into_iter().for_each(|(file, seen)| {
            self.0.entry(file).or_insert(seen);
        });
    }

    /// New snapshots of the same files.
    #[must_use]
    pub fn retaken(&self) -> FileSnapshots {
        FileSnapshots::of(self.0.keys())
    }

    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.0.keys().map(PathBuf::as_path)
    }

    /// Number of files.
    pub fn len(&self) -> usize {
        self.0.len()
    }
}

fn snapshot(file: &Path) -> FileSnapshot {
    fs::metadata(file).ok().map(|found| (found.modified().ok(), found.len()))
}
