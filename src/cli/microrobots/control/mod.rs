//! `tweeze control`: drives robots to their goals from measured poses; each line of measurements is answered with a
//! command.

mod link;
mod protocol;

use crate::check::Options;
use crate::claims::Claims;
use crate::claims::microrobots::MicrorobotsOrder;
use crate::cli::arguments::{ControlArguments, ReportFormat};
use crate::cli::loaded::Loaded;
use crate::cli::signals::{self, RunStop};
use crate::cli::waiting::ProgressLine;
use crate::cli::{Exit, build, errors, terminal};
use crate::compile::{self, CompileOutcome};
use crate::diagnostic::Sink;
use crate::emit::Provenance;
use crate::emit::mcap::recording::{RecordedLine, Recorder};
use crate::lower::microrobots::command::{command_line, stopped};
use crate::plan::Motion;
use crate::plan::microrobots::MicrorobotsMotion;
use crate::plan::microrobots::control::{Command, Controller, StopReason};
use crate::plan::watch::SearchWatch;
use crate::source::Sources;
pub use link::Address;
use link::{Answers, INTERRUPT_POLL, Incoming, Link, SendError};
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

/// Greatest number of consecutive lines that may be invalid.
const MAX_GARBLED: u32 = 5;

/// Plans and verifies the program, then controls its task until it is finished or given up.
pub fn run(arguments: &ControlArguments) -> Exit {
    let options = Options { settings: arguments.settings.set.clone(), only: arguments.task.clone() };
    let loaded = match Loaded::read(&arguments.file, options, &arguments.report) {
        Ok(loaded) => loaded,
        Err(exit) => return exit,
    };
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let checked = compile::check_program(&loaded.program(&loaded.disk()), &mut sources, &mut sink);
    let claims = checked.map(|checked| checked.claims);
    let claims = match claims.as_deref() {
        None => {
            terminal::report(&sink, &sources, arguments.report.format);
            return Exit::Errors;
        }
        Some([one]) => one,
        Some(all) => {
            terminal::report(&sink, &sources, arguments.report.format);
            return not_one(&loaded.shown(), all);
        }
    };
    let order = match controlled_bed(claims) {
        Ok(order) => order,
        Err(why) => return refused(&why),
    };
    if let Some(address) = &arguments.listen
        && let Err(error) = link::check(address)
    {
        return not_listening(address, &error);
    }
    let search = Arc::<SearchWatch>::default();
    let waiting = ProgressLine::begin(&search);
    let progress = &mut |index, count, task: &str| waiting.at(index, count, task);
    let built = search.over(|| compile::verified_plans(claims, &sources, &mut sink, progress));
    drop(waiting);
    terminal::report(&sink, &sources, arguments.report.format);
    let plans = match built {
        Ok(built) => built.plans,
        Err(CompileOutcome::Refused) => return Exit::Refused,
        Err(CompileOutcome::Errors | CompileOutcome::Compiled(_)) => return Exit::Errors,
    };
    let Some(Motion::Microrobots(planned)) = plans.first().map(|plan| &plan.motion) else {
        return refused(&no_bed(&claims.name));
    };
    let lines = order.steps.iter().map(|step| sources.position(step.span).line).collect();
    let provenance = build::provenance(&sources, &loaded.options);
    serve(arguments, claims, &provenance, order, &planned.motion, lines)
}

/// The order of a task that can be controlled: a single run on one bed that waits for nothing else; otherwise the
/// reason why there is none.
pub(super) fn controlled_bed(claims: &Claims) -> Result<&MicrorobotsOrder, String> {
    let name = &claims.name;
    let [job] = claims.jobs.as_slice() else { return Err(no_bed(name)) };
    let order = MicrorobotsOrder::of(&job.order).filter(|order| order.facts.errors.is_some());
    let order = order.ok_or_else(|| no_bed(name))?;
    match job.holds.is_empty() {
        true => Ok(order),
        false => Err(format!(
            "`{name}` cannot be controlled: it waits for an input or a person, which `control` does not support"
        )),
    }
}

fn no_bed(name: &str) -> String {
    format!(
        "`{name}` cannot be controlled: this needs one run of one task on a bed of microrobots with all error bounds; `--task NAME` chooses a task"
    )
}

/// Reports why a program cannot be controlled.
pub(super) fn refused(why: &str) -> Exit {
    terminal::to_stderr(&format!("tweeze: {why}\n"));
    Exit::Usage
}

fn not_one(shown: &str, all: &[Claims]) -> Exit {
    let names: Vec<&str> = all.iter().map(|claims| claims.name.as_str()).collect();
    terminal::to_stderr(&match names.is_empty() {
        true => format!("tweeze: {shown} has no task to control\n"),
        false => format!("tweeze: {shown} has several tasks; choose one with `--task`: {}\n", names.join(", ")),
    });
    Exit::Usage
}

