//! `--watch`: programs are built again whenever one of their files changes.

use super::arguments::QuietArgument;
use super::glances::Glances;
use super::{Exit, terminal};
use crate::quantity::count;
use std::path::PathBuf;
use std::thread;
use std::time::Duration;

/// Period in which files are looked at: that works on every file system, also on those that tell nobody of changes.
const PERIOD: Duration = Duration::from_millis(150);

/// Builds, and builds again after each change of a file that the last build needed. A build answers with its exit status and adds the
/// files that it needs, each as it was before it was read. Only a signal ends it, or wrong usage.
pub fn watch(programs: &[PathBuf], quiet: QuietArgument, mut build: impl FnMut(&mut Glances) -> Exit) -> Exit {
    loop {
        let mut needed = Glances::of(programs);
        if build(&mut needed) == Exit::Usage {
            return Exit::Usage;
        }
        let files = count(needed.len(), "file");
        // Without a reader it goes on.
        let _ = terminal::success(&terminal::line("Watching", &files, 0, "Ctrl-C ends"), quiet);
        // What changed while the build went on is built again, too.
        while needed.again() == needed {
            thread::sleep(PERIOD);
        }
        settle(needed.again());
    }
}

/// Waits until files stay as they are: an editor may write in several steps.
fn settle(mut files: Glances) {
    loop {
        thread::sleep(PERIOD);
        let now = files.again();
        if now == files {
            return;
        }
        files = now;
    }
}
