//! The checker's findings of an open program, in the form that editors show.

use super::hints::CheckedFigures;
use super::text::{self, ColumnUnit, EditedText};
use crate::check::imports::{FileFault, Library};
use crate::check::{Checked, Options, ProgramSource, check_program};
use crate::diagnostic::{Diagnostic, Label, Severity, Sink};
use crate::source::{FileId, Origin, Sources, beside};
use lsp_types::{
    CodeAction, CodeActionKind, DiagnosticRelatedInformation, DiagnosticSeverity, Location, NumberOrString, TextEdit,
    Uri, WorkspaceEdit,
};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Library that prefers open texts to files on the disk.
pub struct Overlay<'a> {
    /// Folder of the program.
    pub folder: &'a Path,
    pub texts: &'a BTreeMap<PathBuf, &'a str>,
    pub disk: &'a dyn Library,
}

impl<'a> Overlay<'a> {
    /// The overlay for the program of a path.
    pub fn around(path: &'a Path, texts: &'a BTreeMap<PathBuf, &'a str>, disk: &'a dyn Library) -> Overlay<'a> {
        Overlay { folder: path.parent().unwrap_or(Path::new("")), texts, disk }
    }

    /// Path of a file that is named relative to the program.
    pub fn path(&self, name: &str) -> PathBuf {
        match self.folder.as_os_str().is_empty() {
            // The program is a text that was never saved.
            true => PathBuf::from(name),
            false => PathBuf::from(beside(&format!("{}/", self.folder.display()), name)),
        }
    }
}

impl Library for Overlay<'_> {
    fn read(&self, from: &str, path: &str) -> Result<(String, String), FileFault> {
        let name = beside(from, path);
        match self.texts.get(&self.path(&name)) {
            Some(text) => Ok((name, (*text).to_owned())),
            None => self.disk.read(from, path),
        }
    }

    fn read_mesh(&self, from: &str, path: &str) -> Result<(String, String), FileFault> {
        self.disk.read_mesh(from, path)
    }

    fn shown(&self, name: &str) -> String {
        name.to_owned()
    }
}

/// Result of checking an open program.
#[derive(Default)]
pub struct OpenFindings {
    pub found: Vec<lsp_types::Diagnostic>,
    /// Empty if there is an error.
    pub figures: CheckedFigures,
    /// The open texts that it reads, its own included.
    pub read: BTreeSet<PathBuf>,
}

/// Checks the program of a path, which must be one of the open texts.
pub fn of(
    path: &Path,
    uri: &Uri,
    texts: &BTreeMap<PathBuf, &str>,
    disk: &dyn Library,
    unit: ColumnUnit,
) -> OpenFindings {
    let Some(text) = texts.get(path) else { return OpenFindings::default() };
    let library = Overlay::around(path, texts, disk);
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let checked = check_open_program(path, text, &library, &mut sources, &mut sink);
    let own = EditedText::new((*text).to_owned());
    let shown = ShownProgram { uri, own: &own, library: &library, sources: &sources, unit };
    let figures = checked.zip(shown.own_file()).map(|(checked, own)| CheckedFigures::of(&checked, own));
    let found = sink.sorted().into_iter().map(|diagnostic| shown.diagnostic(diagnostic)).collect();
    OpenFindings { found, figures: figures.unwrap_or_default(), read: read_of(path, &sources, &library) }
}

fn read_of(path: &Path, sources: &Sources, library: &Overlay) -> BTreeSet<PathBuf> {
    let own = sources.files().filter(|(_, file)| file.origin == Origin::User);
    let open = own.map(|(_, file)| library.path(&file.name)).filter(|path| library.texts.contains_key(path));
    open.chain([path.to_owned()]).collect()
}

/// Checks the text of a program with the open texts and the files around it.
fn check_open_program(
    path: &Path,
    text: &str,
    library: &Overlay,
    sources: &mut Sources,
    sink: &mut Sink,
) -> Option<Checked> {
    let request = ProgramSource { name: &text::file_name(path), text, library, options: &Options::default() };
    check_program(&request, sources, sink)
}

/// Titles of the errors of a program, in order.
pub fn errors(path: &Path, texts: &BTreeMap<PathBuf, &str>, disk: &dyn Library) -> Vec<String> {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    if let Some(text) = texts.get(path) {
        check_open_program(path, text, &Overlay::around(path, texts, disk), &mut sources, &mut sink);
    }
    let errors = sink.sorted().into_iter().filter(|diagnostic| diagnostic.code.severity() == Severity::Error);
    errors.map(|diagnostic| diagnostic.title.clone()).collect()
}

