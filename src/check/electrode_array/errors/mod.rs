//! Diagnostics of electrode arrays: E0409 onwards, E0505, E0515, E0521 onwards.
//!
//! Diagnostics of a device come without labels: the caller attaches them to the fields, in whichever file these are.

mod droplets;
mod reservoirs;
mod teams;
mod zones;

pub use crate::check::errors::*;
pub use droplets::*;
pub use reservoirs::*;
pub use teams::*;
pub use zones::*;

use crate::check::value::{BoardFile, LeftOut, Value};
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell, MAX_SHARING};
use crate::diagnostic::{Code, Diagnostic};
use crate::quantity::{Dimension, count, digits};
use crate::source::{Span, Spanned};
use std::collections::BTreeSet;

/// A part with a cell, and the place in the source that names it.
#[derive(Clone, Copy)]
pub struct PartPlace<'a> {
    pub name: &'a str,
    pub cell: ElectrodeCell,
    /// Where the program puts or sends the part there.
    pub span: Span,
}

pub fn radius_out_of_table(radius: String, [least, most]: [String; 2], nearest: String) -> Diagnostic {
    Diagnostic::new(
        Code::E0409,
        format!("electrodes have a radius of {radius}, but forces are known only from {least} to {most}"),
    )
    .help(format!("make `radius` {nearest}, or give the device a table of `forces` for its own electrodes"))
}

pub fn radius_twice(radius: String, first: Span, second: Span) -> Diagnostic {
    Diagnostic::new(Code::E0409, format!("`forces` has two rows for a radius of {radius}"))
        .label(second, "again here")
        .label(first, "first here")
        .help("keep one of the two: between the rows of a table forces are interpolated")
}

pub fn gap_out_of_limits(ratio: f64, limit: f64, [least, most]: [Option<f64>; 2]) -> Diagnostic {
    let range = match (least, most) {
        (Some(least), Some(most)) => format!("from {} to {}", digits(least), digits(most)),
        (Some(least), None) => format!("{} or more", digits(least)),
        (None, Some(most)) => format!("{} or less", digits(most)),
        (None, None) => "any".to_owned(),
    };
    let what = if ratio < limit {
        "sparks jump between electrodes that are nearer"
    } else {
        "a part is not pulled across a wider gap"
    };
    Diagnostic::new(Code::E0410, format!("pitch ratio {} must be {range}", digits(ratio)))
        .help(format!("make `pitch_ratio` {}: {what}", digits(limit)))
}

/// The forces on a part at the potential of its device, as text for a message.
pub struct Balance {
    pub lateral: String,
    pub friction: String,
    pub net: String,
    /// The net force at the needed potential.
    pub there: Option<String>,
    /// The source of a requirement beyond a positive net force, if there is one.
    pub known_by: Option<&'static str>,
}

/// `least` is a sufficient potential, `most_friction` a sufficient friction if no potential is.
pub fn potential_too_low(
    potential: &str,
    radius: &str,
    least: Option<&str>,
    balance: Option<&Balance>,
    most_friction: Option<f64>,
) -> Diagnostic {
    let title = match (least, balance) {
        (Some(least), _) => {
            format!("a potential of {potential} is too low: moving a part over electrodes of {radius} takes {least}")
        }
        (None, Some(balance)) => {
            format!("friction of {} holds a part that is pulled with {}", balance.friction, balance.lateral)
        }
        (None, None) => format!("a potential of {potential} moves no part"),
    };
    let forces = balance.map(|Balance { lateral, friction, net, there, known_by }| {
        let there = there.as_ref().map(|there| format!(" ({there} at the potential needed)")).unwrap_or_default();
        let known = known_by.map(|known_by| {
            format!("; this model gives a net force above 0, but the limit is {known_by}: less is not known to move a part")
        });
        let known = known.unwrap_or_default();
        format!(": at {potential} a part is pulled with {lateral} against a static friction of {friction}, net {net}{there}{known}")
    });
    let mend = match (least, most_friction) {
        (Some(least), _) => format!("raise `potential` to {least}"),
        (None, Some(friction)) => format!("no potential moves it: lower `friction` to {}", digits(friction)),
        (None, None) => "raise `potential`".to_owned(),
    };
    Diagnostic::new(Code::E0411, title).help(format!("{mend}{}", forces.unwrap_or_default()))
}

