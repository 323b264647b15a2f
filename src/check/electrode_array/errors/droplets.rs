//! Diagnostics of the operations of droplets: dispense, merge, split, mix, discard.

use super::{PartPlace, nearest, written};
use crate::check::scope::nearest as nearest_name;
use crate::check::value::Value;
use crate::claims::electrode_array::{AssayOperation, BoardPart, DropletContent, DropletShare, ElectrodeArrayStop};
use crate::claims::{Job, Relation};
use crate::device::Verb;
use crate::device::electrode_array::{ElectrodeCell, MAX_PLACES, SPLIT_APART, droplets};
use crate::diagnostic::{Code, Diagnostic};
use crate::quantity::{Dimension, Quantity, digits, fraction};
use crate::source::Span;
use std::collections::BTreeSet;

/// The stays of an assay, or those of one of its parts, take more steps than can be planned.
pub fn stays_too_long(span: Span, part: Option<&str>, [steps, most_steps]: [u64; 2], step_ns: u64) -> Diagnostic {
    let most = Quantity::new(most_steps as f64 * step_ns as f64 / 1e9, Dimension::TIME);
    let one = Quantity::time_ns(step_ns);
    let title = match part {
        Some(part) => {
            format!("`{part}` stays for {steps} steps of the board up to here; at most {most_steps} can be planned")
        }
        None => format!(
            "the operations up to here stay for {steps} steps of the board; at most {most_steps} can be planned"
        ),
    };
    let whose = if part.is_some() { "of a part in one assay" } else { "of one assay" };
    Diagnostic::new(Code::E0554, title).label(span, format!("steps of {one}")).help(format!(
        "split the `assay`, with `wait` where all droplets rest: the stays {whose} may take {most} in total"
    ))
}

/// Reason why a part is gone, and the place in the program that removed it.
#[derive(Debug, Clone, Copy)]
pub enum Departure {
    /// It has merged with another part.
    Merged(Span),
    /// It has left the board.
    Left(Span),
}

impl Departure {
    /// The part that an operation removes, with the reason.
    pub fn of(operation: &AssayOperation) -> Option<(usize, Departure)> {
        let departure = if operation.leaves { Departure::Left } else { Departure::Merged };
        operation.gone().map(|part| (part, departure(operation.span)))
    }
}

pub fn gone_before(span: Span, name: &str, departure: Departure) -> Diagnostic {
    match departure {
        Departure::Merged(merged) => {
            Diagnostic::new(Code::E0526, format!("`{name}` has merged with another part by then"))
                .label(span, "no longer a part of its own")
                .label_elsewhere(merged, span, "merged here")
                .help("use the name before `with`: it is the name of the merged part from then on")
        }
        Departure::Left(left) => Diagnostic::new(Code::E0526, format!("`{name}` has left the board by then"))
            .label(span, "no longer there")
            .label_elsewhere(left, span, "leaves here")
            .help("discard it later, or name another part: `discard` removes a part for the rest of the schedule"),
    }
}

/// A droplet that is dispensed after the operation in which it merges.
pub fn dispensed_after_merging(span: Span, name: &str, merged: Span) -> Diagnostic {
    Diagnostic::new(Code::E0526, format!("`{name}` is dispensed after it has merged with another part"))
        .label(span, "enters the board only here")
        .label_elsewhere(merged, span, "merged here")
        .help("write the `dispense` above: operations of a part take place in the order of the program")
}

/// A part without a place, used before its `dispense`.
pub fn not_there_yet(span: Span, part: &BoardPart) -> Diagnostic {
    let name = &part.name;
    Diagnostic::new(Code::E0555, format!("`{name}` is not on the board by then"))
        .label(span, "neither dispensed nor split off before")
        .label_elsewhere(part.span, span, "declared without `at`")
        .help(format!(
            "write `dispense {name} from RESERVOIR` or `split {name} from PART at (5, 3)` before, or give `{name}` a place in the scene with `at`"
        ))
}

