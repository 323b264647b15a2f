//! Any bytes are read as a log, or refused, without a panic.

#![no_main]

use libfuzzer_sys::fuzz_target;
use tweeze::verify::log;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(log) = log::read(bytes) {
        log.voltage_fault();
    }
});
