use super::*;
use crate::diagnostic::Code;
use crate::emit::fixture::FixtureSchedule;
use crate::emit::{Format, emit, fixture};
use mcap::records::op;
use proptest::prelude::*;
use prost::Message;
use std::collections::BTreeSet;

fn written(fixture: &FixtureSchedule) -> Vec<u8> {
    emit(Format::Mcap, &fixture.verified, &fixture.provenance).expect("the fixture can be written").remove(0).bytes
}

fn code(bytes: &[u8]) -> Code {
    read(bytes).expect_err("the log is broken").diagnostic().code
}

#[test]
fn a_log_comes_back_as_it_was() {
    for make in
        [fixture::fetch, fixture::pair, fixture::large, fixture::idle, fixture::crowd, fixture::bed, fixture::paces]
    {
        let fixture = make();
        let log = read(&written(&fixture)).unwrap();
        let FixtureSchedule { verified, provenance } = fixture;
        assert_eq!(&log.schedule, verified.schedule());
        assert_eq!(log.claims, write_claims(verified.claims()).unwrap());
        assert_eq!((log.files.clone(), log.settings.clone()), (provenance.files, provenance.settings));
        assert_eq!(log.version, env!("CARGO_PKG_VERSION"));
        assert_eq!(log.series_fault(), None);
    }
}

#[test]
fn the_log_of_many_messages_has_several_chunks() {
    let bytes = written(&fixture::large());
    let chunks = mcap::read::LinearReader::new(&bytes).unwrap();
    let chunks = chunks.filter(|record| matches!(record, Ok(mcap::records::Record::Chunk { .. }))).count();
    assert!(chunks > 1, "{chunks} chunks: the fixture is too small for this test");
}

#[test]
fn a_log_cut_anywhere_breaks_off() {
    let bytes = written(&fixture::idle());
    for end in (0..bytes.len()).filter(|end| *end < 64 || end % 97 == 0 || *end > bytes.len() - 64) {
        let expected = if end < mcap::MAGIC.len() { Code::E0840 } else { Code::E0841 };
        assert_eq!(code(&bytes[..end]), expected, "cut at {end}");
    }
}

#[test]
fn any_changed_byte_is_found() {
    let good = written(&fixture::idle());
    for at in (0..good.len()).filter(|at| *at < 64 || at % 61 == 0 || *at > good.len() - 256) {
        let mut bytes = good.clone();
        bytes[at] ^= 1 << (at % 8);
        assert!(read(&bytes).is_err(), "byte {at}");
    }
}

#[test]
fn more_bytes_after_the_end_are_damage() {
    let mut bytes = written(&fixture::idle());
    bytes.push(0);
    assert_eq!(code(&bytes), Code::E0842);
}

/// A record with opcode and length.
fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    [&[opcode], (body.len() as u64).to_le_bytes().as_slice(), body].concat()
}

/// A complete file around the records of a data section, with correct checksums.
fn file(records: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = [mcap::MAGIC, &record(op::HEADER, &[0; 8]), &records.concat()].concat();
    let crc = crc32fast::hash(&bytes);
    bytes.extend(record(op::DATA_END, &crc.to_le_bytes()));
    let footer = record(op::FOOTER, &[0; 20]);
    let crc = crc32fast::hash(&footer[..footer.len() - 4]);
    bytes.extend(&footer[..footer.len() - 4]);
    bytes.extend(crc.to_le_bytes());
    bytes.extend(mcap::MAGIC);
    bytes
}

fn chunk(size: u64, crc: u32, compression: &str, data: &[u8]) -> Vec<u8> {
    let mut body = vec![0; 16];
    body.extend(size.to_le_bytes());
    body.extend(crc.to_le_bytes());
    body.extend((compression.len() as u32).to_le_bytes());
    body.extend(compression.as_bytes());
    body.extend((data.len() as u64).to_le_bytes());
    body.extend(data);
    record(op::CHUNK, &body)
}

#[test]
fn a_file_of_nothing_lacks_the_schedule() {
    assert_eq!(read(&file(&[])), Err(LogError::Missing { what: "attachment `schedule.json`".into() }));
    assert_eq!(code(&file(&[])), Code::E0844);
}

