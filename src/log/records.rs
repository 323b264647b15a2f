//! Parses the records of an MCAP file, with a check before every step.

use super::error::LogError;
use super::series::{self, Decoder, Samples, Series};
use super::{
    MAX_DATA_BYTES, MAX_DEFINITION_BYTES, MAX_DEVICES, MAX_MAP_BYTES, MAX_MESSAGE_BYTES, MAX_MESSAGES, METADATA,
    RECORDING,
};
use mcap::records::op;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Length of the opcode and the length field before every record.
const RECORD_HEAD_BYTES: usize = 9;

/// Largest chunk that is unpacked: the largest message, and a quarter more for the messages before it.
const MAX_CHUNK_BYTES: u64 = MAX_MESSAGE_BYTES + MAX_MESSAGE_BYTES / 4;

/// The parts of a log that are kept.
#[derive(Default)]
pub struct Contents<'a> {
    pub attachments: Vec<Attachment<'a>>,
    /// The metadata records of Tweeze, by name.
    pub metadata: BTreeMap<&'static str, BTreeMap<String, String>>,
    pub series: Vec<Series>,
}

/// A file inside the log.
pub struct Attachment<'a> {
    pub offset: u64,
    pub name: String,
    pub data: &'a [u8],
}

/// Called with the topic, the instant and the bytes of every message, in file order.
pub type Visitor<'v> = dyn FnMut(&str, u64, &[u8]) + 'v;

/// State of the reader: message types and topics found, and amounts read.
struct RecordsState<'v> {
    visit: &'v mut Visitor<'v>,
    schemas: BTreeMap<u16, RecordSchema>,
    topics: BTreeMap<u16, SeriesTopic>,
    data_bytes: u64,
    /// Bytes of message types and topics, each counted once.
    definition_bytes: u64,
    messages: u64,
}

impl RecordsState<'_> {
    /// Counts a definition that is stored.
    fn define(&mut self, record: &LogRecord) -> Result<(), LogError> {
        self.definition_bytes += record.body.len() as u64;
        let (bytes, limit) = (self.definition_bytes, MAX_DEFINITION_BYTES);
        match bytes > limit {
            true => {
                let what = "the sum of the definitions".to_owned();
                Err(LogError::TooLarge { offset: record.offset(), what, bytes, limit })
            }
            false => Ok(()),
        }
    }
}

#[derive(PartialEq)]
struct RecordSchema {
    name: String,
    encoding: String,
    descriptor: Vec<u8>,
}

/// A topic, and the series that its messages go to if it is one of channels.
struct SeriesTopic {
    name: String,
    definition: Vec<u8>,
    series: Option<(usize, Decoder)>,
}