pub fn step_too_short(step: &str, settling: &str, least: &str) -> Diagnostic {
    Diagnostic::new(
        Code::E0412,
        format!("a step lasts {step}, but a part needs {settling} to come to rest on the next cell"),
    )
    .help(format!("make `step_duration` {least} or longer"))
}

pub fn never_settles(drag: &str) -> Diagnostic {
    Diagnostic::new(Code::E0412, "a part does not come to rest on the next cell").help(format!(
        "check the unit of `{drag}`: without drag a part swings about its goal, and in thick liquid it creeps"
    ))
}

pub fn rows_of_map(found: usize, rows: u32) -> Diagnostic {
    Diagnostic::new(
        Code::E0429,
        format!("`channels` has {found} rows, but the board has {rows}").replace(" 1 rows", " 1 row"),
    )
    .help("write a list for each row, the top row first, with `none` where the board has no electrode")
}

pub fn row_of_map(row: u32, found: usize, columns: u32) -> Diagnostic {
    let title = format!("row {row} of `channels` has {found} places, but the board has {columns} columns");
    Diagnostic::new(Code::E0429, title.replace(" 1 places", " 1 place").replace(" 1 columns", " 1 column"))
        .help("write a number or `none` for each column, from the left")
}

/// A channel with several electrodes on a board of microparts.
pub fn microparts_on_shared_channel(channel: u32) -> Diagnostic {
    Diagnostic::new(Code::E0429, format!("channel {channel} drives several electrodes of a board that carries microparts"))
        .help("write a number of its own at each place: a pair of electrodes moves a micropart; only droplets are moved on shared channels")
}

/// More electrodes on shared channels than are replayed.
pub fn too_many_sharing(electrodes: usize) -> Diagnostic {
    Diagnostic::new(Code::E0429, format!("{electrodes} electrodes share channels; at most {MAX_SHARING} may"))
        .help("give some of them channels of their own, or write `none` where no droplet goes")
}

pub fn no_electrode() -> Diagnostic {
    Diagnostic::new(Code::E0429, "the board has no electrodes")
        .help("write the number of the driver's channel at each place that has an electrode")
}

/// Two fields of one file that both give channels.
pub fn two_maps() -> Diagnostic {
    Diagnostic::new(Code::E0429, "`map` and `channels` both give the channels of the electrodes")
        .help("remove one of them: `map` takes everything from its file")
}

/// A number of columns or rows that differs from that of the board file.
pub fn side_of_map(name: &str, given: u32, board: &BoardFile) -> Diagnostic {
    let (side, path) = (if name == "columns" { board.columns } else { board.rows }, &board.path);
    let title = format!("`{name}` is {given}, but the electrodes of `{path}` have {side} {name}");
    let title = if side == 1 { title.trim_end_matches('s').to_owned() } else { title };
    Diagnostic::new(Code::E0429, title)
        .help(format!("write {side}, or leave `{name}` out: `map` takes it from the file"))
}

/// Most electrode names in a label.
const MOST_NAMES: usize = 12;

/// Electrodes of a board file that droplets cannot use.
pub fn left_out(board: &BoardFile) -> Diagnostic {
    let LeftOut { sharing, cut_off, off_lattice } = &board.left_out;
    let kept = board.channels.iter().flatten().count();
    let count = sharing.len() + cut_off.len() + off_lattice.len();
    let title = format!("{count} of the {} electrodes of `{}` are left out", kept + count, board.path);
    let title = if count == 1 { title.replace("are left out", "is left out") } else { title };
    Diagnostic::new(Code::W0405, title).help(
        "droplets are not sent there; switch them by hand or by your own program, or write the board out as `channels` with other places",
    )
}

