use super::*;
use crate::emit::dimibot::mcap::scene;
use crate::emit::fixture::{self, FixtureSchedule};
use prost::Message as _;
use std::io::Cursor;

type Edit<'a> = &'a mut dyn FnMut(&str, u64, Vec<u8>) -> Vec<Vec<u8>>;

/// The topics of a device, as its kind makes them.
pub fn device_topics(verified: &Verified, device: &str) -> (Vec<LogTopic>, Vec<Mover>) {
    let job = verified.claims().jobs.iter().find(|job| job.device == device).expect("a job of the device");
    pictures(&job.order).topics(verified, &Signals::new(verified.schedule()), device)
}

/// The log repacked, with every message replaced by the result of `edit`, and the attachments changed by `attach`.
fn edited(bytes: &[u8], edit: Edit, attach: impl Fn(&mut Attachment)) -> Vec<u8> {
    let mut writer = WriteOptions::new().library(LIBRARY).compression(None).create(Cursor::new(Vec::new())).unwrap();
    for message in ::mcap::MessageStream::new(bytes).unwrap() {
        let message = message.unwrap();
        for data in edit(&message.channel.topic, message.log_time, message.data.to_vec()) {
            writer.write(&::mcap::Message { data: data.into(), ..message.clone() }).unwrap();
        }
    }
    for record in ::mcap::read::LinearReader::new(bytes).unwrap() {
        match record.unwrap() {
            records::Record::Attachment { header, data, .. } => {
                let records::AttachmentHeader { log_time, create_time, name, media_type } = header;
                let mut attachment = Attachment { log_time, create_time, name, media_type, data };
                attach(&mut attachment);
                writer.attach(&attachment).unwrap();
            }
            records::Record::Metadata(metadata) => writer.write_metadata(&metadata).unwrap(),
            _ => {}
        }
    }
    writer.finish().unwrap();
    writer.into_inner().into_inner()
}

fn found(edit: Edit, attach: impl Fn(&mut Attachment)) -> String {
    let FixtureSchedule { verified, provenance } = fixture::pair();
    let [bytes, _] = write(&verified, &provenance).unwrap();
    difference(&edited(&bytes, edit, attach), &verified, &provenance).expect("an edited log differs")
}

#[test]
fn a_log_is_no_different_from_itself() {
    for make in [
        fixture::fetch,
        fixture::pair,
        fixture::large,
        fixture::idle,
        fixture::crowd,
        fixture::bed,
        fixture::paces,
        fixture::hand,
    ] {
        let FixtureSchedule { verified, provenance } = make();
        let [bytes, _] = write(&verified, &provenance).unwrap();
        assert_eq!(difference(&bytes, &verified, &provenance), None);
    }
}

#[test]
fn packing_alone_is_named_as_such() {
    let found = found(&mut |_, _, data| vec![data], |_| ());
    assert!(found.starts_with("names, index or packing"), "{found}");
}

#[test]
fn any_edited_message_is_found() {
    let cases = [
        ("/bot/scene", 0, "the message of `/bot/scene` at 0 ns differs"),
        ("/Aid/plan", 7_500_000, "the message of `/Aid/plan` at 7500000 ns differs"),
        ("/bot/scene/points", 0, "the message of `/bot/scene/points` at 0 ns differs"),
        ("/log", 7_500_000, "the message of `/log` at 7500000 ns differs"),
        ("/tf", 25_000_000, "the message of `/tf` at 25000000 ns differs"),
        ("/bot/voltages", 14_999_999, "the message of `/bot/voltages` at 14999999 ns differs"),
        ("/bot/path", 0, "the message of `/bot/path` at 0 ns differs"),
        ("/Aid/pose", 22_500_000, "the message of `/Aid/pose` at 22500000 ns differs"),
    ];
    for (topic, t_ns, expected) in cases {
        let mut flip = |of: &str, at: u64, mut data: Vec<u8>| {
            if of == topic && at == t_ns {
                // The last byte of a message is inside a number or a text, so the message can still be read.
                *data.last_mut().unwrap() ^= 1;
            }
            vec![data]
        };
        assert_eq!(found(&mut flip, |_| ()), expected);
    }
}

#[test]
fn a_missing_and_an_extra_message_are_found() {
    let drop = |topic: &'static str, at: u64| {
        move |of: &str, t_ns: u64, data: Vec<u8>| if (of, t_ns) == (topic, at) { vec![] } else { vec![data] }
    };
    assert_eq!(found(&mut drop("/log", 0), |_| ()), "the message of `/log` at 0 ns is missing");
    assert_eq!(
        found(&mut drop("/Aid/pose", 110_000_000), |_| ()),
        "the message of `/Aid/pose` at 110000000 ns is missing"
    );
    let mut twice =
        |of: &str, _: u64, data: Vec<u8>| if of == "/bot/scene" { vec![data.clone(), data] } else { vec![data] };
    assert!(found(&mut twice, |_| ()).starts_with("`/bot/scene` has an extra message at 0 ns"));
}

