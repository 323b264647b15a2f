//! Judges a schedule against the device models and the program's claims, trusting nothing of the planner.
//!
//! Input: a [`Schedule`] and the [`Claims`] of its program. Output: a [`Verdict`].
//! Promise: only this stage can make a [`Verified`] value, and only such a value can be emitted, but for the page that shows why a log was
//! refused. It uses nothing of a planner, and
//! nothing that planners measure with: distances, placed shapes and outlines are those of `geometry` in here. The parts of
//! `device` that both use are listed in `tests/tidy.rs`. Places come from the kinematic matrix, sweeps from gaps between projections, moves
//! of parts from the electrodes that are on, turns of parts from the contacts of tips. No input makes it panic. Cost for n actuations and m
//! obstacles: n log n to sort, and for each move m/32 comparisons of boxes plus the exact distance of the few bodies near it; each
//! step of a board also costs its parts, each sample of a rolling motion a linear program.
//!
//! Rules are checked in three rounds, each only if the one before found nothing, since a broken index or interval would
//! make nonsense of the rest: `form` (the schedule alone), `clock` (its runs and steps against the claims), and
//! then together the timeline, the replay of each run (one file per kind), and `record` (the schedule's own figures).

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
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
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

    /// What was checked, how often, and what comes nearest to what.
    pub fn evidence(&self) -> &Evidence {
        &self.held.2
    }

    /// Takes a schedule on trust, for the tests of the stages that come after this one.
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
    /// The verified schedule; what speaks against it is pushed.
    pub fn accepted(self, sink: &mut Sink) -> Option<Verified> {
        match self {
            Verdict::Accepted(verified) => return Some(verified),
            Verdict::Rejected(violations) => violations.into_iter().for_each(|violation| sink.push(violation.into())),
            Verdict::Inconclusive { why } => sink.push(inconclusive(&why)),
        }
        None
    }
}

/// Checks a schedule against its program: the claims, which were derived from the files of `sources`, and the files themselves for
/// the texts of its steps.
///
/// Claims of the checker can always be judged; [`Verdict::Inconclusive`] results only from claims from elsewhere.
pub fn verify_program(schedule: Schedule, claims: &Claims, sources: &Sources) -> Verdict {
    let tally = Rc::new(Tally::default());
    let found =
        judge(&schedule, claims, &tally).map(|found| with_source_map(found, &schedule, claims, sources, &tally));
    verdict(found, schedule, claims, &tally)
}

