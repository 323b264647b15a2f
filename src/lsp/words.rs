//! The words of the vocabulary at a place: what they mean, and which may stand there.
//!
//! The words are those of the kinds whose published devices the text uses, or of all kinds if it uses none, and stand in the tables
//! that the checker reads.

use super::outline;
use super::planning::ProgramPlans;
use super::text::{ColumnUnit, EditedText};
use crate::check::scope::{FUNCTIONS, function_form};
use crate::device::instrument::{AuxiliarySort, Family};
use crate::device::{Kind, Vocabulary, VocabularyField};
use crate::syntax::tree::{Item, Tree, UsePath};
use lsp_types::{CompletionItem, CompletionItemKind, Documentation, Hover, HoverContents, MarkupContent, MarkupKind};
use std::collections::BTreeMap;

/// The words that begin a declaration, with its form.
const DECLARATIONS: [(&str, &str); 9] = [
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

/// Settings and steps that tasks of all kinds have.
pub(super) const COMMON_STEPS: [(&str, &str); 10] = [
    ("minimize", "minimize WHAT: the figure that the plan minimises"),
    ("require", "require FIGURE <= LIMIT: a limit that the plan must keep"),
    ("using", "using PLANNER { expansions: 5000000 }: how the plan is searched"),
    ("wait", "wait 10 ms: nothing is switched for so long; wait until card.port0.line5 for at most 5 s"),
    ("prompt", "prompt \"add the sample\": asks the person at the bench, and waits"),
    ("pulse", "pulse OUTPUT: a pulse of an output of the sort `trigger`"),
    ("set", "set OUTPUT to high, to low, or to 60 %: the level of an output"),
    ("together", "together { GOALS }: at the same time, where the kind can"),
    ("assay", "assay { OPERATIONS }: each part in its own time, where the kind can"),
    ("for", "for i in 0..5 { … }: once for each"),
];

/// A word with its form and its meaning.
struct KnownWord {
    word: &'static str,
    form: String,
    meaning: String,
    kind: CompletionItemKind,
}

/// The meaning of the word at a byte of a text.
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

/// The words that may stand at a byte of a text, and the names that it declares.
pub fn completions(text: &str, at: usize) -> Vec<CompletionItem> {
    let tree = outline::tree(text);
    let kinds = kinds(&tree);
    let around = tree.items.iter().find(|item| item.span().start < at as u32 && at as u32 <= item.span().end);
    let is_inside = text[..at].matches('{').count() > text[..at].matches('}').count();
    let mut items: BTreeMap<String, CompletionItem> = BTreeMap::new();
    let mut add = |word: &str, form: &str, meaning: &str, kind: CompletionItemKind| {
        let documentation = (!meaning.is_empty()).then(|| Documentation::String(meaning.to_owned()));
        let item = CompletionItem {
            label: word.to_owned(),
            detail: Some(form.to_owned()),
            documentation,
            kind: Some(kind),
            ..CompletionItem::default()
        };
        items.entry(word.to_owned()).or_insert(item);
    };
    if !is_inside {
        DECLARATIONS.iter().for_each(|(word, form)| add(word, form, "", CompletionItemKind::KEYWORD));
    } else {
        let is_wanted = |kind: CompletionItemKind| match around {
            Some(Item::Device(_) | Item::Instrument(_) | Item::Output(_)) => kind == CompletionItemKind::FIELD,
            Some(Item::Scene(_)) => kind == CompletionItemKind::CLASS,
            Some(Item::Task(_)) => kind != CompletionItemKind::FIELD && kind != CompletionItemKind::CLASS,
            _ => true,
        };
        let of_instruments = matches!(around, Some(Item::Instrument(_) | Item::Output(_) | Item::Wiring(_)));
        for known in known_words(&kinds, of_instruments).iter().filter(|known| is_wanted(known.kind)) {
            add(known.word, &known.form, &known.meaning, known.kind);
        }
        if is_wanted(CompletionItemKind::KEYWORD) {
            COMMON_STEPS.iter().for_each(|(word, form)| add(word, form, "", CompletionItemKind::KEYWORD));
        }
    }
    for (name, sort) in names(&tree) {
        add(&name, sort, "", CompletionItemKind::VARIABLE);
    }
    items.into_values().collect()
}

/// The kinds that a text uses by their published devices; all if there is none.
fn kinds(tree: &Tree) -> Vec<&'static Vocabulary> {
    let used = |kind: &&Kind| {
        tree.items.iter().any(|item| match item {
            Item::Use(item) => match &item.path {
                UsePath::Library { words, .. } => words.iter().any(|word| word.text == kind.name()),
                UsePath::File(_) => false,
            },
            Item::Let(_)
            | Item::Device(_)
            | Item::Instrument(_)
            | Item::Output(_)
            | Item::Scene(_)
            | Item::Task(_)
            | Item::Program(_)
            | Item::Wiring(_)
            | Item::Error(_) => false,
        })
    };
    let own: Vec<&Kind> = Kind::ALL.iter().filter(used).collect();
    let shown = if own.is_empty() { Kind::ALL.iter().collect() } else { own };
    shown.into_iter().map(|kind| kind.vocabulary()).collect()
}

