//! Judges a recorded run of a controller: its commands against the device and the task, its measurements against
//! commands and goals.
//!
//! Input: the lines of the exchange in order, and the claims of the program. Output: a [`RecordedRun`], or the
//! violations by time. Promise: no code of the controller is used. Arm positions come from the levels of the voltage,
//! paths from strokes, and the allowed deviation of a robot from its path from the bounds on the device's errors. The
//! walk ends at the first line after which the state is unknown. Cost: for each measurement its robots, and the pairs
//! and obstacles near one another. Its tests are `tests/microrobots/recorded.rs`.

mod commanded;
mod goals;
mod measured;

use super::super::rule::{Findings, Rule, Violation, ms};
use super::{ReplayStop, RobotPlace, claims};
use crate::claims::microrobots::MicrorobotsOrder;
use crate::claims::{Claims, Job};
use crate::device::microrobots::Errors;
use crate::device::microrobots::control::StopReason;
use crate::schedule::control::{CommandLine, CommandWord, ControlLine, MeasuredLine};
use crate::source::{Sources, Span};
use commanded::Commanded;
use measured::{Seen, Tracked};

/// Allowances beyond the limits of the program and the errors of its device.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Tolerances {
    /// Distance of a measured position from where the commands bring the robot.
    pub path_um: f64,
    /// Distance from a goal.
    pub goal_um: f64,
    /// Angle from the heading of a goal.
    pub heading_rad: f64,
    /// Time beyond a time limit.
    pub time_ns: u64,
}

/// Summary of a recorded run without a violation.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedRun {
    pub measurements: u64,
    pub commands: u64,
    pub strokes: u64,
    /// Measurements that the controller did not use.
    pub set_aside: u64,
    /// Time from the first measurement to the last.
    pub duration_ns: u64,
    /// The deviation that is the largest fraction of what was allowed.
    pub farthest: Option<Deviation>,
    /// Goals in the order of the task.
    pub goals: Vec<GoalReached>,
}

/// Distance of a robot's measured position from where the commands bring it.
#[derive(Debug, Clone, PartialEq)]
pub struct Deviation {
    pub robot: String,
    /// Time since the first measurement.
    pub at_ns: u64,
    pub off_um: f64,
    pub allowed_um: f64,
}

/// Deviation of a robot from its goal, as measured; in an assembly, from its place in the structure.
#[derive(Debug, Clone, PartialEq)]
pub struct GoalReached {
    pub robot: String,
    pub is_docked: bool,
    pub off_um: f64,
    pub allowed_um: f64,
    pub off_rad: f64,
    pub allowed_rad: f64,
}

/// Judges the lines of a run of the only task of some claims, which were derived from the files of `sources`.
///
/// # Errors
/// The violations, at least one.
pub fn judge(
    lines: &[&ControlLine],
    claims: &Claims,
    sources: &Sources,
    tolerances: Tolerances,
) -> Result<RecordedRun, Vec<Violation>> {
    let unfit = |why: &str| Err(vec![Violation::new(Rule::Exchange, 0, format!("no recording can be judged: {why}"))]);
    let [job] = claims.jobs.as_slice() else { return unfit("the program must have exactly one run of one device") };
    let Some(order) = MicrorobotsOrder::of(&job.order) else { return unfit("the task is not for microrobots") };
    let Some(errors) = order.facts.errors else { return unfit("the device does not state its errors") };
    if let Err(super::InvalidClaims(why)) = claims::check_claims(order) {
        return unfit(&why);
    }
    let text_lines = order.steps.iter().map(|step| sources.position(step.span).line).collect();
    let run = JudgedRecording { job, order, errors, tolerances, text_lines };
    let mut walk = Walk::new(&run);
    let mut findings = Findings::default();
    match walk.all(lines, &mut findings) {
        Ok(()) | Err(ReplayStop::InvalidClaims(_)) => {}
        Err(ReplayStop::Broken(violation)) => findings.push(*violation),
    }
    match findings.is_empty() {
        true => Ok(walk.report()),
        false => Err(findings.sorted()),
    }
}

/// A recording with the claims to judge it by.
struct JudgedRecording<'a> {
    job: &'a Job,
    order: &'a MicrorobotsOrder,
    errors: Errors,
    tolerances: Tolerances,
    /// The line of each step in the program's text.
    text_lines: Vec<u32>,
}

impl JudgedRecording<'_> {
    fn name(&self, robot: usize) -> &str {
        &self.order.robot(robot).name
    }

    /// The index of a robot of the scene.
    fn robot(&self, name: &str) -> Option<usize> {
        (0..self.order.robots.len()).find(|robot| self.name(*robot) == name)
    }

    /// A violation in a step; `time_ns` counts from the first measurement.
    fn within(&self, rule: Rule, step: usize, time_ns: u64, title: String) -> Violation {
        let span = self.order.steps.get(step).map_or(Span::default(), |step| step.span);
        Violation::new(rule, time_ns, title).label(span, "in this step").help(mend(rule))
    }
}

