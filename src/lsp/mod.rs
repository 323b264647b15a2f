//! Language server on standard input and output.
//!
//! Input: messages of the Language Server Protocol 3.17. Output: the checker's findings after each change, the
//! canonical form, document symbols, semantic tokens and folds, completions and hover texts. Method: each open text is
//! kept as it is in the editor (`text`); after all pending messages are read, every open program is checked as a whole,
//! with open texts in place of the files on the disk. Guarantee: no message but `exit` ends the server; an unknown
//! document, a position outside a text or an unknown request gets an empty answer or an error. Nothing is planned here.

mod capabilities;
mod completion;
mod cursor;
mod findings;
mod highlight;
mod hints;
mod names;
mod outline;
mod planning;
mod signatures;
mod text;
mod words;

#[cfg(test)]
mod tests;

pub use planning::{PLANNED, PlanningResult, ProgramPlanner};

use crate::check::imports::Library;
use capabilities::{capabilities, column_unit, refreshes_hints};
use findings::{OpenFindings, Overlay};
use hints::CheckedFigures;
use lsp_server::{Connection, ErrorCode, Message, Notification, Request, Response};
use lsp_types::notification::{
    DidChangeTextDocument, DidChangeWatchedFiles, DidCloseTextDocument, DidOpenTextDocument, DidSaveTextDocument, Exit,
    Notification as Notice, PublishDiagnostics,
};
use lsp_types::request::{
    CodeActionRequest, CodeLensRequest, Completion, DocumentHighlightRequest, DocumentSymbolRequest,
    FoldingRangeRequest, Formatting, GotoDefinition, HoverRequest, InlayHintRefreshRequest, InlayHintRequest,
    References, Rename, Request as Asked, SemanticTokensFullRequest, Shutdown, SignatureHelpRequest,
};
use lsp_types::{
    DocumentHighlight, DocumentSymbolResponse, InitializeParams, Location, PublishDiagnosticsParams, SemanticTokens,
    TextEdit, Uri, WorkspaceEdit,
};
use names::ProgramNames;
use planning::ProgramPlans;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use text::{ColumnUnit, EditedText};

/// Gives access to the files around a program; supplied by a caller that may read files.
pub type FilesAround<'a> = &'a dyn Fn(&Path, &mut dyn FnMut(&dyn Library));

/// How a session ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SessionEnd {
    /// The client asked for the shutdown before it ended the session.
    Agreed,
    /// The client ended the session without a shutdown, or disconnected.
    Abrupt,
}

/// Serves one client until it ends. The planner's results arrive through the connection, like the client's messages.
///
/// # Errors
/// The first messages are not those of the protocol.
pub fn serve(
    connection: &Connection,
    around: FilesAround,
    planner: &mut dyn ProgramPlanner,
) -> Result<SessionEnd, String> {
    let unexpected =
        |_| "the first message of a client must be `initialize`, and the next one `initialized`".to_owned();
    let (id, asked) = connection.initialize_start().map_err(unexpected)?;
    let asked: InitializeParams = serde_json::from_value(asked)
        .map_err(|error| format!("the parameters of `initialize` do not follow the protocol: {error}"))?;
    let unit = column_unit(&asked);
    let answer = json!({
        "capabilities": capabilities(unit),
        "serverInfo": { "name": "tweeze", "version": env!("CARGO_PKG_VERSION") },
    });
    connection.initialize_finish(id, answer).map_err(unexpected)?;
    let mut session = Session {
        connection,
        around,
        planner,
        unit,
        refreshes_hints: refreshes_hints(&asked),
        open: BTreeMap::new(),
        tickets: 0,
        is_changed: false,
        is_shut: false,
    };
    Ok(session.run())
}

/// An open document.
struct OpenDocument {
    uri: Uri,
    text: EditedText,
    version: i32,
    /// Whether the file on the disk is the same as this text.
    is_saved: bool,
    /// Ticket of the last search for plans of this text; `None` if the files on the disk differ from the open ones.
    ticket: Option<u64>,
    /// Result of that search, once it has ended.
    plans: ProgramPlans,
    /// The checker's figures for the text of the last published findings.
    figures: CheckedFigures,
}

