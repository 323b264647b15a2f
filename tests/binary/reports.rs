//! Machine-readable diagnostics and reports: `--format short`, `json`, `github` and `sarif`.

use assert_cmd::Command;
use assert_cmd::assert::Assert;
use serde_json::{Value, json};
use std::fs;
use tempfile::TempDir;

const SOUND: &str = "use std.dimibot\ndevice bot : dimibot.femto_st\ntask go on bot { move to (1, 1) }\n";

/// A program without a task, which is a warning, and with a name of multi-byte letters that is declared twice.
const BROKEN: &str = "let µ位 = 3 um\nlet µ位 = 4 um\n";

fn bench() -> TempDir {
    let bench = tempfile::tempdir().expect("a folder for the test");
    let write = |name: &str, text: &str| fs::write(bench.path().join(name), text).expect("a program is written");
    write("sound.twz", SOUND);
    write("bro,ken 1%.twz", BROKEN);
    bench
}

fn run(bench: &TempDir, arguments: &[&str]) -> Assert {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tweeze"));
    command.current_dir(bench.path()).args(arguments).assert()
}

fn out(assert: &Assert) -> String {
    String::from_utf8_lossy(&assert.get_output().stdout).into_owned()
}

fn err(assert: &Assert) -> String {
    String::from_utf8_lossy(&assert.get_output().stderr).into_owned()
}

fn parsed(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

#[test]
fn short_is_a_line_for_each_diagnostic() {
    let bench = bench();
    let failed = run(&bench, &["check", "bro,ken 1%.twz", "sound.twz", "gone.twz", "--format", "short"]).code(4);
    let text = err(&failed);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 3, "{text}");
    assert!(lines[0].starts_with("bro,ken 1%.twz:1:1: warning[W0503]"), "{text}");
    assert!(lines[1].starts_with("bro,ken 1%.twz:2:5: error[E0202]"), "{text}");
    assert!(lines[2].starts_with("error[E0801]: cannot read `gone.twz`"), "{text}");
    assert_eq!(out(&failed), "  Checked  sound.twz  1 device, 1 task\n");
}

#[test]
fn json_has_the_place_and_all_labels() {
    let bench = bench();
    let failed = run(&bench, &["check", "bro,ken 1%.twz", "gone.twz", "--format", "json"]).code(4);
    let lines: Vec<Value> = err(&failed).lines().map(parsed).collect();
    let (warning, error, unreadable) = (&lines[0], &lines[1], &lines[2]);
    assert_eq!(warning["severity"], "warning");
    assert_eq!([&warning["line"], &warning["column"]], [1, 1]);
    assert_eq!([&error["severity"], &error["file"]], ["error", "bro,ken 1%.twz"]);
    assert_eq!([&error["line"], &error["column"]], [2, 5]);
    assert_eq!([&error["end_line"], &error["end_column"]], [2, 7], "columns are characters");
    let first = &error["labels"][0];
    for key in ["file", "line", "column", "end_line", "end_column"] {
        assert_eq!(error[key], first[key]);
        assert!(unreadable[key].is_null(), "{unreadable}");
    }
    assert!(first["text"].is_string() && error["title"].is_string(), "{error}");
    assert_eq!(unreadable["labels"], json!([]));
    assert!(error["edits"].is_null() && unreadable["edits"].is_null(), "nothing is known to the letter");
}

/// A program with fixes of two edits that belong together: `=>` for `->` with its spaces, and brackets on both sides of
/// a place.
const MENDABLE: &str =
    "use std.dimibot\ndevice bot = dimibot.femto_st { stroke: 1 µV }\ntask go on bot { move to 1, 2; }\n";

