//! `tweeze lsp`.

use super::library::Disk;
use super::{Exit, terminal};
use crate::lsp::{self, SessionEnd};
use lsp_server::Connection;

/// Serves an editor on standard input and output until it ends.
pub fn run() -> Exit {
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
