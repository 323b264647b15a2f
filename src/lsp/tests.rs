//! The words that highlighters in editors, web pages and books colour are those of the compiler.

use crate::check::frames;
use crate::check::scope::STEP_WORDS;
use crate::device::Kind;
use crate::quantity::{PLAIN, PREFIXED, PREFIXES};
use crate::syntax::RESERVED;
use crate::syntax::functions::function_names;
use std::collections::{BTreeMap, BTreeSet};

/// The word list from which the highlighters in `editors` are generated.
const EDITORS: &str = include_str!("../../editors/words.json");

const PAGE: &str = include_str!("../../assets/page/program.js");

type Words = BTreeSet<&'static str>;

/// The words of the compiler's tables, by the names of the lists.
fn words() -> BTreeMap<&'static str, Words> {
    let vocabularies = || Kind::ALL.iter().map(|kind| kind.vocabulary());
    let verbs = || vocabularies().flat_map(|vocabulary| vocabulary.verbs_and_conditions());
    let steps = STEP_WORDS.into_iter().chain(["run"]).chain(verbs().map(|verb| verb.name));
    let nouns = vocabularies().flat_map(|vocabulary| vocabulary.nouns).map(|noun| noun.name);
    BTreeMap::from([
        ("reserved", RESERVED.into()),
        ("functions", function_names().collect()),
        ("steps", steps.collect()),
        ("step_nouns", verbs().filter_map(|verb| verb.noun).collect()),
        ("nouns", nouns.chain([frames::NOUN]).collect()),
        ("units", PLAIN.iter().map(|unit| unit.0).collect()),
        ("prefixed_units", PREFIXED.iter().map(|unit| unit.0).collect()),
        ("prefixes", PREFIXES.iter().map(|prefix| prefix.0).collect()),
    ])
}

#[test]
fn editors_know_the_words_of_the_language() {
    let lists: BTreeMap<String, Vec<&str>> = serde_json::from_str(EDITORS).expect("lists of words");
    for (name, words) in words() {
        assert_eq!(lists[name], Vec::from_iter(words), "`{name}` of editors/words.json");
    }
    // Lists that only the grammar has.
    let of_grammar = ["declarations", "operators", "prepositions", "truths"];
    let known: BTreeSet<&str> = words().into_keys().chain(of_grammar).collect();
    assert_eq!(lists.keys().map(String::as_str).collect::<BTreeSet<_>>(), known);
    for name in ["declarations", "prepositions", "truths"] {
        assert!(lists[name].iter().all(|word| RESERVED.contains(word)), "`{name}`");
    }
}

#[test]
fn pages_know_the_words_of_the_language() {
    let list = PAGE.split("const WORDS").nth(1).and_then(|rest| rest.split(';').next()).expect("a list of words");
    let shown: BTreeSet<&str> = list.split(['"', ' ', '\n', '(', ')', '+']).collect();
    for (name, words) in words().into_iter().filter(|(name, _)| matches!(*name, "reserved" | "steps" | "nouns")) {
        let missing: Vec<&str> = words.into_iter().filter(|word| !shown.contains(word)).collect();
        assert!(missing.is_empty(), "`{name}` on pages: {missing:?}");
    }
}
