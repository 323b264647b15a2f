//! Verbs with their nouns, objects, prepositions and braces, checked against the kind's vocabulary.

use super::Checker;
use super::errors::{self, WantedName};
use super::lets::Argument;
use super::scope::{STEP_WORDS, Scope, nearest, path_text};
use crate::device::{self, Count, Vocabulary};
use crate::source::Span;
use crate::syntax::tree::{self, Entry, Expr, ExprKind};
use std::collections::BTreeMap;

/// A verb with its object and its prepositions, each accepted by the vocabulary.
pub struct Call {
    pub verb: &'static device::Verb,
    pub object: Option<Argument>,
    pub phrases: Vec<(&'static str, Argument)>,
    /// The entries in its braces.
    pub entries: Vec<Entered>,
    pub span: Span,
}

/// An entry of a verb's braces: an object with its prepositions.
pub struct Entered {
    pub object: Argument,
    pub phrases: Vec<(&'static str, Argument)>,
    pub span: Span,
}

impl Checker<'_> {
    /// A step that is a verb with its object and its prepositions; `None` after an error.
    pub fn verb(&mut self, step: &tree::Step, scope: &Scope, vocabulary: &'static Vocabulary) -> Option<Call> {
        let noun = step.noun.as_ref().map(|noun| noun.text.as_str());
        let Some(verb) = vocabulary.verb_of(&step.head.text, noun) else {
            let verbs = vocabulary.verbs.iter().map(|verb| verb.name);
            let near = nearest(&step.head.text, verbs.chain(STEP_WORDS));
            self.sink.push(match step.head.text.as_str() {
                "maximize" | "maximise" => errors::maximized(step.head.span, vocabulary),
                "then" if step.noun.is_none() && step.phrases.is_empty() => errors::second_objective(step.head.span),
                "then" => errors::then_before_step(step.head.span),
                "start" if vocabulary.state.is_some() && step.phrases.is_empty() => {
                    errors::start_without_at(step.head.span)
                }
                word if vocabulary.settings.iter().any(|setting| setting.name == word) => {
                    errors::setting_without_colon(&step.head)
                }
                verb => errors::unknown_verb(step.head.span, verb, vocabulary, near),
            });
            return None;
        };
        self.verb_call(step, scope, verb)
    }

    /// Reads the use of a verb or of a task's condition; `None` after an error.
    pub fn verb_call(&mut self, step: &tree::Step, scope: &Scope, verb: &'static device::Verb) -> Option<Call> {
        self.noun(step, verb)?;
        let entries = self.braces(step, verb, scope);
        let object = self.verb_object(step, verb, scope);
        // `move [a, b] to [(5, 3), (7, 6)]` is one mistake.
        let is_list = |expr: &Expr| matches!(expr.kind, ExprKind::List(_));
        if object.is_none() && step.object.as_ref().is_some_and(is_list) {
            return None;
        }
        let phrases = self.phrases(step, verb, verb.phrases, scope);
        Some(Call { verb, object: object?, phrases: phrases?, entries: entries?, span: step.span })
    }

    /// Checks that the noun before the object is the verb's own; `None` after an error.
    fn noun(&mut self, step: &tree::Step, verb: &'static device::Verb) -> Option<()> {
        match (&step.noun, verb.noun) {
            (None, None) => return Some(()),
            (Some(noun), Some(own)) if noun.text == own => return Some(()),
            (Some(noun), Some(own)) => {
                let near = nearest(&noun.text, [own]);
                self.sink.push(errors::wrong_noun(noun, verb, own, near));
            }
            // An object that could not be read was reported.
            (Some(_), None) if matches!(&step.object, Some(Expr { kind: ExprKind::Error, .. })) => {}
            // `rotate bead 80 deg`: the word is the object, and the preposition of what follows is missing.
            (Some(_), None) if step.object.is_some() && !verb.phrases.is_empty() => {
                let (amount, value) = step.object.as_ref().map_or((false, step.span), |it| (is_amount(it), it.span));
                let lacking = preposition_before(amount, verb).unwrap_or_default();
                self.sink.push(errors::missing_preposition(value, verb, lacking));
            }
            (Some(noun), None) => self.sink.push(errors::unexpected_part(noun.span, verb, "a noun")),
            (None, Some(own)) => self.sink.push(errors::missing_part(step.span, verb, &format!("`{own}`"))),
        }
        None
    }

