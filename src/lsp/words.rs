//! Hover texts: the words of the vocabulary and their meanings.
//!
//! The words are those of the kinds whose published devices the text uses, or of all kinds if it uses none; they come
//! from the tables that the checker reads.

use super::outline;
use super::planning::ProgramPlans;
use super::text::{ColumnUnit, EditedText};
use crate::device::instrument::{AuxiliarySort, Family};
use crate::device::{Kind, Vocabulary, VocabularyField};
use crate::syntax::functions::{FUNCTIONS, function_form};
use crate::syntax::tree::{Item, Tree, Use, UsePath};
use lsp_types::{Hover, HoverContents, MarkupContent, MarkupKind};

/// The words that begin a declaration, each with its form.
pub(super) const DECLARATIONS: [(&str, &str); 9] = [
    ("use", "use std.dimibot, or use \"bench.twz\" as lab"),
    ("let", "let NAME = VALUE"),
    ("device", "device NAME : KIND { FIELD: VALUE }"),
    ("instrument", "instrument NAME : FAMILY { FIELD: VALUE }"),
    ("output", "output NAME : trigger { duration: 5 ms }, or output NAME : digital"),
    ("scene", "scene NAME { obstacle NAME : SHAPE at PLACE }"),
    ("task", "task NAME on DEVICE in SCENE { minimize WHAT, STEPS }"),
    ("program", "program NAME { run TASK, wait 10 ms }"),
    ("wiring", "wiring DEVICE { CHANNEL -> OUTPUT }"),
];

/// Settings and steps that tasks of every kind have, each with its form.
pub(super) const COMMON_STEPS: [(&str, &str); 11] = [
    ("minimize", "minimize WHAT: the figure that the plan minimises"),
    ("require", "require FIGURE <= LIMIT: a limit that the plan must keep"),
    ("using", "using PLANNER { expansions: 5000000 }: how the plan is searched"),
    ("start", "start at STATE: where the device is at the beginning of the task"),
    ("wait", "wait 10 ms: nothing is switched for this time; wait until card.port0.line5 for at most 5 s"),
    ("prompt", "prompt \"add the sample\": asks the person at the bench and waits for the answer"),
    ("pulse", "pulse OUTPUT: a pulse of an output of the sort `trigger`"),
    ("set", "set OUTPUT to high, to low, or to 60 %: the level of an output"),
    ("together", "together { GOALS }: goals at the same time, if the kind of device allows it"),
    ("assay", "assay { OPERATIONS }: each part in its own time, if the kind of device allows it"),
    ("for", "for i in 0..5 { … }: once for each value"),
];

/// A word with its form and its meaning.
pub(super) struct KnownWord {
    pub(super) word: &'static str,
    form: String,
    meaning: String,
}

/// Hover text for the word at a byte of a text.
pub fn hover(text: &EditedText, at: usize, unit: ColumnUnit, plans: &ProgramPlans) -> Option<Hover> {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let source = text.as_str();
    let start = source[..at]
        .rfind(|c| !is_part(c))
        .map_or(0, |before| before + source[before..].chars().next().map_or(1, char::len_utf8));
    let end = source[at..].find(|c| !is_part(c)).map_or(source.len(), |end| at + end);
    let word = &source[start..end];
    let tree = outline::tree(source);
    let all =
        known_words(&kinds(&tree), tree.items.iter().any(|item| matches!(item, Item::Instrument(_) | Item::Output(_))));
    let of_kinds = all.into_iter().filter(|known| known.word == word);
    let common = DECLARATIONS.iter().chain(&COMMON_STEPS).filter(|known| known.0 == word);
    let mut lines: Vec<String> = of_kinds.map(|known| format!("`{}`\n\n{}", known.form, known.meaning)).collect();
    lines.extend(common.map(|known| format!("`{}`", known.1)));
    lines.dedup();
    lines.extend(plans.summary(word).map(|summary| summary.value));
    let value = lines.join("\n\n---\n\n");
    (!value.is_empty()).then(|| Hover {
        contents: HoverContents::Markup(MarkupContent { kind: MarkupKind::Markdown, value }),
        range: Some(text.range(start..end, unit)),
    })
}

/// The kinds whose published devices a text uses; all kinds if it uses none.
pub(super) fn kinds(tree: &Tree) -> Vec<&'static Vocabulary> {
    let used = |kind: &&Kind| {
        tree.items.iter().any(|item| {
            let Item::Use(Use { path: UsePath::Library { words, .. }, .. }) = item else { return false };
            words.iter().any(|word| word.text == kind.name())
        })
    };
    let own: Vec<&Kind> = Kind::ALL.iter().filter(used).collect();
    let shown = if own.is_empty() { Kind::ALL.iter().collect() } else { own };
    shown.into_iter().map(|kind| kind.vocabulary()).collect()
}

/// All words of some kinds, optionally with those of instruments.
pub(super) fn known_words(kinds: &[&'static Vocabulary], with_instruments: bool) -> Vec<KnownWord> {
    let field = |field: &VocabularyField| KnownWord { word: field.name, form: field.term(), meaning: field.meaning() };
    let mut words = Vec::new();
    let mut push = |word, form: String, meaning: &str| {
        words.push(KnownWord { word, form, meaning: meaning.to_owned() });
    };
    for vocabulary in kinds {
        for verb in vocabulary.verbs_and_conditions() {
            push(verb.name, verb.example.to_owned(), &verb.meaning());
        }
        for noun in vocabulary.nouns {
            push(noun.name, noun.name.to_owned(), noun.doc);
        }
        for objective in vocabulary.objectives {
            push(objective.name, format!("minimize {}", objective.name), objective.doc);
        }
        for outcome in vocabulary.outcomes {
            push(outcome.name, outcome.condition(), outcome.doc);
        }
        for planner in vocabulary.planners {
            push(planner.name, format!("using {}", planner.name), planner.doc);
        }
    }
    for function in FUNCTIONS {
        push(function.name, function_form(function.name).unwrap_or_default(), function.doc);
    }
    for vocabulary in kinds {
        words.extend(vocabulary.fields.iter().chain(vocabulary.settings).map(field));
    }
    if with_instruments {
        words.extend(Family::ALL.iter().flat_map(|family| family.fields()).map(field));
        words.extend(AuxiliarySort::ALL.iter().flat_map(|sort| sort.fields()).map(field));
    }
    words
}
