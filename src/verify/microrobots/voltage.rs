//! Effect of the bed's voltage on the arms: control cycles and trains of strokes.
//!
//! Input: a run. Output: its legs, each with the control state in which its strokes are driven. Promise: in each leg
//! every arm is certainly up or down, as in a control state of the claims, and no stroke moves it, however many there
//! are: a level that leaves all arms unmoved does so again when repeated. Outside of actuations the bed is at 0 V.

use super::super::clock::JudgedRun;
use super::super::rule::{Findings, Rule, Violation, ms};
use super::relay::ArmHysteresis;
use crate::claims::microrobots::{MicrorobotsAction, MicrorobotsOrder};
use crate::device::microrobots::Arm;
use crate::schedule::{Actuation, Swing};
use rustc_hash::FxHashMap;

/// A control cycle and the train of strokes after it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct VoltageLeg {
    pub start_ns: u64,
    /// When its strokes begin.
    pub train_ns: u64,
    pub strokes: u64,
    /// Index of the control state among the order's states.
    pub control: usize,
}

/// The legs of each step of the run; none for a wait.
///
/// # Errors
/// At the first voltage whose effect is unknown.
pub(super) fn legs(
    run: &JudgedRun,
    order: &MicrorobotsOrder,
    findings: &mut Findings,
) -> Result<Vec<Vec<VoltageLeg>>, Violation> {
    let states = order.states.iter().enumerate().rev();
    let mut bed = DrivenBed {
        run,
        order,
        hysteresis: ArmHysteresis::new(&order.facts),
        controls: states.map(|(index, state)| (state.arms.as_slice(), index)).collect(),
    };
    let mut actuations = run.actuations.as_slice();
    let mut legs = Vec::with_capacity(order.steps.len());
    for (nth, step) in order.steps.iter().enumerate() {
        let own = actuations.iter().take_while(|actuation| actuation.step as usize == run.steps[nth]).count();
        let (here, later) = actuations.split_at(own);
        actuations = later;
        legs.push(match step.action {
            MicrorobotsAction::Wait(duration_ns) => {
                bed.wait(nth, duration_ns, here, findings)?;
                Vec::new()
            }
            MicrorobotsAction::Apply { .. } | MicrorobotsAction::Drive { .. } | MicrorobotsAction::Assemble(_) => {
                bed.drive(nth, here, findings)?
            }
        });
    }
    bed.rest(run.end_ns(), order.steps.len().checked_sub(1))?;
    Ok(legs)
}

/// The bed during the replay of a run.
struct DrivenBed<'r, 'a> {
    run: &'r JudgedRun<'a>,
    order: &'r MicrorobotsOrder,
    hysteresis: ArmHysteresis<'r>,
    /// Index of the first control state with each pattern of arms.
    controls: FxHashMap<&'r [Arm], usize>,
}

impl DrivenBed<'_, '_> {
    fn name(&self, row: usize) -> &str {
        &self.order.facts.robots[row].name
    }

    /// Sets the bed to 0 V, which must bring all arms up.
    fn rest(&mut self, time_ns: u64, nth: Option<usize>) -> Result<(), Violation> {
        self.run.tally.count_checks(Rule::Arm, self.hysteresis.arms.len());
        self.hysteresis.visit(0.0);
        let Some(row) = self.hysteresis.not_up() else { return Ok(()) };
        let title = format!("the arm of `{}` may stay down at 0 V, at {}", self.name(row), ms(time_ns));
        Err(match nth {
            Some(nth) => self.run.violation(Rule::Arm, nth, time_ns, title),
            None => Violation::new(Rule::Arm, time_ns, title),
        })
    }

    fn wait(
        &mut self,
        nth: usize,
        duration_ns: u64,
        here: &[&Actuation],
        findings: &mut Findings,
    ) -> Result<(), Violation> {
        self.run.wait_lasts(nth, duration_ns, findings);
        if let Some(first) = here.first() {
            let title = format!("the bed is driven during a wait, at {}", ms(first.start_ns));
            return Err(self.run.violation(Rule::Wait, nth, first.start_ns, title));
        }
        self.rest(self.run.step(nth).start_ns, Some(nth))
    }

