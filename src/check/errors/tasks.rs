//! Scenes, tasks and programs: E05xx.

use super::{listed, with_article};
use crate::check::lets::Argument;
use crate::check::value::{Value, whole};
use crate::claims::ValueOrigin;
use crate::device::instrument::Level;
use crate::device::{Verb, Vocabulary, VocabularyPhrase, condition_of_any_kind};
use crate::diagnostic::{Code, Diagnostic};
use crate::quantity::{Dimension, digits};
use crate::source::Span;
use crate::syntax::tree::{Ident, Step};

pub fn outside_workspace(span: Span, what: &str, extent: &str, help: String) -> Diagnostic {
    Diagnostic::new(Code::E0501, format!("{what} is outside the workspace, {extent}"))
        .label(span, "cannot be reached")
        .help(help)
}

/// A goal or a start on an obstacle; `code` tells which.
pub fn on_obstacle(
    code: Code,
    span: Span,
    what: &str,
    name: &str,
    obstacle: Span,
    why: &str,
    free: Option<String>,
) -> Diagnostic {
    Diagnostic::new(code, format!("{what} lies on obstacle `{name}`"))
        .label(span, why)
        .label(obstacle, "the obstacle")
        .help_if(free)
}

/// Labels the origin of an argument's value, if it has one.
pub fn given_at(diagnostic: Diagnostic, argument: &Argument) -> Diagnostic {
    given_from(diagnostic, argument.span, argument.origin.as_ref())
}

/// As [`given_at`], for a value that already has a label at `labelled`.
pub fn given_from(diagnostic: Diagnostic, labelled: Span, origin: Option<&ValueOrigin>) -> Diagnostic {
    match origin {
        Some(origin) => diagnostic.label_elsewhere(origin.span, labelled, origin.text.clone()),
        None => diagnostic,
    }
}

pub fn off_lattice(span: Span, off: &str, precision: &str, help: String) -> Diagnostic {
    Diagnostic::new(Code::E0503, format!("the nearest cell is {off} away, but the precision is {precision}"))
        .label(span, "off the lattice")
        .help(help)
}

pub fn word_of_wrong_width(span: Span, found: u32, left: u32, right: u32, device: &str) -> Diagnostic {
    Diagnostic::new(Code::E0504, format!("a word has {found} digits, but the robot has {} modules", left + right))
        .label(span, format!("`{device}` has {left} modules on the left and {right} on the right"))
        .help(format!("write bl{}..bl0 and then br{}..br0, {left} + {right} digits", left - 1, right - 1))
}

pub fn precision_beyond_robot(span: Span, precision: &str, repeatability: &str) -> Diagnostic {
    Diagnostic::new(
        Code::E0506,
        format!("precision {precision} is finer than the repeatability of the robot, {repeatability}"),
    )
    .label(span, "finer than the robot repeats")
    .help(format!("use {repeatability} or more, or give the device its measured repeatability"))
}

pub fn two_things_at_once(device: &str, first: Span, second: Span) -> Diagnostic {
    let diagnostic = Diagnostic::new(Code::E0508, format!("device `{device}` is used twice at the same time"));
    diagnostic
        .label(second, "runs at the same time")
        .label_elsewhere(first, second, "busy here")
        .help("run one after the other: move one of them out of `together`")
}

pub fn devices_of_one_name(device: &str, first: Span, second: Span) -> Diagnostic {
    Diagnostic::new(Code::E0508, format!("two devices named `{device}` in one schedule"))
        .label(second, "runs one of them")
        .label_elsewhere(first, second, "runs the other")
        .help("rename one of the two: channels are named after their device")
}

pub fn missing_part(span: Span, verb: &Verb, part: &str) -> Diagnostic {
    Diagnostic::new(Code::E0509, format!("`{}` lacks {part}", verb.name))
        .label(span, "incomplete step")
        .help(format!("write `{}`", verb.example))
}

pub fn missing_preposition(span: Span, verb: &Verb, preposition: &str) -> Diagnostic {
    Diagnostic::new(Code::E0509, format!("`{}` lacks `{preposition}`", verb.name))
        .label(span, format!("write `{preposition}` before this"))
        .help(format!("as in `{}`", verb.example))
}

pub fn unexpected_part(span: Span, verb: &Verb, part: &str) -> Diagnostic {
    Diagnostic::new(Code::E0509, format!("`{}` does not take {part}", verb.name))
        .label(span, "does not belong here")
        .help(format!("write `{}`", verb.example))
}

