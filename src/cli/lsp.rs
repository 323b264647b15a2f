//! `tweeze lsp`.

use super::library::Disk;
use super::{Exit, terminal};
use crate::lsp::{self, SessionEnd};
use lsp_server::Connection;
use std::io::IsTerminal;

/// Serves an editor on standard input and output until it ends.
pub fn run() -> Exit {
    if std::io::stdin().is_terminal() {
        terminal::to_stderr(
            "an editor starts this and writes to its standard input; `tweeze lsp --help` says how. Ctrl-C ends it\n",
        );
    }
    let (connection, threads) = Connection::stdio();
    let ended = lsp::serve(&connection, &|path, with| with(&Disk::round(path)));
    // The writer ends when nobody can send any more.
    drop(connection);
    let exit = match ended {
        Ok(SessionEnd::Agreed) => Exit::Done,
        // The protocol asks for 1.
        Ok(SessionEnd::Abrupt) => Exit::Errors,
        Err(why) => {
            terminal::to_stderr(&format!("tweeze lsp: {why}\n"));
            Exit::Errors
        }
    };
    match threads.join() {
        Ok(()) => exit,
        Err(_) => exit.max(Exit::Errors),
    }
}
