//! `tweeze lsp`.

use super::background::BackgroundPlanner;
use super::library::Disk;
use super::{Exit, terminal};
use crate::lsp::{self, SessionEnd};
use lsp_server::{Connection, Message};
use std::io::{self, BufRead, IsTerminal, Read};
use std::sync::{Arc, OnceLock};
use std::thread;

/// Longest message that is read, in bytes; the largest program is a tenth of it.
const MAX_MESSAGE_BYTES: u64 = 1 << 28;

/// Longest line of a message's header, in bytes.
const MAX_HEADER_LINE_BYTES: u64 = 1 << 12;

/// Serves an editor on standard input and output until it ends.
pub fn run() -> Exit {
    if std::io::stdin().is_terminal() {
        terminal::to_stderr(
            "an editor starts this and writes to its standard input; `tweeze lsp --help` says how. Ctrl-C ends it\n",
        );
    }
    let (connection, Connection { sender, receiver }) = Connection::memory();
    // Known before the session learns that nothing more comes.
    let unreadable = Arc::new(OnceLock::new());
    let found = Arc::clone(&unreadable);
    // What the planner finds comes in by the same way as what the client says. It must not keep that way open once the client is gone.
    let client = Arc::new(sender);
    let session = Arc::downgrade(&client);
    let mut planner = BackgroundPlanner::new(move |message| {
        if let Some(session) = session.upgrade() {
            // The session has ended.
            let _ = session.send(message);
        }
    });
    thread::spawn(move || {
        let mut input = io::stdin().lock();
        let read = loop {
            match next(&mut input) {
                Ok(Some(message)) => match client.send(message) {
                    Ok(()) => {}
                    // The session has ended.
                    Err(_) => break Ok(()),
                },
                Ok(None) => break Ok(()),
                Err(why) => break Err(why),
            }
        };
        if let Err(why) = read {
            found.get_or_init(|| why.to_string());
        }
    });
    let writer = thread::spawn(move || {
        let mut output = io::stdout().lock();
        receiver.into_iter().try_for_each(|message| message.write(&mut output))
    });
    let ended = lsp::serve(&connection, &|path, with| with(&Disk::round(path)), &mut planner);
    drop(planner);
    // The writer ends when nobody can send any more. The reader may wait for a client that says nothing.
    drop(connection);
    let is_written = matches!(writer.join(), Ok(Ok(())));
    if ended == Ok(SessionEnd::Agreed) && is_written {
        return Exit::Done;
    }
    if let Some(why) = unreadable.get().or(ended.as_ref().err()) {
        terminal::to_stderr(&format!("tweeze lsp: {why}\n"));
    }
    // The protocol asks for 1 where the client did not ask for the end.
    Exit::Errors
}

/// The next message; `None` at the end. The length that its header gives is judged before there is room made for it.
fn next(input: &mut impl BufRead) -> io::Result<Option<Message>> {
    let mut message = Vec::new();
    let mut length = 0;
    loop {
        let start = message.len();
        input.take(MAX_HEADER_LINE_BYTES).read_until(b'\n', &mut message)?;
        let line = String::from_utf8_lossy(&message[start..]);
        let field = line.trim_end().split_once(':');
        if let Some((_, value)) = field.filter(|(name, _)| name.eq_ignore_ascii_case("Content-Length")) {
            let wrong = |_| {
                invalid(format!(
                    "a header with the length `{}`, which is no number of bytes",
                    terminal::name(value.trim())
                ))
            };
            length = value.trim().parse().map_err(wrong)?;
        }
        // The library refuses a header that is not well formed.
        if line.trim_end().is_empty() || field.is_none() {
            break;
        }
    }
    if length > MAX_MESSAGE_BYTES {
        return Err(invalid(format!("a message of {length} bytes; at most {MAX_MESSAGE_BYTES} are read")));
    }
    input.take(length).read_to_end(&mut message)?;
    Message::read(&mut message.as_slice())
}

fn invalid(why: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, why)
}
