//! Error reports of planning: E06xx.

use crate::claims::{Relation, Requirement};
use crate::device::MAX_EXPANSIONS;
use crate::diagnostic::{Code, Diagnostic};
use crate::quantity::count;
use crate::source::Span;

/// Most obstacles that one report labels.
const MAX_LABELS: usize = 8;

/// Known effect of removing the blamed obstacles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Removal {
    OpensAndIsSmallest,
    Opens,
    Unknown,
}

/// A step between two places, for a message.
pub struct StepEnds<'a> {
    pub step: Span,
    pub from: &'a str,
    pub to: &'a str,
}

/// Finding about a missed limit. Values are of the outcome, in SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LimitVerdict {
    /// Proven: the least value of all plans that keep the other limits, and some plan attains it.
    Least(f64),
    /// Proven lower bound for plans that keep the other limits; then the value of the best plan found, if it keeps them.
    AtLeast(f64, Option<f64>),
    /// Proven, without a value of its own: the limits exclude one another.
    Conflict,
    /// No plan was found, and nothing is proven.
    NotFound,
    /// No plan was found for this objective, but `minimize` with the other objective finds one that keeps all limits.
    Elsewhere(&'static str, f64),
}

impl LimitVerdict {
    /// Whether no plan keeps all limits.
    pub fn is_proven(self) -> bool {
        match self {
            LimitVerdict::Least(_) | LimitVerdict::AtLeast(..) | LimitVerdict::Conflict => true,
            LimitVerdict::NotFound | LimitVerdict::Elsewhere(..) => false,
        }
    }
}

/// Formatted figures for the report of a missed limit.
pub struct LimitTexts {
    pub reached: String,
    pub limit: String,
    /// Value of the verdict.
    pub value: String,
    /// Rounded up, so that a limit of this value is kept.
    pub enough: String,
    /// Rounded down, so that it remains a lower bound.
    pub floor: String,
}

pub fn impossible(ends: StepEnds, proof: &str, blamed: &[(&str, Span)], removal: Removal) -> Diagnostic {
    let StepEnds { step, from, to } = ends;
    let mut diagnostic =
        Diagnostic::new(Code::E0601, format!("no plan leads from {from} to {to}")).label(step, proof.to_owned());
    let mut labelled: Vec<Span> = vec![step];
    for (_, span) in blamed {
        if !labelled.contains(span) && labelled.len() <= MAX_LABELS {
            diagnostic = diagnostic.label(*span, "in the way");
            labelled.push(*span);
        }
    }
    diagnostic.help_if(removal_help(blamed, removal))
}

/// Up to `most` names and the number left out: `` `a`, `b` and 3 more ``.
pub fn listed(names: impl IntoIterator<Item = String>, most: usize) -> String {
    let mut names: Vec<String> = names.into_iter().collect();
    let more = names.len().saturating_sub(most);
    names.truncate(most);
    let rest = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("{}{rest}", names.join(", "))
}

fn removal_help(blamed: &[(&str, Span)], removal: Removal) -> Option<String> {
    let names = listed(blamed.iter().map(|(name, _)| format!("`{name}`")), MAX_LABELS);
    match (removal, blamed.len()) {
        (_, 0) => None,
        (Removal::OpensAndIsSmallest, 1) => Some(format!("there is a path without {names}")),
        (Removal::OpensAndIsSmallest, _) => {
            Some(format!("there is a path without {names}, but not without fewer of them"))
        }
        (Removal::Opens, _) => Some(format!("there is a path without {names}, the smallest set found")),
        (Removal::Unknown, _) => Some(format!(
            "the way is blocked by {names}; other obstacles may block it too, since the search for the smallest set \
             ran out of steps"
        )),
    }
}

pub fn gave_up(step: Span, to: &str, what: &str, budget: u64, bound: &str, planner: &str) -> Diagnostic {
    Diagnostic::new(Code::E0602, format!("{what} gave up after {}", count(budget, "expansion")))
        .label(step, undecided(to, bound))
        .help(more_allowed(budget, planner))
}

