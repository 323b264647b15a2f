//! Programs and logs from strangers: what they may not do to the person who checks, builds or verifies them.
//!
//! `tests/found/` holds the programs that once did; each says in its first line what it is.

mod bench;
mod files;
#[cfg(target_os = "linux")]
mod kills;
mod logs;
#[cfg(unix)]
mod signals;
#[path = "../support/system.rs"]
mod system;
mod texts;
