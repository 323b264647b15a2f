//! Runs the blocks of a page in its own folder.

use super::blocks::{Block, ELISION, blocks, matches, rewritten};
use super::{assert_nothing, pages, read, root, updates};
use crate::case::Case;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use tempfile::TempDir;
use tweeze::diagnostic::Sink;
use tweeze::format::format;
use tweeze::source::Sources;

/// Pages whose programs are compiled by other tests: `tests/portable/examples.rs`, the tests of published devices in every
/// program, and the rest of this file.
const WITHOUT_BLOCKS: [&str; 3] = ["docs/examples.md", "docs/library.md", "docs/diagnostics.md"];

/// The state of a page while its blocks run.
struct Bench {
    folder: TempDir,
    wrong: Vec<String>,
    rewritten: Vec<(Block, Vec<String>)>,
}

/// A command of a block with the output that its page shows.
#[derive(Debug, Default)]
struct Shown {
    /// Its lines as they are on the page.
    source: Vec<String>,
    command: String,
    prints: Vec<String>,
}

impl Bench {
    fn new() -> Bench {
        let folder = tempfile::tempdir().expect("a folder for the page");
        let examples = folder.path().join("examples");
        fs::create_dir(&examples).expect("a folder for the examples");
        for entry in fs::read_dir(root().join("examples")).expect("the examples").flatten() {
            fs::copy(entry.path(), examples.join(entry.file_name())).expect("an example is copied");
        }
        Bench { folder, wrong: Vec::new(), rewritten: Vec::new() }
    }

    fn work(&mut self, block: &Block) {
        if let Some(file) = block.value("file").filter(|file| block.before != format!("**`{file}`**")) {
            self.wrong.push(format!("{}: the line before the block is not **`{file}`**", block.line));
        }
        match (block.language.as_str(), block.value("file"), block.value("of")) {
            (_, _, Some(path)) => self.look_up(block, path),
            ("twz", file, _) => self.compile(block, file),
            (_, Some(file), _) => self.write(file, &block.text()),
            ("console", ..) => self.show(block),
            ("sh" | "toml" | "lua", ..) if block.has("bench") => {}
            ("sh", ..) => self.run_all(block),
            ("text", ..) => {}
            (other, ..) => self.wrong.push(format!("{}: nothing holds a block `{other}`", block.line)),
        }
    }

    fn write(&self, file: &str, text: &str) {
        fs::write(self.folder.path().join(file), text).expect("a file of the page is written");
    }

    fn compile(&mut self, block: &Block, file: Option<&str>) {
        let mut sources = Sources::default();
        let id = sources.add("page", block.shown());
        if format(id, &block.shown(), &mut Sink::default()) != block.shown() {
            self.wrong.push(format!("{}: `tweeze fmt` writes this program in another form", block.line));
        }
        let name = file.unwrap_or("main.twz").to_owned();
        let files = self.texts();
        let (_, sink) = Case { name, text: block.text(), files, ..Case::default() }.compile();
        let mut codes: Vec<&str> = sink.sorted().iter().map(|diagnostic| diagnostic.code.name()).collect();
        codes.sort_unstable();
        codes.dedup();
        let expected: Vec<&str> = block.value("reports").map(|codes| codes.split(',').collect()).unwrap_or_default();
        if codes != expected {
            let titles: Vec<&str> = sink.sorted().iter().map(|diagnostic| diagnostic.title.as_str()).collect();
            self.wrong.push(format!("{}: {codes:?} and not {expected:?}: {titles:?}", block.line));
        }
        if let Some(file) = file {
            self.write(file, &block.text());
        }
    }

    /// The text files of the page's folder, by name.
    fn texts(&self) -> BTreeMap<String, String> {
        let entries = fs::read_dir(self.folder.path()).expect("the folder of the page").flatten();
        let text = |path: &Path| fs::read_to_string(path).ok();
        entries
            .filter_map(|entry| Some((entry.file_name().to_string_lossy().into_owned(), text(&entry.path())?)))
            .collect()
    }

    /// Runs a command; returns its status and the lines of both outputs.
    fn run(&self, command: &str) -> (i32, Vec<String>) {
        let binary = Path::new(env!("CARGO_BIN_EXE_tweeze"));
        let path = std::env::var_os("PATH").unwrap_or_default();
        let own = binary.parent().map(Path::to_path_buf).into_iter();
        let path = std::env::join_paths(own.chain(std::env::split_paths(&path))).expect("a path");
        let output = Command::new("sh")
            .args(["-c", &format!("exec 2>&1\n{command}")])
            .current_dir(self.folder.path())
            .env("PATH", path)
            .env("PYTHONPATH", root().join("tests/oracles/standins"))
            .env("STANDIN_LOG", self.folder.path().join("standin.log"))
            .env_remove("COLUMNS")
            .stdin(Stdio::null())
            .output()
            .expect("a shell");
        let text = String::from_utf8_lossy(&output.stdout);
        (output.status.code().unwrap_or(-1), text.trim_end().lines().map(|line| line.trim_end().to_owned()).collect())
    }

    /// Whether the programs that a block needs are available; in CI all of them must be.
    fn is_possible(&self, block: &Block) -> bool {
        let needed = block.value("needs").into_iter().flat_map(|needs| needs.split(','));
        let is_there = |program: &str| self.run(&format!("command -v {program}")).0 == 0;
        std::env::var_os("TWEEZE_REQUIRE_ORACLES").is_some() || needed.into_iter().all(is_there)
    }

