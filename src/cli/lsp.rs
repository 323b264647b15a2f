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
        // Locked for each message: what is refused is answered in between.
        receiver.into_iter().try_for_each(|message| message.write(&mut io::stdout().lock()))
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

/// A message of the right length that says nothing: the next one can be read all the same.
struct RefusedMessage {
    /// Of JSON-RPC: -32700 for what is no JSON, -32600 for what is no message.
    code: i32,
    why: String,
}

impl RefusedMessage {
    /// Answers it. Which request it was is not known.
    fn write(&self) -> io::Result<()> {
        let error = serde_json::json!({"code": self.code, "message": self.why});
        let text = serde_json::json!({"jsonrpc": "2.0", "id": null, "error": error}).to_string();
        let mut output = io::stdout().lock();
        write!(output, "Content-Length: {}\r\n\r\n{text}", text.len())?;
        output.flush()
    }
}

/// The next message; `None` at the end. The length that its header gives is judged before there is room made for it.
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
                    "a header with the length `{}`, which is no number of bytes",
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
        Ok(_) => RefusedMessage { code: -32600, why: "this is no request, answer or notification".to_owned() },
        Err(_) => RefusedMessage { code: -32700, why: format!("this is no JSON: {error}") },
    })))
}

fn invalid(why: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, why)
}
