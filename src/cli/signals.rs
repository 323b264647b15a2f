//! Signals that end the process: Ctrl-C, a closed terminal, a request to terminate. A build removes its staged files,
//! or finishes a commit that has begun; then the process dies of the signal. A controlled run stops its robots first.

use super::terminal;
use crate::plan::watch::SearchWatch;
use std::io::{self, IsTerminal};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, Once, PoisonError};
use std::time::Duration;

/// Whether the process has been asked to end.
static ASKED: AtomicBool = AtomicBool::new(false);

/// Whether the build's files are in place. Locked while a folder is changed; the code that ends the process waits for
/// the lock.
static FILES_IN_PLACE: Mutex<bool> = Mutex::new(false);

/// Longest wait for a signal handler to set its flag, in milliseconds.
const MAX_FLAG_POLLS: usize = 1000;

/// Work that the first signal ends instead of the process.
enum SignalTarget {
    /// A search; only Ctrl-C ends it.
    Search(Arc<SearchWatch>),
    /// A controlled run; any signal ends it.
    Run(Arc<AtomicBool>),
}

static SIGNAL_TARGET: Mutex<Option<SignalTarget>> = Mutex::new(None);

fn signal_target() -> MutexGuard<'static, Option<SignalTarget>> {
    // A thread that panicked has left a complete value.
    SIGNAL_TARGET.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Guard: while it lives, the first Ctrl-C ends a search with the best plan found.
pub struct KeepBestGuard(());

/// Directs the next Ctrl-C to the watched searches.
pub fn keep_best(search: &Arc<SearchWatch>) -> KeepBestGuard {
    *signal_target() = Some(SignalTarget::Search(Arc::clone(search)));
    KeepBestGuard(())
}

impl Drop for KeepBestGuard {
    fn drop(&mut self) {
        *signal_target() = None;
    }
}

/// Guard: while it lives, the first signal does not end the process; the owner stops the run and then ends.
pub struct RunStop(Arc<AtomicBool>);

/// Directs the next signal to the run, which polls [`RunStop::is_asked`].
pub fn stop_run_first() -> RunStop {
    let stop = Arc::<AtomicBool>::default();
    *signal_target() = Some(SignalTarget::Run(Arc::clone(&stop)));
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
        *signal_target() = None;
    }
}

/// Passes a signal to the work that it ends instead of the process, and returns whether there is such work: a search
/// then takes the best plan found, or the first one that it finds; a run stops.
fn target_takes_signal(is_ctrl_c: bool) -> bool {
    // Locked until the end, so that dropping `KeepBestGuard` or `RunStop` waits for it.
    let mut target = signal_target();
    let taken = target.take_if(|one| match one {
        SignalTarget::Search(_) => is_ctrl_c,
        SignalTarget::Run(_) => true,
    });
    let Some(taken) = taken else { return false };
    if let SignalTarget::Search(search) = &taken {
        search.accept_incumbent();
    }
    // Clear the flag before the owner of `KeepBestGuard` can go on to write, or the run can end. The handler that sets
    // the flag may not have run yet.
    for _ in 0..MAX_FLAG_POLLS {
        if ASKED.swap(false, Ordering::SeqCst) {
            break;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let line = if io::stderr().is_terminal() { "\n" } else { "" };
    match taken {
        SignalTarget::Search(_) => terminal::to_stderr(&format!(
            "{line}tweeze: continuing with the best plan found; press Ctrl-C again to stop without one\n"
        )),
        SignalTarget::Run(stop) => stop.store(true, Ordering::SeqCst),
    }
    true
}

/// Whether the process has been asked to end; true no later than the return of the signal handler.
pub fn is_asked() -> bool {
    ASKED.load(Ordering::SeqCst)
}

/// Keeps the process alive until dropped; the caller sets it to true once the files are in place.
pub fn changing_files() -> MutexGuard<'static, bool> {
    // A thread that panicked has left the folder as a kill would have.
    FILES_IN_PLACE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Waits for the process to end, after [`is_asked`] has become true.
pub fn wait_for_end() -> ! {
    loop {
        std::thread::park();
    }
}

/// Reports whether files were written, once no folder is being changed. The caller holds the guard until the process
/// ends, so that no other change begins.
fn report_interruption() -> MutexGuard<'static, bool> {
    let in_place = changing_files();
    let line = if io::stderr().is_terminal() { "\n" } else { "" };
    let written = if *in_place { "after its files were written" } else { "nothing was written" };
    terminal::to_stderr(&format!("{line}tweeze: interrupted, {written}\n"));
    in_place
}

/// Makes a write beyond the file size limit fail instead of ending the process.
pub fn outlive_limits() {
    #[cfg(unix)]
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::<AtomicBool>::default());
}

/// Makes signals that end the process wait for [`changing_files`] from now on; further calls have no effect.
pub fn catch() {
    static CAUGHT: Once = Once::new();
    CAUGHT.call_once(install);
}

/// Installs the handlers. If signals cannot be caught, they end the process at once and the next build into the folder
/// cleans up.
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
            if target_takes_signal(signal == SIGINT) {
                continue;
            }
            let _alive = report_interruption();
            // The parent process learns that a signal ended this one: a shell shows 128 plus the signal's number.
            let _ = low_level::emulate_default_handler(signal);
            std::process::exit(128 + signal);
        }
    };
    if std::thread::Builder::new().spawn(watch).is_ok() {
        for signal in wanted {
            // If this fails, a set of files is finished that could have been abandoned.
            let _ = flag::register(signal, &ASKED);
        }
    }
}

/// The signals that the parent process set to be ignored, as bits: `nohup` and shells do so for processes that should
/// outlive them. Empty on systems that do not report them.
#[cfg(unix)]
fn ignored_signals() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}

/// Installs the handler for Ctrl-C and a closed window.
#[cfg(windows)]
fn install() {
    // If this fails, they end the process at once and the next build into the folder cleans up.
    let _ = ctrlc::set_handler(|| {
        ASKED.store(true, Ordering::SeqCst);
        if target_takes_signal(true) {
            return;
        }
        let _alive = report_interruption();
        std::process::exit(130);
    });
}

/// Does nothing: on other systems signals end the process at once.
#[cfg(not(any(unix, windows)))]
fn install() {}
