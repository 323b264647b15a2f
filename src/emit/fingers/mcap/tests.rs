use super::*;
use crate::emit::fingers::motion::{HandMotion, MAX_MOMENTS};
use crate::emit::fixture;
use crate::emit::mcap::foxglove::SceneUpdate;
use crate::emit::mcap::tests::device_topics;
use crate::schedule::State;
use crate::schedule::fingers::FingersState;
use prost::Message as _;

fn topic<'a>(topics: &'a [LogTopic], name: &str) -> &'a LogTopic {
    topics.iter().find(|topic| topic.name == name).unwrap_or_else(|| panic!("no topic {name}"))
}

fn scene(topic: &LogTopic, at: usize) -> SceneUpdate {
    SceneUpdate::decode(topic.messages[at].1.as_slice()).unwrap()
}

#[test]
fn the_part_is_where_the_states_say_and_turns_steadily_between_them() {
    let hand = fixture::hand().verified;
    let (topics, movers) = device_topics(&hand, "hand");
    let poses = topic(&topics, "/hand/pose");
    let held: Vec<(u64, foxglove::Pose)> = poses
        .messages
        .iter()
        .map(|(t_ns, data)| (*t_ns, PoseInFrame::decode(data.as_slice()).unwrap().pose.unwrap()))
        .collect();
    let at = |t_ns: u64| held.iter().rfind(|(held_ns, _)| *held_ns <= t_ns).unwrap().1;
    for timed in &hand.schedule().plans[0].states {
        let State::Fingers(FingersState { position_um, orientation, .. }) = &timed.state else {
            panic!("a state of a hand")
        };
        let (pose, [w, _, _, z]) = (at(timed.t_ns), orientation);
        let turn = pose.orientation.unwrap();
        assert!((turn.w - w).abs() < 1e-8 && (turn.z - z).abs() < 1e-8, "{timed:?}");
        assert!((pose.position.unwrap().z - position_um[2]).abs() < 1e-6);
    }
    // The first step is rolled from 287 to 387 ms.
    assert_eq!(held[1].0, 287_000_000, "told once more before it moves");
    let half_way = at(337_000_000).orientation.unwrap();
    let turned_rad = 2.0 * half_way.z.atan2(half_way.w);
    assert!((turned_rad.to_degrees() - 10.0).abs() < 0.01, "{turned_rad}");
    let frames: Vec<&str> = movers.iter().map(|mover| mover.frame.as_str()).collect();
    assert_eq!(frames, ["hand/bead", "hand/finger/f1", "hand/finger/f2", "hand/finger/f3"]);
    assert!(movers.iter().all(|mover| mover.places[0].0 == 0), "all stand from the beginning on");
}

#[test]
fn tips_are_where_the_schedule_has_them() {
    let hand = fixture::hand().verified;
    let signals = Signals::new(hand.schedule());
    let motion = HandMotion::new(&hand, &signals, "hand");
    let moments = &motion.plans[0].moments;
    assert!(moments.windows(2).all(|pair| pair[0].t_ns < pair[1].t_ns));
    for moment in &moments[1..] {
        for (finger, tip_um) in moment.tips_um.iter().enumerate() {
            let expected = [0, 1, 2].map(|axis| signals.value(3 * finger + axis, moment.t_ns));
            assert_eq!(*tip_um, expected);
        }
    }
    let ways = moments.windows(2).flat_map(|pair| pair[0].tips_um.iter().zip(&pair[1].tips_um));
    let longest_um = ways.map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]).hypot(a[2] - b[2])).fold(0.0, f64::max);
    assert!(longest_um <= 1.0 + 1e-9, "{longest_um}");
}

#[test]
fn a_ball_a_flat_part_and_another_are_drawn_with_their_sections() {
    let hand = fixture::hand().verified;
    let drawn = |change: &dyn Fn(&mut crate::claims::fingers::HandPart)| {
        let (schedule, mut claims) = (hand.schedule().clone(), hand.claims().clone());
        let crate::claims::Order::Fingers(order) = &mut claims.jobs[0].order else { panic!("a hand") };
        change(std::sync::Arc::make_mut(&mut order.part));
        let (topics, _) = device_topics(&Verified::assume(schedule, claims), "hand");
        let body = scene(topic(&topics, "/hand/scene"), 0).entities[0].clone();
        assert_eq!((body.id.as_str(), body.frame_id.as_str()), ("hand/part/bead", "hand/bead"));
        // The ends I and J are two balls.
        (body.spheres.len() - 2, body.triangles.len(), body.lines.len())
    };
    assert_eq!(drawn(&|_| ()), (1, 0, 2));
    assert_eq!(drawn(&|part| part.xz = None), (0, 1, 1));
    let cube =
        crate::geometry::outline::Outline::RoundedRectangle { half_um: [14.0; 2], radius_um: 3.0, centre_um: [0.0; 2] };
    assert_eq!(drawn(&|part| part.xy.outline = cube.clone()), (0, 2, 2));
}

