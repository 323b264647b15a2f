//! Altered logs of small programs, with every checksum corrected.

use super::mutate;
use super::numbers::{self, MAGNITUDES};
use super::random::Random;
use mcap::records::Record;
use std::io::Cursor;

/// The parts of a log.
#[derive(Clone)]
pub struct Parts {
    /// Messages with their topic, type, descriptor, metadata and time.
    messages: Vec<mcap::Message<'static>>,
    attachments: Vec<(String, String, Vec<u8>)>,
    metadata: Vec<mcap::records::Metadata>,
}

impl Parts {
    /// Unpacks a log. It is leaked, because the few logs that are altered live as long as the worker.
    pub fn of(log: Vec<u8>) -> Option<Parts> {
        let log: &'static [u8] = Box::leak(log.into_boxed_slice());
        let stream = mcap::MessageStream::new(log).ok()?;
        let messages = stream.filter_map(Result::ok).collect();
        let (mut attachments, mut metadata) = (Vec::new(), Vec::new());
        for record in mcap::read::LinearReader::new(log).ok()? {
            match record.ok()? {
                Record::Attachment { header, data, .. } => {
                    attachments.push((header.name, header.media_type, data.into_owned()));
                }
                Record::Metadata(record) => metadata.push(record),
                _ => {}
            }
        }
        Some(Parts { messages, attachments, metadata })
    }

    /// Packs a log; every checksum is correct.
    pub fn pack(&self, compress: bool) -> Option<Vec<u8>> {
        let compression = compress.then_some(mcap::Compression::Zstd);
        let options = mcap::WriteOptions::new().compression(compression).compression_threads(0);
        let mut writer = options.create(Cursor::new(Vec::new())).ok()?;
        for message in &self.messages {
            writer.write(message).ok()?;
        }
        for (name, media_type, data) in &self.attachments {
            let (name, media_type) = (name.clone(), media_type.clone());
            let attachment =
                mcap::Attachment { log_time: 0, create_time: 0, name, media_type, data: data.as_slice().into() };
            writer.attach(&attachment).ok()?;
        }
        for record in &self.metadata {
            writer.write_metadata(record).ok()?;
        }
        writer.finish().ok()?;
        Some(writer.into_inner().into_inner())
    }
}

/// A log with random changes.
pub fn altered(random: &mut Random, good: &Parts, texts: &[String]) -> Vec<u8> {
    let mut parts = good.clone();
    for _ in 0..=random.below(2) {
        match random.below(8) {
            0 if !parts.messages.is_empty() => message(random, &mut parts),
            1 => metadata(random, &mut parts, texts),
            _ => attachment(random, &mut parts, texts),
        }
    }
    let mut bytes = parts.pack(random.below(2) == 0).unwrap_or_default();
    if random.below(8) == 0 && !bytes.is_empty() {
        // Without correcting the checksums, to reach the reader's own checks.
        let at = random.below(bytes.len() as u32) as usize;
        bytes[at] ^= 1 << random.below(8);
    }
    bytes
}

fn message(random: &mut Random, parts: &mut Parts) {
    let at = random.below(parts.messages.len() as u32) as usize;
    match random.below(4) {
        0 => drop(parts.messages.remove(at)),
        1 => {
            let twice = parts.messages[at].clone();
            parts.messages.push(twice);
        }
        2 => parts.messages[at].log_time = random.next() >> random.below(64),
        _ => {
            let mut data = parts.messages[at].data.to_vec();
            splice(random, &mut data);
            parts.messages[at].data = data.into();
        }
    }
}

/// Replaces a few bytes.
fn splice(random: &mut Random, data: &mut Vec<u8>) {
    let at = random.below(data.len() as u32 + 1) as usize;
    let end = (at + random.below(9) as usize).min(data.len());
    let bytes: Vec<u8> = (0..random.below(9)).map(|_| random.next() as u8).collect();
    data.splice(at..end, bytes);
}

fn metadata(random: &mut Random, parts: &mut Parts, texts: &[String]) {
    let settings = ["[]", "[\"a=1\"]", "[\"=\"]", "{", "[\"\\u0000=\\u0007\"]"][random.below(5) as usize].to_owned();
    for record in &mut parts.metadata {
        let keys: Vec<String> = record.metadata.keys().cloned().collect();
        let Some(key) = keys.get(random.below(keys.len().max(1) as u32) as usize) else { continue };
        match random.below(3) {
            0 => drop(record.metadata.remove(key)),
            1 => drop(record.metadata.insert("settings".to_owned(), settings.clone())),
            _ => drop(record.metadata.insert(key.clone(), mutate::mutated(random, texts))),
        }
    }
}

fn attachment(random: &mut Random, parts: &mut Parts, texts: &[String]) {
    if parts.attachments.is_empty() {
        return;
    }
    let at = random.below(parts.attachments.len() as u32) as usize;
    if random.below(16) == 0 {
        match random.below(3) {
            0 => drop(parts.attachments.remove(at)),
            1 => parts.attachments[at].0 = "source/../../x".to_owned(),
            _ => {
                let twice = parts.attachments[at].clone();
                parts.attachments.push(twice);
            }
        }
        return;
    }
    let (name, _, data) = &mut parts.attachments[at];
    let text = String::from_utf8_lossy(data).into_owned();
    let places = numbers::places(&text);
    *data = match random.below(6) {
        0 if name.starts_with("source/") => mutate::mutated(random, texts).into_bytes(),
        1 if name.starts_with("source/") => {
            let own = [text];
            mutate::mutated(random, &own).into_bytes()
        }
        5 => {
            splice(random, data);
            std::mem::take(data)
        }
        _ if places.is_empty() => Vec::new(),
        _ => {
            let place = &places[random.below(places.len() as u32) as usize];
            numbers::scaled(&text, place, MAGNITUDES[random.below(12) as usize]).into_bytes()
        }
    };
}
