//! Background planning of saved programs for an editor. Each search runs in its own process, which is ended as soon as
//! its answer is no longer wanted and cannot crash the editor's server.

use crate::lsp::{PLANNED, PlanningResult, ProgramPlanner};
use lsp_server::{Message, Notification};
use std::collections::BTreeMap;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{self, Receiver, Sender};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// Time limit of a search for an editor, in seconds; `tweeze build` has no such limit.
const LIMIT_S: u64 = 60;

/// Interval at which a search is polled.
const PERIOD: Duration = Duration::from_millis(20);

/// Greatest number of bytes of an output that are read.
const MAX_OUTPUT_BYTES: u64 = 1 << 24;

/// The tickets whose answers are wanted, by program.
#[derive(Default)]
struct Wanted(Mutex<BTreeMap<PathBuf, u64>>);

impl Wanted {
    fn all(&self) -> MutexGuard<'_, BTreeMap<PathBuf, u64>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn is(&self, path: &Path, ticket: u64) -> bool {
        self.all().get(path) == Some(&ticket)
    }
}

/// Plans one program at a time.
pub struct BackgroundPlanner {
    wanted: Arc<Wanted>,
    /// `None` once the planner is being dropped.
    jobs: Option<Sender<(PathBuf, u64)>>,
    worker: Option<JoinHandle<()>>,
}

impl BackgroundPlanner {
    /// A planner that passes its results to `answer`.
    pub fn new(answer: impl Fn(Message) + Send + 'static) -> BackgroundPlanner {
        let wanted = Arc::new(Wanted::default());
        let (jobs, begun) = mpsc::channel();
        let shared = Arc::clone(&wanted);
        let worker = thread::spawn(move || work(&begun, &shared, &answer));
        BackgroundPlanner { wanted, jobs: Some(jobs), worker: Some(worker) }
    }
}

impl ProgramPlanner for BackgroundPlanner {
    fn start(&mut self, path: &Path, ticket: u64) {
        self.wanted.all().insert(path.to_owned(), ticket);
        if let Some(jobs) = &self.jobs {
            // Cannot fail, because the worker lives as long as the planner.
            let _ = jobs.send((path.to_owned(), ticket));
        }
    }

    fn stop(&mut self, path: &Path) {
        self.wanted.all().remove(path);
    }
}

impl Drop for BackgroundPlanner {
    fn drop(&mut self) {
        self.wanted.all().clear();
        self.jobs = None;
        if let Some(worker) = self.worker.take() {
            // A worker that panicked has nothing left to end.
            let _ = worker.join();
        }
    }
}

fn work(jobs: &Receiver<(PathBuf, u64)>, wanted: &Wanted, answer: &impl Fn(Message)) {
    for (path, ticket) in jobs {
        if !wanted.is(&path, ticket) {
            continue;
        }
        // If no process can be started, the editor shows only what the checker finds.
        if let Ok(Some(result)) = planned(&path, ticket, wanted) {
            answer(Message::Notification(Notification::new(PLANNED.to_owned(), result)));
        }
    }
}

/// Plans a program; `None` if the result is no longer wanted.
fn planned(path: &Path, ticket: u64, wanted: &Wanted) -> io::Result<Option<PlanningResult>> {
    let mut command = Command::new(std::env::current_exe()?);
    command.args(["check", "--plan", "--format", "json", "--"]).arg(path);
    let mut search = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
    let [report, findings] = [reader(search.stdout.take()), reader(search.stderr.take())];
    let begin = Instant::now();
    let limit_s = loop {
        if search.try_wait()?.is_some() {
            break None;
        }
        if begin.elapsed() > Duration::from_secs(LIMIT_S) {
            end(&mut search);
            break Some(LIMIT_S);
        }
        if !wanted.is(path, ticket) {
            end(&mut search);
            return Ok(None);
        }
        thread::sleep(PERIOD);
    };
    let [report, findings] = [report, findings].map(|reader| reader.join().unwrap_or_default());
    Ok(Some(PlanningResult { path: path.to_owned(), ticket, report, findings, limit_s }))
}

/// Kills a search and waits until it has ended.
fn end(search: &mut Child) {
    // It may have ended just now.
    let _ = search.kill();
    let _ = search.wait();
}

/// Reads an output of a process in a separate thread, so that neither pipe fills up.
fn reader(output: Option<impl Read + Send + 'static>) -> JoinHandle<String> {
    thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(output) = output {
            // After an error, what was read so far is used.
            let _ = output.take(MAX_OUTPUT_BYTES).read_to_end(&mut bytes);
        }
        String::from_utf8_lossy(&bytes).into_owned()
    })
}
