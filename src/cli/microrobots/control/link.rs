//! Transport of lines: standard input and output, or one connection over a local socket.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpListener, ToSocketAddrs};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::{Duration, Instant};

/// The longest line that is read, in bytes.
const MAX_LINE_BYTES: u64 = 1024 * 1024;

/// Greatest number of lines that wait for the controller.
const WAITING_LINES: usize = 64;

/// A line of the input with its number, from 1.
pub struct Incoming {
    pub number: u64,
    /// The error is why it cannot be read: longer than [`MAX_LINE_BYTES`], or not UTF-8.
    pub line: Result<String, &'static str>,
}

/// Both directions of a connection.
pub struct Link {
    pub lines: Receiver<Incoming>,
    pub answers: Answers,
}

/// Interval at which signals are polled while no line comes, nobody connects, or nobody reads.
pub const INTERRUPT_POLL: Duration = Duration::from_millis(20);

/// Lines to the peer that carries out commands. A separate thread writes them, so that waiting for a reader can be
/// interrupted.
pub struct Answers {
    texts: SyncSender<String>,
    written: Receiver<bool>,
    /// Whether a line is still waiting for its reader; no other line can be sent then.
    is_stuck: bool,
}

/// Why a line was not sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SendError {
    /// The reader is gone, or did not read in time.
    Unread,
    Interrupted,
}

impl Answers {
    fn to(to: impl Write + Send + 'static) -> Answers {
        let ((texts, lines), (done, written)) = (sync_channel::<String>(1), sync_channel(1));
        std::thread::spawn(move || write(to, &lines, &done));
        Answers { texts, written, is_stuck: false }
    }

    /// Sends a line and waits until it is written, at most for a given time.
    ///
    /// # Errors
    /// The line was not written; later lines are refused too.
    pub fn send(&mut self, text: &str, within: Duration, is_interrupted: impl Fn() -> bool) -> Result<(), SendError> {
        if self.is_stuck || self.texts.send(text.to_owned()).is_err() {
            return Err(SendError::Unread);
        }
        let begun = Instant::now();
        loop {
            match self.written.recv_timeout(INTERRUPT_POLL) {
                Ok(true) => return Ok(()),
                Err(RecvTimeoutError::Timeout) if is_interrupted() => {
                    self.is_stuck = true;
                    return Err(SendError::Interrupted);
                }
                Err(RecvTimeoutError::Timeout) if begun.elapsed() < within => {}
                Ok(false) | Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => {
                    self.is_stuck = true;
                    return Err(SendError::Unread);
                }
            }
        }
    }
}

fn write(mut to: impl Write, lines: &Receiver<String>, done: &SyncSender<bool>) {
    for line in lines {
        let is_written = to.write_all(line.as_bytes()).and_then(|()| to.flush()).is_ok();
        if done.send(is_written).is_err() || !is_written {
            return;
        }
    }
}

/// Address to listen at.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Address {
    Tcp(SocketAddr),
    #[cfg(unix)]
    Unix(std::path::PathBuf),
}

impl Address {
    /// Parses `HOST:PORT` or `unix:PATH`.
    ///
    /// # Errors
    /// A message that says what is wrong; only addresses of this machine are allowed.
    pub fn parse(text: &str) -> Result<Address, String> {
        if let Some(path) = text.strip_prefix("unix:") {
            #[cfg(unix)]
            return match path {
                "" => Err("expected a path after `unix:`, such as `unix:/tmp/bed.sock`".to_owned()),
                path => Ok(Address::Unix(path.into())),
            };
            #[cfg(not(unix))]
            return Err(format!("`unix:{path}` works on Unix only; use HOST:PORT, such as 127.0.0.1:7000"));
        }
        let found =
            text.to_socket_addrs().map_err(|error| format!("{error}; use HOST:PORT, such as 127.0.0.1:7000"))?;
        let (own, others): (Vec<SocketAddr>, Vec<SocketAddr>) = found.partition(|address| address.ip().is_loopback());
        match (own.first(), others.first()) {
            (Some(address), None) => Ok(Address::Tcp(*address)),
            _ => Err("only addresses of this machine are allowed: use 127.0.0.1, [::1] or localhost".to_owned()),
        }
    }
}