fn undecided(to: &str, bound: &str) -> String {
    format!("a path to {to} was neither found nor proven impossible; none costs less than {bound}")
}

/// Report of an assay whose search ended without a plan and with budget left. `avoids`: the task keeps the traces of
/// droplets apart, and so has a single assay.
pub fn nothing_left_to_try(step: Span, to: &str, bound: u64, avoids: bool) -> Diagnostic {
    let help = if avoids {
        "give droplets that must not touch each other's traces separate paths, or send a wash over the cells that both \
         cross, `after` the operation that soils them"
    } else {
        "move parts away from places that others need, with `move PART to CELL`, or split the operations into several \
         `assay` steps"
    };
    Diagnostic::new(Code::E0602, "the search found no plan and has nothing left to try")
        .label(step, undecided(to, &count(bound, "step")))
        .help(format!("a larger budget is unlikely to help: {help}"))
}

/// Report of a greedy planner that gave up; its failure proves nothing. `first` begins the help: what Tweeze's own
/// planner needs before it can plan this, such as another field.
pub fn greedy_gave_up(asked: Span, part: &str, at: &str, steps: usize, how: &str, first: &str) -> Diagnostic {
    let steps = count(steps, "step");
    Diagnostic::new(Code::E0602, format!("the greedy planner leaves `{part}` {how} at {at} after {steps}"))
        .label(asked, "neither planned nor proven impossible")
        .help(format!("{first}leave `using` out: Tweeze's own planner searches all plans within its budget"))
}

fn all_of(names: &[&str]) -> String {
    match names {
        [one, other] => format!("`{one}` and `{other}`"),
        _ => listed(names.iter().map(|name| format!("`{name}`")), MAX_LABELS),
    }
}

/// Report of a part whose own ways and stays take longer than the time within which it must do its next operation.
pub fn too_far_in_time(step: Span, part: &str) -> Diagnostic {
    Diagnostic::new(Code::E0601, format!("no plan: the paths and stays of `{part}` take longer than `within` allows"))
        .label(step, "this takes too long even with no other part on the board")
        .help("allow more time, choose places that are closer together, or shorten the operations in between")
}

/// Report of a part whose mixing loop leaves the board.
pub fn loop_off_board(step: Span, part: &str) -> Diagnostic {
    Diagnostic::new(Code::E0601, format!("no plan: the mixing loop of `{part}` leaves the board"))
        .label(step, "the loop begins where the part then stands")
        .help("name the cell where mixing begins: `mix PART at (5, 3) for 3 s`")
}

/// Extends the reason why the first of `count` choices of places has no plan: none of the others has one either.
pub fn of_first_arrangement(diagnostic: Diagnostic, count: usize) -> Diagnostic {
    if count == 1 {
        return diagnostic;
    }
    let all = format!("none of the {count} choices of places has a plan; this is the reason for the first");
    let help = diagnostic.help.as_ref().map_or(all.clone(), |own| format!("{own}; {all}"));
    diagnostic.help(help)
}

/// Report of parts that keep one another from their operations in every order. `is_timed`: some operations must follow
/// others within a time.
pub fn operations_exclude_one_another(step: Span, parts: &[&str], is_timed: bool) -> Diagnostic {
    let all = all_of(parts);
    let title = match (is_timed, parts) {
        (true, _) => format!("no plan: {all} cannot do these operations in time in any order"),
        (false, [_]) => format!("no plan: {all} cannot do these operations in any order"),
        (false, _) => format!("no plan: {all} keep one another from these operations in every order"),
    };
    let help = "`discard` a part that is done, do some of the operations in an assay or a `move` of their own before \
                this one, or give goals more room";
    let timed = "allow more time, or let the earlier operation take place elsewhere: where the part already stands, it \
                 begins at once and is not delayed for a `within`";
    let searched = "all positions of all parts together were searched";
    Diagnostic::new(Code::E0601, title).label(step, searched).help(if is_timed { timed } else { help })
}

