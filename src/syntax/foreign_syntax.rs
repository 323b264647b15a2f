//! Habits from other languages; each gets one diagnostic that shows the equivalent in Tweeze.

use super::context::{self, after, line_after, line_before, part, quote, token_at, value_in, with_blanks};
use super::words::{PREPOSITIONS, is_word};
use crate::diagnostic::{Code, Diagnostic};
use crate::source::Span;

/// Diagnoses an unreadable step written in the style of another language.
pub(super) fn step(span: Span, source: &str) -> Option<Diagnostic> {
    let text = &source[span.range()];
    let head = token_at(text, 0);
    let rest = &text[head.len()..];
    let at = span.start as usize;
    if !head.starts_with(is_word) {
        return None;
    }
    if let Some(method) = rest.strip_prefix('.') {
        return method_call(span, head, method);
    }
    if head == "set" {
        let name = rest.trim_start();
        let name = &name[..name.len() - name.trim_start_matches(is_word).len()];
        let sign = at + text.find('=')?;
        let level = source[sign + 1..span.end as usize].trim_start_matches('=').trim();
        let sign = part(span, sign, sign + 1);
        return (!name.is_empty()).then(|| {
            Diagnostic::new(Code::E0119, "`=` where `to` belongs")
                .label(sign, "`to` goes between an output and its level")
                .help(format!("write `set {name} to {}`", quote(level)))
                .with_fix(with_blanks(sign, source), " to ")
        });
    }
    let argument = rest.strip_prefix('(')?.trim_start();
    let name = token_at(argument, 0);
    (name.starts_with(is_word) && argument[name.len()..].trim_start().starts_with('=')).then(|| {
        Diagnostic::new(Code::E0101, "a step written as a call")
            .label(part(span, at, at + head.len() + 1), "steps take no brackets")
            .help("write a verb and prepositions, as in `move to (1, 2)`")
    })
}

/// `bot.move_to(1, 2)`, `time.sleep(0.5)`.
fn method_call(span: Span, object: &str, method: &str) -> Option<Diagnostic> {
    let name = token_at(method, 0);
    if !name.starts_with(is_word) || !method[name.len()..].starts_with('(') {
        return None;
    }
    let start = span.start as usize;
    let help = match name {
        "sleep" | "pause" | "wait" | "delay" => "write `wait` with a time and its unit, as in `wait 500 ms`",
        _ => "begin with the verb: the device of a task is in its head, as in `task go on bot { move to (1, 2) }`",
    };
    let whole = part(span, start, start + object.len() + 1 + name.len());
    Some(Diagnostic::new(Code::E0101, "a step written as a call").label(whole, "steps are not methods").help(help))
}

/// Diagnoses what stopped parsing at `at` inside a list of a declaration: a matrix or a loop.
pub(super) fn list(span: Span, at: usize, source: &str) -> Option<Diagnostic> {
    let text = &source[span.start as usize..at];
    let open = text.rfind('[').filter(|open| !text[*open..].contains(']'))?;
    let token = token_at(source, at);
    if token == "for" {
        return Some(
            Diagnostic::new(Code::E0122, "a list computed by a `for`")
                .label(part(span, at, at + token.len()), "from another language")
                .help("write the elements out, or repeat the step: `for i in 0..4 { move to (i, 2) }`"),
        );
    }
    let start = span.start as usize + open;
    let (rest, _) = source[start + 1..span.end as usize].split_once(']')?;
    let rows: Vec<Vec<&str>> = rest
        .split([';', '\n'])
        .map(|row| row.split([' ', '\t', ',']).filter(|cell| !cell.is_empty()).collect())
        .filter(|row: &Vec<&str>| !row.is_empty())
        .collect();
    let is_number = |cell: &&str| cell.starts_with(|c: char| c.is_ascii_digit() || c == '-');
    let is_matrix = rest.contains(';') && rows.iter().all(|row| row.len() == 2 && row.iter().all(is_number));
    is_matrix.then(|| {
        let places: Vec<String> = rows.iter().map(|row| format!("({}, {})", row[0], row[1])).collect();
        let list = format!("[{}]", places.join(", "));
        let whole = part(span, start, start + rest.len() + 2);
        Diagnostic::new(Code::E0122, "a matrix")
            .label(whole, "from another language")
            .help(format!("write a list of places, `{}`", quote(&list)))
            .with_fix(whole, list)
    })
}

