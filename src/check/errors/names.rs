//! Names: E02xx.

use super::{listed, meant};
use crate::check::scope::{Declaration, path_text};
use crate::diagnostic::{Code, Diagnostic};
use crate::source::Span;
use crate::syntax::tree::{Ident, Path};

pub fn unknown_name(span: Span, name: &str, sort: &str, near: Option<&str>) -> Diagnostic {
    Diagnostic::new(Code::E0201, format!("no {sort} is named `{name}`"))
        .label(span, "not declared in this file")
        .help_if(meant(near))
}

pub fn unknown_kind(span: Span, name: &str, near: Option<&str>, kinds: &[&str]) -> Diagnostic {
    let known = format!("the kinds are {}; `tweeze devices` lists what they offer", listed(kinds.iter().copied()));
    Diagnostic::new(Code::E0201, format!("no device or device kind is named `{name}`"))
        .label(span, "not declared in this file")
        .help(meant(near).unwrap_or(known))
}

pub fn unknown_file(span: Span, alias: &str, near: Option<&str>) -> Diagnostic {
    let mend =
        format!("a name before a dot is a used file: write `use std.{alias}` or `use \"{alias}.twz\"` at the top");
    Diagnostic::new(Code::E0201, format!("no file is used here as `{alias}`"))
        .label(span, "not the name of a `use`")
        .help(meant(near).unwrap_or(mend))
}

pub fn shape_without_fields(span: Span, form: crate::device::shape::Form) -> Diagnostic {
    let fields: Vec<String> = form.fields().iter().map(|field| format!("{}: …", field.name)).collect();
    Diagnostic::new(Code::E0401, format!("a {} without its fields", form.name()))
        .label(span, "how large?")
        .help(format!("write `{} {{ {} }}`", form.name(), fields.join(", ")))
}

pub fn declared_twice(name: &str, span: Span, earlier: Span) -> Diagnostic {
    Diagnostic::new(Code::E0202, format!("`{name}` is declared twice"))
        .label(span, "declared again here")
        .label(earlier, "first declared here")
        .help("a name is declared once in a file; no inner block declares it again")
}

pub fn kept_name(name: &Ident, keeper: &str) -> Diagnostic {
    Diagnostic::new(Code::E0203, format!("`{}` is {keeper} and keeps its name", name.text))
        .label(name.span, "cannot be declared")
        .help(format!("choose another name, as `my_{}`", name.text))
}

pub fn missing_file(span: Span, what: &str, why: &str, chain: &[String]) -> Diagnostic {
    Diagnostic::new(Code::E0204, format!("{what} cannot be used: {why}"))
        .label(span, "used here")
        .help_if((chain.len() > 1).then(|| format!("imported by {}", chain.join(" → "))))
}

pub fn unknown_library(span: Span, name: &str, near: Option<&str>, known: &[&str]) -> Diagnostic {
    let list = format!("the standard library has {}", listed(known.iter().copied()));
    Diagnostic::new(Code::E0204, format!("the standard library has no `{name}`"))
        .label(span, "used here")
        .help(meant(near).unwrap_or(list))
}

pub fn import_cycle(span: Span, chain: &[String]) -> Diagnostic {
    Diagnostic::new(Code::E0205, "files use each other in a circle")
        .label(span, "this closes the circle")
        .help(format!("the circle is {}; move what both need into a third file", chain.join(" → ")))
}

pub fn too_many_files(span: Span, limit: usize) -> Diagnostic {
    Diagnostic::new(Code::E0204, format!("more than {limit} files are used")).label(span, "one too many")
}

pub fn wrong_sort(path: &Path, found: Declaration, wanted: &str) -> Diagnostic {
    let name = path_text(path);
    Diagnostic::new(Code::E0206, format!("`{name}` is {}, {wanted} belongs here", found.sort.describe()))
        .label(path.span, format!("{} belongs here", wanted))
        .label(found.span, "declared here")
}

pub fn indexed_name(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0206, "an index where a declared name belongs")
        .label(span, "devices, scenes, tasks and programs have no indices")
        .help("declare it under a name of its own")
}

pub fn defined_by_itself(span: Span, declared: Span) -> Diagnostic {
    Diagnostic::new(Code::E0207, "a name that is defined by itself")
        .label(span, "asked for while it is being made out")
        .label(declared, "declared here")
}

pub fn too_deep(span: Span, what: &str, limit: usize) -> Diagnostic {
    Diagnostic::new(Code::E0207, format!("more than {limit} {what} hang on one another"))
        .label(span, "one too many")
        .help("declare them in the order in which they are needed, or shorten the chain")
}

pub fn lets_too_deep(span: Span) -> Diagnostic {
    too_deep(span, "values", crate::check::evaluate::MAX_LET_DEPTH)
}

pub fn unknown_verb(span: Span, verb: &str, kind: &str, near: Option<&str>, known: &[&str]) -> Diagnostic {
    let list = format!("a {kind} can {}; besides there are `wait` and the settings", listed(known.iter().copied()));
    Diagnostic::new(Code::E0208, format!("a {kind} cannot `{verb}`"))
        .label(span, "not a step")
        .help(meant(near).unwrap_or(list))
}

pub fn unknown_field(name: &Ident, owner: &str, near: Option<&str>, known: &[&str]) -> Diagnostic {
    let list = match known {
        [] => "it has no fields".to_owned(),
        known => format!("it has {}", listed(known.iter().copied())),
    };
    Diagnostic::new(Code::E0209, format!("{owner} has no field `{}`", name.text))
        .label(name.span, "unknown field")
        .help(meant(near).unwrap_or(list))
}

pub fn unknown_noun(span: Span, noun: &str, near: Option<&str>, known: &[&str]) -> Diagnostic {
    let list = format!("a scene may hold {}", listed(known.iter().copied()));
    Diagnostic::new(Code::E0210, format!("no object of a scene is called `{noun}`"))
        .label(span, "not a noun of this device")
        .help(meant(near).unwrap_or(list))
}

pub fn unused(code: Code, span: Span, what: &str, name: &str) -> Diagnostic {
    Diagnostic::new(code, format!("{what} `{name}` is never used")).label(span, "declared here")
}

pub fn never_run(span: Span, name: &str) -> Diagnostic {
    Diagnostic::new(Code::W0502, format!("task `{name}` is never run"))
        .label(span, "no program runs it")
        .help(format!("add `run {name}` to a program, or build it alone with `--task {name}`"))
}

pub fn never_run_with_parameters(span: Span, name: &str) -> Diagnostic {
    Diagnostic::new(Code::W0502, format!("task `{name}` has parameters and is never run"))
        .label(span, "nothing gives it arguments")
        .help(format!("add a program: `program all {{ run {name}(…) }}`"))
}
