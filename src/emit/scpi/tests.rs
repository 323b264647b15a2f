use super::*;
use crate::diagnostic::Code;
use crate::emit::fixture::FixtureSchedule;
use crate::emit::tests::bench::{generator, on, on_generators};
use crate::emit::{Provenance, emit, fixture};
use crate::schedule::{Actuation, Channel, ChannelUnit};

/// The script, its description and the sender.
fn files(fixture: &FixtureSchedule) -> [(String, Vec<u8>); 3] {
    let files = emit(Format::Scpi, &fixture.verified, &fixture.provenance).expect("the fixture can be written");
    let files: Vec<(String, Vec<u8>)> = files.into_iter().map(|file| (file.name, file.bytes)).collect();
    files.try_into().expect("three files")
}

fn notes(fixture: &FixtureSchedule) -> String {
    let [_, (_, notes), _] = files(fixture);
    String::from_utf8(notes).expect("a text")
}

fn code(fixture: &FixtureSchedule) -> Code {
    emit(Format::Scpi, &fixture.verified, &fixture.provenance).expect_err("it cannot be played").diagnostic().code
}

/// The samples of a block.
fn codes(script: &[u8], head: &[u8]) -> Vec<i16> {
    let at = script.windows(head.len()).position(|window| window == head).expect("the block is there") + head.len();
    let digits = usize::from(script[at] - b'0');
    let length: usize = std::str::from_utf8(&script[at + 1..at + 1 + digits]).unwrap().parse().unwrap();
    let block = &script[at + 1 + digits..][..length];
    block.chunks(2).map(|pair| i16::from_be_bytes([pair[0], pair[1]])).collect()
}

#[test]
fn a_script_begins_and_ends_at_zero_and_puts_every_edge_on_a_sample() {
    let fetch = on_generators(fixture::fetch());
    let [(name, script), (_, notes), (sender, program)] = files(&fetch);
    assert_eq!((name.as_str(), sender.as_str()), ("fetch.awg.scpi", "fetch.scpi.py"));
    let expected: Vec<i16> =
        [0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0].map(|on| if on == 1 { i16::MAX } else { -i16::MAX }).to_vec();
    assert_eq!(codes(&script, b":SOUR1:DATA:ARB:DAC CH1,#"), expected);
    let text = String::from_utf8_lossy(&script).into_owned();
    let head = "\n:SOUR1:FUNC:ARB:FILT OFF\n:SOUR1:FUNC:ARB:SRAT 66.66666666666667\n:OUTP1:LOAD INF\n:SOUR1:VOLT 0.4\n:SOUR1:VOLT:OFFS 0.2\n";
    assert!(text.contains(head), "{text}");
    assert!(text.starts_with("*RST\n*CLS\n") && text.ends_with(":OUTP20 ON\n:SYST:ERR?\n*TRG\n"));
    let notes = String::from_utf8(notes).unwrap();
    assert!(notes.contains("ch1\t0\t0.4\tbot.bl0.set\tamplifier x 50\t0.000305 V\tDev1/port0/line0\n"), "{notes}");
    let program = String::from_utf8(program).unwrap();
    assert!(program.contains("\"file\": \"fetch.awg.scpi\"") && !program.contains(hold_parts::PLAYS), "{program}");
}

#[test]
fn an_output_with_one_voltage_is_a_dc_source() {
    let [(_, script), ..] = files(&on_generators(fixture::fetch()));
    let text = String::from_utf8_lossy(&script).into_owned();
    let idle =
        (1..=20).find(|output| !text.contains(&format!("DATA:ARB:DAC CH{output},"))).expect("a module never moves");
    assert!(text.contains(&format!("\n:SOUR{idle}:FUNC DC\n:SOUR{idle}:VOLT:OFFS 0\n:SYST:ERR?\n")), "{text}");
}