/// Connection over standard input and output.
pub fn standard() -> Link {
    Link { lines: reader(io::stdin()), answers: Answers::to(io::stdout()) }
}

/// Checks whether an address can be listened at, before work is done for a connection that cannot be made.
///
/// # Errors
/// It cannot be listened at.
pub fn check(address: &Address) -> io::Result<()> {
    match address {
        Address::Tcp(address) => TcpListener::bind(address).map(drop),
        #[cfg(unix)]
        Address::Unix(path) => {
            std::os::unix::net::UnixListener::bind(path)?;
            std::fs::remove_file(path)
        }
    }
}

/// Waits for one connection; `ready` is called with the address once clients can connect. `None` if it was interrupted
/// first.
///
/// # Errors
/// The address cannot be listened at.
pub fn accepted(
    address: &Address,
    ready: impl FnOnce(&str),
    is_interrupted: impl Fn() -> bool,
) -> io::Result<Option<Link>> {
    match address {
        Address::Tcp(address) => {
            let listener = TcpListener::bind(address)?;
            listener.set_nonblocking(true)?;
            ready(&listener.local_addr()?.to_string());
            let Some((stream, _)) = first(|| listener.accept(), is_interrupted)? else { return Ok(None) };
            stream.set_nonblocking(false)?;
            stream.set_nodelay(true)?;
            Ok(Some(Link { lines: reader(stream.try_clone()?), answers: Answers::to(stream) }))
        }
        #[cfg(unix)]
        Address::Unix(path) => {
            let listener = std::os::unix::net::UnixListener::bind(path)?;
            listener.set_nonblocking(true)?;
            ready(&format!("unix:{}", path.display()));
            let accepted = first(|| listener.accept(), is_interrupted);
            // The name is needed only for connecting.
            let _ = std::fs::remove_file(path);
            let Some((stream, _)) = accepted? else { return Ok(None) };
            stream.set_nonblocking(false)?;
            Ok(Some(Link { lines: reader(stream.try_clone()?), answers: Answers::to(stream) }))
        }
    }
}

/// The first connection; `None` if it was interrupted first.
fn first<C>(accept: impl Fn() -> io::Result<C>, is_interrupted: impl Fn() -> bool) -> io::Result<Option<C>> {
    loop {
        match accept() {
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
            connection => return connection.map(Some),
        }
        if is_interrupted() {
            return Ok(None);
        }
        std::thread::sleep(INTERRUPT_POLL);
    }
}

/// Reads lines in a separate thread, so that waiting for one can be interrupted.
pub fn reader(from: impl Read + Send + 'static) -> Receiver<Incoming> {
    let (to, lines) = sync_channel(WAITING_LINES);
    std::thread::spawn(move || read(from, &to));
    lines
}

fn read(from: impl Read, to: &SyncSender<Incoming>) {
    let mut from = BufReader::new(from);
    for number in 1.. {
        let mut bytes = Vec::new();
        match (&mut from).take(MAX_LINE_BYTES).read_until(b'\n', &mut bytes) {
            Ok(0) | Err(_) => return,
            Ok(_) => {}
        }
        let is_whole = bytes.last() == Some(&b'\n') || (bytes.len() as u64) < MAX_LINE_BYTES;
        let line = match (is_whole, String::from_utf8(bytes)) {
            (false, _) => {
                if skip_line(&mut from).is_err() {
                    return;
                }
                Err("a line is longer than 1 MiB")
            }
            (true, Err(_)) => Err("a line is not UTF-8"),
            // Skipped: a stream of empty lines is silence, and the watchdog must notice it.
            (true, Ok(line)) if line.trim().is_empty() => continue,
            (true, Ok(line)) => Ok(line),
        };
        if to.send(Incoming { number, line }).is_err() {
            return;
        }
    }
}

/// Skips the rest of a line.
fn skip_line(from: &mut impl BufRead) -> io::Result<()> {
    loop {
        let buffer = from.fill_buf()?;
        let end = buffer.iter().position(|byte| *byte == b'\n');
        let (length, is_over) = end.map_or((buffer.len(), buffer.is_empty()), |end| (end + 1, true));
        from.consume(length);
        if is_over {
            return Ok(());
        }
    }
}
