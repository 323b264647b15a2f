//! Controller in another process, reached over a socket: `tweeze control` as a user runs it.

use crate::claims::microrobots::MicrorobotsOrder;
use crate::geometry::Pose;
use crate::plan::microrobots::control::{Command, ControlPhase, InTheWay, Pilot, Stop, StopReason, StrokeSegment};
use crate::schedule::control::{CommandLine, CommandWord, ControlLine, MeasuredLine, SegmentLine};
use crate::schedule::microrobots::RecordedPose;
use std::ffi::OsStr;
use std::io::{BufRead, BufReader, Write};
use std::net::{Shutdown, TcpStream};
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

/// Text before the address on standard error.
const LISTENING: &str = "listening at ";

/// Arguments of the controller.
pub struct RemoteTask<'a> {
    pub file: &'a Path,
    pub task: &'a str,
    pub settings: &'a [String],
    /// Path of the recording.
    pub record: Option<&'a Path>,
}

/// A running `tweeze control` with its connection.
pub struct RemotePilot<'a> {
    order: &'a MicrorobotsOrder,
    child: Child,
    answers: BufReader<TcpStream>,
    segments: Vec<StrokeSegment>,
    step: usize,
    phase: ControlPhase,
}

impl<'a> RemotePilot<'a> {
    /// Starts a controller and connects to it.
    ///
    /// # Errors
    /// A message that says what went wrong.
    pub fn start(order: &'a MicrorobotsOrder, task: &RemoteTask) -> Result<Self, String> {
        let own = std::env::current_exe().map_err(|error| format!("the path of tweeze is unknown: {error}"))?;
        let settings = task.settings.iter().flat_map(|setting| ["--set", setting]);
        let mut child = std::process::Command::new(own)
            .arg("control")
            .arg(task.file)
            .args(["--task", task.task, "--listen", "127.0.0.1:0"])
            .args(settings)
            .args(task.record.iter().flat_map(|path| [OsStr::new("--record"), path.as_os_str()]))
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|error| format!("the controller cannot be started: {error}"))?;
        match connected(&mut child) {
            Ok(answers) => {
                let phase = ControlPhase::Wait;
                Ok(RemotePilot { order, child, answers, segments: Vec::new(), step: 0, phase })
            }
            Err(why) => {
                end(&mut child);
                Err(why)
            }
        }
    }

    /// Measurement as a line of the protocol.
    fn line(&self, measured: &[Option<Pose>], now_ns: u64) -> String {
        let pose = |(robot, pose): (usize, &Option<Pose>)| {
            (self.order.robot(robot).name.clone(), pose.map(RecordedPose::from))
        };
        let robots = measured.iter().enumerate().map(pose).collect();
        let line = ControlLine::Measured(MeasuredLine { t_ns: now_ns, robots });
        // Keys are strings and numbers are finite, so serialisation cannot fail.
        format!("{}\n", line.written().unwrap_or_default())
    }

    fn asked(&mut self, line: &str) -> Option<CommandLine> {
        let mut answer = String::new();
        self.answers.get_mut().write_all(line.as_bytes()).ok()?;
        self.answers.read_line(&mut answer).ok().filter(|read| *read > 0)?;
        serde_json::from_str(&answer).ok()
    }

    /// Takes the segments of an answer; `None` if it names a state that the device does not have.
    fn take_segments(&mut self, segments: &[SegmentLine]) -> Option<()> {
        self.segments.clear();
        for SegmentLine { state, levels_v, strokes } in segments {
            let known = self.order.states.iter().position(|known| known.digits() == *state)?;
            self.segments.push(StrokeSegment { state: known, strokes: *strokes, sets_arms: !levels_v.is_empty() });
        }
        Some(())
    }
}

impl Pilot for RemotePilot<'_> {
    fn observe(&mut self, measured: &[Option<Pose>], now_ns: u64) -> Command<'_> {
        let line = self.line(measured, now_ns);
        let answer = self.asked(&line);
        let stopped =
            |reason, robot, in_the_way, step, phase| Command::Stop(Stop { reason, robot, in_the_way, step, phase });
        let Some(answer) = answer else { return stopped(StopReason::Silence, None, None, self.step, self.phase) };
        (self.step, self.phase) = (answer.step, answer.phase);
        let until_ns = answer.until_ns.unwrap_or(0);
        match answer.command {
            CommandWord::Drive if self.take_segments(answer.segments.as_deref().unwrap_or_default()).is_some() => {
                Command::Drive { segments: &self.segments, until_ns }
            }
            CommandWord::Rest => Command::Rest { until_ns },
            CommandWord::Continue => Command::Continue { until_ns },
            CommandWord::Finished => Command::Finished,
            CommandWord::Drive | CommandWord::Stop => {
                let is_blamed = |robot: &usize| answer.robot.as_ref() == Some(&self.order.robot(*robot).name);
                let robot = (0..self.order.robots.len()).find(is_blamed);
                let in_the_way = answer.in_the_way.and_then(|name| InTheWay::named(self.order, &name));
                stopped(answer.reason.unwrap_or(StopReason::Garbled), robot, in_the_way, self.step, self.phase)
            }
        }
    }

    fn step(&self) -> usize {
        self.step
    }

    fn phase(&self) -> ControlPhase {
        self.phase
    }
}

impl Drop for RemotePilot<'_> {
    fn drop(&mut self) {
        // Without its connection the controller ends on its own, with a complete recording.
        let _ = self.answers.get_ref().shutdown(Shutdown::Both);
        let begun = Instant::now();
        while matches!(self.child.try_wait(), Ok(None)) && begun.elapsed() < ENDING {
            std::thread::sleep(Duration::from_millis(2));
        }
        end(&mut self.child);
    }
}

/// Longest time that a controller may take to end its recording after the last measurement.
const ENDING: Duration = Duration::from_secs(5);

/// Kills a controller that has not ended on its own.
fn end(child: &mut Child) {
    // It may have ended already.
    let _ = child.kill();
    let _ = child.wait();
}

/// Connects to a controller and reads its greeting.
fn connected(child: &mut Child) -> Result<BufReader<TcpStream>, String> {
    let stderr = child.stderr.take().ok_or("the controller has no standard error")?;
    let mut stderr = BufReader::new(stderr);
    let mut before = String::new();
    let address = loop {
        let mut line = String::new();
        match stderr.read_line(&mut line) {
            Ok(0) | Err(_) => return Err(format!("the controller ended before it was listening:\n{before}")),
            Ok(_) => match line.split_once(LISTENING) {
                Some((_, address)) => break address.trim().to_owned(),
                None => before.push_str(&line),
            },
        }
    };
    // Drained, because a full pipe would block the controller.
    std::thread::spawn(move || std::io::copy(&mut stderr, &mut std::io::sink()));
    let failed = |error: std::io::Error| format!("the controller cannot be reached at {address}: {error}");
    let stream = TcpStream::connect(&address).map_err(failed)?;
    stream.set_nodelay(true).map_err(failed)?;
    let mut answers = BufReader::new(stream);
    answers.read_line(&mut String::new()).map_err(failed)?;
    Ok(answers)
}
