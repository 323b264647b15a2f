use super::drawing::{PaperView, PlacedLabel, decimal};
use super::strobe::{MAX_STROBES, StrobedPlace, Strobes, ranges};
use super::*;
use crate::emit::{fixture, picture_at};
use crate::schedule::State;
use crate::schedule::dimibot::DimibotState;
use crate::schedule::fingers::FingersState;
use std::collections::BTreeSet;

fn text(verified: &Verified, moment_ns: Option<u64>) -> String {
    String::from_utf8(write(verified, moment_ns).expect("the fixture can be drawn")).expect("SVG is text")
}

fn count(text: &str, what: &str) -> usize {
    text.matches(what).count()
}

#[test]
fn numbers_have_one_form() {
    let shown = [0.0, -0.0, -0.0004, 1.0, 1.0005, -2.5, 1e-9, 120.0].map(number);
    assert_eq!(shown, ["0", "0", "0", "1", "1", "-2.5", "0", "120"]);
    assert_eq!(decimal(100.0, 0), "100");
}

#[test]
fn every_text_is_safe() {
    assert_eq!(escaped("a<b>&\"c\"'\u{1}\n"), "a&lt;b&gt;&amp;&quot;c&quot;&#39;\u{fffd} ");
    let fetch = fixture::fetch().verified;
    let named = fixture::changed(&fetch, |schedule| schedule.name = "<b>&\"'\u{0}".to_owned());
    let text = text(&named, None);
    assert!(text.contains("<title>&lt;b&gt;&amp;&quot;&#39;\u{fffd}</title>"));
    assert!(!text.contains("<b>"));
}

#[test]
fn colours_are_those_of_the_page() {
    let page = concat!(include_str!("../../../assets/page/page.css"), include_str!("../../../assets/page/scene.js"));
    let own = include_str!("drawing.rs").split("pub mod color").nth(1).unwrap_or_default();
    let colors: Vec<&str> = own.split('"').filter(|word| word.starts_with('#') && word.len() == 7).collect();
    assert!(colors.len() > 20);
    for color in colors {
        assert!(page.contains(color), "{color}");
    }
}

#[test]
fn numbers_in_a_row_are_ranges() {
    assert_eq!(ranges(&[1]), "1");
    assert_eq!(ranges(&[1, 2, 4, 5, 6, 9]), "1, 2, 4–6, 9");
}

#[test]
fn strobes_are_few_with_the_ends_and_the_stops() {
    let few: BTreeSet<u64> = (0..5).collect();
    assert_eq!(Strobes::chosen(&few, &few, 12), Strobes { instants: vec![0, 1, 2, 3, 4], note: None });
    let many: BTreeSet<u64> = (0..1000).collect();
    let stops = BTreeSet::from([17, 400, 401]);
    let chosen = Strobes::chosen(&many, &stops, MAX_STROBES);
    assert_eq!(chosen.instants.len(), MAX_STROBES);
    assert!([0, 17, 400, 401, 999].iter().all(|stop| chosen.instants.contains(stop)));
    assert!(chosen.note.as_ref().is_some_and(|note| note.contains("12 of 1000 states") && note.contains("all stops")));
    let chosen = Strobes::chosen(&many, &many, MAX_STROBES);
    assert_eq!((chosen.instants.len(), chosen.instants[0], chosen.instants[11]), (12, 0, 999));
    assert!(chosen.note.is_some_and(|note| note.contains("12 of 1000 stops")));
}

#[test]
fn places_on_one_spot_share_a_label() {
    let strobes = Strobes { instants: vec![0, 10, 20, 30], note: None };
    let places = StrobedPlace::all(&strobes, |t_ns| Some([if t_ns == 20 { 5.0 } else { 0.0 }, 0.0]));
    assert_eq!(places.len(), 2);
    assert_eq!((ranges(&[1, 2, 4]), places[0].instants()), ("1, 2, 4".to_owned(), "0 10 30".to_owned()));
    let near = StrobedPlace::clustered(places.iter().map(|place| (place, [place.place[0] / 2.0, 0.0])));
    assert_eq!(near, [([0.0, 0.0], vec![1, 2, 3, 4])]);
}