/// A part that is dispensed although it has been on the board since a place in the source.
pub fn there_already(span: Span, name: &str, since: Span) -> Diagnostic {
    Diagnostic::new(Code::E0555, format!("`{name}` is on the board already"))
        .label(span, "cannot enter it again")
        .label_elsewhere(since, span, format!("`{name}` has been on the board since this"))
        .help("declare another `part` without `at`, or a list of them with `for`: each droplet has a name of its own")
}

/// `after` a part that has no operation above.
pub fn nothing_to_come_after(span: Span, name: &str) -> Diagnostic {
    Diagnostic::new(Code::E0564, format!("`{name}` has no operation above, so nothing can come after one"))
        .label(span, "does nothing above")
        .help(format!("write the operations of `{name}` first: `after {name}` means after all that it does above"))
}

/// A longest time without a reference.
pub fn within_of_nothing(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0573, "`within` limits the time after another operation, but none is named")
        .label(span, "counts from nothing")
        .help("write `after PART within 20 s`; `after` the part itself counts from the end of its own operation above")
}

/// `among` in a step that has one goal for each part.
pub fn among_outside_assay(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0576, "`among` belongs in an `assay`")
        .label(span, "no `assay` around it")
        .help("`assay { … }` plans operations and chooses their places; to let the plan choose which part comes to which goal, write `move any m to […]`")
}

/// Both a fixed place and a choice of places.
pub fn at_and_among(verb: &Verb, at: Span, among: Span) -> Diagnostic {
    Diagnostic::new(Code::E0509, format!("`at` and `among` are given in one `{}`", verb.name))
        .label(among, "the plan chooses one of these")
        .label(at, "this is the place")
        .help("remove one of them")
}

pub fn among_nothing(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0576, "`among` names no place")
        .label(span, "nothing to choose from")
        .help("write the cells to choose from, as `among [(2, 2), (7, 2)]`, or one after `at`")
}

pub fn among_too_many(span: Span, count: usize) -> Diagnostic {
    Diagnostic::new(Code::E0576, format!("`among` names {count} places; at most {MAX_PLACES} are allowed"))
        .label(span, "too many to choose from")
        .help("leave out those that no good plan would use")
}

pub fn among_one_twice(stop: &ElectrodeArrayStop, first: Span) -> Diagnostic {
    Diagnostic::new(Code::E0576, format!("`among` names {} twice", stop.cell))
        .label(stop.span, "again here")
        .label(first, "first here")
        .help("remove one of them")
}

/// `after` or `within` among steps, which have an order anyway.
pub fn after_outside_assay(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0564, "`after` and `within` belong in an `assay`")
        .label(span, "no `assay` around it")
        .help("`assay { … }` plans operations side by side, and `after` orders them; steps follow each other anyway, and what is in a `together` begins at the same time")
}

pub fn parts_are_not_dispensed(span: Span) -> Diagnostic {
    Diagnostic::new(
        Code::E0555,
        "no reservoir dispenses parts with (2, 2) electrodes; droplets with (1, 1) are dispensed",
    )
    .label(span, "not on this device")
    .help("give the part a place in the scene, as `part NAME at (5, 3)`")
}

/// Adds that the device must hold its droplets; `hold` is the field that turns holding off.
fn held(diagnostic: Diagnostic, hold: Option<Span>) -> Diagnostic {
    let diagnostic = match hold {
        Some(hold) => diagnostic.label(hold, "electrodes are on only to move a droplet"),
        None => diagnostic,
    };
    diagnostic.help("give the device `hold: true`")
}

/// `hold` is the field that turns holding off.
pub fn dispenses_without_hold(span: Span, hold: Option<Span>) -> Diagnostic {
    let title = "droplets are dispensed only on a device that holds them, but this one has `hold: false`";
    let diagnostic =
        Diagnostic::new(Code::E0555, title).label(span, "the electrode at the outlet pulls the droplet out");
    held(diagnostic, hold)
}

pub fn dispenses_in_no_time(span: Span, device: &str) -> Diagnostic {
    Diagnostic::new(Code::E0555, format!("the device `{device}` has no `dispense_duration`"))
        .label(span, "how long does this take?")
        .help("give the device the time that its reservoirs need for one droplet, as `dispense_duration: 2 s`")
}

