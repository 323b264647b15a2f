//! Fixtures with instruments wired to their channels.

use crate::device::instrument::{
    AXIS_LETTERS, Bench, Direction, Drive, Instrument, InstrumentFacts, Link, MachineControllerFacts, StageLimits,
    Start, VoltageOutput, WaveformGeneratorFacts,
};
use crate::emit::fixture::FixtureSchedule;
use crate::schedule::ChannelUnit;
use crate::source::Span;

/// A common laboratory generator, but with an output for every channel.
pub fn generator() -> WaveformGeneratorFacts {
    WaveformGeneratorFacts {
        outputs: 4096,
        voltage: VoltageOutput { peak_v: 10.0, bits: 16, rate_hz: 62.5e6 },
        least_points: 8,
        most_points: 1_000_000,
        most_steps: 512,
        start: Start::Sender,
    }
}

/// A generator that plays every nanosecond, unlike any real one.
pub fn fast_generator() -> WaveformGeneratorFacts {
    let generator = generator();
    WaveformGeneratorFacts { voltage: VoltageOutput { rate_hz: 1e9, ..generator.voltage }, ..generator }
}

/// All channels on one generator `awg`: voltages behind a 50x amplifier, positions behind drivers of 0.1 V/um from -1
/// V.
pub fn on_generators(fixture: FixtureSchedule) -> FixtureSchedule {
    on(fixture, generator())
}

/// All channels on a generator with these facts.
pub fn on(fixture: FixtureSchedule, facts: WaveformGeneratorFacts) -> FixtureSchedule {
    fixture.changed(|schedule| {
        let facts = InstrumentFacts::WaveformGenerator(facts);
        let mut bench = Bench::default();
        bench.instruments.insert("awg".to_owned(), Instrument { model: "a.rack".to_owned(), facts });
        for (index, channel) in schedule.channels.iter().enumerate() {
            let link = match channel.unit {
                ChannelUnit::Volt => Link::Amplifier { gain: 50.0, limit_v: None, slew_v_per_s: None },
                ChannelUnit::Micrometre => Link::StageDriver { zero_v: -1.0, scale_v_per_um: 0.1 },
            };
            let output = format!("ch{}", index + 1);
            let (instrument, limits) = ("awg".to_owned(), StageLimits::default());
            let drive = Drive { instrument, output, link, limits, span: Span::default() };
            bench.drives.insert(channel.name.clone(), drive);
        }
        schedule.bench = bench;
    })
}

/// The nine stages of a hand as the axes of a machine, the first channel on the last letter; every other stage counts
/// backwards from the middle of its travel of 1 mm.
pub fn on_machine(fixture: FixtureSchedule) -> FixtureSchedule {
    fixture.changed(|schedule| {
        let facts = InstrumentFacts::MachineController(MachineControllerFacts { axes: 9, rate_hz: 20e3 });
        let mut bench = Bench::default();
        bench.instruments.insert("mill".to_owned(), Instrument { model: "a.machine".to_owned(), facts });
        for (index, channel) in schedule.channels.iter().enumerate() {
            let link =
                Link::Axis { origin_um: 500.0, direction: Direction::ALL[index % 2], least_um: 0.0, most_um: 1000.0 };
            let output = AXIS_LETTERS[AXIS_LETTERS.len() - 1 - index].to_string();
            let (instrument, limits) = ("mill".to_owned(), StageLimits::default());
            let drive = Drive { instrument, output, link, limits, span: Span::default() };
            bench.drives.insert(channel.name.clone(), drive);
        }
        schedule.bench = bench;
    })
}
