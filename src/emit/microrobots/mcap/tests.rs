use super::*;
use crate::device::microrobots::Arm;
use crate::emit::fixture;
use crate::emit::mcap::devices;
use crate::emit::mcap::foxglove::{FrameTransforms, SceneUpdate};
use crate::emit::mcap::tests::device_topics;
use crate::emit::microrobots::motion::MAX_POSES;
use crate::schedule::State;
use crate::schedule::microrobots::{MicrorobotsState, RecordedPose};
use prost::Message as _;

fn topic<'a>(topics: &'a [LogTopic], name: &str) -> &'a LogTopic {
    topics.iter().find(|topic| topic.name == name).unwrap_or_else(|| panic!("no topic {name}"))
}

fn scene(topic: &LogTopic, at: usize) -> SceneUpdate {
    SceneUpdate::decode(topic.messages[at].1.as_slice()).unwrap()
}

#[test]
fn poses_are_those_of_the_states_and_follow_circles_between_them() {
    let bed = fixture::bed().verified;
    let (topics, _) = device_topics(&bed, "m");
    let poses = topic(&topics, "/m/poses");
    assert_eq!(poses.metadata["robots"], "D1 D2 D3");
    let held: Vec<(u64, Vec<[f64; 2]>)> = poses
        .messages
        .iter()
        .map(|(t_ns, data)| {
            let message = PosesInFrame::decode(data.as_slice()).unwrap();
            let place = |pose: &foxglove::Pose| pose.position.map(|place| [place.x, place.y]).unwrap();
            (*t_ns, message.poses.iter().map(place).collect())
        })
        .collect();
    for timed in &bed.schedule().plans[0].states {
        let State::Microrobots(MicrorobotsState { poses, .. }) = &timed.state else { panic!("a state of microrobots") };
        let (_, last) = held.iter().rfind(|(t_ns, _)| *t_ns <= timed.t_ns).unwrap();
        for (place, RecordedPose { x_um, y_um, .. }) in last.iter().zip(poses.values()) {
            assert!((place[0] - x_um).abs() < 1e-6 && (place[1] - y_um).abs() < 1e-6, "{place:?} {x_um} {y_um}");
        }
    }
    // D1 turns clockwise about (0, -150) in the first train, which lasts from 2 to 32 ms.
    let first: Vec<_> = held.iter().filter(|(t_ns, _)| (2_000_000..=32_000_000).contains(t_ns)).collect();
    assert!(first.len() > 90, "a pose each 5 degrees of 458");
    assert!(first.iter().all(|(_, places)| (places[0][0].hypot(places[0][1] + 150.0) - 150.0).abs() < 1e-5));
}

#[test]
fn arms_are_numbers_that_jump() {
    let bed = fixture::bed().verified;
    let (topics, _) = device_topics(&bed, "m");
    let arms = topic(&topics, "/m/arms");
    let values = |data: &[u8]| data.chunks(9).map(|chunk| f64::from_le_bytes(chunk[1..].try_into().unwrap())).collect();
    let held: Vec<(u64, Vec<f64>)> = arms.messages.iter().map(|(t_ns, data)| (*t_ns, values(data))).collect();
    assert!(held.len() > 1000, "told again at each beat");
    let mut held = held;
    held.dedup_by(|next, last| next.1 == last.1 && next.0 != 31_999_999 && next.0 != bed.schedule().duration_ns);
    assert_eq!(held[0], (0, vec![2.0, 1.0, 1.0, 0.0]));
    assert_eq!(held[1], (31_999_999, vec![2.0, 1.0, 1.0, 0.0]));
    assert_eq!(held[2], (32_000_000, vec![0.0; 4]));
    assert_eq!(arms.metadata["D3"], "steering arm of D3: 0 up, 1 down");
    assert_eq!(held.last().unwrap(), &(bed.schedule().duration_ns, vec![0.0; 4]));
}

#[test]
fn an_orbit_is_a_whole_turn_without_interruption() {
    let bed = fixture::bed().verified;
    let motion = BedMotion::new(&bed, "m");
    let orbits = motion.plans[0].orbits();
    // 600 strokes of 2 um on a circle of 942 um are a full turn; the later turns of 300 um are not.
    let found: Vec<_> = orbits.iter().map(|orbit| (orbit.robot, orbit.start_ns, orbit.end_ns)).collect();
    assert_eq!(found, [(0, 0, 32_000_000), (1, 0, 32_000_000)]);
    assert!((orbits[0].centre_um[1] + 150.0).abs() < 1e-9);
    assert_eq!(orbits[0].reach_um, 180f64.hypot(60.0));
}

