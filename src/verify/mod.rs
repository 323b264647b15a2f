//! The independent verifier: replays a schedule against the device models and the program's claims, and trusts nothing
//! of the planner.
//!
//! Input: a [`Schedule`] and the [`Claims`] of its program. Output: a [`Verdict`]. Promise: only this stage can make a
//! [`Verified`] value, and only such a value can be emitted; the exception is the page that shows why a log was
//! refused. The verifier shares no code with a planner, nor the geometry that planners measure with: distances, placed
//! shapes and outlines come from its own `geometry` module. `tests/tidy.rs` lists the parts of `device` that both use.
//! Positions come from the kinematic matrix, swept areas from gaps between projections, moves of parts from the
//! electrodes that are on, and turns of parts from the contacts of tips. No input makes it panic. Cost for n
//! actuations and m obstacles: n log n to sort, and per move m/32 box comparisons plus the exact distance to the few
//! bodies near it; each step of a board also costs its parts, and each sample of a rolling motion a linear program.
//!
//! Rules are checked in three rounds. A round starts only if the one before found nothing, because a broken index or
//! interval would make the later findings meaningless:
//! 1. `form`: the schedule alone.
//! 2. `clock`: its runs and steps against the claims.
//! 3. The timeline, the replay of each run (one file per kind), and `record` (the schedule's own figures), together.

mod boxes;
mod catalogue;
mod clock;
mod dimibot;
pub(crate) mod electrode_array;
mod evidence;
pub mod fingers;
mod form;
mod geometry;
mod holds;
pub mod microrobots;
mod outputs;
mod premise;
mod record;
mod rule;
mod source_map;

pub use evidence::{Clearance, Evidence, GapUnit};
pub use rule::{MAX_VIOLATIONS, Rule, Violation};

use crate::claims::{Claims, Order};
use crate::device::each_kind;
use crate::diagnostic::{Code, Diagnostic, Sink};
use crate::schedule::{ChannelUnit, Schedule, State, TimedState};
use crate::source::{Sources, Span};
use clock::JudgedRun;
use evidence::Tally;
use rule::Findings;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Deref;
use std::rc::Rc;

/// A schedule that was replayed without a violation, with the claims that it keeps.
#[derive(Debug, Clone)]
pub struct Verified {
    held: Box<(Schedule, Claims, Evidence)>,
}

impl Verified {
    /// The schedule.
    pub fn schedule(&self) -> &Schedule {
        &self.held.0
    }

    /// The claims that it was checked against.
    pub fn claims(&self) -> &Claims {
        &self.held.1
    }

    /// Number of checks of each rule, and the least clearances.
    pub fn evidence(&self) -> &Evidence {
        &self.held.2
    }

    /// Accepts a schedule without checking it, for tests of the later stages.
    #[cfg(test)]
    pub(crate) fn assume(schedule: Schedule, claims: Claims) -> Self {
        Verified { held: Box::new((schedule, claims, Evidence::default())) }
    }
}

/// Result of verification.
#[derive(Debug, Clone)]
pub enum Verdict {
    /// Every rule is kept.
    Accepted(Verified),
    /// The violations, by time; at least one, at most [`MAX_VIOLATIONS`].
    Rejected(Vec<Violation>),
    /// No schedule can be checked against the claims.
    Inconclusive { why: String },
}

impl Verdict {
    /// The verified schedule; otherwise `None`, with the violations or the reason pushed to the sink.
    pub fn into_verified(self, sink: &mut Sink) -> Option<Verified> {
        match self {
            Verdict::Accepted(verified) => return Some(verified),
            Verdict::Rejected(violations) => violations.into_iter().for_each(|violation| sink.push(violation.into())),
            Verdict::Inconclusive { why } => sink.push(inconclusive(&why)),
        }
        None
    }
}

/// Checks a schedule against its program: against the claims, which were derived from the files of `sources`, and
/// against the files themselves for the texts of its steps.
///
/// Claims of the checker can always be judged; [`Verdict::Inconclusive`] results only from claims of another origin.
pub fn verify_program(schedule: Schedule, claims: &Claims, sources: &Sources) -> Verdict {
    let tally = Rc::new(Tally::default());
    let found =
        judge(&schedule, claims, &tally).map(|found| with_source_map(found, &schedule, claims, sources, &tally));
    verdict(found, schedule, claims, &tally)
}

