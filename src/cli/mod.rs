//! Command line: the only module that touches files, the clock and the terminal.

mod arguments;
mod background;
mod build;
mod check;
mod devices;
mod difference;
mod disk;
mod errors;
mod explain;
mod failed;
mod file_snapshots;
mod fmt;
mod formats;
mod library;
mod loaded;
mod lsp;
mod microrobots;
mod new;
mod report;
mod signals;
mod terminal;
mod verify;
mod view;
mod waiting;
mod watch;

use arguments::{Command, Invocation};
use clap::{CommandFactory, Parser};
use microrobots::{Address, judge_recording, run_control, run_simulate};
use std::ffi::OsString;
use std::process::ExitCode;

/// Exit status of a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Exit {
    Done = 0,
    /// The program has errors.
    Errors = 1,
    /// Wrong usage.
    Usage = 2,
    /// Verification refused a schedule.
    Refused = 3,
    /// A file could not be read or written.
    Files = 4,
    /// Tweeze itself failed.
    Fault = 5,
    /// A controlled task was given up.
    Stopped = 6,
}

/// Stack of the working thread, in bytes: several times what the deepest accepted nesting needs.
const STACK_BYTES: usize = 64 * 1024 * 1024;

/// Runs a command line and returns its exit status.
pub fn run(arguments: impl Iterator<Item = OsString>) -> ExitCode {
    let invocation = match Invocation::try_parse_from(arguments) {
        Ok(invocation) => invocation,
        Err(error) => {
            // Help and version are answers; everything else is wrong usage. A closed pipe is ignored.
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { Exit::Usage as u8 } else { Exit::Done as u8 });
        }
    };
    terminal::choose_colour(invocation.color);
    signals::outlive_limits();
    let worker = std::thread::Builder::new().stack_size(STACK_BYTES).spawn(move || dispatch(invocation.command));
    let exit = match worker.map(std::thread::JoinHandle::join) {
        Ok(Ok(exit)) => exit,
        Ok(Err(_)) => terminal::fault("internal error, described above"),
        Err(error) => terminal::fault(&format!("no thread could be started: {error}")),
    };
    if signals::is_asked() {
        signals::wait_for_end();
    }
    ExitCode::from(exit as u8)
}

fn dispatch(command: Command) -> Exit {
    match command {
        Command::Check(arguments) => check::run(&arguments),
        Command::Build(arguments) => build::run(&arguments),
        Command::Verify(arguments) => verify::run(&arguments),
        Command::View(arguments) => view::run(&arguments),
        Command::New(arguments) => new::run(&arguments),
        Command::Explain(arguments) => explain::run(&arguments),
        Command::Fmt(arguments) => fmt::run(&arguments),
        Command::Lsp(_) => lsp::run(),
        Command::Simulate(arguments) => run_simulate(&arguments),
        Command::Control(arguments) => run_control(&arguments),
        Command::Devices(arguments) => devices::run(&arguments),
        Command::Completions(arguments) => {
            let mut script = Vec::new();
            clap_complete::generate(arguments.shell, &mut Invocation::command(), "tweeze", &mut script);
            terminal::answer(&String::from_utf8_lossy(&script))
        }
    }
}
