//! A process that dies before any of its operations leaves the complete old set or the complete new one to the next
//! build.

use super::*;
use std::cell::Cell;
use std::collections::BTreeMap;

/// A disk on which the process is killed after a number of operations.
struct Mortal {
    left: Cell<usize>,
}

impl Mortal {
    fn new(left: usize) -> Mortal {
        Mortal { left: Cell::new(left) }
    }

    /// Fails for ever once the operations are used up: a dead process changes nothing any more.
    fn live(&self) -> io::Result<()> {
        let left = self.left.get();
        self.left.set(left.saturating_sub(1));
        if left == 0 { Err(io::Error::other("killed")) } else { Ok(()) }
    }
}

impl DiskOps for Mortal {
    fn write(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        let is_last = self.left.get() == 1;
        self.live()?;
        // The last operation is only half done.
        RealDisk.write(path, if is_last { &bytes[..bytes.len() / 2] } else { bytes })
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        self.live().and_then(|()| RealDisk.rename(from, to))
    }

    fn link(&self, from: &Path, to: &Path) -> io::Result<()> {
        self.live().and_then(|()| RealDisk.link(from, to))
    }

    fn remove(&self, path: &Path) -> io::Result<()> {
        self.live().and_then(|()| RealDisk.remove(path))
    }

    fn sync(&self, folder: &Path) -> io::Result<()> {
        self.live().and_then(|()| RealDisk.sync(folder))
    }
}

type Set = BTreeMap<String, Vec<u8>>;

fn set(folder: &Path) -> Set {
    let entries = fs::read_dir(folder).expect("a folder").flatten();
    entries
        .map(|entry| {
            (entry.file_name().to_string_lossy().into_owned(), fs::read(entry.path()).expect("it can be read"))
        })
        .collect()
}

const OLD: [(&str, &[u8]); 2] = [("a", b"old a"), ("b", b"old b")];
const NEW: [(&str, &[u8]); 3] = [("a", b"new a"), ("b", b"new b"), ("c", b"new c")];

fn of(files: &[(&str, &[u8])]) -> Set {
    files.iter().map(|(name, bytes)| ((*name).to_owned(), bytes.to_vec())).collect()
}

fn write(folder: &Path, ops: &dyn DiskOps, files: &[(&str, &[u8])]) -> Result<(), DiskFault> {
    Folder::open(folder, ops).and_then(|folder| folder.replace(files))
}

#[test]
fn a_kill_before_any_act_leaves_a_whole_set_to_the_next_build() {
    let mut seen = [0, 0];
    for life in 0.. {
        let folder = tempfile::tempdir().expect("a folder");
        write(folder.path(), &RealDisk, &OLD).expect("the old set");
        let mortal = Mortal::new(life);
        let finished = write(folder.path(), &mortal, &NEW).is_ok();
        let left = set(folder.path());
        for (name, _) in OLD {
            assert!(left.contains_key(name), "`{name}` is missing after {life} acts");
        }
        drop(Folder::open(folder.path(), &RealDisk).expect("the next build begins"));
        let whole = set(folder.path());
        assert!(whole == of(&OLD) || whole == of(&NEW), "after {life} acts: {whole:?}");
        seen[usize::from(whole == of(&NEW))] += 1;
        if finished {
            break;
        }
    }
    assert!(seen[0] > 3 && seen[1] > 3, "{seen:?}");
}

/// A disk on which one operation fails and all others succeed.
struct Faulty {
    at: usize,
    acts: Cell<usize>,
}

impl Faulty {
    fn act(&self) -> io::Result<()> {
        let act = self.acts.get();
        self.acts.set(act + 1);
        if act == self.at { Err(io::Error::other("input/output error")) } else { Ok(()) }
    }
}

impl DiskOps for Faulty {
    fn write(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        self.act().and_then(|()| RealDisk.write(path, bytes))
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        self.act().and_then(|()| RealDisk.rename(from, to))
    }
}

#[test]
fn an_act_that_fails_leaves_the_old_set_and_nothing_else() {
    for at in 0..20 {
        let folder = tempfile::tempdir().expect("a folder");
        write(folder.path(), &RealDisk, &OLD).expect("the old set");
        let disk = Faulty { at, acts: Cell::new(0) };
        let expected = if write(folder.path(), &disk, &NEW).is_ok() { of(&NEW) } else { of(&OLD) };
        assert_eq!(set(folder.path()), expected, "act {at}");
        assert_eq!(expected == of(&NEW), at >= 8, "act {at}: three files, a draft, its rename, three renames");
    }
}

