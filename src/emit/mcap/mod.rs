//! MCAP: a log that viewers play without set-up, and that `tweeze verify` judges without any other file.
//!
//! All messages are protobuf. For each device: `/<device>/voltages` (V) or `/<device>/positions` (um); `/<device>/pose`
//! (of the end-effector or the held part) and `/<device>/path` (the whole path of an end-effector),
//! `/<device>/pose/<part>` for each part of a board, or the `poses` of all robots; `/<device>/scene` and
//! `/<device>/plan` (scenery, paths and stops, in three dimensions). For viewers that show no scenes there are points:
//! `…/points` of both, and of each mover in its own frame (`/bot/tip/points`). For all: `/tf` and `/log` (each step at
//! its start, with file and line in its text, and each beat of a step that has many). Attachments: `schedule.json`,
//! `claims.json`, and every source file as `source/<name>`. The metadata record `tweeze` names the version that wrote
//! the log, its schema, and its sources. The clock begins at 0.
//!
//! A micrometre would be a dot in a viewer whose unit is the metre, so pictures are enlarged: one unit is one
//! micrometre, for every device.

pub(super) mod cloud;
pub(super) mod devices;
mod difference;
pub(super) mod drawing;
pub(super) mod foxglove;
pub(super) mod frames;
pub mod layout;
pub(super) mod lines;
pub mod recording;
#[cfg(test)]
pub(super) mod tests;
pub(super) mod voltages;

pub use difference::{difference, difference_diagnostic};

use super::{EmitError, Format, Provenance, Signals};
use crate::claims::Order;
use crate::device::each_kind;
use crate::geometry::Pose;
use crate::log::{self, CLAIMS, METADATA, SCHEDULE, SOURCE_PREFIX};
use crate::schedule::json;
use crate::source::MAX_FILE_BYTES;
use crate::verify::Verified;
use ::mcap::write::NoSeek;
use ::mcap::{Attachment, Compression, McapError, WriteOptions, Writer, records};
use devices::LoggedDevice;
use frames::Mover;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{Seek, Write};

/// The scale of pictures, as written in the metadata record.
pub const SCALE: &str = "1 unit of a picture is 1 um";

/// The library, as written in the file's header.
pub const LIBRARY: &str = concat!("tweeze ", env!("CARGO_PKG_VERSION"));

/// Uncompressed size at which a chunk is closed. Up to this size the output of zstd does not depend on its threads.
const CHUNK_BYTES: u64 = 768 * 1024;

const ZSTD_LEVEL: u32 = 3;

/// Header bytes of a message in the file.
const MESSAGE_HEAD_BYTES: u64 = 31;

/// Estimated size of the name and metadata of a topic, which its chunks repeat.
const DEFINITION_BYTES: u64 = 64 * 1024;

/// Greatest number of movers with a topic for their outline.
const MAX_OUTLINES: usize = 500;

/// The frame that all devices stand in.
const WORLD: &str = "world";

/// One topic of the log with its messages.
pub(super) struct LogTopic {
    pub name: String,
    pub schema: foxglove::MessageSchema,
    pub metadata: BTreeMap<String, String>,
    /// In order of time.
    pub messages: Vec<(u64, Vec<u8>)>,
}

impl LogTopic {
    pub fn new<T: ::foxglove::Encode>(name: impl Into<String>, messages: Vec<(u64, Vec<u8>)>) -> LogTopic {
        let schema = foxglove::schema::<T>().expect("every foxglove message has a schema");
        LogTopic { name: name.into(), schema, metadata: BTreeMap::new(), messages }
    }
}

/// Pictures of a device kind in a log, implemented by its orders.
pub(super) trait Pictures {
    /// All topics of a device except its voltages or positions, and its movers.
    fn topics(&self, verified: &Verified, signals: &Signals, device: &str) -> (Vec<LogTopic>, Vec<Mover>);

    /// Least and greatest x of the picture of the device, in its own frame.
    fn reach(&self) -> [f64; 2];