/// Labels the first parts, each place once; labels the step if there is no part.
fn labelled(
    mut diagnostic: Diagnostic,
    step: Span,
    parts: &[(&str, Span)],
    says: impl Fn(&str) -> String,
) -> Diagnostic {
    for (name, span) in parts.iter().take(MAX_LABELS) {
        if diagnostic.labels.iter().all(|label| label.span != *span) {
            diagnostic = diagnostic.label(*span, says(name));
        }
    }
    if diagnostic.labels.is_empty() { diagnostic.label(step, "this step") } else { diagnostic }
}

/// Report of parts that block one another on the way to their goals.
pub fn blocked_by_one_another(step: Span, parts: &[(&str, Span)], merge: Option<Span>) -> Diagnostic {
    let others = if parts.len() == 2 { "the other" } else { "the others" };
    let names: Vec<&str> = parts.iter().map(|(name, _)| *name).collect();
    let title = format!("no plan: {} cannot pass one another", all_of(&names));
    let says = |name: &str| format!("`{name}` is in the way of {others}");
    let diagnostic = labelled(Diagnostic::new(Code::E0601, title), step, parts, says);
    match merge {
        Some(merge) => diagnostic.label(merge, "once it arrives, each of the two stays here").help(
            "there is no room for them to pass while parts that merge must stay in place, as in this step: write it as \
             `assay { … }`, in which they may leave again",
        ),
        None => diagnostic
            .help("give one of them a goal on its own side, or move an obstacle: there is no room for them to pass"),
    }
}

/// Adds that a reason holds only while these parts, which no operation moves, stay where they are.
pub fn where_others_stay<'a>(diagnostic: Diagnostic, names: impl Iterator<Item = &'a str>) -> Diagnostic {
    let names: Vec<String> = names.map(|name| format!("`{name}`")).collect();
    if names.is_empty() {
        return diagnostic;
    }
    let (verb, they) = if names.len() == 1 { ("stays where it is", "it") } else { ("stay where they are", "they") };
    let stay = format!("{} {verb}; with `may_yield: true` {they} may make room", listed(names, MAX_LABELS));
    let help = diagnostic.help.as_ref().map_or(stay.clone(), |own| format!("{stay}. Otherwise, {own}"));
    diagnostic.help(help)
}

/// Report of a part that electrodes on shared channels keep from its goal.
pub fn torn_by_channels(ends: StepEnds, part: &str) -> Diagnostic {
    let StepEnds { step, from, to } = ends;
    Diagnostic::new(
        Code::E0601,
        format!("no plan leads from {from} to {to}: shared channels block every path of `{part}`"),
    )
    .label(step, format!("the electrode of the next cell switches on others, which pull `{part}` or a part that stays"))
    .help("give electrodes along the path channels of their own, or other numbers in `channels`")
}

/// Report of parts that could pass one another if each electrode had a channel of its own.
pub fn excluded_by_channels(step: Span, parts: &[(&str, Span)]) -> Diagnostic {
    let names: Vec<&str> = parts.iter().map(|(name, _)| *name).collect();
    let title = format!("no plan: shared channels keep {} from their goals", all_of(&names));
    let title = if parts.len() == 1 { title.replace("their goals", "its goal") } else { title };
    let says = |name: &str| format!("the channel that moves or holds `{name}` also pulls others");
    labelled(Diagnostic::new(Code::E0601, title), step, parts, says).help(UNSHARED)
}

/// Report of parts that could do their operations if each electrode had a channel of its own.
pub fn operations_excluded_by_channels(step: Span, parts: &[&str]) -> Diagnostic {
    let title = format!("no plan: shared channels keep {} from these operations", all_of(parts));
    Diagnostic::new(Code::E0601, title).label(step, "all positions of all parts together were searched").help(UNSHARED)
}

