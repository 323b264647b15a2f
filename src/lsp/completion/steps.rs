//! Completion in tasks and programs: their steps, with the prepositions and values that each verb takes.

use super::{DeclaredName, Suggestions, is_complete};
use crate::device::{self, Assay, Count, Together, Verb, Vocabulary, VocabularyPhrase};
use crate::lsp::words::COMMON_STEPS;
use crate::quantity::Dimension;
use lsp_types::CompletionItemKind;

impl Suggestions<'_> {
    pub(super) fn task(&mut self, outer: &[&str], inner: &[Vec<&str>]) {
        let kinds = self.kinds_behind("on", outer);
        let blocks: Vec<&[&str]> = inner
            .iter()
            .map(Vec::as_slice)
            .filter(|head| !matches!(head.first(), Some(&"for" | &"together" | &"assay")))
            .collect();
        match blocks.last() {
            None => self.step(&kinds),
            Some(["using", planner]) => {
                let planners = kinds.iter().flat_map(|kind| kind.planners).filter(|known| known.name == *planner);
                self.fields(planners.flat_map(|planner| planner.options).collect());
            }
            Some([verb, ..]) if !blocks[0].contains(&":") => {
                let block = kinds.iter().find_map(|kind| kind.verb(verb)?.block);
                let Some(block) = block else { return };
                match self.entry() {
                    [] => self.value(Some(&block.object), &[]),
                    entry => self.phrases(entry, block.phrases),
                }
            }
            Some(head) => self.braces_of_value(head),
        }
    }

    /// Completes an entry of a task or of a block in it.
    fn step(&mut self, kinds: &[&'static Vocabulary]) {
        let entry = self.entry();
        let settings = || kinds.iter().flat_map(|kind| kind.settings);
        match entry {
            [] => {
                self.first_words(kinds);
                settings().for_each(|field| {
                    self.word(field.name, &field.term(), &field.meaning(), CompletionItemKind::PROPERTY)
                });
            }
            ["minimize"] => {
                kinds.iter().for_each(|kind| self.choices(kind.objectives));
            }
            ["require"] => {
                for outcome in kinds.iter().flat_map(|kind| kind.outcomes) {
                    self.word(outcome.name, &outcome.condition(), outcome.doc, CompletionItemKind::ENUM_MEMBER);
                }
                self.objects("part");
            }
            ["require", outcome, limit @ ..] => {
                let outcome = kinds.iter().flat_map(|kind| kind.outcomes).find(|known| known.name == *outcome);
                let sort = outcome.map(|outcome| device::positive(outcome.unit.dimension()));
                self.value(sort.as_ref(), limit);
            }
            ["using"] => {
                for planner in kinds.iter().flat_map(|kind| kind.planners) {
                    self.word(
                        planner.name,
                        &format!("using {}", planner.name),
                        planner.doc,
                        CompletionItemKind::ENUM_MEMBER,
                    );
                }
            }
            [name, tail @ ..] if tail.first() == Some(&":") => {
                let setting = settings().find(|field| field.name == *name);
                self.value(setting.map(|field| &field.sort), tail);
            }
            ["for", ..] => self.loop_head(),
            ["start"] => self.keywords(&["at"]),
            _ if self.common_step() => {}
            [verb, ..] => self.verb(kinds, verb),
        }
    }

    /// Adds the words that begin a step of the given kinds.
    fn first_words(&mut self, kinds: &[&'static Vocabulary]) {
        for verb in kinds.iter().flat_map(|kind| kind.verbs_and_conditions()) {
            self.word(verb.name, verb.example, &verb.meaning(), CompletionItemKind::METHOD);
        }
        for (word, form) in COMMON_STEPS {
            let is_of_kinds = kinds.iter().any(|kind| match word {
                "together" => matches!(kind.together, Together::Yes),
                "assay" => kind.assay == Assay::Yes,
                "start" => kind.state.is_some(),
                _ => true,
            });
            if is_of_kinds {
                self.word(word, form, "", CompletionItemKind::KEYWORD);
            }
        }
    }

    /// Completes a step that programs also have; returns whether the entry is one.
    pub(super) fn common_step(&mut self) -> bool {
        match self.entry() {
            ["set" | "pulse"] => self.names(&[DeclaredName::Output]),
            ["set", _] => self.keywords(&["to"]),
            ["set", _, "to"] => {
                self.keywords(&["high", "low"]);
                self.names(&[DeclaredName::Value]);
            }
            ["wait"] => {
                self.keywords(&["until"]);
                self.value(None, &[]);
            }
            ["wait", "until"] => self.names(&[DeclaredName::Instrument]),
            ["wait", duration] => self.value(Some(&device::positive(Dimension::TIME)), &[duration]),
            ["wait", "until", _] => self.keywords(&["for"]),
            ["wait", "until", _, "for"] => self.keywords(&["at"]),
            ["wait", "until", _, "for", "at"] => self.keywords(&["most"]),
            ["wait", "until", _, "for", "at", "most", limit @ ..] => {
                self.value(Some(&device::positive(Dimension::TIME)), limit);
            }
            ["set" | "pulse" | "wait" | "prompt", ..] => {}
            _ => return false,
        }
        true
    }

    fn verb(&mut self, kinds: &[&'static Vocabulary], word: &str) {
        let entry = self.entry();
        let noun = entry.get(1).copied();
        let verbs: Vec<&Verb> =
            kinds.iter().flat_map(|kind| kind.verbs_and_conditions()).filter(|verb| verb.name == word).collect();
        let with_noun = verbs.iter().find(|verb| verb.noun.is_some() && verb.noun == noun);
        let Some(verb) = with_noun.or(verbs.iter().find(|verb| verb.noun.is_none())).or(verbs.first()) else { return };
        let head = 1 + usize::from(with_noun.is_some());
        if entry.len() > head || self.cursor.in_brackets.is_some() && verb.object.is_none() {
            return self.phrases(entry, verb.phrases);
        }
        if with_noun.is_none() {
            verbs.iter().filter_map(|verb| verb.noun).for_each(|noun| self.keywords(&[noun]));
        }
        match &verb.object {
            Some(object) => self.value(Some(object), &[]),
            None => self.phrases(entry, verb.phrases),
        }
    }

    /// Completes after an object: the prepositions that the step does not have yet, or the value of the last one.
    fn phrases(&mut self, entry: &[&str], phrases: &[VocabularyPhrase]) {
        let phrase_of = |token: &str| phrases.iter().find(|phrase| phrase.preposition == token);
        let value = (0..entry.len()).rev().find_map(|at| Some((&phrase_of(entry[at])?.sort, &entry[at + 1..])));
        let written = value.map_or(entry, |value| value.1);
        let is_whole = self.cursor.in_brackets.is_none() && written.last().is_some_and(|last| is_complete(last));
        if is_whole {
            let may_follow =
                |phrase: &&VocabularyPhrase| phrase.count == Count::AnyNumber || !entry.contains(&phrase.preposition);
            phrases.iter().filter(may_follow).for_each(|phrase| self.keywords(&[phrase.preposition]));
        }
        match value {
            Some((sort, written)) => self.value(Some(sort), written),
            None if is_whole => {}
            None => self.value(None, entry),
        }
    }
}