/// A reservoir with the outlet of another one.
pub fn outlets_on_one_cell(name: &str, cell: ElectrodeCell, span: Span, other: Span) -> Diagnostic {
    Diagnostic::new(Code::E0555, format!("reservoir `{name}` has its outlet at {cell}, where another has its own"))
        .label(span, "one electrode, two reservoirs")
        .label_elsewhere(other, span, "the other one")
        .help("give each its own outlet: `at` is the electrode onto which a reservoir dispenses")
}

pub fn parts_do_not_merge(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0527, "parts with (2, 2) electrodes do not merge; droplets with (1, 1) do")
        .label(span, "not on this device")
        .help("write two `move`s to cells that are far enough apart")
}

pub fn merges_with_itself(span: Span, name: &str) -> Diagnostic {
    Diagnostic::new(Code::E0527, format!("`{name}` cannot merge with itself"))
        .label(span, "one droplet, named twice")
        .help("name two droplets of the scene")
}

/// `hold` is the field that turns holding off.
pub fn merges_without_hold(span: Span, hold: Option<Span>) -> Diagnostic {
    let diagnostic =
        Diagnostic::new(Code::E0529, "droplets merge only on a device that holds them, but this one has `hold: false`")
            .label(span, "the first to arrive would not be held for the second");
    held(diagnostic, hold)
}

pub fn parts_do_not_split(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0557, "parts with (2, 2) electrodes do not split; droplets with (1, 1) do")
        .label(span, "not on this device")
        .help("give the other part a place of its own in the scene, as `part NAME at (5, 3)`")
}

/// `hold` is the field that turns holding off.
pub fn splits_without_hold(span: Span, hold: Option<Span>) -> Diagnostic {
    let title = "droplets split only on a device that holds them, but this one has `hold: false`";
    let diagnostic = Diagnostic::new(Code::E0557, title).label(span, "two electrodes pull a droplet apart");
    held(diagnostic, hold)
}

/// The device requires a greater separation than the two halves of a split have.
pub fn halves_too_near(span: Span, device: &str, apart: u32) -> Diagnostic {
    let title = format!("the two droplets of a split are {SPLIT_APART} electrodes apart, but `{device}` keeps {apart}");
    Diagnostic::new(Code::E0557, title)
        .label(span, "too near from the beginning")
        .help(format!("give the device `separation: {SPLIT_APART}`, or dispense two droplets instead"))
}

pub fn splits_from_itself(span: Span, name: &str) -> Diagnostic {
    Diagnostic::new(Code::E0557, format!("`{name}` cannot be split from itself"))
        .label(span, "one droplet, named twice")
        .help("name the new droplet after `split`, a `part` without `at` in the scene; the other one keeps its name")
}

/// The cell at which a droplet is split, and the step that splits it.
#[derive(Debug, Clone, Copy)]
pub struct SplitPlace {
    pub at: ElectrodeCell,
    pub span: Span,
}

/// A half of a split that would come at a cell that is not beside that of the split.
pub fn comes_not_beside(place: SplitPlace, to: ElectrodeCell, span: Span) -> Diagnostic {
    let SplitPlace { at, .. } = place;
    let beside = ElectrodeCell::new(at.column.saturating_add(1), at.row);
    Diagnostic::new(Code::E0557, format!("{to} is not beside {at}, where the droplet is pulled apart"))
        .label(span, "must be left, right, above or below it")
        .help(format!(
            "write `to {beside}`, or leave `to` out, which means the same; the other half goes the opposite way"
        ))
}

/// A half of a split that would come where it cannot be; `across` is a free cell beside the split in the perpendicular
/// direction, whose opposite is free too.
pub fn half_has_no_room(
    place: SplitPlace,
    name: &str,
    [column, row]: [i64; 2],
    across: Option<ElectrodeCell>,
) -> Diagnostic {
    let SplitPlace { at, span } = place;
    let help = match across {
        Some(cell) => format!("pull it apart the other way, with `to {cell}`, or split elsewhere"),
        None => {
            "split where the electrodes on both sides are on the board, work, and are clear of obstacles".to_owned()
        }
    };
    let title = format!("no room for `{name}` at ({column}, {row}), where it goes when the droplet is split at {at}");
    Diagnostic::new(Code::E0557, title).label(span, "one half goes to each side").help(help)
}