/// Help where the same goals have a plan with a channel for each electrode.
const UNSHARED: &str = "with a channel for each electrode they have a plan: give some electrodes channels of their \
                        own, or parts other goals";

/// Report of parts, each with its name and cell, that electrodes on shared channels pull away from where they should be
/// held.
pub fn restless_by_channels(step: Span, [one, other]: [(&str, String); 2]) -> Diagnostic {
    let held = |(name, cell): &(&str, String)| format!("`{name}` at {cell}");
    let (title, whom) = match one.0 == other.0 {
        true => (format!("no plan: {} cannot be held", held(&one)), "it"),
        false => (format!("no plan: {} and {} cannot be held together", held(&one), held(&other)), "one of them"),
    };
    Diagnostic::new(Code::E0601, title)
        .label(step, format!("meanwhile a shared channel switches on an electrode beside {whom}"))
        .help("leave out the wait, or begin it with the parts on electrodes of other channels")
}

/// Report of a plan that breaks the rule of shared channels, from a planner that ignores it.
pub fn heedless_of_channels(step: Span) -> Diagnostic {
    Diagnostic::new(Code::E0602, "the greedy planner ignores shared channels, and its plan conflicts with them")
        .label(step, "neither planned nor proven impossible")
        .help("leave `using` out: Tweeze's own planner moves parts only as shared channels allow")
}

/// Report of a step whose proof depends on where an earlier step has brought parts with interchangeable goals.
pub fn not_from_here(step: Span, tried: usize) -> Diagnostic {
    let others = match tried {
        0 => "other choices were not tried".to_owned(),
        _ => format!("no plan was found with the {} tried", count(tried, "choice")),
    };
    Diagnostic::new(Code::E0602, "no plan was found for this step from the cells where the plan has put the parts")
        .label(step, format!("the plan chooses where each part stands before this step; {others}"))
        .help("before this step, give the parts that it moves goals of their own instead of `any` or `among`")
}

/// Report of goals of `any` that lie where fewer parts can come than there are goals.
pub fn goals_out_of_reach(step: Span, name: &str, [goals, parts]: [usize; 2], goal: &str) -> Diagnostic {
    let title = match parts {
        0 => format!("no plan: no part of `any {name}` can reach its goal {goal}"),
        // There are more such goals than parts, hence several.
        _ => format!(
            "no plan: {goals} goals of `any {name}`, {goal} among them, can be reached by only {parts} of its parts"
        ),
    };
    Diagnostic::new(Code::E0601, title)
        .label(step, "obstacles or parts that stay lie between")
        .help("move a goal to the side of the parts, or move an obstacle")
}

/// Report of parts that cannot pass one another, whichever of their goals each takes.
pub fn blocked_with_any_goals(step: Span, parts: &[&str]) -> Diagnostic {
    let title = format!("no plan: {} cannot pass one another, whichever goals they take", all_of(parts));
    Diagnostic::new(Code::E0601, title)
        .label(step, "every choice of goals was searched")
        .help("give them goals with more room, or move some of them in an earlier step of its own")
}

pub fn too_few_steps(limit_span: Span, limit: u64, least: u64) -> Diagnostic {
    let unproven = Diagnostic::new(Code::E0603, format!("no plan was found that has {limit} steps or fewer"));
    Diagnostic::new(Code::E0603, format!("no plan has {limit} steps or fewer"))
        .label(limit_span, "this limit")
        .help(format!("every plan takes at least {least} steps: raise the limit"))
        .with_weaker_form(unproven.label(limit_span, "this limit").help("it is not known whether there is one"))
}

pub fn more_allowed(budget: u64, planner: &str) -> String {
    let most = u64::from(MAX_EXPANSIONS);
    if budget >= most {
        return "no larger budget is allowed: choose a route through other places with `via`, or leave out obstacles that \
                are far away"
            .to_owned();
    }
    format!("allow more: `using {planner} {{ expansions: {} }}`", budget.saturating_mul(8).min(most))
}