struct Session<'a> {
    connection: &'a Connection,
    around: FilesAround<'a>,
    planner: &'a mut dyn ProgramPlanner,
    unit: ColumnUnit,
    /// Whether the client can be asked to request hints again.
    refreshes_hints: bool,
    /// By path.
    open: BTreeMap<PathBuf, OpenDocument>,
    /// Number of tickets given so far: to searches for plans, and to requests that the client answers.
    tickets: u64,
    /// Whether a text or a file has changed since findings were last published.
    is_changed: bool,
    /// Whether the client has asked for the shutdown; only `exit` may follow.
    is_shut: bool,
}

impl Session<'_> {
    fn run(&mut self) -> SessionEnd {
        loop {
            let Ok(message) = self.connection.receiver.recv() else { return SessionEnd::Abrupt };
            if let Some(end) = self.take(message) {
                return end;
            }
            // Pending messages are read first, so that fast typing is checked only once, for the last text.
            while let Ok(message) = self.connection.receiver.try_recv() {
                if let Some(end) = self.take(message) {
                    return end;
                }
            }
            self.settle();
        }
    }

    /// Publishes findings of the current texts, if a text or a file has changed since the last time.
    fn settle(&mut self) {
        if self.is_changed {
            self.publish_all();
        }
    }

    fn take(&mut self, message: Message) -> Option<SessionEnd> {
        match message {
            Message::Request(Request { id, .. }) if self.is_shut => {
                let why = "the server was shut down and waits for `exit`".to_owned();
                self.send(Message::Response(Response::new_err(id, ErrorCode::InvalidRequest as i32, why)));
            }
            Message::Request(request) if request.method == Shutdown::METHOD => {
                self.is_shut = true;
                self.is_changed = false;
                self.send(Message::Response(Response::new_ok(request.id, ())));
            }
            Message::Request(request) => self.answer(request),
            Message::Notification(notice) if notice.method == Exit::METHOD => {
                return Some(if self.is_shut { SessionEnd::Agreed } else { SessionEnd::Abrupt });
            }
            Message::Notification(_) if self.is_shut => {}
            Message::Notification(notice) => self.note(notice),
            Message::Response(_) => {}
        }
        None
    }

    fn answer(&mut self, request: Request) {
        let Request { id, method, params } = request;
        if method == InlayHintRequest::METHOD {
            // Hints refer to the checked text, so pending changes are checked first.
            self.settle();
        }
        let answer = match method.as_str() {
            Formatting::METHOD => read(params).map(|asked| json!(self.formatted::<Formatting>(&asked))),
            DocumentSymbolRequest::METHOD => read(params).map(|asked| json!(self.symbols(&asked))),
            HoverRequest::METHOD => read(params).map(|asked| json!(self.hover(&asked))),
            Completion::METHOD => read(params).map(|asked| json!(self.completions(&asked))),
            CodeActionRequest::METHOD => read::<lsp_types::CodeActionParams>(params)
                .map(|asked| json!(findings::quick_fixes(&asked.text_document.uri, asked.context.diagnostics))),
            GotoDefinition::METHOD => read(params).map(|asked| json!(self.definition(&asked))),
            References::METHOD => read(params).map(|asked| json!(self.references(&asked))),
            DocumentHighlightRequest::METHOD => read(params).map(|asked| json!(self.highlights(&asked))),
            InlayHintRequest::METHOD => read(params).map(|asked| json!(self.hints(&asked))),
            CodeLensRequest::METHOD => read(params).map(|asked| json!(self.lenses(&asked))),
            SignatureHelpRequest::METHOD => read(params).map(|asked| json!(self.signatures(&asked))),
            FoldingRangeRequest::METHOD => read(params).map(|asked| json!(self.folds(&asked))),
            SemanticTokensFullRequest::METHOD => read(params).map(|asked| json!(self.tokens(&asked))),
            Rename::METHOD => match read(params).map(|asked| self.renamed(&asked)) {
                Some(Ok(edits)) => Some(json!(edits)),
                Some(Err(why)) => {
                    return self.send(Message::Response(Response::new_err(id, ErrorCode::RequestFailed as i32, why)));
                }
                None => None,
            },
            _ => {
                let why = format!("`{method}` is not supported");
                return self.send(Message::Response(Response::new_err(id, ErrorCode::MethodNotFound as i32, why)));
            }
        };
        let response = match answer {
            Some(answer) => Response::new_ok(id, answer),
            None => {
                let why = format!("these parameters do not fit `{method}`");
                Response::new_err(id, ErrorCode::InvalidParams as i32, why)
            }
        };
        self.send(Message::Response(response));
    }

    fn note(&mut self, notice: Notification) {
        match notice.method.as_str() {
            DidOpenTextDocument::METHOD => {
                let Some(opened) = read::<lsp_types::DidOpenTextDocumentParams>(notice.params) else { return };
                let document = opened.text_document;
                let Some(path) = text::path(&document.uri) else { return };
                let opened = OpenDocument {
                    uri: document.uri,
                    text: EditedText::new(document.text),
                    version: document.version,
                    is_saved: true,
                    ticket: None,
                    plans: ProgramPlans::default(),
                    figures: CheckedFigures::default(),
                };
                self.open.insert(path.clone(), opened);
                self.is_changed = true;
            }
            DidChangeTextDocument::METHOD => {
                let Some(changed) = read::<lsp_types::DidChangeTextDocumentParams>(notice.params) else { return };
                let Some(path) = text::path(&changed.text_document.uri) else { return };
                let Some(document) = self.open.get_mut(&path) else { return };
                (document.is_saved, document.plans) = (false, ProgramPlans::default());
                for change in changed.content_changes {
                    document.text.change(change.range, &change.text, self.unit);
                }
                document.version = changed.text_document.version;
                self.is_changed = true;
            }
            DidSaveTextDocument::METHOD => {
                let Some(saved) = read::<lsp_types::DidSaveTextDocumentParams>(notice.params) else { return };
                let path = text::path(&saved.text_document.uri);
                let Some(document) = path.and_then(|path| self.open.get_mut(&path)) else { return };
                document.is_saved = true;
                self.disk_changed();
            }
            DidChangeWatchedFiles::METHOD => {
                let Some(changed) = read::<lsp_types::DidChangeWatchedFilesParams>(notice.params) else { return };
                let is_open = |uri: &Uri| text::path(uri).is_some_and(|path| self.open.contains_key(&path));
                // An open text stands for its file. Any other file may be one that open programs read from the disk.
                if changed.changes.iter().any(|change| !is_open(&change.uri)) {
                    self.disk_changed();
                }
            }
            PLANNED => {
                let Some(result) = read::<PlanningResult>(notice.params) else { return };
                self.planned(&result);
            }
            DidCloseTextDocument::METHOD => {
                let Some(closed) = read::<lsp_types::DidCloseTextDocumentParams>(notice.params) else { return };
                let uri = closed.text_document.uri;
                let Some(path) = text::path(&uri) else { return };
                self.planner.stop(&path);
                if self.open.remove(&path).is_some() {
                    self.publish(uri, Vec::new(), None);
                    self.is_changed = true;
                }
            }
            _ => {}
        }
    }

    /// A file on the disk has changed, which any open program may read: all are checked and planned again.
    fn disk_changed(&mut self) {
        self.open.values_mut().for_each(|document| document.ticket = None);
        self.is_changed = true;
    }

    /// Checks every open program: a change in one may affect those that use it.
    fn publish_all(&mut self) {
        let texts = self.texts();
        let mut all_found = Vec::with_capacity(texts.len());
        let mut all_figures = Vec::with_capacity(texts.len());
        let mut read = BTreeMap::new();
        for (path, document) in &self.open {
            let mut checked = OpenFindings::default();
            (self.around)(path, &mut |disk| {
                checked = findings::of(path, &document.uri, &texts, disk, self.unit);
            });
            all_found.push(checked.found);
            all_figures.push(checked.figures);
            read.insert(path.clone(), checked.read);
        }
        self.follow_disk(&read);
        self.is_changed = false;
        for ((path, document), mut found) in self.open.iter().zip(all_found) {
            found.extend(document.plans.diagnostics(path, &document.uri, &document.text, self.unit, &found));
            self.publish(document.uri.clone(), found, Some(document.version));
        }
        for (document, figures) in self.open.values_mut().zip(all_figures) {
            document.figures = figures;
        }
    }

    /// The open texts by path.
    fn texts(&self) -> BTreeMap<PathBuf, &str> {
        self.open.iter().map(|(path, document)| (path.clone(), document.text.as_str())).collect()
    }

    fn publish(&self, uri: Uri, diagnostics: Vec<lsp_types::Diagnostic>, version: Option<i32>) {
        let params = PublishDiagnosticsParams { uri, diagnostics, version };
        self.send(Message::Notification(Notification::new(PublishDiagnostics::METHOD.to_owned(), params)));
    }

    fn send(&self, message: Message) {
        // If the client is gone, the next receive fails.
        let _ = self.connection.sender.send(message);
    }

    fn document(&self, uri: &Uri) -> Option<&OpenDocument> {
        self.open.get(&text::path(uri)?)
    }

    /// The canonical form, as one edit of the whole text; no edit if the text already has it.
    fn formatted<R>(&self, asked: &R::Params) -> Option<Vec<TextEdit>>
    where
        R: Asked<Params = lsp_types::DocumentFormattingParams>,
    {
        let text = &self.document(&asked.text_document.uri)?.text;
        let canonical = outline::canonical(text.as_str());
        let edit = || TextEdit { range: text.range(0..text.as_str().len(), self.unit), new_text: canonical.clone() };
        Some(if canonical == text.as_str() { Vec::new() } else { vec![edit()] })
    }

    fn symbols(&self, asked: &lsp_types::DocumentSymbolParams) -> Option<DocumentSymbolResponse> {
        let text = &self.document(&asked.text_document.uri)?.text;
        Some(DocumentSymbolResponse::Nested(outline::symbols(text, self.unit)))
    }

    fn folds(&self, asked: &lsp_types::FoldingRangeParams) -> Option<Vec<lsp_types::FoldingRange>> {
        Some(highlight::folds(&self.document(&asked.text_document.uri)?.text))
    }

    fn tokens(&self, asked: &lsp_types::SemanticTokensParams) -> Option<SemanticTokens> {
        let text = &self.document(&asked.text_document.uri)?.text;
        Some(SemanticTokens { result_id: None, data: highlight::tokens(text, self.unit) })
    }

    fn hover(&self, asked: &lsp_types::HoverParams) -> Option<lsp_types::Hover> {
        let place = &asked.text_document_position_params;
        let document = self.document(&place.text_document.uri)?;
        let at = document.text.offset(place.position, self.unit);
        words::hover(&document.text, at, self.unit, &document.plans)
    }

    fn signatures(&self, asked: &lsp_types::SignatureHelpParams) -> Option<lsp_types::SignatureHelp> {
        let place = &asked.text_document_position_params;
        let text = &self.document(&place.text_document.uri)?.text;
        signatures::help(text.as_str(), text.offset(place.position, self.unit))
    }

    fn hints(&self, asked: &lsp_types::InlayHintParams) -> Option<Vec<lsp_types::InlayHint>> {
        let document = self.document(&asked.text_document.uri)?;
        Some(hints::shown(&document.text, &document.figures, &document.plans, asked.range, self.unit))
    }

    /// Code lenses over the heads of tasks and programs; none if the text is not a file.
    fn lenses(&self, asked: &lsp_types::CodeLensParams) -> Option<Vec<lsp_types::CodeLens>> {
        let uri = &asked.text_document.uri;
        let is_file = text::path(uri)?.is_absolute();
        let document = self.document(uri)?;
        Some(if is_file { outline::lenses(&document.text, uri, self.unit) } else { Vec::new() })
    }

    fn completions(&self, asked: &lsp_types::CompletionParams) -> Option<Vec<lsp_types::CompletionItem>> {
        let (path, at) = self.place(&asked.text_document_position)?;
        let texts = self.texts();
        let mut found = Vec::new();
        (self.around)(&path, &mut |disk| {
            found = completion::completions(texts[&path], at, &Overlay::around(&path, &texts, disk));
        });
        Some(found)
    }
}

