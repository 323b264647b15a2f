//! `--watch`: builds programs again whenever one of their files changes.

use super::arguments::QuietArgument;
use super::file_snapshots::FileSnapshots;
use super::{Exit, terminal};
use crate::quantity::count;
use std::path::PathBuf;
use std::thread;
use std::time::Duration;

/// Polling interval. Polling works on every file system, including those without change notifications.
const PERIOD: Duration = Duration::from_millis(150);

/// Builds, and builds again after each change of a file that the last build needed. `build` returns its exit status and
/// adds the files that it needs, each with its state before it was read. Only a signal or wrong usage ends the loop.
pub fn watch(programs: &[PathBuf], quiet: QuietArgument, mut build: impl FnMut(&mut FileSnapshots) -> Exit) -> Exit {
    loop {
        let mut needed = FileSnapshots::of(programs);
        if build(&mut needed) == Exit::Usage {
            return Exit::Usage;
        }
        let files = count(needed.len(), "file");
        // Goes on even if nobody reads the output.
        let _ = terminal::success(&terminal::line("Watching", &files, 0, "Ctrl-C ends"), quiet);
        // Changes during the build trigger another one too.
        while needed.retaken() == needed {
            thread::sleep(PERIOD);
        }
        settle(needed.retaken());
    }
}

/// Waits until files stop changing, because an editor may write in several steps.
fn settle(mut files: FileSnapshots) {
    loop {
        thread::sleep(PERIOD);
        let now = files.retaken();
        if now == files {
            return;
        }
        files = now;
    }
}