    /// The entries in a verb's braces; `None` after an error.
    fn braces(&mut self, step: &tree::Step, verb: &'static device::Verb, scope: &Scope) -> Option<Vec<Entered>> {
        match (&step.block, verb.block) {
            (None, None) => Some(Vec::new()),
            (Some(_), None) => {
                self.sink.push(errors::unexpected_part(step.head.span, verb, "a block"));
                None
            }
            (None, Some(_)) => {
                self.sink.push(errors::missing_part(step.span, verb, "its braces"));
                None
            }
            (Some(entries), Some(block)) => {
                let mut entered = Vec::new();
                let is_whole = self.entered(entries, &mut scope.clone(), verb, block, &mut entered);
                is_whole.then_some(entered)
            }
        }
    }

    /// Collects the entries of a verb's braces into `found`; `false` if any was left out because of an error.
    fn entered(
        &mut self,
        entries: &[Entry],
        scope: &mut Scope,
        verb: &'static device::Verb,
        block: &'static device::Block,
        found: &mut Vec<Entered>,
    ) -> bool {
        let mut is_whole = true;
        for entry in entries {
            is_whole &= match entry {
                Entry::Step(step) => match self.one_entered(step, scope, verb, block) {
                    Some(one) => {
                        found.push(one);
                        true
                    }
                    None => false,
                },
                Entry::For(each) => {
                    let mut all = true;
                    self.repeat(each, scope, &mut |checker, scope| {
                        all &= checker.entered(&each.entries, scope, verb, block, found);
                    });
                    all
                }
                Entry::Field(field) => {
                    self.sink.push(errors::no_entry(field.name.span, verb));
                    false
                }
                Entry::Error(_) => false,
            };
        }
        is_whole
    }

    /// `D3 to pose(…)`: the head is the object.
    fn one_entered(
        &mut self,
        step: &tree::Step,
        scope: &Scope,
        verb: &'static device::Verb,
        block: &'static device::Block,
    ) -> Option<Entered> {
        if step.noun.is_some() || step.object.is_some() || step.block.is_some() {
            self.sink.push(errors::no_entry(step.span, verb));
            return None;
        }
        let name = tree::IndexedName { name: step.head.clone(), indices: step.indices.clone(), span: step.head.span };
        let path = tree::Path { segments: vec![name], span: step.head.span };
        let head = Expr { kind: ExprKind::Path(path), span: step.head.span };
        let wanted = WantedName { name: format!("`{}`", verb.name), doc: verb.doc.to_owned(), declared: None };
        let object = self.accept(block.object, &head, scope, &wanted);
        let object = object.map(|value| self.argument_of(&head, value, scope));
        let phrases = self.phrases(step, verb, block.phrases, scope);
        Some(Entered { object: object?, phrases: phrases?, span: step.span })
    }

    fn verb_object(
        &mut self,
        step: &tree::Step,
        verb: &'static device::Verb,
        scope: &Scope,
    ) -> Option<Option<Argument>> {
        match (&step.object, verb.object) {
            (None, None) => Some(None),
            (Some(expr), Some(sort)) => {
                if let Some((lacking, place)) = self.without_preposition(expr, verb, scope) {
                    self.sink.push(errors::missing_preposition(place, verb, lacking));
                    return None;
                }
                let wanted = WantedName { name: format!("`{}`", verb.name), doc: verb.doc.to_owned(), declared: None };
                let value = self.accept(sort, expr, scope, &wanted)?;
                Some(Some(self.argument_of(expr, value, scope)))
            }
            (Some(Expr { kind: ExprKind::Error, .. }), None) => None,
            (Some(expr), None) => {
                let lacking = verb.phrases.iter().find(|entry| {
                    entry.count.is_needed() && step.phrases.iter().all(|p| p.preposition.text != entry.preposition)
                });
                self.sink.push(match lacking {
                    Some(lacking) => errors::missing_preposition(expr.span, verb, lacking.preposition),
                    None => errors::unexpected_part(expr.span, verb, "an object"),
                });
                None
            }
            (None, Some(sort)) => {
                self.sink.push(errors::missing_part(step.span, verb, &lacking(sort)));
                None
            }
        }
    }