#[test]
fn edits_stand_in_json_and_sarif() {
    let bench = bench();
    fs::write(bench.path().join("mend.twz"), MENDABLE).expect("written");
    let failed = run(&bench, &["check", "mend.twz", "--format", "json"]).code(1);
    let mut text = MENDABLE.to_owned();
    // Applied from the last one on, so that the offsets of the others stay valid.
    let mut edits: Vec<Value> = err(&failed)
        .lines()
        .map(parsed)
        .flat_map(|line| line["edits"].as_array().cloned().unwrap_or_default())
        .collect();
    edits.sort_by_key(|edit| (edit["line"].as_u64(), edit["column"].as_u64()));
    assert!(edits.len() >= 4, "{}", err(&failed));
    for edit in edits.iter().rev() {
        let [start, end] = [["line", "column"], ["end_line", "end_column"]].map(|keys| {
            let [line, column] = keys.map(|key| edit[key].as_u64().expect("a number") as usize);
            let of_line: usize = text.split_inclusive('\n').take(line - 1).map(str::len).sum();
            of_line + text[of_line..].chars().take(column - 1).map(char::len_utf8).sum::<usize>()
        });
        text.replace_range(start..end, edit["replacement"].as_str().expect("a text"));
    }
    assert_eq!(
        text,
        "use std.dimibot\ndevice bot : dimibot.femto_st { stroke: 1 µV }\ntask go on bot { move to (1, 2) }\n"
    );
    let failed = run(&bench, &["check", "mend.twz", "--format", "sarif"]).code(1);
    let document = parsed(&out(&failed));
    let faults: Vec<String> = jsonschema::validator_for(&schema())
        .expect("a schema")
        .iter_errors(&document)
        .map(|error| error.to_string())
        .collect();
    assert!(faults.is_empty(), "{faults:?}\n{document:#}");
    let results = document["runs"][0]["results"].as_array().expect("a list");
    let inserted: Vec<&Value> = results
        .iter()
        .filter_map(|result| result["fixes"].as_array())
        .flatten()
        .flat_map(|fix| fix["artifactChanges"][0]["replacements"].as_array().expect("a list"))
        .map(|edit| &edit["insertedContent"]["text"])
        .collect();
    assert_eq!(inserted, [":", "(", ")", ""], "{document:#}");
}

#[test]
fn reports_of_success_are_json_too() {
    let bench = bench();
    let checked = parsed(&out(&run(&bench, &["check", "sound.twz", "--format", "json"]).code(0)));
    let declared = json!({ "devices": 1, "scenes": 0, "tasks": 1, "programs": 0 });
    assert_eq!(checked, json!({ "checked": "sound.twz", "declared": declared }));
    let built = parsed(&out(&run(&bench, &["build", "sound.twz", "--emit", "mcap,csv", "--format", "json"]).code(0)));
    assert_eq!([&built["built"], &built["declared"]], [&json!("sound.twz"), &declared]);
    let schedule = &built["schedules"][0];
    assert_eq!(
        [&schedule["name"], &schedule["files"]],
        [&json!("go"), &json!(["go.mcap", "go.lichtblick.json", "go.csv"])]
    );
    assert_eq!(schedule["plans"][0]["optimal"], true);
    assert_eq!(schedule["plans"][0]["cost"], schedule["plans"][0]["bound"]);
    let verified = run(&bench, &["verify", "go.mcap", "--against", "sound.twz", "--format", "json"]).code(0);
    let verified = parsed(&out(&verified));
    assert_eq!([&verified["verified"], &verified["against"]], ["go.mcap", "sound.twz"]);
    assert_eq!(verified["schedule"]["actuations"], schedule["actuations"]);
}

#[test]
fn workflow_commands_are_escaped() {
    let bench = bench();
    let failed = run(&bench, &["check", "bro,ken 1%.twz", "--format", "github"]).code(1);
    let text = err(&failed);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 2, "{text}");
    let place = "file=bro%2Cken 1%25.twz,line=2,endLine=2,col=5,endColumn=7,title=E0202";
    assert!(lines[0].starts_with("::warning file=bro%2Cken 1%25.twz,line=1,"), "{text}");
    assert!(lines[1].starts_with(&format!("::error {place}::")) && text.contains("%0Ahelp: "), "{text}");
}

