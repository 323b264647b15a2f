//! Devices and wirings: E04xx.

use crate::check::scope::path_text;
use crate::device::VocabularyField;
use crate::device::instrument::LinkSort;
use crate::diagnostic::{Code, Diagnostic};
use crate::quantity::Quantity;
use crate::source::Span;
use crate::syntax::tree::{Ident, Path};

use super::listed;

/// `library` is a published device to start from: its file and its name.
pub fn missing_fields(
    span: Span,
    owner: &str,
    missing: &[&VocabularyField],
    library: Option<(&str, &str)>,
) -> Diagnostic {
    let names: Vec<&str> = missing.iter().map(|field| field.name).collect();
    let list: Vec<String> = missing.iter().map(|field| format!("`{}` ({})", field.name, field.doc)).collect();
    let start =
        library.map(|(file, device)| format!("; or start from a published device: `use {file}` and `: {device}`"));
    Diagnostic::new(Code::E0401, format!("{owner} lacks {}", listed(names)))
        .label(span, "not all fields are given")
        .help(format!("add {}{}", list.join(", "), start.unwrap_or_default()))
}

pub fn field_twice(name: &Ident, earlier: Span) -> Diagnostic {
    Diagnostic::new(Code::E0402, format!("field `{}` is given twice", name.text))
        .label(name.span, "given again here")
        .label(earlier, "first given here")
}

pub fn time_out_of_clock(span: Span, what: &str, found: &str, limit: &str) -> Diagnostic {
    Diagnostic::new(Code::E0404, format!("{what} of {found} does not fit the clock; {limit}"))
        .label(span, "out of the range of the clock")
        .help("schedules count whole nanoseconds")
}

pub fn workspace_too_large(span: Span, extent: &str, limit: &str) -> Diagnostic {
    Diagnostic::new(Code::E0405, format!("workspace of {extent}; the largest that can be planned is {limit}"))
        .label(span, "follows from the stroke and the gain of this device")
        .help("the workspace is gain * stroke * sqrt(2) * (2 - 2^(1-n)) wide: check the units of `stroke` and `gain`")
}

pub fn cells_indistinguishable(span: Span, repeatability: &str, pitch: &str) -> Diagnostic {
    Diagnostic::new(Code::W0401, format!("the repeatability of {repeatability} is more than half the pitch of {pitch}"))
        .label(span, "neighbouring cells of this robot cannot be told apart")
        .help("more modules refine the lattice, not the robot: places are no better than the repeatability")
}

/// For an existing module its channels are listed by the part after the dot; for a missing module the valid range is
/// given.
pub fn unknown_channel(span: Span, owner: &str, channel: &str, known: &[String]) -> Diagnostic {
    let module = |channel: &str| channel.split('.').next().unwrap_or_default().to_owned();
    let of_module = known.iter().filter(|known| module(known) == module(channel)).map(String::as_str);
    let help = match listed(of_module).as_str() {
        "nothing" if known.len() == 1 => format!("its channel is `{}`", known[0]),
        "nothing" => {
            let [first, last] = [known.first(), known.last()].map(|known| known.map_or("", String::as_str));
            format!("its channels run from `{first}` to `{last}`; `tweeze devices` shows how they are named")
        }
        list => format!("write {list}"),
    };
    Diagnostic::new(Code::E0406, format!("{owner} has no channel `{channel}`"))
        .label(span, "no such channel")
        .help(help)
}

/// A wire of an electrode that shares its channel with an earlier one, which gives the channel its name.
pub fn wire_of_shared_channel(span: Span, channel: &str, first: &str) -> Diagnostic {
    Diagnostic::new(Code::E0406, format!("electrode `{channel}` is on a shared channel, which is named `{first}`"))
        .label(span, "no channel of its own")
        .help(format!(
            "wire `{first}`: a shared channel is named after the first of its electrodes, row by row from row 1"
        ))
}

pub fn channel_wired_twice(channel: &str, span: Span, earlier: Span) -> Diagnostic {
    Diagnostic::new(Code::E0407, format!("channel `{channel}` is wired twice"))
        .label(span, "wired again here")
        .label_elsewhere(earlier, span, "first wired here")
}

pub fn output_used_twice(output: &str, span: Span, earlier: Span) -> Diagnostic {
    Diagnostic::new(Code::E0407, format!("output \"{output}\" drives two channels"))
        .label(span, "used again here")
        .label_elsewhere(earlier, span, "first used here")
        .help("wire each channel to an output of its own")
}

pub fn wired_twice(device: &str, span: Span, earlier: Span) -> Diagnostic {
    Diagnostic::new(Code::E0408, format!("device `{device}` has two wirings"))
        .label(span, "wired again here")
        .label(earlier, "first wired here")
        .help("put all wires of a device into one `wiring`")
}

