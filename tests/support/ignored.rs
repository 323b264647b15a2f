//! Signals that a test inherited as ignored.

#![allow(dead_code, reason = "each test uses the part that it needs")]

pub const SIGHUP: i32 = 1;
pub const SIGINT: i32 = 2;
pub const SIGTERM: i32 = 15;

/// Whether this test was started with a signal ignored, as background jobs of some shells are with SIGINT; then every
/// process that it starts ignores the signal too.
pub fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let is_ignored = mask(&status, "SigIgn:") >> (signal - 1) & 1 == 1;
    if is_ignored {
        println!("SKIPPED: signal {signal} is ignored here");
    }
    is_ignored
}

/// The bit mask of signals in a line of a process's status.
pub fn mask(status: &str, name: &str) -> u64 {
    let mask = status.lines().find_map(|line| line.strip_prefix(name));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}
