//! Inlay hints and code lenses as an editor receives them.

use super::*;
use crate::editor::{Editor, place};
use lsp_server::Message;
use serde_json::{Value, json};

/// The next finding with a code, in any message.
fn finding(editor: &mut Editor, code: &str) -> Value {
    loop {
        let (_, found) = editor.findings();
        if let Some(found) = found.into_iter().find(|found| found["code"] == code) {
            return found;
        }
    }
}

impl Editor {
    /// Waits until the server asks to refresh hints, and answers.
    fn refreshed(&mut self) {
        loop {
            if let Message::Request(request) = self.receive() {
                assert_eq!(request.method, "workspace/inlayHint/refresh");
                return self.send(Message::Response(lsp_server::Response::new_ok(request.id, ())));
            }
        }
    }

    /// The hints of a document: position and text of each.
    fn hints(&mut self, uri: &str) -> Vec<(Value, String)> {
        let all = json!({ "start": place(0, 0), "end": place(999, 0) });
        let asked = json!({ "textDocument": { "uri": uri }, "range": all });
        let hints = self.ask("textDocument/inlayHint", asked).expect("it answers");
        let hint = |hint: &Value| (hint["position"].clone(), hint["label"].as_str().expect("a text").to_owned());
        hints.as_array().expect("a list").iter().map(hint).collect()
    }
}