#[test]
fn bombs_are_refused_before_they_are_unpacked() {
    const LIMIT: u64 = MAX_MESSAGE_BYTES + MAX_MESSAGE_BYTES / 4;
    let zeros = zstd::bulk::compress(&vec![0; 1 << 20], 3).unwrap();
    assert!(zeros.len() < 200);
    for size in [LIMIT + 1, u64::MAX] {
        assert_eq!(code(&file(&[chunk(size, 1, "zstd", &zeros)])), Code::E0843);
    }
    for size in [LIMIT, (1 << 20) + 1, (1 << 20) - 1, 0] {
        assert_eq!(code(&file(&[chunk(size, 1, "zstd", &zeros)])), Code::E0842);
    }
    let empty = crc32fast::hash(&vec![0; 1 << 20]);
    let many = vec![chunk(1 << 20, empty, "zstd", &zeros); 600];
    assert_eq!(code(&file(&many)), Code::E0842, "the first chunk holds no records");
}

#[test]
fn the_sum_of_the_chunks_is_limited() {
    // Messages of a topic that is not read, after its definition, which each chunk repeats.
    let text = |text: &str| [(text.len() as u32).to_le_bytes().as_slice(), text.as_bytes()].concat();
    let topic = record(op::CHANNEL, &[vec![1, 0, 0, 0], text("a"), text("protobuf"), vec![0; 4]].concat());
    let message = record(op::MESSAGE, &[vec![1, 0], vec![0; 20], vec![0; 60 << 20]].concat());
    let data = [topic, message].concat();
    let packed = zstd::bulk::compress(&data, 1).unwrap();
    let chunk = chunk(data.len() as u64, crc32fast::hash(&data), "zstd", &packed);
    assert_eq!(code(&file(&vec![chunk.clone(); 34])), Code::E0844, "2,040 MiB are read");
    assert_eq!(code(&file(&vec![chunk; 35])), Code::E0843, "2,100 MiB are not");
}

#[test]
fn the_number_of_devices_is_limited() {
    let text = |text: &str| [(text.len() as u32).to_le_bytes().as_slice(), text.as_bytes()].concat();
    let message = prost_types::DescriptorProto { name: Some("V".into()), ..Default::default() };
    let proto = prost_types::FileDescriptorProto {
        package: Some("a".into()),
        message_type: vec![message],
        ..Default::default()
    };
    let descriptor = prost_types::FileDescriptorSet { file: vec![proto] }.encode_to_vec();
    let length = (descriptor.len() as u32).to_le_bytes().to_vec();
    let schema = record(op::SCHEMA, &[vec![1, 0], text("a.V"), text("protobuf"), length, descriptor].concat());
    let topic = |id: u16| {
        let body =
            [id.to_le_bytes().to_vec(), vec![1, 0], text(&format!("/d{id}/voltages")), text("protobuf"), vec![0; 4]];
        record(op::CHANNEL, &body.concat())
    };
    let devices = |count: u64| {
        let topics = (0..count as u16).map(topic);
        code(&file(&std::iter::once(schema.clone()).chain(topics).collect::<Vec<_>>()))
    };
    assert_eq!(devices(MAX_DEVICES), Code::E0844);
    assert_eq!(devices(MAX_DEVICES + 1), Code::E0843);
}

#[test]
fn lengths_that_reach_beyond_are_damage() {
    let huge = u32::MAX.to_le_bytes();
    let attachment = [&[0; 16], huge.as_slice()].concat();
    let long = [vec![0; 24], u64::MAX.to_le_bytes().to_vec(), vec![0; 4]].concat();
    let topic = [&[1, 0, 0, 0], huge.as_slice()].concat();
    let cases = [
        record(op::ATTACHMENT, &attachment),
        record(op::ATTACHMENT, &long),
        record(op::ATTACHMENT, &[]),
        record(op::METADATA, &huge),
        record(op::CHANNEL, &topic),
        record(op::SCHEMA, &[]),
        record(op::MESSAGE, &[9; 22]),
        chunk(9, 0, "", &[9; 9]),
        chunk(4, 1, "lz4", &[9; 4]),
        chunk(4, crc32fast::hash(&[9; 4]), "", &[9; 4]),
    ];
    for case in cases {
        assert_eq!(code(&file(std::slice::from_ref(&case))), Code::E0842, "{case:?}");
    }
    let mut bytes = file(&[]);
    let at = mcap::MAGIC.len() + 1;
    bytes[at..at + 8].fill(0xff);
    assert_eq!(code(&bytes), Code::E0841);
}