/// Planning of saved programs.
impl Session<'_> {
    /// Starts planning for each program that is on the disk exactly as it is open here, together with all open files
    /// that it uses, because the planner reads the disk. Discards the plans of the others. `read` lists the open files
    /// that each program reads.
    fn follow_disk(&mut self, read: &BTreeMap<PathBuf, BTreeSet<PathBuf>>) {
        let mut has_lost_hints = false;
        for (path, read) in read.iter().filter(|(path, _)| path.is_absolute()) {
            let Some(is_saved) = self.open.get(path).map(|document| document.is_saved) else { continue };
            let is_on_disk = is_saved && self.are_on_disk(read);
            let Some(document) = self.open.get_mut(path) else { continue };
            let is_settled = match document.ticket {
                Some(_) => is_on_disk,
                None => !is_on_disk && !document.plans.has_hints() && !document.plans.has_findings(),
            };
            if is_settled {
                continue;
            }
            has_lost_hints |= is_saved && document.plans.has_hints();
            self.is_changed |= document.plans.has_findings();
            document.plans = ProgramPlans::default();
            document.ticket = is_on_disk.then_some(self.tickets + 1);
            match document.ticket {
                Some(ticket) => {
                    self.tickets = ticket;
                    self.planner.start(path, ticket);
                }
                None => self.planner.stop(path),
            }
        }
        if has_lost_hints {
            self.refresh_hints();
        }
    }

    /// Asks the client to request hints again, although their text has not changed.
    fn refresh_hints(&mut self) {
        if self.refreshes_hints {
            self.tickets += 1;
            let id = format!("hints {}", self.tickets).into();
            self.send(Message::Request(Request::new(id, InlayHintRefreshRequest::METHOD.to_owned(), ())));
        }
    }

    /// Whether these open texts are the same on the disk.
    fn are_on_disk(&self, paths: &BTreeSet<PathBuf>) -> bool {
        let texts = self.texts();
        paths.iter().all(|path| {
            let name = text::file_name(path);
            let mut is_same = false;
            // Editors do not include a byte order mark in the text.
            let plain = |text: &str| text.trim_start_matches('\u{feff}').to_owned();
            (self.around)(path, &mut |disk| {
                let found = disk.read("", &name).map(|(_, text)| plain(&text));
                is_same = texts.get(path).is_some_and(|open| found == Ok(plain(open)));
            });
            is_same
        })
    }

    /// Takes the result of planning, unless the text has changed since.
    fn planned(&mut self, result: &PlanningResult) {
        let Some(document) = self.open.get_mut(&result.path) else { return };
        if !document.is_saved || document.ticket != Some(result.ticket) {
            return;
        }
        document.plans = ProgramPlans::of(result);
        // If the planner found only what the checker found, there is nothing new to publish.
        self.is_changed |= document.plans.has_findings();
        self.refresh_hints();
    }
}

