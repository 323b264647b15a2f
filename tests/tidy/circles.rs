//! No import cycles: each file of `src` is above all files that it imports. A `mod.rs` and its own children count as
//! one unit, and imports between them are ignored.

use super::{is_test_file, sources, without_tests, word_at};
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// A file by the words of its path: `src/plan/search.rs` is `plan`, `search`, and `src/plan/mod.rs` is `plan`.
type Module = Vec<String>;

fn module(path: &str) -> Module {
    let path = path.trim_start_matches("src/").trim_end_matches(".rs").trim_end_matches("/mod");
    path.split('/').map(str::to_owned).collect()
}

/// The code without its `use` items, and the trees of these items.
fn split_uses(code: &str) -> (String, Vec<String>) {
    let (mut rest, mut uses) = (String::new(), Vec::new());
    for item in code.split_inclusive(';') {
        let begins = |line: &str| {
            let line = line.trim_start();
            ["use ", "pub use ", "pub(crate) use ", "pub(super) use "].iter().any(|head| line.starts_with(head))
        };
        let at = item.split_inclusive('\n').scan(0, |at, line| {
            let here = *at;
            *at += line.len();
            Some((here, line))
        });
        match at.filter(|(_, line)| begins(line)).last() {
            Some((at, _)) => {
                rest.push_str(&item[..at]);
                let tree = item[at..].split_once("use ").map_or("", |(_, tree)| tree);
                uses.push(tree.trim_end_matches(';').split_whitespace().collect());
            }
            None => rest.push_str(item),
        }
    }
    (rest, uses)
}

/// The paths of a `use` tree without spaces: `a::{b, c::{d, e}}` has three.
fn spread(tree: &str) -> Vec<String> {
    let Some((head, group)) = tree.split_once('{') else { return vec![tree.to_owned()] };
    let group = group.strip_suffix('}').unwrap_or(group);
    let (mut depth, mut begin, mut parts) = (0, 0, Vec::new());
    for (at, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&group[begin..at]);
                begin = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&group[begin..]);
    parts.iter().filter(|part| !part.is_empty()).flat_map(|part| spread(&format!("{head}{part}"))).collect()
}

/// The paths that a text names: in its `use` items, and elsewhere after `crate` and `super`.
fn paths(code: &str) -> Vec<Vec<String>> {
    let (rest, uses) = split_uses(code);
    let starts = ["crate::", "super::"].into_iter().flat_map(|start| rest.match_indices(start)).map(|(at, _)| at);
    let starts = starts.filter(|at| !rest[..*at].ends_with(|c: char| c.is_alphanumeric() || "_:".contains(c)));
    let is_path = |c: char| c.is_alphanumeric() || "_:".contains(c);
    let inside = starts.map(|at| rest[at..].split(|c| !is_path(c)).next().unwrap_or_default().to_owned());
    let all = inside.chain(uses.iter().flat_map(|tree| spread(tree)));
    all.map(|path| path.split("::").map(word_at).collect()).collect()
}

/// The file that a path leads to from a module.
fn file_of(path: &[String], from: &Module, files: &BTreeSet<Module>) -> Option<Module> {
    let mut at: Module = match path.first()?.as_str() {
        "crate" => Vec::new(),
        "self" => from.clone(),
        "super" => from[..from.len() - 1].to_vec(),
        _ => from.clone(),
    };
    let named = usize::from(matches!(path[0].as_str(), "crate" | "self" | "super"));
    for word in &path[named..] {
        if word == "super" {
            at.pop();
            continue;
        }
        at.push(word.clone());
        if !files.contains(&at) {
            at.pop();
            break;
        }
    }
    files.contains(&at).then_some(at)
}

/// The shortest import cycle; empty if there is none.
fn circle(texts: &[(String, String)]) -> Vec<String> {
    let files: BTreeSet<Module> = texts.iter().map(|(path, _)| module(path)).collect();
    let imports = |(path, text): &(String, String)| {
        let from = module(path);
        let found = paths(&without_tests(text)).into_iter().filter_map(|path| file_of(&path, &from, &files));
        let is_own = |to: &Module| to[..to.len() - 1] == from[..] || from[..from.len() - 1] == to[..] || *to == from;
        let found: BTreeSet<Module> = found.filter(|to| !is_own(to)).collect();
        (from, found)
    };
    let imports: BTreeMap<Module, BTreeSet<Module>> = texts.iter().map(imports).collect();
    let back_to = |start: &Module| {
        let mut from: BTreeMap<&Module, &Module> = BTreeMap::new();
        let mut open = VecDeque::from([start]);
        while let Some(at) = open.pop_front() {
            for next in &imports[at] {
                if from.contains_key(next) {
                    continue;
                }
                from.insert(next, at);
                open.push_back(next);
            }
        }
        let mut way = vec![from.get(start)?.join("/")];
        let mut at = from[start];
        while at != start {
            at = from[at];
            way.push(at.join("/"));
        }
        Some(way)
    };
    files.iter().filter_map(back_to).min_by_key(Vec::len).unwrap_or_default()
}

#[test]
fn files_import_in_no_circle() {
    let is_room = |path: &str| !is_test_file(path) && !matches!(path, "src/lib.rs" | "src/main.rs");
    let texts: Vec<(String, String)> = sources().into_iter().filter(|(path, _)| is_room(path)).collect();
    assert_eq!(circle(&texts), [""; 0], "each of these files imports the one before it, the first the last");
}

#[test]
fn a_circle_is_found() {
    let file = |path: &str, text: &str| (format!("src/{path}.rs"), text.to_owned());
    let a = file("a/mod", "mod b;\nmod c;\npub use b::B;");
    let b = file("a/b", "use super::{A, c::{self, C}};");
    assert_eq!(circle(&[a.clone(), b.clone(), file("a/c", "use super::A;\n")]), [""; 0]);
    let tests = "use super::A;\n\n#[cfg(test)]\nmod tests {\n    use super::super::b::B;\n}";
    assert_eq!(circle(&[a.clone(), b.clone(), file("a/c", tests)]), [""; 0]);
    assert_eq!(circle(&[a.clone(), b.clone(), file("a/c", "pub(super) use crate::a::b::B;")]), ["a/c", "a/b"]);
    let far = [file("d", "use crate::e;\n"), file("e", "fn f() {\n    crate::a::c::x();\n}\n")];
    let all = [vec![a, b, file("a/c", "use crate::d::{D,\n    E};\n")], far.to_vec()].concat();
    assert_eq!(circle(&all), ["e", "d", "a/c"]);
}
