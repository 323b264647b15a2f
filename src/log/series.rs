//! Recorded voltages and positions: decodes their messages and compares them with the schedule.

use super::{BOUND_SUFFIX, PERIOD_SUFFIX};
use crate::schedule::{Actuation, Channel, ChannelUnit, Schedule, Swing};
use prost::Message;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorSet};
use std::collections::{BTreeMap, BTreeSet};

/// Largest message type that is read, in bytes; decoding one takes some hundred times as much memory.
pub const MAX_DESCRIPTOR_BYTES: usize = 64 * 1024;

/// Tolerance of a value on a slope, relative to the larger end: the rounding of a few operations.
const SLOPE_ROUNDING: f64 = 1e-12;

/// The recorded channels of a device.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// The topic of the series.
    pub topic: String,
    pub columns: Vec<SeriesColumn>,
    pub samples: Samples,
}

/// Increasing instants, with a value for each column. A log may have millions, so they are stored in two flat lists.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Samples {
    times_ns: Vec<u64>,
    /// The values of the first instant, then those of the next.
    values: Vec<f64>,
}

impl Samples {
    /// Adds an instant with its values; their number is the same for all instants.
    pub fn push(&mut self, t_ns: u64, values: &[f64]) {
        self.times_ns.push(t_ns);
        self.values.extend_from_slice(values);
    }

    /// The instants.
    pub fn times_ns(&self) -> &[u64] {
        &self.times_ns
    }

    /// The values of an instant.
    pub fn at(&self, index: usize) -> &[f64] {
        let width = self.values.len() / self.times_ns.len().max(1);
        &self.values[index * width..(index + 1) * width]
    }

    /// Every instant with its values.
    pub fn iter(&self) -> impl Iterator<Item = (u64, &[f64])> {
        self.times_ns.iter().enumerate().map(|(index, t_ns)| (*t_ns, self.at(index)))
    }
}

/// Meaning of one of the numbers in each message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SeriesColumn {
    /// Full name of the channel: `bot.bl4.set`.
    pub channel: String,
    pub bound: Bound,
    /// The periods of the channel's drive trains, as written in the log; empty for an exact value.
    pub periods_ns: String,
}

/// Relation of a recorded number to the value of its channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bound {
    /// The value itself.
    Exact,
    /// The lower level during a drive train, otherwise the value.
    Low,
    /// The higher level during a drive train, otherwise the value.
    High,
}

impl Bound {
    /// Its name in the metadata of a topic and in the names of its fields.
    pub fn name(self) -> Option<&'static str> {
        match self {
            Bound::Exact => None,
            Bound::Low => Some("low"),
            Bound::High => Some("high"),
        }
    }

    fn read(word: Option<&String>) -> Option<Bound> {
        [Bound::Exact, Bound::Low, Bound::High].into_iter().find(|bound| bound.name() == word.map(String::as_str))
    }
}

/// Decoder for the values of a message.
#[derive(Debug)]
pub enum Decoder {
    /// One field for each channel: from a field's number to the index of its channel.
    Fields(BTreeMap<u64, usize>),
    /// All channels in this field, as a packed list.
    List { number: u64, count: usize },
}

/// The decoder of a message type, with the meaning of each number, which the topic's metadata give for each field.
pub fn decoder(
    name: &str,
    descriptor: &[u8],
    metadata: &BTreeMap<String, String>,
) -> Result<(Decoder, Vec<SeriesColumn>), String> {
    if descriptor.len() > MAX_DESCRIPTOR_BYTES {
        return Err(format!(
            "it has a message type of {} bytes; the limit is {MAX_DESCRIPTOR_BYTES}",
            descriptor.len()
        ));
    }
    let set = FileDescriptorSet::decode(descriptor).map_err(|error| format!("it has no message type: {error}"))?;
    let message = find(&set, name).ok_or_else(|| format!("it has no message type `{name}`"))?;
    if let [field] = message.field.as_slice()
        && field.label() == Label::Repeated
    {
        let number = number(field)?;
        let path = |index: usize| format!("{}[{index}]", field.name());
        let paths = (0..).map(path).take_while(|path| metadata.contains_key(path));
        let columns = paths.map(|path| column(&path, metadata)).collect::<Result<Vec<_>, _>>()?;
        return Ok((Decoder::List { number, count: columns.len() }, columns));
    }
    let mut fields = BTreeMap::new();
    let mut columns = Vec::new();
    for field in &message.field {
        columns.push(column(field.name(), metadata)?);
        if field.label() != Label::Optional || fields.insert(number(field)?, columns.len() - 1).is_some() {
            return Err(format!("it has a field `{}` that does not hold a single value", field.name()));
        }
    }
    Ok((Decoder::Fields(fields), columns))
}