pub fn parts_do_not_mix(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0558, "parts with (2, 2) electrodes are not mixed; droplets with (1, 1) are")
        .label(span, "not on this device")
        .help("write `incubate` to leave a part where it is for a time")
}

/// An invalid field `mixer`.
pub fn no_mixing_loop(found: &Value) -> Diagnostic {
    let title = format!("a `mixer` needs two columns and two rows or more, but this is {}", written(found));
    Diagnostic::new(Code::E0558, title).help("write the columns and the rows of the loop, as `mixer: (2, 4)`")
}

/// A mixing loop with a cell that a droplet cannot take; `free` is a corner from which the loop is free.
pub fn loop_blocked(
    name: &str,
    span: Span,
    corner: ElectrodeCell,
    [columns, rows]: [u32; 2],
    cell: ElectrodeCell,
    free: Option<ElectrodeCell>,
) -> Diagnostic {
    let title = format!("`{name}` cannot be mixed from {corner}: it cannot go to {cell}");
    let help = nearest(free, "from which the whole loop is free").unwrap_or_else(|| {
        "give the device a smaller `mixer`: no cell of this board leaves the whole loop free".to_owned()
    });
    Diagnostic::new(Code::E0558, title)
        .label(span, format!("{columns} × {rows} electrodes, to the right and up from here"))
        .help(help)
}

pub fn parts_contain_nothing(span: Span) -> Diagnostic {
    Diagnostic::new(
        Code::E0559,
        "parts with (2, 2) electrodes contain nothing that merges or splits; droplets with (1, 1) do",
    )
    .label(span, "not on this device")
    .help("`require` compares `steps`, `sum_of_costs`, `moves` and `time` of their plans")
}

/// A fluid that the scene does not have.
pub fn unknown_fluid(
    code: Code,
    span: Span,
    name: &str,
    word: Span,
    fluids: &BTreeSet<&str>,
    scene: Option<Span>,
) -> Diagnostic {
    let known: Vec<String> = fluids.iter().take(SHOWN_FLUIDS).map(|fluid| format!("`{fluid}`")).collect();
    let more = if fluids.len() > SHOWN_FLUIDS { ", …" } else { "" };
    let near = nearest_name(name, fluids.iter().copied());
    let volume = if code == Code::E0559 { ", and have a `volume`" } else { "" };
    let diagnostic = Diagnostic::new(code, format!("no fluid of this scene is called `{name}`"))
        .label(span, "neither a reservoir nor a part with a place");
    let diagnostic = match near {
        Some(near) => diagnostic.near_object(name, word, near),
        None => diagnostic.help(format!("droplets can contain {}{more}{volume}", known.join(", "))),
    };
    match scene {
        Some(scene) => diagnostic.label_elsewhere(scene, span, "the scene"),
        None => diagnostic,
    }
}

/// `avoid` or `wash` for microparts, which leave no traces.
pub fn parts_leave_no_traces(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0565, "parts with (2, 2) electrodes leave no traces; droplets with (1, 1) do")
        .label(span, "not on this device")
        .help("leave the line out")
}

/// A wash in a task that avoids nothing.
pub fn washes_nothing(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0565, "`wash` removes traces, but this task avoids none")
        .label(span, "no `avoid` in the task")
        .help("write before it what must not contaminate what, as `avoid blood in serum`")
}

/// A wash fluid that the task also avoids or protects.
pub fn avoids_a_wash(span: Span, fluid: &str, wash: Span) -> Diagnostic {
    Diagnostic::new(Code::E0565, format!("`{fluid}` is a wash fluid, so it leaves no traces and is not contaminated"))
        .label(span, "avoids nothing")
        .label_elsewhere(wash, span, "washed with here")
        .help("leave out this line, or wash with another fluid")
}

/// Wash droplets from something other than a reservoir.
pub fn washes_from_no_reservoir(span: Span, name: &str) -> Diagnostic {
    Diagnostic::new(Code::E0565, format!("`{name}` is not a reservoir, so no wash droplets come from it"))
        .label(span, "a part that is on the board")
        .help("name a `reservoir` of the scene, or leave out `to CELL` and send the part itself where it is to wash")
}

