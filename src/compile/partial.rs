//! Partial builds of a program with errors: as much of it as is without a fault, planned and verified.

use super::{ProgramSource, check_program, verified_plans};
use crate::check::imports;
use crate::check::reduced::{LeftOut, leave_out, leave_out_all_steps};
use crate::check::{self as checker, Checked};
use crate::claims::Claims;
use crate::diagnostic::{Sink, WrittenPlace};
use crate::source::{Sources, Span};
use crate::verify::Verified;

/// Rounds of leaving out faults: what remains may have faults that were hidden before. In the last round no task has
/// a step.
const MAX_ROUNDS: usize = 4;

/// The part of a program that could be built.
pub struct PartialBuild {
    /// One schedule of the program without the faulty parts: of each faulty task, the steps before the first fault.
    pub verified: Verified,
    /// The claims of the same schedule in the whole program, if all of them could be made.
    pub whole: Option<Claims>,
    /// The positions in the scene that the faulty parts refer to.
    pub places: Vec<WrittenPlace>,
}

/// Builds the rest of a program whose errors are known; `None` if nothing of it can be shown. All places, of what is
/// built and of the errors, refer to the sources of the same program.
pub fn partial(program: &ProgramSource, errors: &Sink) -> Option<PartialBuild> {
    let mut faults = first_places(errors);
    let mut places = Vec::new();
    for round in 1..=MAX_ROUNDS {
        let (mut sources, mut sink) = (Sources::default(), Sink::default());
        // Parts that cannot be parsed are missing from the trees; their errors are known already.
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

/// The primary span of each error.
fn first_places(errors: &Sink) -> Vec<Span> {
    errors.sorted().into_iter().filter(|error| error.is_error()).filter_map(|error| error.span()).collect()
}

/// The schedule to be shown: the first in which something was left out, or else the first.
fn shown<'a>(checked: &'a Checked, left_out: &LeftOut) -> Option<&'a Claims> {
    let lacks = |claims: &&Claims| claims.jobs.iter().any(|job| left_out.tasks.contains(&job.span));
    checked.claims.iter().find(lacks).or(checked.claims.first())
}

/// The claims of a schedule in the whole program, by name.
fn whole(program: &ProgramSource, name: &str) -> Option<Claims> {
    let checked = check_program(program, &mut Sources::default(), &mut Sink::default())?;
    checked.claims.into_iter().find(|claims| claims.name == name)
}