    /// Each beat of a step in which many things move: its start, and the text of its moves.
    fn beats(&self, _verified: &Verified, _device: &str) -> Vec<(u64, String)> {
        Vec::new()
    }

    /// Camera tilt for the device, in degrees; 0 from above.
    fn tilt_deg(&self) -> f64 {
        0.0
    }

    /// Right edge of the picture in the scene, for a given frame; `None` for a kind whose devices have no frame.
    fn right_in_scene(&self, _frame: &Pose) -> Option<f64> {
        None
    }
}

/// The pictures of an order.
fn pictures(order: &Order) -> &dyn Pictures {
    each_kind!(Order, order, order => order)
}

/// The bytes of the log, and those of a layout that shows it.
///
/// # Errors
/// [`EmitError::TooLarge`] beyond the limits of the log's reader; [`EmitError::Failed`] if the library fails.
pub(super) fn write(verified: &Verified, provenance: &Provenance) -> Result<[Vec<u8>; 2], EmitError> {
    let (topics, movers) = read_topics(verified)?;
    let layout = layout::write(verified, &topics, &movers);
    drop(movers);
    let mut bytes = Vec::new();
    write_to(&mut bytes, topics, verified, provenance)?;
    bytes.shrink_to_fit();
    Ok([bytes, layout])
}

/// The topics of a log, if its reader accepts their size, and its movers.
fn read_topics(verified: &Verified) -> Result<(Vec<LogTopic>, Vec<Mover>), EmitError> {
    let signals = Signals::new(verified.schedule());
    EmitError::refuse_size(Format::Mcap, voltages::estimated_bytes(&signals), log::MAX_DATA_BYTES)?;
    let (topics, movers) = topics_and_movers(verified, &signals);
    refuse_what_is_not_read(&topics)?;
    Ok((topics, movers))
}

/// Writes the log. All messages together, and the schedule that it carries, may each take several hundred megabytes;
/// the messages are freed before the schedule is serialised.
fn write_to(
    to: &mut dyn Write,
    topics: Vec<LogTopic>,
    verified: &Verified,
    provenance: &Provenance,
) -> Result<(), EmitError> {
    let failed = |error: McapError| EmitError::Failed { format: Format::Mcap, detail: error.to_string() };
    let mut writer = options().create(NoSeek::new(to)).map_err(failed)?;
    write_messages(&mut writer, topics).map_err(failed)?;
    let schedule = json::write(verified.schedule());
    attach(&mut writer, SCHEDULE, "application/json", &schedule, log::MAX_SCHEDULE_BYTES)?;
    drop(schedule);
    let claims = log::write_claims(verified.claims()).expect("claims have string keys only");
    attach(&mut writer, CLAIMS, "application/json", &claims, log::MAX_CLAIMS_BYTES)?;
    for (name, text) in &provenance.files {
        let name = format!("{SOURCE_PREFIX}{name}");
        attach(&mut writer, &name, "text/plain", text.as_bytes(), MAX_FILE_BYTES as u64)?;
    }
    writer.write_metadata(&metadata(verified, provenance)).map_err(failed)?;
    writer.finish().map(drop).map_err(failed)
}

/// An error if the log's reader would refuse the messages for their size.
fn refuse_what_is_not_read(topics: &[LogTopic]) -> Result<(), EmitError> {
    let lengths =
        || topics.iter().flat_map(|topic| &topic.messages).map(|(_, data)| data.len() as u64 + MESSAGE_HEAD_BYTES);
    let refuse = |bytes, limit| EmitError::refuse_size(Format::Mcap, bytes, limit);
    let definitions: u64 = topics.iter().map(|topic| topic.schema.descriptor.len() as u64 + DEFINITION_BYTES).sum();
    refuse(lengths().max().unwrap_or(0), log::MAX_MESSAGE_BYTES)?;
    refuse(lengths().sum::<u64>() + definitions, log::MAX_DATA_BYTES)?;
    refuse(lengths().count() as u64, log::MAX_MESSAGES)?;
    refuse(topics.iter().filter(|topic| log::is_topic(&topic.name)).count() as u64, log::MAX_DEVICES)
}

