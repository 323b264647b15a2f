//! Wash droplets that `wash with water to CELL` adds, judged by a sequential walk through the operations: with them
//! there is no contamination at any stop, without any one of them there is, and each comes between the droplets that it
//! separates.

use crate::programs::{Answered, answered, checked};
use crate::scenes::Random;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fmt::Write as _;
use tweeze::claims::Order;
use tweeze::claims::electrode_array::{AssayOperation, ElectrodeArrayAction, ElectrodeArrayOrder, Fluids};
use tweeze::device::electrode_array::ElectrodeCell;

/// Exit of the water droplets.
const EXIT: (u32, u32) = (16, 1);

/// A random assay: droplets meet water, mix, and are read where others were before; the fluids that contaminate each
/// other are random.
fn program(chance: &mut Random) -> String {
    let droplets = 2 + chance.below(3);
    let mut text = format!(
        "use std.electrode_array as ea\n\
         device chip : ea.droplet_chip {{ columns: 16, rows: {}, mixer: (2, 3) }}\nscene bench {{\n  reservoir water at (16, 9)\n",
        5 * droplets + 4
    );
    for droplet in 0..droplets {
        let row = 3 + 5 * droplet;
        let _ = writeln!(text, "  reservoir f{droplet} at (1, {row})\n  part d{droplet} : ea.droplet");
    }
    text.push_str("}\ntask run on chip in bench {\n  using portfolio { expansions: 200_000 }\n  avoid f0 in f1\n");
    for (of, within) in (0..droplets).flat_map(|of| (0..droplets).map(move |within| (of, within))) {
        if chance.below(3) > 0 {
            let _ = writeln!(text, "  avoid f{of} in f{within}");
        }
    }
    let _ = writeln!(text, "  wash with water to {EXIT:?}\n  assay {{");
    let mut lists: Vec<VecDeque<String>> = (0..droplets).map(|droplet| operations(droplet, chance)).collect();
    // Mostly one droplet after the other.
    let is_mixed = chance.below(3) == 0;
    while let Some(first) = lists.iter().position(|list| !list.is_empty()) {
        let open: Vec<usize> = (first..lists.len()).filter(|at| !lists[*at].is_empty()).collect();
        let next = if is_mixed { open[chance.below(open.len() as u32) as usize] } else { first };
        text.extend(lists[next].pop_front());
    }
    text.push_str("  }\n}\n");
    text
}

/// Lines of a droplet's operations.
fn operations(droplet: u32, chance: &mut Random) -> VecDeque<String> {
    let row = 3 + 5 * droplet;
    let mut lines = VecDeque::from([format!("    dispense d{droplet} from f{droplet}\n")]);
    match chance.below(3) {
        0 => {}
        1 => lines.push_back(format!("    mix d{droplet} at (5, {row}) for 500 ms\n")),
        _ => {
            lines.push_back(format!("    incubate d{droplet} at (7, 8) for 300 ms\n"));
            lines.push_back(format!("    mix d{droplet} for 500 ms\n"));
        }
    }
    if chance.below(4) > 0 {
        lines.push_back(format!("    incubate d{droplet} at (12, 6) for 500 ms\n"));
        // At the current place, or at the detector again.
        for again in ["", " at (12, 6)"].into_iter().filter(|_| chance.below(2) == 0) {
            lines.push_back(format!("    incubate d{droplet}{again} for 100 ms\n"));
        }
    }
    let exit = if chance.below(5) == 0 { 12 } else { row };
    lines.push_back(format!("    discard d{droplet} at (16, {exit})\n"));
    lines
}

/// The cells that a droplet occupies during an operation.
fn cells(operation: &AssayOperation, at: Option<ElectrodeCell>, order: &ElectrodeArrayOrder) -> Vec<ElectrodeCell> {
    let mut cells: Vec<ElectrodeCell> = operation.stops.iter().map(|stop| stop.cell).collect();
    cells.extend(at.filter(|_| operation.stops.is_empty()));
    if let Some(corner) = cells.last().copied().or(at).filter(|_| operation.mixes) {
        let [columns, rows] = order.facts.mixer;
        let round = (0..columns).flat_map(|column| (0..rows).map(move |row| (column, row)));
        cells.extend(round.map(|(column, row)| ElectrodeCell::new(corner.column + column, corner.row + row)));
    }
    cells
}

/// Whether the operations, carried out in sequence and without those of one part, cause no contamination.
fn is_clean(order: &ElectrodeArrayOrder, operations: &[AssayOperation], without: Option<usize>) -> bool {
    let rules = &order.contamination;
    let mut fluids: Vec<Fluids> = vec![Fluids::new(); order.parts.len()];
    let mut at: BTreeMap<usize, ElectrodeCell> = BTreeMap::new();
    let mut left: BTreeMap<ElectrodeCell, BTreeSet<String>> = BTreeMap::new();
    for operation in operations.iter().filter(|operation| Some(operation.part) != without) {
        let part = operation.part;
        fluids[part].extend(operation.fluid.clone());
        let own = &fluids[part];
        for cell in cells(operation, at.get(&part).copied(), order) {
            let here = left.entry(cell).or_default();
            if own.iter().all(|fluid| rules.washes.contains(fluid)) {
                here.clear();
                continue;
            }
            let harm = |of: &str, within: &str| here.contains(of) && own.contains(within) && !own.contains(of);
            if rules.avoided.iter().any(|trace| harm(&trace.of, &trace.within)) {
                return false;
            }
            here.extend(own.iter().cloned());
        }
        at.extend(operation.stops.last().map(|stop| (part, stop.cell)));
    }
    true
}

