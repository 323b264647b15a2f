//! Programs and logs from strangers: attacks on the person who checks, builds or verifies them.
//!
//! `tests/found/` has the programs that once succeeded; the first line of each describes the attack.

mod bench;
mod files;
#[cfg(unix)]
#[path = "../support/ignored.rs"]
mod ignored;
#[cfg(target_os = "linux")]
mod kills;
mod logs;
#[cfg(unix)]
mod signals;
#[path = "../support/system.rs"]
mod system;
mod texts;
