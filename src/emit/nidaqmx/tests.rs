use super::*;
use crate::device::instrument::{Bench, Drive, Instrument, Link, StageLimits, VoltageOutput};
use crate::diagnostic::Code;
use crate::emit::fixture::FixtureSchedule;
use crate::emit::{emit, fixture};
use crate::schedule::{Channel, ChannelUnit};
use crate::source::Span;

/// All voltages of a fixture on digital lines, positions on analog outputs.
pub fn on_card(fixture: FixtureSchedule, digital_rate_hz: f64) -> FixtureSchedule {
    let voltage = Some(VoltageOutput { peak_v: 10.0, bits: 16, rate_hz: 719e3 });
    let facts =
        DataAcquisitionFacts { ports: 4, lines: 32, digital_rate_hz, analog_outputs: 9, voltage, start: Start::Sender };
    let facts = InstrumentFacts::DataAcquisition(facts);
    fixture.changed(|schedule| {
        let mut bench = Bench::default();
        bench.instruments.insert("card".to_owned(), Instrument { model: "a.card".to_owned(), facts });
        for (index, Channel { name, unit, .. }) in schedule.channels.iter().enumerate() {
            let (output, link) = match unit {
                ChannelUnit::Volt => (format!("port{}.line{}", index / 32, index % 32), Link::Switch { on_v: 20.0 }),
                ChannelUnit::Micrometre => {
                    (format!("ao{index}"), Link::StageDriver { zero_v: 0.0, scale_v_per_um: 0.1 })
                }
            };
            let (instrument, limits) = ("card".to_owned(), StageLimits::default());
            bench.drives.insert(name.clone(), Drive { instrument, output, link, limits, span: Span::default() });
        }
        schedule.bench = bench;
    })
}

fn text(fixture: &FixtureSchedule) -> String {
    let files = emit(Format::Nidaqmx, &fixture.verified, &fixture.provenance).expect("the fixture can be written");
    let names: Vec<&str> = files.iter().map(|file| file.name.as_str()).collect();
    let name = &fixture.verified.schedule().name;
    assert_eq!(names, [format!("{name}.card.daq"), format!("{name}.nidaqmx.py")]);
    assert!(String::from_utf8_lossy(&files[1].bytes).contains("\"file\": \""));
    String::from_utf8(files[0].bytes.clone()).expect("a text")
}

/// The lines without comments and titles, split into cells.
fn rows(text: &str) -> Vec<Vec<String>> {
    let rows = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    rows.map(|row| row.split('\t').map(str::to_owned).collect()).collect()
}

#[test]
fn a_pulse_is_one_sample_of_its_line_and_the_last_sample_is_off() {
    let text = text(&on_card(fixture::fetch(), 1e6));
    assert!(text.contains("# port0.line0 is bot.bl0.set [V]\n") && text.contains("15000000 ns"), "{text}");
    let rows = rows(&text);
    assert_eq!(rows[0], ["1", "0x00000001"], "{text}");
    assert_eq!(rows.last().expect("a row"), &["1", "0x00000000"]);
    let samples: u64 = rows.iter().map(|row| row[0].parse::<u64>().expect("a number")).sum();
    assert_eq!(samples, 150 / 15 + 1);
}

#[test]
fn stages_are_volts_of_their_drivers() {
    let text = text(&on_card(fixture::hand(), 0.0));
    assert!(text.contains("samples\tao0 [V]\tao1 [V]"), "{text}");
    let rows = rows(&text);
    assert!((rows[0][1].parse::<f64>().expect("volts") - 2.85).abs() < 1e-12, "28.5 um at 0.1 V/um");
    assert!((rows.last().expect("a row")[3].parse::<f64>().expect("volts") - 0.5).abs() < 1e-12, "z rests at 5 um");
}

#[test]
fn what_a_card_cannot_play_is_refused() {
    let code = |fixture: FixtureSchedule| {
        let error = emit(Format::Nidaqmx, &fixture.verified, &fixture.provenance).expect_err("it cannot be played");
        error.diagnostic().code
    };
    assert_eq!(code(on_card(fixture::fetch(), 0.0)), Code::E0829);
    assert_eq!(code(fixture::fetch()), Code::E0824);
    let edge_later =
        |rate_hz: f64| on_card(fixture::fetch(), rate_hz).changed(|schedule| schedule.actuations[0].duration_ns += 1);
    assert_eq!(code(edge_later(1e9)), Code::E0823, "samples of 1 ns are more than the sender takes");
    assert_eq!(code(edge_later(1e6)), Code::E0623, "and finer than those of the card");
    let slow = |rate_hz: f64| {
        on_card(fixture::hand(), 0.0).changed(|schedule| {
            for instrument in schedule.bench.instruments.values_mut() {
                let InstrumentFacts::DataAcquisition(facts) = &mut instrument.facts else { continue };
                facts.voltage = Some(VoltageOutput { peak_v: 10.0, bits: 16, rate_hz });
            }
        })
    };
    assert_eq!(code(slow(20.0)), Code::E0624, "stages leap from sample to sample");
    assert!(emit(Format::Nidaqmx, &slow(20e3).verified, &slow(20e3).provenance).is_ok());
}

/// Nothing changes after the last edge, so the end of the schedule needs no sample of its own.
#[test]
fn an_end_between_samples_is_played_to_the_next_one() {
    let later = on_card(fixture::fetch(), 1e6).changed(|schedule| schedule.duration_ns += 1);
    let text = text(&later);
    assert!(text.contains("15000000 ns"), "{text}");
    let samples: u64 = rows(&text).iter().map(|row| row[0].parse::<u64>().expect("a number")).sum();
    assert_eq!(samples, 150 / 15 + 2);
}