/// A word before the object that is not the verb's.
pub fn wrong_noun(noun: &Ident, verb: &Verb, own: &str, near: Option<&str>) -> Diagnostic {
    Diagnostic::new(Code::E0509, format!("`{}` takes a `{own}`, not a `{}`", verb.name, noun.text))
        .label(noun.span, format!("`{own}` is expected here"))
        .near_or(near, format!("write `{}`", verb.example))
}

/// Something in a verb's braces that is not an entry.
pub fn no_entry(span: Span, verb: &Verb) -> Diagnostic {
    Diagnostic::new(Code::E0509, format!("this is not an entry of `{}`", verb.name))
        .label(span, "an object and its prepositions belong here, without a verb")
        .help(format!("write `{}`", verb.example))
}

pub fn unknown_preposition(preposition: &Ident, verb: &Verb, taken: &[VocabularyPhrase]) -> Diagnostic {
    let known = listed(taken.iter().map(|phrase| phrase.preposition));
    Diagnostic::new(Code::E0509, format!("`{}` does not take `{}`", verb.name, preposition.text))
        .label(preposition.span, "not understood here")
        .help(match taken {
            [] => format!("write it as in `{}`", verb.example),
            _ => format!("it takes {known}, as in `{}`", verb.example),
        })
}

pub fn preposition_twice(preposition: &Ident, earlier: Span, verb: &Verb) -> Diagnostic {
    Diagnostic::new(Code::E0509, format!("`{}` is given twice in one `{}`", preposition.text, verb.name))
        .label(preposition.span, "again here")
        .label(earlier, "first here")
        .help("write two steps, one below the other")
}

pub fn setting_after_step(name: &Ident, step: Span) -> Diagnostic {
    Diagnostic::new(Code::E0510, format!("setting `{}` is written after a step", name.text))
        .label(name.span, "settings come first")
        .label(step, "the first step")
        .help(format!("move `{}` above the first step: it applies to the whole task", name.text))
}

pub fn setting_in_loop(name: &Ident) -> Diagnostic {
    Diagnostic::new(Code::E0510, format!("setting `{}` is written in a `for`", name.text))
        .label(name.span, "a setting is given once")
        .help("move it out of the `for`, to the top of the task")
}

pub fn setting_twice(name: &Ident, earlier: Span) -> Diagnostic {
    Diagnostic::new(Code::E0510, format!("setting `{}` is given twice", name.text))
        .label(name.span, "given again here")
        .label(earlier, "first given here")
        .help("remove one of the two")
}

pub fn bad_setting_form(span: Span, head: &str, example: &str) -> Diagnostic {
    Diagnostic::new(Code::E0509, format!("`{head}` takes one value"))
        .label(span, format!("expected `{head}` and one value"))
        .help(format!("write `{head} {example}`"))
}

/// A step that switches an output, in a wrong form.
pub fn bad_output_step(step: &Step, form: &str) -> Diagnostic {
    let words = match step.head.text.as_str() {
        "pulse" => "the name of an output",
        _ => "the name of an output, `to`, and a level",
    };
    Diagnostic::new(Code::E0509, format!("`{}` takes {words}", step.head.text))
        .label(step.span, "incomplete or too long")
        .help(format!("write `{form}`"))
}

pub fn pulse_of_level(span: Span, name: &str, declared: Span, is_graded: bool) -> Diagnostic {
    let (sort, [first, second]) = match is_graded {
        true => ("level", ["60 %", "0 %"]),
        false => ("digital", ["high", "low"]),
    };
    Diagnostic::new(Code::E0556, format!("`{name}` cannot be pulsed"))
        .label(span, "`pulse` is for outputs of the sort `trigger`")
        .label(declared, format!("an output of the sort `{sort}`"))
        .help(format!(
            "write `set {name} to {first}` and later `set {name} to {second}`, or declare it `: trigger {{ duration: 5 ms }}`"
        ))
}

pub fn level_of_trigger(step: &Step, name: &str, declared: Span) -> Diagnostic {
    Diagnostic::new(Code::E0556, format!("`{name}` has no level to set"))
        .label(step.head.span, "`set` is for outputs of the sorts `digital` and `level`")
        .label(declared, "an output of the sort `trigger`")
        .help(format!("write `pulse {name}`, or declare it `: digital`"))
        .with_fix(step.span, format!("pulse {name}"))
}

