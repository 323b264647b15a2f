//! Machine-readable diagnostics: JSON, one line of text, workflow commands of GitHub Actions, and SARIF 2.1.0.
//!
//! Lines count from 1, columns from 1 in characters; an end is the place after the last character.

use super::plain::plain;
use super::{Code, Diagnostic, Label, Severity, Sink, SourceEdit};
use crate::source::{Sources, Span};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::Path;

/// The schema of the SARIF documents.
const SARIF_SCHEMA: &str = "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json";

/// `error` or `warning`.
pub fn severity(code: Code) -> &'static str {
    match code.severity() {
        Severity::Error => "error",
        Severity::Warning => "warning",
    }
}

/// One diagnostic as a line of JSON. `file`, `line`, `column`, `end_line` and `end_column` are the place that it points
/// to, null if there is none; `labels` lists all places, each with its text; `edits` are the edits that fix it, null if
/// they are not known exactly.
pub fn json_line(diagnostic: &Diagnostic, sources: &Sources) -> String {
    let labels: Vec<Value> = diagnostic.labels.iter().map(|label| json_label(label, sources)).collect();
    let mut object = json!({
        "code": diagnostic.code,
        "severity": severity(diagnostic.code),
        "title": diagnostic.title,
        "help": diagnostic.help,
    });
    for key in ["file", "line", "column", "end_line", "end_column"] {
        object[key] = labels.first().map_or(Value::Null, |first| first[key].clone());
    }
    object["labels"] = labels.into();
    let edits: Vec<Value> = diagnostic.fix.iter().map(|edit| json_edit(edit, sources)).collect();
    object["edits"] = if edits.is_empty() { Value::Null } else { edits.into() };
    object.to_string()
}

/// An edit: a place and the text that replaces it.
fn json_edit(edit: &SourceEdit, sources: &Sources) -> Value {
    json_place(edit.span, "replacement", &edit.text, sources)
}

fn json_label(label: &Label, sources: &Sources) -> Value {
    json_place(label.span, "text", &label.text, sources)
}

/// A place, with a text under a given key.
fn json_place(span: Span, key: &str, text: &str, sources: &Sources) -> Value {
    let file = sources.file(span.file);
    let (start, end) = (file.position(span.start), file.position(span.end));
    json!({
        "file": file.shown,
        "line": start.line,
        "column": start.column,
        "end_line": end.line,
        "end_column": end.column,
        key: text,
    })
}

/// One diagnostic as one line of text, in the usual form of compilers: `fetch.twz:21:11: error[E0503]: title`.
pub fn short_line(diagnostic: &Diagnostic, sources: &Sources) -> String {
    let place = diagnostic.span().map_or_else(String::new, |span| {
        let file = sources.file(span.file);
        let start = file.position(span.start);
        format!("{}:{}:{}: ", plain(&file.shown), start.line, start.column)
    });
    let code = diagnostic.code;
    format!("{place}{}[{code}]: {}", severity(code), plain(&diagnostic.title))
}

/// One diagnostic as a workflow command of GitHub Actions, which shows it at its line of a pull request.
pub fn github_line(diagnostic: &Diagnostic, sources: &Sources) -> String {
    let code = diagnostic.code;
    let place = diagnostic.span().map_or_else(String::new, |span| {
        let file = sources.file(span.file);
        let (start, end) = (file.position(span.start), file.position(span.end));
        // GitHub reads columns only if both are on the same line.
        let columns = match start.line == end.line {
            true => format!(",col={},endColumn={}", start.column, end.column),
            false => String::new(),
        };
        format!("file={},line={},endLine={}{columns},", github_property(&file.shown), start.line, end.line)
    });
    let help = diagnostic.help.as_deref().map_or_else(String::new, |help| format!("\nhelp: {help}"));
    let message = github_data(&format!("{}{help}", diagnostic.title));
    format!("::{} {place}title={code}::{message}", severity(code))
}

fn github_data(text: &str) -> String {
    text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A")
}

fn github_property(text: &str) -> String {
    github_data(text).replace(':', "%3A").replace(',', "%2C")
}