/// Label text for the electrodes that are left out.
pub fn names_left_out(LeftOut { sharing, cut_off, off_lattice }: &LeftOut) -> String {
    let named = |names: &[String], why: &str| {
        let mut seen = BTreeSet::new();
        let distinct: Vec<&str> = names.iter().map(String::as_str).filter(|name| seen.insert(*name)).collect();
        let shown = distinct.iter().take(MOST_NAMES).copied().collect::<Vec<_>>().join(", ");
        let more = distinct.len().saturating_sub(MOST_NAMES);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        (!names.is_empty()).then(|| format!("{why}: {shown}{more}"))
    };
    let parts = [
        named(sharing, "on a channel with others that are left out"),
        named(cut_off, "cut off from the others"),
        named(off_lattice, "off the lattice"),
    ];
    parts.into_iter().flatten().collect::<Vec<_>>().join("; ")
}

pub fn microparts_need_all() -> Diagnostic {
    Diagnostic::new(Code::E0429, "a board that carries microparts needs a working electrode at every place")
        .help("put an `obstacle` on the cells of electrodes that do not work; gaps are for boards of droplets")
}

pub fn nothing_to_disable(facts: &ElectrodeArrayFacts, value: &Value) -> Diagnostic {
    let ElectrodeArrayFacts { columns, rows, .. } = facts;
    let title = format!("{} is not an electrode of the board", written(value));
    Diagnostic::new(Code::E0429, title).help(format!(
        "cells go from (1, 1), at the lower left, to ({columns}, {rows}); leave out those that are `none` in `channels`"
    ))
}

/// Reason why no centre can be at a cell of the board.
fn no_place(facts: &ElectrodeArrayFacts, cell: ElectrodeCell) -> Option<String> {
    let map = facts.map.as_ref().filter(|map| facts.is_on_board(cell) && !map.works(cell))?;
    Some(match map.has_electrode(cell) {
        true => format!("the electrode at {cell} is disabled"),
        false => format!("the board has no electrode at {cell}"),
    })
}

pub fn unknown_layout(found: &str) -> Diagnostic {
    Diagnostic::new(Code::E0413, format!("a part has {found} electrodes, but boards carry (1, 1) and (2, 2)"))
        .help("write `layout { electrodes: (2, 2), half_width: 1.5 }` for a micropart, `(1, 1)` for a droplet")
}

pub fn body_too_small(half: f64, least: f64) -> Diagnostic {
    let title = format!(
        "a half width of {} pitches is too small: the electrodes of the part reach {}",
        digits(half),
        digits(least)
    );
    Diagnostic::new(Code::E0413, title)
        .help(format!("make `half_width` {} or more: the body holds its electrodes", digits(least)))
}

pub fn bodies_touch(apart: u32, width_pitches: f64, least: u32) -> Diagnostic {
    let title = format!("parts of {} pitches touch at a separation of {apart}", digits(width_pitches));
    Diagnostic::new(Code::E0414, title).help(format!("make `separation` {least} or more"))
}

pub fn parts_pulled(apart: u32, least: u32) -> Diagnostic {
    Diagnostic::new(
        Code::E0414,
        format!(
            "at a separation of {apart}, the electrodes of one part pull on the next; they reach up to {}",
            least - 1
        ),
    )
    .help(format!("make `separation` {least} or more: an electrode pulls what lies beside it, diagonals included"))
}

pub fn obstacle_under_body(clearance: u32, half: f64, least: u32) -> Diagnostic {
    let title =
        format!("a clearance of {clearance} is too small: a part reaches {} pitches from its centre", digits(half));
    Diagnostic::new(Code::E0414, title).help(format!("make `clearance` {least} or more"))
}

pub fn board_too_small(columns: u32, rows: u32, least: u32) -> Diagnostic {
    Diagnostic::new(
        Code::E0415,
        format!("a board has {columns} x {rows} electrodes, but a part needs {least} x {least}"),
    )
    .help(format!("make `columns` and `rows` {least} or more"))
}

