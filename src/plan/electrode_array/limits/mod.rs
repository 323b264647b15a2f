//! The limits of a task as numbers of steps, costs and moves, and the report if no plan is known to keep them.

pub mod labels;
pub mod limited;

use self::labels::{BoardFigures, PlanLimits};
use self::limited::{PlanFront, UNLIMITED, exceeds};
use super::board::{BoardCosts, Paths};
use super::motion::{ElectrodeArrayMotion, ElectrodeArrayStepMotion};
use crate::claims::electrode_array::{ElectrodeArrayAction, ElectrodeArrayOrder};
use crate::claims::{Relation, Requirement};
use crate::device::Kind;
use crate::device::electrode_array::ElectrodeArrayOutcome;
use crate::diagnostic::{Code, Diagnostic};
use crate::plan::requirements::{Kept, enough, keeps, show};
use crate::quantity::Dimension;
use std::collections::BTreeMap;

/// Greatest figure considered; larger limits count as no limit.
const MOST_COUNTED: u64 = 1 << 40;

/// Index of the figure that determines an outcome.
fn figure(outcome: &str) -> Option<usize> {
    ElectrodeArrayOutcome::find(outcome).map(|outcome| match outcome {
        ElectrodeArrayOutcome::Steps | ElectrodeArrayOutcome::Time => 0,
        ElectrodeArrayOutcome::SumOfCosts => 1,
        ElectrodeArrayOutcome::Moves => 2,
    })
}

/// Duration in seconds of a task of `steps` steps, including its waits.
pub fn seconds(order: &ElectrodeArrayOrder, steps: u64) -> f64 {
    let waits_ns = order.steps.iter().map(|step| match step.action {
        ElectrodeArrayAction::Wait(duration_ns) => u128::from(duration_ns),
        ElectrodeArrayAction::Move(_) | ElectrodeArrayAction::Assay(_) => 0,
    });
    (u128::from(steps) * u128::from(order.facts.step_ns) + waits_ns.sum::<u128>()) as f64 / 1e9
}

/// The least value of an outcome, from lower bounds on the steps and the sum of costs; `None` if these do not bound it.
pub fn least(order: &ElectrodeArrayOrder, outcome: &str, bounds: BoardCosts) -> Option<f64> {
    let figure = [Some(bounds.makespan), Some(bounds.sum_of_costs), None][figure(outcome)?]?;
    Some(value(order, outcome, figure))
}

/// The value of an outcome for a figure.
fn value(order: &ElectrodeArrayOrder, outcome: &str, figure: u64) -> f64 {
    if outcome == ElectrodeArrayOutcome::Time.name() { seconds(order, figure) } else { figure as f64 }
}

/// Limits on the figures from the requirements of a task; time is converted to steps.
pub fn of<'r>(order: &ElectrodeArrayOrder, requirements: impl IntoIterator<Item = &'r Requirement>) -> PlanLimits {
    let mut limits = PlanLimits { most: [UNLIMITED; 3], least: [0; 3] };
    for requirement in requirements {
        let Some(figure) = figure(&requirement.outcome) else { continue };
        let (least, most) = allowed(order, requirement);
        limits.least[figure] = limits.least[figure].max(least);
        limits.most[figure] = limits.most[figure].min(most);
    }
    limits
}

/// The least and the greatest value that a requirement allows; if it allows none, the least is above the greatest.
fn allowed(order: &ElectrodeArrayOrder, requirement: &Requirement) -> (u64, u64) {
    let first = |relation: Relation, wanted: Kept| {
        let asked = Requirement { relation, ..requirement.clone() };
        let (mut low, mut high) = (0, MOST_COUNTED);
        while low < high {
            let middle = low + (high - low) / 2;
            if keeps(&asked, value(order, &requirement.outcome, middle)) == wanted {
                high = middle;
            } else {
                low = middle + 1;
            }
        }
        low
    };
    let most = |first_not: u64| match first_not {
        MOST_COUNTED.. => UNLIMITED,
        first_not => first_not.saturating_sub(1),
    };
    let below = |relation| {
        let first_not = first(relation, Kept::No);
        (u64::from(first_not == 0), most(first_not))
    };
    match requirement.relation {
        Relation::Less => below(Relation::Less),
        Relation::AtMost => below(Relation::AtMost),
        Relation::AtLeast => (first(Relation::AtLeast, Kept::Yes), UNLIMITED),
        Relation::More => (first(Relation::More, Kept::Yes), UNLIMITED),
        Relation::Equal => {
            let (least, most) = below(Relation::AtMost);
            (least.max(first(Relation::AtLeast, Kept::Yes)), most)
        }
    }
}

/// The limits lifted: figures that had an upper limit get a very large one, so that plans still differ in them.
pub fn lifted(limits: PlanLimits) -> PlanLimits {
    let lift = |most| if most == UNLIMITED { UNLIMITED } else { MOST_COUNTED };
    PlanLimits { most: limits.most.map(lift), least: [0; 3] }
}

