//! A log of another version is neither verified nor reported as edited.

use super::bench::{done, tweeze};
use mcap::records::Record;
use std::collections::BTreeMap;
use std::io::Cursor;

const PROGRAM: &str = "use std.dimibot\ndevice bot : dimibot.femto_st\ntask go on bot { move to (1, 1) }\n";

/// A log packed again with other metadata and claims.
fn packed(log: &[u8], metadata: impl Fn(&mut BTreeMap<String, String>), claims: impl Fn(String) -> String) -> Vec<u8> {
    let mut writer = mcap::WriteOptions::new().compression(None).create(Cursor::new(Vec::new())).expect("a writer");
    for message in mcap::MessageStream::new(log).expect("a log") {
        writer.write(&message.expect("a message")).expect("written");
    }
    for record in mcap::read::LinearReader::new(log).expect("a log") {
        match record.expect("a record") {
            Record::Attachment { header, data, .. } => {
                let data = match header.name.as_str() {
                    "claims.json" => claims(String::from_utf8_lossy(&data).into_owned()).into_bytes().into(),
                    _ => data,
                };
                let (name, media_type) = (header.name, header.media_type);
                let attachment = mcap::Attachment { log_time: 0, create_time: 0, name, media_type, data };
                writer.attach(&attachment).expect("written");
            }
            Record::Metadata(mut record) => {
                metadata(&mut record.metadata);
                writer.write_metadata(&record).expect("written");
            }
            _ => {}
        }
    }
    writer.finish().expect("written");
    writer.into_inner().into_inner()
}

/// The exit status and message for the log of [`PROGRAM`] with some of its metadata and claims replaced.
fn reported(metadata: &[(&str, Option<&str>)], claims: impl Fn(String) -> String) -> (Option<i32>, String) {
    let bench = tempfile::tempdir().expect("a folder");
    std::fs::write(bench.path().join("go.twz"), PROGRAM).expect("written");
    done(tweeze(bench.path()).args(["build", "go.twz"]));
    let log = std::fs::read(bench.path().join("go.mcap")).expect("a log");
    let replace = |record: &mut BTreeMap<String, String>| {
        for (key, value) in metadata {
            match value {
                Some(value) => drop(record.insert((*key).to_owned(), (*value).to_owned())),
                None => drop(record.remove(*key)),
            }
        }
    };
    std::fs::write(bench.path().join("go.mcap"), packed(&log, replace, claims)).expect("written");
    let output = tweeze(bench.path()).args(["verify", "go.mcap"]).env("COLUMNS", "200").output().expect("it starts");
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn a_log_of_another_schema_is_not_judged() {
    for (schema, version, message) in [
        (None, Some("0.1.0"), "written by tweeze 0.1.0 in schema 1;"),
        (Some("1"), Some("0.1.0"), "written by tweeze 0.1.0 in schema 1;"),
        (Some("99"), Some("7.1.0"), "written by tweeze 7.1.0 in schema 99;"),
        (Some("x\u{1b}[2J"), None, "an unknown version of tweeze in schema x[2J;"),
    ] {
        let (code, text) = reported(&[("schema", schema), ("version", version)], |claims| claims);
        assert!(code == Some(4) && text.contains("E0848") && text.contains(message), "{text}");
        assert!(text.contains("verify it with ") && !text.contains("edited") && !text.contains('\u{1b}'), "{text}");
    }
}

#[test]
fn what_another_version_of_the_same_schema_derives_is_no_edit() {
    let other = [("version", Some("0.0.9"))];
    let changed = |claims: String| claims.replace("0.138", "0.139");
    for text in [reported(&other, |claims| claims), reported(&other, changed)] {
        assert!(text.0 == Some(4) && text.1.contains("E0848") && text.1.contains("tweeze 0.0.9"), "{text:?}");
    }
    // The same edit in a log of this version is reported as one.
    let (code, text) = reported(&[], changed);
    assert!(code == Some(3) && text.contains("E0741") && text.contains("edited"), "{text}");
    let (code, text) = reported(&[], |claims| claims.replace("tweeze-claims", "breeze-claims"));
    assert!(code == Some(4) && text.contains("E0845"), "{text}");
}
