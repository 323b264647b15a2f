//! Signals that end the process: Ctrl-C, a closed terminal, a request to terminate. Of a build, staged files are removed, or a commit
//! that has begun is finished; then the process dies of the signal. A controlled run stops its robots first.

use super::terminal;
use crate::plan::watch::SearchWatch;
use std::io::{self, IsTerminal};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, Once, PoisonError};
use std::time::Duration;

/// Whether the process has been asked to end.
static ASKED: AtomicBool = AtomicBool::new(false);

/// Whether the build's files are in place. Held while a folder is changed: who ends the process waits for it.
static FILES_IN_PLACE: Mutex<bool> = Mutex::new(false);

/// Milliseconds in which the handler of a signal sets its flag.
const FLAG_LOOKS: usize = 1000;

/// What the first signal ends in place of the process.
enum Spared {
    /// Ctrl-C alone ends the search.
    Search(Arc<SearchWatch>),
    /// Any signal ends the run.
    Run(Arc<AtomicBool>),
}

static SPARED: Mutex<Option<Spared>> = Mutex::new(None);

fn spared() -> MutexGuard<'static, Option<Spared>> {
    // A thread that panicked has left one of them, or none.
    SPARED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// While this lives, the first Ctrl-C ends a search with what it has found.
pub struct BestKept(());

/// The first Ctrl-C from here on is for the searches that are watched.
pub fn keep_best(search: &Arc<SearchWatch>) -> BestKept {
    *spared() = Some(Spared::Search(Arc::clone(search)));
    BestKept(())
}

impl Drop for BestKept {
    fn drop(&mut self) {
        *spared() = None;
    }
}

/// While this lives, the first signal does not end the process: whoever holds it stops what is running, and then ends.
pub struct RunStop(Arc<AtomicBool>);

/// The first signal from here on is for the run that asks [`RunStop::is_asked`].
pub fn stop_run_first() -> RunStop {
    let stop = Arc::<AtomicBool>::default();
    *spared() = Some(Spared::Run(Arc::clone(&stop)));
    RunStop(stop)
}

impl RunStop {
    /// Whether the run has been asked to stop.
    pub fn is_asked(&self) -> bool {
        self.0.load(Ordering::SeqCst)
    }
}

impl Drop for RunStop {
    fn drop(&mut self) {
        *spared() = None;
    }
}

/// Whether a signal is for what is spared: a search then takes the best plan it has, or the first one that it finds; a run stops.
fn spares_the_process(is_ctrl_c: bool) -> bool {
    // Held until the end: who drops `BestKept` or `RunStop` waits for it.
    let mut spared = spared();
    let taken = spared.take_if(|one| match one {
        Spared::Search(_) => is_ctrl_c,
        Spared::Run(_) => true,
    });
    let Some(taken) = taken else { return false };
    if let Spared::Search(search) = &taken {
        search.take_what_is_held();
    }
    // Before whoever drops `BestKept` can go on to write, or the run can end. The handler that sets it may not have come to that yet.
    for _ in 0..FLAG_LOOKS {
        if ASKED.swap(false, Ordering::SeqCst) {
            break;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let line = if io::stderr().is_terminal() { "\n" } else { "" };
    match taken {
        Spared::Search(_) => terminal::to_stderr(&format!(
            "{line}tweeze: goes on with the best plan found; Ctrl-C again ends without one\n"
        )),
        Spared::Run(stop) => stop.store(true, Ordering::SeqCst),
    }
    true
}

/// Whether the process has been asked to end. True at the latest when the handler of the signal returns.
pub fn is_asked() -> bool {
    ASKED.load(Ordering::SeqCst)
}

/// Keeps the process alive until dropped; to be set to true once the files are in place.
pub fn changing_files() -> MutexGuard<'static, bool> {
    // A thread that panicked has left a folder as a kill would have left it.
    FILES_IN_PLACE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Waits for the end, after [`is_asked`].
pub fn wait_for_end() -> ! {
    loop {
        std::thread::park();
    }
}

/// Reports the files written, once no folder is being changed. The guard is held until the process ends, so that nothing more is begun.
fn say_goodbye() -> MutexGuard<'static, bool> {
    let in_place = changing_files();
    let line = if io::stderr().is_terminal() { "\n" } else { "" };
    let written = if *in_place { "after its files were written" } else { "nothing was written" };
    terminal::to_stderr(&format!("{line}tweeze: interrupted, {written}\n"));
    in_place
}

/// A file beyond the limit of the process is from here on an error of the write, and not the end of the process.
pub fn outlive_limits() {
    #[cfg(unix)]
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::<AtomicBool>::default());
}

/// From here on, signals that ask the process to end wait for [`changing_files`]; asked again, nothing changes.
pub fn catch() {
    static CAUGHT: Once = Once::new();
    CAUGHT.call_once(install);
}

/// Where signals cannot be caught, they end the process at once, and the next build into the folder clears up.
#[cfg(unix)]
fn install() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::{flag, iterator::Signals, low_level};
    let ignored = ignored_signals();
    let wanted = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|signal| ignored >> (signal - 1) & 1 == 0);
    let wanted: Vec<i32> = wanted.collect();
    let Ok(mut signals) = Signals::new(&wanted) else { return };
    let watch = move || {
        for signal in signals.forever() {
            if spares_the_process(signal == SIGINT) {
                continue;
            }
            let _alive = say_goodbye();
            // Whoever waits for this process learns that a signal ended it: a shell shows 128 and the signal's number.
            let _ = low_level::emulate_default_handler(signal);
            std::process::exit(128 + signal);
        }
    };
    if std::thread::Builder::new().spawn(watch).is_ok() {
        for signal in wanted {
            // Without it, a set is finished that could have been given up.
            let _ = flag::register(signal, &ASKED);
        }
    }
}

/// The signals that the parent process set to be ignored, as bits: `nohup` and shells do so for processes that are to outlive them. Empty
/// where the system does not report them.
#[cfg(unix)]
fn ignored_signals() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}

/// Ctrl-C and a closed window.
#[cfg(windows)]
fn install() {
    // Where they cannot be caught, they end the process at once, and the next build into the folder clears up.
    let _ = ctrlc::set_handler(|| {
        ASKED.store(true, Ordering::SeqCst);
        if spares_the_process(true) {
            return;
        }
        let _alive = say_goodbye();
        std::process::exit(130);
    });
}

/// Other systems end the process at once.
#[cfg(not(any(unix, windows)))]
fn install() {}