fn not_listening(address: &Address, error: &std::io::Error) -> Exit {
    let left = match address {
        #[cfg(unix)]
        Address::Unix(path) if error.kind() == std::io::ErrorKind::AddrInUse => {
            // A test connection would be accepted in place of the peer that the other process waits for.
            format!("; delete `{}` if a killed process left it behind", path.display())
        }
        #[cfg(unix)]
        Address::Unix(_) => String::new(),
        Address::Tcp(_) => String::new(),
    };
    terminal::to_stderr(&format!("tweeze: cannot listen there: {error}{left}\n"));
    Exit::Files
}

/// Connects and runs the control loop.
fn serve(
    arguments: &ControlArguments,
    claims: &Claims,
    provenance: &Provenance,
    order: &MicrorobotsOrder,
    motion: &MicrorobotsMotion,
    lines: Vec<u32>,
) -> Exit {
    let Some(controller) = Controller::new(order, motion) else { return refused(&no_bed(&claims.name)) };
    if let Some(beyond) = controller.beyond_precision() {
        terminal::to_stderr(&beyond_precision(beyond));
    }
    let recorder = match arguments.record.as_deref().map(|path| recorder(path, claims, provenance)).transpose() {
        Ok(recorder) => recorder,
        Err(diagnostic) => {
            terminal::report_one(*diagnostic, arguments.report.format);
            return Exit::Files;
        }
    };
    signals::catch();
    let interrupt = signals::stop_run_first();
    let link = match connected(arguments.listen.as_ref(), &interrupt) {
        Ok(link) => link,
        Err(exit) => {
            drop(recorder);
            // Nothing was exchanged, so the file that was begun is not a recording.
            arguments.record.iter().for_each(|path| drop(std::fs::remove_file(path)));
            return exit;
        }
    };
    let (answers, incoming) = (link.answers, link.lines);
    let (record_path, is_unrecorded) = (arguments.record.as_deref(), false);
    let (t_ns, late, garbled) = (0, None, 0);
    let report = arguments.report.format;
    let mut session = Session {
        order,
        controller,
        lines,
        recorder,
        record_path,
        is_unrecorded,
        report,
        answers,
        interrupt,
        t_ns,
        late,
        garbled,
    };
    let greeted = session.greet(&claims.name);
    let exit = greeted.and_then(|()| session.control(&incoming)).unwrap_or_else(|reason| session.give_up(reason));
    session.finish_recording();
    if session.is_unrecorded { Exit::Files } else { exit }
}

/// Connects to the peer that measures and carries out commands.
fn connected(listen: Option<&Address>, interrupt: &RunStop) -> Result<Link, Exit> {
    let Some(address) = listen else { return Ok(link::standard()) };
    let ready = |at: &str| terminal::to_stderr(&format!("tweeze: listening at {at}\n"));
    match link::accepted(address, ready, || interrupt.is_asked()) {
        Ok(Some(link)) => Ok(link),
        Ok(None) => {
            terminal::to_stderr("tweeze: interrupted before a connection was made\n");
            Err(Exit::Stopped)
        }
        Err(error) => Err(not_listening(address, &error)),
    }
}

/// Message for a task whose precision is finer than its drives can reach: the tolerances that `verify` needs.
fn beyond_precision([place_um, heading_rad]: [f64; 2]) -> String {
    let (place, heading) = (place_um.ceil(), heading_rad.to_degrees().ceil());
    let granted = [("--goal-tolerance", place, "um"), ("--heading-tolerance", heading, "deg")].into_iter();
    let granted = granted.filter(|(_, more, _)| *more > 0.0);
    let granted: Vec<String> = granted.map(|(name, more, unit)| format!("{name} {more}{unit}")).collect();
    format!(
        "tweeze: in closed loop, drives end up to {place} um and {heading} deg beyond the `precision` of the task: set a `precision` that allows this, or verify the recording with `{}`\n",
        granted.join(" ")
    )
}

fn recorder(
    path: &Path,
    claims: &Claims,
    provenance: &Provenance,
) -> Result<Recorder<BufWriter<File>>, Box<crate::diagnostic::Diagnostic>> {
    let file = File::create_new(path).map_err(|error| Box::new(errors::not_recorded(path, &error)))?;
    Recorder::begin(BufWriter::new(file), claims, provenance).map_err(|error| {
        let _ = std::fs::remove_file(path);
        Box::new(error.diagnostic())
    })
}

/// A controller with its connection.
struct Session<'a> {
    order: &'a MicrorobotsOrder,
    controller: Controller<'a>,
    lines: Vec<u32>,
    recorder: Option<Recorder<BufWriter<File>>>,
    record_path: Option<&'a Path>,
    /// Whether writing the recording has failed; the failure was reported.
    is_unrecorded: bool,
    report: ReportFormat,
    answers: Answers,
    interrupt: RunStop,
    /// Time of the last measurement.
    t_ns: u64,
    /// When the watchdog ends the task, by this machine's clock; `None` before the first measurement, when the robots
    /// are at rest. Only a new command moves it, because a camera whose clock has stopped sends measurements for ever.
    late: Option<Instant>,
    /// Number of consecutive invalid lines.
    garbled: u32,
}