/// A step that waits for an input or a person, in a wrong form.
pub fn bad_hold_step(step: &Step) -> Diagnostic {
    let (takes, help) = match step.head.text.as_str() {
        "prompt" => (
            "`prompt` takes a text in quotes; `for at most` and a time limit the wait",
            "write `prompt \"add the sample\"`",
        ),
        _ => (
            "`wait until` takes an input, then `for at most` and a time",
            "write `wait until card.port0.line5 for at most 5 s` for a line of an instrument, or `wait until \"ready\" for at most 5 s` for an input that your own command reads",
        ),
    };
    Diagnostic::new(Code::E0509, takes).label(step.span, "incomplete or too long").help(help)
}

pub fn no_input(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0566, "this is not an input")
        .label(span, "neither a line of an instrument nor a name in quotes")
        .help("write `wait until card.port0.line5 for at most 5 s`, or `wait until \"motion.digital-in-00\" …`")
}

pub fn instrument_without_inputs(span: Span, name: &str, declared: Span, family: &str) -> Diagnostic {
    Diagnostic::new(Code::E0566, format!("instrument `{name}` has no input that a program can wait for"))
        .label(span, "not an input")
        .label_elsewhere(declared, span, format!("an instrument of the family `{family}`"))
        .help("wait for a digital line of a `data_acquisition`, or for a name in quotes that your own program reads")
}

pub fn unknown_input(span: Span, name: &str, declared: Span, input: &str, known: &str) -> Diagnostic {
    Diagnostic::new(Code::E0566, format!("instrument `{name}` has no digital line `{input}`"))
        .label(span, "no such line")
        .label_elsewhere(declared, span, "the instrument")
        .help(known.to_owned())
}

pub fn input_is_output(span: Span, name: &str) -> Diagnostic {
    Diagnostic::new(Code::E0566, format!("`{name}` is an output of this program, so it cannot be an input"))
        .label(span, "a channel is wired to it")
        .help("wait for another line")
}

/// `require time >= 10 s` in a task whose duration depends on an input or a person.
pub fn least_time_of_hold(span: Span, hold: Span) -> Diagnostic {
    Diagnostic::new(Code::E0567, "`time` has a lower limit, but the task may end sooner")
        .label(span, "cannot be guaranteed")
        .label(hold, "this wait ends as soon as its event occurs")
        .help("leave it out, or set an upper limit, for which the longest wait counts")
}

/// A wait for an input or a person between the runs of a program.
pub fn hold_in_program(head: &Ident) -> Diagnostic {
    Diagnostic::new(Code::E0518, format!("this `{}` belongs in a task, not in a program", head.text))
        .label(head.span, "waits for an input or a person")
        .help("write it as a step at the beginning or at the end of a task")
}

/// `high` or `low` for an output with levels between the two.
pub fn word_for_share(span: Span, name: &str, word: Level) -> Diagnostic {
    let share = match word {
        Level::Low => "0 %",
        Level::High => "100 %",
    };
    Diagnostic::new(Code::E0311, format!("{name} must be a share of its range, but this is `{}`", word.name()))
        .label(span, "a level of an output of the sort `digital`")
        .help(format!("write `{share}`"))
        .with_fix(span, share)
}

pub fn outputs_of_one_name(name: &str, declared: Span, earlier: Span) -> Diagnostic {
    Diagnostic::new(Code::E0202, format!("an output of another file is also named `{name}`"))
        .label(declared, "one of the two")
        .label_elsewhere(earlier, declared, "the other")
        .help("rename one of them: channels are distinguished by these names")
}

pub fn bad_start(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0509, "`start` takes `at` and a state")
        .label(span, "incomplete or too long")
        .help("write `start at 0b10001_00010` or `start at (17, 2)`")
}

/// `form` is the call as it should be: `go(goal: cell)`.
pub fn wrong_argument_count(span: Span, form: &str, wanted: usize, found: usize, declared: Span) -> Diagnostic {
    let arguments = match wanted {
        0 => "no arguments".to_owned(),
        1 => "1 argument".to_owned(),
        more => format!("{more} arguments"),
    };
    let given = if found == 1 { "1 is".to_owned() } else { format!("{found} are") };
    let name = form.split('(').next().unwrap_or(form);
    Diagnostic::new(Code::E0511, format!("`{name}` takes {arguments}, but {given} given"))
        .label(span, "run here")
        .label(declared, "declared here")
        .help(format!("write `run {form}`"))
}

