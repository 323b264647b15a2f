//! The book in `docs/` and the README: every code block does what its page says, and every link has a target.
//!
//! The first word after a fence says what a block is; the words after it say what must hold:
//!
//! - `twz`: a whole program in its canonical form, compiled without an error or a warning. `reports=E0503,W0511`: with
//!   these codes and no others. `file=fetch.twz`: the program is a file for the blocks after it, and the line before
//!   the fence is its name, **`fetch.twz`**. A comment `<!-- twz … -->` before the block has the rest of a program of
//!   which the page shows a part; a line `…` in it stands for that part, which otherwise comes last.
//! - any other word with `file=`: a file for the blocks after it, for instance a Python program.
//! - `console`: lines that begin with `$ ` are commands, the others are what they print. A line `…` stands for any
//!   lines, and `…` within a line for any text. The last command ends with status 0, or with the status of `exit=`.
//!   `needs=python3`: skipped if that program is missing.
//! - `sh`: commands that are run, one per line, whatever they print. With the word `bench` they need an instrument, or
//!   the source of Tweeze itself, and are not run.
//! - any word with `of=PATH`: lines of that file, as it is or as the blocks before it have written it; `…` as above.
//! - `toml` and `lua` with `bench`: settings of editors, which are not run.
//! - `text`: nothing to run.
//!
//! Each page has its own folder with a copy of `examples`, in which its blocks run one after the other. A file that
//! they write as `pictures/NAME.svg` is compared with the picture `docs/pictures/tutorials/NAME.svg`.
//! `TWEEZE_UPDATE=1 cargo test --test explain book` rewrites what commands print and the generated pages: read the
//! changes before committing them.

mod bench;
mod blocks;
mod generated;
mod links;

use std::fs;
use std::path::{Path, PathBuf};

/// The root of the project.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn updates() -> bool {
    std::env::var_os("TWEEZE_UPDATE").is_some()
}

/// The pages of the book and the README, by path from the root.
fn pages() -> Vec<String> {
    let mut pages = vec!["README.md".to_owned()];
    let mut open: Vec<PathBuf> = vec![root().join("docs")];
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(&folder).expect("a folder of the book").flatten() {
            let path = entry.path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|ending| ending == "md") {
                let from_root = path.strip_prefix(root()).expect("below the root");
                pages.push(from_root.to_string_lossy().replace('\\', "/"));
            }
        }
    }
    pages.sort();
    pages
}

fn read(page: &str) -> String {
    fs::read_to_string(root().join(page)).unwrap_or_else(|error| panic!("{page}: {error}"))
}

/// Asserts that no page has a fault; lists all faults at once.
fn assert_nothing(wrong: &[String]) {
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