fn verdict(
    found: Result<Vec<Violation>, InvalidClaims>,
    schedule: Schedule,
    claims: &Claims,
    tally: &Tally,
) -> Verdict {
    match found {
        Err(InvalidClaims(why)) => Verdict::Inconclusive { why },
        Ok(violations) if violations.is_empty() => {
            Verdict::Accepted(Verified { held: Box::new((schedule, claims.clone(), tally.evidence())) })
        }
        Ok(violations) => {
            // A rule that is broken must have been counted as checked before.
            #[cfg(test)]
            violations.iter().for_each(|violation| assert!(tally.times(violation.rule) > 0, "{violation:?}"));
            Verdict::Rejected(violations)
        }
    }
}

/// The source map is judged last: the other rules must have paired steps with those of the claims.
fn with_source_map(
    found: Vec<Violation>,
    schedule: &Schedule,
    claims: &Claims,
    sources: &Sources,
    tally: &Rc<Tally>,
) -> Vec<Violation> {
    if !found.is_empty() {
        return found;
    }
    let mut findings = Findings::counting(tally);
    source_map::check(schedule, claims, sources, &mut findings);
    findings.sorted()
}

/// Violations of the claims of a program other than the schedule's own; texts of steps are not compared.
///
/// # Errors
/// The reason why no schedule can be checked against the claims.
pub fn violations(schedule: &Schedule, claims: &Claims) -> Result<Vec<Violation>, String> {
    judge(schedule, claims, &Rc::default()).map_err(|InvalidClaims(why)| why)
}

/// Whether a schedule's indices, numbers, channels, runs and steps are consistent with one another and with its
/// claims; other rules are not checked.
pub fn is_consistent(schedule: &Schedule, claims: &Claims) -> bool {
    let mut findings = Findings::default();
    if premise::check(claims).is_err() {
        return false;
    }
    form::check(schedule, claims, &mut findings);
    if findings.is_empty() {
        clock::runs(schedule, claims, &mut findings);
    }
    findings.is_empty()
}

/// As [`verify_program`] but without the source map, for schedules that the tests make by hand.
#[cfg(test)]
fn verify(schedule: Schedule, claims: &Claims) -> Verdict {
    let tally = Rc::new(Tally::default());
    verdict(judge(&schedule, claims, &tally), schedule, claims, &tally)
}

/// Diagnostic for claims against which no schedule can be checked.
pub fn inconclusive(why: &str) -> Diagnostic {
    Diagnostic::new(Code::E0740, format!("no schedule can be checked against the claims: {why}"))
}

/// Why no schedule can be checked against the claims.
#[derive(Debug)]
struct InvalidClaims(String);

/// Why a run cannot be followed to its end.
#[derive(Debug)]
enum ReplayStop {
    InvalidClaims(InvalidClaims),
    /// The state after this is unknown, so the device is not followed further.
    Broken(Box<Violation>),
}

impl From<InvalidClaims> for ReplayStop {
    fn from(invalid: InvalidClaims) -> ReplayStop {
        ReplayStop::InvalidClaims(invalid)
    }
}

impl From<Violation> for ReplayStop {
    fn from(violation: Violation) -> ReplayStop {
        ReplayStop::Broken(Box::new(violation))
    }
}

/// A replayed state; that of the record where the two agree, since there may be millions.
#[derive(Debug)]
enum ReplayedState<'a> {
    Recorded(&'a TimedState),
    Own(Box<TimedState>),
}

impl Deref for ReplayedState<'_> {
    type Target = TimedState;

    fn deref(&self) -> &TimedState {
        match self {
            ReplayedState::Recorded(state) => state,
            ReplayedState::Own(state) => state,
        }
    }
}

/// Result of the replay of a run.
#[derive(Debug)]
struct Replay<'a> {
    /// States at the beginning and after every change.
    states: Vec<ReplayedState<'a>>,
    /// Every outcome of the kind's vocabulary, by name, in SI units.
    outcomes: BTreeMap<&'static str, f64>,
    /// Concurrent operations, by index of the step in the run, in the order of the program.
    operations: BTreeMap<usize, Vec<JudgedOperation>>,
}

/// An operation as it was replayed.
#[derive(Debug)]
struct JudgedOperation {
    parts: Vec<String>,
    /// When the first of its parts is free for it, when all parts have arrived, and when it is done.
    times_ns: [u64; 3],
    span: Span,
}

/// Required terms of a plan's record, from the claims.
struct RecordTerms {
    planner: &'static str,
    objective: &'static str,
    /// The outcome that the objective minimises; `None` for an estimate, which no replay derives.
    outcome: Option<&'static str>,
    /// Unit of the cost.
    unit: &'static str,
    /// Number of these units in one SI unit.
    scale: f64,
}