/// The part of SARIF 2.1.0 that Tweeze uses, by sections 3.13 (document) to 3.30 (regions) of the standard.
fn schema() -> Value {
    let text = json!({ "type": "object", "required": ["text"], "additionalProperties": false, "properties": {
        "text": { "type": "string", "minLength": 1 }, "markdown": { "type": "string", "minLength": 1 } } });
    let number = json!({ "type": "integer", "minimum": 1 });
    let level = json!({ "enum": ["none", "note", "warning", "error"] });
    let region = json!({ "type": "object", "required": ["startLine"], "additionalProperties": false, "properties": {
        "startLine": number, "startColumn": number, "endLine": number, "endColumn": number } });
    let artifact = json!({ "type": "object", "additionalProperties": false, "properties": {
        "uri": { "type": "string", "format": "uri-reference" } } });
    let physical = json!({ "type": "object", "required": ["artifactLocation"], "additionalProperties": false,
        "properties": { "artifactLocation": artifact, "region": region } });
    let location = json!({ "type": "object", "additionalProperties": false, "properties": {
        "physicalLocation": physical, "message": text } });
    let locations = json!({ "type": "array", "items": location });
    let rule = json!({ "type": "object", "required": ["id"], "additionalProperties": false, "properties": {
        "id": { "type": "string" }, "shortDescription": text, "help": text,
        "defaultConfiguration": { "type": "object", "properties": { "level": level } } } });
    let replacement = json!({ "type": "object", "required": ["deletedRegion"], "additionalProperties": false, "properties": {
        "deletedRegion": region, "insertedContent": { "type": "object", "required": ["text"], "properties": { "text": { "type": "string" } } } } });
    let change = json!({ "type": "object", "required": ["artifactLocation", "replacements"], "additionalProperties": false,
        "properties": { "artifactLocation": artifact, "replacements": { "type": "array", "minItems": 1, "items": replacement } } });
    let fix = json!({ "type": "object", "required": ["artifactChanges"], "additionalProperties": false, "properties": {
        "description": text, "artifactChanges": { "type": "array", "minItems": 1, "items": change } } });
    let result = json!({ "type": "object", "required": ["message"], "additionalProperties": false, "properties": {
        "ruleId": { "type": "string" }, "ruleIndex": { "type": "integer", "minimum": 0 }, "level": level,
        "message": text, "locations": locations, "relatedLocations": locations,
        "fixes": { "type": "array", "items": fix } } });
    let driver = json!({ "type": "object", "required": ["name"], "additionalProperties": false, "properties": {
        "name": { "type": "string" }, "semanticVersion": { "type": "string" },
        "rules": { "type": "array", "uniqueItems": true, "items": rule } } });
    let run = json!({ "type": "object", "required": ["tool"], "additionalProperties": false, "properties": {
        "tool": { "type": "object", "required": ["driver"], "properties": { "driver": driver } },
        "columnKind": { "enum": ["utf16CodeUnits", "unicodeCodePoints"] },
        "results": { "type": "array", "items": result } } });
    json!({ "type": "object", "required": ["version", "runs"], "additionalProperties": false, "properties": {
        "$schema": { "type": "string", "format": "uri" }, "version": { "const": "2.1.0" },
        "runs": { "type": "array", "items": run } } })
}

#[test]
fn sarif_is_one_document() {
    let bench = bench();
    let files = ["bro,ken 1%.twz", "sound.twz", "gone.twz"];
    let failed = run(&bench, &["check", files[0], files[1], files[2], "--format", "sarif"]).code(4);
    assert_eq!(err(&failed), "");
    let document = parsed(&out(&failed));
    let validator = jsonschema::validator_for(&schema()).expect("a schema");
    let faults: Vec<String> = validator.iter_errors(&document).map(|error| error.to_string()).collect();
    assert!(faults.is_empty(), "{faults:?}\n{document:#}");
    let run_of = &document["runs"][0];
    let results = run_of["results"].as_array().expect("a list");
    assert_eq!(results.len(), 3, "{document:#}");
    for result in results {
        let rule = &run_of["tool"]["driver"]["rules"][result["ruleIndex"].as_u64().expect("a number") as usize];
        assert_eq!([&rule["id"], &rule["defaultConfiguration"]["level"]], [&result["ruleId"], &result["level"]]);
    }
    let place = &results[1]["locations"][0]["physicalLocation"];
    assert_eq!(place["artifactLocation"]["uri"], "bro%2Cken%201%25.twz");
    assert_eq!(place["region"], json!({ "startLine": 2, "startColumn": 5, "endLine": 2, "endColumn": 7 }));
    let related = &results[1]["relatedLocations"][0]["physicalLocation"];
    assert_eq!(related["region"]["startLine"], 1, "{document:#}");
    assert_eq!(results[2]["locations"], json!([]));
    let sound = parsed(&out(&run(&bench, &["check", "sound.twz", "--format", "sarif"]).code(0)));
    assert_eq!(sound["runs"][0]["results"], json!([]));
    run(&bench, &["build", "sound.twz", "--format", "sarif"]).code(2);
}
