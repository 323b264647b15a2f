//! Compiles programs given as text through the compiler's public interface.

#![allow(dead_code, reason = "each test uses the part that it needs")]

use std::path::{Path, PathBuf};
use tweeze::check::Options;
use tweeze::check::imports::{FileFault, Library, NoFiles};
use tweeze::claims::electrode_array::ElectrodeArrayOrder;
use tweeze::compile::{self, CompileOutcome, ProgramSource};
use tweeze::device::electrode_array::Electrodes;
use tweeze::device::instrument::{Family, InstrumentFacts, Protocol};
use tweeze::diagnostic::Sink;
use tweeze::emit::{self, Format, OutputFile, Provenance};
use tweeze::schedule::{ChannelUnit, Schedule};
use tweeze::source::{Origin, Sources};
use tweeze::verify::Verified;

/// Result of compiling a program.
#[derive(Debug)]
pub struct Built {
    /// Every schedule in order of declaration; empty after an error.
    pub schedules: Vec<Verified>,
    /// The codes of all diagnostics by place, including warnings.
    pub codes: Vec<&'static str>,
    /// Their titles, in the same order.
    pub titles: Vec<String>,
    /// Whether the verifier, and not the checker or a planner, stopped it.
    pub refused: bool,
    provenance: Provenance,
}

/// Path of a program that once got a wrong answer.
pub fn found_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/found").join(format!("{name}.twz"))
}

/// Text of such a program.
pub fn found(name: &str) -> String {
    let path = found_path(name);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Library of the files in a folder of the project.
pub struct Folder<'a>(pub &'a Path);

impl Library for Folder<'_> {
    fn read(&self, _: &str, path: &str) -> Result<(String, String), FileFault> {
        let text = std::fs::read_to_string(self.0.join(path)).map_err(|error| error.to_string())?;
        Ok((path.to_owned(), text))
    }
}

/// Compiles a text as far as possible.
pub fn compiled(library: &dyn Library, text: &str) -> (CompileOutcome, Sources, Sink) {
    let options = Options::default();
    let program = ProgramSource { name: "test.twz", text, library, options: &options };
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let outcome = compile::compile(&program, &mut sources, &mut sink, &mut ());
    (outcome, sources, sink)
}

/// Compiles a text whose used files are in a folder.
pub fn build_in(folder: &Path, text: &str) -> Built {
    let (outcome, sources, sink) = compiled(&Folder(folder), text);
    let (schedules, refused) = match outcome {
        CompileOutcome::Compiled(compiled) => (compiled.schedules, false),
        CompileOutcome::Errors => (Vec::new(), false),
        CompileOutcome::Refused => (Vec::new(), true),
    };
    let codes = sink.sorted().into_iter().map(|diagnostic| diagnostic.code.name()).collect();
    let titles = sink.sorted().into_iter().map(|diagnostic| diagnostic.title.clone()).collect();
    let own = sources.files().filter(|(_, file)| file.origin == Origin::User);
    let files = own.map(|(_, file)| (file.name.clone(), file.text.to_string())).collect();
    Built {
        schedules,
        codes,
        titles,
        refused,
        provenance: Provenance { files, settings: Vec::new(), is_recorded: false },
    }
}

/// Compiles a text that uses no file beside it.
pub fn build(text: &str) -> Built {
    build_in(Path::new("."), text)
}

impl Built {
    /// Every file of every format that can represent it: G-code is for stages only, and instruments play what is wired
    /// to them.
    pub fn files(&self) -> Vec<OutputFile> {
        let mut files = Vec::new();
        for verified in &self.schedules {
            let are_stages = verified.schedule().channels.iter().all(|channel| channel.unit == ChannelUnit::Micrometre);
            let instruments = verified.schedule().bench.instruments.values();
            let families: Vec<Family> = instruments.map(|instrument| instrument.facts.family()).collect();
            let drivers = verified.schedule().bench.instruments.values().filter_map(|driver| match &driver.facts {
                InstrumentFacts::ElectrodeDriver(facts) => Some(facts.protocol),
                InstrumentFacts::WaveformGenerator(_)
                | InstrumentFacts::DataAcquisition(_)
                | InstrumentFacts::StageController(_)
                | InstrumentFacts::MachineController(_) => None,
            });
            let protocols: Vec<Protocol> = drivers.collect();
            let has_electrodes_alone = !switches_accessories(verified.schedule());
            let is_played = |format: &&Format| match format {
                Format::Gcode => are_stages,
                Format::Scpi => families.contains(&Family::WaveformGenerator),
                Format::Nidaqmx => families.contains(&Family::DataAcquisition),
                Format::Frames => families.contains(&Family::ElectrodeDriver),
                Format::Stages => families.contains(&Family::StageController),
                Format::Opendrop => has_electrodes_alone && protocols.contains(&Protocol::Opendrop),
                Format::Microdrop => has_electrodes_alone && protocols.iter().any(|protocol| protocol.has_microdrop()),
                Format::Sheet => carries_droplets(verified),
                // These have a single clock and cannot wait.
                Format::Csv | Format::Vcd | Format::Pwl => verified.schedule().holds.is_empty(),
                Format::Mcap | Format::Json | Format::Html | Format::Svg => true,
            };
            for format in Format::ALL.iter().filter(is_played) {
                let set = emit::emit(*format, verified, &self.provenance);
                files.extend(set.unwrap_or_else(|error| panic!("{}: {error:?}", format.name())));
            }
        }
        files
    }
}

/// Whether a magnet or heater of an electrode driver is wired; of the board formats only `frames` supports them.
pub fn switches_accessories(schedule: &Schedule) -> bool {
    schedule.bench.drives.values().any(|drive| ["magnet", "heater"].iter().any(|name| drive.output.starts_with(name)))
}

/// Whether a board of the schedule carries droplets, each on a single electrode.
pub fn carries_droplets(verified: &Verified) -> bool {
    verified.claims().jobs.iter().any(|job| {
        let board = ElectrodeArrayOrder::of(&job.order);
        board.is_some_and(|board| board.facts.layout.electrodes == Electrodes::Single)
    })
}

/// The codes and helps of a text that uses no other file.
pub fn complaints(text: &str) -> (Vec<&'static str>, Vec<String>) {
    let (_, _, sink) = compiled(&NoFiles, text);
    let sorted = sink.sorted();
    let codes = sorted.iter().map(|diagnostic| diagnostic.code.name()).collect();
    (codes, sorted.iter().filter_map(|diagnostic| diagnostic.help.clone()).collect())
}