/// Writes an attachment of at most `limit` bytes.
fn attach<W: Write + Seek>(
    writer: &mut Writer<W>,
    name: &str,
    media_type: &str,
    data: &[u8],
    limit: u64,
) -> Result<(), EmitError> {
    EmitError::refuse_size(Format::Mcap, data.len() as u64, limit)?;
    let (name, media_type) = (name.to_owned(), media_type.to_owned());
    let attachment = Attachment { log_time: 0, create_time: 0, name, media_type, data: Cow::Borrowed(data) };
    let failed = |error: McapError| EmitError::Failed { format: Format::Mcap, detail: error.to_string() };
    writer.attach(&attachment).map_err(failed)
}

fn topics(verified: &Verified, signals: &Signals) -> Vec<LogTopic> {
    topics_and_movers(verified, signals).0
}

fn topics_and_movers(verified: &Verified, signals: &Signals) -> (Vec<LogTopic>, Vec<Mover>) {
    let mut topics = Vec::new();
    for (device, unit, channels) in signals.devices() {
        topics.push(voltages::topic(signals, device, unit, &channels));
    }
    let devices = LoggedDevice::all(verified);
    let mut movers = Vec::new();
    for device in &devices {
        let (own, moving) = pictures(&device.job.order).topics(verified, signals, device.name);
        topics.extend(own);
        movers.extend(moving);
    }
    topics.extend(movers.iter().filter(|mover| !mover.outline.is_empty()).take(MAX_OUTLINES).filter_map(Mover::points));
    topics.push(devices::frames(&devices, &movers));
    topics.push(lines::topic(verified));
    (topics, movers)
}

fn metadata(verified: &Verified, provenance: &Provenance) -> records::Metadata {
    let settings = serde_json::to_string(&provenance.settings).expect("strings are JSON");
    let entries = [
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("schema", log::SCHEMA.to_string()),
        ("program", verified.schedule().name.clone()),
        ("settings", settings),
        ("scale", SCALE.to_owned()),
    ];
    let metadata = entries.into_iter().map(|(key, value)| (key.to_owned(), value)).collect();
    records::Metadata { name: METADATA.to_owned(), metadata }
}

/// Write options of the file. It is written sequentially, so it can go to any sink.
fn options() -> WriteOptions {
    WriteOptions::new()
        .profile("")
        .library(LIBRARY)
        .compression(Some(Compression::Zstd))
        .compression_level(ZSTD_LEVEL)
        .compression_threads(0)
        .chunk_size(Some(CHUNK_BYTES))
        .disable_seeking(true)
}

/// Writes all messages in order of time, and frees each once written.
fn write_messages<W: Write + Seek>(writer: &mut Writer<W>, mut topics: Vec<LogTopic>) -> Result<(), McapError> {
    let mut ids = Vec::new();
    for topic in &topics {
        let schema = writer.add_schema(&topic.schema.name, "protobuf", &topic.schema.descriptor)?;
        ids.push(writer.add_channel(schema, &topic.name, "protobuf", &topic.metadata)?);
    }
    for (topic, sequence) in in_order(&topics) {
        let (log_time, data) = std::mem::take(&mut topics[topic].messages[sequence]);
        let header = records::MessageHeader {
            channel_id: ids[topic],
            sequence: u32::try_from(sequence).unwrap_or(u32::MAX),
            log_time,
            publish_time: log_time,
        };
        writer.write_to_known_channel(&header, &data)?;
    }
    Ok(())
}

/// Indices of topic and message, for all messages in order of time, then of topic.
fn in_order(topics: &[LogTopic]) -> Vec<(usize, usize)> {
    let of_topic = |(topic, list): (usize, &LogTopic)| {
        (0..list.messages.len()).map(move |message| (topic, message)).collect::<Vec<_>>()
    };
    let mut order: Vec<(usize, usize)> = topics.iter().enumerate().flat_map(of_topic).collect();
    order.sort_by_key(|&(topic, message)| (topics[topic].messages[message].0, topic, message));
    order
}