pub fn unknown_parameter_sort(sort: &Ident, near: Option<&str>, known: &[&str]) -> Diagnostic {
    Diagnostic::new(Code::E0511, format!("no parameter can be a `{}`", sort.text))
        .label(sort.span, "unknown sort")
        .near_or(near, format!("a parameter is one of {}", listed(known.iter().copied())))
}

pub fn too_many_runs(span: Span, limit: usize) -> Diagnostic {
    Diagnostic::new(Code::E0512, format!("more than {limit} runs and waits in one schedule"))
        .label(span, "the limit is exceeded here")
        .help("split the program into several")
}

pub fn too_many_steps(span: Span, limit: usize) -> Diagnostic {
    Diagnostic::new(Code::E0512, format!("more than {limit} steps of tasks in one schedule"))
        .label(span, "the limit is exceeded here")
        .help("split the program into several")
}

pub fn nothing_to_build(span: Span) -> Diagnostic {
    Diagnostic::new(Code::W0503, "the file declares no task")
        .label(span, "nothing to build here")
        .help("a file of devices and scenes is imported by others: `use \"this.twz\"`")
}

pub fn no_such_task(name: &str, near: Option<&str>, known: &[&str]) -> Diagnostic {
    let list = match known {
        [] => "the file declares none".to_owned(),
        known => format!("the file declares {}", listed(known.iter().copied())),
    };
    Diagnostic::new(Code::E0513, format!("no task or program is named `{name}`")).near_or(near, list)
}

pub fn task_needs_arguments(span: Span, name: &str) -> Diagnostic {
    Diagnostic::new(Code::E0513, format!("`{name}` has parameters and cannot be built alone"))
        .label(span, "declared with parameters")
        .help(format!("add a program: `program all {{ run {name}(…) }}`"))
}

pub fn shape_wanted(span: Span, found: &Value) -> Diagnostic {
    Diagnostic::new(Code::E0304, format!("expected a shape, found {}", found.describe_fully()))
        .label(span, found.describe())
        .help(if matches!(found, Value::Point(_)) {
            "write `at` instead of `:` before a place"
        } else {
            "write `disc { radius: 0.8 um }`, or leave `: shape` out for a point"
        })
}

pub fn bad_shape(span: Span, what: &str, why: &str, help: &str) -> Diagnostic {
    Diagnostic::new(Code::E0514, what).label(span, why).help(help)
}

pub fn shape_too_large(span: Span, limit: &str) -> Diagnostic {
    Diagnostic::new(Code::E0514, format!("an obstacle reaches further than {limit}"))
        .label(span, "too far or too large")
        .help("check the unit: obstacles are given in micrometres, as `0.8 um`")
}

pub fn wrong_place(span: Span, found: &Value, wanted: &str) -> Diagnostic {
    if let Some(parts) = odd_cell(found) {
        let cell = |round: fn(f64) -> f64| {
            let parts: Vec<String> = parts.iter().map(|part| digits(round(*part))).collect();
            format!("({})", parts.join(", "))
        };
        if parts.iter().all(|part| part.fract() == 0.0) {
            return Diagnostic::new(Code::E0515, format!("cell {} lies beyond every workspace", cell(|part| part)))
                .label(span, "cells are counted; places have units")
                .help("write a cell, as `(12, 7)`, or a place with its unit, as `(4 um, 2.5 um)`");
        }
        let place: Vec<String> = parts.iter().map(|part| format!("{} um", digits(*part))).collect();
        let [below, above, place] = [cell(f64::floor), cell(f64::ceil), format!("({})", place.join(", "))];
        return Diagnostic::new(Code::E0515, format!("cell {} is not whole", cell(|part| part)))
            .label(span, "cells are counted; places have units")
            .help(format!("write the cell `{below}` or `{above}`, or a place with its unit, as `{place}`"));
    }
    Diagnostic::new(Code::E0515, format!("`at` needs {wanted}, but this is {}", found.describe_fully()))
        .label(span, found.describe())
        .help("write `at (12, 7)` for a cell, `at (4 um, 2.5 um)` for a place, `at pose(8 um, 3 um, 30 deg)` for a turned shape")
}

/// The coordinates of a cell of which one is not whole or is too large to be exact; `None` for any other value.
fn odd_cell(found: &Value) -> Option<Vec<f64>> {
    let Value::Point(coordinates) = found else { return None };
    let are_numbers = coordinates.iter().all(|part| part.dimension == Dimension::NUMBER);
    let is_odd = are_numbers && coordinates.iter().any(|part| whole(*part).is_none());
    is_odd.then(|| coordinates.iter().map(|part| part.si).collect())
}

