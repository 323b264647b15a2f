//! Plans of saved programs for an editor: each is searched for in a process of its own, which ends as soon as its answer is not wanted any
//! more, and cannot take the editor's server with it.

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

/// How long a search goes on for an editor, in seconds; `tweeze build` has no such limit.
const LIMIT_S: u64 = 60;

/// Period in which a search is looked at.
const PERIOD: Duration = Duration::from_millis(20);

/// Most of an output that is read, in bytes.
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

/// Plans one program after the other.
pub struct BackgroundPlanner {
    wanted: Arc<Wanted>,
    /// `None` once it ends.
    jobs: Option<Sender<(PathBuf, u64)>>,
    worker: Option<JoinHandle<()>>,
}

impl BackgroundPlanner {
    /// A planner that hands over its answers by `answer`.
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
            // The worker ends with the planner alone.
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
        // Where no process can be started, an editor shows what the checker finds.
        if let Ok(Some(result)) = planned(&path, ticket, wanted) {
            answer(Message::Notification(Notification::new(PLANNED.to_owned(), result)));
        }
    }
}

/// What comes of planning a program; `None` if that is not wanted any more.
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

/// Ends a search, and waits until it has ended.
fn end(search: &mut Child) {
    // It may have ended just now.
    let _ = search.kill();
    let _ = search.wait();
}

/// Reads an output of a process beside the other one, so that neither is full.
fn reader(output: Option<impl Read + Send + 'static>) -> JoinHandle<String> {
    thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(output) = output {
            // What was read until then is what there is.
            let _ = output.take(MAX_OUTPUT_BYTES).read_to_end(&mut bytes);
        }
        String::from_utf8_lossy(&bytes).into_owned()
    })
}