#[test]
fn a_journal_from_a_stranger_changes_nothing() {
    for journal in [
        r#"{"moves":[{"from":".tweeze-new-0","to":"../x","number":1}],"remove":[]}"#,
        r#"{"moves":[{"from":"a","to":"b","number":1}],"remove":[]}"#,
        r#"{"moves":[],"remove":[{"name":"../a","number":1}]}"#,
        r#"{"moves":[],"remove":[{"name":"/etc/passwd","number":1}]}"#,
        r#"{"moves":[{"from":".tweeze-new-0","to":"a","number":1}],"remove":[]}"#,
        r#"{"moves":[{"from":".tweeze-new-0","to":"a","number":null}],"remove":[{"name":"b","number":null}]}"#,
        "nonsense",
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        write(folder.path(), &RealDisk, &OLD).expect("the old set");
        fs::write(folder.path().join(".tweeze-new-0"), "not of this folder").expect("written");
        fs::write(folder.path().join(JOURNAL), journal).expect("written");
        let before = set(folder.path());
        if KNOWS_FILES || !journal.contains("\"a\",\"number") {
            let refused = Folder::open(folder.path(), &RealDisk).map(drop).expect_err("it is refused");
            assert!(refused.error.to_string().contains("does not belong to a build into this folder"), "{journal}");
            assert_eq!(set(folder.path()), before, "{journal}");
        }
    }
}

/// Only the file that a build wrote is removed, not another one with its name.
#[cfg(unix)]
#[test]
fn a_removal_is_of_one_file() {
    let folder = tempfile::tempdir().expect("a folder");
    write(folder.path(), &RealDisk, &OLD).expect("the old set");
    let own = number(&folder.path().join("b")).expect("it has a number");
    for (number, left) in [(own + 1, 2), (own, 1)] {
        let journal = format!(r#"{{"moves":[],"remove":[{{"name":"b","number":{number}}}]}}"#);
        fs::write(folder.path().join(JOURNAL), journal).expect("written");
        drop(Folder::open(folder.path(), &RealDisk).expect("it is carried out"));
        assert_eq!(set(folder.path()).len(), left);
    }
}

/// A disk on which the process is asked to end after a number of checks.
struct Asked {
    after: Cell<usize>,
}

impl DiskOps for Asked {
    fn check_interrupt(&self) -> io::Result<()> {
        let left = self.after.get();
        self.after.set(left.saturating_sub(1));
        if left == 0 { Err(io::ErrorKind::Interrupted.into()) } else { Ok(()) }
    }
}

#[test]
fn a_build_that_is_asked_to_end_leaves_the_old_set_and_nothing_else() {
    for after in 0..4 {
        let folder = tempfile::tempdir().expect("a folder");
        write(folder.path(), &RealDisk, &OLD).expect("the old set");
        let fault = write(folder.path(), &Asked { after: Cell::new(after) }, &NEW).expect_err("it is interrupted");
        assert_eq!(fault.error.kind(), io::ErrorKind::Interrupted);
        assert_eq!(set(folder.path()), of(&OLD), "asked after {after} files");
    }
}

/// A build that waits for another one can be interrupted too.
#[test]
fn waiting_for_a_folder_can_be_interrupted() {
    let folder = tempfile::tempdir().expect("a folder");
    let held = Folder::open(folder.path(), &RealDisk).expect("the folder is free");
    let fault = Folder::open(folder.path(), &Asked { after: Cell::new(3) }).map(drop).expect_err("it is held");
    assert_eq!(fault.error.kind(), io::ErrorKind::Interrupted);
    drop(held);
    drop(Folder::open(folder.path(), &Asked { after: Cell::new(0) }).expect("the folder is free again"));
}

#[test]
fn names_that_some_disks_take_for_one_are_found() {
    assert_eq!(first_name_collision(["go.mcap", "Go.mcap"]), Some("Go.mcap"));
    assert_eq!(first_name_collision(["go.mcap", "go.csv"]), None);
}
