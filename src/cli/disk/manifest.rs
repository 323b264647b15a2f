//! Manifest: a hidden file that records which program each file of a folder was built from. Without it, two programs
//! with tasks of the same name would silently replace one another's files.

use super::{Destination, errors};
use crate::diagnostic::Diagnosed;
use crate::emit::OutputFile;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

/// The name of the hidden file.
pub const NAME: &str = ".tweeze.json";

/// Maps the name of each file to the program it was built from.
#[derive(Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Manifest {
    files: BTreeMap<String, ProgramId>,
}

/// A program, identified by its location. The location is hashed, so that a folder that is passed on reveals nothing
/// about the machine.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct ProgramId {
    /// File name of the program, for messages.
    program: String,
    /// SHA-256 of the relative path from the folder to the program, in hexadecimal; of the path to the log if the
    /// program is known from a log.
    place: String,
    /// Whether the program is known from a log, which does not know the program's location.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    is_logged: bool,
}

impl Manifest {
    /// The manifest of a folder; empty if there is none.
    pub fn read(folder: &Path) -> Diagnosed<Manifest> {
        let path = folder.join(NAME);
        let unreadable = |error: io::Error| Box::new(errors::bad_manifest(&path, &error.to_string()));
        match fs::read(&path) {
            Ok(bytes) => serde_json::from_slice(&bytes).map_err(|error| unreadable(error.into())),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Manifest::default()),
            Err(error) => Err(unreadable(error)),
        }
    }

    /// Records files as built from a program; returns whether that changes anything.
    ///
    /// # Errors
    /// A file there was built from another program, and may not be replaced.
    pub fn enter(&mut self, to: &Destination, files: &[OutputFile]) -> Diagnosed<bool> {
        let before = self.files.clone();
        let origin = ProgramId::of(to);
        for file in files {
            let is_there = to.folder.join(&file.name).symlink_metadata().is_ok();
            let other = self.files.get(&file.name).filter(|other| is_there && other.differs_from(&origin));
            if let Some(other) = other.filter(|_| !to.force) {
                return Err(Box::new(errors::of_another_program(&to.folder.join(&file.name), &other.program)));
            }
            self.files.insert(file.name.clone(), origin.clone());
        }
        self.files.retain(|name, _| {
            files.iter().any(|file| file.name == *name) || to.folder.join(name).symlink_metadata().is_ok()
        });
        Ok(self.files != before)
    }

    /// Whether a file was built from a program.
    pub fn is_own(&self, to: &Destination, name: &str) -> bool {
        self.files.get(name).is_some_and(|origin| *origin == ProgramId::of(to))
    }

    /// Serialised form.
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = serde_json::to_vec_pretty(self).expect("names are JSON");
        bytes.push(b'\n');
        bytes
    }
}

impl ProgramId {
    fn of(to: &Destination) -> ProgramId {
        let Destination { folder, program, logged, force: _, inputs: _ } = to;
        let named = logged.map_or(*program, Path::new);
        let name = named.file_name().unwrap_or_default().to_string_lossy().into_owned();
        // Standard input has no location, and some systems cannot resolve paths; the paths as typed are used then.
        let way = match (folder.canonicalize(), place_of(program)) {
            (Ok(folder), Ok(program)) => way_to(&folder, &program),
            (_, Err(_)) => program.to_path_buf(),
            (Err(_), Ok(program)) => way_to(folder, &program),
        };
        let digest = Sha256::digest(way.to_string_lossy().replace('\\', "/").as_bytes());
        let place = digest.iter().map(|byte| format!("{byte:02x}")).collect();
        ProgramId { program: name, place, is_logged: logged.is_some() }
    }

    /// Whether it is another program. The page of a log and the page of the program with the same name may replace each
    /// other.
    fn differs_from(&self, other: &ProgramId) -> bool {
        let is_same = (self.is_logged || other.is_logged) && self.program == other.program;
        self.place != other.place && !is_same
    }
}

/// Location of a program, even if it no longer exists.
fn place_of(program: &Path) -> io::Result<PathBuf> {
    let gone = |error: io::Error| {
        let name = program.file_name().filter(|name| !name.to_string_lossy().starts_with('<')).ok_or(error)?;
        let folder = program.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        folder.canonicalize().map(|folder| folder.join(name))
    };
    program.canonicalize().or_else(gone)
}

/// Relative path from a folder to a file, so that both can be moved together.
fn way_to(folder: &Path, file: &Path) -> PathBuf {
    let (from, to): (Vec<Component>, Vec<Component>) = (folder.components().collect(), file.components().collect());
    let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    let up = from[shared..].iter().map(|_| Component::ParentDir);
    up.chain(to[shared..].iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_way_does_not_depend_on_where_both_lie() {
        assert_eq!(way_to(Path::new("/a/out"), Path::new("/a/b/p.twz")), Path::new("../b/p.twz"));
        assert_eq!(way_to(Path::new("/x/a/out"), Path::new("/x/a/b/p.twz")), Path::new("../b/p.twz"));
        assert_eq!(way_to(Path::new("/a"), Path::new("/a/p.twz")), Path::new("p.twz"));
    }
}