    fn show(&mut self, block: &Block) {
        if !self.is_possible(block) {
            println!("SKIPPED: line {} needs {}", block.line, block.value("needs").unwrap_or_default());
            return;
        }
        let shown = commands(block);
        let status: i32 = block.value("exit").map_or(0, |status| status.parse().expect("a status"));
        let mut new: Vec<String> = Vec::new();
        let mut is_changed = false;
        for (at, one) in shown.iter().enumerate() {
            let (ended, prints) = self.run(&one.command);
            let due = if at + 1 == shown.len() { status } else { 0 };
            if ended != due {
                self.wrong.push(format!("{}: `{}` ends with {ended}: {prints:#?}", block.line, one.command));
            }
            new.extend(one.source.iter().cloned());
            let is_elided = one.prints.iter().any(|line| line.contains(ELISION));
            let is_same = matches(&one.prints, &prints);
            if !is_same && updates() && !is_elided {
                is_changed = true;
                new.extend(prints);
                continue;
            }
            if !is_same {
                self.wrong.push(format!("{}: `{}` prints\n{}", block.line, one.command, prints.join("\n")));
            }
            new.extend(one.prints.iter().cloned());
        }
        if is_changed {
            self.rewritten.push((block.clone(), new));
        }
    }

    fn run_all(&mut self, block: &Block) {
        for command in &block.lines {
            let (ended, prints) = self.run(command);
            if ended != 0 {
                self.wrong.push(format!("{}: `{command}` ends with {ended}: {prints:#?}", block.line));
            }
        }
    }

    fn look_up(&mut self, block: &Block, path: &str) {
        let text = fs::read_to_string(self.folder.path().join(path)).unwrap_or_default();
        let any = || std::iter::once(ELISION.to_owned());
        let expected: Vec<String> = any().chain(block.lines.iter().cloned()).chain(any()).collect();
        let lines: Vec<String> = text.lines().map(str::to_owned).collect();
        if !matches(&expected, &lines) {
            self.wrong.push(format!("{}: these lines are not in {path}", block.line));
        }
    }
}

/// The commands of a block: each begins with `$ ` and is continued after a `\`.
fn commands(block: &Block) -> Vec<Shown> {
    let mut commands: Vec<Shown> = Vec::new();
    for line in &block.lines {
        let goes_on = commands.last_mut().filter(|last| last.prints.is_empty() && last.command.ends_with('\\'));
        match (line.strip_prefix("$ "), goes_on) {
            (_, Some(last)) => {
                last.command.pop();
                last.command.push_str(line.trim_start());
                last.source.push(line.clone());
            }
            (Some(command), None) => {
                let (source, command) = (vec![line.clone()], command.to_owned());
                commands.push(Shown { source, command, ..Shown::default() });
            }
            (None, None) => match commands.last_mut() {
                Some(last) => last.prints.push(line.clone()),
                None => commands.push(Shown { command: format!("false # {line}"), ..Shown::default() }),
            },
        }
    }
    commands
}

/// Folder to which commands of a page write pictures, and folder of the pictures in the book.
const PICTURES: [&str; 2] = ["pictures", "docs/pictures/tutorials"];

impl Bench {
    /// Compares the pictures that the page's commands have written with those of the book.
    fn compare_pictures(&mut self) {
        let [written, shown] = [self.folder.path().join(PICTURES[0]), root().join(PICTURES[1])];
        for entry in fs::read_dir(written).into_iter().flatten().flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            if !name.ends_with(".svg") {
                continue;
            }
            let picture = fs::read_to_string(entry.path()).expect("a picture is text");
            if updates() {
                fs::write(shown.join(&name), &picture).expect("a picture is written");
            }
            if fs::read_to_string(shown.join(&name)).ok().as_ref() != Some(&picture) {
                self.wrong.push(format!("0: {}/{name} is not what the page's commands write", PICTURES[1]));
            }
        }
    }
}

/// Runs one page; returns its faults.
fn work_through(page: &str) -> Vec<String> {
    let text = read(page);
    let mut bench = Bench::new();
    for block in blocks(&text) {
        bench.work(&block);
    }
    bench.compare_pictures();
    if !bench.rewritten.is_empty() {
        fs::write(root().join(page), rewritten(&text, &bench.rewritten)).expect("the page is rewritten");
    }
    bench.wrong.iter().map(|wrong| format!("{page}:{wrong}")).collect()
}

/// Runs the pages of one part of the book; the parts are separate tests, so that they run in parallel.
fn work_through_all(is_part: impl Fn(&str) -> bool) {
    let pages: Vec<String> =
        pages().into_iter().filter(|page| is_part(page) && !WITHOUT_BLOCKS.contains(&page.as_str())).collect();
    assert!(!pages.is_empty());
    let wrong: Vec<String> = pages.iter().flat_map(|page| work_through(page)).collect();
    assert_nothing(&wrong);
}

#[test]
fn the_tutorials_do_what_they_say() {
    work_through_all(|page| page.starts_with("docs/tutorials/"));
}

#[test]
fn the_hardware_pages_do_what_they_say() {
    work_through_all(|page| page.starts_with("docs/hardware/"));
}

#[test]
fn the_other_pages_do_what_they_say() {
    work_through_all(|page| !page.starts_with("docs/tutorials/") && !page.starts_with("docs/hardware/"));
}
