//! Plans programs given as text and verifies each plan.

use tweeze::check::Options;
use tweeze::check::imports::NoFiles;
use tweeze::claims::Claims;
use tweeze::compile::{self, ProgramSource};
use tweeze::diagnostic::Sink;
use tweeze::lower::lower;
use tweeze::plan::{self, Plan};
use tweeze::source::Sources;
use tweeze::verify::{self, Verdict};

/// Result for the only task of a program.
#[derive(Debug)]
pub enum Answered {
    Plan(Box<Plan<()>>),
    /// The planner's errors, each with its code and help.
    Errors(Vec<String>),
    /// The program itself has errors.
    Unfit,
}

/// The claims of the only task of a program, with sources and diagnostics; `None` if it has errors.
pub fn checked(text: &str) -> Option<(Claims, Sources, Sink)> {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let options = Options::default();
    let program = ProgramSource { name: "task.twz", text, library: &NoFiles, options: &options };
    let mut checked = compile::check_program(&program, &mut sources, &mut sink)?;
    assert_eq!(checked.claims.len(), 1, "one task: {text}");
    Some((checked.claims.pop()?, sources, sink))
}

pub fn answered(text: &str) -> Answered {
    let Some((claims, sources, mut sink)) = checked(text) else { return Answered::Unfit };
    let claims = &claims;
    let plans = plan::plan(claims, &mut sink, &mut |_, _, _| {});
    match plans {
        Some(mut plans) => {
            let schedule = lower(claims, &plans, &sources, &mut sink).expect("a schedule");
            let verdict = verify::verify_program(schedule, claims, &sources);
            assert!(matches!(verdict, Verdict::Accepted(_)), "{verdict:?}\n{text}");
            Answered::Plan(Box::new(plans.remove(0).map(drop)))
        }
        None => Answered::Errors(
            sink.sorted()
                .into_iter()
                .map(|reported| {
                    format!("{:?}: {}; {}", reported.code, reported.title, reported.help.as_deref().unwrap_or(""))
                })
                .collect(),
        ),
    }
}
