//! In-vitro panels: every sample is mixed with every reagent. Each mixture rests where it was merged, queues for the
//! detector of its reagent and leaves. For comparison, the same operations run as consecutive steps, as a board
//! without assays would do.
//!
//! Also three families of published assays (PCR mixing tree, in-vitro diagnostics 1 to 5, protein dilution; MFSim's
//! B1, B2 and B4) on 15 x 19 electrodes at 100 Hz: fluids are dispensed from their ports in 2 s, mixed around 4 x 2
//! electrodes at eight places, and split in 2 s.

use super::clock;
use super::programs::{Answered, answered};
use tweeze::plan::Plan;

/// Samples and reagents of the panels.
const PANELS: [(u32, u32); 7] = [(2, 2), (2, 3), (3, 3), (3, 4), (4, 4), (4, 5), (5, 5)];

pub fn table() {
    println!("\nassays: in-vitro panels on droplet_chip, separation 2; planned, lowered and verified");
    println!("samples x reagents  droplets  operations  electrodes     ms   steps  bound  ratio | one after the other");
    for (samples, reagents) in PANELS {
        let (time, plan) = clock::timed(|| planned(&panel(samples, reagents, "assay {\n", "}\n")));
        let serial = planned(&panel(samples, reagents, "", ""));
        let pairs = samples * reagents;
        let (columns, rows) = size(samples, reagents);
        println!(
            "{samples:7} x {reagents:<8}  {:8}  {:10}  {:4} x {rows:<3} {:6.0}  {:6}  {:5}  {:5.3} | {}",
            2 * pairs,
            4 * pairs,
            columns,
            1e3 * time.as_secs_f64(),
            plan.cost,
            plan.bound,
            plan.cost / plan.bound,
            serial.cost
        );
    }
}

/// Samples and reagents of the published in-vitro assays; then, for each sample, how long its mixtures are mixed and
/// read, in seconds.
const IN_VITRO: [(u32, u32); 5] = [(2, 2), (2, 3), (3, 3), (3, 4), (4, 4)];
const SAMPLE_S: [u32; 4] = [5, 3, 4, 6];

const FIELD_BOARD: &str = "use std.electrode_array as ea\n\
    device chip : ea.droplet_chip {\n\
    columns: 15, rows: 19, step_duration: 10 ms, settling: 8 ms, dispense_duration: 2 s, mixer: (4, 2)\n}\n";

/// Levels of splits of the protein assays; then of those with more leaves than places, and of those that take minutes.
const PROTEIN: [u32; 3] = [1, 2, 3];
const DEEP_PROTEIN: [u32; 4] = [4, 5, 6, 7];
const LONG_PROTEIN: [u32; 3] = [9, 10, 12];

pub fn field_table() {
    println!("\npublished assays on 15 x 19 electrodes at 100 Hz; planned, lowered and verified");
    println!("assay       droplets  operations     ms   steps  bound  ratio | one after the other");
    let panels = |mixing: MixingPlace| {
        let named = move |((samples, reagents), number): (&(u32, u32), u32)| {
            (format!("in-vitro {number}"), in_vitro(*samples, *reagents, mixing))
        };
        IN_VITRO.iter().zip(1..).map(named)
    };
    let protein = PROTEIN.iter().map(|levels| (format!("protein {levels}"), protein(*levels)));
    for (name, program) in std::iter::once(("PCR".to_owned(), pcr())).chain(panels(MixingPlace::InTurn)).chain(protein)
    {
        row(&name, &program, program.one_after_the_other());
    }
    println!("the same in-vitro assays, at those of the eight places that the plan chooses");
    for (name, program) in panels(MixingPlace::Open) {
        row(&name, &program, None);
    }
    println!("more leaves than places; beside the bound that of eight places with no way between them, in any order");
    deep_protein(&DEEP_PROTEIN);
}

/// Thousands of droplets, each protein dilution twice as long as the one before.
pub fn long_table() {
    println!("\nlong assays on 15 x 19 electrodes at 100 Hz; planned, lowered and verified");
    deep_protein(&LONG_PROTEIN);
}

fn deep_protein(levels: &[u32]) {
    for &levels in levels {
        let program = super::protein::protein(levels);
        row(&format!("protein {levels}"), &program, Some(f64::from(50 * (1 << levels) - 5) * 100.0 / 8.0));
    }
}