#[test]
fn edited_attachments_are_found() {
    let replace = |name: &'static str, from: &'static str, to: &'static str| {
        move |attachment: &mut Attachment| {
            if attachment.name == name {
                let text = String::from_utf8(attachment.data.to_vec()).unwrap();
                assert!(text.contains(from));
                attachment.data = text.replacen(from, to, 1).into_bytes().into();
            }
        }
    };
    let same: Edit = &mut |_, _, data| vec![data];
    assert_eq!(found(same, replace("source/Pair.twz", "task", "tusk")), "the attached source files differ");
    assert_eq!(found(same, replace("claims.json", "\"gain\":0.138", "\"gain\":0.139")), "the attached claims differ");
    assert_eq!(found(same, replace("schedule.json", "\"line\": 3", "\"line\": 4")), "the attached schedule differs");
    let broken = found(same, replace("schedule.json", "tweeze-schedule", "breeze-schedule"));
    assert!(broken.contains("format `breeze-schedule` version 2"), "{broken}");
}

#[test]
fn something_that_is_no_log_differs() {
    let FixtureSchedule { verified, provenance } = fixture::idle();
    assert!(difference(b"nothing", &verified, &provenance).unwrap().contains("does not begin like"));
}

#[test]
fn the_scene_shows_every_obstacle_twice_and_takes_away_what_is_gone() {
    let verified = fixture::fetch().verified;
    let topics = scene::topics(&verified, "bot");
    let update = |topic: &LogTopic| foxglove::SceneUpdate::decode(topic.messages[0].1.as_slice()).unwrap();
    let updates: Vec<_> = topics.iter().map(update).collect();
    let entity = |id: &str| updates.iter().flat_map(|update| &update.entities).find(|entity| entity.id == id).unwrap();
    let bead = entity("bot/obstacle/bead");
    let diameters: Vec<f64> = bead.cylinders.iter().map(|cylinder| cylinder.size.unwrap().x).collect();
    assert_eq!(diameters, [1.6, 1.6 + 2.0 * 0.15000000000000002]);
    assert_eq!(entity("bot/obstacle/dust").cubes.len(), 1);
    assert_eq!(entity("bot/path").lines[0].points.len(), verified.schedule().plans[0].states.len());
    assert_eq!(entity("bot/tip").frame_id, "bot/tip");
    assert!(updates.iter().all(|update| update.deletions.is_empty()));
}

/// Repeats the task with other obstacles.
fn twice(change: impl FnOnce(&mut Vec<crate::claims::dimibot::DimibotObstacle>)) -> Verified {
    let verified = fixture::fetch().verified;
    let (mut schedule, mut claims) = (verified.schedule().clone(), verified.claims().clone());
    let mut job = claims.jobs[0].clone();
    let crate::claims::Order::Dimibot(order) = &mut job.order else { panic!("an order of a DiMiBot") };
    change(std::sync::Arc::make_mut(&mut order.obstacles));
    claims.jobs.push(job);
    let mut plan = schedule.plans[0].clone();
    plan.start_ns = 1_000_000_000;
    plan.states.iter_mut().for_each(|state| state.t_ns += 1_000_000_000);
    schedule.plans.push(plan);
    schedule.duration_ns += 1_000_000_000;
    Verified::assume(schedule, claims)
}

fn scenes(verified: &Verified) -> Vec<(u64, foxglove::SceneUpdate)> {
    let topics = scene::topics(verified, "bot");
    let decode = |(t_ns, data): &(u64, Vec<u8>)| (*t_ns, foxglove::SceneUpdate::decode(data.as_slice()).unwrap());
    topics[0].messages.iter().map(decode).collect()
}

#[test]
fn scenery_is_said_again_only_when_it_is_another() {
    assert_eq!(scenes(&twice(|_| ())).len(), 1);
    let scenes = scenes(&twice(|obstacles| drop(obstacles.remove(0))));
    assert_eq!(scenes.iter().map(|(t_ns, _)| *t_ns).collect::<Vec<_>>(), [0, 1_000_000_000]);
    assert_eq!(scenes[1].1.deletions.iter().map(|gone| gone.id.as_str()).collect::<Vec<_>>(), ["bot/obstacle/bead"]);
}

#[test]
fn a_crowded_scene_is_drawn_in_part_and_says_so() {
    let many = |count: usize| {
        let scenes = scenes(&twice(|obstacles| {
            let dust = obstacles[5].clone();
            *obstacles = vec![dust; count];
        }));
        let lattice = scenes[1].1.entities.iter().find(|entity| entity.id == "bot/lattice").unwrap();
        let all = scenes[1].1.entities.iter().find(|entity| entity.id == "bot/obstacles").unwrap();
        (all.cubes.len(), lattice.texts[0].text.contains("20000 of 20001 obstacles shown"))
    };
    assert_eq!(many(20_000), (20_000, false));
    assert_eq!(many(20_001), (20_000, true));
}

#[test]
fn the_pose_stays_until_the_pulse_begins_and_is_new_when_it_ends() {
    let verified = fixture::pair().verified;
    let topics = topics(&verified, &Signals::new(verified.schedule()));
    let poses = topics.iter().find(|topic| topic.name == "/Aid/pose").unwrap();
    let x = |data: &[u8]| foxglove::PoseInFrame::decode(data).unwrap().pose.unwrap().position.unwrap().x;
    let first: Vec<(u64, bool)> = poses.messages.iter().take(5).map(|(t_ns, data)| (*t_ns, x(data) > 0.0)).collect();
    let expected = [(0, false), (7_500_000, false), (22_500_000, true), (25_000_000, true), (40_000_000, true)];
    assert_eq!(first, expected);
}