#[test]
fn washes_are_added_where_they_are_needed_and_nowhere_else() {
    let mut chance = Random::new(0x7761_7368);
    let (mut added, mut planned) = (0, 0);
    for _ in 0..60 {
        let text = program(&mut chance);
        let (claims, ..) = checked(&text).unwrap_or_else(|| panic!("a program without errors:\n{text}"));
        let Order::ElectrodeArray(order) = &claims.jobs[0].order else { panic!("a board") };
        let ElectrodeArrayAction::Assay(operations) = &order.steps[0].action else { panic!("an assay") };
        assert!(is_clean(order, operations, None), "{text}");
        let washes: Vec<usize> =
            (0..order.parts.len()).filter(|part| order.parts[*part].name.starts_with("wash")).collect();
        for wash in &washes {
            assert!(!is_clean(order, operations, Some(*wash)), "{} is idle:\n{text}", order.parts[*wash].name);
            let own: Vec<usize> = (0..operations.len()).filter(|place| operations[*place].part == *wash).collect();
            let (first, last) = (own[0], own[own.len() - 1]);
            assert!(operations[first].comes && operations[last].leaves, "{text}");
            assert_eq!(operations[last].stops[0].cell, ElectrodeCell::new(EXIT.0, EXIT.1));
            let over = &own[1..own.len() - 1];
            let soiling = |place: &usize| operations[*place].after.iter().all(|before| *before < first);
            assert!(
                !over.is_empty() && over.iter().all(|place| !operations[*place].after.is_empty() && soiling(place))
            );
            let next = operations.iter().skip(last + 1).find(|operation| operation.after.contains(&(last - 1)));
            assert!(next.is_some(), "nothing comes after {}:\n{text}", order.parts[*wash].name);
        }
        added += washes.len();
        // The verifier checks every plan against the traces, electrode by electrode.
        planned += usize::from(!washes.is_empty() && matches!(answered(&text), Answered::Plan(_)));
    }
    assert!(added >= 50 && planned >= 15, "{added} washes, {planned} plans with some");
}

/// The same washes, written by hand.
#[test]
fn an_added_wash_is_a_droplet_like_any_other() {
    let program = |wash: &str, rinse: &str, between: &str, after: &str| {
        format!(
            "use std.electrode_array as ea\n\
             device chip : ea.droplet_chip {{ columns: 14, rows: 9 }}\n\
             scene bench {{\n  reservoir water at (14, 5)\n  part blood : ea.droplet at (2, 2)\n\
             part serum : ea.droplet at (2, 8)\n{rinse}}}\n\
             task read on chip in bench {{\n  avoid blood in serum\n  avoid serum in blood\n  {wash}\n  assay {{\n\
             incubate blood at (11, 5) for 2 s\n{between}    incubate serum at (11, 5) for 2 s{after}\n\
             discard blood at (14, 2)\n    discard serum at (14, 8)\n  }}\n}}\n"
        )
    };
    let added = program("wash with water to (14, 2)", "", "", "");
    let by_hand = program(
        "wash with water",
        "  part rinse : ea.droplet\n",
        "    dispense rinse from water\n    move rinse to (11, 5) after blood\n    discard rinse at (14, 2)\n",
        // The last operation above is the exit; `after` refers to the one before it.
        " after rinse",
    );
    let of = |text: &str| match answered(text) {
        Answered::Plan(plan) => (plan.cost, plan.bound),
        other => panic!("{other:?}:\n{text}"),
    };
    let ((cost, bound), (other_cost, other_bound)) = (of(&added), of(&by_hand));
    // The hand-written version comes after the wash has left, which is no sooner.
    assert!(cost <= other_cost && bound <= other_bound, "{cost} of {bound}, {other_cost} of {other_bound}");
}

/// A second scene states where parts are declared, not where the first task has left them.
#[test]
fn droplets_of_a_later_task_start_where_the_earlier_one_left_them() {
    let program = |cell: &str, wash: &str| {
        let scene = |name: &str, blood: &str| {
            format!(
                "scene {name} {{\n  reservoir water at (14, 5)\n  part blood : ea.droplet at {blood}\n\
                 part serum : ea.droplet at (2, 8)\n}}\n"
            )
        };
        format!(
            "use std.electrode_array as ea\ndevice chip : ea.droplet_chip {{ columns: 14, rows: 9 }}\n{}{}\
             task first on chip in one {{ move blood to (9, 2) }}\n\
             task second on chip in two {{\n  avoid blood in serum\n  {wash}\n  prompt \"clean the board\"\n  assay {{\n\
             move blood to (12, 2)\n    incubate serum at {cell} for 1 s\n  }}\n}}\n\
             program day {{\n  run first\n  run second\n}}\n",
            scene("one", "(2, 2)"),
            scene("two", "(4, 2)"),
        )
    };
    assert!(matches!(answered(&program("(4, 2)", "")), Answered::Plan(_)));
    assert!(checked(&program("(9, 2)", "")).is_none(), "blood stands there at first");
    let washed = program("(9, 2)", "wash with water to (14, 2)");
    let (claims, ..) = checked(&washed).expect("a program without errors");
    assert!(claims.jobs.iter().all(|job| {
        ElectrodeArrayOrder::of(&job.order)
            .is_some_and(|order| order.parts.iter().filter(|part| part.name.starts_with("wash")).count() == 1)
    }));
    assert!(matches!(answered(&washed), Answered::Plan(_)));
}