    fn drive(
        &mut self,
        nth: usize,
        here: &[&Actuation],
        findings: &mut Findings,
    ) -> Result<Vec<VoltageLeg>, Violation> {
        let step = self.run.step(nth);
        let mut legs = Vec::new();
        let (mut due_ns, mut cycle_ns) = (step.start_ns, None);
        for actuation in here {
            self.gap(nth, due_ns, actuation.start_ns, findings);
            due_ns = actuation.end_ns();
            match actuation.swing {
                None => {
                    self.level(nth, actuation)?;
                    cycle_ns = cycle_ns.or(Some(actuation.start_ns));
                }
                Some(swing) => legs.push(self.train(nth, actuation, swing, cycle_ns.take())?),
            }
        }
        self.gap(nth, due_ns, step.end_ns(), findings);
        self.run.tally.count_checks(Rule::Train, 1);
        if let Some(cycle_ns) = cycle_ns {
            let title = format!("a control cycle from {} on is not followed by strokes", ms(cycle_ns));
            return Err(self.run.violation(Rule::Train, nth, cycle_ns, title));
        }
        Ok(legs)
    }

    /// No time is lost between the actuations of a step; if it is, the bed is at 0 V.
    fn gap(&mut self, nth: usize, from_ns: u64, to_ns: u64, findings: &mut Findings) {
        findings.count_checks(Rule::Idle, 1);
        if from_ns == to_ns {
            return;
        }
        self.hysteresis.visit(0.0);
        let title = format!("the bed is without voltage from {} to {}, within a step", ms(from_ns), ms(to_ns));
        findings.push(self.run.violation(Rule::Idle, nth, from_ns, title));
    }

    /// Checks and applies a level of a control cycle.
    fn level(&mut self, nth: usize, actuation: &Actuation) -> Result<(), Violation> {
        self.run.tally.count_checks(Rule::Level, 1);
        let Actuation { start_ns, duration_ns, from, to, .. } = *actuation;
        let (max_v, dwell_ns) = (self.order.facts.max_v, self.order.facts.dwell_ns);
        let at = ms(start_ns);
        let title = if from != to {
            format!("the bed goes from {from} V to {to} V in a control cycle at {at}; its levels must be steady")
        } else if !(0.0..=max_v).contains(&from) {
            format!("the bed is at {from} V at {at}; the source gives 0 V to {max_v} V")
        } else if duration_ns < dwell_ns {
            let (lasts, due) = (ms(duration_ns), ms(dwell_ns));
            format!("the bed is at {from} V for {lasts} at {at}; at least {due} is needed")
        } else {
            self.hysteresis.visit(from);
            return Ok(());
        };
        Err(self.run.violation(Rule::Level, nth, start_ns, title))
    }

    /// Checks a train of strokes and returns its leg.
    fn train(
        &self,
        nth: usize,
        actuation: &Actuation,
        swing: Swing,
        cycle_ns: Option<u64>,
    ) -> Result<VoltageLeg, Violation> {
        let facts = &self.order.facts;
        self.run.tally.count_checks(Rule::Train, 1);
        self.run.tally.count_checks(Rule::Arm, self.hysteresis.arms.len());
        self.run.tally.count_checks(Rule::Control, 1);
        let train_ns = actuation.start_ns;
        let at = ms(train_ns);
        let due = Swing { period_ns: facts.period_ns, levels: [facts.flex_v, facts.relax_v] };
        if swing != due {
            let shown =
                |Swing { period_ns, levels: [one, other] }| format!("{one} V and {other} V every {}", ms(period_ns));
            let title = format!("the bed swings between {} at {at}; {} is needed", shown(swing), shown(due));
            return Err(self.run.violation(Rule::Train, nth, train_ns, title));
        }
        let Some(start_ns) = cycle_ns else {
            let title = format!("the strokes at {at} do not follow a control cycle");
            return Err(self.run.violation(Rule::Train, nth, train_ns, title));
        };
        if let Some(row) = self.hysteresis.unknown() {
            let title = format!("the arm of `{}` may be up or down when strokes begin at {at}", self.name(row));
            return Err(self.run.violation(Rule::Arm, nth, train_ns, title));
        }
        for level_v in swing.levels {
            if let Some(row) = self.hysteresis.moved_by(level_v) {
                let title = format!("a stroke to {level_v} V at {at} may move the arm of `{}`", self.name(row));
                return Err(self.run.violation(Rule::Arm, nth, train_ns, title));
            }
        }
        let control = self.control(nth, train_ns)?;
        Ok(VoltageLeg { start_ns, train_ns, strokes: actuation.duration_ns / swing.period_ns, control })
    }

    /// The control state of the claims with the present arm positions.
    fn control(&self, nth: usize, train_ns: u64) -> Result<usize, Violation> {
        let arms: Vec<Arm> = self.hysteresis.arms.iter().flatten().copied().collect();
        self.controls.get(arms.as_slice()).copied().ok_or_else(|| {
            let digits: String = arms.iter().map(|arm| char::from(b'0' + arm.digit())).collect();
            let title =
                format!("the arms are in state {digits} at {}, which is no control state of the device", ms(train_ns));
            self.run.violation(Rule::Control, nth, train_ns, title)
        })
    }
}