fn column(path: &str, metadata: &BTreeMap<String, String>) -> Result<SeriesColumn, String> {
    let channel = metadata.get(path).ok_or_else(|| format!("it does not name the channel of `{path}`"))?.clone();
    let bound = Bound::read(metadata.get(&format!("{path}{BOUND_SUFFIX}")));
    let bound = bound.ok_or_else(|| format!("it does not name the drive level of `{path}`"))?;
    let periods_ns = metadata.get(&format!("{path}{PERIOD_SUFFIX}")).cloned().unwrap_or_default();
    Ok(SeriesColumn { channel, bound, periods_ns })
}

fn find<'a>(set: &'a FileDescriptorSet, name: &str) -> Option<&'a DescriptorProto> {
    set.file.iter().find_map(|file| {
        let short = name.strip_prefix(file.package())?.strip_prefix('.')?;
        file.message_type.iter().find(|message| message.name() == short)
    })
}

fn number(field: &FieldDescriptorProto) -> Result<u64, String> {
    match u64::try_from(field.number()) {
        Ok(number) if number > 0 && field.r#type() == Type::Double => Ok(number),
        Ok(_) | Err(_) => Err(format!("it has a field `{}` that is not a double", field.name())),
    }
}

/// Protobuf wire types.
const FIXED64: u64 = 1;
const LENGTH_DELIMITED: u64 = 2;

impl Decoder {
    /// The values of a message. Every channel must be present exactly once.
    pub fn decode(&self, mut bytes: &[u8]) -> Result<Vec<f64>, String> {
        match self {
            Decoder::Fields(fields) => {
                let mut values = vec![None; fields.len()];
                while !bytes.is_empty() {
                    let key = varint(&mut bytes)?;
                    let field = fields.get(&(key >> 3)).filter(|_| key & 7 == FIXED64);
                    let value = &mut values[*field.ok_or_else(|| format!("it has an unknown field {}", key >> 3))?];
                    if value.replace(double(&mut bytes)?).is_some() {
                        return Err(format!("it has field {} twice", key >> 3));
                    }
                }
                values
                    .into_iter()
                    .collect::<Option<_>>()
                    .ok_or_else(|| "it does not have a value for every channel".to_owned())
            }
            Decoder::List { number, count } => {
                if *count == 0 && bytes.is_empty() {
                    return Ok(Vec::new());
                }
                let key = varint(&mut bytes)?;
                let length = varint(&mut bytes)?;
                if key != number << 3 | LENGTH_DELIMITED || length != 8 * *count as u64 || bytes.len() as u64 != length
                {
                    return Err(format!("it is not a list of {count} values"));
                }
                (0..*count).map(|_| double(&mut bytes)).collect()
            }
        }
    }
}

fn varint(bytes: &mut &[u8]) -> Result<u64, String> {
    prost::encoding::decode_varint(bytes).map_err(|error| error.to_string())
}

fn double(bytes: &mut &[u8]) -> Result<f64, String> {
    let (value, rest) = bytes.split_first_chunk::<8>().ok_or("it breaks off within a value")?;
    *bytes = rest;
    Ok(f64::from_le_bytes(*value))
}

/// Difference between the recorded voltages or positions and the schedule.
#[derive(Debug, Clone, PartialEq)]
pub enum SeriesFault {
    /// The channels of a device are not recorded, or channels are recorded that the schedule does not have.
    Topic { topic: String },
    /// The channels of a topic are not those of the device, in order.
    Channels { topic: String },
    /// A value differs.
    Value { channel: String, unit: ChannelUnit, t_ns: u64, recorded: f64, scheduled: f64 },
    /// A jump or an end is not recorded, so that a plot would show something else.
    Gap { topic: String, t_ns: u64 },
}

impl std::fmt::Display for SeriesFault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            SeriesFault::Topic { topic } => write!(f, "`{topic}` is missing or superfluous"),
            SeriesFault::Channels { topic } => write!(f, "`{topic}` has other channels"),
            SeriesFault::Value { channel, unit, t_ns, recorded, scheduled } => {
                let unit = unit.symbol();
                write!(f, "`{channel}` at {t_ns} ns has {recorded} {unit} instead of {scheduled} {unit}")
            }
            SeriesFault::Gap { topic, t_ns } => write!(f, "`{topic}` has no message at {t_ns} ns"),
        }
    }
}

/// The first difference between recorded voltages and positions and a schedule.
///
/// If there is none, linear interpolation between the messages of a topic gives the channels of its device at every
/// nanosecond, or the two levels between which they swing: every instant at which a value jumps or bends is recorded,
/// as are the instant before it, 0 and the end.
pub fn fault(schedule: &Schedule, recorded: &[Series]) -> Option<SeriesFault> {
    let topics: BTreeSet<String> = schedule.channels.iter().map(topic).collect();
    let by_channel = schedule.by_channel();
    for topic in &topics {
        match recorded.iter().find(|series| series.topic == *topic) {
            Some(series) => {
                if let Some(fault) = topic_fault(schedule, &by_channel, series) {
                    return Some(fault);
                }
            }
            None => return Some(SeriesFault::Topic { topic: topic.clone() }),
        }
    }
    let extra = recorded.iter().find(|series| !topics.contains(&series.topic))?;
    Some(SeriesFault::Topic { topic: extra.topic.clone() })
}