/// Reads a whole file.
pub fn read<'a, 'v>(bytes: &'a [u8], visit: &'v mut Visitor<'v>) -> Result<Contents<'a>, LogError> {
    if !bytes.starts_with(mcap::MAGIC) {
        return Err(LogError::NotALog);
    }
    let mut contents = Contents::default();
    let (schemas, topics) = (BTreeMap::new(), BTreeMap::new());
    let mut state = RecordsState { visit, schemas, topics, data_bytes: 0, definition_bytes: 0, messages: 0 };
    let mut records = Records { bytes, at: mcap::MAGIC.len(), base: 0 };
    loop {
        let record = records.next()?;
        if record.opcode == op::DATA_END {
            check_crc(&bytes[..record.start], RecordFields::of(&record).u32()?, &record, "the data section")?;
            break;
        }
        take(&record, &mut contents, &mut state)?;
    }
    check_summary(&mut records)?;
    Ok(contents)
}

/// Reads to the end of the file. The summary gives viewers fast access; only its checksum matters here.
fn check_summary(records: &mut Records) -> Result<(), LogError> {
    let start = records.at;
    loop {
        let record = records.next()?;
        if record.opcode != op::FOOTER {
            continue;
        }
        let mut fields = RecordFields::of(&record);
        fields.skip(16)?;
        let covered = &records.bytes[start..record.start + RECORD_HEAD_BYTES + 16];
        check_crc(covered, fields.u32()?, &record, "the summary")?;
        let rest = &records.bytes[records.at..];
        return match rest == mcap::MAGIC {
            true => Ok(()),
            false if mcap::MAGIC.starts_with(rest) => Err(LogError::Truncated { offset: records.bytes.len() as u64 }),
            false => Err(LogError::damaged(records.at as u64, "the file does not end as an MCAP log must")),
        };
    }
}

fn check_crc(covered: &[u8], written: u32, record: &LogRecord, what: &str) -> Result<(), LogError> {
    let computed = crc32fast::hash(covered);
    match written {
        0 => Err(LogError::damaged(record.offset(), format!("{what} has no checksum"))),
        _ if written == computed => Ok(()),
        _ => Err(LogError::damaged(
            record.offset(),
            format!("{what} has the checksum {computed:08x}, but {written:08x} is recorded"),
        )),
    }
}

/// Handles one record of the data section.
fn take<'a>(record: &LogRecord<'a>, contents: &mut Contents<'a>, state: &mut RecordsState) -> Result<(), LogError> {
    match record.opcode {
        op::CHUNK => chunk(record, contents, state),
        op::ATTACHMENT => {
            contents.attachments.push(attachment(record)?);
            Ok(())
        }
        op::METADATA => {
            let mut fields = RecordFields::of(record);
            let name = fields.text()?;
            let Some(name) = [METADATA, RECORDING].into_iter().find(|own| *own == name) else { return Ok(()) };
            match contents.metadata.insert(name, fields.map()?) {
                Some(_) => Err(LogError::damaged(record.offset(), format!("a second metadata record `{name}`"))),
                None => Ok(()),
            }
        }
        op::SCHEMA | op::CHANNEL | op::MESSAGE => definition_or_message(record, contents, state),
        op::FOOTER => Err(LogError::damaged(record.offset(), "the data section has no end")),
        _ => Ok(()),
    }
}

fn attachment<'a>(record: &LogRecord<'a>) -> Result<Attachment<'a>, LogError> {
    let mut fields = RecordFields::of(record);
    fields.skip(16)?;
    let name = fields.text()?.to_owned();
    fields.text()?;
    let length = fields.u64()?;
    let data = fields.take(length)?;
    let covered = &record.body[..fields.at];
    let what = format!("the attachment `{name}`");
    check_crc(covered, fields.u32()?, record, &what)?;
    fields.end()?;
    Ok(Attachment { offset: record.offset(), name, data })
}

fn chunk<'a>(record: &LogRecord<'a>, contents: &mut Contents<'a>, state: &mut RecordsState) -> Result<(), LogError> {
    let mut fields = RecordFields::of(record);
    fields.skip(16)?;
    let (size, crc) = (fields.u64()?, fields.u32()?);
    let compression = fields.text()?.to_owned();
    let length = fields.u64()?;
    let packed = fields.take(length)?;
    fields.end()?;
    state.data_bytes = state.data_bytes.saturating_add(size);
    for (what, bytes, limit) in
        [("a chunk", size, MAX_CHUNK_BYTES), ("the sum of the chunks", state.data_bytes, MAX_DATA_BYTES)]
    {
        if bytes > limit {
            return Err(LogError::TooLarge { offset: record.offset(), what: what.to_owned(), bytes, limit });
        }
    }
    let data = match compression.as_str() {
        "" => Cow::Borrowed(packed),
        "zstd" => Cow::Owned(
            zstd::bulk::decompress(packed, size as usize)
                .map_err(|error| LogError::damaged(record.offset(), format!("a chunk cannot be unpacked: {error}")))?,
        ),
        _ => return Err(LogError::damaged(record.offset(), format!("compression `{compression}` is not supported"))),
    };
    if data.len() as u64 != size {
        let what = format!("a chunk unpacks to {} bytes, but {size} are declared", data.len());
        return Err(LogError::damaged(record.offset(), what));
    }
    check_crc(&data, crc, record, "a chunk")?;
    let mut records = Records { bytes: &data, at: 0, base: record.offset() };
    while records.at < data.len() {
        let inner = records.next().map_err(|_| LogError::damaged(record.offset(), "a chunk ends within a record"))?;
        definition_or_message(&inner, contents, state)?;
    }
    Ok(())
}

