//! The voltages or positions of a device's channels as a time series that viewers plot by name.
//!
//! `/bot/voltages` is in volts, `/hand/positions` in micrometres; the following applies to both.
//!
//! Each device has its own message type. Up to [`MAX_FIELDS`] channels each is a field, so a plot is selected as
//! `/bot/voltages.bl4_set`; beyond that they are one list, `/plate/voltages.volts[7]`. The topic's metadata map each
//! field to its channel and wire. Every message contains all channels, since a missing field reads as 0 V. At 1 ns
//! before a jump the old values are repeated, so that lines between messages are the signal itself. All values are also
//! repeated at [`resample_instants`], since viewers draw only a few points per pixel and would join the levels of a
//! rarely logged signal by slopes.
//!
//! A channel with drive trains would need a message for every edge, so it has two fields, `/bed/voltages.bed_low` and
//! `…bed_high`: the lower and the higher level of the current train, and the same value twice outside trains. The
//! topic's metadata name the level of each field and the periods of the trains.

use super::{LogTopic, Signals, foxglove};
use crate::emit::identifier;
use crate::emit::signal::SignalCursor;
use crate::log::{self, BOUND_SUFFIX, Bound, PERIOD_SUFFIX};
use crate::schedule::ChannelUnit;
use prost::Message;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet};
use std::collections::{BTreeMap, BTreeSet};

/// Greatest number of channels with a field each.
pub const MAX_FIELDS: usize = 300;

/// Greatest number of bytes of field names, since readers limit the size of a message type.
const MAX_NAME_BYTES: usize = 16 * 1024;

/// Number of equal parts of the schedule at whose ends all values are repeated: about one per pixel of a plot.
pub const RESAMPLE_STEPS: u64 = 1000;

/// The instants at which values are repeated.
pub fn resample_instants(duration_ns: u64) -> impl Iterator<Item = u64> {
    (0..=RESAMPLE_STEPS)
        .map(move |step| (u128::from(duration_ns) * u128::from(step) / u128::from(RESAMPLE_STEPS)) as u64)
}

/// Repeats held values at those instants.
pub fn repeat_values(levels: &mut BTreeMap<u64, Vec<f64>>, duration_ns: u64) {
    for t_ns in resample_instants(duration_ns) {
        if let Some((_, values)) = levels.range(..=t_ns).next_back() {
            let values = values.clone();
            levels.entry(t_ns).or_insert(values);
        }
    }
}

/// Name of the field that lists many channels.
fn list(unit: ChannelUnit) -> &'static str {
    match unit {
        ChannelUnit::Volt => "volts",
        ChannelUnit::Micrometre => "micrometres",
    }
}

/// One number of each message.
struct MessageColumn {
    channel: usize,
    bound: Bound,
}

/// The columns of these channels; two for each that swings.
fn columns(signals: &Signals, channels: &[usize]) -> Vec<MessageColumn> {
    let of_channel = |&channel: &usize| {
        let bounds: &[Bound] = match signals.swings(channel).next() {
            Some(_) => &[Bound::Low, Bound::High],
            None => &[Bound::Exact],
        };
        bounds.iter().map(move |bound| MessageColumn { channel, bound: *bound })
    };
    channels.iter().flat_map(of_channel).collect()
}

/// Estimated bytes of all messages.
pub fn estimated_bytes(signals: &Signals) -> u64 {
    let of_device = |channels: &[usize]| {
        let messages = 2 * signals.breaks(channels.iter().copied()).len() as u64 + RESAMPLE_STEPS + 2;
        messages * (columns(signals, channels).len() as u64 * 10 + 31)
    };
    signals.devices().iter().map(|(.., channels)| of_device(channels)).sum()
}