/// The topic in which a channel is recorded.
fn topic(channel: &Channel) -> String {
    super::topic(&channel.device, channel.unit)
}

fn topic_fault(schedule: &Schedule, by_channel: &[Vec<&Actuation>], series: &Series) -> Option<SeriesFault> {
    let channels = schedule.channels.iter().zip(by_channel).filter(|(channel, _)| topic(channel) == series.topic);
    let columns: Vec<(SeriesColumn, &Channel, &[&Actuation])> = channels
        .flat_map(|(channel, actuations)| {
            columns(&channel.name, actuations).map(move |column| (column, channel, &actuations[..]))
        })
        .collect();
    if !columns.iter().map(|(column, ..)| column).eq(&series.columns) {
        return Some(SeriesFault::Channels { topic: series.topic.clone() });
    }
    let mut columns = columns.iter().enumerate();
    columns.find_map(|(index, (column, channel, actuations))| {
        column_fault(schedule, series, index, column, channel, actuations)
    })
}

/// The columns required for a channel.
fn columns(channel: &str, actuations: &[&Actuation]) -> impl Iterator<Item = SeriesColumn> {
    let swings = actuations.iter().filter_map(|actuation| actuation.swing);
    let periods: BTreeSet<u64> = swings.map(|swing| swing.period_ns).collect();
    let periods_ns = periods.iter().map(u64::to_string).collect::<Vec<_>>().join(" ");
    let bounds: &[Bound] = if periods.is_empty() { &[Bound::Exact] } else { &[Bound::Low, Bound::High] };
    let column =
        |bound: &Bound| SeriesColumn { channel: channel.to_owned(), bound: *bound, periods_ns: periods_ns.clone() };
    bounds.iter().map(column).collect::<Vec<_>>().into_iter()
}

fn column_fault(
    schedule: &Schedule,
    series: &Series,
    index: usize,
    column: &SeriesColumn,
    channel: &Channel,
    actuations: &[&Actuation],
) -> Option<SeriesFault> {
    if let Some(fault) = gap(schedule.duration_ns, series, actuations) {
        return Some(fault);
    }
    let mut next = 0;
    for (t_ns, values) in series.samples.iter() {
        while actuations.get(next).is_some_and(|actuation| actuation.end_ns() <= t_ns) {
            next += 1;
        }
        let running = actuations.get(next).filter(|actuation| actuation.start_ns <= t_ns);
        let scheduled = running
            .map_or_else(|| (rest(channel, actuations, next), 0.0), |actuation| value(actuation, column.bound, t_ns));
        let recorded = values[index];
        let agrees = (recorded - scheduled.0).abs() <= scheduled.1;
        if !agrees {
            let (channel, unit, scheduled) = (column.channel.clone(), channel.unit, scheduled.0);
            return Some(SeriesFault::Value { channel, unit, t_ns, recorded, scheduled });
        }
    }
    None
}

/// The value between actuations, after the first `over` of them: a stage stays at its last position or, before its
/// first actuation, at the position where that begins.
fn rest(channel: &Channel, actuations: &[&Actuation], over: usize) -> f64 {
    match channel.unit {
        ChannelUnit::Volt => channel.rest_v,
        ChannelUnit::Micrometre => match over.checked_sub(1) {
            Some(last) => actuations[last].to,
            None => actuations.first().map_or(0.0, |first| first.from),
        },
    }
}

/// The value of an actuation at an instant within it, and its tolerance.
fn value(actuation: &Actuation, bound: Bound, t_ns: u64) -> (f64, f64) {
    let Actuation { start_ns, duration_ns, from, to, swing, .. } = *actuation;
    match (swing, bound) {
        (Some(Swing { levels: [a, b], .. }), Bound::Low) => return (a.min(b), 0.0),
        (Some(Swing { levels: [a, b], .. }), Bound::High) => return (a.max(b), 0.0),
        (Some(_), Bound::Exact) | (None, _) => {}
    }
    if from == to {
        return (from, 0.0);
    }
    let passed = (t_ns - start_ns) as f64 / duration_ns as f64;
    (from * (1.0 - passed) + to * passed, SLOPE_ROUNDING * from.abs().max(to.abs()))
}

/// The first instant that must be recorded and is not.
fn gap(duration_ns: u64, series: &Series, actuations: &[&Actuation]) -> Option<SeriesFault> {
    let edges = actuations.iter().flat_map(|actuation| [actuation.start_ns, actuation.end_ns()]);
    let times = edges.flat_map(|t_ns| [t_ns.saturating_sub(1), t_ns]).chain([0, duration_ns]);
    let recorded = |t_ns: &u64| series.samples.times_ns().binary_search(t_ns).is_ok();
    let missing = times.into_iter().find(|t_ns| !recorded(t_ns));
    missing.map(|t_ns| SeriesFault::Gap { topic: series.topic.clone(), t_ns })
}