impl Session<'_> {
    fn greet(&mut self, task: &str) -> Result<(), StopReason> {
        self.answer(&protocol::greeting(self.order, task))
    }

    /// Answers lines until the task is over. The error is the reason to give it up.
    fn control(&mut self, incoming: &Receiver<Incoming>) -> Result<Exit, StopReason> {
        loop {
            match self.next(incoming)? {
                Incoming { number, line: Ok(line) } => {
                    if let Some(exit) = self.take(number, &line)? {
                        return Ok(exit);
                    }
                }
                Incoming { number, line: Err(why) } => self.refuse(number, why)?,
            }
        }
    }

    /// The next line, or the reason to wait no longer.
    fn next(&self, incoming: &Receiver<Incoming>) -> Result<Incoming, StopReason> {
        loop {
            let left = self.late.map_or(INTERRUPT_POLL, |late| late.saturating_duration_since(Instant::now()));
            match incoming.recv_timeout(left.min(INTERRUPT_POLL)) {
                _ if self.interrupt.is_asked() => return Err(StopReason::Interrupted),
                Ok(incoming) => return Ok(incoming),
                Err(RecvTimeoutError::Timeout) if self.is_late() => return Err(StopReason::Silence),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Err(StopReason::Closed),
            }
        }
    }

    /// Whether the watchdog's time is up.
    fn is_late(&self) -> bool {
        self.late.is_some_and(|late| late <= Instant::now())
    }

    /// Handles a line of measured poses; returns the exit status if the task is over.
    fn take(&mut self, number: u64, line: &str) -> Result<Option<Exit>, StopReason> {
        let measured = match protocol::measured(self.order, line) {
            Ok(measured) => measured,
            Err(why) => return self.refuse(number, &why).map(|()| None),
        };
        self.garbled = 0;
        self.record(RecordedLine::Measured, measured.t_ns.max(self.t_ns), line.trim_end())?;
        let is_late = self.is_late();
        let command = self.controller.observe(&measured.poses, measured.t_ns);
        let over = match command {
            Command::Drive { until_ns, .. } | Command::Rest { until_ns } => {
                let left_ns = until_ns.saturating_sub(measured.t_ns).saturating_add(self.order.facts.watchdog_ns());
                self.late = Instant::now().checked_add(Duration::from_nanos(left_ns));
                None
            }
            Command::Continue { .. } if is_late => return Err(StopReason::Silence),
            Command::Continue { .. } => None,
            Command::Finished => Some(Exit::Done),
            Command::Stop(_) => Some(Exit::Stopped),
        };
        self.t_ns = self.t_ns.max(measured.t_ns);
        self.command()?;
        self.say_why();
        Ok(over)
    }

    /// Refuses a line. The error is that there were too many in a row.
    fn refuse(&mut self, number: u64, why: &str) -> Result<(), StopReason> {
        self.garbled += 1;
        self.answer(&protocol::error(number, why))?;
        if self.garbled > MAX_GARBLED { Err(StopReason::Garbled) } else { Ok(()) }
    }

    /// Gives the task up, unless it is over. The peer may be gone and the disk full; the command is still recorded and
    /// sent as far as possible.
    fn give_up(&mut self, reason: StopReason) -> Exit {
        self.controller.stop(reason, None);
        let line = self.command_line();
        let _ = self.record(RecordedLine::Command, self.t_ns, line.trim_end());
        let _ = self.answer(&line);
        self.say_why();
        Exit::Stopped
    }

    /// Reports on standard error why the task was given up, if it was.
    fn say_why(&self) {
        if let Command::Stop(stop) = self.controller.last() {
            terminal::to_stderr(&format!("tweeze: stopped: {}\n", stopped(self.order, stop)));
        }
    }

    /// Sends the controller's last command.
    fn command(&mut self) -> Result<(), StopReason> {
        let line = self.command_line();
        self.record(RecordedLine::Command, self.t_ns, line.trim_end())?;
        self.answer(&line)
    }

    fn command_line(&self) -> String {
        protocol::written(&command_line(self.order, &self.lines, &self.controller, self.t_ns))
    }

    fn answer(&mut self, text: &str) -> Result<(), StopReason> {
        let within = Duration::from_nanos(self.order.facts.watchdog_ns());
        self.answers.send(text, within, || self.interrupt.is_asked()).map_err(|why| match why {
            SendError::Unread => StopReason::Unread,
            SendError::Interrupted => StopReason::Interrupted,
        })
    }

    fn record(&mut self, line: RecordedLine, t_ns: u64, json: &str) -> Result<(), StopReason> {
        let Some(recorder) = &mut self.recorder else { return Ok(()) };
        let added = recorder.add(line, t_ns, json);
        self.recorded(added)
    }

    fn finish_recording(&mut self) {
        let finished = self.recorder.take().map_or(Ok(()), Recorder::finish);
        let _ = self.recorded(finished);
    }

    /// Reports a failure to write the recording, once; nothing more is added to it.
    fn recorded(&mut self, written: std::io::Result<()>) -> Result<(), StopReason> {
        let Err(error) = written else { return Ok(()) };
        self.recorder = None;
        self.is_unrecorded = true;
        let path = self.record_path.unwrap_or(Path::new(""));
        terminal::report_one(errors::not_recorded_on(path, &error), self.report);
        Err(StopReason::Unrecorded)
    }
}