/// The instrument with its declaration; `known` lists its outputs.
pub fn unknown_output(
    span: Span,
    name: &str,
    declared: Span,
    output: &str,
    known: &str,
    takes_boards: bool,
) -> Diagnostic {
    let all =
        if takes_boards { format!("; `electrodes -> {name}` wires all electrodes of a board") } else { String::new() };
    let title = match output {
        "" => format!("a wire to instrument `{name}` names no output"),
        _ => format!("instrument `{name}` has no output `{output}`"),
    };
    Diagnostic::new(Code::E0426, title)
        .label(span, "no such output")
        .label_elsewhere(declared, span, "declared here")
        .help(format!("its outputs are {known}: write `{name}.` and one of them{all}"))
}

/// A digital line on a channel of positions.
pub fn line_for_a_stage(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0427, "a digital line cannot position a stage")
        .label(span, "this output is on or off")
        .help("wire positions to voltage outputs, with the `scale` that the stage's driver expects")
}

/// A channel of voltages wired to a controller of stages.
pub fn stage_for_a_voltage(span: Span, name: &str, declared: Span) -> Diagnostic {
    Diagnostic::new(Code::E0427, format!("`{name}` moves stages and gives no voltage"))
        .label(span, "positions a stage")
        .label_elsewhere(declared, span, "declared here")
        .help("wire voltages to a `waveform_generator` or to `data_acquisition`, and the stages of a hand to this one")
}

/// A stage that ends where it begins, or before.
pub fn no_travel(span: Span, least: Quantity, most: Quantity) -> Diagnostic {
    Diagnostic::new(Code::E0403, format!("the travel of a stage, from {least} to {most}, is empty or reversed"))
        .label(span, "ends here")
        .help("give `travel_from` and `travel_to` as the stage's own positions, the lower one first")
}

/// A field of a wire to an output without a declared instrument.
pub fn wire_without_instrument(field: &Ident, output: Span) -> Diagnostic {
    Diagnostic::new(Code::E0427, format!("`{}` is given for a wire that leads to no instrument", field.text))
        .label(field.span, "belongs to the output of an instrument")
        .label(output, "only a name")
        .help("declare the instrument, `instrument awg : instruments.keysight_33500b`, and wire to `awg.ch1`; `tweeze devices` lists the families")
}

/// A field of all wires inside of a loop.
pub fn wire_field_in_loop(field: &Ident) -> Diagnostic {
    Diagnostic::new(Code::E0427, format!("`{}` applies to all wires, but is written in a loop", field.text))
        .label(field.span, "a field of the whole wiring")
        .help("move it out of the loop, or into the braces of a wire: `a -> awg.ch1 { gain: 50 }`")
}

/// `awg.ch1 -> bed`.
pub fn wire_turned_round(channel: &Path, output: &Path) -> Diagnostic {
    let [instrument, channel] = [channel, output].map(|path| (path_text(path), path.span));
    let finding = Diagnostic::new(Code::E0119, "this wire is the wrong way round")
        .label(instrument.1, "an output of an instrument")
        .help(format!("put the channel of the device first: write `{} -> {}`", channel.0, instrument.0));
    // No edit where there is an index, which is not part of the names.
    match [&instrument, &channel].iter().all(|(name, span)| name.len() == span.range().len()) {
        true => finding.with_fix(instrument.1, channel.0).with_fix(channel.1, instrument.0),
        false => finding,
    }
}

/// `bed: …` for `bed -> …`.
pub fn colon_in_wire(channel: &Ident) -> Diagnostic {
    Diagnostic::new(Code::E0119, format!("`{}` is wired with `:`, as if it were a field", channel.text))
        .label(channel.span, "`->` belongs between a channel and its output")
        .help(format!("write `{} -> …`", channel.text))
}

pub fn instruments_of_one_name(name: &str, declared: Span, earlier: Span) -> Diagnostic {
    Diagnostic::new(Code::E0427, format!("two instruments named `{name}` in one program"))
        .label(declared, "one of the two")
        .label_elsewhere(earlier, declared, "the other")
        .help("rename one of them: files and logs name instruments without their program file")
}

pub fn no_number_of_points(least: Span, most: Span, least_points: u32, most_points: u32) -> Diagnostic {
    Diagnostic::new(Code::E0403, format!("`least_points` of {least_points} is above `most_points` of {most_points}"))
        .label(least, "no waveform can have this many points")
        .label(most, "the memory holds this many")
}

