//! Checks the commands of a recorded run against the device and the steps of its task.
//!
//! Input: command lines. Output: the legs that they drive. Promise: arm positions come from the voltage alone, as in a
//! replayed schedule: between two drives the bed is at the relax level, otherwise at 0 V.

use super::super::relay::ArmHysteresis;
use super::JudgedRecording;
use crate::claims::microrobots::MicrorobotsAction;
use crate::device::microrobots::Arm;
use crate::schedule::control::{CommandLine, CommandWord, SegmentLine};
use crate::verify::ReplayStop;
use crate::verify::rule::{Findings, Rule, ms};

/// Strokes in a control state of the order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct CommandedLeg {
    pub control: usize,
    pub strokes: u64,
}

/// The commands so far.
pub(super) struct Commanded<'r, 'a> {
    run: &'r JudgedRecording<'a>,
    hysteresis: ArmHysteresis<'a>,
    /// When the last command ends; `None` before the first one.
    pub until_ns: Option<u64>,
    /// For each robot of the order, whether the controller considers it docked.
    pub docked: Vec<bool>,
    pub strokes: u64,
    /// Legs with strokes in the current step, and the start and end of its rest.
    applied: Vec<CommandedLeg>,
    rested: Option<[u64; 2]>,
}

impl<'r, 'a> Commanded<'r, 'a> {
    pub fn new(run: &'r JudgedRecording<'a>) -> Self {
        let mut hysteresis = ArmHysteresis::new(&run.order.facts);
        hysteresis.visit(0.0);
        let docked = vec![false; run.order.robots.len()];
        Commanded { run, hysteresis, until_ns: None, docked, strokes: 0, applied: Vec::new(), rested: None }
    }

    /// Checks that step, line and names of a command are those of the program, and that docked robots stay docked.
    pub fn words(&mut self, command: &CommandLine, at_ns: u64) -> Result<(), ReplayStop> {
        let (run, step, at) = (self.run, command.step, ms(at_ns));
        let broken = |title: String| Err(ReplayStop::from(run.within(Rule::Exchange, step, at_ns, title)));
        match run.text_lines.get(step) {
            Some(line) if command.line == Some(*line) => {}
            Some(line) => {
                return broken(format!("the command at {at} does not name line {line}, which is that of its step"));
            }
            None => return broken(format!("the command at {at} is for step {step}, which the task does not have")),
        }
        let robots = |names: &[String]| names.iter().map(|name| run.robot(name)).collect::<Option<Vec<usize>>>();
        let (Some(_), Some(docked)) = (robots(&command.driven), robots(&command.docked)) else {
            return broken(format!("the command at {at} names a robot that the scene does not have"));
        };
        let docks = |robot: usize| {
            let docks = |action: &MicrorobotsAction| match action {
                MicrorobotsAction::Assemble(docks) => docks.iter().any(|dock| dock.robot == robot),
                MicrorobotsAction::Apply { .. } | MicrorobotsAction::Drive { .. } | MicrorobotsAction::Wait(_) => false,
            };
            run.order.steps.iter().take(step + 1).any(|step| docks(&step.action))
        };
        for robot in 0..self.docked.len() {
            let name = run.name(robot);
            match (self.docked[robot], docked.contains(&robot)) {
                (true, false) => return broken(format!("`{name}` is no longer considered docked at {at}")),
                (false, true) if !docks(robot) => {
                    return broken(format!("`{name}` is considered docked at {at}, but no step docks it"));
                }
                (_, is_docked) => self.docked[robot] = is_docked,
            }
        }
        Ok(())
    }

    /// The legs of a command that drives or rests.
    pub fn take(
        &mut self,
        command: &CommandLine,
        at_ns: u64,
        findings: &mut Findings,
    ) -> Result<Vec<CommandedLeg>, ReplayStop> {
        let mut legs = Vec::new();
        let mut lasts_ns = 0_u64;
        let is_rest = command.command == CommandWord::Rest;
        for segment in command.segments.iter().flatten().filter(|_| !is_rest) {
            legs.push(self.segment(segment, command.step, at_ns, findings)?);
            let facts = &self.run.order.facts;
            let levels_ns = (segment.levels_v.len() as u64).saturating_mul(facts.dwell_ns);
            let train_ns = segment.strokes.saturating_mul(facts.period_ns);
            lasts_ns = lasts_ns.saturating_add(levels_ns).saturating_add(train_ns);
        }
        self.hysteresis.visit(if is_rest { 0.0 } else { self.run.order.facts.relax_v });
        let due_ns = match is_rest {
            true => self.rest_until(command),
            false => Some(command.t_ns.saturating_add(lasts_ns.max(self.run.errors.replan_ns))),
        };
        if command.until_ns != due_ns || due_ns.is_none() {
            let at = ms(at_ns);
            let title = format!("the command at {at} lasts longer or shorter than what it commands");
            return Err(self.run.within(Rule::Exchange, command.step, at_ns, title).into());
        }
        self.until_ns = command.until_ns;
        self.applied.extend(&legs);
        self.strokes = legs.iter().fold(self.strokes, |sum, leg| sum.saturating_add(leg.strokes));
        Ok(legs)
    }

