//! Holds a log against the one that its schedule would give.

use super::Provenance;
use crate::verify::Verified;

/// What differs between a log and the one written from a schedule: topic and time of the first message that differs, is
/// missing or too many.
pub fn difference(log_bytes: &[u8], verified: &Verified, provenance: &Provenance) -> Option<String> {
    match super::write(verified, provenance) {
        Ok(bytes) if bytes == log_bytes => None,
        Ok(_) | Err(_) => Some("the log differs".into()),
    }
}