fn row(name: &str, program: &FieldAssay, beside: Option<f64>) {
    let (time, plan) = clock::timed(|| planned(&program.text("assay {\n", "}\n")));
    println!(
        "{name:10}  {:8}  {:10}  {:5.0}  {:6}  {:5}  {:5.3} | {}",
        program.droplets,
        program.operations.len(),
        1e3 * time.as_secs_f64(),
        plan.cost,
        plan.bound,
        plan.cost / plan.bound,
        beside.map_or("none".to_owned(), |steps| format!("{steps:.0}"))
    );
}

/// The corner of a mixer, numbered 0 to 7: droplets can pass between the mixers, and to the ports.
pub fn place(number: u32) -> (u32, u32) {
    (4 + 5 * (number % 2), 3 + 5 * (number / 2))
}

/// A published assay.
#[derive(Default)]
pub struct FieldAssay {
    pub droplets: u32,
    /// Reservoirs and parts.
    pub scene: Vec<String>,
    pub operations: Vec<String>,
}

impl FieldAssay {
    pub fn reservoir(&mut self, name: &str, at: (u32, u32)) {
        self.scene.push(format!("reservoir {name} at {at:?}"));
    }

    fn dispense(&mut self, droplet: &str, from: &str) {
        self.droplets += 1;
        self.scene.push(format!("part {droplet} : ea.droplet"));
        self.operations.push(format!("dispense {droplet} from {from}"));
    }

    fn mix(&mut self, one: &str, other: &str, at: (u32, u32), time_s: u32) {
        self.operations.push(format!("merge {one} with {other} at {at:?}"));
        self.operations.push(format!("mix {one} for {time_s} s"));
    }

    /// Total steps when the operations run as consecutive steps of a task; `None` if one of them has no plan, because
    /// waiting droplets may block it.
    fn one_after_the_other(&self) -> Option<f64> {
        match answered(&self.text("", "")) {
            Answered::Plan(plan) => Some(plan.cost),
            Answered::Errors(_) | Answered::Unfit => None,
        }
    }

    /// The program, with the given text before and after its operations.
    fn text(&self, before: &str, after: &str) -> String {
        let (scene, operations) = (self.scene.join("\n"), self.operations.join("\n"));
        format!(
            "{FIELD_BOARD}scene board {{\n{scene}\n}}\ntask run on chip in board {{\n{before}{operations}\n{after}}}\n"
        )
    }
}

/// Eight fluids, mixed in pairs for 3 s, repeatedly until one droplet is left.
fn pcr() -> FieldAssay {
    let mut assay = FieldAssay::default();
    for fluid in 0..8 {
        assay.reservoir(&format!("f{fluid}"), (1 + 14 * (fluid / 4), 3 + 4 * (fluid % 4)));
        assay.dispense(&format!("d{fluid}"), &format!("f{fluid}"));
    }
    let tree = [(0, 1, place(0)), (2, 3, place(4)), (4, 5, place(1)), (6, 7, place(5))];
    let roots = [(0, 2, place(2)), (4, 6, place(3)), (0, 4, place(6))];
    for (one, other, at) in tree.into_iter().chain(roots) {
        assay.mix(&format!("d{one}"), &format!("d{other}"), at, 3);
    }
    assay.operations.push("discard d0 at (15, 1)".to_owned());
    assay
}

/// One sample, diluted 1:1 and split repeatedly; each part is diluted four more times, merged with the reagent, and
/// read for 30 s.
fn protein(levels: u32) -> FieldAssay {
    let mut assay = FieldAssay::default();
    let ports = [("s", (8, 1)), ("b0", (1, 6)), ("b1", (15, 6)), ("r0", (1, 11)), ("r1", (15, 11))];
    ports.iter().for_each(|(name, at)| assay.reservoir(name, *at));
    let mut count = 0;
    let mut meet = |assay: &mut FieldAssay, part: u32, fluid: &str| {
        count += 1;
        let other = format!("{fluid}_{count}");
        assay.dispense(&other, &format!("{fluid}{}", count % 2));
        assay.mix(&format!("d{part}"), &other, place(part), 3);
    };
    assay.dispense("d0", "s");
    let leaves = 1 << levels;
    for level in 0..levels {
        let step = leaves >> (level + 1);
        for part in (0..leaves).step_by(2 * step as usize) {
            meet(&mut assay, part, "b");
            let (half, (column, row)) = (part + step, place(part));
            assay.scene.push(format!("part d{half} : ea.droplet"));
            assay.droplets += 1;
            assay.operations.push(format!("incubate d{part} for 2 s"));
            assay.operations.push(format!("split d{half} from d{part} at ({}, {row})", column + 1));
        }
    }
    for part in 0..leaves {
        for fluid in ["b", "b", "b", "b", "r"] {
            meet(&mut assay, part, fluid);
        }
        assay.operations.push(format!("incubate d{part} for 30 s"));
        assay.operations.push(format!("discard d{part} at (15, 1)"));
    }
    assay
}