/// Help for the operator, by the rule that is broken.
fn mend(rule: Rule) -> &'static str {
    const MENDS: [(Rule, &str); 7] = [
        (
            Rule::Path,
            "a measurement is wrong, or the robots have larger errors than the device declares: correct `errors`, or allow \
             more with `--path-tolerance`",
        ),
        (Rule::Goal, "allow more with `--goal-tolerance` and `--heading-tolerance`, or run the task again"),
        (Rule::Dock, "allow more with `--goal-tolerance` and `--heading-tolerance`, or run the task again"),
        (Rule::GivenUp, "the recording has all measurements and commands up to then; run the task again"),
        (Rule::Requirement, "raise the limit, or allow more with `--time-tolerance`"),
        (Rule::Meet, "check the measurements: two bodies cannot overlap"),
        (Rule::Graze, "check the measurements: no body can be inside an obstacle"),
    ];
    let edited = "`tweeze control` never records this: the recording was edited, or written by another program";
    MENDS.iter().find(|(of, _)| *of == rule).map_or(edited, |(_, mend)| mend)
}

/// Progress through the lines of a recording.
struct Walk<'r, 'a> {
    run: &'r JudgedRecording<'a>,
    commanded: Commanded<'r, 'a>,
    tracked: Tracked<'r, 'a>,
    goals: goals::Goals<'r, 'a>,
    first_ns: Option<u64>,
    /// Time of the last measurement.
    last_ns: u64,
    /// Index of the current step.
    step: usize,
    measurements: u64,
    commands: u64,
    set_aside: u64,
}

impl<'r, 'a> Walk<'r, 'a> {
    fn new(run: &'r JudgedRecording<'a>) -> Self {
        Walk {
            run,
            commanded: Commanded::new(run),
            tracked: Tracked::new(run),
            goals: goals::Goals::new(run),
            first_ns: None,
            last_ns: 0,
            step: 0,
            measurements: 0,
            commands: 0,
            set_aside: 0,
        }
    }

    /// Time since the first measurement.
    fn since_ns(&self, t_ns: u64) -> u64 {
        t_ns.saturating_sub(self.first_ns.unwrap_or(t_ns))
    }

    fn exchange(&self, t_ns: u64, what: String) -> ReplayStop {
        let at_ns = self.since_ns(t_ns);
        self.run.within(Rule::Exchange, self.step, at_ns, format!("{what}, at {}", ms(at_ns))).into()
    }

    fn all(&mut self, lines: &[&ControlLine], findings: &mut Findings) -> Result<(), ReplayStop> {
        let (mut pending, mut last): (Option<&MeasuredLine>, Option<&CommandLine>) = (None, None);
        for line in lines {
            if let Some(CommandLine { command: CommandWord::Finished | CommandWord::Stop, t_ns, .. }) = last {
                return Err(self.exchange(*t_ns, "lines follow the end of the run".to_owned()));
            }
            match (line, pending.take()) {
                (ControlLine::Measured(measured), None) => {
                    self.first_ns.get_or_insert(measured.t_ns);
                    self.measurements += 1;
                    pending = Some(measured);
                }
                (ControlLine::Measured(_), Some(before)) => {
                    return Err(self.exchange(before.t_ns, "a measurement is not answered by a command".to_owned()));
                }
                (ControlLine::Command(command), measured) => {
                    self.commands += 1;
                    self.pair(measured, command, findings)?;
                    last = Some(command);
                }
            }
        }
        if let Some(MeasuredLine { t_ns, .. }) = pending {
            return Err(self.exchange(*t_ns, "a measurement is not answered by a command".to_owned()));
        }
        self.end(last)
    }

    /// Checks that the run ends with its task done.
    fn end(&self, last: Option<&CommandLine>) -> Result<(), ReplayStop> {
        let at_ns = self.since_ns(self.last_ns);
        let title = match last {
            Some(CommandLine { command: CommandWord::Finished, .. }) => return Ok(()),
            Some(CommandLine { command: CommandWord::Stop, message, .. }) => {
                let why = message.as_deref().unwrap_or("no reason is recorded");
                let clean: String = why.chars().filter(|c| !c.is_control()).take(200).collect();
                format!("the task was given up at {}: {clean}", ms(at_ns))
            }
            Some(_) => format!("the recording breaks off at {}, before the task is done", ms(at_ns)),
            None => "the recording has no commands".to_owned(),
        };
        Err(self.run.within(Rule::GivenUp, self.step, at_ns, title).into())
    }

