//! The conditions of a task held against the outcome of its plan.

use super::{Optimality, Plan, errors};
use crate::check::claims::{Job, Relation, Requirement};
use crate::diagnostic::Sink;
use crate::quantity::{Dimension, Quantity};

/// How far a sum of floats may stray from a limit that it meets exactly, relative to the limit.
const REQUIREMENT_TOLERANCE: f64 = 1e-9;

/// Whether an outcome meets its requirement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kept {
    Yes,
    No,
}

/// Holds an outcome against a requirement.
pub fn keeps(requirement: &Requirement, reached: f64) -> Kept {
    let slack = requirement.limit.abs() * REQUIREMENT_TOLERANCE;
    let holds = match requirement.relation {
        Relation::Less => reached < requirement.limit - slack,
        Relation::AtMost => reached <= requirement.limit + slack,
        Relation::Equal => (reached - requirement.limit).abs() <= slack,
        Relation::AtLeast => reached >= requirement.limit - slack,
        Relation::More => reached > requirement.limit + slack,
    };
    if holds { Kept::Yes } else { Kept::No }
}

/// Whether a plan meets all requirements of its job; those that it misses are reported.
///
/// `best` answers with a plan that minimises an outcome instead, if the kind knows how; it is asked for each missed limit from
/// above, so that the message can say which limit would do.
pub fn require(job: &Job, plan: &Plan, best: &mut dyn FnMut(&str) -> Option<Plan>, sink: &mut Sink) -> Kept {
    let mut all_kept = Kept::Yes;
    for requirement in &job.requirements {
        let Some(&reached) = plan.outcomes.get(&requirement.outcome) else { continue };
        if keeps(requirement, reached) == Kept::Yes {
            continue;
        }
        all_kept = Kept::No;
        let wants_less = matches!(requirement.relation, Relation::Less | Relation::AtMost);
        let best = if wants_less { best(&requirement.outcome) } else { None };
        let help = best.and_then(|best| best_instead(job, requirement, &best));
        let (reached, limit) = (shown(job, requirement, reached), shown(job, requirement, requirement.limit));
        sink.push(errors::requirement_missed(requirement, &reached, &limit, help));
    }
    all_kept
}

fn shown(job: &Job, requirement: &Requirement, value: f64) -> String {
    let outcomes = job.kind().vocabulary().outcomes;
    let known = outcomes.iter().find(|known| known.name == requirement.outcome);
    Quantity::new(value, known.map_or(Dimension::NUMBER, |known| known.dimension)).to_string()
}

/// What the plan reaches that minimises the missed figure itself.
fn best_instead(job: &Job, requirement: &Requirement, best: &Plan) -> Option<String> {
    let name = &requirement.outcome;
    let reached = *best.outcomes.get(name)?;
    let text = shown(job, requirement, reached);
    Some(match (keeps(requirement, reached), best.proof) {
        (Kept::Yes, _) => format!("`minimize {}` finds a plan of {text}", best.objective),
        (Kept::No, Optimality::Proven) => format!("no plan does better: raise the limit to {text}"),
        (Kept::No, Optimality::Open) => format!("the best plan found for `minimize {}` has {text}", best.objective),
    })
}