#[test]
fn what_the_memory_does_not_take_is_refused() {
    let with = |most_points| on(fixture::fetch(), WaveformGeneratorFacts { most_points, ..generator() });
    assert_eq!(files(&with(12))[0].0, "fetch.awg.scpi");
    assert_eq!(code(&with(11)), Code::E0823);
    let error = emit(Format::Scpi, &with(11).verified, &Provenance::default()).unwrap_err().diagnostic();
    assert_eq!(error.title, "the schedule of 150000000 ns needs 12 points of 15000000 ns; `awg` takes at most 11");
    let later = |ns| {
        let edge = with(1_000_000).changed(|schedule| schedule.actuations[0].duration_ns += ns);
        code(&edge)
    };
    assert_eq!(later(16), Code::E0823, "16 ns are its shortest sample");
    assert_eq!(later(1), Code::E0623);
    assert_eq!(code(&fixture::fetch()), Code::E0824);
}

#[test]
fn a_train_is_a_step_of_a_sequence() {
    let train = on_generators(fixture::train(1_200_000));
    let [(_, script), (_, notes), _] = files(&train);
    let script = String::from_utf8_lossy(&script).into_owned();
    let steps = "\"CH1\",\"CH1_1\",1,onceWaitTrig,lowAtStart,4,\"CH1_1\",5,repeat,lowAtStart,4,\"CH1_2\",5,repeat,lowAtStart,4,\
                 \"CH1_3\",300000,repeat,lowAtStart,4,\"CH1_1\",1,repeatInf,lowAtStart,4";
    assert!(script.contains(&format!("\n:SOUR1:DATA:SEQ #3{}{steps}\n", steps.len())), "{script}");
    assert!(script.contains("\n:SOUR1:FUNC:ARB CH1\n:SOUR1:FUNC:ARB:FILT OFF\n:SOUR1:FUNC:ARB:SRAT 40000\n"));
    let notes = String::from_utf8(notes).unwrap();
    assert!(notes.contains("\nch1\t4\tCH1_3\t8\t300000\trepeat\t80\n"), "{notes}");
    let little = |most_points| on(fixture::bed(), WaveformGeneratorFacts { most_steps: 3, most_points, ..generator() });
    assert_eq!(files(&little(10_000))[0].0, "bed.awg.scpi", "all of it written out");
    assert_eq!(code(&little(1_000)), Code::E0823);
    let error = emit(Format::Scpi, &little(1_000).verified, &Provenance::default()).unwrap_err().diagnostic();
    assert!(error.title.contains("in at most 3 steps"), "{}", error.title);
}

#[test]
fn stages_wait_and_rest_where_they_are() {
    let hand = on_generators(fixture::hand());
    let [(_, script), (_, notes), _] = files(&hand);
    let notes = String::from_utf8(notes).unwrap();
    // At most 28.5 um in 20 ms: 0.05 um take 35 us, rounded down to 20 us.
    assert!(notes.contains("a stage moves by\n0.0"), "{notes}");
    assert!(
        notes.contains("ch3\t-1\t-0.5\thand.f1.z\tstage driver, 0.1 V/um from -1 V on\t0.0000763 um\t-\n"),
        "{notes}"
    );
    let codes = codes(&script, b":SOUR3:DATA:ARB:DAC CH3,#");
    assert_eq!((codes[0], codes.last()), (-i16::MAX, Some(&i16::MAX)), "z goes from 0 um to 5 um");
    assert!(codes.windows(2).all(|pair| pair[0] <= pair[1]), "z only rises");
}

#[test]
fn stages_are_sampled_within_the_period_of_voltages() {
    let both = |period_ns: u64| {
        let changed = fixture::hand().changed(|schedule| {
            let name = "plate.e1_1".to_owned();
            schedule.channels.push(Channel {
                name,
                device: "plate".into(),
                unit: ChannelUnit::Volt,
                wire: None,
                rest_v: 0.0,
            });
            let pulse = Actuation { channel: 9, from: 50.0, to: 50.0, ..schedule.actuations[0] };
            schedule.actuations.push(Actuation { start_ns: period_ns, duration_ns: 3 * period_ns, ..pulse });
        });
        on_generators(changed)
    };
    let period = |fixture: &FixtureSchedule| {
        notes(fixture).split("A sample lasts ").nth(1).unwrap().split(' ').next().unwrap().parse::<u64>().unwrap()
    };
    let alone_ns = period(&on_generators(fixture::hand()));
    assert_eq!(period(&both(3_000_000)), 3_000_000 / 3_000_000u64.div_ceil(alone_ns));
    assert_eq!(code(&both(17)), Code::E0823);
    assert_eq!(code(&both(7)), Code::E0623);
}