#[test]
fn parts_without_a_checksum_are_damage() {
    let mut bytes = written(&fixture::idle());
    let end = bytes.len() - mcap::MAGIC.len();
    bytes[end - 4..end].fill(0);
    let Err(LogError::Damaged { what, .. }) = read(&bytes) else { panic!("a missing checksum is damage") };
    assert_eq!(what, "the summary has no checksum");
}

fn fault(change: impl FnOnce(&mut Log)) -> Option<SeriesFault> {
    let mut log = read(&written(&fixture::pair())).unwrap();
    change(&mut log);
    log.series_fault()
}

/// Changes the samples of a topic.
fn sampled(log: &mut Log, topic: usize, change: impl FnOnce(&mut Vec<(u64, Vec<f64>)>)) {
    let samples = &mut log.series[topic].samples;
    let mut list = samples.iter().map(|(t_ns, values)| (t_ns, values.to_vec())).collect();
    change(&mut list);
    *samples = Samples::default();
    list.into_iter().for_each(|(t_ns, values)| samples.push(t_ns, &values));
}

#[test]
fn every_recorded_voltage_counts() {
    let value = |log: &mut Log, volts: f64| {
        sampled(log, 0, |samples| {
            let sample = samples.iter_mut().find(|(t_ns, _)| *t_ns == 15_000_000).expect("an edge");
            sample.1[0] = volts;
        });
    };
    assert_eq!(fault(|log| value(log, 0.0)), None);
    let Some(SeriesFault::Value { channel, t_ns, recorded, scheduled, .. }) = fault(|log| value(log, 1e-300)) else {
        panic!("a value that is not in the schedule is found")
    };
    assert_eq!((channel.as_str(), t_ns, recorded, scheduled), ("bot.bl0.set", 15_000_000, 1e-300, 0.0));
    assert!(matches!(fault(|log| value(log, f64::NAN)), Some(SeriesFault::Value { .. })));
}

#[test]
fn every_jump_is_recorded() {
    let log = read(&written(&fixture::pair())).unwrap();
    let device = log.series[1].topic.split('/').nth(1).expect("a topic of a device").to_owned();
    let own = log.schedule.actuations.iter().filter(|act| log.schedule.channels[act.channel as usize].device == device);
    let edges: BTreeSet<u64> = own.flat_map(|act| [act.start_ns, act.end_ns()]).collect();
    let times = edges.iter().flat_map(|t_ns| [t_ns.saturating_sub(1), *t_ns]).chain([0, log.schedule.duration_ns]);
    let needed: BTreeSet<u64> = times.collect();
    assert!(needed.len() > 20);
    let without = |t_ns: u64| fault(|log| sampled(log, 1, |samples| samples.retain(|(other_ns, _)| *other_ns != t_ns)));
    for t_ns in &needed {
        let fault = without(*t_ns);
        assert!(matches!(fault, Some(SeriesFault::Gap { .. })), "sample at {t_ns} ns: {fault:?}");
    }
    let beat_ns = *log.series[1].samples.times_ns().iter().find(|t_ns| !needed.contains(t_ns)).expect("a beat");
    assert_eq!(without(beat_ns), None, "a beat says nothing new");
    let again = |log: &mut Log| {
        sampled(log, 0, |samples| {
            let values = samples[0].1.clone();
            samples.insert(1, (1, values));
        });
    };
    assert_eq!(fault(again), None, "more messages than needed do no harm");
}

