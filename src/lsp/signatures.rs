//! Signature help: the arguments of the function, task or program call around the cursor.

use super::outline;
use crate::syntax::functions::FUNCTIONS;
use crate::syntax::is_word;
use crate::syntax::tree::{Item, Parameter, Runnable};
use lsp_types::{Documentation, ParameterInformation, ParameterLabel, SignatureHelp, SignatureInformation};

/// Bytes before the cursor that are searched for the opening bracket.
const MAX_LOOKBACK_BYTES: usize = 4096;

/// Signature of the call around a byte of a text, with the current argument.
pub fn help(text: &str, at: usize) -> Option<SignatureHelp> {
    let (name, argument) = call(&text[text.ceil_char_boundary(at.saturating_sub(MAX_LOOKBACK_BYTES))..at])?;
    let signature = of_function(name).or_else(|| of_task(text, name))?;
    let last = signature.parameters.as_ref().map_or(0, Vec::len).saturating_sub(1);
    // The last parameter of a function such as `min` repeats.
    let active_parameter = Some(if signature.label.ends_with("…)") { argument.min(last) } else { argument } as u32);
    Some(SignatureHelp { signatures: vec![signature], active_signature: Some(0), active_parameter })
}

/// The name before the innermost open round bracket, and the number of commas after that bracket.
fn call(before: &str) -> Option<(&str, usize)> {
    let (mut open, mut commas) = (0_usize, 0);
    for (at, character) in before.char_indices().rev() {
        match character {
            ')' | ']' => open += 1,
            '(' if open == 0 => {
                let name = &before[before[..at].trim_end_matches(is_word).len()..at];
                return (!name.is_empty()).then_some((name, commas));
            }
            '(' | '[' => open = open.checked_sub(1)?,
            ',' if open == 0 => commas += 1,
            // A call does not extend over a block.
            '{' | '}' => return None,
            _ => {}
        }
    }
    None
}

fn of_function(name: &str) -> Option<SignatureInformation> {
    let form = FUNCTIONS.iter().find(|form| form.name == name)?;
    Some(signature(name, form.parameters.iter().map(|parameter| (*parameter).to_owned()), form.doc))
}

fn of_task(text: &str, name: &str) -> Option<SignatureInformation> {
    let tree = outline::tree(text);
    let Runnable { parameters, doc, .. } =
        tree.items.iter().filter_map(Item::runnable).find(|runnable| runnable.name.text == name)?;
    let shown = |parameter: &Parameter| format!("{}: {}", parameter.name.text, parameter.sort.text);
    Some(signature(name, parameters.iter().map(shown), doc.as_deref().unwrap_or_default()))
}

fn signature(name: &str, parameters: impl Iterator<Item = String>, doc: &str) -> SignatureInformation {
    let parameters: Vec<String> = parameters.collect();
    let label = format!("{name}({})", parameters.join(", "));
    let information =
        |parameter: String| ParameterInformation { label: ParameterLabel::Simple(parameter), documentation: None };
    SignatureInformation {
        label,
        documentation: (!doc.is_empty()).then(|| Documentation::String(doc.to_owned())),
        parameters: Some(parameters.into_iter().map(information).collect()),
        active_parameter: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The label, and the index of the argument at the mark `|`.
    fn at(text: &str) -> Option<(String, u32)> {
        let (at, text) = (text.find('|').expect("a mark"), text.replace('|', ""));
        let help = help(&text, at)?;
        Some((help.signatures[0].label.clone(), help.active_parameter?))
    }

    #[test]
    fn the_innermost_call_is_shown_with_the_argument_at_work() {
        let pose = |argument| Some(("pose(x, y, heading)".to_owned(), argument));
        assert_eq!(at("let a = pose(|"), pose(0));
        assert_eq!(at("let a = pose(1 um, (2 um, 3 um), [1, 2], |)"), pose(3));
        assert_eq!(at("let a = pose(1 um, max(1, 2), |)"), pose(2));
        assert_eq!(at("let a = pose(max(1, 2, 3|), 4)"), Some(("max(value, …)".to_owned(), 1)));
        let task = "/// Goes there.\ntask go(goal: cell, rest: time) on bot { move to goal }\n";
        assert_eq!(
            at(&format!("{task}program p {{ run go((1, 2), |")),
            Some(("go(goal: cell, rest: time)".to_owned(), 1))
        );
        for other in
            ["let a = |", "let a = (1, |", "let a = f(|", "let µ = \"(\" |", "task a { max( } |", "let a = pose)|", "|"]
        {
            assert_eq!(at(other), None, "{other}");
        }
    }
}