/// Present state of each device, by its name.
type LastStates<'a> = BTreeMap<&'a str, State>;

/// Verification of one kind of device; implemented by its orders.
trait Judge {
    /// Unit of a channel's values; `None` if the device has no channel of that name.
    fn unit(&self, channel: &str) -> Option<ChannelUnit>;

    /// Whether its channels may swing between two values (a square wave).
    fn swings(&self) -> bool {
        false
    }

    /// Checks what the replay assumes of the claims.
    fn premise(&self) -> Result<(), InvalidClaims>;

    /// Whether another order of the same device states the same facts about it.
    fn has_facts_of(&self, other: &Order) -> bool;

    /// Whether another order of the same device has the same parts, from one run to the next.
    fn has_parts_of(&self, _other: &Order) -> bool {
        true
    }

    /// Forces on the parts that are held in a state, if the kind holds parts by forces; see [`forces`].
    fn forces(&self, _state: &State) -> Option<Vec<Option<[f64; 3]>>> {
        None
    }

    /// Required terms of a plan's record.
    fn terms(&self) -> RecordTerms;

    /// Objective for `minimize` that lowers an outcome, if there is one.
    fn minimized_as(&self, outcome: &str) -> Option<&'static str>;

    /// Replays a run and checks it against its order. Afterwards `last_states` has the device's last state.
    ///
    /// # Errors
    /// At the first violation after which the device's state is unknown.
    fn replay<'a>(
        &self,
        run: &JudgedRun<'a>,
        claims: &Claims,
        last_states: &mut LastStates<'a>,
        findings: &mut Findings,
    ) -> Result<Replay<'a>, ReplayStop>;

    /// Checks the program's devices of the kind against one another; called once per kind. `order` has the indices of
    /// the runs, those of one device in the order in which it executes them.
    fn check_between_devices(&self, _runs: &[JudgedRun], _order: &[usize], _claims: &Claims, _findings: &mut Findings) {
    }
}

/// Force of each finger on the part that the fingers hold in a state, along the axes of the device, in micronewtons.
/// `None` for a finger that is free; `None` as a whole where nothing is held or no forces balance.
pub fn forces(order: &Order, state: &State) -> Option<Vec<Option<[f64; 3]>>> {
    judge_of(order).forces(state)
}

/// The judge of an order.
fn judge_of(order: &Order) -> &dyn Judge {
    each_kind!(Order, order, order => order)
}

/// Comparison and display of one kind's states.
trait JudgedState {
    /// Whether a replayed state equals this recorded one, up to rounding.
    fn agrees(&self, replayed: &State) -> bool;

    /// The state in words.
    fn shown(&self) -> String;
}

/// The judge of a recorded or replayed state.
fn judged_state(state: &State) -> &dyn JudgedState {
    each_kind!(State, state, state => state)
}

fn judge(schedule: &Schedule, claims: &Claims, tally: &Rc<Tally>) -> Result<Vec<Violation>, InvalidClaims> {
    premise::check(claims)?;
    let mut findings = Findings::counting(tally);
    form::check(schedule, claims, &mut findings);
    if !findings.is_empty() {
        return Ok(findings.sorted());
    }
    let runs = clock::runs(schedule, claims, &mut findings);
    if !findings.is_empty() {
        return Ok(findings.sorted());
    }
    let mut last_states = LastStates::new();
    let mut lost = BTreeSet::new();
    let due = clock::timeline(schedule, &runs, claims, &mut findings);
    let order: Vec<usize> = due.iter().filter_map(|stretch| stretch.job).collect();
    outputs::check(schedule, &runs, claims, &mut findings);
    holds::check(schedule, &runs, &due, claims, &mut findings);
    for job in claims.first_of_kinds() {
        judge_of(&job.order).check_between_devices(&runs, &order, claims, &mut findings);
    }
    for index in order {
        let run = &runs[index];
        if lost.contains(run.job.device.as_str()) {
            continue;
        }
        tally.count_checks(Rule::Start, 1);
        tally.count_checks(Rule::State, run.plan.states.len().max(1));
        match judge_of(&run.job.order).replay(run, claims, &mut last_states, &mut findings) {
            Ok(replay) => record::check(run, &replay, &mut findings),
            Err(ReplayStop::InvalidClaims(invalid)) => return Err(invalid),
            Err(ReplayStop::Broken(violation)) => {
                findings.push(*violation);
                lost.insert(run.job.device.as_str());
            }
        }
    }
    Ok(findings.sorted())
}

#[cfg(test)]
mod tests;
