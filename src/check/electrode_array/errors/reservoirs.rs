//! Diagnostics of reservoirs: their outlets and the frames that dispense droplets.

use super::written;
use crate::check::value::Value;
use crate::device::electrode_array::{ElectrodeCell, MAX_DISPENSE_FRAMES};
use crate::diagnostic::{Code, Diagnostic};
use crate::source::Span;

/// Some of the fields of reservoirs without the others.
pub fn half_of_reservoirs(missing: &[&str]) -> Diagnostic {
    let names: Vec<String> = missing.iter().map(|name| format!("`{name}`")).collect();
    Diagnostic::new(Code::E0429, format!("the reservoirs of the board lack {}", names.join(" and ")))
        .help("give all three: `outlets: [(1, 2)]`, `dispense_frames: [[[3], [3, 2], [0, 9]]]` and `dispense_frame_duration: 1.2 s`")
}

/// Different numbers of sequences and outlets.
pub fn frames_of_other_outlets() -> Diagnostic {
    Diagnostic::new(Code::E0429, "`dispense_frames` and `outlets` differ in length")
        .help("write one list of frames for each outlet, in the same order")
}

/// An outlet without a known channel.
pub fn outlet_without_number(value: &Value) -> Diagnostic {
    Diagnostic::new(
        Code::E0429,
        format!("{} cannot be an outlet: the board has no numbered electrode there", written(value)),
    )
    .help("an outlet is the cell, as `(1, 2)`, of an electrode that has a number in `channels`")
}

/// Frames that do not leave a droplet on the outlet.
pub fn makes_no_droplet(outlet: ElectrodeCell, own: u32) -> Diagnostic {
    Diagnostic::new(Code::E0429, format!("these frames make no droplet at {outlet}")).help(format!(
        "write 1 to {MAX_DISPENSE_FRAMES} frames, the first one with a pad of the reservoir, the last one with {own}, the channel of the electrode at {outlet}, which holds the droplet"
    ))
}

/// `none` in a frame.
pub fn nothing_in_frame() -> Diagnostic {
    Diagnostic::new(Code::E0429, "a frame lists the channels that are on, but `none` is not a channel")
        .help("leave `none` out; a frame in which all pads are off is `[]`")
}

/// A frame that switches an electrode on which other droplets may be.
pub fn frame_on_the_board(channel: u32, outlet: ElectrodeCell) -> Diagnostic {
    let title = format!("channel {channel} is an electrode of the board other than the outlet {outlet}");
    Diagnostic::new(Code::E0429, title)
        .help("a frame switches pads of its reservoir, which `channels` does not list, and the outlet")
}

/// A pad shared by two reservoirs.
pub fn pad_of_two(channel: u32, [one, other]: [ElectrodeCell; 2]) -> Diagnostic {
    let title = format!("channel {channel} is a pad of the reservoirs at {one} and at {other}");
    Diagnostic::new(Code::E0429, title).help("give each reservoir pads of its own: one frame would act on both")
}

/// A reservoir whose outlet is switched together with other electrodes.
pub fn outlet_on_shared_channel(name: &str, cell: ElectrodeCell, other: ElectrodeCell, span: Span) -> Diagnostic {
    let title = format!("reservoir `{name}` has its outlet at {cell}, which shares its channel with {other}");
    Diagnostic::new(Code::E0555, title).label(span, "no channel of its own").help(
        "put the outlet on an electrode with a channel of its own: a droplet would come out whenever the other electrode is on",
    )
}

/// An outlet of the device on a shared channel.
pub fn outlet_shares_channel(cell: ElectrodeCell, channel: u32) -> Diagnostic {
    Diagnostic::new(
        Code::E0429,
        format!("{cell} cannot be an outlet: its channel {channel} switches other electrodes too"),
    )
    .help("choose an electrode with a channel of its own: a droplet would come out whenever the others are on")
}

/// A reservoir where the board has none.
pub fn no_reservoir_there(name: &str, cell: ElectrodeCell, span: Span, outlets: &[ElectrodeCell]) -> Diagnostic {
    let known: Vec<String> = outlets.iter().map(ElectrodeCell::to_string).collect();
    let nearest = outlets.iter().min_by_key(|outlet| outlet.steps_to(cell));
    let title = format!("reservoir `{name}` has its outlet at {cell}, where the board has no reservoir");
    let diagnostic = Diagnostic::new(Code::E0555, title).label(span, "no outlet");
    diagnostic.help(match nearest {
        Some(nearest) => format!("the outlets of the board are {}; the nearest is {nearest}", known.join(", ")),
        None => "the device lists no outlets; leave `outlets: []` out if droplets come from elsewhere".to_owned(),
    })
}