#[test]
fn labels_keep_apart_and_inside() {
    let room = PaperBox { left: 0.0, top: 0.0, right: 60.0, bottom: 60.0 };
    let mut to = Drawing::default();
    for _ in 0..40 {
        let text_style = TextStyle::SMALL;
        to.label(PlacedLabel { text: "12".to_owned(), text_style, at: [30.0, 30.0], radius_pt: 2.0, may_cover: false });
    }
    let left_out = to.place_labels(room);
    let body = to.into_body();
    let shown = count(&body, "<text");
    assert_eq!(shown + left_out, 40);
    assert!((4..=24).contains(&shown), "{shown}");
}

#[test]
fn a_view_keeps_shapes_and_fits() {
    let room = PaperBox { left: 10.0, top: 20.0, right: 110.0, bottom: 70.0 };
    let view = PaperView::fitted([[0.0, 0.0], [10.0, 10.0]], room);
    assert_eq!(view.scale, 5.0);
    assert_eq!(view.at([0.0, 0.0]), [35.0, 70.0]);
    assert_eq!(view.at([10.0, 10.0]), [85.0, 20.0]);
}

#[test]
fn a_robot_is_drawn_with_its_stops_and_modules() {
    let fetch = fixture::fetch().verified;
    let text = text(&fetch, None);
    assert_eq!(count(&text, "data-module="), 10);
    assert_eq!(count(&text, "data-stop="), 2);
    assert!(count(&text, "data-t-ns=") >= 9);
    let words: Vec<&str> = text.split("<text ").filter_map(|rest| rest.split(['>', '<']).nth(1)).collect();
    assert!(words.join(" ").contains("not proven optimal (bound 0.1 µm)"), "{words:?}");
    for forbidden in ["<script", "<style", "href", "@import", "<image", "<foreignObject"] {
        assert!(!text.contains(forbidden), "{forbidden}");
    }
}

/// The states of a plan are drawn at their positions, also one by one.
#[test]
fn at_a_state_the_place_of_the_state_is_drawn() {
    let fetch = fixture::fetch().verified;
    for timed in &fetch.schedule().plans[0].states {
        let State::Dimibot(DimibotState { position_um: [x, y], .. }) = timed.state else {
            panic!("a state of a robot")
        };
        let place = format!("data-x-um=\"{}\" data-y-um=\"{}\"", decimal(x, 6), decimal(y, 6));
        let text = text(&fetch, Some(timed.t_ns));
        assert!(text.contains(&place), "{place} at {}", timed.t_ns);
    }
    let hand = fixture::hand().verified;
    for timed in &hand.schedule().plans[0].states {
        let State::Fingers(FingersState { position_um, .. }) = &timed.state else { panic!("a state of a hand") };
        let [x, y, z] = position_um.map(|value| decimal(value, 6));
        let place = format!("data-x-um=\"{x}\" data-y-um=\"{y}\" data-z-um=\"{z}\"");
        assert!(text(&hand, Some(timed.t_ns)).contains(&place), "{place} at {}", timed.t_ns);
    }
}

#[test]
fn every_kind_is_drawn_at_any_instant_of_it() {
    for make in [fixture::fetch, fixture::pair, fixture::large, fixture::idle, fixture::bed, fixture::hand] {
        let verified = make().verified;
        let last_ns = verified.schedule().duration_ns;
        for t_ns in [0, last_ns.min(1), last_ns / 3, last_ns / 2, last_ns] {
            let text = text(&verified, Some(t_ns));
            assert!(text.contains(&format!("data-t-ns=\"{t_ns}\"")), "{} at {t_ns}", verified.schedule().name);
        }
        let late = picture_at(&verified, last_ns + 1).expect_err("it is over by then").diagnostic();
        assert!(late.title.contains("after the end"), "{}", late.title);
        assert!(text(&verified, None).starts_with("<?xml"));
    }
}