/// `7 // 2`, where everything from the `//` on is a comment.
pub(super) fn whole_division(comment: Span, source: &str) -> Option<Diagnostic> {
    let divisor = source[comment.range()].strip_prefix("//")?.trim();
    let is_number =
        divisor.starts_with(|c: char| c.is_ascii_digit()) && divisor.chars().all(|c| c.is_ascii_digit() || c == '.');
    let follows_value = || line_before(source, comment.start as usize).ends_with(|c: char| is_word(c) || c == ')');
    (is_number && follows_value()).then(|| {
        Diagnostic::new(Code::W0101, "a comment that may be meant as a division")
            .label(comment, "`//` begins a comment")
            .help(format!("write `floor(… / {divisor})` for an integer quotient, or add a word to the comment"))
    })
}

/// `from std import dimibot` at the head of a line.
pub(super) fn import(span: Span, text: &str) -> Option<Diagnostic> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let (["from", "std", "import", file], true) = (words.get(..4)?, words.len() == 4) else { return None };
    Some(
        Diagnostic::new(Code::E0122, "`from … import` is not part of the language")
            .label(span, "from another language")
            .help(format!("write `use std.{}`", quote(file)))
            .with_fix(span, format!("use std.{file}")),
    )
}

/// `device my-bot …`, `device "bot" …`: an invalid name; `rest` is the part that could not be read.
pub(super) fn name(rest: Span, source: &str) -> Option<Diagnostic> {
    let start = rest.start as usize;
    let text = &source[rest.range()];
    let ends = |text: &str| text.len() - text.trim_start_matches(|c| is_word(c) || c == '-').len();
    if text.starts_with('-') {
        let first = source[..start].len() - source[..start].trim_end_matches(is_word).len();
        let whole = &source[start - first..start + ends(text)];
        let written = whole.replace('-', "_");
        return (first > 0).then(|| {
            Diagnostic::new(Code::E0110, format!("`{}` is not a valid name", quote(whole)))
                .label(
                    part(rest, start - first, start - first + whole.len()),
                    "names consist of letters, digits and `_`",
                )
                .help(format!("write `{}`", quote(&written)))
                .with_fix_here(written)
        });
    }
    let inside = text.strip_prefix('"')?.split('"').next()?;
    let is_name = inside.starts_with(is_word) && inside.chars().all(is_word);
    (is_name && !inside.starts_with(|c: char| c.is_ascii_digit())).then(|| {
        Diagnostic::new(Code::E0110, "a name in quotes")
            .label(part(rest, start, start + inside.len() + 2), "names are written without quotes")
            .help(format!("write `{}`", quote(inside)))
            .with_fix_here(inside)
    })
}

/// Comparisons in words with their signs; longer phrases come before their own prefixes.
const COMPARISONS: [(&str, &str); 23] = [
    ("less than or equal to", "<="),
    ("greater than or equal to", ">="),
    ("more than or equal to", ">="),
    ("less than", "<"),
    ("lower than", "<"),
    ("smaller than", "<"),
    ("greater than", ">"),
    ("more than", ">"),
    ("longer than", ">"),
    ("no more than", "<="),
    ("not more than", "<="),
    ("no less than", ">="),
    ("not less than", ">="),
    ("at most", "<="),
    ("at least", ">="),
    ("up to", "<="),
    ("within", "<="),
    ("below", "<"),
    ("under", "<"),
    ("above", ">"),
    ("over", ">"),
    ("equal to", "=="),
    ("equals", "=="),
];