/// The planner reads files, so a text that differs from its file is not planned until it is saved.
#[test]
fn what_is_not_on_the_disk_is_not_planned() {
    let bench = Bench::new();
    let uri = format!("file://{}", bench.path("a.twz").display());
    let (mut editor, _) = Editor::new(json!({ "workspace": { "inlayHint": { "refreshSupport": true } } }));
    let text = "use std.dimibot\ndevice bot : dimibot.femto_st\ntask go on bot { move to (1, 1) }\n";
    fs::write(bench.path("a.twz"), "use std.dimibot\nlet x =\n").expect("written");
    editor.open(&uri, text);
    assert_eq!(editor.findings().1, Vec::<Value>::new());
    std::thread::sleep(std::time::Duration::from_millis(500));
    fs::write(bench.path("a.twz"), text).expect("written");
    editor.note("textDocument/didSave", json!({ "textDocument": { "uri": &uri } }));
    assert_eq!(editor.findings().1, Vec::<Value>::new());
    // The first planning result is for the saved text.
    match editor.receive() {
        Message::Request(request) => assert_eq!(request.method, "workspace/inlayHint/refresh"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn saved_programs_are_planned() {
    let bench = Bench::new();
    let uri = format!("file://{}", bench.path("a.twz").display());
    let (mut editor, hello) = Editor::new(json!({ "workspace": { "inlayHint": { "refreshSupport": true } } }));
    assert_eq!(hello["capabilities"]["textDocumentSync"]["save"], true);
    let text = "use std.dimibot\ndevice bot : dimibot.femto_st\n// µ\ntask go on bot { // there\n  move to (1, 1)\n}\nprogram both { run go, run go }\n";
    let save = |editor: &mut Editor, text: &str| {
        fs::write(bench.path("a.twz"), text).expect("written");
        editor.change(&uri, json!({ "text": text }));
        editor.note("textDocument/didSave", json!({ "textDocument": { "uri": &uri } }));
    };
    fs::write(bench.path("a.twz"), text).expect("written");
    editor.open(&uri, text);
    editor.refreshed();
    let hints = editor.hints(&uri);
    let places: Vec<&Value> = hints.iter().map(|hint| &hint.0).collect();
    assert_eq!(places, [&place(1, 29), &place(3, 25), &place(4, 16), &place(6, 31)], "{hints:?}");
    says(&hints[0].1, &["cells of "]);
    says(&hints[1].1, &["ms, ", " um (", "optimal (bound"]);
    // The first run moves; in the second the tip is already there.
    assert_eq!(hints[2].1, "0 ms to 30 ms");
    says(&hints[3].1, &["ms in 2 runs"]);
    let on_name = json!({ "textDocument": { "uri": &uri }, "position": place(3, 6) });
    let hover = editor.ask("textDocument/hover", on_name).expect("it answers");
    says(hover["contents"]["value"].as_str().expect("text"), &["Planned and verified", "optimal (bound"]);
    // An unsaved text has no plans.
    editor.change(&uri, json!({ "range": { "start": place(4, 11), "end": place(4, 12) }, "text": "2" }));
    assert_eq!(editor.hints(&uri), hints[..1]);
    // The planner's finding is at its line.
    let walled = "use std.dimibot\ndevice bot : dimibot.femto_st\nscene s { obstacle wall : cells { from: (1, 0), to: (1, 3) } }\ntask go on bot in s { move to (3, 3) }\n";
    save(&mut editor, walled);
    let found = finding(&mut editor, "E0601");
    assert_eq!(found["range"]["start"]["line"], 3, "{found}");
    assert_eq!(found["relatedInformation"][0]["location"]["range"]["start"]["line"], 2, "{found}");
    assert_eq!(editor.hints(&uri), hints[..1]);
    // It disappears with the next edit, and an error that the checker finds is not listed twice.
    save(&mut editor, &walled.replace("(3, 3)", "(30, 3)"));
    let found = loop {
        let (_, found) = editor.findings();
        if found.iter().any(|found| found["code"] == "E0501") {
            break found;
        }
    };
    assert_eq!(found.len(), 1, "{found:?}");
    save(&mut editor, text);
    editor.refreshed();
    assert_eq!(editor.ask("shutdown", json!(null)).expect("it answers"), Value::Null);
    editor.note("exit", json!(null));
    assert_eq!(editor.status(), Some(0));
}

/// The planner reads files, so the plans of a program are dropped when a used file is open with another text, and
/// return with the file's own text.
#[test]
fn plans_are_those_of_the_open_texts() {
    let bench = Bench::new();
    let [lab, program] = ["lab.twz", "a.twz"].map(|name| format!("file://{}", bench.path(name).display()));
    let walls = "let far = (1, 3)\n";
    let walled = "use std.dimibot\nuse \"lab.twz\"\ndevice bot : dimibot.femto_st\nscene s { obstacle wall : cells { from: (1, 0), to: lab.far } }\ntask go on bot in s { move to (3, 3) }\n";
    fs::write(bench.path("lab.twz"), walls).expect("written");
    fs::write(bench.path("a.twz"), walled).expect("written");
    let (mut editor, _) = Editor::new(json!({ "workspace": { "inlayHint": { "refreshSupport": true } } }));
    editor.open(&program, walled);
    finding(&mut editor, "E0601");
    editor.open(&lab, walls);
    let of_program = |editor: &mut Editor| loop {
        let (of, found) = editor.findings();
        if of == program {
            break found.iter().map(|found| found["code"].as_str().expect("a code").to_owned()).collect::<Vec<_>>();
        }
    };
    assert_eq!(of_program(&mut editor), ["E0601"]);
    // Saved or not, the program itself has changed now; it is planned when the other file is saved, too.
    editor.change(&lab, json!({ "text": "let far = (1, 2)\n" }));
    assert_eq!(of_program(&mut editor), [""; 0]);
    editor.note("textDocument/didSave", json!({ "textDocument": { "uri": &program } }));
    assert_eq!(editor.hints(&program).len(), 1);
    fs::write(bench.path("lab.twz"), "let far = (1, 2)\n").expect("written");
    editor.note("textDocument/didSave", json!({ "textDocument": { "uri": &lab } }));
    editor.refreshed();
    assert!(editor.hints(&program).len() > 1);
    // A text that is closed without being saved is replaced by its file.
    editor.change(&lab, json!({ "text": walls }));
    editor.refreshed();
    assert_eq!(editor.hints(&program).len(), 1);
    editor.note("textDocument/didClose", json!({ "textDocument": { "uri": &lab } }));
    editor.refreshed();
    assert!(editor.hints(&program).len() > 1);
}

/// The checker's figures are available while the text is typed, without a plan.
#[test]
fn hints_tell_pitches_and_the_cells_of_places() {
    let (mut editor, _) = Editor::new(json!({}));
    let uri = "untitled:one";
    let text = "use std.dimibot, use std.electrode_array as ea\n\
                device bot : dimibot.femto_st { left: 5 }\ndevice plate : ea.droplet_chip { columns: 9, rows: 9 }\n\
                let shelf = (1.9 um, 2.1 um)\n\
                task go on bot { move to (3, 3), move to (3.2 um, 5.9 um), for i in 1..9 { move to (i * 1 um, 2 um) }, move to shelf }\n";
    editor.open(uri, text);
    let hints = editor.hints(uri);
    let reported: Vec<(u64, &str)> =
        hints.iter().map(|(at, label)| (at["line"].as_u64().expect("a line"), label.as_str())).collect();
    let expected = [
        (1, "cells of 426.916 nm by 3.41533 um"),
        (2, "cells of 1.5 mm"),
        (4, "cell (7, 2), 954.4 nm off"),
        (4, "cell (12, 1), 1.4207 um off; cell (14, 1), 1.4155 um off; cell (16, 1), 1.4254 um off …"),
        (4, "cell (4, 1), 1.3293 um off"),
    ];
    assert_eq!(reported, expected);
    // They follow the text, even in the message that changes it, and disappear with an error.
    editor.change(uri, json!({ "range": { "start": place(1, 38), "end": place(1, 39) }, "text": "7" }));
    let changed = editor.hints(uri);
    assert_eq!(changed.len(), hints.len());
    assert_ne!(changed[0].1, hints[0].1);
    editor.change(uri, json!({ "range": { "start": place(1, 38), "end": place(1, 39) }, "text": "70000" }));
    assert_eq!(editor.hints(uri), []);
}

/// Hints of a board's steps, and of turns with what they really reach.
#[test]
fn hints_tell_what_steps_take_and_reach() {
    let bench = Bench::new();
    let (mut editor, _) = Editor::new(json!({ "workspace": { "inlayHint": { "refreshSupport": true } } }));
    let mut planned = |name: &str, text: &str| {
        let uri = format!("file://{}", bench.path(name).display());
        fs::write(bench.path(name), text).expect("written");
        editor.open(&uri, text);
        editor.refreshed();
        editor.hints(&uri)
    };
    let board = "use std.electrode_array as ea\ndevice plate : ea.droplet_chip { columns: 9, rows: 9 }\n\
                 scene s { part a : ea.droplet at (2, 2) }\n\
                 task go on plate in s {\n  move a to (5, 2)\n  together {\n    move a to (5, 6)\n  }\n}\n";
    let steps: Vec<(Value, String)> = planned("board.twz", board).into_iter().skip(2).collect();
    assert_eq!(steps, [(place(4, 18), "180 ms, 3 steps".to_owned()), (place(5, 12), "240 ms, 4 steps".to_owned())]);
    let hand = "use std.fingers as f\ndevice hand : f.three_fingers { tip_radius: 4.5 um, step: 20 deg }\n\
                scene cell { part bead : ellipsoid { axes: (16 um, 11.845 um, 11.845 um), material: f.silicon } }\n\
                task flip on hand in cell {\n  rotate bead by 80 deg about z\n}\n";
    let turned = planned("hand.twz", hand);
    let at_step: Vec<&String> = turned.iter().filter(|hint| hint.0["line"] == 4).map(|hint| &hint.1).collect();
    assert_eq!(at_step.len(), 1, "{turned:?}");
    says(at_step[0], &[" s, reaches 80.0005 deg"]);
}

/// The code lenses over tasks and programs, as a client carries them out.
#[test]
fn lenses_build_and_show_a_task() {
    let bench = Bench::new();
    let uri = format!("file://{}", bench.path("a.twz").display());
    let (mut editor, hello) = Editor::new(json!({}));
    assert_eq!(hello["capabilities"]["codeLensProvider"], json!({ "resolveProvider": false }));
    let text = "use std.dimibot\ndevice bot : dimibot.femto_st\ntask go on bot { move to (1, 1) }\n\
                task at_place(c: cell) on bot { move to c }\nprogram day { run go, run at_place((2, 2)) }\n";
    fs::write(bench.path("a.twz"), text).expect("written");
    editor.open(&uri, text);
    let lenses = editor.ask("textDocument/codeLens", json!({ "textDocument": { "uri": &uri } })).expect("it answers");
    let lenses = lenses.as_array().expect("a list");
    let reported: Vec<(&Value, &Value, &Value)> = lenses
        .iter()
        .map(|lens| (&lens["range"]["start"], &lens["command"]["title"], &lens["command"]["command"]))
        .collect();
    let (build, view) = ((json!("Build"), json!("tweeze.build")), (json!("View"), json!("tweeze.view")));
    let [go, day] = [place(2, 5), place(4, 8)];
    let expected =
        [(&go, &build.0, &build.1), (&go, &view.0, &view.1), (&day, &build.0, &build.1), (&day, &view.0, &view.1)];
    assert_eq!(reported, expected);
    assert_eq!(lenses[0]["command"]["arguments"], json!([&uri, "go"]));
    // The command of the lens builds that task only.
    let arguments = &lenses[2]["command"]["arguments"];
    bench
        .run(&["build", "a.twz", "--task", arguments[1].as_str().expect("a name"), "-o", "out", "--emit", "json"])
        .code(DONE);
    assert_eq!(bench.names("out"), ["day.json"]);
    // An unsaved text cannot be built, and a document that is not open has no tasks.
    editor.open("untitled:one", text);
    for (uri, expected) in [("untitled:one", json!([])), ("file:///nowhere.twz", Value::Null)] {
        let lenses =
            editor.ask("textDocument/codeLens", json!({ "textDocument": { "uri": uri } })).expect("it answers");
        assert_eq!(lenses, expected, "{uri}");
    }
}