#[test]
fn grasps_are_shown_from_state_to_state() {
    let hand = fixture::hand().verified;
    let (topics, _) = device_topics(&hand, "hand");
    let state = topic(&topics, "/hand/state");
    let states = &hand.schedule().plans[0].states;
    assert_eq!(state.messages.len(), states.len());
    let shown: Vec<(usize, String)> = (0..states.len())
        .map(|at| {
            let update = scene(state, at);
            (update.entities[0].spheres.len(), update.entities[1].texts[0].text.clone())
        })
        .collect();
    assert_eq!(shown[0], (0, "grasp (0, 0, 0) in xy at angle 1".to_owned()));
    assert_eq!(shown[1], (2, "grasp (1, 38, 0) in xy at angle 1".to_owned()));
    assert_eq!(shown[3], (3, "grasp (74, 37, 57) in xy at angle 2".to_owned()));
    // Contact 38 of the second state is J.
    let place = scene(state, 1).entities[0].spheres[1].pose.unwrap().position.unwrap();
    assert!((place.x + 14.0).abs() < 1e-5 && place.y.abs() < 1e-5, "{place:?}");
    // Forces of the holding fingers, which balance: the ball weighs nothing.
    let forces = |at: usize| scene(state, at).entities[0].arrows.clone();
    assert_eq!((0..states.len()).map(|at| forces(at).len()).collect::<Vec<_>>(), [0, 2, 2, 3, 2, 2, 2]);
    for at in 1..states.len() {
        let mut sum = nalgebra::Vector3::zeros();
        for arrow in forces(at) {
            let pose = arrow.pose.unwrap();
            let (turn, place) = (pose.orientation.unwrap(), pose.position.unwrap());
            let turn = nalgebra::Quaternion::new(turn.w, turn.x, turn.y, turn.z);
            let along = nalgebra::UnitQuaternion::new_normalize(turn) * nalgebra::Vector3::x();
            assert!(along.dot(&nalgebra::Vector3::new(place.x, place.y, place.z)) < 0.0, "it pushes");
            sum += along * (arrow.shaft_length + arrow.head_length);
        }
        assert!(sum.norm() < 1e-3, "state {at}: {sum}");
    }
    let plan = scene(topic(&topics, "/hand/plan"), 0);
    assert_eq!(plan.entities[0].lines.len(), 3, "a trail for each finger");
}

#[test]
fn a_long_way_is_a_bounded_number_of_moments() {
    let far = fixture::changed(&fixture::hand().verified, |schedule| {
        for actuation in &mut schedule.actuations {
            (actuation.from, actuation.to) = (actuation.from * 1e4, actuation.to * 1e4);
        }
    });
    let signals = Signals::new(far.schedule());
    let motion = HandMotion::new(&far, &signals, "hand");
    let reported = motion.plans[0].moments.len();
    assert!(reported <= MAX_MOMENTS + 100 && reported > MAX_MOMENTS / 2, "{reported} moments");
}

#[test]
fn contacts_go_when_the_fingers_begin_to_leave() {
    let gone = fixture::changed(&fixture::hand().verified, |schedule| {
        let last = schedule.plans[0].states.last_mut().unwrap();
        let State::Fingers(FingersState { grasp, tips_um, .. }) = &mut last.state else { panic!("a state of a hand") };
        (*grasp, *tips_um) = (vec![0; 3], vec![None; 3]);
    });
    let (topics, _) = device_topics(&gone, "hand");
    let state = topic(&topics, "/hand/state");
    let leave_ns = gone.schedule().steps[2].start_ns;
    let going = state.messages.iter().rposition(|(t_ns, _)| *t_ns == leave_ns).unwrap();
    assert_eq!(going, state.messages.len() - 2);
    assert_eq!(scene(state, going - 1).entities[0].spheres.len(), 2);
    assert_eq!(scene(state, going).entities[0].spheres.len(), 0);
    assert_eq!(scene(state, going).entities[1].texts[0].text, "grasp (0, 0, 0) in xy at angle 3");
}
