//! `tweeze control`: brings robots to their goals by measured poses, which come as lines, and answers each with a command.

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
use link::Incoming;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

/// So many lines in a row may be no measurements.
const MAX_GARBLED: u32 = 5;

/// How often a signal is looked for while no line comes.
const INTERRUPT_LOOK: Duration = Duration::from_millis(20);

/// Builds and verifies the program, then controls its task until it is done or given up.
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
    if let Some(Err(error)) = arguments.listen.as_ref().map(link::check) {
        return not_listening(&error);
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
    serve(arguments, (claims, &provenance), (order, &planned.motion), lines)
}

/// The order of a task that can be controlled: one run of one bed, without a wait for anything else; or why there is none.
pub(super) fn controlled_bed(claims: &Claims) -> Result<&MicrorobotsOrder, String> {
    let name = &claims.name;
    let [job] = claims.jobs.as_slice() else { return Err(no_bed(name)) };
    let order = MicrorobotsOrder::of(&job.order).filter(|order| order.facts.errors.is_some());
    let order = order.ok_or_else(|| no_bed(name))?;
    match job.holds.is_empty() {
        true => Ok(order),
        false => {
            Err(format!("`{name}` cannot be controlled: it waits for an input or a person, which `control` does not"))
        }
    }
}

fn no_bed(name: &str) -> String {
    format!(
        "`{name}` cannot be controlled: that takes one run of one task on a bed of microrobots with all error bounds; `--task NAME` chooses a task"
    )
}

/// Says why a program is not controlled.
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

fn not_listening(error: &std::io::Error) -> Exit {
    terminal::to_stderr(&format!("tweeze: cannot listen there: {error}\n"));
    Exit::Files
}

/// Connects and controls.
fn serve(
    arguments: &ControlArguments,
    (claims, provenance): (&Claims, &Provenance),
    (order, motion): (&MicrorobotsOrder, &MicrorobotsMotion),
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
    let link = match &arguments.listen {
        None => link::standard(),
        Some(address) => {
            let ready = |at: &str| terminal::to_stderr(&format!("tweeze: listening at {at}\n"));
            match link::accepted(address, ready) {
                Ok(link) => link,
                Err(error) => return not_listening(&error),
            }
        }
    };
    signals::catch();
    let interrupt = signals::stop_run_first();
    let (answers, incoming) = (link.answers, link.lines);
    let mut session =
        Session { order, controller, lines, recorder, answers, interrupt, t_ns: 0, until_ns: None, garbled: 0 };
    let exit = session.greet(&claims.name).and_then(|()| session.control(&incoming)).unwrap_or_else(|exit| exit);
    match session.recorder.take().map(Recorder::finish) {
        None | Some(Ok(())) => exit,
        Some(Err(error)) => {
            terminal::report_one(error.diagnostic(), arguments.report.format);
            Exit::Files
        }
    }
}

/// What must be granted to the drives of a task whose precision is finer than they can be brought to.
fn beyond_precision([place_um, heading_rad]: [f64; 2]) -> String {
    let (place, heading) = (place_um.ceil(), heading_rad.to_degrees().ceil());
    let granted = [("--goal-tolerance", place, "um"), ("--heading-tolerance", heading, "deg")].into_iter();
    let granted = granted.filter(|(_, more, _)| *more > 0.0);
    let granted: Vec<String> = granted.map(|(name, more, unit)| format!("{name} {more}{unit}")).collect();
    format!(
        "tweeze: in closed loop drives end up to {place} um and {heading} deg beyond the `precision` of the task: state one that you need, or \
         verify the recording with `{}`\n",
        granted.join(" ")
    )
}

fn recorder(
    path: &Path,
    claims: &Claims,
    provenance: &Provenance,
) -> Result<Recorder<BufWriter<File>>, Box<crate::diagnostic::Diagnostic>> {
    let file = File::create_new(path).map_err(|error| Box::new(errors::not_recorded(path, &error)))?;
    Recorder::begin(BufWriter::new(file), claims, provenance).map_err(|error| Box::new(error.diagnostic()))
}

/// A controller with its connection.
struct Session<'a> {
    order: &'a MicrorobotsOrder,
    controller: Controller<'a>,
    lines: Vec<u32>,
    recorder: Option<Recorder<BufWriter<File>>>,
    answers: Box<dyn Write>,
    interrupt: RunStop,
    /// Time of the last measurement.
    t_ns: u64,
    /// When the last command ends; `None` before the first measurement.
    until_ns: Option<u64>,
    /// Lines in a row that were no measurements.
    garbled: u32,
}