fn definition_or_message(
    record: &LogRecord,
    contents: &mut Contents,
    state: &mut RecordsState,
) -> Result<(), LogError> {
    match record.opcode {
        op::SCHEMA => schema(record, state),
        op::CHANNEL => topic(record, contents, state),
        op::MESSAGE => message(record, contents, state),
        _ => Err(LogError::damaged(record.offset(), "a record that does not belong in a chunk")),
    }
}

fn schema(record: &LogRecord, state: &mut RecordsState) -> Result<(), LogError> {
    let mut fields = RecordFields::of(record);
    let id = fields.u16()?;
    let (name, encoding) = (fields.text()?.to_owned(), fields.text()?.to_owned());
    let length = u64::from(fields.u32()?);
    let descriptor = fields.take(length)?.to_vec();
    fields.end()?;
    let schema = RecordSchema { name, encoding, descriptor };
    // Writers repeat the definition in every chunk.
    match state.schemas.get(&id) {
        Some(known) if *known != schema => {
            Err(LogError::damaged(record.offset(), format!("a second message type number {id}")))
        }
        Some(_) => Ok(()),
        None => {
            state.define(record)?;
            state.schemas.insert(id, schema);
            Ok(())
        }
    }
}

fn topic(record: &LogRecord, contents: &mut Contents, state: &mut RecordsState) -> Result<(), LogError> {
    let mut fields = RecordFields::of(record);
    let (id, schema) = (fields.u16()?, fields.u16()?);
    if let Some(known) = state.topics.get(&id) {
        // Writers repeat the definition in every chunk.
        return match known.definition == record.body {
            true => Ok(()),
            false => Err(LogError::damaged(record.offset(), format!("a second topic number {id}"))),
        };
    }
    state.define(record)?;
    let (name, encoding) = (fields.text()?.to_owned(), fields.text()?.to_owned());
    let metadata = fields.map()?;
    fields.end()?;
    let mut series = None;
    if super::is_topic(&name) {
        let schema =
            state.schemas.get(&schema).filter(|schema| schema.encoding == "protobuf" && encoding == "protobuf");
        let schema =
            schema.ok_or_else(|| LogError::content(format!("topic `{name}`"), "it has no protobuf messages"))?;
        let (decoder, columns) = series::decoder(&schema.name, &schema.descriptor, &metadata)
            .map_err(|what| LogError::content(format!("topic `{name}`"), what))?;
        if contents.series.iter().any(|series| series.topic == name) {
            return Err(LogError::damaged(record.offset(), format!("a second topic `{name}`")));
        }
        let (devices, limit) = (contents.series.len() as u64 + 1, MAX_DEVICES);
        if devices > limit {
            let what = "the number of topics of channels".to_owned();
            return Err(LogError::TooLarge { offset: record.offset(), what, bytes: devices, limit });
        }
        series = Some((contents.series.len(), decoder));
        contents.series.push(Series { topic: name.clone(), columns, samples: Samples::default() });
    }
    state.topics.insert(id, SeriesTopic { name, definition: record.body.to_vec(), series });
    Ok(())
}

fn message(record: &LogRecord, contents: &mut Contents, state: &mut RecordsState) -> Result<(), LogError> {
    state.messages += 1;
    if state.messages > MAX_MESSAGES {
        let (bytes, limit) = (state.messages, MAX_MESSAGES);
        return Err(LogError::TooLarge {
            offset: record.offset(),
            what: "the number of messages".into(),
            bytes,
            limit,
        });
    }
    let mut fields = RecordFields::of(record);
    let id = fields.u16()?;
    fields.skip(4)?;
    let t_ns = fields.u64()?;
    fields.skip(8)?;
    let Some(topic) = state.topics.get(&id) else {
        return Err(LogError::damaged(record.offset(), format!("a message of the unknown topic number {id}")));
    };
    (state.visit)(&topic.name, t_ns, &record.body[fields.at..]);
    let Some((index, decoder)) = &topic.series else { return Ok(()) };
    let series = &mut contents.series[*index];
    let place = || format!("topic `{}` at {t_ns} ns", topic.name);
    let values = decoder.decode(&record.body[fields.at..]).map_err(|what| LogError::content(place(), what))?;
    if series.samples.times_ns().last().is_some_and(|last_ns| *last_ns >= t_ns) {
        return Err(LogError::content(place(), "it must be later than the message before it"));
    }
    series.samples.push(t_ns, &values);
    Ok(())
}

