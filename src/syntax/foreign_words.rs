//! Words of other languages that newcomers use, and their equivalents in Tweeze.

/// Replacement for a word of another language; `None` for any other word.
pub(super) fn help(word: &str) -> Option<&'static str> {
    Some(match word {
        "if" | "else" | "elif" | "elseif" | "unless" | "switch" => {
            "programs have no conditions: write a task for each case and choose one with `--task`"
        }
        "while" | "loop" | "repeat" | "until" | "foreach" => {
            "write `for i in 0..4 { … }` to repeat the lines in its braces"
        }
        "import" | "include" => "write `use std.dimibot` for a library, or `use \"bench.twz\" as lab` for another file",
        "fn" | "def" | "func" | "function" | "fun" | "void" => {
            "a task takes parameters: `task go(goal: cell) on bot { move to goal }`"
        }
        "const" | "var" | "val" | "define" | "int" | "float" | "double" => {
            "write `let pitch = 70 um` at the top of the file to name a value"
        }
        "end" | "endfor" | "done" => "a block ends with `}`",
        "return" | "break" | "continue" => "steps are carried out in order, to the last one",
        "class" | "struct" => "`device NAME : KIND { … }` declares a device, `scene NAME { … }` its surroundings",
        _ => return None,
    })
}