pub fn published_separation() -> Diagnostic {
    Diagnostic::new(Code::W0402, "the separations of table 3 let parts collide in 3 of its 25 entries")
        .help(
            "the unsafe ones, with the first part to the right of and above the second: one to the right, two up (v1, v4), 4 rows \
             apart; one to the left, two down (v2, v3), 4 columns apart; one down, two to the right (v3, v1), 4 rows or 4 \
             columns apart; the verifier refuses such steps: for real work write `separation: 4`",
        )
}

/// `chosen` is the planner, or the first step.
pub fn published_needs_published(chosen: Option<Span>) -> Diagnostic {
    let diagnostic = Diagnostic::new(Code::E0520, "planner `portfolio` cannot plan with separations `as_published`");
    let diagnostic = match chosen {
        Some(span) => diagnostic.label(span, "planned by `portfolio`"),
        None => diagnostic,
    };
    diagnostic
        .help("write `using cooperative_astar` or `using plain_cooperative_astar`, or give the device `separation: 4`")
}

pub fn stands_nowhere(span: Span, noun: &str, name: &str) -> Diagnostic {
    let dispensed = if noun == "part" { "; only droplets come out of reservoirs and other droplets" } else { "" };
    Diagnostic::new(Code::E0515, format!("{noun} `{name}` has no place"))
        .label(span, "where?")
        .help(format!("write `{noun} {name} at (5, 3)`, column and row from 1{dispensed}"))
}

pub fn no_cell(span: Span, found: &Value) -> Diagnostic {
    Diagnostic::new(Code::E0515, format!("expected a whole cell, found {}", written(found)))
        .label(span, if is_cell(found) { "no electrode".to_owned() } else { found.describe() })
        .help("write `(5, 3)`: the column and the row of an electrode, whole numbers from 1")
}

/// Whether this is a pair of plain numbers, possibly not whole.
fn is_cell(found: &Value) -> bool {
    matches!(found, Value::Point(point) if point.iter().all(|number| number.dimension == Dimension::NUMBER))
}

/// A point of numbers as written; anything else by its kind.
fn written(found: &Value) -> String {
    match found {
        Value::Point(point) if is_cell(found) => {
            let numbers: Vec<String> = point.iter().map(ToString::to_string).collect();
            format!("({})", numbers.join(", "))
        }
        other => other.describe_fully(),
    }
}

pub fn off_board(
    span: Span,
    noun: &str,
    name: &str,
    pair: [i64; 2],
    facts: &ElectrodeArrayFacts,
    device: &str,
) -> Diagnostic {
    let ElectrodeArrayFacts { columns, rows, .. } = facts;
    let (what, [first, last]) = match (noun, facts.reach()) {
        ("part", Some(reach)) => ("cell that it can take", reach),
        _ => ("electrode", [ElectrodeCell::new(1, 1), ElectrodeCell::new(*columns, *rows)]),
    };
    let near = |at: i64, first: u32, last: u32| at.clamp(first.into(), last.into());
    let [column, row] = pair;
    let title = format!("{noun} `{name}` at ({column}, {row}) is off the board of (1, 1) to ({columns}, {rows})");
    Diagnostic::new(Code::E0515, title).label(span, format!("`{device}` has {columns} columns and {rows} rows")).help(
        format!(
            "the nearest {what} is ({}, {})",
            near(column, first.column, last.column),
            near(row, first.row, last.row)
        ),
    )
}

/// The range of cells that a part can take, for a message.
fn extent(reach: Option<[ElectrodeCell; 2]>) -> String {
    reach.map_or("no cell".to_owned(), |[first, last]| format!("{first} to {last}"))
}

fn nearest(cell: Option<ElectrodeCell>, what: &str) -> Option<String> {
    cell.map(|cell| format!("the nearest cell {what} is {cell}"))
}