/// More channels than the frames of a driver have room for.
pub fn too_many_driver_channels(protocol: &str, channels: u32, most: u32) -> Diagnostic {
    Diagnostic::new(Code::E0403, format!("{channels} channels; a frame of `{protocol}` has room for {most}"))
        .help(format!("give the driver at most {most} channels"))
}

/// A rate at which a stage controller takes no positions.
pub fn no_stream_rate(protocol: &str, rate: &str, rates: &str) -> Diagnostic {
    Diagnostic::new(Code::E0403, format!("`rate` is {rate}, but `{protocol}` takes {rates}"))
        .help("give the controller such a rate: the higher it is, the less corners are cut")
}

pub fn no_driver_voltage(least: &str, most: &str) -> Diagnostic {
    Diagnostic::new(Code::E0403, format!("`least_potential` of {least} is above `most_potential` of {most}"))
        .help("swap the two")
}

/// A frequency for a driver that is set by hand.
pub fn no_driver_frequency(protocol: &str) -> Diagnostic {
    Diagnostic::new(
        Code::E0403,
        format!("`frequency` is given, but the voltage of `{protocol}` is set on the driver itself"),
    )
    .help("leave `frequency` out and set it on the driver; a DropBot, `protocol: dropbot`, takes it from here")
}

/// A temperature for a heater that the driver does not have.
pub fn no_driver_heater(field: &str, protocol: &str) -> Diagnostic {
    Diagnostic::new(Code::E0403, format!("`{field}` is given, but the frames of `{protocol}` heat nothing"))
        .help(format!("leave `{field}` out; an OpenDrop, `protocol: opendrop`, has three heaters"))
}

/// A temperature that a frame cannot encode.
pub fn temperature_of_no_frame(given: &str, [least, most]: [u32; 2]) -> Diagnostic {
    Diagnostic::new(
        Code::E0403,
        format!("a heater is set to {given}, but frames have whole degrees from {least} degC to {most} degC"),
    )
    .help("use the nearest of these temperatures")
}

/// An electrode wired to a magnet or a heater.
pub fn channel_to_accessory(span: Span, channel: &str, output: &str) -> Diagnostic {
    Diagnostic::new(Code::E0427, format!("`{channel}` is wired to `{output}`, which switches no electrode"))
        .label(span, "an electrode of a device")
        .help(format!(
            "wire an `output` of the bench to it and set that in steps: `output lift : digital`, `wiring lift {{ out -> {output} }}`"
        ))
}

/// A graded output wired to a magnet or a heater.
pub fn share_of_accessory(span: Span, name: &str, declared: Span, output: &str) -> Diagnostic {
    Diagnostic::new(Code::E0427, format!("`{name}` has many levels, but `{output}` is on or off"))
        .label(span, "a magnet or a heater")
        .label_elsewhere(declared, span, "a `level`")
        .help(format!("declare it with two levels: `output {name} : digital`"))
}

/// A wire to a heater without a temperature.
pub fn heater_without_temperature(span: Span, name: &str, declared: Span, output: &str) -> Diagnostic {
    Diagnostic::new(Code::E0426, format!("instrument `{name}` gives no temperature for its `{output}`"))
        .label(span, "no such output yet")
        .label_elsewhere(declared, span, "declared here")
        .help(format!("give the instrument the temperature: `{output}: 60 degC`"))
}

/// All electrodes of a board wired to an instrument that has no channel for each.
pub fn electrodes_to_other_instrument(span: Span, name: &str, declared: Span) -> Diagnostic {
    Diagnostic::new(Code::E0427, format!("`electrodes` is wired to `{name}`, which drives no board of electrodes"))
        .label(span, "not an `electrode_driver`")
        .label_elsewhere(declared, span, "declared here")
        .help("wire them to an electrode driver, or one by one: `e1_1 -> daq.port0.line0 { switches: … V }`, with the voltage of its electrodes")
}

/// All electrodes of a board wired to one output.
pub fn electrodes_to_one_output(span: Span, name: &str) -> Diagnostic {
    Diagnostic::new(Code::E0427, "`electrodes` is wired to one output")
        .label(span, "drives one electrode")
        .help(format!("write `electrodes -> {name}`: each electrode goes to the channel of its number"))
}

/// All electrodes of a board that has no numbers for them.
pub fn electrodes_without_numbers(span: Span, device: &str) -> Diagnostic {
    Diagnostic::new(Code::E0427, format!("the electrodes of `{device}` have no numbers"))
        .label(span, "which channel drives which electrode?")
        .help("give the device its `channels`, a list for each row, or wire electrodes one by one: `e1_1 -> driver.c8 { switches: … V }`, with the voltage of its electrodes")
}