/// Two lines that add wash droplets.
pub fn washes_by_two(span: Span, earlier: Span) -> Diagnostic {
    Diagnostic::new(Code::E0565, "two lines add wash droplets to this task")
        .label(span, "the second")
        .label_elsewhere(earlier, span, "the first")
        .help("leave out one `to CELL`: a fluid without it washes where the program sends its droplets")
}

/// Traces that an earlier task has left on the same board.
pub fn contaminated_before(avoided: Span, fluid: &str, earlier: &Job) -> Diagnostic {
    let title = format!("the traces of `{fluid}` that `{}` left on `{}` are ignored", earlier.task, earlier.device);
    Diagnostic::new(Code::W0513, title)
        .label(avoided, "the board counts as clean before this task")
        .label_elsewhere(earlier.run_span, avoided, format!("moves `{fluid}` across it"))
        .help("write all operations into one `assay`; or clean the board in between, with a first step that asks for it: `prompt \"clean the board\"`")
}

/// More droplets than a board can have, with the added wash droplets.
pub fn too_many_washes(span: Span, washes: usize, parts: usize, most: usize) -> Diagnostic {
    Diagnostic::new(Code::E0522, format!("{washes} wash droplets and {parts} parts; at most {most} are allowed"))
        .label(span, "adds them")
        .help("give fluids that contaminate each other places of their own, or divide the work among several tasks")
}

/// Moving steps besides the single assay of a task that avoids traces.
pub fn avoids_outside_assay(span: Span, avoided: Span) -> Diagnostic {
    Diagnostic::new(Code::E0565, "traces are avoided only within one `assay`, not from step to step")
        .label(span, "outside it")
        .label_elsewhere(avoided, span, "avoided here")
        .help("write all operations of the task into one `assay { … }`; before it, the board counts as clean")
}

/// Two droplets that stop at one cell and contaminate each other.
pub fn harms_at_one_place(span: Span, [left, comes]: [&str; 2], cell: ElectrodeCell) -> Diagnostic {
    Diagnostic::new(Code::E0565, format!("`{left}` and `{comes}` both stop at {cell}, and each contaminates the other"))
        .label(span, format!("`{left}` stops there too"))
        .help("give each a place of its own, or write `wash with FLUID to CELL`, which sends a droplet of it there between the two")
}

/// A droplet that stops where another one starts that contaminates it.
pub fn stops_where_another_starts(
    stop: Span,
    start: Span,
    [left, comes]: [&str; 2],
    cell: ElectrodeCell,
) -> Diagnostic {
    Diagnostic::new(Code::E0565, format!("`{comes}` stops at {cell}, where `{left}` starts and contaminates it"))
        .label(stop, format!("the traces of `{left}` are already there"))
        .label_elsewhere(start, stop, format!("`{left}` starts there"))
        .help("give it another place, or write `wash with FLUID to CELL`, which sends a droplet of it there between the two")
}

/// A droplet that ends where another one stops that contaminates it; `is_written_before` says whether the program sends
/// the former there first.
pub fn ends_where_another_stops(
    stop: Span,
    end: Span,
    [left, ends]: [&str; 2],
    cell: ElectrodeCell,
    is_written_before: bool,
) -> Diagnostic {
    let order = if is_written_before { format!("put `{left}` above `{ends}`, and ") } else { String::new() };
    Diagnostic::new(Code::E0565, format!("`{ends}` ends at {cell}, where `{left}` stops and contaminates it"))
        .label(stop, format!("`{left}` leaves its traces there, sooner or later"))
        .label_elsewhere(end, stop, format!("`{ends}` stays there to the end"))
        .help(format!(
            "send it away afterwards: `discard {ends} at CELL` or `move {ends} to CELL`; or {order}write `wash with FLUID to CELL`, which sends \
             a droplet of it there between the two"
        ))
}