pub fn part_out_of_reach(
    span: Span,
    [noun, name]: [&str; 2],
    cell: ElectrodeCell,
    facts: &ElectrodeArrayFacts,
    near: Option<ElectrodeCell>,
) -> Diagnostic {
    let (title, label) = match no_place(facts, cell) {
        Some(why) => (format!("{noun} `{name}` cannot be at {cell}: {why}"), "nothing holds it here"),
        None => (
            format!(
                "{noun} `{name}` at {cell} extends beyond the rim; part centres may be at {}",
                extent(facts.reach())
            ),
            "its electrodes do not fit on the board here",
        ),
    };
    Diagnostic::new(Code::E0515, title).label(span, label).help_if(nearest(near, "that it can take"))
}

pub fn goal_out_of_reach(
    span: Span,
    [column, row]: [i64; 2],
    facts: &ElectrodeArrayFacts,
    free: Option<ElectrodeCell>,
) -> Diagnostic {
    let cell =
        u32::try_from(column).ok().zip(u32::try_from(row).ok()).map(|(column, row)| ElectrodeCell::new(column, row));
    let title = cell.and_then(|cell| no_place(facts, cell)).unwrap_or_else(|| {
        format!("cell ({column}, {row}) is not one of the cells that a part can take, {}", extent(facts.reach()))
    });
    Diagnostic::new(Code::E0501, title).label(span, "cannot be reached").help_if(nearest(free, "that is free"))
}

/// A start or goal too near to an obstacle, with the code to report.
pub fn near_obstacle(
    place: Spanned<ElectrodeCell>,
    code: Code,
    name: &str,
    obstacle: Span,
    distance: u32,
    apart: u32,
    free: Option<ElectrodeCell>,
) -> Diagnostic {
    let Spanned { value: cell, span } = place;
    let title = match distance {
        0 => format!("cell {cell} lies on obstacle `{name}`"),
        distance => {
            format!("cell {cell} lies {distance} electrodes from obstacle `{name}`; at least {apart} are needed")
        }
    };
    Diagnostic::new(code, title.replace(" 1 electrodes", " 1 electrode"))
        .label(span, if distance == 0 { "covered" } else { "too near" })
        .label(obstacle, "the obstacle")
        .help_if(nearest(free, "that is free"))
}

/// `found` and `carried` are electrodes and half width.
pub fn part_of_other_layout(
    name: &str,
    found: (Span, (String, String)),
    carried: (Span, (String, String)),
) -> Diagnostic {
    let text = |(electrodes, half): &(String, String)| format!("{electrodes} electrodes and a half width of {half}");
    let title = format!("`{name}` has {}, but the device carries {}", text(&found.1), text(&carried.1));
    Diagnostic::new(Code::E0521, title)
        .label(found.0, "another layout")
        .label(carried.0, "what the device carries")
        .help("leave the layout out to use that of the device; one board carries parts of one layout")
}

/// `parts` has the part that starts too near, then the earlier one.
pub fn starts_too_near(parts: [PartPlace; 2], apart: u32, free: Option<ElectrodeCell>) -> Diagnostic {
    let [PartPlace { name, cell, span }, PartPlace { name: other, cell: at, span: other_span }] = parts;
    let title = match cell.apart(at) {
        0 => format!("parts `{other}` and `{name}` start on the same cell"),
        distance => {
            format!("parts `{other}` and `{name}` start {}; the least distance is {apart}", electrodes(distance))
        }
    };
    Diagnostic::new(Code::E0523, title)
        .label(span, format!("`{name}` starts here"))
        .label_elsewhere(other_span, span, format!("`{other}` starts here"))
        .help_if(nearest(free, &format!("that is free for `{name}`")))
}

fn electrodes(distance: u32) -> String {
    format!("{} apart", count(distance, "electrode"))
}

