//! For any input the compiler ends without a panic and reports what it does not understand.

use super::support::{Built, build};
use proptest::prelude::*;
use proptest::sample::{Index, select};

/// Words, signs and values of the language, and some foreign ones.
const TOKENS: &[&str] = &[
    "use", "as", "let", "device", "scene", "task", "program", "wiring", "table", "true", "false", "to", "from", "by",
    "about", "for", "at", "via", "with", "in", "on", "move", "visit", "wait", "run", "together", "minimize", "using",
    "start", "require", "assemble", "std", ".", "dimibot", "femto_st", "electrode_array", "ea", "plate", "chip",
    "part", "droplet", "merge", "makespan", "sum_of_costs", "steps", "portfolio", "cooperative_astar", "may_yield",
    "hold", "separation", "as_published", "(3, 3)", "(0, 0)", "(99, 1)", "4", "1", "0", "bot", "bench", "obstacle",
    "disc", "box", "polygon", "capsule", "cells", "radius", "size", "points", "left", "right", "distance", "time",
    "pose", "sqrt", "min", "count", "x", "p", "i", "m1", "35", "0.138", "1e-3", "10_000", "0b101_01", "1e999",
    "99999999999999999999", "um", "ms", "V", "deg", "um/s", "µm", "kk", ":", ",", "->", "=", "<=", ">=", "==", "<",
    ">", "+", "-", "*", "/", "^", "..", "(", ")", "[", "]", "{", "}", "|", "\"", "\"a{i}b\"", "\"{{\"", "\n", "\n",
    "\n", " ", "//", "///", "//!", ";", "#", "@", "é", "\u{feff}", "\r\n", "\0",
];

const PROGRAM: &str = include_str!("../../examples/dimibot_fetch.twz");

const PAPER: &str = include_str!("../../examples/dimibot_paper.twz");

const UNEQUAL: &str = include_str!("../../examples/dimibot_unequal.twz");

/// Small boards, so that a program that a mutation makes unsolvable is quickly proven so.
const ARRAYS: &str = include_str!("../data/arrays.twz");

/// Whether schedules were returned or an error was reported, and the verifier did not refuse a planner's result.
fn is_answered(built: &Built) -> bool {
    let failed = built.codes.iter().any(|code| code.starts_with('E'));
    !built.refused && (failed == built.schedules.is_empty() || (!failed && built.schedules.is_empty()))
}

/// The tokens of a program: words, numbers, spaces, and single signs.
fn tokens(text: &str) -> Vec<&str> {
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let is_word = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
        let end = rest.find(|c| !is_word(c)).filter(|end| *end > 0).unwrap_or(if is_word(first) {
            rest.len()
        } else {
            first.len_utf8()
        });
        tokens.push(&rest[..end]);
        rest = &rest[end..];
    }
    tokens
}

/// A change to one token of a program.
#[derive(Debug, Clone)]
enum Mutation {
    Drop(Index),
    Double(Index),
    Swap(Index, Index),
    Replace(Index, &'static str),
    Insert(Index, &'static str),
}

fn mutation() -> impl Strategy<Value = Mutation> {
    prop_oneof![
        any::<Index>().prop_map(Mutation::Drop),
        any::<Index>().prop_map(Mutation::Double),
        (any::<Index>(), any::<Index>()).prop_map(|(a, b)| Mutation::Swap(a, b)),
        (any::<Index>(), select(TOKENS)).prop_map(|(at, token)| Mutation::Replace(at, token)),
        (any::<Index>(), select(TOKENS)).prop_map(|(at, token)| Mutation::Insert(at, token)),
    ]
}

fn mutated(text: &'static str, mutations: &[Mutation]) -> String {
    let mut tokens = tokens(text);
    for mutation in mutations {
        let at = |index: &Index| index.index(tokens.len());
        match mutation {
            Mutation::Drop(index) => drop(tokens.remove(at(index))),
            Mutation::Double(index) => tokens.insert(at(index), tokens[at(index)]),
            Mutation::Swap(one, other) => {
                let (one, other) = (at(one), at(other));
                tokens.swap(one, other);
            }
            Mutation::Replace(index, token) => {
                let index = at(index);
                tokens[index] = token;
            }
            Mutation::Insert(index, token) => tokens.insert(at(index), token),
        }
    }
    tokens.concat()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_soup_of_tokens_is_answered(soup in proptest::collection::vec(select(TOKENS), 0..80), blank in select(&["", " "][..])) {
        prop_assert!(is_answered(&build(&soup.join(blank))));
    }

    #[test]
    fn a_mutated_program_is_answered(
        program in select(&[PROGRAM, PAPER, UNEQUAL, ARRAYS, ARRAYS][..]),
        mutations in proptest::collection::vec(mutation(), 1..4),
    ) {
        prop_assert!(is_answered(&build(&mutated(program, &mutations))));
    }

    #[test]
    fn random_bytes_are_answered(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        prop_assert!(is_answered(&build(&String::from_utf8_lossy(&bytes))));
    }

    #[test]
    fn random_characters_are_answered(text in "(\\PC|[\r\n\t{}()\\[\\]\":;,])*") {
        prop_assert!(is_answered(&build(&text)));
    }
}

#[test]
fn deep_nesting_ends_within_the_stack_of_a_test() {
    let inside = |open: &str, close: &str| {
        let nested = format!("{}1{}", open.repeat(100_000), close.repeat(100_000));
        format!(
            "use std.dimibot\ndevice bot : dimibot.femto_st {{ gain: {nested} }}\ntask t on bot {{ move to (0, 0) }}\n"
        )
    };
    for (open, close) in
        [("(", ")"), ("[", "]"), ("disc { a: ", "}"), ("-", ""), ("abs(", ")"), ("1 + ", ""), ("2^", "")]
    {
        let built = build(&inside(open, close));
        assert!(is_answered(&built) && built.schedules.is_empty(), "{open}");
        assert!(build(&inside(open, "")).schedules.is_empty(), "{open}");
    }
    let together = format!("program p {{ {} }}\n", "together { ".repeat(100_000));
    assert!(build(&together).schedules.is_empty());
    let loops = format!("scene s {{ {} }}\n", "for i in 0..9 { ".repeat(100_000));
    assert!(build(&loops).schedules.is_empty());
}

#[test]
fn a_line_of_a_megabyte_is_answered() {
    for piece in ["a", "1", " ", "\"", "(0, 0), ", "{", "}", "//", "0b1", "a.", "µ"] {
        assert!(is_answered(&build(&piece.repeat(1_000_000 / piece.len()))), "{piece}");
    }
}