    /// Judges a command, with the measurement that it answers.
    fn pair(
        &mut self,
        measured: Option<&MeasuredLine>,
        command: &CommandLine,
        findings: &mut Findings,
    ) -> Result<(), ReplayStop> {
        let now_ns = measured.map_or(self.last_ns, |measured| measured.t_ns);
        if command.t_ns != now_ns.max(self.last_ns) {
            return Err(self.exchange(now_ns, "the time of a command differs from that of its measurement".to_owned()));
        }
        let stops = command.command == CommandWord::Stop;
        let Some(measured) = measured else {
            let is_unasked = matches!(
                command.reason,
                Some(
                    StopReason::Silence
                        | StopReason::Closed
                        | StopReason::Garbled
                        | StopReason::Interrupted
                        | StopReason::Unread
                )
            );
            return match stops && is_unasked {
                true => Ok(()),
                false => Err(self.exchange(now_ns, "a command answers no measurement".to_owned())),
            };
        };
        let until_ns = self.commanded.until_ns;
        let latest_ns =
            until_ns.map(|until| until.max(self.last_ns).saturating_add(self.run.order.facts.watchdog_ns()));
        let must_stop = if now_ns < self.last_ns {
            Some("the clock of the measurements runs backwards")
        } else if latest_ns.is_some_and(|latest_ns| now_ns > latest_ns) {
            Some("a measurement comes after the watchdog has expired")
        } else {
            None
        };
        if let Some(why) = must_stop {
            return if stops { Ok(()) } else { Err(self.exchange(now_ns, format!("{why}, but the run continues"))) };
        }
        self.last_ns = now_ns;
        let is_early = until_ns.is_some_and(|until_ns| now_ns < until_ns);
        match (is_early, command.command) {
            (true, CommandWord::Continue) if command.until_ns == until_ns => return Ok(()),
            (true, CommandWord::Stop) => return Ok(()),
            (true, _) => return Err(self.exchange(now_ns, "a command comes before the last one has ended".to_owned())),
            (false, CommandWord::Continue) => {
                return Err(
                    self.exchange(now_ns, "`continue` is commanded when no command is being carried out".to_owned())
                );
            }
            (false, _) => {}
        }
        let at_ns = self.since_ns(now_ns);
        let poses = self.poses(measured)?;
        let holds = command.command == CommandWord::Drive && command.segments.as_ref().is_some_and(Vec::is_empty);
        // Nothing has been driven before, nor is anything because of this measurement, so the run can begin with the
        // next one.
        if holds && !self.tracked.has_begun() {
            self.set_aside += 1;
            return self.follow(command, at_ns, None, findings);
        }
        match self.tracked.see(&poses, self.step, at_ns, findings) {
            Seen::Usable(places) => {
                self.goals.pass(self.step, &places);
                self.follow(command, at_ns, Some(&places), findings)
            }
            Seen::SetAside(_) if stops => Ok(()),
            Seen::SetAside(why) => {
                self.set_aside += 1;
                match holds {
                    true => self.follow(command, at_ns, None, findings),
                    false => Err(ReplayStop::Broken(why)),
                }
            }
        }
    }

    /// The measured poses by robot, in the order of the scene; `None` for a robot that was not seen.
    fn poses(&self, measured: &MeasuredLine) -> Result<Vec<Option<RobotPlace>>, ReplayStop> {
        if let Some(unknown) = measured.robots.keys().find(|name| self.run.robot(name).is_none()) {
            let clean: String = unknown.chars().filter(|c| !c.is_control()).take(40).collect();
            return Err(self.exchange(measured.t_ns, format!("`{clean}` is measured, but is no robot of the scene")));
        }
        let place = |robot: usize| {
            let pose = measured.robots.get(self.run.name(robot))?.as_ref()?;
            Some(RobotPlace::of(&pose.pose()))
        };
        Ok((0..self.run.order.robots.len()).map(place).collect())
    }

    /// Applies a command. `places` are those of the measurement that it answers, if that was used.
    fn follow(
        &mut self,
        command: &CommandLine,
        at_ns: u64,
        places: Option<&[RobotPlace]>,
        findings: &mut Findings,
    ) -> Result<(), ReplayStop> {
        if command.command == CommandWord::Stop {
            return Ok(());
        }
        self.commanded.words(command, at_ns)?;
        let is_over = command.command == CommandWord::Finished;
        let next = if is_over { self.run.order.steps.len() } else { command.step };
        if next < self.step {
            return Err(self.exchange(command.t_ns, "a command is for a step that had already ended".to_owned()));
        }
        for step in self.step..next {
            let Some(places) = places else {
                return Err(self.exchange(command.t_ns, "a step ends without a usable measurement".to_owned()));
            };
            self.commanded.end_step(step, at_ns, findings);
            self.goals.end_step(step, at_ns, places, &self.commanded.docked, findings);
        }
        self.step = next;
        if is_over {
            goals::time(self.run, at_ns, findings);
            return Ok(());
        }
        let legs = self.commanded.take(command, at_ns, findings)?;
        self.tracked.drive(&legs, &self.commanded.docked);
        Ok(())
    }

    fn report(self) -> RecordedRun {
        RecordedRun {
            measurements: self.measurements,
            commands: self.commands,
            strokes: self.commanded.strokes,
            set_aside: self.set_aside,
            duration_ns: self.since_ns(self.last_ns),
            farthest: self.tracked.farthest(),
            goals: self.goals.reached,
        }
    }
}
