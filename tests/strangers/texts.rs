//! Programs: whatever a text asks for, it is answered with a diagnostic, soon and in little memory.

use super::bench::{Bench, ERRORS, found, says};

#[test]
fn brackets_too_deep_that_end_lines_below_are_reported() {
    for name in ["panic-too-deep.twz", "panic-too-deep-string.twz"] {
        let bench = Bench::new();
        bench.write("a.twz", found(name));
        says(&bench.run(&["check", "a.twz"]).code(ERRORS).err, &["E0120", "nested more than 64 deep"]);
    }
}
