use super::*;
use crate::device::instrument::{Awaited, Bench, Direction, Drive, HoldTerms, Instrument, StageLimits};
use crate::diagnostic::Code;
use crate::emit::fixture::FixtureSchedule;
use crate::emit::{Provenance, emit, fixture};
use crate::schedule::{Actuation, ScheduledHold};
use crate::source::Span;

/// A controller of PI with three axes.
pub fn gcs(most_points: u32) -> StageControllerFacts {
    StageControllerFacts {
        protocol: StageProtocol::Gcs,
        axes: 3,
        rate_hz: 20e3,
        most_points: Some(most_points),
        start: Start::Sender,
    }
}

/// A controller of SmarAct with nine axes.
pub fn mcs2() -> StageControllerFacts {
    StageControllerFacts {
        protocol: StageProtocol::Mcs2,
        axes: 9,
        rate_hz: 1e3,
        most_points: None,
        start: Start::Sender,
    }
}

/// The stages of a fixture on as many controllers as needed; all but the first wait for it. Every other stage counts
/// backwards.
pub fn on_controllers(fixture: FixtureSchedule, facts: &StageControllerFacts) -> FixtureSchedule {
    fixture.changed(|schedule| {
        let mut bench = Bench::default();
        for (index, channel) in schedule.channels.iter().enumerate() {
            let [controller, axis] = [index / facts.axes as usize, index % facts.axes as usize];
            let start = if controller == 0 { facts.start } else { Start::Trigger };
            let name = format!("pi{}", controller + 1);
            let own = StageControllerFacts { start, ..facts.clone() };
            let model = "a.controller".to_owned();
            bench.instruments.insert(name.clone(), Instrument { model, facts: InstrumentFacts::StageController(own) });
            let direction = Direction::ALL[index % 2];
            let link = Link::Axis { origin_um: 50.0, direction, least_um: -20.0, most_um: 120.0 };
            let (output, limits, span) = (format!("axis{}", axis + 1), StageLimits::default(), Span::default());
            bench.drives.insert(channel.name.clone(), Drive { instrument: name, output, link, limits, span });
        }
        schedule.bench = bench;
    })
}

/// The rows of a table: the point number, and the place of each axis.
fn rows(text: &str) -> Vec<(u64, Vec<f64>)> {
    let rows = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    let cells = |row: &str| row.split(',').map(|cell| cell.parse::<f64>().expect("a number")).collect::<Vec<f64>>();
    rows.map(|row| (cells(row)[0] as u64, cells(row)[1..].to_vec())).collect()
}

fn tables(fixture: &FixtureSchedule) -> Vec<String> {
    let files = emit(Format::Stages, &fixture.verified, &fixture.provenance).expect("the fixture can be written");
    let texts = files.into_iter().filter(|file| file.name.ends_with(".csv"));
    texts.map(|file| String::from_utf8(file.bytes).expect("a text")).collect()
}

/// Place of an axis at a point, interpolated linearly between rows.
fn between(rows: &[(u64, Vec<f64>)], axis: usize, point: f64) -> f64 {
    let after = rows.iter().position(|row| row.0 as f64 >= point).expect("an instant of the schedule").max(1);
    let [(a, before), (b, behind)] = [&rows[after - 1], &rows[after]];
    before[axis] + (behind[axis] - before[axis]) * (point - *a as f64) / (b - a) as f64
}

