//! `tweeze new`: a small program that builds at once, from a template.

use super::arguments::{NewArguments, Template};
use super::{Exit, disk, errors, terminal};
use crate::device::Kind;
use clap::ValueEnum;
use std::path::Path;

/// Placeholder for the project's name in a template.
const PROJECT: &str = "PROJECT";

/// Content of the ignore file: the folder that the first build writes to.
const IGNORED: &str = "out/\n";

impl Template {
    fn text(self) -> &'static str {
        match self {
            Template::PickAndPlace => include_str!("../../assets/templates/pick-and-place.twz"),
            Template::Scan => include_str!("../../assets/templates/scan.twz"),
            Template::Sort => include_str!("../../assets/templates/sort.twz"),
            Template::Assay => include_str!("../../assets/templates/assay.twz"),
            Template::Assemble => include_str!("../../assets/templates/assemble.twz"),
            Template::Turn => include_str!("../../assets/templates/turn.twz"),
        }
    }

    /// The first template that uses the published devices of a kind.
    fn of(kind: Kind) -> Option<Template> {
        let library = format!("use std.{}", kind.name());
        Template::value_variants().iter().copied().find(|template| template.text().contains(&library))
    }
}

/// Creates a folder with a program in it.
pub fn run(arguments: &NewArguments) -> Exit {
    let template = arguments.template.or(arguments.kind.and_then(Template::of)).unwrap_or(Template::PickAndPlace);
    let folder = &arguments.path;
    let named = folder.file_name().map(|name| name.to_string_lossy().into_owned());
    // The name is inserted into a comment of the program.
    let Some(name) = named.filter(|name| !name.contains(char::is_control)) else {
        terminal::report_one(errors::no_name_for_a_project(folder), arguments.report.format);
        return Exit::Files;
    };
    if let Some(stem) = name.strip_suffix(".twz") {
        terminal::report_one(errors::program_for_a_folder(&name, stem), arguments.report.format);
        return Exit::Files;
    }
    let program = format!("{name}.twz");
    let files = [(program.as_str(), template.text().replace(PROJECT, &name)), (".gitignore", IGNORED.to_owned())];
    if let Err(diagnostic) = disk::make_folder(folder, &files) {
        terminal::report_one(*diagnostic, arguments.report.format);
        return Exit::Files;
    }
    let path = folder.join(&program);
    terminal::answer(&report(&path, folder))
}

/// Reports what was created, and the commands to run next.
fn report(program: &Path, folder: &Path) -> String {
    let made = terminal::line("Created", &terminal::name(&program.to_string_lossy()), 0, "");
    // Quoted for a shell; a name that begins with `-` must not be read as an option.
    let [program, out] = [program, &folder.join("out")].map(|path| {
        let path = terminal::name(&path.to_string_lossy());
        let path = if path.starts_with('-') { format!("./{path}") } else { path };
        errors::quoted(&path)
    });
    format!("{made}\nNext:\n  tweeze build {program} --emit mcap,html,svg -o {out}\n  tweeze view {program} -o {out}\n")
}
