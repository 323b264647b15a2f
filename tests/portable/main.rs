//! The same program gives the same bytes: wherever it is stored, however its path is typed, whatever mathematics the platform links; and
//! logs of other versions are distinguished from edited ones.

mod bench;
mod figures;
mod mathematics;
mod outputs;
mod paths;
#[path = "../support/system.rs"]
mod system;
mod versions;
