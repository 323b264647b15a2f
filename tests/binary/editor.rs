//! `tweeze lsp`, driven as an editor drives it.

use super::*;
use lsp_server::{Message, Notification, Request, RequestId, ResponseError};
use lsp_types::Position;
use serde_json::{Value, json};
use std::io::{BufReader, Write as _};
use std::process::{Child, ChildStdin, ChildStdout};

/// An editor with one open folder.
struct Editor {
    server: Child,
    input: Option<ChildStdin>,
    output: BufReader<ChildStdout>,
    asked: i32,
}

impl Editor {
    /// Starts the server and shakes hands.
    fn new(capabilities: Value) -> (Editor, Value) {
        let mut server = Plain::new(env!("CARGO_BIN_EXE_tweeze"))
            .arg("lsp")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the server starts");
        let input = server.stdin.take();
        let output = BufReader::new(server.stdout.take().expect("it has an output"));
        let mut editor = Editor { server, input, output, asked: 0 };
        let hello = editor.ask("initialize", json!({ "capabilities": capabilities }));
        editor.note("initialized", json!({}));
        (editor, hello.expect("it answers"))
    }

    fn send(&mut self, message: Message) {
        message.write(self.input.as_mut().expect("it is open")).expect("it is written");
    }

    fn note(&mut self, method: &str, params: Value) {
        self.send(Message::Notification(Notification::new(method.to_owned(), params)));
    }

    fn ask(&mut self, method: &str, params: Value) -> Result<Value, ResponseError> {
        self.asked += 1;
        let id = RequestId::from(self.asked);
        self.send(Message::Request(Request::new(id.clone(), method.to_owned(), params)));
        loop {
            match self.receive() {
                Message::Response(response) if response.id == id => return response.response_result,
                Message::Response(_) | Message::Request(_) | Message::Notification(_) => {}
            }
        }
    }

    fn receive(&mut self) -> Message {
        Message::read(&mut self.output).expect("it is a message").expect("the server is there")
    }

    /// The next findings that the server sends, with their document.
    fn findings(&mut self) -> (String, Vec<Value>) {
        loop {
            if let Message::Notification(note) = self.receive() {
                assert_eq!(note.method, "textDocument/publishDiagnostics");
                let uri = note.params["uri"].as_str().expect("a name").to_owned();
                return (uri, note.params["diagnostics"].as_array().expect("a list").clone());
            }
        }
    }

    fn open(&mut self, uri: &str, text: &str) {
        self.note(
            "textDocument/didOpen",
            json!({ "textDocument": { "uri": uri, "languageId": "tweeze", "version": 1, "text": text } }),
        );
    }

    fn change(&mut self, uri: &str, change: Value) {
        self.note(
            "textDocument/didChange",
            json!({ "textDocument": { "uri": uri, "version": 2 }, "contentChanges": [change] }),
        );
    }

    fn status(mut self) -> Option<i32> {
        drop(self.input.take());
        self.server.wait().expect("it ends").code()
    }
}

fn place(line: u32, character: u32) -> Value {
    json!(Position { line, character })
}

#[test]
fn an_editor_opens_mends_and_formats_a_program() {
    let bench = Bench::new();
    let uri = format!("file://{}", bench.path("a.twz").display());
    let at = |line, character| json!({ "textDocument": { "uri": &uri }, "position": place(line, character) });
    let whole = json!({ "textDocument": { "uri": &uri }, "options": { "tabSize": 2, "insertSpaces": true } });
    let (mut editor, hello) = Editor::new(json!({}));
    assert_eq!(hello["capabilities"]["positionEncoding"], "utf-16");

    // The emoji is two columns of UTF-16, so the wrong word begins at 29.
    let text = SMALL.replace("{ move", "{ /* 😀 */ mvoe").replace("/* 😀 */ ", "");
    editor.open(&uri, &text.replace("task", "// 😀 µ\ntask"));
    let (of, found) = editor.findings();
    assert_eq!((of.as_str(), found.len()), (uri.as_str(), 1), "{found:?}");
    assert_eq!((&found[0]["code"], &found[0]["severity"]), (&json!("E0208"), &json!(1)));
    assert_eq!(found[0]["range"], json!({ "start": place(3, 17), "end": place(3, 21) }));
    says(found[0]["message"].as_str().expect("text"), &["mvoe", "help: ", "move"]);

    editor.change(&uri, json!({ "range": { "start": place(3, 17), "end": place(3, 21) }, "text": "move" }));
    assert_eq!(editor.findings(), (uri.clone(), vec![]));

    let hover = editor.ask("textDocument/hover", at(3, 18)).expect("it answers");
    says(hover["contents"]["value"].as_str().expect("text"), &["move to (", "`via`"]);
    let field = editor.ask("textDocument/completion", at(1, 5)).expect("it answers");
    assert!(field.as_array().is_some_and(|items| items.iter().any(|item| item["label"] == "device")), "{field}");
    let steps = editor.ask("textDocument/completion", at(3, 17)).expect("it answers");
    let has = |word: &str| steps.as_array().is_some_and(|items| items.iter().any(|item| item["label"] == word));
    assert!(has("visit") && has("minimize") && has("precision") && has("bot") && !has("device"), "{steps}");

    let symbols = editor.ask("textDocument/documentSymbol", whole.clone()).expect("it answers");
    let names: Vec<&Value> = symbols.as_array().expect("a list").iter().map(|symbol| &symbol["name"]).collect();
    assert_eq!(names, ["bot", "go"]);

    assert_eq!(editor.ask("textDocument/formatting", whole.clone()).expect("it answers"), json!([]));
    editor.change(&uri, json!({ "range": { "start": place(1, 0), "end": place(1, 6) }, "text": "device  " }));
    editor.findings();
    let edits = editor.ask("textDocument/formatting", whole).expect("it answers");
    assert_eq!(edits[0]["newText"], SMALL.replace("task", "// 😀 µ\ntask"));

    editor.note("textDocument/didClose", json!({ "textDocument": { "uri": &uri } }));
    assert_eq!(editor.findings(), (uri, vec![]));
    assert_eq!(editor.ask("shutdown", Value::Null).expect("it answers"), Value::Null);
    editor.note("exit", Value::Null);
    assert_eq!(editor.status(), Some(DONE));
}