#[test]
fn every_device_and_channel_is_recorded() {
    assert!(matches!(fault(|log| drop(log.series.pop())), Some(SeriesFault::Topic { .. })));
    assert!(matches!(fault(|log| log.series[0].topic.push('x')), Some(SeriesFault::Topic { .. })));
    assert!(matches!(fault(|log| log.series[0].columns.swap(0, 1)), Some(SeriesFault::Channels { .. })));
    let twice = fault(|log| log.series.push(Series { topic: "/ghost/voltages".into(), ..log.series[0].clone() }));
    assert_eq!(twice, Some(SeriesFault::Topic { topic: "/ghost/voltages".into() }));
}

#[test]
fn a_slope_may_be_rounded_but_not_bent() {
    let log = read(&written(&fixture::crowd())).unwrap();
    let bent = |by: f64| {
        let mut log = log.clone();
        sampled(&mut log, 0, |samples| samples.iter_mut().find(|(t_ns, _)| *t_ns == 99).unwrap().1[0] += by);
        log.series_fault()
    };
    assert_eq!(bent(1e-13), None);
    assert!(matches!(bent(1e-10), Some(SeriesFault::Value { t_ns: 99, .. })));
}

#[test]
fn trains_are_recorded_by_both_of_their_levels() {
    let log = read(&written(&fixture::bed())).unwrap();
    let [low, high] = &log.series[0].columns[..] else { panic!("two columns") };
    assert_eq!((low.bound, high.bound), (Bound::Low, Bound::High));
    assert_eq!((low.channel.as_str(), high.periods_ns.as_str()), ("m.bed", "50000"));
    let within = log.series[0].samples.iter().find(|(t_ns, _)| *t_ns == 2_000_000).unwrap();
    assert_eq!(within.1, [115.0, 130.0]);
    assert!(log.series[0].samples.times_ns().len() < 1061, "only breaks and beats are recorded");
    let fault = |change: fn(&mut Log)| {
        let mut log = log.clone();
        change(&mut log);
        log.series_fault()
    };
    let value = fault(|log| sampled(log, 0, |samples| samples.iter_mut().for_each(|one| one.1[0] = one.1[1])));
    assert!(matches!(value, Some(SeriesFault::Value { t_ns: 2_000_000, recorded: 130.0, scheduled: 115.0, .. })));
    let mut gap = log.clone();
    sampled(&mut gap, 0, |samples| samples.retain(|(t_ns, _)| *t_ns != 2_000_000));
    assert!(matches!(gap.series_fault(), Some(SeriesFault::Gap { t_ns: 2_000_000, .. })));
    for change in [
        (|log| log.series[0].columns.swap(0, 1)) as fn(&mut Log),
        |log| log.series[0].columns[0].bound = Bound::Exact,
        |log| log.series[0].columns[1].periods_ns = "40000".into(),
        |log| log.schedule.actuations.retain(|actuation| actuation.swing.is_none()),
    ] {
        assert!(matches!(fault(change), Some(SeriesFault::Channels { .. })));
    }
}

#[test]
fn a_message_says_every_channel_once() {
    let fields = series::Decoder::Fields([(1, 0), (2, 1)].into());
    let value = |number: u8, volts: f64| [vec![number << 3 | 1], volts.to_le_bytes().to_vec()].concat();
    let (a, b) = (value(1, 5.0), value(2, 0.0));
    assert_eq!(fields.decode(&[b.clone(), a.clone()].concat()), Ok(vec![5.0, 0.0]));
    for bad in [vec![], a.clone(), [a.clone(), a.clone(), b.clone()].concat(), [a.clone(), b, value(3, 1.0)].concat()] {
        assert!(fields.decode(&bad).is_err());
    }
    assert!(fields.decode(&a[..5]).is_err());
    let list = series::Decoder::List { number: 1, count: 2 };
    let packed = [vec![1 << 3 | 2, 16], 1f64.to_le_bytes().to_vec(), 2f64.to_le_bytes().to_vec()].concat();
    assert_eq!(list.decode(&packed), Ok(vec![1.0, 2.0]));
    assert!(list.decode(&packed[..17]).is_err());
    assert!(list.decode(&[]).is_err());
}

