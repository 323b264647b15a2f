//! `tweeze explain`.

use super::arguments::ExplainArguments;
use super::{Exit, terminal};
use crate::check::scope::nearest;
use crate::diagnostic::Code;

/// Prints the page of a code, the pages of all codes, or the list of all codes.
pub fn run(arguments: &ExplainArguments) -> Exit {
    if arguments.all {
        return terminal::answer(&pages());
    }
    let Some(name) = &arguments.code else { return terminal::answer(&list()) };
    match Code::find(name) {
        Some(code) => terminal::answer(code.page()),
        None => {
            let near = nearest(name, Code::ALL.iter().map(|code| code.name()));
            let near = near.map_or(String::new(), |near| format!("; did you mean {near}?"));
            eprintln!("no diagnostic has the code `{name}`{near}\n`tweeze explain` lists them all");
            Exit::Usage
        }
    }
}

fn list() -> String {
    Code::ALL.iter().map(|code| format!("{}  {}\n", code.name(), code.summary())).collect()
}

/// All pages as one Markdown text, in the order of their codes.
fn pages() -> String {
    let pages: Vec<&str> = Code::ALL.iter().map(|code| code.page().trim_end()).collect();
    pages.join("\n\n") + "\n"
}
