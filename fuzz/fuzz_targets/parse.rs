//! Any text through the checker: it ends, does not panic, and gives a checked program exactly if it reported no error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use tweeze::check::Options;
use tweeze::check::imports::Library;
use tweeze::compile::{self, Program};
use tweeze::diagnostic::{Sink, render};
use tweeze::source::Sources;

struct Nothing;

impl Library for Nothing {
    fn read(&self, _: &str, _: &str) -> Result<(String, String), String> {
        Err("there are no files here".to_owned())
    }
}

fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let options = Options::default();
    let program = Program { name: "fuzz.twz", text, library: &Nothing, options: &options };
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let checked = compile::check(&program, &mut sources, &mut sink);
    assert_eq!(checked.is_some(), sink.errors() == 0);
    let look = render::Look { colour: render::Colour::Plain, characters: render::Characters::Unicode, width: 100 };
    for diagnostic in sink.sorted() {
        render::human(diagnostic, &sources, look);
        render::json_line(diagnostic, &sources);
    }
});