/// A docked robot has no orbit, although its arm is down.
#[test]
fn a_docked_robot_has_no_orbit() {
    let bed = fixture::bed().verified;
    let mut motion = BedMotion::new(&bed, "m");
    let orbits = |motion: &BedMotion| -> Vec<(usize, u64)> {
        motion.plans[0].orbits().iter().map(|orbit| (orbit.robot, orbit.end_ns)).collect()
    };
    let next = &mut motion.plans[0].legs[1].movers;
    next.iter_mut().for_each(|body| body.arm = Arm::Down);
    next[0].is_docked = true;
    let end_ns = motion.plans[0].legs[1].end_ns;
    assert!(end_ns > 32_000_000);
    assert_eq!(orbits(&motion)[..2], [(0, 32_000_000), (1, end_ns)]);
}

#[test]
fn what_holds_in_a_leg_is_drawn_and_nothing_else() {
    let bed = fixture::bed().verified;
    let (topics, _) = device_topics(&bed, "m");
    let state = topic(&topics, "/m/state");
    let drawn: Vec<(usize, usize, usize)> = (0..state.messages.len())
        .map(|at| {
            let update = scene(state, at);
            let of = |count: fn(&foxglove::SceneEntity) -> usize| update.entities.iter().map(count).sum();
            (of(|entity| entity.cylinders.len()), of(|entity| entity.cubes.len()), of(|entity| entity.lines.len()))
        })
        .collect();
    // Orbits, arms that are down, docked robots: two legs, the wait, three legs, the end.
    assert_eq!(drawn, [(2, 2, 0), (0, 0, 0), (0, 0, 0), (0, 1, 0), (0, 0, 0), (0, 3, 2), (0, 0, 2)]);
    let plan = scene(topic(&topics, "/m/plan"), 0);
    assert_eq!(plan.entities[0].lines.len(), 3, "a trail for each robot");
    assert_eq!(plan.entities[1].texts.len(), 3, "one goal of a drive, two of an assembly");
}

#[test]
fn robots_have_bodies_in_frames_that_turn() {
    let bed = fixture::bed().verified;
    let (topics, movers) = device_topics(&bed, "m");
    let standing = scene(topic(&topics, "/m/scene"), 0);
    for name in ["D1", "D2", "D3"] {
        let body = standing.entities.iter().find(|entity| entity.id == format!("m/robot/{name}")).unwrap();
        assert_eq!(body.frame_id, format!("m/{name}"));
        assert_eq!(body.cubes[0].size.map(|size| (size.x, size.y)), Some((120.0, 60.0)));
        assert_eq!(body.triangles.len(), 1);
    }
    let tf = devices::frames(&devices::LoggedDevice::all(&bed), &movers);
    let last = FrameTransforms::decode(tf.messages.last().unwrap().1.as_slice()).unwrap();
    let state = bed.schedule().plans[0].states.last().unwrap();
    let State::Microrobots(MicrorobotsState { poses, .. }) = &state.state else { panic!("a state of microrobots") };
    for (name, pose) in poses {
        let frame = last.transforms.iter().find(|frame| frame.child_frame_id == format!("m/{name}")).unwrap();
        let turn = frame.rotation.unwrap();
        let found_rad = 2.0 * turn.z.atan2(turn.w);
        let off_rad = found_rad - pose.heading_rad();
        assert!(off_rad.sin().abs() < 1e-8 && off_rad.cos() > 0.0);
    }
    let device = &devices::LoggedDevice::all(&bed)[0];
    assert!(device.pose.place[0] > 400.0, "what lies left of the origin has its room");
}

#[test]
fn robots_stand_from_the_beginning_on() {
    let bed = fixture::bed().verified;
    let later = fixture::changed(&bed, |schedule| {
        schedule.actuations.iter_mut().for_each(|actuation| actuation.start_ns += 1000);
        schedule.plans[0].start_ns += 1000;
        schedule.plans[0].states.iter_mut().for_each(|state| state.t_ns += 1000);
    });
    let (topics, movers) = device_topics(&later, "m");
    let instants = |name| topic(&topics, name).messages.iter().map(|(t_ns, _)| *t_ns).take(2).collect::<Vec<_>>();
    assert_eq!(instants("/m/poses"), [0, 2_001_000]);
    assert_eq!(instants("/m/scene"), [0]);
    assert!(movers.iter().all(|mover| mover.places[0].0 == 0 && mover.places[1].0 == 2_001_000));
}

#[test]
fn an_hour_of_motion_is_a_bounded_number_of_poses() {
    let hour = fixture::train(72_000_000).changed(|schedule| {
        let states = &mut schedule.plans[0].states;
        states.truncate(2);
        states[1].t_ns = schedule.duration_ns;
        schedule.plans[0].duration_ns = schedule.duration_ns;
    });
    let motion = BedMotion::new(&hour.verified, "m");
    let reported = motion.plans[0].moments.len() * 3;
    assert!(reported <= MAX_POSES + 9 && reported > MAX_POSES / 2, "{reported} poses");
}
