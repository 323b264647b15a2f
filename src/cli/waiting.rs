//! A sign of life for work that lasts longer than a second; on a terminal only.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::Duration;

/// Time after which a progress line appears.
const PATIENCE: Duration = Duration::from_secs(1);

/// Period of the animation.
const TICK: Duration = Duration::from_millis(100);

/// Progress line; appears after one second. Dropping it clears the line.
pub struct ProgressLine {
    news: Option<Sender<News>>,
    watcher: Option<JoinHandle<()>>,
}

/// The current part of the work: its index, the number of parts, and its name.
struct News {
    index: usize,
    count: usize,
    name: String,
}

impl ProgressLine {
    /// Begins to wait; silent where standard error is no terminal.
    pub fn begin() -> ProgressLine {
        if !std::io::stderr().is_terminal() {
            return ProgressLine { news: None, watcher: None };
        }
        let (news, received) = mpsc::channel::<News>();
        let watcher = std::thread::spawn(move || {
            let mut latest = None;
            let patience = std::time::Instant::now() + PATIENCE;
            loop {
                let left = patience.saturating_duration_since(std::time::Instant::now());
                match received.recv_timeout(left) {
                    Ok(part) => latest = Some(part),
                    Err(RecvTimeoutError::Disconnected) => return,
                    Err(RecvTimeoutError::Timeout) => break,
                }
            }
            let bar = bar(latest);
            for part in received {
                show(&bar, &part);
            }
            bar.finish_and_clear();
        });
        ProgressLine { news: Some(news), watcher: Some(watcher) }
    }

    /// Tells that a part of the work has begun.
    pub fn at(&self, index: usize, count: usize, name: &str) {
        if let Some(news) = &self.news {
            // The watcher ends only when this sender is dropped.
            let _ = news.send(News { index, count, name: name.to_owned() });
        }
    }
}

fn bar(latest: Option<News>) -> ProgressBar {
    let bar = ProgressBar::new(0);
    if let Ok(style) = ProgressStyle::with_template("  Planning {bar:24} {pos}/{len} {msg} ({elapsed})") {
        bar.set_style(style);
    }
    if let Some(part) = latest {
        show(&bar, &part);
    }
    bar.enable_steady_tick(TICK);
    bar
}

fn show(bar: &ProgressBar, part: &News) {
    bar.set_length(part.count as u64);
    bar.set_position(part.index as u64);
    bar.set_message(part.name.clone());
}

impl Drop for ProgressLine {
    fn drop(&mut self) {
        self.news = None;
        if let Some(watcher) = self.watcher.take() {
            // A watcher that panicked has nothing to clear.
            let _ = watcher.join();
        }
    }
}
