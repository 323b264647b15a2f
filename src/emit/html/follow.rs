//! Pages that follow their program: while it is rebuilt, each page moves on to the page of the latest build.

use crate::emit::Provenance;
use crate::schedule::sha256;
use serde::Serialize;

/// The beginning of every page.
const HEAD: &str = "<html lang=\"en\"";

/// A script beside the pages of a build that names the latest build. Pages cannot read other files from the disk, but
/// they can load scripts.
pub struct Follower<'a> {
    /// Name of the script.
    script: &'a str,
    /// Fingerprint of the program's files.
    stamp: String,
}

/// Content of the script.
#[derive(Serialize)]
struct LatestBuild<'a> {
    stamp: &'a str,
    /// Names of the pages: those of the schedules, or the one of the errors.
    pages: &'a [&'a str],
}

impl<'a> Follower<'a> {
    /// The script of a build, by its name.
    pub fn new(script: &'a str, provenance: &Provenance) -> Self {
        let files = provenance.files.iter().flat_map(|(name, text)| [name.as_str(), "\n", text, "\n"]);
        Self { script, stamp: sha256(&files.collect::<String>()) }
    }

    /// Makes a page follow.
    pub fn mark_page(&self, page: &mut Vec<u8>) {
        let script = self.script.replace('&', "&amp;").replace('"', "&quot;");
        let head = format!("{HEAD} data-follow=\"{script}\" data-stamp=\"{}\"", self.stamp);
        let at = page.windows(HEAD.len()).position(|part| part == HEAD.as_bytes()).expect("every page begins with it");
        page.splice(at..at + HEAD.len(), head.bytes());
    }

    /// The bytes of the script, once the pages are known.
    pub fn script_bytes(&self, pages: &[&str]) -> Vec<u8> {
        let latest = LatestBuild { stamp: &self.stamp, pages };
        format!("tweezeBuilt({});\n", serde_json::to_string(&latest).expect("names are JSON")).into_bytes()
    }
}
