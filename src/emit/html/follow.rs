//! Pages that follow their program: while it is built again and again, each moves on to the page of the latest build.

use crate::emit::Provenance;
use crate::schedule::sha256;
use serde::Serialize;

/// The beginning of every page.
const HEAD: &str = "<html lang=\"en\"";

/// A script beside the pages of a build that says which build is the latest. Pages cannot read other files from the disk, but they can
/// load scripts.
pub struct Follower<'a> {
    /// Its name.
    script: &'a str,
    /// Fingerprint of the program's files.
    stamp: String,
}

/// What the script tells.
#[derive(Serialize)]
struct LatestBuild<'a> {
    stamp: &'a str,
    /// The pages, by name: those of the schedules, or the one of the errors.
    pages: &'a [&'a str],
}

impl<'a> Follower<'a> {
    /// The script of a build, by its name.
    pub fn new(script: &'a str, provenance: &Provenance) -> Self {
        let files = provenance.files.iter().flat_map(|(name, text)| [name.as_str(), "\n", text, "\n"]);
        Self { script, stamp: sha256(&files.collect::<String>()) }
    }

    /// Lets a page follow.
    pub fn lead(&self, page: &mut Vec<u8>) {
        let script = self.script.replace('&', "&amp;").replace('"', "&quot;");
        let head = format!("{HEAD} data-follow=\"{script}\" data-stamp=\"{}\"", self.stamp);
        let at = page.windows(HEAD.len()).position(|part| part == HEAD.as_bytes()).expect("every page begins with it");
        page.splice(at..at + HEAD.len(), head.bytes());
    }

    /// The script, once the pages are known.
    pub fn tell(&self, pages: &[&str]) -> Vec<u8> {
        let latest = LatestBuild { stamp: &self.stamp, pages };
        format!("tweezeBuilt({});\n", serde_json::to_string(&latest).expect("names are JSON")).into_bytes()
    }
}
