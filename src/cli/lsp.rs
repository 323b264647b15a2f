//! `tweeze lsp`.

use super::background::BackgroundPlanner;
use super::library::Disk;
use super::{Exit, terminal};
use crate::lsp::{self, SessionEnd};
use lsp_server::{Connection, Message};
use std::io::{self, BufRead, IsTerminal, Read, Write};
use std::sync::{Arc, OnceLock};
use std::thread;

/// Longest message that is read, in bytes; the largest program is a tenth of it.
const MAX_MESSAGE_BYTES: u64 = 1 << 28;

/// Longest line of a message's header, in bytes.
const MAX_HEADER_LINE_BYTES: u64 = 1 << 12;

/// Serves an editor on standard input and output until it ends the session.
pub fn run() -> Exit {
    if std::io::stdin().is_terminal() {
        terminal::to_stderr(
            "an editor starts this and writes to its standard input; see `tweeze lsp --help`. Ctrl-C ends it\n",
        );
    }
    let (connection, Connection { sender, receiver }) = Connection::memory();
    // Set before the channel closes, so that it is known when the session sees the end of the input.
    let unreadable = Arc::new(OnceLock::new());
    let found = Arc::clone(&unreadable);
    // The planner sends its results over the same channel as the client's messages. The planner must not keep the
    // channel open once the client is gone.
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
                Ok(Some(Ok(message))) => match client.send(message) {
                    Ok(()) => {}
                    // The session has ended.
                    Err(_) => break Ok(()),
                },
                Ok(Some(Err(refused))) => match refused.write() {
                    Ok(()) => {}
                    Err(why) => break Err(why),
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
        // Locked for each message only, because the reader answers refused messages in between.
        receiver.into_iter().try_for_each(|message| message.write(&mut io::stdout().lock()))
    });
    let ended = lsp::serve(&connection, &|path, with| with(&Disk::around(path)), &mut planner);
    drop(planner);
    // The writer ends when no sender is left. The reader is not joined, because it may wait for a silent client.
    drop(connection);
    let is_written = matches!(writer.join(), Ok(Ok(())));
    if ended == Ok(SessionEnd::Agreed) && is_written {
        return Exit::Done;
    }
    if let Some(why) = unreadable.get().or(ended.as_ref().err()) {
        terminal::to_stderr(&format!("tweeze lsp: {why}\n"));
    }
    // The protocol requires status 1 if the client did not ask for the shutdown.
    Exit::Errors
}

/// A message of the stated length that is not valid; the next message can still be read.
struct RefusedMessage {
    /// JSON-RPC error code: -32700 for invalid JSON, -32600 for JSON that is not a message.
    code: i32,
    why: String,
}

impl RefusedMessage {
    /// Sends the error response; the id of the request is unknown.
    fn write(&self) -> io::Result<()> {
        let error = serde_json::json!({"code": self.code, "message": self.why});
        let text = serde_json::json!({"jsonrpc": "2.0", "id": null, "error": error}).to_string();
        let mut output = io::stdout().lock();
        write!(output, "Content-Length: {}\r\n\r\n{text}", text.len())?;
        output.flush()
    }
}

/// Reads the next message; `None` at the end of the input. The length in the header is checked before memory is
/// allocated.
fn next(input: &mut impl BufRead) -> io::Result<Option<Result<Message, RefusedMessage>>> {
    let mut length = None;
    loop {
        let mut line = Vec::new();
        input.take(MAX_HEADER_LINE_BYTES).read_until(b'\n', &mut line)?;
        if line.is_empty() {
            return Ok(None);
        }
        let line = String::from_utf8_lossy(&line);
        if line.trim_end().is_empty() {
            break;
        }
        let Some((name, value)) = line.trim_end().split_once(':') else {
            return Err(invalid(format!(
                "a header with the line `{}`, which has no colon",
                terminal::name(line.trim_end())
            )));
        };
        if name.eq_ignore_ascii_case("Content-Length") {
            let wrong = |_| {
                invalid(format!(
                    "a header with the length `{}`, which is not a number of bytes",
                    terminal::name(value.trim())
                ))
            };
            length = Some(value.trim().parse().map_err(wrong)?);
        }
    }
    let length: u64 = length.ok_or_else(|| invalid("a header without `Content-Length`".to_owned()))?;
    if length > MAX_MESSAGE_BYTES {
        return Err(invalid(format!("a message of {length} bytes; at most {MAX_MESSAGE_BYTES} are read")));
    }
    let mut body = Vec::new();
    input.take(length).read_to_end(&mut body)?;
    if (body.len() as u64) < length {
        return Err(invalid(format!("a message ends after {} of its {length} bytes", body.len())));
    }
    Ok(Some(serde_json::from_slice(&body).map_err(|error| match serde_json::from_slice::<serde_json::Value>(&body) {
        Ok(_) => RefusedMessage { code: -32600, why: "this is not a request, a response or a notification".to_owned() },
        Err(_) => RefusedMessage { code: -32700, why: format!("this is not JSON: {error}") },
    })))
}

fn invalid(why: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, why)
}