pub fn noun_of_other_kind(span: Span, noun: &str, kind: &str, known: &[&str]) -> Diagnostic {
    Diagnostic::new(Code::E0210, format!("{} has no `{noun}`", with_article(kind)))
        .label(span, "not a noun of this device")
        .help(format!("its scenes may hold {}", listed(known.iter().copied())))
}

pub fn repeated_object(name: &str, span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0202, format!("each iteration of the `for` declares `{name}` again"))
        .label(span, "one name for several objects")
        .help(format!("give it an index counted by the loop, as in `for i, p in places {{ … {name}[i] … }}`"))
}

pub fn bad_requirement(span: Span, vocabulary: &Vocabulary) -> Diagnostic {
    let known = listed(vocabulary.outcomes.iter().map(|outcome| outcome.name));
    Diagnostic::new(Code::E0516, "`require` compares an outcome with a limit")
        .label(span, "not such a comparison")
        .help(format!("write `require time <= 400 ms`; {} has {known}", with_article(vocabulary.name)))
}

pub fn limits_exclude(outcome: &str, earlier: Span, later: Span) -> Diagnostic {
    Diagnostic::new(Code::E0603, format!("no plan keeps both limits of `{outcome}`"))
        .label(later, "excludes the other")
        .label_elsewhere(earlier, later, "this one")
        .help("remove one of the two, or change one until some value keeps both")
}

pub fn unknown_outcome(span: Span, name: &str, near: Option<&str>, vocabulary: &Vocabulary) -> Diagnostic {
    let known = listed(vocabulary.outcomes.iter().map(|outcome| outcome.name));
    if vocabulary.objectives.iter().any(|objective| objective.name == name) {
        return Diagnostic::new(Code::E0516, format!("`{name}` can be minimized, but not required"))
            .label(span, "not a figure that the verifier derives from a plan")
            .help(format!("write `minimize {name}`, or require one of {known}"));
    }
    Diagnostic::new(Code::E0516, format!("a plan of {} has no `{name}`", with_article(vocabulary.name)))
        .label(span, "unknown outcome")
        .near_or(near, format!("it has {known}"))
}

pub fn unknown_planner(span: Span, name: &str, near: Option<&str>, vocabulary: &Vocabulary) -> Diagnostic {
    let known = listed(vocabulary.planners.iter().map(|planner| planner.name));
    Diagnostic::new(Code::E0517, format!("{} has no planner `{name}`", with_article(vocabulary.name)))
        .label(span, "unknown planner")
        .near_or(near, format!("write one of {known}, as `using {}`", vocabulary.planners[0].name))
}

pub fn planner_cannot(span: Span, name: &str, what: &str, asked: Span) -> Diagnostic {
    Diagnostic::new(Code::E0520, format!("planner `{name}` cannot {what}"))
        .label(span, "chosen here")
        .label_elsewhere(asked, span, "requested here")
        .help("leave `using` out: Tweeze's own planner does it")
}

pub fn together_in_task(span: Span, why: &str) -> Diagnostic {
    Diagnostic::new(Code::E0518, why)
        .label(span, "not in this task")
        .help("write the steps one below the other; several devices run together in a `program`")
}

/// A `together` or an `assay` without a block, or with an empty one.
pub fn bad_block_in_task(step: &Step) -> Diagnostic {
    let (what, example) = match step.head.text.as_str() {
        "assay" => ("operations", "assay { move a to (6, 3), incubate a for 30 s, move b to (2, 3) }"),
        _ => ("goals", "together { move m1 to (26, 31), move m2 to (5, 3) }"),
    };
    Diagnostic::new(Code::E0518, format!("`{}` needs a block of {what}", step.head.text))
        .label(step.span, format!("no {what}"))
        .help(format!("write `{example}`"))
}

/// A word in the block of a `together` or an `assay` that does not belong there.
pub fn not_in_block(word: &Ident, head: &Ident) -> Diagnostic {
    let (one, all) = match head.text.as_str() {
        "assay" => ("an operation of a part", "operations"),
        _ => ("a goal", "goals"),
    };
    let title = format!("`{}` is not {one}; `{}` takes only {all}", word.text, head.text);
    let wait = (head.text == "assay" && word.text == "wait")
        .then(|| "write `incubate NAME for 10 s`, with the part that waits".to_owned());
    let place = match word.text.as_str() {
        "minimize" | "require" | "using" | "start" => "before all steps".to_owned(),
        word if condition_of_any_kind(word).is_some() => "before all steps".to_owned(),
        _ => format!("before or after the `{}`", head.text),
    };
    let elsewhere = format!("write it {place}");
    Diagnostic::new(Code::E0518, title).label(word.span, "not in this block").help(wait.unwrap_or(elsewhere))
}