    /// The end of the current step's rest; `None` in a step that does not wait.
    fn rest_until(&mut self, command: &CommandLine) -> Option<u64> {
        let MicrorobotsAction::Wait(duration_ns) = self.run.order.steps.get(command.step)?.action else { return None };
        let [_, until_ns] = *self.rested.get_or_insert([command.t_ns, command.t_ns.saturating_add(duration_ns)]);
        Some(until_ns)
    }

    /// The leg of a segment: a control cycle, unless the arms are in position already, followed by strokes that move
    /// no arm.
    fn segment(
        &mut self,
        segment: &SegmentLine,
        step: usize,
        at_ns: u64,
        findings: &mut Findings,
    ) -> Result<CommandedLeg, ReplayStop> {
        let (order, at) = (self.run.order, ms(at_ns));
        let facts = &order.facts;
        let broken = |rule, title: String| Err(ReplayStop::from(self.run.within(rule, step, at_ns, title)));
        if let Some(level) = segment.levels_v.iter().find(|level| !(0.0..=facts.max_v).contains(*level)) {
            let title = format!("a level of {level} V is commanded at {at}; the source gives 0 V to {} V", facts.max_v);
            return broken(Rule::Level, title);
        }
        if segment.strokes == 0 {
            return broken(Rule::Train, format!("a segment at {at} has no strokes"));
        }
        segment.levels_v.iter().for_each(|level| self.hysteresis.visit(*level));
        let name = |row: usize| &facts.robots[row].name;
        if let Some(row) = self.hysteresis.unknown() {
            return broken(
                Rule::Arm,
                format!("the arm of `{}` may be up or down when strokes begin at {at}", name(row)),
            );
        }
        for level_v in [facts.flex_v, facts.relax_v] {
            if let Some(row) = self.hysteresis.moved_by(level_v) {
                let title = format!("a stroke to {level_v} V at {at} may move the arm of `{}`", name(row));
                return broken(Rule::Arm, title);
            }
        }
        self.hysteresis.visit(facts.relax_v);
        let arms: Vec<Arm> = self.hysteresis.arms.iter().flatten().copied().collect();
        let digits: String = arms.iter().map(|arm| char::from(b'0' + arm.digit())).collect();
        let control = order.states.iter().position(|state| state.arms == arms).filter(|_| digits == segment.state);
        let Some(control) = control else {
            return broken(
                Rule::Control,
                format!("the arms are in state {digits} at {at}, which is not the state of the command"),
            );
        };
        let is_down = |robot: &usize| self.docked[*robot] && arms[order.robots[*robot].row] == Arm::Down;
        if let Some(robot) = (0..self.docked.len()).find(is_down) {
            let name = self.run.name(robot);
            let title = format!("strokes at {at} are driven while the arm of docked robot `{name}` is down");
            findings.push(self.run.within(Rule::Twist, step, at_ns, title));
        }
        Ok(CommandedLeg { control, strokes: segment.strokes })
    }

    /// An `apply` or a `wait` was executed as written.
    pub fn end_step(&mut self, step: usize, at_ns: u64, findings: &mut Findings) {
        let (applied, rested) = (std::mem::take(&mut self.applied), self.rested.take());
        match self.run.order.steps[step].action {
            MicrorobotsAction::Apply { state, duration_ns } => {
                let due = duration_ns.div_ceil(self.run.order.facts.period_ns);
                let strokes = applied.iter().map(|leg| leg.strokes).fold(0, u64::saturating_add);
                let title = match applied.iter().find(|leg| leg.control != state) {
                    Some(leg) => format!("control state {} is applied, but the program applies {state}", leg.control),
                    None if strokes != due => {
                        format!("{strokes} strokes are driven in `apply`; {due} are needed for {}", ms(duration_ns))
                    }
                    None => return,
                };
                findings.push(self.run.within(Rule::Apply, step, at_ns, title));
            }
            MicrorobotsAction::Wait(duration_ns) if duration_ns > 0 => {
                let is_kept = applied.is_empty() && rested.is_some();
                if !is_kept {
                    let title = format!("the bed is driven during a wait of {}, or does not rest", ms(duration_ns));
                    findings.push(self.run.within(Rule::Wait, step, at_ns, title));
                }
            }
            MicrorobotsAction::Wait(_) | MicrorobotsAction::Drive { .. } | MicrorobotsAction::Assemble(_) => {}
        }
    }
}
