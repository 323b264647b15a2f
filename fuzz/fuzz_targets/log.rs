//! Any bytes through the reader of logs: it ends, does not panic, and allocates no more than the file's size allows.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(log) = tweeze::verify::log::read(bytes) {
        log.voltage_fault();
    }
});
