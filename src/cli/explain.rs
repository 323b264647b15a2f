//! `tweeze explain`.

use super::arguments::ExplainArguments;
use super::{Exit, terminal};
use crate::check::scope::nearest;
use crate::diagnostic::Code;

/// Shows the page of a code, or the list of all.
pub fn run(arguments: &ExplainArguments) -> Exit {
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
