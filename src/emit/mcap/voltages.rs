//! The voltages of a device's channels as a time series that viewers plot by name.
//!
//! A message type is made for each device. Up to [`MAX_FIELDS`] channels each is a field, so that a plot is asked for as
//! `/bot/voltages.bl4_set`; beyond that they are one list, `/plate/voltages.volts[7]`. The topic's metadata says which field is
//! which channel, and the wire behind it. Every message holds all channels, since a missing field reads as 0 V. Just before a
//! jump, 1 ns earlier, the old values are said again, so that lines between messages are the signal itself.

use super::{Signals, Topic, foxglove};
use crate::emit::identifier;
use prost::Message;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet};
use std::collections::{BTreeMap, BTreeSet};

/// The most channels that get a field each.
pub const MAX_FIELDS: usize = 300;

/// The most bytes of names that get a field each: readers limit the size of a message type.
const MAX_NAME_BYTES: usize = 16 * 1024;

/// The name of the field that lists many channels.
const LIST: &str = "volts";

/// About how many bytes all messages take.
pub fn estimated_bytes(signals: &Signals) -> u64 {
    let of_device = |channels: &[usize]| {
        let messages = 2 * signals.breaks(channels.iter().copied()).len() + 2;
        messages as u64 * (channels.len() as u64 * 10 + 31)
    };
    signals.devices().iter().map(|(_, channels)| of_device(channels)).sum()
}

/// The topic of a device.
pub fn topic(signals: &Signals, device: &str, channels: &[usize]) -> Topic {
    let all = &signals.schedule.channels;
    let short = channels.iter().map(|&channel| match all[channel].name.split_once('.') {
        Some((_, rest)) => rest,
        None => all[channel].name.as_str(),
    });
    let names = identifier::distinct(short);
    let fields = names.len() <= MAX_FIELDS && names.iter().map(String::len).sum::<usize>() <= MAX_NAME_BYTES;
    let paths =
        names.iter().enumerate().map(|(index, name)| if fields { name.clone() } else { format!("{LIST}[{index}]") });
    let mut metadata = BTreeMap::new();
    for (path, &channel) in paths.zip(channels) {
        if let Some(wire) = &all[channel].wire {
            metadata.insert(format!("{path}.wire"), wire.clone());
        }
        metadata.insert(path, all[channel].name.clone());
    }
    let package = format!("tweeze.{}", identifier::distinct([device])[0]);
    Topic {
        name: format!("/{device}/voltages"),
        schema: schema(&package, if fields { Shape::Fields(&names) } else { Shape::List }),
        metadata,
        messages: messages(signals, channels, if fields { encode_fields } else { encode_list }),
    }
}

/// What a message looks like.
enum Shape<'a> {
    Fields(&'a [String]),
    List,
}

fn schema(package: &str, shape: Shape) -> foxglove::Schema {
    let field = |name: &str, number: usize, label: Label| FieldDescriptorProto {
        name: Some(name.to_owned()),
        json_name: Some(name.to_owned()),
        number: Some(number as i32),
        label: Some(label as i32),
        r#type: Some(Type::Double as i32),
        ..FieldDescriptorProto::default()
    };
    let fields = match shape {
        Shape::Fields(names) => {
            names.iter().enumerate().map(|(index, name)| field(name, index + 1, Label::Optional)).collect()
        }
        Shape::List => vec![field(LIST, 1, Label::Repeated)],
    };
    let message = DescriptorProto { name: Some("Voltages".into()), field: fields, ..DescriptorProto::default() };
    let file = FileDescriptorProto {
        name: Some(format!("{}.proto", package.replace('.', "/"))),
        package: Some(package.to_owned()),
        message_type: vec![message],
        syntax: Some("proto3".into()),
        ..FileDescriptorProto::default()
    };
    let descriptor = FileDescriptorSet { file: vec![file] }.encode_to_vec();
    foxglove::Schema { name: format!("{package}.Voltages"), descriptor }
}

fn messages(signals: &Signals, channels: &[usize], encode: fn(&[f64]) -> Vec<u8>) -> Vec<(u64, Vec<u8>)> {
    let breaks = signals.breaks(channels.iter().copied());
    let before = breaks.iter().filter_map(|t_ns| t_ns.checked_sub(1));
    let ends = [0, signals.schedule.duration_ns];
    let times: BTreeSet<u64> = breaks.iter().copied().chain(before).chain(ends).collect();
    let at = |t_ns| {
        let values: Vec<f64> = channels.iter().map(|&channel| signals.value(channel, t_ns)).collect();
        (t_ns, encode(&values))
    };
    times.into_iter().map(at).collect()
}

/// One field for each value, zero included.
fn encode_fields(values: &[f64]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(values.len() * 10);
    for (number, value) in (1..).zip(values) {
        prost::encoding::double::encode(number, value, &mut bytes);
    }
    bytes
}

/// One packed list as field 1.
fn encode_list(values: &[f64]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(values.len() * 8 + 10);
    prost::encoding::double::encode_packed(1, values, &mut bytes);
    bytes
}
