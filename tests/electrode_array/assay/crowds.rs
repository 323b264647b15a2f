//! Assays with more droplets than fit on the board at once: every plan passes the verifier, and none is below its
//! bound.

use crate::programs::{Answered, answered};
use crate::scenes::Random;
use crate::scenes::random::cases;

/// Meeting places: corners of mixing loops of 4 × 2 electrodes, with lanes between them.
const PLACES: [(u32, u32); 8] = [(4, 3), (9, 3), (4, 8), (9, 8), (4, 13), (9, 13), (4, 18), (9, 18)];

/// Reservoirs on both sides.
const PORTS: [(u32, u32); 4] = [(1, 6), (1, 11), (15, 6), (15, 11)];

/// Pairs of droplets that meet, are mixed and rest at the places in turn; each pair follows the one before it there.
fn panel(chance: &mut Random) -> String {
    let pairs = 34 + chance.below(8);
    let mut lines = vec![
        "use std.electrode_array as ea".to_owned(),
        "device chip : ea.droplet_chip { columns: 15, rows: 19, dispense_duration: 300 ms, mixer: (4, 2) }".to_owned(),
        "scene bench {".to_owned(),
    ];
    lines.extend(PORTS.iter().enumerate().map(|(port, at)| format!("reservoir r{port} at {at:?}")));
    lines.extend((0..pairs).flat_map(|pair| ["a", "b"].map(|name| format!("part {name}{pair} : ea.droplet"))));
    lines.push("}\ntask run on chip in bench {\nassay {".to_owned());
    for pair in 0..pairs {
        let place = chance.below(8);
        let before = (0..pair).rev().find(|before| lines.iter().any(|line| line == &format!("// {before} at {place}")));
        let after = before.map(|before| format!(" after a{before}")).unwrap_or_default();
        let at = PLACES[place as usize];
        let [one, other] = [0, 1].map(|_| chance.below(4));
        lines.push(format!("dispense a{pair} from r{one}"));
        lines.push(format!("dispense b{pair} from r{other}"));
        lines.push(format!("merge a{pair} with b{pair} at {at:?}{after}"));
        lines.push(format!("// {pair} at {place}"));
        lines.push(format!("mix a{pair} for {} ms", 60 * (1 + chance.below(40))));
        lines.push(format!("incubate a{pair} for {} ms", 60 * (1 + chance.below(60))));
        lines.push(format!("discard a{pair} at (15, 1)"));
    }
    lines.push("}\n}".to_owned());
    lines.join("\n")
}

#[test]
fn assays_of_many_droplets_are_planned() {
    let cases = cases(3);
    let mut chance = Random::new(1_507);
    for _ in 0..cases {
        let text = panel(&mut chance);
        // The verifier has accepted each plan.
        let Answered::Plan(plan) = answered(&text) else { panic!("no plan of\n{text}") };
        assert!(plan.bound <= plan.cost && plan.cost <= 2.0 * plan.bound, "{} and {}", plan.cost, plan.bound);
    }
}

/// Droplets that crowd a small board and are pooled at two places; later ones block those before them.
fn pools(chance: &mut Random) -> String {
    let apart = |one: (u32, u32), other: (u32, u32)| one.0.abs_diff(other.0).max(one.1.abs_diff(other.1)) >= 2;
    let spread = |chance: &mut Random, most: usize| {
        let mut cells: Vec<(u32, u32)> = Vec::new();
        for _ in 0..200 {
            let cell = (1 + chance.below(9), 1 + chance.below(6));
            if cells.len() < most && cells.iter().all(|other| apart(*other, cell)) {
                cells.push(cell);
            }
        }
        cells
    };
    let (starts, places) = (spread(chance, 8), spread(chance, 2));
    let parts: String =
        starts.iter().enumerate().map(|(part, at)| format!("part p{part} : ea.droplet at {at:?}\n")).collect();
    let merges = (2..starts.len()).map(|part| format!("merge p{} with p{part} at {:?}\n", part % 2, places[part % 2]));
    format!(
        "use std.electrode_array as ea\ndevice chip : ea.droplet_chip {{ columns: 9, rows: 6, most_volume: 8 }}\n\
         scene bench {{\n{parts}}}\ntask run on chip in bench {{\nassay {{\n{}}}\n}}",
        merges.collect::<String>()
    )
}

/// List scheduling in the usual priority orders plans about half of them.
#[test]
fn most_crowds_that_are_pooled_are_planned() {
    let mut chance = Random::new(77);
    let all: Vec<String> = (0..12).map(|_| pools(&mut chance)).collect();
    let planned = all.iter().filter(|text| matches!(answered(text), Answered::Plan(_))).count();
    assert!(planned >= 10, "{planned} of {}", all.len());
}