/// Requests about names.
impl Session<'_> {
    /// The names of all open programs.
    fn names(&self) -> ProgramNames {
        let uris = self.open.iter().map(|(path, document)| (path.clone(), document.uri.clone()));
        let mut names = ProgramNames::new(uris.collect());
        let texts = self.texts();
        for path in self.open.keys() {
            (self.around)(path, &mut |disk| names.add(path, &texts, disk));
        }
        names
    }

    /// The path and the byte offset of a position in an open document.
    fn place(&self, place: &lsp_types::TextDocumentPositionParams) -> Option<(PathBuf, usize)> {
        let path = text::path(&place.text_document.uri)?;
        let offset = self.open.get(&path)?.text.offset(place.position, self.unit);
        Some((path, offset))
    }

    fn definition(&self, asked: &lsp_types::GotoDefinitionParams) -> Option<Location> {
        let (path, offset) = self.place(&asked.text_document_position_params)?;
        self.names().definition(&path, offset, self.unit)
    }

    fn references(&self, asked: &lsp_types::ReferenceParams) -> Option<Vec<Location>> {
        let (path, offset) = self.place(&asked.text_document_position)?;
        Some(self.names().references(&path, offset, self.unit, asked.context.include_declaration))
    }

    /// The occurrences of a name in its own file.
    fn highlights(&self, asked: &lsp_types::DocumentHighlightParams) -> Option<Vec<DocumentHighlight>> {
        let place = &asked.text_document_position_params;
        let (path, offset) = self.place(place)?;
        let all = self.names().references(&path, offset, self.unit, true).into_iter();
        let own = all.filter(|location| location.uri == place.text_document.uri);
        Some(own.map(|location| DocumentHighlight { range: location.range, kind: None }).collect())
    }

    fn renamed(&self, asked: &lsp_types::RenameParams) -> Result<WorkspaceEdit, String> {
        let (path, offset) = self.place(&asked.text_document_position).ok_or("the document is not open")?;
        let (edit, renamed) = self.names().renamed(&path, offset, self.unit, &asked.new_name)?;
        let before = self.texts();
        let after = renamed.iter().map(|(path, text)| (path.clone(), text.as_str()));
        let after: BTreeMap<PathBuf, &str> = before.clone().into_iter().chain(after).collect();
        for path in self.open.keys() {
            let [mut old, mut new] = [Vec::new(), Vec::new()];
            (self.around)(path, &mut |disk| {
                old = findings::errors(path, &before, disk);
                new = findings::errors(path, &after, disk);
            });
            if new.len() > old.len() {
                let first = new.iter().find(|error| !old.contains(error)).unwrap_or(&new[0]);
                return Err(format!("this name would cause an error: {first}; rename by hand"));
            }
        }
        Ok(edit)
    }
}

fn read<T: DeserializeOwned>(params: Value) -> Option<T> {
    serde_json::from_value(params).ok()
}
