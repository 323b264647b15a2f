//! Steps that wait for an input or a person.

use super::Checker;
use super::errors::{self, WantedName};
use super::scope::{Scope, path_text};
use super::value::Value;
use crate::claims::{Job, Relation};
use crate::device::instrument::{Awaited, Bench, Family, HoldTerms, InstrumentFacts, Level, OutputSort};
use crate::device::{Range, Sort};
use crate::quantity::Dimension;
use crate::syntax::tree::{Expr, ExprKind, Phrase, Step};
use std::collections::BTreeMap;

/// Duration on the clock of a prompt without a limit, in nanoseconds.
const PROMPT_NS: u64 = 1_000_000_000;

/// Preposition of the longest time.
const AT_MOST: [&str; 3] = ["for", "at", "most"];

/// Whether a step waits for an input or a person rather than for a time.
pub fn is_hold(step: &Step) -> bool {
    match step.head.text.as_str() {
        "prompt" => true,
        "wait" => {
            step.noun.as_ref().is_some_and(|noun| noun.text == "until")
                || matches!(&step.object, Some(Expr { kind: ExprKind::Path(path), .. }) if path_text(path) == "until")
        }
        _ => false,
    }
}

impl Checker<'_> {
    /// `wait until card.port0.line5 for at most 5 s`, or `prompt "add sample"`.
    pub fn hold(&mut self, step: &Step, scope: &Scope) -> Option<HoldTerms> {
        match step.head.text.as_str() {
            "prompt" => self.prompt(step, scope),
            _ => self.wait_until(step, scope),
        }
    }

    fn wait_until(&mut self, step: &Step, scope: &Scope) -> Option<HoldTerms> {
        let (level, limit) = match step.phrases.as_slice() {
            [limit] if is_limit(limit) => (None, limit),
            [level, limit] if level.preposition.text == "at" && is_limit(limit) => (Some(level), limit),
            _ => {
                self.sink.push(errors::bad_hold_step(step));
                return None;
            }
        };
        let object = step.object.as_ref().filter(|_| step.noun.is_some() && step.block.is_none());
        let Some(object) = object else {
            self.sink.push(errors::bad_hold_step(step));
            return None;
        };
        let input = self.input(object, scope);
        let level = match level {
            None => Some(Level::High),
            Some(phrase) => {
                let wanted =
                    WantedName { name: "the level of an input".to_owned(), doc: String::new(), declared: None };
                match self.accept(Sort::Word(Level::CHOICES), &phrase.value, scope, &wanted) {
                    Some(Value::Text(word)) => Level::find(&word),
                    _ => None,
                }
            }
        };
        let duration_ns = self.limit(limit, scope)?;
        let ((name, place), level) = (input?, level?);
        Some(HoldTerms { awaited: Awaited::Input { name, place, level }, duration_ns, is_bounded: true })
    }

    fn prompt(&mut self, step: &Step, scope: &Scope) -> Option<HoldTerms> {
        let limit = match step.phrases.as_slice() {
            [] => None,
            [limit] if is_limit(limit) => Some(limit),
            _ => {
                self.sink.push(errors::bad_hold_step(step));
                return None;
            }
        };
        let whole = step.noun.is_none() && step.block.is_none();
        let Some(Expr { kind: ExprKind::Text(text), span }) = step.object.as_ref().filter(|_| whole) else {
            self.sink.push(errors::bad_hold_step(step));
            return None;
        };
        let prompt = self.text(text, *span, scope);
        let duration_ns = match limit {
            Some(limit) => self.limit(limit, scope)?,
            None => PROMPT_NS,
        };
        let prompt = prompt?.split_whitespace().collect::<Vec<_>>().join(" ");
        Some(HoldTerms { awaited: Awaited::Person { prompt }, duration_ns, is_bounded: limit.is_some() })
    }

    /// The longest time of a wait, in nanoseconds.
    fn limit(&mut self, phrase: &Phrase, scope: &Scope) -> Option<u64> {
        let sort = Sort::Quantity { dimension: Dimension::TIME, range: Range::Positive };
        let wanted = WantedName { name: "the longest wait".to_owned(), doc: String::new(), declared: None };
        let Value::Quantity(time) = self.accept(sort, &phrase.value, scope, &wanted)? else { return None };
        super::clock_ns(time, phrase.value.span, "the longest wait", self.sink).filter(|limit_ns| *limit_ns > 0)
    }

    /// The input that a step names, with the instrument that reads it and its name there if the input is declared.
    fn input(&mut self, object: &Expr, scope: &Scope) -> Option<(String, Option<(String, String)>)> {
        let path = match &object.kind {
            ExprKind::Text(text) => return Some((self.text(text, object.span, scope)?, None)),
            ExprKind::Path(path) => path,
            _ => {
                self.sink.push(errors::no_input(object.span));
                return None;
            }
        };
        let (place, words) = self.instrument_of(path, scope)?;
        let facts = self.facts::<Family>(place)?.facts;
        let input = self.channel_name(&path.segments[words..], scope)?;
        let (name, declared) = self.named(place);
        let name = name.to_owned();
        if facts.family() != Family::DataAcquisition {
            self.sink.push(errors::instrument_without_inputs(object.span, &name, declared, facts.family().name()));
            return None;
        }
        if facts.output(&input) != Some(OutputSort::Digital) {
            self.sink.push(errors::unknown_input(object.span, &name, declared, &input, &lines(&facts)));
            return None;
        }
        Some((format!("{name}.{input}"), Some((name, input))))
    }

    /// Reports a task that both waits for something and requires a least time, and inputs that are also outputs.
    pub fn holds_of(&mut self, jobs: &[Job], wires: &BTreeMap<String, String>, bench: &Bench) {
        for job in jobs.iter().filter(|job| !job.holds.is_empty()) {
            let spans = job.step_spans();
            for hold in &job.holds {
                let Awaited::Input { name, place, .. } = &hold.terms.awaited else { continue };
                let is_driven = |(instrument, input): &(String, String)| {
                    bench.drives.values().any(|drive| drive.instrument == *instrument && drive.output == *input)
                };
                let is_output = wires.values().any(|wire| wire == name) || place.as_ref().is_some_and(is_driven);
                if is_output {
                    self.sink.push(errors::input_is_output(spans[hold.step], name));
                }
            }
            for requirement in job.requirements.iter().filter(|requirement| requirement.outcome == "time") {
                if matches!(requirement.relation, Relation::AtLeast | Relation::More | Relation::Equal) {
                    self.sink.push(errors::least_time_of_hold(requirement.span, spans[job.holds[0].step]));
                }
            }
        }
    }
}

/// Whether a phrase gives the longest time of a wait.
fn is_limit(phrase: &Phrase) -> bool {
    phrase.preposition.text.split_whitespace().eq(AT_MOST)
}

/// The names of an instrument's digital lines, for a message.
fn lines(facts: &InstrumentFacts) -> String {
    match facts {
        InstrumentFacts::DataAcquisition(facts) if facts.ports * facts.lines > 0 => {
            format!("its lines are `port0.line0` to `port{}.line{}`", facts.ports - 1, facts.lines - 1)
        }
        _ => "it has no digital lines".to_owned(),
    }
}
