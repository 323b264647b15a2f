//! What there is to see of files without reading them, to know of their changes.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// The time and the length of a file; `None` where there is none.
type Glance = Option<(Option<SystemTime>, u64)>;

/// Files, each as it was when it was first looked at: whoever looks at a file before reading it misses no change.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Glances(BTreeMap<PathBuf, Glance>);

impl Glances {
    /// Files as they are now.
    pub fn of<'f>(files: impl IntoIterator<Item = &'f PathBuf>) -> Glances {
        Glances(files.into_iter().map(|file| (file.clone(), glance(file))).collect())
    }

    /// Looks at a file that was not looked at before.
    pub fn look_at(&mut self, file: &Path) {
        self.0.entry(file.to_owned()).or_insert_with(|| glance(file));
    }

    /// Adds what was seen of other files; of a file in both, what was seen here.
    pub fn add(&mut self, others: Glances) {
        others.0.into_iter().for_each(|(file, seen)| {
            self.0.entry(file).or_insert(seen);
        });
    }

    /// The same files as they are now.
    #[must_use]
    pub fn again(&self) -> Glances {
        Glances::of(self.0.keys())
    }

    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.0.keys().map(PathBuf::as_path)
    }

    /// Number of files.
    pub fn len(&self) -> usize {
        self.0.len()
    }
}

fn glance(file: &Path) -> Glance {
    fs::metadata(file).ok().map(|found| (found.modified().ok(), found.len()))
}