/// The diagnostics of several programs as one SARIF document, with a line end.
pub fn sarif(reports: &[(Sources, Sink)]) -> String {
    let all = || reports.iter().flat_map(|(sources, sink)| sink.sorted().into_iter().map(move |one| (one, sources)));
    let codes: BTreeSet<Code> = all().map(|(diagnostic, _)| diagnostic.code).collect();
    let rules: Vec<Value> = codes.iter().map(|code| sarif_rule(*code)).collect();
    let index = |code: Code| codes.iter().position(|other| *other == code);
    let results: Vec<Value> =
        all().map(|(diagnostic, sources)| sarif_result(diagnostic, sources, index(diagnostic.code))).collect();
    let driver = json!({ "name": "tweeze", "semanticVersion": env!("CARGO_PKG_VERSION"), "rules": rules });
    let run = json!({ "tool": { "driver": driver }, "columnKind": "unicodeCodePoints", "results": results });
    let document = json!({ "$schema": SARIF_SCHEMA, "version": "2.1.0", "runs": [run] });
    format!("{document:#}\n")
}

fn sarif_rule(code: Code) -> Value {
    json!({
        "id": code,
        "shortDescription": { "text": code.summary() },
        "help": { "text": code.page(), "markdown": code.page() },
        "defaultConfiguration": { "level": severity(code) },
    })
}

fn sarif_result(diagnostic: &Diagnostic, sources: &Sources, rule: Option<usize>) -> Value {
    let help = diagnostic.help.as_deref().map_or_else(String::new, |help| format!("\nhelp: {help}"));
    let mut places = diagnostic.labels.iter().map(|label| sarif_location(label, sources));
    let mut result = json!({
        "ruleId": diagnostic.code,
        "ruleIndex": rule,
        "level": severity(diagnostic.code),
        "message": { "text": format!("{}{help}", diagnostic.title) },
        "locations": places.next().into_iter().collect::<Vec<_>>(),
    });
    let related: Vec<Value> = places.collect();
    if !related.is_empty() {
        result["relatedLocations"] = related.into();
    }
    if let Some(first) = diagnostic.fix.first() {
        let replacements: Vec<Value> = diagnostic.fix.iter().map(|edit| sarif_replacement(edit, sources)).collect();
        let artifact = json!({ "uri": uri(&sources.file(first.span.file).shown) });
        result["fixes"] = json!([{
            "description": { "text": diagnostic.help },
            "artifactChanges": [{ "artifactLocation": artifact, "replacements": replacements }],
        }]);
    }
    result
}

fn sarif_replacement(edit: &SourceEdit, sources: &Sources) -> Value {
    json!({ "deletedRegion": sarif_region(edit.span, sources), "insertedContent": { "text": edit.text } })
}

fn sarif_region(span: Span, sources: &Sources) -> Value {
    let file = sources.file(span.file);
    let (start, end) = (file.position(span.start), file.position(span.end));
    json!({
        "startLine": start.line,
        "startColumn": start.column,
        "endLine": end.line,
        "endColumn": end.column,
    })
}

fn sarif_location(label: &Label, sources: &Sources) -> Value {
    let file = sources.file(label.span.file);
    let region = sarif_region(label.span, sources);
    let mut location =
        json!({ "physicalLocation": { "artifactLocation": { "uri": uri(&file.shown) }, "region": region } });
    if !label.text.is_empty() {
        location["message"] = json!({ "text": label.text });
    }
    location
}

/// A path as a URI, or as a reference to one if it is relative.
fn uri(path: &str) -> String {
    let slashed = if cfg!(windows) { path.replace('\\', "/") } else { path.to_owned() };
    let mut uri = String::new();
    if Path::new(path).is_absolute() {
        uri.push_str(if slashed.starts_with('/') { "file://" } else { "file:///" });
    }
    for byte in slashed.bytes() {
        match byte {
            b'/' | b'-' | b'.' | b'_' | b'~' => uri.push(byte as char),
            byte if byte.is_ascii_alphanumeric() => uri.push(byte as char),
            byte => uri.push_str(&format!("%{byte:02X}")),
        }
    }
    uri
}
