//! Programs that differ from a canonical one only in spaces, empty lines, redundant commas and the spelling of units.

use super::random::Random;

/// A random text with the same meaning as a canonical one.
pub fn mangled(text: &str, random: &mut Random) -> String {
    let ending = if random.below(3) == 0 { "\r\n" } else { "\n" };
    // The open brackets; `t` stands for the brace of a table.
    let mut open: Vec<char> = Vec::new();
    let mut result = ending.repeat(random.below(3) as usize);
    for line in text.lines() {
        let code = code_end(line);
        let mut mangled = String::new();
        if !line.is_empty() {
            mangled.push_str(&blanks(random, 0));
        }
        let is_doc = line.trim_start().starts_with("///") || line.trim_start().starts_with("//!");
        mangle_code(line[..code].trim(), &mut open, random, &mut mangled);
        if random.below(4) == 0 && takes_comma(&line[..code], &open) {
            mangled.push_str(&blanks(random, 0));
            mangled.push(',');
        }
        if code < line.len() {
            mangled.push_str(&if is_doc { String::new() } else { blanks(random, 0) });
            mangled.push_str(&line[code..]);
        }
        // A `//!` comment ends with its line.
        mangled.push_str(&blanks(random, 0));
        result.push_str(&mangled);
        result.push_str(ending);
        if line.is_empty() {
            result.push_str(&format!("{}{ending}", blanks(random, 0)).repeat(random.below(3) as usize));
        }
    }
    match random.below(3) {
        0 => result.trim_end().to_owned(),
        1 => result,
        _ => result + ending + "  " + ending,
    }
}

/// At least `least` spaces or tabs.
fn blanks(random: &mut Random, least: usize) -> String {
    let count = least + random.below(4) as usize;
    (0..count).map(|_| if random.below(5) == 0 { '\t' } else { ' ' }).collect()
}

/// Where the code of a line ends and its comment begins.
fn code_end(line: &str) -> usize {
    let mut is_text = false;
    let at = line.char_indices().find(|(at, c)| {
        is_text ^= *c == '"';
        !is_text && line[*at..].starts_with("//")
    });
    at.map_or(line.len(), |(at, _)| at)
}

/// Whether a comma may follow the code of a line: at the end of an entry.
fn takes_comma(code: &str, open: &[char]) -> bool {
    let code = code.trim_end();
    // A device or an instrument without a block ends with its line.
    if (code.starts_with("device ") || code.starts_with("instrument ")) && !code.contains('{') {
        return false;
    }
    let in_block = matches!(open.last(), None | Some('{'));
    in_block
        && !code.is_empty()
        && !code.ends_with(['{', '(', '[', ',', ':', '=', '+', '-', '*', '/', '^', '<', '>', '.'])
}

fn mangle_code(code: &str, open: &mut Vec<char>, random: &mut Random, result: &mut String) {
    let mut is_text = false;
    for (at, c) in code.char_indices() {
        is_text ^= c == '"';
        let before = code[..at].chars().next_back();
        let after = code[at..].chars().nth(1);
        if is_text {
            result.push(c);
            continue;
        }
        match c {
            ' ' => {
                let is_idle = before.is_some_and(|c| "{,:=(".contains(c)) || after.is_some_and(|c| "}=".contains(c));
                result.push_str(&blanks(random, usize::from(!is_idle)));
            }
            '(' | '[' | '{' => {
                let is_table = c == '{' && code[..at].trim_end().ends_with("table");
                open.push(if is_table { 't' } else { c });
                result.push(c);
                result.push_str(&blanks(random, 0));
            }
            ')' | ']' | '}' => {
                let opening = open.pop();
                let is_empty = code[..at].trim_end().ends_with(['(', '[', ',']);
                // Lists and tuples may end with a comma; the parameter list of a head may not.
                let is_list = opening == Some('(') && !is_empty && !is_head(code);
                if is_list && random.below(6) == 0 {
                    result.push(',');
                }
                result.push_str(&blanks(random, 0));
                result.push(c);
            }
            'u' if code[at..].starts_with("um") && before == Some(' ') && is_number_before(&code[..at]) => {
                result.push(*['u', 'µ', 'μ'].get(random.below(3) as usize).unwrap_or(&'u'));
            }
            _ => result.push(c),
        }
    }
}

/// Whether a line may have parameters.
fn is_head(code: &str) -> bool {
    code.starts_with("task ") || code.starts_with("program ")
}

fn is_number_before(code: &str) -> bool {
    code.trim_end().ends_with(|c: char| c.is_ascii_digit())
}
