//! Any text is read and checked without a panic, and a text without errors comes back checked.

#![no_main]

use libfuzzer_sys::fuzz_target;
use tweeze::check::Options;
use tweeze::check::imports::Library;
use tweeze::compile::{Program, check};
use tweeze::diagnostic::Sink;
use tweeze::source::Sources;

struct Nothing;

impl Library for Nothing {
    fn read(&self, _: &str, _: &str) -> Result<(String, String), String> {
        Err("there are no files here".to_owned())
    }
}

fuzz_target!(|text: &str| {
    let (mut sources, mut sink, options) = (Sources::default(), Sink::default(), Options::default());
    let program = Program { name: "fuzz.twz", text, library: &Nothing, options: &options };
    let checked = check(&program, &mut sources, &mut sink);
    assert_eq!(checked.is_some(), sink.errors() == 0);
});
