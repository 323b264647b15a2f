//! Parameters of functions have names: none is a tuple pattern in the parameter list.

use super::{code, rust};

/// The parameter lists of all functions, each with the name of its function; `type F = fn(…)` and closures have none.
fn parameter_lists(code: &str) -> Vec<(&str, &str)> {
    let heads =
        code.match_indices("fn ").filter(|(at, _)| !code[..*at].ends_with(|c: char| c.is_alphanumeric() || c == '_'));
    let lists = heads.filter_map(|(at, _)| {
        let rest = &code[at + "fn ".len()..];
        let name = &rest[..rest.find(|c: char| !(c.is_alphanumeric() || c == '_'))?];
        // Skips the type parameters, whose bounds may contain parentheses.
        let mut angles = 0;
        let begin = rest.char_indices().find_map(|(at, c)| {
            angles += i32::from(c == '<') - i32::from(c == '>' && !rest[..at].ends_with('-'));
            (c == '(' && angles == 0).then_some(at)
        })?;
        let mut depth = 0;
        let end = rest[begin..].char_indices().find_map(|(at, c)| {
            depth += i32::from(c == '(') - i32::from(c == ')');
            (depth == 0).then_some(begin + at)
        })?;
        Some((name, &rest[begin + 1..end]))
    });
    lists.collect()
}

/// Whether one of these parameters is a pattern in parentheses. The draws of a property test, `(a, b) in …`, do not
/// count.
fn takes_a_tuple_apart(parameters: &str) -> bool {
    let (mut depth, mut begin) = (0, Some(0));
    parameters.char_indices().any(|(at, c)| {
        let is_arrow = c == '>' && parameters[..at].ends_with('-');
        depth += i32::from("([{<".contains(c)) - i32::from(")]}>".contains(c) && !is_arrow);
        match c {
            ',' if depth == 0 => begin = Some(at + 1),
            ':' if depth == 0 => {
                let pattern = begin.take().map_or("", |begin| parameters[begin..at].trim().trim_start_matches('&'));
                return pattern.starts_with('(') && pattern.ends_with(')');
            }
            _ => {}
        }
        false
    })
}

#[test]
fn parameters_have_names() {
    for (path, text) in rust() {
        for (name, parameters) in parameter_lists(&code(&text)) {
            assert!(!takes_a_tuple_apart(parameters), "{path}: `fn {name}` takes a tuple apart: give its parts names");
        }
    }
}

#[test]
fn a_tuple_taken_apart_is_seen() {
    let apart = [
        "fn f((a, b): (u8, u8)) {}",
        "fn f<F: Fn(u8) -> u8>(a: F, &(b, c): &(u8, u8)) {}",
        "fn f(\n    (a, b): (u8, u8),\n) {}",
    ];
    let named = [
        "fn f(a: (u8, u8), b: [u8; 2]) {}",
        "fn f(a: impl Fn((u8, u8)) -> u8) {}",
        "fn f([a, b]: [u8; 2]) {}",
        "fn f() { g(|(a, b)| a + b) }",
    ];
    let is_seen = |text: &str| parameter_lists(text).iter().any(|(_, parameters)| takes_a_tuple_apart(parameters));
    assert!(apart.iter().all(|text| is_seen(text)));
    assert!(!named.iter().any(|text| is_seen(text)));
}