/// The topic of a device's channels of one unit.
pub fn topic(signals: &Signals, device: &str, unit: ChannelUnit, channels: &[usize]) -> LogTopic {
    let all = &signals.schedule.channels;
    let columns = columns(signals, channels);
    let short = columns.iter().map(|MessageColumn { channel, bound }| {
        let name = all[*channel].name.split_once('.').map_or(all[*channel].name.as_str(), |(_, rest)| rest);
        bound.name().map_or_else(|| name.to_owned(), |bound| format!("{name}_{bound}"))
    });
    let short: Vec<String> = short.collect();
    let names = identifier::distinct_fields(short.iter().map(String::as_str));
    let fields = names.len() <= MAX_FIELDS && names.iter().map(String::len).sum::<usize>() <= MAX_NAME_BYTES;
    let paths = names
        .iter()
        .enumerate()
        .map(|(index, name)| if fields { name.clone() } else { format!("{}[{index}]", list(unit)) });
    let mut metadata = BTreeMap::new();
    for (path, column) in paths.zip(&columns) {
        if let Some(wire) = &all[column.channel].wire {
            metadata.insert(format!("{path}.wire"), wire.clone());
        }
        if let Some(bound) = column.bound.name() {
            metadata.insert(format!("{path}{BOUND_SUFFIX}"), bound.to_owned());
            metadata.insert(format!("{path}{PERIOD_SUFFIX}"), periods(signals, column.channel));
        }
        metadata.insert(path, all[column.channel].name.clone());
    }
    let package = format!("tweeze.{}", signals.device_names(identifier::plain)[device]);
    let message = match unit {
        ChannelUnit::Volt => "Voltages",
        ChannelUnit::Micrometre => "Positions",
    };
    LogTopic {
        name: log::topic(device, unit),
        schema: schema(
            &package,
            message,
            if fields { MessageShape::Fields(&names) } else { MessageShape::List(list(unit)) },
        ),
        metadata,
        messages: messages(signals, channels, &columns, if fields { encode_fields } else { encode_list }),
    }
}

/// The distinct periods of a channel's swings in nanoseconds, in rising order.
fn periods(signals: &Signals, channel: usize) -> String {
    let periods: BTreeSet<u64> = signals.swings(channel).map(|(_, swing)| swing.period_ns).collect();
    periods.iter().map(u64::to_string).collect::<Vec<_>>().join(" ")
}

/// Layout of a message.
pub enum MessageShape<'a> {
    Fields(&'a [String]),
    /// One field of this name.
    List(&'a str),
}

/// A message type of doubles.
pub fn schema(package: &str, message: &str, shape: MessageShape) -> foxglove::MessageSchema {
    let field = |name: &str, number: usize, label: Label| FieldDescriptorProto {
        name: Some(name.to_owned()),
        json_name: Some(name.to_owned()),
        number: Some(number as i32),
        label: Some(label as i32),
        r#type: Some(Type::Double as i32),
        ..FieldDescriptorProto::default()
    };
    let fields = match shape {
        MessageShape::Fields(names) => {
            names.iter().enumerate().map(|(index, name)| field(name, index + 1, Label::Optional)).collect()
        }
        MessageShape::List(name) => vec![field(name, 1, Label::Repeated)],
    };
    let name = format!("{package}.{message}");
    let message = DescriptorProto { name: Some(message.into()), field: fields, ..DescriptorProto::default() };
    let file = FileDescriptorProto {
        name: Some(format!("{}.proto", package.replace('.', "/"))),
        package: Some(package.to_owned()),
        message_type: vec![message],
        syntax: Some("proto3".into()),
        ..FileDescriptorProto::default()
    };
    let descriptor = FileDescriptorSet { file: vec![file] }.encode_to_vec();
    foxglove::MessageSchema { name, descriptor }
}

fn messages(
    signals: &Signals,
    channels: &[usize],
    columns: &[MessageColumn],
    encode: fn(&[f64]) -> Vec<u8>,
) -> Vec<(u64, Vec<u8>)> {
    let breaks = signals.breaks(channels.iter().copied());
    let before = breaks.iter().filter_map(|t_ns| t_ns.checked_sub(1));
    let repeated = resample_instants(signals.schedule.duration_ns);
    let times: BTreeSet<u64> = breaks.iter().copied().chain(before).chain(repeated).collect();
    let mut cursors: Vec<(SignalCursor, Bound)> =
        columns.iter().map(|column| (SignalCursor::new(signals, column.channel), column.bound)).collect();
    let mut values = Vec::with_capacity(columns.len());
    let at = |t_ns| {
        values.clear();
        values.extend(cursors.iter_mut().map(|(cursor, bound)| {
            let [low, high] = cursor.envelope(t_ns);
            match bound {
                Bound::Exact | Bound::Low => low,
                Bound::High => high,
            }
        }));
        (t_ns, encode(&values))
    };
    times.into_iter().map(at).collect()
}

/// Encodes one field per value, zero included.
pub fn encode_fields(values: &[f64]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(values.len() * 10);
    for (number, value) in (1..).zip(values) {
        prost::encoding::double::encode(number, value, &mut bytes);
    }
    bytes
}

/// Encodes one packed list as field 1.
fn encode_list(values: &[f64]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(values.len() * 8 + 10);
    prost::encoding::double::encode_packed(1, values, &mut bytes);
    bytes
}
