//! Runs the built program in folders of the tests.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The root of the project.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A command for the built program in a folder.
pub fn tweeze(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tweeze"));
    command.current_dir(folder).env_remove("LD_PRELOAD");
    command
}

/// Runs a command that must succeed.
#[track_caller]
pub fn done(command: &mut Command) -> Output {
    let output = command.output().expect("the program starts");
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

/// Every file of a folder by its name.
pub fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).expect("the folder is there").flatten();
    let read = |path: PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        (name, std::fs::read(&path).expect("it can be read"))
    };
    // Names that begin with a dot are the folder's own record of which program its files were built from.
    let is_output = |entry: &std::fs::DirEntry| !entry.file_name().to_string_lossy().starts_with('.');
    entries.filter(is_output).map(|entry| read(entry.path())).collect()
}