/// Report of a limit that the plan misses. `all` is the number of limits of the task; `texts` formats the figures for a
/// value of the verdict.
pub fn requirement_missed(
    requirement: &Requirement,
    verdict: LimitVerdict,
    all: usize,
    texts: &dyn Fn(Option<f64>) -> LimitTexts,
) -> Diagnostic {
    let name = &requirement.outcome;
    let value = match verdict {
        LimitVerdict::Least(value) | LimitVerdict::AtLeast(value, _) | LimitVerdict::Elsewhere(_, value) => Some(value),
        LimitVerdict::Conflict | LimitVerdict::NotFound => None,
    };
    let LimitTexts { reached, limit, value, enough, floor } = texts(value);
    let (within, raise) = match requirement.relation {
        Relation::Less => ("below", "above"),
        Relation::AtMost => ("within", "to"),
        Relation::Equal => ("at exactly", "to"),
        Relation::AtLeast => ("at or above", "to"),
        Relation::More => ("above", "to"),
    };
    let (others, with_others) = if all > 1 { (" and the other limits", " with the other limits") } else { ("", "") };
    let (title, label, help) = match verdict {
        LimitVerdict::Least(_) => (
            format!("no plan keeps `{name}` {within} {limit}{others}"),
            format!("proven: the minimum is {value}{with_others}"),
            Some(format!("raise the limit {raise} {value}")),
        ),
        LimitVerdict::AtLeast(_, best) => (
            format!("no plan keeps `{name}` {within} {limit}{others}"),
            format!("proven: no plan has less than {floor}{with_others}"),
            best.map(|best| format!("the plan found would keep a limit of {}", texts(Some(best)).enough)),
        ),
        LimitVerdict::Conflict => (
            format!("no plan keeps `{name}` {within} {limit} and the other limits"),
            format!("proven; the best plan without limits has {reached}"),
            None,
        ),
        LimitVerdict::NotFound => (
            format!("no plan was found that keeps `{name}` {within} {limit}{others}"),
            format!("the plan found has {reached}"),
            Some(not_proven(requirement.relation)),
        ),
        LimitVerdict::Elsewhere(objective, _) => (
            format!("no plan was found that keeps `{name}` {within} {limit}{others}"),
            format!("the plan found has {reached}"),
            Some(format!("`minimize {objective}` finds a plan with {enough}")),
        ),
    };
    Diagnostic::new(Code::E0603, title).label(requirement.span, label).help_if(help)
}

fn not_proven(relation: Relation) -> String {
    match relation {
        Relation::Less | Relation::AtMost => "it is not known whether there is one",
        Relation::Equal | Relation::AtLeast | Relation::More => {
            "only upper limits guide the search; this limit was merely checked against the plan found"
        }
    }
    .to_owned()
}

/// What may keep two robots apart for which no plans were found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SeparationRemedy {
    /// Their goals make them touch: they must end elsewhere.
    OtherEnds,
    OtherTimes,
}

/// Report of a robot for which no plan was found that keeps it apart from others of its scene; `with` are their names in
/// backquotes.
pub fn not_apart(
    [device, with]: [&str; 2],
    run: Span,
    why: &str,
    other: Option<Span>,
    mend: SeparationRemedy,
) -> Diagnostic {
    let title = format!("no plans were found that keep `{device}` and {with} apart");
    let diagnostic = Diagnostic::new(Code::E0610, title).label(run, why);
    let diagnostic = match other {
        Some(other) => diagnostic.label_elsewhere(other, run, format!("a run of {with}")),
        None => diagnostic,
    };
    diagnostic.help(match mend {
        SeparationRemedy::OtherEnds => format!("end the run of `{device}` elsewhere, or move {with} on first"),
        SeparationRemedy::OtherTimes => {
            "this does not prove that there are none; it may help to run one after the other instead of `together`, or \
             to route one through other places with `via`"
                .to_owned()
        }
    })
}