/// `goals` has the goal that is too near, then the earlier one.
pub fn goals_too_near(goals: [PartPlace; 2], apart: u32, free: Option<ElectrodeCell>) -> Diagnostic {
    let [PartPlace { name, cell, span }, PartPlace { name: other, cell: at, span: other_span }] = goals;
    let title = match cell.apart(at) {
        0 => format!("parts `{other}` and `{name}` have the same goal"),
        distance => {
            format!("the goals of `{other}` and `{name}` are {}; the least distance is {apart}", electrodes(distance))
        }
    };
    Diagnostic::new(Code::E0524, title)
        .label(span, format!("goal of `{name}`"))
        .label_elsewhere(other_span, span, format!("goal of `{other}`"))
        .help_if(nearest(free, &format!("that is free for `{name}`")))
}

/// As [`goals_too_near`], for the last stops of parts that may go on from there.
pub fn ends_too_near(ends: [PartPlace; 2], apart: u32, free: Option<ElectrodeCell>) -> Diagnostic {
    let on = format!("send `{}` or `{}` on from there, with `move` or `discard`", ends[1].name, ends[0].name);
    let nearest = nearest(free, &format!("that is free for `{}`", ends[0].name));
    let help = nearest.map_or_else(|| on.clone(), |nearest| format!("{on}; {nearest}"));
    goals_too_near(ends, apart, free).help(help)
}

/// A part that is sent too near to one that stays; in an assay the latter may go on by an operation of its own.
pub fn near_standing_part(
    moved: PartPlace,
    stays: PartPlace,
    apart: u32,
    free: Option<ElectrodeCell>,
    in_assay: bool,
) -> Diagnostic {
    let PartPlace { name, cell, span } = moved;
    let PartPlace { name: other, cell: at, span: since } = stays;
    let title = match cell.apart(at) {
        0 => format!("`{name}` is sent to {cell}, where `{other}` is"),
        distance => {
            let distance = electrodes(distance).replace(" apart", "");
            format!("`{name}` is sent to {cell}, {distance} from `{other}` at {at}; the least distance is {apart}")
        }
    };
    let aside = match in_assay {
        true => format!("send `{other}` away in this assay, as `move {other} to CELL`"),
        false => format!("send `{other}` away before, or in the same `together`"),
    };
    Diagnostic::new(Code::E0524, title)
        .label(span, if cell == at { "taken" } else { "too near" })
        .label_elsewhere(since, span, format!("`{other}` is at {at} by then"))
        .help(nearest(free, "that is free").map(|free| format!("{free}; or {aside}")).unwrap_or(aside))
}

pub fn two_goals(name: &str, span: Span, earlier: Span) -> Diagnostic {
    Diagnostic::new(Code::E0525, format!("`{name}` has two goals at the same time"))
        .label(span, "again here")
        .label_elsewhere(earlier, span, "first here")
        .help("write two steps, one below the other, or one `move` with `via`")
}

/// A part that stands too near to an obstacle of a later run's scene; `part.span` is what brought it there.
pub fn obstacle_comes_near(
    run: Span,
    part: PartPlace,
    obstacle: &str,
    at: Span,
    distance: u32,
    apart: u32,
) -> Diagnostic {
    let PartPlace { name, cell, span: since } = part;
    let title = match distance {
        0 => format!("`{name}` is at {cell} by then, on obstacle `{obstacle}` of this run's scene"),
        distance => {
            let distance = electrodes(distance).replace(" apart", "");
            format!(
                "`{name}` is at {cell} by then, {distance} from obstacle `{obstacle}`; the least distance is {apart}"
            )
        }
    };
    Diagnostic::new(Code::E0530, title)
        .label(run, "begins with a different scene from the previous run")
        .label(since, format!("`{name}` has been at {cell} since this"))
        .label(at, "the obstacle")
        .help(format!("send `{name}` away before this run, or give the tasks of the device one scene"))
}

pub fn unlike_parts(run: Span, device: &str, name: &str) -> Diagnostic {
    Diagnostic::new(
        Code::E0528,
        format!("tasks of `{device}` in one schedule have different parts: `{name}` is not in both scenes"),
    )
    .label(run, "not the same parts as before")
    .help("a board keeps its parts between tasks: give all of them one scene, or scenes with parts of the same names")
}
