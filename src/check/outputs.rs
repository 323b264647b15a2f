//! Auxiliary outputs, and the steps that switch them.

use super::Checker;
use super::devices::CheckedDeclaration;
use super::errors::{self, WantedName};
use super::figures::Figures;
use super::scope::{DeclarationPlace, DeclarationSort, Scope, path_text};
use super::value::Value;
use super::wiring::Wiring;
use crate::claims::auxiliary::AuxiliaryAction;
use crate::claims::{Claims, Job};
use crate::device::instrument::{AuxiliaryOutput, AuxiliarySort, Bench, Drive, Level};
use crate::device::{Range, Sort};
use crate::quantity::Dimension;
use crate::syntax::tree::{Expr, ExprKind, Step};
use std::collections::{BTreeMap, BTreeSet};

impl Checker<'_> {
    /// The facts of an output that lacks no field; `None` after an error.
    pub fn facts_of_output(&mut self, declared: &CheckedDeclaration<AuxiliarySort>) -> Option<AuxiliaryOutput> {
        let fields = &declared.fields;
        if declared.root == AuxiliarySort::Level {
            let (low_v, high_v) = (fields.si("from")?, fields.si("to")?);
            let rest_v = between([low_v, high_v], fields.si("rest")?);
            return Some(AuxiliaryOutput { high_v, low_v, rest_v, pulse_ns: None, is_graded: true });
        }
        let high_v = fields.si("voltage")?;
        let rest_v = match fields.word("rest").and_then(Level::find).unwrap_or_default() {
            Level::Low => 0.0,
            Level::High => high_v,
        };
        let pulse_ns = match declared.root {
            AuxiliarySort::Trigger => Some(fields.clock_ns("duration", self.sink)?),
            AuxiliarySort::Digital | AuxiliarySort::Level => None,
        };
        Some(AuxiliaryOutput { high_v, low_v: 0.0, rest_v, pulse_ns, is_graded: false })
    }

    /// Reads `pulse camera`: the output's name and action; `None` after an error.
    pub fn pulse(&mut self, step: &Step, scope: &Scope) -> Option<(String, AuxiliaryAction)> {
        let whole = step.noun.is_none() && step.phrases.is_empty() && step.block.is_none();
        let Some(ExprKind::Path(path)) = step.object.as_ref().filter(|_| whole).map(|object| &object.kind) else {
            self.sink
                .push(errors::bad_output_step(step, &format!("pulse {}", written_output(step).unwrap_or("camera"))));
            return None;
        };
        let place = self.resolve(path, scope, DeclarationSort::Output)?;
        let facts = self.facts::<AuxiliarySort>(place)?;
        let (name, declared) = self.named(place);
        if facts.pulse_ns.is_none() {
            self.sink.push(errors::pulse_of_level(step.head.span, name, declared, facts.is_graded));
            return None;
        }
        Some((self.enlist_output(place)?, AuxiliaryAction::Pulse))
    }

    /// Reads `set light to high`: the output's name and action; `None` after an error.
    pub fn level(&mut self, step: &Step, scope: &Scope) -> Option<(String, AuxiliaryAction)> {
        let whole = step.noun.is_none() && step.block.is_none();
        let object = step.object.as_ref().filter(|_| whole).map(|object| &object.kind);
        let to = step.phrases.iter().find(|phrase| step.phrases.len() == 1 && phrase.preposition.text == "to");
        let (Some(ExprKind::Path(path)), Some(phrase)) = (object, to) else {
            let name = written_output(step).unwrap_or("light");
            let asked = step.object.iter().chain(step.phrases.iter().map(|phrase| &phrase.value));
            let is_low = |value: &Expr| matches!(&value.kind, ExprKind::Path(path) if matches!(path_text(path).as_str(), "low" | "off"));
            let level = if asked.into_iter().any(is_low) { "low" } else { "high" };
            self.sink.push(errors::bad_output_step(step, &format!("set {name} to {level}")));
            return None;
        };
        let place = self.resolve(path, scope, DeclarationSort::Output);
        let Some((place, facts)) = place.and_then(|place| Some((place, self.facts::<AuxiliarySort>(place)?))) else {
            // The sort of level that an output with errors takes is unknown.
            if level_word(&phrase.value).is_none() {
                self.evaluate(&phrase.value, scope);
            }
            return None;
        };
        let (sort, name) = match facts.is_graded {
            true => {
                let share = Sort::Quantity { dimension: Dimension::NUMBER, range: Range::Share };
                (share, format!("the level of `{}`", self.named(place).0))
            }
            false => (Sort::Word(Level::CHOICES), "the level of an output".to_owned()),
        };
        let doc = if facts.is_graded { "a share of it, as `60 %`".to_owned() } else { String::new() };
        let wanted = WantedName { name, doc, declared: None };
        if let Some(word) = level_word(&phrase.value).filter(|_| facts.is_graded) {
            self.sink.push(errors::word_for_share(phrase.value.span, &wanted.name, word));
            return None;
        }
        let level = self.accept(sort, &phrase.value, scope, &wanted);
        let (name, declared) = self.named(place);
        if facts.pulse_ns.is_some() {
            self.sink.push(errors::level_of_trigger(step, name, declared));
            return None;
        }
        let action = match level? {
            Value::Quantity(share) => AuxiliaryAction::Volts(between([facts.low_v, facts.high_v], share.si)),
            Value::Text(word) => match Level::find(&word)? {
                Level::High => AuxiliaryAction::High,
                Level::Low => AuxiliaryAction::Low,
            },
            _ => return None,
        };
        Some((self.enlist_output(place)?, action))
    }

    /// Records that an output is switched, and returns its name; `None` after an error, if another output has the same
    /// name.
    fn enlist_output(&mut self, place: DeclarationPlace) -> Option<String> {
        let (name, declared) = self.named(place);
        let first = *self.outputs_by_name.entry(name.to_owned()).or_insert(place);
        if first != place {
            let earlier = self.named(first).1;
            self.sink.push(errors::outputs_of_one_name(name, declared, earlier));
            return None;
        }
        Some(name.to_owned())
    }

    /// The outputs that the jobs switch, by name, each with its facts and its declaration.
    pub fn outputs_of(&self, jobs: &[Job]) -> BTreeMap<String, (AuxiliaryOutput, DeclarationPlace)> {
        let names: BTreeSet<&String> = jobs.iter().flat_map(|job| &job.events).map(|event| &event.output).collect();
        let known = |name: &String| {
            let place = *self.outputs_by_name.get(name)?;
            Some((name.clone(), (self.outputs.facts.get(&place).copied().flatten()?, place)))
        };
        names.into_iter().filter_map(known).collect()
    }

    /// The outputs of the user's files that rest at a voltage and are wired to instruments of a bench: whoever plays
    /// the schedule must hold that voltage, though no step switches it.
    pub fn resting_outputs(
        &self,
        wiring: &Wiring,
        bench: &Bench,
    ) -> BTreeMap<String, (AuxiliaryOutput, DeclarationPlace)> {
        let all = self.outputs.facts.iter().filter_map(|(place, facts)| Some((*place, (*facts)?)));
        let resting = all.filter(|(place, facts)| {
            let mut drives = wiring.drives(*place);
            facts.rest_v != 0.0 && drives.any(|drive| bench.instruments.contains_key(&drive.instrument))
        });
        resting.map(|(place, facts)| (self.named(place).0.to_owned(), (facts, place))).collect()
    }

    /// The outputs of the user's files that are wired to instruments of a program and that it does not switch.
    pub fn idle_outputs(&self, wiring: &Wiring, claims: &Claims) -> Vec<(String, Drive)> {
        let all = self.outputs.facts.keys().map(|place| (self.named(*place).0, *place));
        let idle = all.filter(|(name, _)| !claims.outputs.contains_key(*name));
        let wired =
            idle.flat_map(|(name, place)| wiring.drives(place).map(move |drive| (name.to_owned(), drive.clone())));
        wired.filter(|(_, drive)| claims.bench.instruments.contains_key(&drive.instrument)).collect()
    }
}

/// The level of a bare word, for an output with two levels.
fn level_word(expr: &Expr) -> Option<Level> {
    let ExprKind::Path(path) = &expr.kind else { return None };
    Level::find(&super::scope::path_text(path))
}

/// The voltage at a share of the way between two voltages.
fn between([low_v, high_v]: [f64; 2], share: f64) -> f64 {
    (low_v + (high_v - low_v) * share).clamp(low_v.min(high_v), low_v.max(high_v))
}

/// The output that a step names, as in `set light high` and `pulse camera for 5 ms`.
fn written_output(step: &Step) -> Option<&str> {
    let object = step.object.as_ref().and_then(|object| match &object.kind {
        ExprKind::Path(path) => path.segments.first().map(|segment| segment.name.text.as_str()),
        _ => None,
    });
    step.noun.as_ref().map(|noun| noun.text.as_str()).or(object)
}
