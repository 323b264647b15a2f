//! `tweeze lsp`, driven as by an editor.

use super::*;
use lsp_server::{Message, Notification, Request, RequestId, ResponseError};
use lsp_types::Position;
use serde_json::{Value, json};
use std::io::{BufReader, Write as _};
use std::process::{Child, ChildStdin, ChildStdout};

/// An editor with one open folder.
pub struct Editor {
    server: Child,
    input: Option<ChildStdin>,
    output: BufReader<ChildStdout>,
    asked: i32,
}

impl Editor {
    /// Starts the server and performs the handshake.
    pub fn new(capabilities: Value) -> (Editor, Value) {
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

    pub fn send(&mut self, message: Message) {
        message.write(self.input.as_mut().expect("it is open")).expect("it is written");
    }

    pub fn note(&mut self, method: &str, params: Value) {
        self.send(Message::Notification(Notification::new(method.to_owned(), params)));
    }

    pub fn ask(&mut self, method: &str, params: Value) -> Result<Value, ResponseError> {
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

    pub fn receive(&mut self) -> Message {
        Message::read(&mut self.output).expect("it is a message").expect("the server is there")
    }

    /// The next findings that the server sends, with their document.
    pub fn findings(&mut self) -> (String, Vec<Value>) {
        loop {
            if let Message::Notification(note) = self.receive() {
                assert_eq!(note.method, "textDocument/publishDiagnostics");
                let uri = note.params["uri"].as_str().expect("a name").to_owned();
                return (uri, note.params["diagnostics"].as_array().expect("a list").clone());
            }
        }
    }

    pub fn open(&mut self, uri: &str, text: &str) {
        self.note(
            "textDocument/didOpen",
            json!({ "textDocument": { "uri": uri, "languageId": "tweeze", "version": 1, "text": text } }),
        );
    }

    pub fn change(&mut self, uri: &str, change: Value) {
        self.note(
            "textDocument/didChange",
            json!({ "textDocument": { "uri": uri, "version": 2 }, "contentChanges": [change] }),
        );
    }

    pub fn status(mut self) -> Option<i32> {
        drop(self.input.take());
        self.server.wait().expect("it ends").code()
    }
}

pub fn place(line: u32, character: u32) -> Value {
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

    // The emoji is two UTF-16 columns wide, so the wrong word begins at 29.
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
    let call = "let a = max(1, ";
    editor.change(&uri, json!({ "range": { "start": place(0, 0), "end": place(0, 0) }, "text": call }));
    let signature = editor.ask("textDocument/signatureHelp", at(0, 15)).expect("it answers");
    assert_eq!(
        (&signature["signatures"][0]["label"], &signature["activeParameter"]),
        (&json!("max(value, …)"), &json!(1))
    );
    assert_eq!(editor.ask("textDocument/signatureHelp", at(0, 4)).expect("it answers"), Value::Null);
    editor.change(&uri, json!({ "range": { "start": place(0, 0), "end": place(0, 15) }, "text": "" }));
    let field = editor.ask("textDocument/completion", at(1, 5)).expect("it answers");
    assert!(field.as_array().is_some_and(|items| items.iter().any(|item| item["label"] == "device")), "{field}");
    let steps = editor.ask("textDocument/completion", at(3, 17)).expect("it answers");
    let has = |word: &str| steps.as_array().is_some_and(|items| items.iter().any(|item| item["label"] == word));
    assert!(has("visit") && has("minimize") && has("precision") && !has("bot") && !has("device"), "{steps}");

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

/// Semantic tokens and folds of a text with a block, a comment of two lines, and characters of two UTF-16 units.
#[test]
fn a_text_has_colours_and_folds() {
    let bench = Bench::new();
    let uri = format!("file://{}", bench.path("a.twz").display());
    let (mut editor, hello) = Editor::new(json!({}));
    let tokens = &hello["capabilities"]["semanticTokensProvider"];
    assert_eq!((&tokens["full"], &tokens["legend"]["tokenTypes"][3]), (&json!(true), &json!("keyword")));
    let text = "// 😀 one\n// two\nuse std.dimibot\ntask go on bot {\n  for i in 0..3 {\n    move to (i, 3)\n  }\n}\n";
    editor.open(&uri, text);
    let whole = json!({ "textDocument": { "uri": &uri } });
    let data = editor.ask("textDocument/semanticTokens/full", whole.clone()).expect("it answers");
    let numbers: Vec<usize> = serde_json::from_value(data["data"].clone()).expect("a list of numbers");
    let (mut line, mut column) = (0, 0);
    let mut words = Vec::new();
    for token in numbers.chunks(5) {
        column = if token[0] == 0 { column + token[1] } else { token[1] };
        line += token[0];
        let units: Vec<u16> = text.lines().nth(line).expect("it is there").encode_utf16().collect();
        let word = String::from_utf16(&units[column..column + token[2]]).expect("whole characters");
        words.push(format!("{word}={}", tokens["legend"]["tokenTypes"][token[3]].as_str().expect("a word")));
    }
    let expected = "// 😀 one=comment, // two=comment, use=keyword, std=namespace, dimibot=namespace, task=keyword, go=function, \
                    on=keyword, bot=variable, for=keyword, i=variable, in=keyword, 0=number, 3=number, move=keyword, \
                    to=keyword, i=variable, 3=number";
    assert_eq!(words.join(", "), expected);
    let folds = editor.ask("textDocument/foldingRange", whole).expect("it answers");
    let lines = |fold: &Value| (fold["startLine"].as_u64(), fold["endLine"].as_u64());
    let found: Vec<_> = folds.as_array().expect("a list").iter().map(lines).collect();
    assert_eq!(found, [(Some(0), Some(1)), (Some(3), Some(6)), (Some(4), Some(5))]);
    let other = json!({ "textDocument": { "uri": "file:///nowhere.twz" } });
    assert_eq!(editor.ask("textDocument/semanticTokens/full", other).expect("it answers"), Value::Null);
}

/// A misspelt word is reported, and the quick fix repairs the program.
#[test]
fn a_quick_fix_writes_the_word_that_is_near() {
    let bench = Bench::new();
    let uri = format!("file://{}", bench.path("a.twz").display());
    let (mut editor, hello) = Editor::new(json!({}));
    assert_eq!(hello["capabilities"]["codeActionProvider"], true);
    editor.open(&uri, &SMALL.replace("move", "mvoe"));
    let (_, found) = editor.findings();
    let asked =
        json!({ "textDocument": { "uri": &uri }, "range": found[0]["range"], "context": { "diagnostics": found } });
    let fixes = editor.ask("textDocument/codeAction", asked).expect("it answers");
    assert_eq!((fixes.as_array().map(Vec::len), &fixes[0]["title"]), (Some(1), &json!("Write `move`")), "{fixes}");
    let edit = &fixes[0]["edit"]["changes"][&uri][0];
    editor.change(&uri, json!({ "range": edit["range"], "text": edit["newText"] }));
    assert_eq!(editor.findings().1, Vec::<Value>::new());
    // A fix of several edits after an emoji, which is two columns wide.
    let broken = SMALL.replace("move to (1, 1)", "move to 1, 1;").replace("{ ", "{ /* 😀 */ ");
    editor.change(&uri, json!({ "text": broken }));
    let (_, found) = editor.findings();
    let fixes = editor
        .ask(
            "textDocument/codeAction",
            json!({ "textDocument": { "uri": &uri }, "range": found[0]["range"], "context": { "diagnostics": found } }),
        )
        .expect("it answers");
    let titles: Vec<&Value> = fixes.as_array().expect("a list").iter().map(|fix| &fix["title"]).collect();
    assert_eq!(titles, ["Write `(1, 1)`", "Remove `;`"], "{fixes}");
    let edits: Vec<Value> = fixes
        .as_array()
        .expect("a list")
        .iter()
        .flat_map(|fix| fix["edit"]["changes"][&uri].as_array().expect("a list"))
        .map(|edit| json!({ "range": edit["range"], "text": edit["newText"] }))
        .rev()
        .collect();
    editor.note(
        "textDocument/didChange",
        json!({ "textDocument": { "uri": &uri, "version": 3 }, "contentChanges": edits }),
    );
    let (_, left) = editor.findings();
    assert_eq!(left.len(), 1, "the comment alone: {left:?}");
    // A finding without a fix, or one that this server never sent, has no action.
    for data in [Value::Null, json!(7), json!({ "range": 7 })] {
        let odd = json!({ "range": edit["range"], "message": "?", "data": data });
        let asked =
            json!({ "textDocument": { "uri": &uri }, "range": edit["range"], "context": { "diagnostics": [odd] } });
        assert_eq!(editor.ask("textDocument/codeAction", asked).expect("it answers"), json!([]));
    }
}

/// A used file that another program changes on the disk affects the open program that uses it.
#[test]
fn files_that_change_on_the_disk_are_read_again() {
    let bench = Bench::new();
    fs::write(bench.path("lab.twz"), "let goal = (1, 1)\n").expect("written");
    let [lab, program] = ["lab.twz", "a.twz"].map(|name| format!("file://{}", bench.path(name).display()));
    let text =
        SMALL.replace("use std.dimibot", "use std.dimibot\nuse \"lab.twz\" as lab").replace("(1, 1)", "lab.goal");
    let (mut editor, _) = Editor::new(json!({}));
    editor.open(&program, &text);
    assert_eq!(editor.findings(), (program.clone(), vec![]));
    fs::write(bench.path("lab.twz"), "let aim = (1, 1)\n").expect("written");
    let changed = |uri: &str| json!({ "changes": [{ "uri": uri, "type": 2 }] });
    // The text in the editor stands for this file: nothing is checked again, and the next findings are those below.
    editor.note("workspace/didChangeWatchedFiles", changed(&program));
    editor.note("workspace/didChangeWatchedFiles", changed(&lab));
    let (of, found) = editor.findings();
    assert_eq!((of, found.len()), (program, 1), "{found:?}");
    says(found[0]["message"].as_str().expect("text"), &["goal"]);
    editor.note("exit", Value::Null);
    assert_eq!(editor.status(), Some(ERRORS));
}

/// A change of a used file in the editor, not yet on the disk, affects the program that uses it.
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
    assert_eq!(after.last(), Some(&(program.clone(), vec![])), "{after:?}");
    // An error in the program may originate in the other file.
    editor.open(&lab, "let goal = (9999, 1)\n");
    let (of, found) = editor.findings();
    assert_eq!((of, found.len()), (program, 1), "{found:?}");
    let related = &found[0]["relatedInformation"][0];
    assert_eq!(related["location"]["uri"].as_str(), Some(lab.as_str()), "{found:?}");
    assert_eq!(related["location"]["range"]["start"], place(0, 11), "{found:?}");
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

/// Starts the server as a client does.
fn server() -> Child {
    let mut server = Plain::new(env!("CARGO_BIN_EXE_tweeze"));
    server.arg("lsp").stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    server.spawn().expect("the server starts")
}

#[test]
fn what_is_no_message_ends_the_server_with_a_sentence() {
    let says_of = |bytes: &[u8]| {
        let mut server = server();
        // It may end before everything is written.
        let _ = server.stdin.take().expect("it is open").write_all(bytes);
        let ended = server.wait_with_output().expect("it ends");
        assert_eq!(ended.status.code(), Some(ERRORS), "{:?}", String::from_utf8_lossy(bytes));
        String::from_utf8_lossy(&ended.stderr).into_owned()
    };
    for (length, words) in [
        ("99999999999999", "a message of "),
        ("18446744073709551615", "a message of "),
        ("99999999999999999999999", "a header with the length `9999"),
        ("-1", "a header with the length `-1`"),
        ("268435457", "a message of "),
    ] {
        let reported = says_of(format!("Content-Length: {length}\r\n\r\n{{}}").as_bytes());
        assert!(reported.starts_with(&format!("tweeze lsp: {words}")) && reported.lines().count() == 1, "{reported}");
    }
    let early = r#"{"jsonrpc":"2.0","method":"textDocument/didOpen","params":{}}"#;
    let reported = says_of(format!("Content-Length: {}\r\n\r\n{early}", early.len()).as_bytes());
    assert!(reported.contains("must be `initialize`") && !reported.contains("Notification"), "{reported}");
    let endless = [b'a'; 10_000];
    for bytes in [&b"Content-Length: 7\r\n\r\n{}"[..], b"hello\r\n", b"\r\n\r\n", b"\xff\xfe", &endless] {
        let reported = says_of(bytes);
        assert!(reported.starts_with("tweeze lsp: ") && reported.lines().count() == 1, "{reported}");
    }
}

#[test]
fn a_message_that_says_nothing_is_refused_and_the_next_one_read() {
    let framed = |body: &[u8]| [format!("Content-Length: {}\r\n\r\n", body.len()).as_bytes(), body].concat();
    let initialize = br#"{"jsonrpc":"2.0","id":1,"method":"initialize","params":{"capabilities":{}}}"#;
    let messages = [&b"{bad"[..], b"", b"\xff", b"{}", b"[]", initialize].map(framed).concat();
    let mut server = server();
    server.stdin.take().expect("it is open").write_all(&messages).expect("it reads");
    let answers = String::from_utf8(server.wait_with_output().expect("it ends").stdout).expect("it is text");
    assert_eq!((answers.matches("-32700").count(), answers.matches("-32600").count()), (3, 2), "{answers}");
    assert!(answers.contains("\"capabilities\""), "{answers}");
}

/// The words of a program under test, each given by the position of its first letter, as `line:column`.
fn words_at(locations: &Value) -> Vec<String> {
    let list = locations.as_array().expect("a list").iter();
    list.map(|location| {
        let (start, uri) = (&location["range"]["start"], location["uri"].as_str().unwrap_or("here"));
        format!("{} {}:{}", uri.rsplit('/').next().expect("a name"), start["line"], start["character"])
    })
    .collect()
}

/// The position in a text of the caret, which a bar marks in some of its words.
fn caret(text: &str, words: &str) -> Value {
    let (before, after) = words.split_once('|').expect("a caret");
    let at = text.find(&format!("{before}{after}")).unwrap_or_else(|| panic!("{words}")) + before.len();
    let line = text[..at].matches('\n').count();
    let start = text[..at].rfind('\n').map_or(0, |end| end + 1);
    place(line as u32, text[start..at].encode_utf16().count() as u32)
}

#[test]
fn names_lead_to_their_declarations_and_back() {
    let bench = Bench::new();
    let lab = "use std.dimibot\ndevice picker : dimibot.femto_st { left: 3 }\nlet goal = (3, 4)\n";
    fs::write(bench.path("µ lab.twz"), lab).expect("it is written");
    let text = "use \"µ lab.twz\" as lab\ndevice bot : lab.picker { right: 3 }\n\
                scene s { obstacle dust : cells { from: (7, 7), to: (7, 7) } }\n\
                task go(n: number) on bot in s { for i in 0..n { move to (i, 1) }, move to lab.goal }\n\
                program day { run go(2), run go(3) }\n";
    let [main, used] = ["main.twz", "µ lab.twz"].map(|name| format!("file://{}", bench.path(name).display()));
    let used = used.replace('µ', "%C2%B5").replace(' ', "%20");
    let (mut editor, _) = Editor::new(json!({}));
    editor.open(&main, text);
    assert_eq!(editor.findings().1, Vec::<Value>::new());
    let at =
        |uri: &str, text: &str, words: &str| json!({ "textDocument": { "uri": uri }, "position": caret(text, words) });

    // A device in another file, from the middle of its name; a task; a parameter; a loop name; a scene.
    let found = editor.ask("textDocument/definition", at(&main, text, "lab.pic|ker")).expect("it answers");
    assert_eq!((found["uri"].as_str(), &found["range"]["start"]), (Some(used.as_str()), &caret(lab, "device |picker")));
    for (from, to) in [
        ("run g|o(3", "task |go("),
        ("0..|n", "go(|n"),
        ("(|i, 1)", "for |i"),
        ("in |s {", "scene |s"),
        ("on bo|t", "|bot :"),
    ] {
        let found = editor.ask("textDocument/definition", at(&main, text, from)).expect("it answers");
        assert_eq!(
            (found["uri"].as_str(), &found["range"]["start"]),
            (Some(main.as_str()), &caret(text, to)),
            "{from}"
        );
    }
    // A word of the language is not a name, and the library has no file.
    for (uri, text, words) in [(&main, text, "|use"), (&main, text, "mo|ve"), (&used, lab, "femto|_st")] {
        assert_eq!(editor.ask("textDocument/definition", at(uri, text, words)).expect("it answers"), Value::Null);
    }

    let with = |uri: &str, text: &str, words: &str, declared: bool| {
        let mut asked = at(uri, text, words);
        asked["context"] = json!({ "includeDeclaration": declared });
        asked
    };
    let uses = editor.ask("textDocument/references", with(&main, text, "task g|o", false)).expect("it answers");
    assert_eq!(words_at(&uses), ["main.twz 4:18", "main.twz 4:29"]);
    // Also from the used file once it is open: the server knows which programs use it.
    editor.open(&used, lab);
    editor.findings();
    let uses = editor.ask("textDocument/references", with(&used, lab, "let go|al", true)).expect("it answers");
    assert_eq!(words_at(&uses), ["main.twz 3:79", "%C2%B5%20lab.twz 2:4"]);
    let lit = editor.ask("textDocument/documentHighlight", at(&main, text, "device |bot")).expect("it answers");
    assert_eq!(words_at(&lit), ["here 1:7", "here 3:22"]);

    let rename = |editor: &mut Editor, (uri, text): (&str, &str), words: &str, name: &str| {
        let mut asked = at(uri, text, words);
        asked["newName"] = json!(name);
        editor.ask("textDocument/rename", asked)
    };
    let edits = rename(&mut editor, (&used, lab), "let go|al", "target").expect("it answers");
    let changes = edits["changes"].as_object().expect("by document");
    assert_eq!(changes.len(), 2, "{changes:?}");
    let range = json!({ "start": caret(text, "lab.|goal"), "end": caret(text, "lab.goal|") });
    assert_eq!(changes[&main], json!([{ "range": range, "newText": "target" }]));
    for (name, why) in [
        ("go", "another meaning"),
        ("task", "valid name"),
        ("a b", "valid name"),
        ("1", "valid name"),
        ("", "valid name"),
    ] {
        let refused = rename(&mut editor, (&main, text), "device b|ot", name).expect_err("it is refused");
        says(&refused.message, &[why]);
    }
    let refused = rename(&mut editor, (&main, text), "|use", "x").expect_err("it is refused");
    says(&refused.message, &["no name declared in your files"]);
}

#[test]
fn parts_of_a_scene_are_names_too() {
    let text = "use std.electrode_array as ea\ndevice chip : ea.droplet_chip { columns: 9, rows: 9 }\n\
                scene s { part a : ea.droplet at (1, 1), for i in 0..2 { part b[i] : ea.droplet at (1 + 4 * i, 9) } }\n\
                task go on chip in s { together { merge a with b0 at (3, 3), move b[1] to (9, 9) } }\n";
    let (mut editor, _) = Editor::new(json!({}));
    editor.open("untitled:one", text);
    assert_eq!(editor.findings().1, Vec::<Value>::new());
    let at = |words: &str| json!({ "textDocument": { "uri": "untitled:one" }, "position": caret(text, words) });
    for (from, to) in [("merge |a", "part |a"), ("with b|0", "part |b[i]"), ("move |b[1]", "part |b[i]")] {
        let found = editor.ask("textDocument/definition", at(from)).expect("it answers");
        assert_eq!((&found["uri"], &found["range"]["start"]), (&json!("untitled:one"), &caret(text, to)), "{from}");
    }
    let renamed = |editor: &mut Editor, words: &str, name: &str| {
        let mut asked = at(words);
        asked["newName"] = json!(name);
        editor.ask("textDocument/rename", asked)
    };
    let refused = renamed(&mut editor, "with b|0", "c").expect_err("its name is made by an index");
    says(&refused.message, &["index"]);
    for name in ["disc", "chip", "i"] {
        renamed(&mut editor, "part |a", name).expect_err("it is taken, or kept");
    }
}

/// A rename that would break something is refused; indices and parameters are kept; an unused name can be renamed too.
#[test]
fn a_new_name_breaks_nothing() {
    let board = "use std.electrode_array as ea\ndevice chip : ea.droplet_chip { columns: 14, rows: 9 }\n";
    let renamed = |text: &str, words: &str| {
        let (mut editor, _) = Editor::new(json!({}));
        editor.open("untitled:one", text);
        editor.findings();
        let asked =
            json!({ "textDocument": { "uri": "untitled:one" }, "position": caret(text, words), "newName": "zz" });
        let edits = editor.ask("textDocument/rename", asked).map_err(|refused| refused.message)?;
        let edits = edits["changes"]["untitled:one"].as_array().expect("edits").clone();
        let column = |edit: &Value, end: &str| {
            let place = &edit["range"][end];
            (place["line"].as_u64().expect("a line"), place["character"].as_u64().expect("a column"))
        };
        Ok::<_, String>(edits.iter().map(|edit| (column(edit, "start"), column(edit, "end"))).collect::<Vec<_>>())
    };
    let indexed = format!(
        "{board}scene b {{ for p in 0..2 {{ part s[p] : ea.droplet at (2, 2 + 4 * p) }} }}\n\
         task read on chip in b {{ for p in 0..2 {{ move s[p] to (10, 2 + 4 * p) }} }}\n"
    );
    assert_eq!(renamed(&indexed, "part |s"), Ok(vec![((2, 31), (2, 32)), ((3, 46), (3, 47))]));
    let given = format!(
        "{board}scene b {{ part a : ea.droplet at (2, 2) }}\ntask go(p: part) on chip in b {{ move p to (9, 5) }}\n\
         program day {{ run go(a) }}\n"
    );
    assert_eq!(renamed(&given, "move |p").map(|edits| edits.len()), Ok(2));
    let avoided = format!(
        "{board}scene b {{ part blood : ea.droplet at (2, 2), part serum : ea.droplet at (2, 8) }}\n\
         task read on chip in b {{\n  avoid blood in serum\n  assay {{ move blood to (11, 5), move serum to (11, 8) }}\n}}\n"
    );
    assert_eq!(renamed(&avoided, "part |blood").map(|edits| edits.len()), Ok(3));
    // Rows of a table of robots are uses of a name that the server does not know.
    let robots = include_str!("../../examples/microrobots_drive.twz");
    says(&renamed(robots, "robot |D2").expect_err("it is named elsewhere, too"), &["no robot", "by hand"]);
    assert_eq!(renamed("let alone = 5\n", "let |alone").map(|edits| edits.len()), Ok(1));
}

/// The parameter of a curve is declared nowhere.
#[test]
fn a_formula_declares_no_name() {
    let text = "let bump = profile { x: 14 um * cos(t) - 6 um * cos(2 * t), y: 9 um * sin(t) }\n";
    let (mut editor, _) = Editor::new(json!({}));
    editor.open("untitled:one", text);
    for words in ["14 um * |cos", "14 um * cos(|t", "9 um * sin(|t"] {
        let at = json!({ "textDocument": { "uri": "untitled:one" }, "position": caret(text, words) });
        let found = editor.ask("textDocument/definition", at.clone()).expect("it answers");
        assert!(found.is_null(), "{words}: {found}");
        let mut renamed = at;
        renamed["newName"] = json!("u");
        let refused = editor.ask("textDocument/rename", renamed).expect_err("it is refused");
        says(&refused.message, &["no name declared in your files"]);
    }
}