/// Source of the mixing places.
#[derive(Clone, Copy)]
enum MixingPlace {
    /// The program assigns the eight places in turn.
    InTurn,
    /// The plan chooses the places.
    Open,
}

/// Every sample is mixed with every reagent.
fn in_vitro(samples: u32, reagents: u32, mixing: MixingPlace) -> FieldAssay {
    let mut assay = FieldAssay::default();
    (0..samples).for_each(|sample| assay.reservoir(&format!("s{sample}"), (1, 3 + 4 * sample)));
    (0..reagents).for_each(|reagent| assay.reservoir(&format!("r{reagent}"), (15, 3 + 4 * reagent)));
    for sample in 0..samples {
        for reagent in 0..reagents {
            let place = (sample * reagents + reagent) % 8;
            let (own, other) = (format!("d{sample}_{reagent}"), format!("e{sample}_{reagent}"));
            assay.dispense(&own, &format!("s{sample}"));
            assay.dispense(&other, &format!("r{reagent}"));
            let time_s = SAMPLE_S[sample as usize];
            match mixing {
                MixingPlace::InTurn => assay.mix(&own, &other, self::place(place), time_s),
                MixingPlace::Open => {
                    let places: Vec<String> = (0..8).map(|place| format!("{:?}", self::place(place))).collect();
                    assay.operations.push(format!("merge {own} with {other} among [{}]", places.join(", ")));
                    assay.operations.push(format!("mix {own} for {time_s} s"));
                }
            }
            assay.operations.push(format!("incubate {own} for {time_s} s"));
            assay.operations.push(format!("discard {own} at (15, 1)"));
        }
    }
    assay
}

fn planned(text: &str) -> Plan<()> {
    match answered(text) {
        Answered::Plan(plan) => *plan,
        Answered::Errors(errors) => panic!("{errors:?}"),
        Answered::Unfit => panic!("a program with errors: {text}"),
    }
}

fn size(samples: u32, reagents: u32) -> (u32, u32) {
    (10 + 3 * samples, 2 + 2 * samples * reagents)
}

/// The program, with the given text before and after its operations.
fn panel(samples: u32, reagents: u32, before: &str, after: &str) -> String {
    let (columns, rows) = size(samples, reagents);
    let each = format!("for s in 0..{samples} {{\nfor r in 0..{reagents} {{\n");
    let reactions: Vec<String> = (0..reagents).map(|reagent| format!("{} s", 3 + reagent * 7 % 5)).collect();
    format!(
        "use std.electrode_array as ea\n\
         device chip : ea.droplet_chip {{ columns: {columns}, rows: {rows} }}\n\
         let reactions = [{reactions}]\n\
         scene panel {{\n{each}\
         part sample[s, r]  : ea.droplet at (1, 2 + 2 * ({reagents} * s + r))\n\
         part reagent[s, r] : ea.droplet at ({columns}, 2 + 2 * ({reagents} * s + r))\n}}\n}}\n}}\n\
         task measure on chip in panel {{\n{before}{each}\
         merge sample[s, r] with reagent[s, r] at (4 + 3 * s, 3 + 4 * r)\n\
         incubate sample[s, r] for reactions[r]\n\
         incubate sample[s, r] at ({detector}, 3 + 4 * r) for 2 s\n\
         discard sample[s, r] at ({detector}, 1)\n}}\n}}\n{after}}}\n",
        reactions = reactions.join(", "),
        detector = columns - 2,
    )
}
