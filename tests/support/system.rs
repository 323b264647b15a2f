//! System commands that some tests need.

use std::process::Command;

/// Whether a system command exists; reports a missing one.
pub fn is_there(command: &str) -> bool {
    let there = Command::new(command).arg("--version").output().is_ok_and(|output| output.status.success());
    assert!(there || std::env::var_os("TWEEZE_REQUIRE_ORACLES").is_none(), "there is no `{command}`");
    if !there {
        println!("SKIPPED: there is no `{command}`");
    }
    there
}
