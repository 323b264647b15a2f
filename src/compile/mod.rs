//! Calls the stages in order, from a program's text to verified schedules.

mod partial;

pub use partial::{PartialBuild, partial};

pub use crate::check::{ProgramSource, check_program};

use crate::check::{Checked, DeclarationTally};
use crate::claims::Claims;
use crate::diagnostic::Sink;
use crate::lower::lower;
use crate::plan::{self, Motion, Plan, Progress};
use crate::schedule::Schedule;
use crate::source::Sources;
use crate::verify::{self, Verified};

/// A compiled program.
pub struct Compiled {
    pub tally: DeclarationTally,
    /// In the order of declaration.
    pub schedules: Vec<Verified>,
}

/// Result of a compilation.
pub enum CompileOutcome {
    Compiled(Compiled),
    /// The program has errors; they were pushed.
    Errors,
    /// The verifier refused a schedule: a fault of the planner, not of the program. The violations were pushed.
    Refused,
}

/// Receives the progress of a compilation.
pub trait CompileObserver {
    /// The program has no errors.
    fn checked(&mut self, _checked: &Checked) {}

    /// A run of a schedule is about to be planned: index, number of runs, task.
    fn planning(&mut self, _index: usize, _count: usize, _task: &str) {}

    /// All runs of a schedule are planned and timed.
    fn scheduled(&mut self, _schedule: &Schedule, _claims: &Claims) {}

    /// The verifier accepted a schedule.
    fn verified(&mut self, _verified: &Verified) {}
}

/// An observer that ignores everything.
impl CompileObserver for () {}

/// Plans of a schedule's jobs, with the schedule that the verifier accepted.
pub struct VerifiedPlans<'a> {
    pub plans: Vec<Plan<Motion<'a>>>,
    pub verified: Verified,
}

/// Plans one schedule of a program and times it, without verification; `None` if it has no plan, in which case the
/// errors were pushed.
pub fn planned<'a>(
    claims: &'a Claims,
    sources: &Sources,
    sink: &mut Sink,
    progress: Progress,
) -> Option<(Vec<Plan<Motion<'a>>>, Schedule)> {
    let plans = plan::plan(claims, sink, progress)?;
    let schedule = lower(claims, &plans, sources, sink)?;
    Some((plans, schedule))
}

/// Plans, schedules and verifies one schedule of a program.
///
/// # Errors
/// [`CompileOutcome::Errors`] or [`CompileOutcome::Refused`]; the diagnostics were pushed.
pub fn verified_plans<'a>(
    claims: &'a Claims,
    sources: &Sources,
    sink: &mut Sink,
    progress: Progress,
) -> Result<VerifiedPlans<'a>, CompileOutcome> {
    let (plans, schedule) = planned(claims, sources, sink, progress).ok_or(CompileOutcome::Errors)?;
    let verified =
        verify::verify_program(schedule, claims, sources).into_verified(sink).ok_or(CompileOutcome::Refused)?;
    Ok(VerifiedPlans { plans, verified })
}

/// Reads, checks, plans, schedules and verifies a program.
pub fn compile(
    program: &ProgramSource,
    sources: &mut Sources,
    sink: &mut Sink,
    observer: &mut dyn CompileObserver,
) -> CompileOutcome {
    let Some(checked) = check_program(program, sources, sink) else { return CompileOutcome::Errors };
    observer.checked(&checked);
    let mut drafts = Vec::with_capacity(checked.claims.len());
    for claims in &checked.claims {
        let progress = &mut |index, count, task: &str| observer.planning(index, count, task);
        let Some((_, draft)) = planned(claims, sources, sink, progress) else { continue };
        observer.scheduled(&draft, claims);
        drafts.push((draft, claims));
    }
    if drafts.len() < checked.claims.len() {
        return CompileOutcome::Errors;
    }
    let mut schedules = Vec::with_capacity(drafts.len());
    for (schedule, claims) in drafts {
        let Some(verified) = verify::verify_program(schedule, claims, sources).into_verified(sink) else { continue };
        observer.verified(&verified);
        schedules.push(verified);
    }
    if schedules.len() < checked.claims.len() {
        return CompileOutcome::Refused;
    }
    CompileOutcome::Compiled(Compiled { tally: checked.tally, schedules })
}