#[test]
fn stages_are_where_the_schedule_has_them_within_what_a_corner_is_cut() {
    for (facts, period_ns) in [(gcs(1 << 20), 50e3), (gcs(9000), 100e3), (mcs2(), 1e6)] {
        let fixture = on_controllers(fixture::hand(), &facts);
        let (schedule, signals) = (fixture.verified.schedule(), Signals::new(fixture.verified.schedule()));
        let tables = tables(&fixture);
        assert_eq!(tables.len(), schedule.channels.len().div_ceil(facts.axes as usize));
        for (channel, name) in schedule.channels.iter().map(|channel| &channel.name).enumerate() {
            let [table, axis] = [channel / facts.axes as usize, channel % facts.axes as usize];
            let text = &tables[table];
            assert!(text.contains(&format!("{period_ns} ns")) && text.contains(&format!("is {name}, ")), "{text}");
            let rows = rows(text);
            let sharpest = schedule.speed_jumps(channel).iter().map(|jump| jump.change_um_per_s).fold(0.0, f64::max);
            let sign = if channel % 2 == 0 { 1.0 } else { -1.0 };
            for t_ns in (0..=schedule.duration_ns).step_by(9_973).chain(signals.breaks([channel])) {
                let at_um = (between(&rows, axis, t_ns as f64 / period_ns) - 50.0) * sign;
                let off_um = (at_um - signals.value(channel, t_ns)).abs();
                assert!(
                    off_um <= corner_cut_um(sharpest, period_ns / 1e9) + 1e-6,
                    "{name} is {off_um} um off at {t_ns} ns"
                );
            }
        }
    }
}

#[test]
fn what_a_wait_holds_is_no_row_of_the_part_before_it() {
    let waits = |fixture: FixtureSchedule| {
        fixture.changed(|schedule| {
            let (start_ns, duration_ns) = (schedule.duration_ns, 60_000_000_000);
            let places: Vec<f64> = {
                let signals = Signals::new(schedule);
                (0..schedule.channels.len()).map(|channel| signals.value(channel, start_ns)).collect()
            };
            for (channel, place_um) in (0..).zip(places) {
                let (from, to) = (place_um, place_um);
                schedule.actuations.push(Actuation { channel, start_ns, duration_ns, from, to, swing: None, step: 0 });
            }
            let awaited = Awaited::Person { prompt: "look".into() };
            let terms = HoldTerms { awaited, duration_ns, is_bounded: false };
            schedule.holds.push(ScheduledHold { step: 0, start_ns, terms });
            schedule.duration_ns += duration_ns;
        })
    };
    for facts in [gcs(1 << 20), mcs2()] {
        let (plain, waiting) = (fixture::hand(), waits(fixture::hand()));
        let [plain, waiting] = [plain, waiting].map(|fixture| tables(&on_controllers(fixture, &facts)));
        assert_eq!(plain, waiting, "the wait is at the end, where nothing is played behind it");
    }
}

#[test]
fn a_controller_says_whether_it_leads_or_follows() {
    let files = emit(Format::Stages, &on_controllers(fixture::hand(), &gcs(1 << 20)).verified, &Provenance::default())
        .expect("files");
    let names: Vec<&str> = files.iter().map(|file| file.name.as_str()).collect();
    assert_eq!(names, ["turn.pi1.stages.csv", "turn.pi2.stages.csv", "turn.pi3.stages.csv", "turn.stages.py"]);
    let sender = String::from_utf8_lossy(&files[3].bytes);
    assert_eq!(sender.matches("\"leads\": true").count(), 1);
    assert_eq!(sender.matches("\"waits_for_trigger\": true").count(), 2);
}

#[test]
fn what_a_controller_cannot_play_is_refused() {
    let code = |fixture: FixtureSchedule| {
        let error = emit(Format::Stages, &fixture.verified, &fixture.provenance).expect_err("it cannot be played");
        error.diagnostic().code
    };
    assert_eq!(code(fixture::hand()), Code::E0824, "no controller");
    assert_eq!(code(on_controllers(fixture::hand(), &gcs(40))), Code::E0823, "points too far apart");
    let few = StageControllerFacts { axes: 3, ..mcs2() };
    assert_eq!(code(on_controllers(fixture::hand(), &few)), Code::E0831, "streams that begin apart");
    let alone = StageControllerFacts { start: Start::Trigger, ..mcs2() };
    assert_eq!(code(on_controllers(fixture::hand(), &alone)), Code::E0831);
    let jump = on_controllers(fixture::hand(), &gcs(1 << 20)).changed(|schedule| {
        schedule.actuations.iter_mut().take(1).for_each(|one| one.to += 1.0);
    });
    assert_eq!(code(jump), Code::E0826);
}