impl Session<'_> {
    fn greet(&mut self, task: &str) -> Result<(), Exit> {
        self.answer(&protocol::greeting(self.order, task))
    }

    /// Answers lines until the task is over. The error is the exit of a connection that failed.
    fn control(&mut self, incoming: &Receiver<Incoming>) -> Result<Exit, Exit> {
        loop {
            let over = match self.next(incoming) {
                Ok(Incoming { number, line: Ok(line) }) => self.take(number, &line)?,
                Ok(Incoming { number, line: Err(why) }) => self.refuse(number, why)?,
                Err(reason) => self.stop(reason)?,
            };
            if let Some(exit) = over {
                return Ok(exit);
            }
        }
    }

    /// The next line, or why none is waited for any more.
    fn next(&self, incoming: &Receiver<Incoming>) -> Result<Incoming, StopReason> {
        // The robots rest before the first measurement: nothing is late.
        let late = self.until_ns.and_then(|until_ns| {
            let left_ns = until_ns.saturating_sub(self.t_ns).saturating_add(self.order.facts.watchdog_ns());
            Instant::now().checked_add(Duration::from_nanos(left_ns))
        });
        loop {
            let left = late.map_or(INTERRUPT_LOOK, |late| late.saturating_duration_since(Instant::now()));
            match incoming.recv_timeout(left.min(INTERRUPT_LOOK)) {
                _ if self.interrupt.is_asked() => return Err(StopReason::Interrupted),
                Ok(incoming) => return Ok(incoming),
                Err(RecvTimeoutError::Timeout) if left > INTERRUPT_LOOK || late.is_none() => {}
                Err(RecvTimeoutError::Timeout) => return Err(StopReason::Silence),
                Err(RecvTimeoutError::Disconnected) => return Err(StopReason::Closed),
            }
        }
    }

    /// A line of measured poses; the exit if the task is over.
    fn take(&mut self, number: u64, line: &str) -> Result<Option<Exit>, Exit> {
        let measured = match protocol::measured(self.order, line) {
            Ok(measured) => measured,
            Err(why) => return self.refuse(number, &why),
        };
        self.garbled = 0;
        self.record(RecordedLine::Measured, measured.t_ns.max(self.t_ns), line.trim_end())?;
        let command = self.controller.observe(&measured.poses, measured.t_ns);
        let over = match command {
            Command::Drive { until_ns, .. } | Command::Rest { until_ns } | Command::Continue { until_ns } => {
                self.until_ns = Some(until_ns);
                None
            }
            Command::Finished => Some(Exit::Done),
            Command::Stop(_) => Some(Exit::Stopped),
        };
        self.t_ns = self.t_ns.max(measured.t_ns);
        self.command()?;
        self.say_why();
        Ok(over)
    }

    /// Refuses a line; the exit if there were too many of them in a row.
    fn refuse(&mut self, number: u64, why: &str) -> Result<Option<Exit>, Exit> {
        self.garbled += 1;
        self.answer(&protocol::error(number, why))?;
        if self.garbled > MAX_GARBLED { self.stop(StopReason::Garbled) } else { Ok(None) }
    }

    fn stop(&mut self, reason: StopReason) -> Result<Option<Exit>, Exit> {
        self.controller.stop(reason, None);
        // Whoever measures may have gone; the recording has the command all the same.
        let sent = self.command();
        self.say_why();
        sent.map(|()| Some(Exit::Stopped)).or(Ok(Some(Exit::Stopped)))
    }

    /// Says at the terminal why the task was given up, if it was.
    fn say_why(&self) {
        if let Command::Stop(stop) = self.controller.last() {
            terminal::to_stderr(&format!("tweeze: stopped: {}\n", stopped(self.order, stop)));
        }
    }

    /// Answers with the controller's last command.
    fn command(&mut self) -> Result<(), Exit> {
        let line = command_line(self.order, &self.lines, &self.controller, self.t_ns);
        let text = protocol::written(&line);
        self.record(RecordedLine::Command, self.t_ns, text.trim_end())?;
        self.answer(&text)
    }

    fn answer(&mut self, text: &str) -> Result<(), Exit> {
        // A reader that has gone ends the control: nobody would carry the commands out.
        self.answers.write_all(text.as_bytes()).and_then(|()| self.answers.flush()).map_err(|_| Exit::Stopped)
    }

    fn record(&mut self, line: RecordedLine, t_ns: u64, json: &str) -> Result<(), Exit> {
        let Some(recorder) = &mut self.recorder else { return Ok(()) };
        recorder.add(line, t_ns, json).map_err(|error| {
            terminal::report_one(error.diagnostic(), ReportFormat::Human);
            Exit::Files
        })
    }
}