fn known_words(kinds: &[&'static Vocabulary], with_instruments: bool) -> Vec<KnownWord> {
    let mut words = Vec::new();
    let field = |field: &VocabularyField, kind| KnownWord {
        word: field.name,
        form: field.term(),
        meaning: field.meaning(),
        kind,
    };
    let mut push = |word, form: String, meaning: &str, kind| {
        words.push(KnownWord { word, form, meaning: meaning.to_owned(), kind });
    };
    for vocabulary in kinds {
        for verb in vocabulary.verbs_and_conditions() {
            push(verb.name, verb.example.to_owned(), &verb.meaning(), CompletionItemKind::METHOD);
        }
        for noun in vocabulary.nouns {
            push(noun.name, noun.name.to_owned(), noun.doc, CompletionItemKind::CLASS);
        }
        for objective in vocabulary.objectives {
            push(
                objective.name,
                format!("minimize {}", objective.name),
                objective.doc,
                CompletionItemKind::ENUM_MEMBER,
            );
        }
        for outcome in vocabulary.outcomes {
            let form = format!("require {}: {}", outcome.name, outcome.unit.dimension().name());
            push(outcome.name, form, outcome.doc, CompletionItemKind::ENUM_MEMBER);
        }
        for planner in vocabulary.planners {
            push(planner.name, format!("using {}", planner.name), planner.doc, CompletionItemKind::ENUM_MEMBER);
        }
    }
    for function in FUNCTIONS {
        words.push(KnownWord {
            word: function.name,
            form: function_form(function.name).unwrap_or_default(),
            meaning: function.doc.to_owned(),
            kind: CompletionItemKind::FUNCTION,
        });
    }
    for vocabulary in kinds {
        words.extend(vocabulary.fields.iter().map(|own| field(own, CompletionItemKind::FIELD)));
        words.extend(vocabulary.settings.iter().map(|own| field(own, CompletionItemKind::PROPERTY)));
    }
    if with_instruments {
        for family in Family::ALL {
            words.extend(family.fields().iter().map(|own| field(own, CompletionItemKind::FIELD)));
        }
        for sort in AuxiliarySort::ALL {
            words.extend(sort.fields().iter().map(|own| field(own, CompletionItemKind::FIELD)));
        }
    }
    words
}

/// The names that a text declares, with what they are.
fn names(tree: &Tree) -> Vec<(String, &'static str)> {
    let name = |item: &Item| match item {
        Item::Let(item) => Some((item.name.text.clone(), "let")),
        Item::Device(item) => Some((item.name.text.clone(), "device")),
        Item::Instrument(item) => Some((item.name.text.clone(), "instrument")),
        Item::Output(item) => Some((item.name.text.clone(), "output")),
        Item::Scene(item) => Some((item.name.text.clone(), "scene")),
        Item::Task(item) => Some((item.name.text.clone(), "task")),
        Item::Program(item) => Some((item.name.text.clone(), "program")),
        Item::Use(_) | Item::Wiring(_) | Item::Error(_) => None,
    };
    tree.items.iter().filter_map(name).filter(|(name, _)| !name.is_empty()).collect()
}