/// Messages; header and data of each attachment; metadata.
#[derive(Clone)]
struct LogSections {
    messages: Vec<u8>,
    attachments: Vec<(Vec<u8>, Vec<u8>)>,
    metadata: Vec<u8>,
}

/// The records of an intact log: the messages unpacked, then the attachments and the metadata.
fn unpacked() -> LogSections {
    use mcap::records::Record;
    let (mut messages, mut attachments, mut metadata) = (Vec::new(), Vec::new(), Vec::new());
    for record in mcap::read::LinearReader::new(&written(&fixture::pair())).unwrap() {
        match record.unwrap() {
            Record::Chunk { header, data } => {
                messages.extend(zstd::bulk::decompress(&data, header.uncompressed_size as usize).unwrap());
            }
            Record::Attachment { header, data, .. } => {
                let mut head = vec![0; 16];
                for text in [&header.name, &header.media_type] {
                    head.extend((text.len() as u32).to_le_bytes());
                    head.extend(text.as_bytes());
                }
                attachments.push((head, data.into_owned()));
            }
            Record::Metadata(record) => {
                metadata.extend((record.name.len() as u32).to_le_bytes());
                metadata.extend(record.name.as_bytes());
                let entries = record.metadata.iter().flat_map(|(key, value)| [key, value]);
                let entries: Vec<u8> = entries
                    .flat_map(|text| [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat())
                    .collect();
                metadata.extend((entries.len() as u32).to_le_bytes());
                metadata.extend(entries);
            }
            _ => {}
        }
    }
    LogSections { messages, attachments, metadata }
}

/// The parts as a file with correct checksums.
fn packed(parts: &LogSections) -> Vec<u8> {
    let mut records = vec![chunk(parts.messages.len() as u64, crc32fast::hash(&parts.messages), "", &parts.messages)];
    for (head, data) in &parts.attachments {
        let mut body = [head.as_slice(), &(data.len() as u64).to_le_bytes(), data].concat();
        body.extend(crc32fast::hash(&body).to_le_bytes());
        records.push(record(op::ATTACHMENT, &body));
    }
    records.push(record(op::METADATA, &parts.metadata));
    file(&records)
}

#[test]
fn a_log_packed_anew_is_read() {
    assert_eq!(read(&packed(&unpacked())), read(&written(&fixture::pair())));
}

proptest! {
    #[test]
    fn no_forged_log_makes_it_panic(
        part in 0usize..6,
        at in any::<prop::sample::Index>(),
        bytes in prop::collection::vec(any::<u8>(), 1..6),
    ) {
        static GOOD: std::sync::LazyLock<LogSections> = std::sync::LazyLock::new(unpacked);
        let mut parts = GOOD.clone();
        let count = parts.attachments.len();
        let place = match part {
            0 | 1 => &mut parts.messages,
            2 => &mut parts.metadata,
            _ => &mut parts.attachments[part % count].1,
        };
        let at = at.index(place.len());
        let end = (at + bytes.len()).min(place.len());
        place.splice(at..end, bytes);
        if let Ok(log) = read(&packed(&parts)) {
            let _ = log.series_fault();
            prop_assert!(crate::schedule::json::write(&log.schedule).len() > 100);
        }
    }

    #[test]
    fn no_bytes_make_it_panic(records in prop::collection::vec((1u8..17, prop::collection::vec(any::<u8>(), 0..60)), 0..6)) {
        let records: Vec<Vec<u8>> = records.iter().map(|(opcode, body)| record(*opcode, body)).collect();
        prop_assert!(read(&file(&records)).is_err());
        prop_assert!(read(&records.concat()).is_err());
    }

    #[test]
    fn no_change_inside_a_chunk_makes_it_panic(at in any::<prop::sample::Index>(), bytes in prop::collection::vec(any::<u8>(), 1..9)) {
        let good = written(&fixture::idle());
        let mut bad = good.clone();
        let at = at.index(bad.len() - bytes.len());
        bad[at..at + bytes.len()].copy_from_slice(&bytes);
        prop_assert_eq!(read(&bad).is_ok(), bad == good);
    }
}
