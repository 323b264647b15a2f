//! `--watch`: programs are built again whenever one of their files changes.

use super::arguments::QuietArgument;
use super::{Exit, terminal};
use crate::schedule::cost::count;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Period in which files are looked at: that works on every file system, also on those that tell nobody of changes.
const PERIOD: Duration = Duration::from_millis(150);

/// What there is to see of a file without reading it; `None` where there is none.
type Glance = Option<(Option<SystemTime>, u64)>;

/// Builds, and builds again after each change of a file that the last build needed. A build answers with its exit status and adds the
/// files that it needs. Only a signal ends it, or wrong usage.
pub fn watch(
    programs: &[PathBuf],
    quiet: QuietArgument,
    mut build: impl FnMut(&mut BTreeSet<PathBuf>) -> Exit,
) -> Exit {
    let mut needed: BTreeSet<PathBuf> = programs.iter().cloned().collect();
    loop {
        // Glances from before the build: what changes while it goes on is built again.
        let before = glances(&needed);
        needed = programs.iter().cloned().collect();
        if build(&mut needed) == Exit::Usage {
            return Exit::Usage;
        }
        let files = count(needed.len(), "file");
        // Without a reader it goes on.
        let _ = terminal::success(&terminal::line("Watching", &files, 0, "Ctrl-C ends"), quiet);
        let built: BTreeMap<&Path, Glance> = needed
            .iter()
            .map(|file| (file.as_path(), before.get(file).copied().unwrap_or_else(|| glance(file))))
            .collect();
        while needed.iter().all(|file| glance(file) == built[file.as_path()]) {
            std::thread::sleep(PERIOD);
        }
        settle(&needed);
    }
}

/// Waits until the files stay as they are: an editor may write in several steps.
fn settle(files: &BTreeSet<PathBuf>) {
    let mut before = glances(files);
    loop {
        std::thread::sleep(PERIOD);
        let now = glances(files);
        if now == before {
            return;
        }
        before = now;
    }
}

fn glances(files: &BTreeSet<PathBuf>) -> BTreeMap<PathBuf, Glance> {
    files.iter().map(|file| (file.clone(), glance(file))).collect()
}

fn glance(file: &Path) -> Glance {
    fs::metadata(file).ok().map(|found| (found.modified().ok(), found.len()))
}