/// Sum of some costs, each figure on its own.
pub fn total(costs: impl Iterator<Item = BoardCosts>) -> BoardCosts {
    costs.fold(BoardCosts::default(), |sum, own| BoardCosts {
        makespan: sum.makespan + own.makespan,
        sum_of_costs: sum.sum_of_costs + own.sum_of_costs,
    })
}

/// Sum of the figures of several plans.
pub fn figures<'p>(plans: impl Iterator<Item = &'p Paths>) -> BoardFigures {
    plans.map(limited::figures).fold([0; 3], |sum, own| [0, 1, 2].map(|figure: usize| sum[figure] + own[figure]))
}

/// Whether figures violate limits.
pub fn breaks(figures: BoardFigures, limits: PlanLimits) -> bool {
    exceeds(figures, limits.most) || exceeds(limits.least, figures)
}

/// Reports that no plan is known to keep the limits. `fronts` were searched within the limits and `wider` without them.
pub fn broken(
    order: &ElectrodeArrayOrder,
    requirements: &[Requirement],
    [fronts, wider]: [&[PlanFront]; 2],
    is_proven: bool,
) -> Diagnostic {
    let texts: Vec<String> = requirements.iter().map(|requirement| format!("`{}`", text(requirement))).collect();
    let all = match texts.as_slice() {
        [one] => one.clone(),
        [before @ .., last] => format!("{} and {last}", before.join(", ")),
        [] => String::new(),
    };
    let title = if is_proven { format!("no plan keeps {all}") } else { format!("no plan was found that keeps {all}") };
    let mut diagnostic = Diagnostic::new(Code::E0603, title);
    let bounds = fronts
        .iter()
        .fold([0; 3], |sum: BoardFigures, front| [0, 1, 2].map(|figure: usize| sum[figure] + front.bounds[figure]));
    for requirement in requirements {
        diagnostic = diagnostic.label(requirement.span, label(order, requirement, bounds));
    }
    let diagnostic = diagnostic.help_if(help(order, requirements, wider));
    match is_proven {
        true => diagnostic.with_weaker_form(broken(order, requirements, [&[], wider], false)),
        false => diagnostic,
    }
}

fn label(order: &ElectrodeArrayOrder, requirement: &Requirement, bounds: BoardFigures) -> String {
    let bound = figure(&requirement.outcome)
        .map(|figure| bounds[figure])
        .filter(|bound| *bound > allowed(order, requirement).1);
    match bound {
        Some(bound) => format!("no plan has less than {}", shown(order, requirement, bound)),
        None => "this limit".to_owned(),
    }
}

/// Help text that names each limit that could be raised alone, and its value, according to the known plans.
fn help(order: &ElectrodeArrayOrder, requirements: &[Requirement], wider: &[PlanFront]) -> Option<String> {
    let raises = requirements.iter().enumerate().filter_map(|(index, requirement)| {
        let rest = requirements.iter().enumerate().filter(|(other, _)| *other != index).map(|(_, other)| other);
        let figure = figure(&requirement.outcome)?;
        let enough = limited::least_known(wider, of(order, rest), figure)?;
        let limit = if requirement.relation == Relation::Less { enough + 1 } else { enough };
        (enough > allowed(order, requirement).1).then(|| {
            let name =
                if requirements.len() == 1 { "the limit".to_owned() } else { format!("`{}`", requirement.outcome) };
            format!("{name} to {}", shown(order, requirement, limit))
        })
    });
    let raises: Vec<String> = raises.collect();
    let plans = if raises.len() > 1 { "plans within these limits are known" } else { "a plan within it is known" };
    (!raises.is_empty()).then(|| format!("raise {}: {plans}", raises.join(", or ")))
}

/// A requirement in source form.
fn text(requirement: &Requirement) -> String {
    let sign = requirement.relation.sign();
    format!("{} {sign} {}", requirement.outcome, show(requirement.limit, dimension(&requirement.outcome)))
}

fn shown(order: &ElectrodeArrayOrder, requirement: &Requirement, figure: u64) -> String {
    enough(value(order, &requirement.outcome, figure), dimension(&requirement.outcome))
}

fn dimension(outcome: &str) -> Dimension {
    let known = Kind::ElectrodeArray.vocabulary().outcomes.iter().find(|known| known.name == outcome);
    known.map_or(Dimension::NUMBER, |known| known.unit.dimension())
}

/// The figures of a plan, by their names.
pub fn outcomes(order: &ElectrodeArrayOrder, motion: &ElectrodeArrayMotion) -> BTreeMap<String, f64> {
    let sum = |sum: [usize; 3], step: &ElectrodeArrayStepMotion| {
        let own = step.figures();
        [0, 1, 2].map(|figure: usize| sum[figure] + own[figure])
    };
    let [steps, sum_of_costs, moves] = motion.steps.iter().fold([0; 3], sum);
    let figures = [
        (ElectrodeArrayOutcome::Steps, steps as f64),
        (ElectrodeArrayOutcome::SumOfCosts, sum_of_costs as f64),
        (ElectrodeArrayOutcome::Moves, moves as f64),
        (ElectrodeArrayOutcome::Time, seconds(order, steps as u64)),
    ];
    figures.into_iter().map(|(word, value)| (word.name().to_owned(), value)).collect()
}