/// A droplet that does not contain what the program requires; `contains` describes its contents.
pub fn other_content(
    content: &DropletContent,
    name: &str,
    reached: f64,
    contains: &str,
    last: Option<Span>,
) -> Diagnostic {
    let wanted = format!("{}{}", words_of(content.relation), fraction(content.limit));
    let title = match &content.share {
        DropletShare::Volume => {
            format!("the volume of `{name}` is {} at the end, but {wanted} is required", droplets(reached))
        }
        DropletShare::Fluid(fluid) => {
            format!("`{name}` is {} `{fluid}` at the end, but {wanted} is required", fraction(reached))
        }
    };
    let help = format!("change what it merges with or how often it is split, or require {}", fraction(reached));
    let diagnostic = Diagnostic::new(Code::E0559, title).label(content.span, format!("contains {contains}")).help(help);
    match last {
        Some(last) => diagnostic.label_elsewhere(last, content.span, "since this"),
        None => diagnostic,
    }
}

/// A required droplet that is never on the board.
pub fn never_there(content: &DropletContent, name: &str) -> Diagnostic {
    Diagnostic::new(Code::E0559, format!("`{name}` is never on the board"))
        .label(content.span, "contains nothing")
        .help(format!("write `dispense {name} from RESERVOIR`, or `split {name} from PART at (5, 3)`"))
}

/// A droplet that is too small or too large for its device.
pub fn volume_out_of_limits(
    span: Span,
    name: &str,
    volume: f64,
    device: &str,
    limit: f64,
    is_largest: bool,
) -> Diagnostic {
    let (word, help) = match is_largest {
        true => ("largest", "split it before, or merge fewer droplets"),
        false => ("smallest", "merge it with another droplet before it is split"),
    };
    let title = format!(
        "the volume of `{name}` is {} by then, but the {word} that `{device}` moves is {}",
        droplets(volume),
        fraction(limit)
    );
    Diagnostic::new(Code::E0559, title).label(span, "after this").help(help)
}

/// A droplet that has become so wide that it would touch another one on the board. Each has its name, its volume and
/// half of its width in electrodes; `apart` is the separation in electrodes.
pub fn wide_droplets(
    span: Span,
    [(name, volume, half_width), (other, others, others_half)]: [(&str, f64, f64); 2],
    device: &str,
    apart: u32,
) -> Diagnostic {
    let width = digits((20.0 * half_width).ceil() / 10.0);
    let title = format!("`{name}` becomes so wide that it can touch `{other}`, {apart} electrodes away");
    Diagnostic::new(Code::W0517, title)
        .label(span, format!("{} by then, about {width} electrodes wide; `{other}` is {}", droplets(volume), droplets(others)))
        .help(format!(
            "write `separation: {}` for `{device}`, or, if it carries such droplets and they stay away from each other, `most_volume: {}`",
            (half_width + others_half).ceil(),
            fraction(volume)
        ))
}

/// A volume limit that excludes every dispensed droplet.
pub fn no_droplet_fits(field: &str, limit: f64) -> Diagnostic {
    Diagnostic::new(Code::E0559, format!("`{field}` is {}, but reservoirs dispense droplets of 1", fraction(limit)))
        .help("volumes are counted in droplets: a droplet of two that have merged is 2, half of one 1/2")
}

/// Most fluids that a message lists.
const SHOWN_FLUIDS: usize = 6;

fn words_of(relation: Relation) -> &'static str {
    match relation {
        Relation::Less => "less than ",
        Relation::AtMost => "at most ",
        Relation::Equal => "",
        Relation::AtLeast => "at least ",
        Relation::More => "more than ",
    }
}

/// A mixing loop too near to a part that stays.
pub fn loop_near_part(name: &str, span: Span, corner: ElectrodeCell, stays: PartPlace, apart: u32) -> Diagnostic {
    let PartPlace { name: other, cell, span: since } = stays;
    let title = format!("the loop in which `{name}` is mixed from {corner} comes too near to `{other}` at {cell}");
    Diagnostic::new(Code::E0524, title)
        .label(span, format!("at least {apart} electrodes are needed"))
        .label_elsewhere(since, span, format!("`{other}` is at {cell} by then"))
        .help(format!("mix elsewhere, or send `{other}` away first"))
}