/// Iterates over the records of a file or a chunk.
struct Records<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Offset of the chunk in the file; 0 for the file itself.
    base: u64,
}

struct LogRecord<'a> {
    opcode: u8,
    start: usize,
    base: u64,
    body: &'a [u8],
}

impl LogRecord<'_> {
    /// Offset of the record in the file; within a compressed chunk, the offset of the chunk.
    fn offset(&self) -> u64 {
        if self.base > 0 { self.base } else { self.start as u64 }
    }
}

impl<'a> Records<'a> {
    fn next(&mut self) -> Result<LogRecord<'a>, LogError> {
        let start = self.at;
        let rest = &self.bytes[start..];
        let truncated = LogError::Truncated { offset: self.bytes.len() as u64 };
        let Some((head, rest)) = rest.split_first_chunk::<RECORD_HEAD_BYTES>() else { return Err(truncated) };
        let [opcode, length @ ..] = *head;
        let length = usize::try_from(u64::from_le_bytes(length)).unwrap_or(usize::MAX);
        let Some(body) = rest.get(..length) else { return Err(truncated) };
        self.at = start + RECORD_HEAD_BYTES + length;
        Ok(LogRecord { opcode, start, base: self.base, body })
    }
}

/// Iterates over the fields of a record.
struct RecordFields<'a> {
    body: &'a [u8],
    at: usize,
    offset: u64,
}

impl<'a> RecordFields<'a> {
    fn of(record: &LogRecord<'a>) -> Self {
        RecordFields { body: record.body, at: 0, offset: record.offset() }
    }

    fn take(&mut self, length: u64) -> Result<&'a [u8], LogError> {
        let end = usize::try_from(length).ok().and_then(|length| self.at.checked_add(length));
        let part = end.and_then(|end| self.body.get(self.at..end));
        let part = part.ok_or_else(|| LogError::damaged(self.offset, "a field reaches beyond its record"))?;
        self.at += part.len();
        Ok(part)
    }

    fn skip(&mut self, length: u64) -> Result<(), LogError> {
        self.take(length).map(|_| ())
    }

    fn number<const N: usize>(&mut self) -> Result<[u8; N], LogError> {
        let part = self.take(N as u64)?;
        Ok(part.try_into().expect("as many bytes as were asked for"))
    }

    fn u16(&mut self) -> Result<u16, LogError> {
        self.number().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Result<u32, LogError> {
        self.number().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, LogError> {
        self.number().map(u64::from_le_bytes)
    }

    fn text(&mut self) -> Result<&'a str, LogError> {
        let length = u64::from(self.u32()?);
        let part = self.take(length)?;
        std::str::from_utf8(part).map_err(|_| LogError::damaged(self.offset, "a name is not UTF-8"))
    }

    fn map(&mut self) -> Result<BTreeMap<String, String>, LogError> {
        let length = u64::from(self.u32()?);
        if length > MAX_MAP_BYTES {
            let (offset, what, limit) = (self.offset, "a map".to_owned(), MAX_MAP_BYTES);
            return Err(LogError::TooLarge { offset, what, bytes: length, limit });
        }
        let part = self.take(length)?;
        let mut entries = RecordFields { body: part, at: 0, offset: self.offset };
        let mut map = BTreeMap::new();
        while entries.at < part.len() {
            let (key, value) = (entries.text()?, entries.text()?);
            if map.insert(key.to_owned(), value.to_owned()).is_some() {
                return Err(LogError::damaged(self.offset, format!("the entry `{key}` occurs twice")));
            }
        }
        Ok(map)
    }

    fn end(&self) -> Result<(), LogError> {
        match self.at == self.body.len() {
            true => Ok(()),
            false => Err(LogError::damaged(self.offset, "a record is longer than its fields")),
        }
    }
}
