use super::*;
use crate::claims::Claims;
use crate::device::instrument::{
    Bench, Direction, Drive, Instrument, InstrumentFacts, Link, StageControllerFacts, StageLimits, StageProtocol, Start,
};
use crate::source::Span;

/// The day with its first channel on a stage controller.
fn on_stage(link: Link, limits: StageLimits) -> (Schedule, Claims) {
    let (mut schedule, mut claims) = day().both();
    let facts = StageControllerFacts {
        protocol: StageProtocol::Gcs,
        axes: 1,
        rate_hz: 20e3,
        most_points: None,
        start: Start::Sender,
    };
    let mut bench = Bench::default();
    let model = "a.controller".to_owned();
    bench.instruments.insert("pi".to_owned(), Instrument { model, facts: InstrumentFacts::StageController(facts) });
    let (instrument, output) = ("pi".to_owned(), "axis1".to_owned());
    let drive = Drive { instrument, output, link, limits, span: Span::default() };
    bench.drives.insert(schedule.channels[0].name.clone(), drive);
    (schedule.bench, claims.bench) = (bench.clone(), bench);
    (schedule, claims)
}

/// A stage that is just long and fast enough, and stages that are not quite.
#[test]
fn stages_move_within_their_travel_and_no_faster_than_they_can() {
    let (schedule, _) = day().both();
    let own: Vec<&Actuation> = schedule.actuations.iter().filter(|one| one.channel == 0).collect();
    let places = || own.iter().flat_map(|one| [one.from, one.to]);
    let (low_um, high_um) = (places().fold(f64::INFINITY, f64::min), places().fold(f64::NEG_INFINITY, f64::max));
    let fastest = own.iter().map(|one| (one.to - one.from).abs() / (one.duration_ns as f64 / 1e9)).fold(0.0, f64::max);
    assert!(low_um < high_um && fastest > 0.0);
    let stage = |[least_um, most_um]: [f64; 2], direction, speed: f64| {
        let speed_um_per_s = Some(speed);
        let limits = StageLimits { speed_um_per_s, acceleration_um_per_s2: None };
        on_stage(Link::Axis { origin_um: 0.0, direction, least_um, most_um }, limits)
    };
    let both = |(schedule, claims): (Schedule, Claims)| passes(&schedule, &claims);
    both(stage([low_um, high_um], Direction::Forward, fastest));
    both(stage([-high_um, -low_um], Direction::Backward, fastest));
    let wrong = |(schedule, claims): (Schedule, Claims)| only(Rule::Wire, &schedule, &claims);
    wrong(stage([low_um + 1e-6, high_um], Direction::Forward, fastest));
    wrong(stage([low_um, high_um - 1e-6], Direction::Forward, fastest));
    wrong(stage([low_um, high_um], Direction::Backward, fastest));
    wrong(stage([low_um, high_um], Direction::Forward, fastest * 0.999));
}
