//! A GTKWave save file beside a VCD file: its variables as rows, grouped by device, with the whole schedule in view.
//!
//! Row flags are those of GTKWave's own save files, hexadecimal sums of: 0x8 binary, 0x20 right-aligned, 0x400 signed,
//! 0x8000 drawn as steps, 0x20000 room for the row above, 0x800200 and 0x1000200 begin and end of a group.

use super::Signals;
use super::variables::{ChannelForm, Variable};
use std::collections::BTreeMap;
use std::fmt::Write as _;

const BIT: &str = "@28";
const STEPS: &str = "@8420";
const ROOM: &str = "@20000\n-\n-";
const GROUP: &str = "@800200";
const GROUP_END: &str = "@1000200";

/// The units in which GTKWave counts time, in nanoseconds: a timescale of 10 us or 100 us is counted in microseconds.
const SCALES_NS: [u64; 4] = [1_000_000_000, 1_000_000, 1000, 1];

/// Time units that a window shows at zoom 0.
const UNITS_IN_WINDOW: u64 = 4;

/// The save file. Channels that are always at 0 V come last in their device.
pub fn write(
    signals: &Signals,
    scopes: &BTreeMap<&str, String>,
    forms: &[ChannelForm],
    variables: &[Variable],
    unit_ns: u64,
) -> String {
    let name = &signals.schedule.name;
    let scale_ns = SCALES_NS.into_iter().find(|scale_ns| *scale_ns <= unit_ns).unwrap_or(1);
    let units = signals.schedule.duration_ns / scale_ns;
    let zoom = units.div_ceil(UNITS_IN_WINDOW).next_power_of_two().trailing_zeros();
    let mut text = format!("[dumpfile] \"{name}.vcd\"\n[savefile] \"{name}.gtkw\"\n[timestart] 0\n[size] 1400 800\n");
    let _ = writeln!(text, "*-{zoom}.000000 0\n[sst_width] 200\n[signals_width] 260");
    for (device, _, channels) in signals.devices() {
        let scope = &scopes[device];
        let _ = writeln!(text, "{GROUP}\n-{scope}");
        let (still, busy): (Vec<usize>, Vec<usize>) =
            channels.into_iter().partition(|channel| forms[*channel] == ChannelForm::Switch(None));
        for channel in busy.into_iter().chain(still) {
            for variable in variables.iter().filter(|variable| variable.channel == channel) {
                let _ = match variable.role.is_bit() {
                    true => writeln!(text, "{BIT}\n{scope}.{}", variable.name),
                    false => writeln!(text, "{STEPS}\n{scope}.{}\n{ROOM}", variable.name),
                };
            }
        }
        let _ = writeln!(text, "{GROUP_END}\n-{scope}");
    }
    text
}
