//! The same program gives the same bytes, wherever it is stored, however its path is typed, and whichever mathematics
//! library the platform links. Logs of other versions are distinguished from edited ones.

mod bench;
mod examples;
mod figures;
mod mathematics;
mod outputs;
mod paths;
#[path = "../support/mod.rs"]
mod support;
#[path = "../support/system.rs"]
mod system;
mod versions;
