use super::*;
use crate::device::electrode_array::{ElectrodeMap, Electrodes};
use crate::emit::mcap::devices;
use crate::emit::mcap::foxglove::{FrameTransforms, SceneUpdate};
use crate::emit::mcap::tests::device_topics;
use crate::lower::electrode_array::tests::{carried, facts};
use prost::Message as _;

/// Two microparts: one moves at once, the other after a wait.
fn two() -> Verified {
    let first = vec![vec![(5, 5), (6, 5)], vec![(12, 5)]];
    let last = vec![vec![(6, 5)], vec![(12, 5), (12, 6)]];
    let (claims, schedule) = carried(&facts(Electrodes::Quad), &[first, vec![], last]);
    Verified::assume(schedule, claims)
}

fn topic<'a>(topics: &'a [LogTopic], name: &str) -> &'a LogTopic {
    topics.iter().find(|topic| topic.name == name).unwrap_or_else(|| panic!("no topic {name}"))
}

#[test]
fn a_part_rests_where_it_is_until_its_step_begins() {
    let (topics, _) = device_topics(&two(), "plate");
    let rows = |part: &str| {
        let pose = |(t_ns, data): &(u64, Vec<u8>)| {
            let pose = PoseInFrame::decode(data.as_slice()).unwrap().pose.unwrap();
            (*t_ns, pose.position.unwrap().y / 94.5)
        };
        topic(&topics, &format!("/plate/pose/{part}")).messages.iter().map(pose).collect::<Vec<_>>()
    };
    assert_eq!(rows("b"), [(0, 4.0), (6_000_000, 4.0), (11_000_000, 5.0)]);
    assert_eq!(rows("a").iter().map(|(t_ns, _)| *t_ns).collect::<Vec<_>>(), [0, 5_000_000]);
    let cells = topic(&topics, "/plate/cells");
    assert_eq!(cells.metadata["b_row"], "row of b, from 1");
    let row = |data: &[u8]| f64::from_le_bytes(data[28..36].try_into().unwrap());
    let reported: Vec<(u64, f64)> = cells.messages.iter().map(|(t_ns, data)| (*t_ns, row(data))).collect();
    assert!(
        reported.contains(&(0, 5.0)) && reported.contains(&(10_999_999, 5.0)) && reported.contains(&(11_000_000, 6.0))
    );
    assert!(reported.len() > 1000, "told again at each beat");
}

#[test]
fn the_electrodes_that_are_on_are_drawn_and_no_others() {
    let (topics, _) = device_topics(&two(), "plate");
    let active = topic(&topics, "/plate/active");
    let drawn: Vec<(u64, usize)> = active
        .messages
        .iter()
        .map(|(t_ns, data)| {
            let update = SceneUpdate::decode(data.as_slice()).unwrap();
            (*t_ns, update.entities[0].cylinders.len())
        })
        .collect();
    assert_eq!(drawn, [(0, 2), (5_000_000, 0), (6_000_000, 2), (11_000_000, 0)]);
}

/// A droplet crosses an electrode that shares its channel with two others, one of which is disabled.
#[test]
fn of_a_shared_channel_all_electrodes_that_work_are_drawn() {
    let cells = (1..=12).flat_map(|row| (1..=20).map(move |column| ElectrodeCell::new(column, row)));
    let number = |cell: ElectrodeCell| match cell.pair() {
        [6, 5] | [12, 9] | [18, 9] => 1,
        [column, row] => 100 * row + column,
    };
    let channels = cells.map(|cell| Some(number(cell))).collect();
    let map = ElectrodeMap { columns: 20, channels, disabled: vec![ElectrodeCell::new(18, 9)] };
    let facts = ElectrodeArrayFacts { map: Some(map.into()), ..facts(Electrodes::Single) };
    let (claims, schedule) = carried(&facts, &[vec![vec![(5, 5), (6, 5), (7, 5)]]]);
    let (topics, _) = device_topics(&Verified::assume(schedule, claims), "plate");
    let drawn = topic(&topics, "/plate/active").messages.iter().map(|(t_ns, data)| {
        let update = SceneUpdate::decode(data.as_slice()).unwrap();
        (*t_ns, update.entities[0].cylinders.len())
    });
    assert_eq!(drawn.collect::<Vec<_>>(), [(0, 2), (5_000_000, 1), (10_000_000, 0)]);
}

#[test]
fn each_part_has_a_frame_a_body_and_a_way() {
    let verified = two();
    let (topics, movers) = device_topics(&verified, "plate");
    let scene = SceneUpdate::decode(topic(&topics, "/plate/scene").messages[0].1.as_slice()).unwrap();
    for name in ["a", "b"] {
        let body = scene.entities.iter().find(|entity| entity.id == format!("plate/part/{name}")).unwrap();
        assert_eq!(body.frame_id, format!("plate/{name}"));
        assert_eq!(body.cubes[0].size.unwrap().x, 3.0 * 94.5);
        let outline =
            movers.iter().find(|mover| mover.frame == format!("plate/{name}")).and_then(Mover::points).unwrap();
        assert_eq!((outline.name, outline.messages.len()), (format!("/plate/{name}/points"), 1));
    }
    let plan = SceneUpdate::decode(topic(&topics, "/plate/plan").messages[0].1.as_slice()).unwrap();
    assert_eq!(plan.entities[0].lines.len(), 2);
    let frames = devices::frames(&devices::LoggedDevice::all(&verified), &movers);
    let last = FrameTransforms::decode(frames.messages.last().unwrap().1.as_slice()).unwrap();
    let names: Vec<&str> = last.transforms.iter().map(|frame| frame.child_frame_id.as_str()).collect();
    assert_eq!(names, ["plate", "plate/a", "plate/b"]);
}