/// Quick fixes for findings, which the editor sends back unchanged.
// `Uri` is the protocol library's type; its hash depends on its text only, so it may be a key.
#[allow(clippy::mutable_key_type)]
pub fn quick_fixes(uri: &Uri, found: Vec<lsp_types::Diagnostic>) -> Vec<CodeAction> {
    let fix = |diagnostic: lsp_types::Diagnostic| {
        let QuickFix { title, edits } = serde_json::from_value(diagnostic.data.clone()?).ok()?;
        let edit = WorkspaceEdit { changes: Some([(uri.clone(), edits)].into()), ..WorkspaceEdit::default() };
        Some(CodeAction {
            title,
            kind: Some(CodeActionKind::QUICKFIX),
            diagnostics: Some(vec![diagnostic]),
            edit: Some(edit),
            is_preferred: Some(true),
            ..CodeAction::default()
        })
    };
    found.into_iter().filter_map(fix).collect()
}

/// A fix with its title; sent along with a finding.
#[derive(Serialize, Deserialize)]
struct QuickFix {
    title: String,
    edits: Vec<TextEdit>,
}

/// An open program in the terms of the editor.
struct ShownProgram<'a> {
    uri: &'a Uri,
    own: &'a EditedText,
    library: &'a Overlay<'a>,
    sources: &'a Sources,
    unit: ColumnUnit,
}

impl ShownProgram<'_> {
    /// The file of the program's own text among the sources.
    fn own_file(&self) -> Option<FileId> {
        self.sources.files().find(|(_, file)| file.origin == Origin::User).map(|(id, _)| id)
    }

    fn diagnostic(&self, diagnostic: &Diagnostic) -> lsp_types::Diagnostic {
        let first = diagnostic.labels.first();
        let own_range = first.and_then(|label| self.range(label));
        let mut message = diagnostic.title.clone();
        if own_range.is_none()
            && let Some(label) = first
        {
            let (file, place) = (self.sources.file(label.span.file), self.sources.position(label.span));
            message = format!("{}:{}: {message}", file.shown, place.line);
        }
        let mut add = |text: &str, before: &str| {
            if !text.is_empty() {
                message.push_str(&format!("\n{before}{text}"));
            }
        };
        add(first.map_or("", |label| &label.text), "");
        add(diagnostic.help.as_deref().unwrap_or(""), "help: ");
        let related = diagnostic.labels.iter().skip(1).filter_map(|label| {
            Some(DiagnosticRelatedInformation { location: self.location(label)?, message: label.text.clone() })
        });
        lsp_types::Diagnostic {
            range: own_range.unwrap_or_default(),
            severity: Some(match diagnostic.code.severity() {
                Severity::Error => DiagnosticSeverity::ERROR,
                Severity::Warning => DiagnosticSeverity::WARNING,
            }),
            code: Some(NumberOrString::String(diagnostic.code.name().to_owned())),
            source: Some("tweeze".to_owned()),
            message,
            related_information: Some(related.collect()),
            data: self.quick_fix_data(diagnostic),
            ..lsp_types::Diagnostic::default()
        }
    }

    /// The edits that fix a finding, if they are known, in the form in which they come back with a request for code
    /// actions.
    fn quick_fix_data(&self, diagnostic: &Diagnostic) -> Option<serde_json::Value> {
        let own = self.own_file()?;
        if diagnostic.fix.is_empty() || diagnostic.fix.iter().any(|edit| edit.span.file != own) {
            return None;
        }
        let edits = diagnostic
            .fix
            .iter()
            .map(|edit| TextEdit { range: self.own.range(edit.span.range(), self.unit), new_text: edit.text.clone() });
        Some(serde_json::json!(QuickFix { title: self.title(diagnostic), edits: edits.collect() }))
    }

    /// Title of a quick fix: the text that it writes, taken from the help where possible.
    fn title(&self, diagnostic: &Diagnostic) -> String {
        let help = diagnostic.help.as_deref().unwrap_or_default();
        let quoted = |start: &str| help.strip_prefix(start)?.split('`').next();
        if let Some(written) = quoted("write `").or_else(|| quoted("did you mean `")) {
            return format!("Write `{written}`");
        }
        match diagnostic.fix.as_slice() {
            [edit] if edit.text.trim().is_empty() => {
                format!("Remove `{}`", &self.own.as_str()[edit.span.range()])
            }
            [edit] => format!("Write `{}`", edit.text.trim()),
            _ => format!("Fix: {help}"),
        }
    }

    /// The place of a label in the program or a file that it uses; `None` in the standard library.
    fn location(&self, label: &Label) -> Option<Location> {
        if let Some(range) = self.range(label) {
            return Some(Location { uri: self.uri.clone(), range });
        }
        let file = self.sources.file(label.span.file);
        let text = EditedText::new(file.text.to_string());
        let range = text.range(label.span.range(), self.unit);
        (file.origin == Origin::User).then_some(Location { uri: text::uri(&self.library.path(&file.name))?, range })
    }

    /// The place of a label in the program's own text; `None` in another file.
    fn range(&self, label: &Label) -> Option<lsp_types::Range> {
        let own = self.own_file()?;
        (label.span.file == own).then(|| self.own.range(label.span.range(), self.unit))
    }
}
