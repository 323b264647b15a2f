//! What there is to see of a program that cannot be built: as much of it as is without a fault, planned and verified.

use super::{ProgramSource, check_program, verified_plans};
use crate::check::imports;
use crate::check::reduced::{LeftOut, leave_out, leave_out_all_steps};
use crate::check::{self as checker, Checked};
use crate::claims::Claims;
use crate::diagnostic::{Sink, WrittenPlace};
use crate::source::{Sources, Span};
use crate::verify::Verified;

/// Rounds in which faults are left out, since what remains may have faults that were hidden before; in the last one no task has a step.
const MAX_ROUNDS: usize = 4;

/// Part of a program that could be built.
pub struct PartialBuild {
    /// One schedule of the program without the parts at fault: of each task at fault, what comes before the first such step.
    pub verified: Verified,
    /// The claims of the same schedule in the whole program, where all of them could be made.
    pub whole: Option<Claims>,
    /// The places in the scene that the parts at fault are about.
    pub places: Vec<WrittenPlace>,
}

/// Builds the rest of a program whose errors are known; `None` where nothing of it can be shown. The places of what is built, and of the
/// errors, are those of the same program's sources.
pub fn partial(program: &ProgramSource, errors: &Sink) -> Option<PartialBuild> {
    let mut faults = first_places(errors);
    let mut places = Vec::new();
    for round in 1..=MAX_ROUNDS {
        let (mut sources, mut sink) = (Sources::default(), Sink::default());
        // What cannot be read is no part of the trees: its errors are known.
        let mut modules =
            imports::load(&mut sources, program.name, program.text, program.library, &mut Sink::default());
        let mut left_out = leave_out(&mut modules, &faults);
        if round == 1 {
            places = std::mem::take(&mut left_out.places);
        }
        if round == MAX_ROUNDS {
            left_out.tasks.extend(leave_out_all_steps(&mut modules).tasks);
        }
        if let Some(checked) = checker::check(&mut sources, &modules, program.options, &mut sink) {
            let claims = shown(&checked, &left_out)?;
            if let Ok(plans) = verified_plans(claims, &sources, &mut sink, &mut |_, _, _| {}) {
                return Some(PartialBuild { verified: plans.verified, whole: whole(program, &claims.name), places });
            }
        }
        faults.extend(first_places(&sink));
    }
    None
}

/// Where each error points to.
fn first_places(errors: &Sink) -> Vec<Span> {
    errors.sorted().into_iter().filter(|error| error.is_error()).filter_map(|error| error.span()).collect()
}

/// The schedule to be shown: the first in which something was left out.
fn shown<'a>(checked: &'a Checked, left_out: &LeftOut) -> Option<&'a Claims> {
    let lacks = |claims: &&Claims| claims.jobs.iter().any(|job| left_out.tasks.contains(&job.span));
    checked.claims.iter().find(lacks).or(checked.claims.first())
}

/// The claims of the whole program for a schedule.
fn whole(program: &ProgramSource, name: &str) -> Option<Claims> {
    let checked = check_program(program, &mut Sources::default(), &mut Sink::default())?;
    checked.claims.into_iter().find(|claims| claims.name == name)
}
