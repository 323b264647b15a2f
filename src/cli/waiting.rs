//! Progress line for work that lasts longer than a second; on a terminal only.

use crate::plan::watch::{SearchProgress, SearchWatch};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// Time after which a progress line appears.
const PATIENCE: Duration = Duration::from_secs(1);

/// Interval at which the line is redrawn.
const TICK: Duration = Duration::from_millis(100);

/// Progress line; appears after one second. Dropping it clears the line.
pub struct ProgressLine {
    shared: Arc<Shared>,
    watcher: Option<JoinHandle<()>>,
}

struct Shared {
    /// The searches of the work.
    search: Arc<SearchWatch>,
    state: Mutex<State>,
    end: Condvar,
}

#[derive(Default)]
struct State {
    part: Option<WorkPart>,
    /// `None` until the line appears.
    bar: Option<ProgressBar>,
    is_over: bool,
}

/// The current part of the work: its index, the number of parts, and its name.
struct WorkPart {
    index: usize,
    count: usize,
    name: String,
}

impl Shared {
    fn state(&self) -> MutexGuard<'_, State> {
        // A thread that panicked has left the bar as it was.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until the line is due, then shows it with the progress of the search until the work is over.
    fn watch(&self) {
        let mut patience = PATIENCE;
        loop {
            let waiting = self.end.wait_timeout_while(self.state(), patience, |state| !state.is_over);
            let (mut state, _) = waiting.unwrap_or_else(PoisonError::into_inner);
            if state.is_over {
                return;
            }
            let State { part, bar, .. } = &mut *state;
            show(bar.get_or_insert_with(new_bar), part.as_ref(), &self.search.progress());
            patience = TICK;
        }
    }
}

impl ProgressLine {
    /// Starts waiting for work and its searches; shows nothing if standard error is not a terminal.
    pub fn begin(search: &Arc<SearchWatch>) -> ProgressLine {
        let shared = Arc::new(Shared { search: Arc::clone(search), state: Mutex::default(), end: Condvar::new() });
        let watched = Arc::clone(&shared);
        let is_shown = std::io::stderr().is_terminal();
        ProgressLine { shared, watcher: is_shown.then(|| std::thread::spawn(move || watched.watch())) }
    }

    /// Records that a part of the work has begun.
    pub fn at(&self, index: usize, count: usize, name: &str) {
        self.shared.state().part = Some(WorkPart { index, count, name: name.to_owned() });
    }

    /// Writes to the terminal while the line is hidden.
    pub fn beside<T>(&self, write: impl FnOnce() -> T) -> T {
        match &self.shared.state().bar {
            Some(bar) => bar.suspend(write),
            None => write(),
        }
    }
}

fn new_bar() -> ProgressBar {
    let bar = ProgressBar::new(0);
    if let Ok(style) = ProgressStyle::with_template(" Planning {bar:16} {pos}/{len} {elapsed} {wide_msg}") {
        bar.set_style(style);
    }
    bar
}

fn show(bar: &ProgressBar, part: Option<&WorkPart>, progress: &SearchProgress) {
    let Some(part) = part else { return };
    bar.set_length(part.count as u64);
    bar.set_position(part.index as u64);
    bar.set_message(progress_text(&part.name, progress));
    bar.tick();
}

/// `fetch: 12.3 M steps of search, best so far 41 steps, least 39`.
fn progress_text(name: &str, progress: &SearchProgress) -> String {
    let searched = match progress.steps {
        0 => String::new(),
        steps => format!(": {} of search", steps_in_short(steps)),
    };
    let best = progress.best.as_ref().map(|best| format!(", best so far {best}")).unwrap_or_default();
    format!("{name}{searched}{best}")
}

/// A number of steps in short form, because it changes all the time.
fn steps_in_short(steps: u64) -> String {
    match steps {
        0..10_000 => format!("{steps} steps"),
        10_000..1_000_000 => format!("{} k steps", steps / 1000),
        _ => format!("{:.1} M steps", steps as f64 / 1e6),
    }
}

impl Drop for ProgressLine {
    fn drop(&mut self) {
        self.shared.state().is_over = true;
        self.shared.end.notify_all();
        if let Some(watcher) = self.watcher.take() {
            // A watcher that panicked has nothing to clear.
            let _ = watcher.join();
        }
        if let Some(bar) = self.shared.state().bar.take() {
            bar.finish_and_clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_says_how_far_the_search_came() {
        let progress = |steps, best: Option<&str>| SearchProgress { steps, best: best.map(str::to_owned) };
        assert_eq!(progress_text("fetch", &progress(0, None)), "fetch");
        assert_eq!(progress_text("fetch", &progress(61_440, None)), "fetch: 61 k steps of search");
        let best = progress(12_345_678, Some("41 steps, least 39"));
        assert_eq!(progress_text("fetch", &best), "fetch: 12.3 M steps of search, best so far 41 steps, least 39");
    }
}