    /// The preposition that `move m1 (5, 3)` lacks, and where: what parses as a function call is an object and its
    /// place.
    fn without_preposition(
        &self,
        expr: &Expr,
        verb: &'static device::Verb,
        scope: &Scope,
    ) -> Option<(&'static str, Span)> {
        let ExprKind::Call { function, .. } = &expr.kind else { return None };
        let names_object = matches!(verb.object, Some(device::Sort::Object(_)));
        let is_function =
            super::scope::reserved_as(&path_text(function)).is_some() || self.names_value(function, scope);
        let place = Span { start: function.span.end, ..expr.span };
        let lacking = preposition_before(false, verb).filter(|_| names_object && !is_function);
        lacking.map(|preposition| (preposition, place))
    }

    fn phrases(
        &mut self,
        step: &tree::Step,
        verb: &'static device::Verb,
        known: &'static [device::VocabularyPhrase],
        scope: &Scope,
    ) -> Option<Vec<(&'static str, Argument)>> {
        let mut accepted = Vec::new();
        let mut is_whole = true;
        let mut seen: BTreeMap<&str, Span> = BTreeMap::new();
        for phrase in &step.phrases {
            let name = phrase.preposition.text.as_str();
            let Some(entry) = known.iter().find(|entry| entry.preposition == name) else {
                self.sink.push(errors::unknown_preposition(&phrase.preposition, verb, known));
                is_whole = false;
                continue;
            };
            if let Some(earlier) =
                seen.insert(name, phrase.preposition.span).filter(|_| entry.count != Count::AnyNumber)
            {
                self.sink.push(errors::preposition_twice(&phrase.preposition, earlier, verb));
                is_whole = false;
            }
            let wanted =
                WantedName { name: format!("`{name}` of `{}`", verb.name), doc: String::new(), declared: None };
            match self.accept(entry.sort, &phrase.value, scope, &wanted) {
                Some(value) => accepted.push((entry.preposition, self.argument_of(&phrase.value, value, scope))),
                None => is_whole = false,
            }
        }
        // An object where none belongs stands for the missing phrase, as a wrong phrase does, and was already reported.
        let lacks_preposition =
            step.object.as_ref().is_some_and(|expr| self.without_preposition(expr, verb, scope).is_some());
        let is_reported = !is_whole || (step.object.is_some() && verb.object.is_none()) || lacks_preposition;
        let is_lacking = |entry: &&device::VocabularyPhrase| match entry.count {
            Count::Once => !seen.contains_key(entry.preposition),
            Count::OnceUnless(other) => !seen.contains_key(entry.preposition) && !seen.contains_key(other),
            Count::AtMostOnce | Count::AnyNumber => false,
        };
        for entry in known.iter().filter(|entry| !is_reported && is_lacking(entry)) {
            self.sink.push(errors::missing_part(step.span, verb, &format!("`{}`", entry.preposition)));
            is_whole = false;
        }
        is_whole.then_some(accepted)
    }
}

/// Whether an expression is a literal number, with or without a unit.
fn is_amount(value: &Expr) -> bool {
    match &value.kind {
        ExprKind::Number(_) | ExprKind::Quantity { .. } => true,
        ExprKind::Negative(inner) => is_amount(inner),
        _ => false,
    }
}

/// The preposition that a value without one most likely lacks: the first required one of those that take such values.
fn preposition_before(is_amount: bool, verb: &'static device::Verb) -> Option<&'static str> {
    let fits = |phrase: &&device::VocabularyPhrase| {
        matches!(phrase.sort, device::Sort::Quantity { .. } | device::Sort::Count { .. }) == is_amount
    };
    let is_needed = |phrase: &&device::VocabularyPhrase| phrase.count.is_needed();
    let mut fitting = verb.phrases.iter().filter(fits);
    let found = fitting.clone().find(is_needed).or(fitting.next()).or(verb.phrases.first());
    found.map(|phrase| phrase.preposition)
}

/// Diagnostic text for a verb without its object.
fn lacking(sort: device::Sort) -> String {
    if let device::Sort::Object(noun) = sort { format!("a {noun}") } else { "an object".to_owned() }
}