fn verdict(found: Result<Vec<Violation>, Unfit>, schedule: Schedule, claims: &Claims, tally: &Tally) -> Verdict {
    match found {
        Err(Unfit(why)) => Verdict::Inconclusive { why },
        Ok(violations) if violations.is_empty() => {
            Verdict::Accepted(Verified { held: Box::new((schedule, claims.clone(), tally.evidence())) })
        }
        Ok(violations) => {
            // What breaks a rule was counted before.
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

/// Violations of the claims of another program than the schedule's own; texts of steps are not compared.
///
/// # Errors
/// Why no schedule can be checked against the claims.
pub fn violations(schedule: &Schedule, claims: &Claims) -> Result<Vec<Violation>, String> {
    judge(schedule, claims, &Rc::default()).map_err(|Unfit(why)| why)
}

/// Whether the parts of a schedule fit together and to its claims, whatever else it breaks: its indices, numbers, channels, runs and steps.
pub fn is_whole(schedule: &Schedule, claims: &Claims) -> bool {
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

/// The diagnostic for claims against which no schedule can be checked.
pub fn inconclusive(why: &str) -> Diagnostic {
    Diagnostic::new(Code::E0740, format!("the claims cannot be judged by: {why}"))
}

/// Why claims cannot be judged by.
#[derive(Debug)]
struct Unfit(String);

/// Why a run cannot be followed to its end.
#[derive(Debug)]
enum Halt {
    Unfit(Unfit),
    /// The state after this is unknown, so the device is not followed further.
    Broken(Box<Violation>),
}

impl From<Unfit> for Halt {
    fn from(unfit: Unfit) -> Halt {
        Halt::Unfit(unfit)
    }
}

impl From<Violation> for Halt {
    fn from(violation: Violation) -> Halt {
        Halt::Broken(Box::new(violation))
    }
}

/// Result of the replay of a run.
#[derive(Debug)]
struct Replay<'a> {
    /// At the beginning and after every change. Borrowed from the record where the two are equal.
    states: Vec<Cow<'a, TimedState>>,
    /// Every outcome that the kind knows, in SI units.
    outcomes: BTreeMap<&'static str, f64>,
    /// Of each step in which several take place at the same time, in the order of the program.
    operations: BTreeMap<usize, Vec<JudgedOperation>>,
}

/// An operation as it was replayed.
#[derive(Debug)]
struct JudgedOperation {
    parts: Vec<String>,
    /// When the first of its parts is free for it, when all are where it takes place, and when it is done.
    times_ns: [u64; 3],
    span: Span,
}

/// Terms of a plan's record, from the claims.
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

/// Where each device stands.
type Standing<'a> = BTreeMap<&'a str, State>;

/// What a kind brings to this stage, on its orders.
trait Judge {
    /// What the numbers of a channel are; `None` if the device has no channel of that name.
    fn unit(&self, channel: &str) -> Option<ChannelUnit>;

    /// Whether its channels may swing between two values.
    fn swings(&self) -> bool {
        false
    }

    /// Asks what the replay takes for granted of the claims.
    fn premise(&self) -> Result<(), Unfit>;

    /// Whether another order of the device holds the same facts about it.
    fn has_facts_of(&self, other: &Order) -> bool;

    /// Whether another order of the device knows the same parts on it, from one run to the next.
    fn has_parts_of(&self, _other: &Order) -> bool {
        true
    }

    /// The forces on what is held in a state, if the kind holds anything by forces; see [`forces`].
    fn forces(&self, _state: &State) -> Option<Vec<Option<[f64; 3]>>> {
        None
    }

    /// What the claims say of a plan's record.
    fn terms(&self) -> RecordTerms;

    /// What `minimize` takes to bring an outcome down, if anything.
    fn minimized_as(&self, outcome: &str) -> Option<&'static str>;

    /// Holds a run against the order. Afterwards `standing` has where the device is.
    ///
    /// # Errors
    /// At the first thing that leaves it unknown what comes after.
    fn replay<'a>(
        &self,
        run: &JudgedRun<'a>,
        claims: &Claims,
        standing: &mut Standing<'a>,
        findings: &mut Findings,
    ) -> Result<Replay<'a>, Halt>;

    /// Holds the program's devices of the kind against one another; asked once. `order` are the runs in the order in which devices
    /// meet them.
    fn beside(&self, _runs: &[JudgedRun], _order: &[usize], _claims: &Claims, _findings: &mut Findings) {}
}

/// The force of each finger on the part that they hold in a state, along the axes of the device and in micronewtons; `None` for a finger that
/// is free, or at all where nothing is held or no forces balance.
pub fn forces(order: &Order, state: &State) -> Option<Vec<Option<[f64; 3]>>> {
    judge_of(order).forces(state)
}

/// The judge of an order.
fn judge_of(order: &Order) -> &dyn Judge {
    each_kind!(Order, order, order => order)
}

/// What a kind brings to this stage, on its states.
trait JudgedState {
    /// Whether a replayed state is this recorded one, but for rounding.
    fn agrees(&self, replayed: &State) -> bool;

    /// The state in words.
    fn shown(&self) -> String;
}

/// The judge of a recorded or replayed state.
fn judged_state(state: &State) -> &dyn JudgedState {
    each_kind!(State, state, state => state)
}

fn judge(schedule: &Schedule, claims: &Claims, tally: &Rc<Tally>) -> Result<Vec<Violation>, Unfit> {
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
    let mut standing = Standing::new();
    let mut lost = BTreeSet::new();
    let due = clock::timeline(schedule, &runs, claims, &mut findings);
    let order: Vec<usize> = due.iter().filter_map(|stretch| stretch.job).collect();
    outputs::check(schedule, &runs, claims, &mut findings);
    holds::check(schedule, &runs, &due, claims, &mut findings);
    for job in claims.first_of_kinds() {
        judge_of(&job.order).beside(&runs, &order, claims, &mut findings);
    }
    for index in order {
        let run = &runs[index];
        if lost.contains(run.job.device.as_str()) {
            continue;
        }
        tally.asked(Rule::Start, 1);
        tally.asked(Rule::State, run.plan.states.len().max(1));
        match judge_of(&run.job.order).replay(run, claims, &mut standing, &mut findings) {
            Ok(replay) => record::check(run, &replay, &mut findings),
            Err(Halt::Unfit(unfit)) => return Err(unfit),
            Err(Halt::Broken(violation)) => {
                findings.push(*violation);
                lost.insert(run.job.device.as_str());
            }
        }
    }
    Ok(findings.sorted())
}

#[cfg(test)]
mod tests;