/// `time less than 400 ms`, after `require`: the range of the words between a figure and its limit, and the sign that
/// they mean.
pub(super) fn comparison(text: &str) -> Option<(std::ops::Range<usize>, &'static str)> {
    let figure = text.trim_start_matches([' ', '\t']);
    let name = figure.len() - figure.trim_start_matches(|c| is_word(c) || matches!(c, '.' | '[' | ']')).len();
    let behind = &figure[name..];
    let words = behind.trim_start_matches([' ', '\t']);
    if name == 0 || words.len() == behind.len() {
        return None;
    }
    let after = |phrase: &str, text: &str| -> Option<usize> {
        let mut rest = text;
        for word in phrase.split(' ') {
            rest = rest.trim_start_matches([' ', '\t']).strip_prefix(word)?;
            rest = Some(rest).filter(|rest| !rest.starts_with(is_word))?;
        }
        Some(text.len() - rest.len())
    };
    // `is less than`, or `is` alone.
    let verb = after("must be", words).or_else(|| after("is", words)).unwrap_or(0);
    let found = COMPARISONS.iter().find_map(|(phrase, sign)| Some((after(phrase, &words[verb..])?, *sign)));
    let (length, sign) = match found {
        Some((length, sign)) => (verb + length, sign),
        None if verb > 0 => (verb, "=="),
        None => return None,
    };
    let limit = words[length..].trim_start_matches([' ', '\t']);
    let is_value = limit.starts_with(|c: char| is_word(c) || c == '(' || c == '-');
    let start = text.len() - words.len();
    is_value.then_some((start..start + length, sign))
}

/// A comparison in words, in an entry that begins at `entry`.
pub(super) fn comparison_in_words(words: Span, entry: usize, sign: &str, source: &str) -> Diagnostic {
    let figure = source[entry..words.start as usize].trim_end();
    let limit = value_in(line_after(source, words.end as usize));
    Diagnostic::new(Code::E0122, format!("`{}` where `{sign}` belongs", quote(&source[words.range()])))
        .label(words, "a comparison is written as a sign")
        .help(format!("write `{} {sign} {}`", quote(figure), quote(limit)))
        .with_fix_here(sign)
}

/// Diagnoses a whole step worded differently from the verb's form; returns the finding and the span that it covers.
pub(super) fn whole_step(step: Span, source: &str) -> Option<(Diagnostic, Span)> {
    let start = step.start as usize;
    let head = ["merge", "split", "assemble"].into_iter().find(|head| source[start..].starts_with(head))?;
    let line = after(source, start).lines().next()?;
    let line = line.split("//").next().unwrap_or_default();
    let text = line.split(['{', '}', ';']).next().unwrap_or_default().trim_end();
    let rest = text[head.len()..].strip_prefix([' ', '\t'])?;
    let names: Vec<&str> = rest.split([' ', '\t', ',']).filter(|word| !word.is_empty()).collect();
    let whole = part(step, start, start + text.len());
    let finding = match head {
        "merge" => merged(whole, text, &names),
        "split" => split_into(whole, &names),
        _ => assembled(whole, line, text, rest),
    };
    finding.map(|finding| (finding, whole))
}

/// `detect drop at window forr 2 s`: the word after a step is a preposition with one wrong letter. Returns the finding
/// and the span of the step with the rest of its line.
pub(super) fn misspelt_behind(step: Span, source: &str) -> Option<(Diagnostic, Span)> {
    let at = context::blanks_end(source, step.end as usize);
    let word = token_at(source, at);
    let behind = context::blanks_end(source, at + word.len());
    let takes_more = source[behind..].starts_with(|c: char| is_word(c) || matches!(c, '(' | '['));
    if word.len() < 3 || at == step.end as usize || behind == at + word.len() || !takes_more {
        return None;
    }
    let right = PREPOSITIONS.into_iter().find(|right| strsim::osa_distance(word, right) == 1)?;
    let rest = source[behind..].split(['{', '}', ';', '\r', '\n']).next().unwrap_or_default();
    let rest = rest.split("//").next().unwrap_or_default().trim_end();
    let finding = misspelt(part(step, at, at + word.len()), word, right);
    Some((finding, part(step, step.start as usize, behind + rest.len())))
}

fn misspelt(place: Span, word: &str, right: &str) -> Diagnostic {
    Diagnostic::new(Code::E0509, format!("no step takes `{}`", quote(word)))
        .label(place, "expected a preposition")
        .help(format!("did you mean `{right}`?"))
        .with_fix(place, right)
}

fn is_name(text: &str) -> bool {
    text.starts_with(|c: char| is_word(c) && !c.is_ascii_digit())
        && text.chars().all(|c| is_word(c) || matches!(c, '[' | ']'))
}

