//! A sign of life for work that lasts longer than a second; on a terminal only.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// Time after which a progress line appears.
const PATIENCE: Duration = Duration::from_secs(1);

/// Period of the animation.
const TICK: Duration = Duration::from_millis(100);

/// Progress line; appears after one second. Dropping it clears the line.
pub struct ProgressLine {
    shared: Arc<Shared>,
    watcher: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    end: Condvar,
}

#[derive(Default)]
struct State {
    part: Option<WorkPart>,
    /// Once it has appeared.
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
        // A thread that panicked has left a bar as it was.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for the patience to end, and shows the line unless the work has ended before.
    fn watch(&self) {
        let waiting = self.end.wait_timeout_while(self.state(), PATIENCE, |state| !state.is_over);
        let (mut state, _) = waiting.unwrap_or_else(PoisonError::into_inner);
        if !state.is_over {
            state.bar = Some(bar(state.part.as_ref()));
        }
    }
}

impl ProgressLine {
    /// Begins to wait; silent where standard error is no terminal.
    pub fn begin() -> ProgressLine {
        let shared = Arc::new(Shared::default());
        let watched = Arc::clone(&shared);
        let is_shown = std::io::stderr().is_terminal();
        ProgressLine { shared, watcher: is_shown.then(|| std::thread::spawn(move || watched.watch())) }
    }

    /// Tells that a part of the work has begun.
    pub fn at(&self, index: usize, count: usize, name: &str) {
        let mut state = self.shared.state();
        let part = WorkPart { index, count, name: name.to_owned() };
        if let Some(bar) = &state.bar {
            show(bar, &part);
        }
        state.part = Some(part);
    }

    /// Writes to the terminal while the line is out of the way.
    pub fn beside<T>(&self, write: impl FnOnce() -> T) -> T {
        match &self.shared.state().bar {
            Some(bar) => bar.suspend(write),
            None => write(),
        }
    }
}

fn bar(part: Option<&WorkPart>) -> ProgressBar {
    let bar = ProgressBar::new(0);
    if let Ok(style) = ProgressStyle::with_template("  Planning {bar:24} {pos}/{len} {msg} ({elapsed})") {
        bar.set_style(style);
    }
    if let Some(part) = part {
        show(&bar, part);
    }
    bar.enable_steady_tick(TICK);
    bar
}

fn show(bar: &ProgressBar, part: &WorkPart) {
    bar.set_length(part.count as u64);
    bar.set_position(part.index as u64);
    bar.set_message(part.name.clone());
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
