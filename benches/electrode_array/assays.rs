//! In-vitro panels: every sample with every reagent. Each mixture rests where it meets, queues for the detector of its reagent and leaves.
//!
//! The same operations as steps one after the other are what a board does without assays.

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

/// The program, with these words round its operations.
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
