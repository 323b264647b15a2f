//! Texts that attacks start from.

use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The files with an extension in a folder and its subfolders, by path.
fn files(folder: &str, ending: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![root().join(folder)];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
            match entry.path() {
                path if path.is_dir() => open.push(path),
                path if path.extension().is_some_and(|other| other == ending) => found.push(path),
                _ => {}
            }
        }
    }
    found.sort();
    found
}

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_default()
}

/// Every program in the project: examples, the standard library, the tests' programs, and those on the pages of
/// `tweeze explain`.
pub fn all() -> Vec<String> {
    let folders = ["examples", "stdlib", "tests"];
    let mut texts: Vec<String> =
        folders.iter().flat_map(|folder| files(folder, "twz")).map(|path| text(&path)).collect();
    for page in files("src/diagnostic/explain", "md") {
        let page = text(&page);
        let blocks = page.split("\n```twz ").skip(1).filter_map(|block| block.split_once('\n')?.1.split("```").next());
        texts.extend(blocks.map(str::to_owned));
    }
    texts.retain(|text| text.len() < 20_000);
    texts
}

/// Small programs of every kind, each with all published devices of its kind written out, so that a number of every
/// field is in the text.
pub fn complete() -> Vec<String> {
    files("tests/fuzz/programs", "twz").iter().map(|path| with_library(&text(path))).collect()
}

/// The board maps in the corpus whose file names end with `name`; they follow programs of the corpus.
pub fn maps(name: &str) -> Vec<String> {
    let programs: Vec<String> = files("tests/corpus", "twz").iter().map(|path| text(path)).collect();
    let parts = programs.iter().flat_map(|program| program.split("\n// file ").skip(1));
    let named = parts.filter_map(|part| part.split_once('\n'));
    let ending = name.rsplit('.').next().unwrap_or_default();
    let of_ending = named.filter(|(file, _)| file.trim().ends_with(ending));
    of_ending.map(|(_, map)| map.to_owned()).collect()
}

/// A program appended to the library file that its first line names: `// with dimibot`.
pub fn with_library(text: &str) -> String {
    let first = text.lines().next().unwrap_or_default();
    let library = first.strip_prefix("// with ").unwrap_or_default();
    let devices = self::text(&root().join("stdlib").join(format!("{library}.twz")));
    let code = devices.lines().filter(|line| !line.trim_start().starts_with("//"));
    format!("{}\n{text}", code.collect::<Vec<_>>().join("\n"))
}