/// `merge a and b`, `merge a, b at (6, 3)`.
fn merged(step: Span, text: &str, words: &[&str]) -> Option<Diagnostic> {
    let (first, second, wrong, behind) = match words {
        [first, "and" | "into" | "+" | "&", second, behind @ ..] => (first, second, words[1], behind),
        [first, second, behind @ ..] if text.contains(&format!("{first},")) => (first, second, ",", behind),
        _ => return None,
    };
    if !is_name(first) || !is_name(second) || !matches!(behind, [] | ["at", ..]) {
        return None;
    }
    // Searched after the first name, because a word such as `and` may be part of it.
    let from = text.find(first)? + first.len();
    let sign = step.start as usize + from + text[from..].find(wrong)?;
    let sign = part(step, sign, sign + wrong.len());
    let finding = Diagnostic::new(Code::E0122, format!("`{wrong}` where `with` belongs"))
        .label(sign, "a droplet merges `with` another");
    let merge = format!("merge {first} with {second} at");
    if behind.is_empty() {
        return Some(finding.help(format!("write `{} CELL`, with the cell where they meet", quote(&merge))));
    }
    let place = text.split(" at ").nth(1).unwrap_or_default();
    let fix = if wrong == "," { " with" } else { "with" };
    Some(finding.help(format!("write `{} {}`", quote(&merge), quote(value_in(place.trim())))).with_fix_here(fix))
}

/// `split sample into a, b`, `split sample`.
fn split_into(step: Span, words: &[&str]) -> Option<Diagnostic> {
    let (droplet, half) = match words {
        [droplet, "into", "half" | "halves" | "two" | "2", ..] | [droplet, "in", ..] => (droplet, "half"),
        [droplet, "into", half, "at" | "to", ..] | [droplet, "into", .., half] if is_name(half) => (droplet, *half),
        _ => return None,
    };
    is_name(droplet).then(|| {
        Diagnostic::new(Code::E0122, "`split` names the new droplet first")
            .label(step, "the new half gets a name of its own; the other half keeps its name")
            .help(format!("write `split {half} from {droplet} at CELL to CELL`, with the cells of both halves"))
    })
}

/// `assemble D1, D2`, with or without a block.
fn assembled(step: Span, line: &str, text: &str, rest: &str) -> Option<Diagnostic> {
    let names: Vec<&str> = rest.split(',').flat_map(|part| part.split(" and ")).map(str::trim).collect();
    if names.len() < 2 || !names.iter().all(|name| is_name(name)) {
        return None;
    }
    let at = step.start as usize + (text.len() - rest.len());
    let place = part(step, at, step.end as usize);
    let finding = Diagnostic::new(Code::E0509, "`assemble` takes braces").label(place, "robots belong in the braces");
    if line[text.len()..].trim_start().starts_with('{') {
        return Some(finding.help("write `assemble {`: the entries name the robots").with_fix_here(""));
    }
    let goals: Vec<String> = names.iter().map(|name| format!("{name} to POSE")).collect();
    Some(finding.help(format!("write `assemble {{ {} }}`, with the pose of each", quote(&goals.join(", ")))))
}

/// Misspellings of `to`. Any other word may be the object that is moved.
const TO: [&str; 5] = ["too", "tto", "tp", "ot", "tu"];

/// `move too (19, 28)`, `move m1 form (5, 3)`: the word before a bracket is a preposition with one wrong letter. `noun`
/// is the word before it.
pub(super) fn misspelt_preposition(object: Span, noun: Option<&str>, source: &str) -> Option<Diagnostic> {
    let text = &source[object.range()];
    let word = token_at(text, 0);
    let follows = text[word.len()..].trim_start_matches([' ', '\t']);
    if !word.starts_with(is_word) || follows.len() == text.len() - word.len() || !follows.starts_with('(') {
        return None;
    }
    // Without `in` and `on`, because `min` and `sin` are functions.
    let known = ["to", "from", "via", "with", "about", "after", "at", "by"];
    let is_near = |right: &&str| *right != word && strsim::osa_distance(word, right) == 1;
    let right = match noun {
        Some(_) if word.chars().all(char::is_alphabetic) && word.len() > 1 => known.into_iter().find(is_near)?,
        None if TO.contains(&word) => "to",
        Some(_) | None => return None,
    };
    let at = object.start as usize;
    Some(misspelt(part(object, at, at + word.len()), word, right))
}