/// A change of a used file in the editor, which the disk has not seen, concerns the program that uses it.
#[test]
fn open_texts_stand_for_files() {
    let bench = Bench::new();
    fs::write(bench.path("lab.twz"), "let goal = (1, 1)\n").expect("written");
    let [lab, program] = ["lab.twz", "a.twz"].map(|name| format!("file://{}", bench.path(name).display()));
    let text =
        SMALL.replace("use std.dimibot", "use std.dimibot\nuse \"lab.twz\" as lab").replace("(1, 1)", "lab.goal");
    let (mut editor, _) = Editor::new(json!({ "general": { "positionEncodings": ["utf-16", "utf-8"] } }));
    editor.open(&program, &text);
    assert_eq!(editor.findings(), (program.clone(), vec![]));
    editor.open(&lab, "let aim = (1, 1)\n");
    let (of, found) = editor.findings();
    assert_eq!((of, found.len()), (program.clone(), 1));
    says(found[0]["message"].as_str().expect("text"), &["goal"]);
    editor.note("textDocument/didClose", json!({ "textDocument": { "uri": &lab } }));
    let after: Vec<(String, Vec<Value>)> = (0..3).map(|_| editor.findings()).collect();
    assert_eq!(after.last(), Some(&(program, vec![])), "{after:?}");
    editor.note("exit", Value::Null);
    assert_eq!(editor.status(), Some(ERRORS));
}

#[test]
fn nothing_strange_ends_the_server() {
    let (mut editor, _) = Editor::new(json!({}));
    let uri = "untitled:Untitled-1";
    editor.open(uri, "task µ on 😀 {");
    editor.findings();
    for (line, character) in [(0, 0), (0, 9), (0, 10), (0, 999), (9, 9), (u32::MAX, u32::MAX)] {
        let at = json!({ "textDocument": { "uri": uri }, "position": place(line, character) });
        for method in ["textDocument/hover", "textDocument/completion"] {
            assert!(editor.ask(method, at.clone()).is_ok(), "{method} {line} {character}");
        }
        editor.change(uri, json!({ "range": { "start": place(line, character), "end": place(0, 3) }, "text": "{" }));
        editor.findings();
    }
    let nowhere = json!({ "textDocument": { "uri": "file:///nowhere.twz" }, "position": place(0, 0) });
    assert_eq!(editor.ask("textDocument/hover", nowhere).expect("it answers"), Value::Null);
    for (method, params) in [("textDocument/hover", json!(7)), ("textDocument/rename", json!({})), ("", json!([]))] {
        assert!(editor.ask(method, params).is_err(), "{method}");
    }
    editor.note("textDocument/didChange", json!({ "what": "ever" }));
    editor.note("$/unknown", Value::Null);
    editor.ask("shutdown", Value::Null).expect("it answers");
    editor.note("exit", Value::Null);
    assert_eq!(editor.status(), Some(DONE));
}

#[test]
fn a_client_that_goes_away_ends_the_server() {
    let (editor, _) = Editor::new(json!({}));
    assert_eq!(editor.status(), Some(ERRORS));
}

#[test]
fn after_shutdown_only_the_exit_is_taken() {
    let (mut editor, _) = Editor::new(json!({}));
    editor.ask("shutdown", Value::Null).expect("it answers");
    let refused = editor.ask("textDocument/formatting", json!({})).expect_err("it is shut down");
    assert_eq!(refused.code, -32600, "{refused:?}");
    editor.open("untitled:a", "task");
    assert!(editor.ask("shutdown", Value::Null).is_err());
    editor.note("exit", Value::Null);
    assert_eq!(editor.status(), Some(DONE));
}

#[test]
fn what_is_no_message_ends_the_server_with_a_sentence() {
    let says_of = |bytes: &[u8]| {
        let mut server = Plain::new(env!("CARGO_BIN_EXE_tweeze"))
            .arg("lsp")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the server starts");
        // It may end before all of it is written.
        let _ = server.stdin.take().expect("it is open").write_all(bytes);
        let ended = server.wait_with_output().expect("it ends");
        assert_eq!(ended.status.code(), Some(ERRORS), "{:?}", String::from_utf8_lossy(bytes));
        String::from_utf8_lossy(&ended.stderr).into_owned()
    };
    for length in ["99999999999999", "18446744073709551615", "99999999999999999999999", "-1", "268435457"] {
        let told = says_of(format!("Content-Length: {length}\r\n\r\n{{}}").as_bytes());
        assert!(told.starts_with("tweeze lsp: a message of ") && told.lines().count() == 1, "{told}");
    }
    let endless = [b'a'; 10_000];
    for bytes in [
        &b"Content-Length: 7\r\n\r\n{}"[..],
        b"hello\r\n",
        b"\r\n\r\n",
        b"\xff\xfe",
        &endless,
        b"Content-Length: 2\r\n\r\n7}",
    ] {
        let told = says_of(bytes);
        assert!(told.starts_with("tweeze lsp: ") && told.lines().count() == 1, "{told}");
    }
}