/// An electrode whose number the driver does not have.
pub fn channel_beyond_driver(
    span: Span,
    name: &str,
    declared: Span,
    channel: &str,
    number: u32,
    known: &str,
) -> Diagnostic {
    Diagnostic::new(Code::E0426, format!("electrode `{channel}` is on channel {number}, but `{name}` has {known}"))
        .label(span, "wires every numbered electrode")
        .label_elsewhere(declared, span, "declared here")
        .help("check `channels` of the device against the driver that the board is made for")
}

/// All channels wired to an output without a declared instrument.
pub fn all_to_a_name(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0427, "`all` is wired to a name, not to an instrument")
        .label(span, "a single output; no others are known")
        .help("declare the instrument, `instrument card : instruments.ni_usb_6343`, and write `all -> card`")
}

/// All channels wired in order, although they have numbers.
pub fn all_of_numbered(span: Span, channel: &str, number: u32, instrument: &str) -> Diagnostic {
    Diagnostic::new(
        Code::E0427,
        format!("`all` leads to the outputs of `{instrument}` in order, regardless of channel numbers"),
    )
    .label(span, format!("here `{channel}` has number {number}"))
    .with_fix_here("electrodes")
    .help(format!("write `electrodes -> {instrument}`: each electrode goes to the output of its number"))
}

/// All channels wired to one output.
pub fn all_to_one_output(span: Span, name: &str) -> Diagnostic {
    Diagnostic::new(Code::E0427, "`all` is wired to one output")
        .label(span, "carries one channel")
        .help(format!("write `all -> {name}`: each channel goes to the next free output"))
}

/// A field for all wires of a device that applies to none of them.
pub fn idle_wire_field(span: Span, device: &str, name: &str) -> Diagnostic {
    let takes = |sort: &&LinkSort| sort.fields().iter().any(|field| field.name == name);
    let others: Vec<&str> = LinkSort::ALL.iter().filter(takes).map(|sort| sort.described()).collect();
    Diagnostic::new(Code::W0504, format!("`{name}` changes nothing: no wire of `{device}` has it"))
        .label(span, "applies to no wire here")
        .help(format!("leave it out; it is for wires to {}", others.join(", to ")))
}

/// Sort of output that the wires of all channels lead to.
fn output_sort(by_lines: bool) -> &'static str {
    if by_lines { "digital line" } else { "voltage or position output" }
}

/// Help for wiring all channels to digital lines instead.
const LINES: &str = "for digital lines give the voltage of the device, which they switch, as `switches: 20 V`";

/// An instrument without a free output for all channels.
pub fn nothing_free(span: Span, name: &str, declared: Span, by_lines: bool) -> Diagnostic {
    let (what, other) =
        (output_sort(by_lines), if by_lines { "leave `switches` out for voltage outputs" } else { LINES });
    Diagnostic::new(Code::E0426, format!("`{name}` has no free {what}"))
        .label(span, "nothing to wire to")
        .label_elsewhere(declared, span, "declared here")
        .help(format!("use another instrument, or {other}"))
}

/// More channels than free outputs.
pub fn channels_left_over(
    span: Span,
    device: &str,
    first: &str,
    [left, total]: [usize; 2],
    by_lines: bool,
) -> Diagnostic {
    let (what, lines) = (output_sort(by_lines), if by_lines { String::new() } else { format!("; {LINES}") });
    let title = format!("no free {what} for {left} of {total} channels of `{device}`; `{first}` is the first of them");
    Diagnostic::new(Code::E0426, title).label(span, format!("no {what} is left")).help(format!(
        "declare another instrument with `start: trigger` and add `all -> NAME` for it: it takes the rest{lines}"
    ))
}

/// Two instruments of a program, each with a wire that leads to it, that both begin when the sender starts them.
/// `is_driver` is set if the second is an electrode driver, which nothing can trigger.
pub fn starts_apart(first: &str, first_wire: Span, second: &str, second_wire: Span, is_driver: bool) -> Diagnostic {
    let help = match is_driver {
        false => format!(
            "connect the trigger output of `{first}` to the trigger input of `{second}`, and give `{second}` `start: trigger`"
        ),
        true => format!(
            "`{second}` has no trigger input, so they cannot start at the same instant: play them in separate programs, or give \
             `{second}` `start: trigger` and start its sender yourself when `{first}` starts"
        ),
    };
    Diagnostic::new(Code::E0428, format!("`{first}` and `{second}` are started by the sender, one after the other"))
        .label(second_wire, format!("played by `{second}`"))
        .label_elsewhere(first_wire, second_wire, format!("played by `{first}`"))
        .help(help)
}