pub fn assay_of_other_kind(span: Span, kind: &str) -> Diagnostic {
    Diagnostic::new(Code::E0518, format!("{} has no `assay`", with_article(kind)))
        .label(span, "not in this task")
        .help("write its steps one after the other")
}

pub fn no_start(span: Span, vocabulary: &Vocabulary) -> Diagnostic {
    let nouns = listed(vocabulary.nouns.iter().map(|noun| noun.name).filter(|noun| *noun != "obstacle"));
    Diagnostic::new(Code::E0518, format!("a task of {} cannot set where it starts", with_article(vocabulary.name)))
        .label(span, "not in this task")
        .help(format!("the scene places each {nouns}; after that, each starts where the last task left it"))
}

pub fn shape_of_other_kind(span: Span, shape: &str, noun: &str, kind: &str, known: &[&str]) -> Diagnostic {
    Diagnostic::new(Code::E0514, format!("`{shape}` is not a shape for {} of the kind {kind}", with_article(noun)))
        .label(span, "not a shape of this noun")
        .help(format!("it may be {}", super::either(known)))
}

pub fn run_in_task(span: Span, task: &str) -> Diagnostic {
    Diagnostic::new(Code::E0518, "a task cannot run another")
        .label(span, "not in a task")
        .help(format!("put runs into a program: `program all {{ run {task} }}`"))
}

pub fn field_in_program(name: &Ident) -> Diagnostic {
    Diagnostic::new(Code::E0518, "a program has no settings")
        .label(name.span, "not in a program")
        .help("put settings into the tasks that it runs")
}

/// The name of a task without `run`.
pub fn run_without_its_word(head: &Ident) -> Diagnostic {
    let name = &head.text;
    Diagnostic::new(Code::E0518, format!("`{name}` needs `run` before it"))
        .label(head.span, "a task, not a step")
        .help(format!("write `run {name}`"))
        .with_fix_here(format!("run {name}"))
}

/// `wait for 5 ms`.
pub fn wait_for(preposition: Span, value: Span) -> Diagnostic {
    let blank = Span { end: value.start, ..preposition };
    Diagnostic::new(Code::E0509, "`wait` takes only a time")
        .label(preposition, "no `for` here")
        .help("write the time directly after `wait`, as in `wait 10 ms`")
        .with_fix(blank, "")
}

pub fn unknown_program_step(head: &Ident, near: Option<&str>) -> Diagnostic {
    let list = match head.text.as_str() {
        "pulse" | "set" => "write it in a task: outputs are switched by the steps of tasks".to_owned(),
        _ => "a program has `run TASK`, `wait 5 ms` and `together { … }`".to_owned(),
    };
    Diagnostic::new(Code::E0518, format!("a program cannot `{}`", head.text))
        .label(head.span, "not a step of a program")
        .near_or(near, list)
}

pub fn bad_together(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0509, "`together` takes a block")
        .label(span, "incomplete or too long")
        .help("write `together { run A, run B }`")
}

pub fn bad_run(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0509, "`run` takes a task or a program")
        .label(span, "incomplete or too long")
        .help("write `run fetch` or `run go((3, 9), 200 ms)`")
}

pub fn too_many_visits(span: Span, found: usize, limit: usize) -> Diagnostic {
    Diagnostic::new(Code::E0519, format!("{found} places in one `visit`; at most {limit} can be ordered"))
        .label(span, "too many")
        .help("write several `visit` steps")
}

pub fn simultaneous_in_vain(span: Span, objective: &str) -> Diagnostic {
    Diagnostic::new(Code::W0504, format!("`simultaneous: safe` changes nothing with `minimize {objective}`"))
        .label(span, "modules are switched one by one")
        .help("write `minimize time`, or leave the setting out")
}

pub fn obstacle_outside(span: Span, name: &str, device: &str) -> Diagnostic {
    Diagnostic::new(Code::W0501, format!("obstacle `{name}` lies outside the workspace of `{device}`"))
        .label(span, "never in the way")
        .help("places count from word 0 along the robot's own axes; check the place and its unit")
}
