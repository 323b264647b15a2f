//! Microrobots: E0416 and above, E0531 and above.
//!
//! Findings about a device come without labels: the caller labels its fields and cells, in whichever file they are.

pub use crate::check::errors::*;

use crate::check::value::Value;
use crate::diagnostic::{Code, Diagnostic};
use crate::geometry::Pose;
use crate::quantity::{Dimension, Quantity, digits, round_down, round_up, significant};
use crate::source::Span;

/// A voltage for a message.
fn volts(v: f64) -> String {
    format!("{} V", digits(six_digits(v)))
}

/// A length for a message.
pub fn length(um: f64) -> String {
    Quantity::new(six_digits(um / 1e6), Dimension::LENGTH).to_string()
}

/// A length of three digits rounded down, for values that fall short.
fn at_most(um: f64) -> String {
    length(round_down(um, 3))
}

/// A length of three digits rounded up, for excessive values and for fixes.
fn at_least(um: f64) -> String {
    length(round_up(um, 3))
}

/// An angle for a message.
fn angle(rad: f64) -> String {
    Quantity::new(six_digits(rad.to_degrees()).to_radians(), Dimension::ANGLE).to_string()
}

/// A value of six significant digits; a mere rounding difference becomes 0.
fn six_digits(value: f64) -> f64 {
    if value.abs() < 1e-12 { 0.0 } else { significant(value, 6) }
}

pub fn too_many_cycles(fine: &str, cycles: f64, most: f64) -> Diagnostic {
    let title = format!("a fine motion of {fine} has {} cycles; the limit is {}", digits(cycles.ceil()), digits(most));
    Diagnostic::new(Code::E0423, title).help("make `fine_length` shorter, or `fine_cycle` longer")
}

/// A pose in program syntax.
pub fn pose_text(pose: &Pose) -> String {
    let Pose { x_um, y_um, heading_rad } = *pose;
    let heading = angle(heading_rad.rem_euclid(std::f64::consts::TAU));
    format!("pose({}, {}, {heading})", length(x_um), length(y_um))
}

pub fn too_many_robots(found: usize, most: usize) -> Diagnostic {
    Diagnostic::new(Code::E0403, format!("the table has {found} robots; one bed takes at most {most}"))
        .help("divide the robots among several beds")
}

pub fn robot_twice(name: &str) -> Diagnostic {
    Diagnostic::new(Code::E0417, format!("robot `{name}` has two rows"))
        .help("give each robot a name of its own, and one row")
}

pub fn stroke_out_of_clock(frequency: Quantity) -> Diagnostic {
    let title = format!("a stroke at {frequency} does not fit the clock of whole nanoseconds");
    Diagnostic::new(Code::E0404, title).help("make `drive_frequency` 500 MHz or less, and 10 uHz or more")
}

pub fn beyond_extent(name: &str, found: Quantity, least_um: f64, most_um: f64) -> Diagnostic {
    let (least, most, unit) = (length(least_um), length(most_um), if name == "speed" { " per stroke" } else { "" });
    let limit =
        if least_um > 0.0 { format!("between {least} and {most}{unit}") } else { format!("at most {most}{unit}") };
    Diagnostic::new(Code::E0403, format!("`{name}` is {found}, but must be {limit}")).help("check its unit")
}

pub fn beyond_figure(name: &str, found: Quantity, most: Quantity) -> Diagnostic {
    Diagnostic::new(Code::E0403, format!("`{name}` is {found}, but must be at most {most}")).help("check its unit")
}

pub fn some_error_bounds(missing: &[&str]) -> Diagnostic {
    let list = listed(missing.iter().copied());
    Diagnostic::new(Code::W0404, format!("the error bounds lack {list}: nothing can be guaranteed"))
        .help(format!("add {list}, 0 where there is no such error, or leave the others out"))
}

pub fn guaranteed_drive(setting: Span, drive: Span) -> Diagnostic {
    Diagnostic::new(Code::E0605, "a task with `drive` on a device with errors is never guaranteed")
        .label(setting, "requires that its goals are guaranteed")
        .label_elsewhere(drive, setting, "measured and corrected on the way; nothing is proven about it")
        .help("leave `guaranteed` out, or leave `drive` out: the dockings of `assemble` from the poses of the scene can be guaranteed")
}

pub fn failures_in_vain(span: Span, why: &str) -> Diagnostic {
    Diagnostic::new(Code::W0504, "`minimize failures` changes nothing: no trial can be simulated")
        .label(span, why.to_owned())
        .help("leave the line out; for an assembly on a device with all error bounds it chooses the plan that fails least")
}

pub fn no_stroke(relax: &str, flex: &str) -> Diagnostic {
    Diagnostic::new(Code::E0419, format!("relax level {relax} must be below the flex level of {flex}"))
        .help("a stroke goes up to `flex` and back to `relax`: make `relax` the lower one")
}

pub fn flex_beyond_source(flex: &str, most: &str) -> Diagnostic {
    Diagnostic::new(Code::E0419, format!("flex level {flex} is above the {most} that the source gives"))
        .help(format!("make `flex` {most} or less"))
}

pub fn docking_sideways(name: &str, found: &str) -> Diagnostic {
    Diagnostic::new(Code::E0423, format!("`{name}` is {found}, but must be less than 90 deg"))
        .help("robots meet with their fronts: 60 deg was measured for meeting head-on, and 45 deg for sticking")
}

pub fn cycle_beyond_fine_motion(cycle: &str, fine: &str) -> Diagnostic {
    Diagnostic::new(Code::E0423, format!("a fine cycle of {cycle} is longer than its fine motion of {fine}"))
        .help(format!("make `fine_cycle` {fine} or less: a fine motion consists of whole cycles"))
}

pub fn relay_label(name: &str, snap_down_v: f64, release_v: f64) -> String {
    format!("`{name}`: down at {}, up at {}", volts(snap_down_v), volts(release_v))
}

pub fn release_above_snap_down(name: &str, release_v: f64, snap_down_v: f64) -> Diagnostic {
    let (release, snap_down) = (volts(release_v), volts(snap_down_v));
    let title = format!(
        "the arm of `{name}` is released at {release}, but must be released below its snap-down at {snap_down}"
    );
    Diagnostic::new(Code::E0418, title)
        .help("an arm that is down stays down until the voltage falls far below the one that lowered it")
}

/// A level from which a voltage of the table must keep its distance.
#[derive(Debug, Clone, Copy)]
pub enum Limit {
    Hold { relax_v: f64, most_v: f64 },
    Drive { flex_v: f64, least_v: f64 },
    Range { max_v: f64, most_v: f64 },
    Floor { least_v: f64 },
}

impl Limit {
    /// The label at the cell.
    pub fn label(self) -> String {
        match self {
            Limit::Hold { most_v, .. } | Limit::Range { most_v, .. } => format!("at most {}", volts(most_v)),
            Limit::Drive { least_v, .. } | Limit::Floor { least_v } => format!("at least {}", volts(least_v)),
        }
    }
}

pub fn voltage_out_of_limit(name: &str, found_v: f64, limit: Limit, margin_v: f64) -> Diagnostic {
    let (found, margin) = (volts(found_v), volts(margin_v));
    let (code, title) = match limit {
        Limit::Hold { relax_v, most_v } => {
            let (relax, short) = (volts(relax_v), volts(found_v - most_v));
            let title = format!(
                "a relax level of {relax} could raise the arm of `{name}`: its release at {found} is {short} too high"
            );
            (Code::E0419, title)
        }
        Limit::Drive { flex_v, least_v } => {
            let (flex, short) = (volts(flex_v), volts(least_v - found_v));
            let title = format!(
                "a flex level of {flex} could lower the arm of `{name}`: its snap-down at {found} is {short} too low"
            );
            (Code::E0419, title)
        }
        Limit::Range { max_v, .. } => {
            let most = volts(max_v);
            let title = format!(
                "even the maximum of {most} may not lower the arm of `{name}`: it snaps down at {found} +- {margin}"
            );
            (Code::E0418, title)
        }
        Limit::Floor { .. } => {
            (Code::E0418, format!("even 0 V may not raise the arm of `{name}`: it is released at {found} +- {margin}"))
        }
    };
    Diagnostic::new(code, title)
}

pub fn narrow_gap(name: &str, gap_v: f64, least_v: f64) -> Diagnostic {
    let (gap, least) = (volts(gap_v), volts(least_v));
    let title = format!("`{name}` is released only {gap} below its snap-down; 2 x margin = {least} is needed");
    Diagnostic::new(Code::E0418, title)
}

pub fn nested_gaps(outer: &str, inner: &str, [snap_down_v, release_v]: [f64; 2]) -> Diagnostic {
    let (snap_down, release) = (volts(snap_down_v), volts(release_v));
    let title =
        format!("nested gaps: `{outer}` snaps down {snap_down} above `{inner}`, and is released {release} below it");
    Diagnostic::new(Code::E0420, title)
        .help("the robot that snaps down later must be released earlier; or give the device `non_string: true`")
}

pub fn alike_robots(one: &str, other: &str, [snap_down_v, release_v]: [f64; 2], least_v: f64) -> Diagnostic {
    let title = if snap_down_v == 0.0 && release_v == 0.0 {
        format!("`{one}` and `{other}` have the same voltages: no level moves one arm without the other")
    } else {
        let [snap_down, release, least] = [snap_down_v, release_v, least_v].map(volts);
        format!(
            "`{one}` and `{other}` differ by {snap_down} in snap-down and {release} in release; 2 x margin = {least} is \
             needed in one of them"
        )
    };
    Diagnostic::new(Code::E0421, title).help("no voltage moves one of the two arms without the other")
}

/// The state with the robots that it lowers; `levels` are those that it takes and those that are allowed.
pub fn no_sequence(state: usize, lowered: &[&str], [levels, most]: [usize; 2], least_v: f64) -> Diagnostic {
    let least = volts(least_v);
    let title = match lowered {
        _ if levels > most => {
            format!("control state {state} needs a cycle of {levels} levels; at most {most} are allowed")
        }
        [] => format!("no control cycle of {most} levels or fewer raises all arms"),
        lowered => {
            let list = listed(lowered.iter().copied());
            format!("no control cycle of {most} levels or fewer lowers {list} and raises the others")
        }
    };
    Diagnostic::new(Code::E0422, title).help(format!(
        "with 2 x margin = {least} between the labelled voltages in one of the columns, two levels are enough"
    ))
}

/// Labels of two voltages that are too near: of the arm that must be down, and of the one that must be up.
pub fn gap_labels(column: &str, [down, up]: [&str; 2], gap_v: f64) -> [String; 2] {
    let gap = volts(gap_v.abs());
    let verb = if column == "release" { "is released" } else { "snaps down" };
    let low = format!("`{down}` must be down");
    let high = match gap_v {
        gap_v if gap_v > 0.0 => format!("`{up}` must be up; it {verb} {gap} above"),
        gap_v if gap_v < 0.0 => format!("`{up}` must be up; it {verb} {gap} below"),
        _ => format!("`{up}` must be up; it {verb} at the same voltage"),
    };
    [low, high]
}

pub fn too_many_states(most: usize) -> Diagnostic {
    Diagnostic::new(Code::E0416, format!("more than {most} control states; the planner takes no more"))
        .help("nested gaps multiply the states: give robots that are used alike rows with the same voltages")
}

/// `code` is that of the last fault that was reported.
pub fn more_faults(code: Code, count: usize) -> Diagnostic {
    Diagnostic::new(code, format!("{count} more faults in this table")).help("fix the others first")
}

/// The change of one voltage that fixes a table.
pub fn voltage_mend(column: &str, name: &str, [now_v, to_v]: [f64; 2]) -> String {
    let verb = if to_v > now_v { "raise" } else { "lower" };
    format!("{verb} `{column}` of `{name}` from {} to {}", volts(now_v), volts(to_v))
}

/// The change of a level of the device that fixes a table.
pub fn level_mend(field: &str, [now_v, to_v]: [f64; 2]) -> String {
    format!("{} `{field}` to {}", if to_v > now_v { "raise" } else { "lower" }, volts(to_v))
}

pub fn small_slack(state: usize, digits: &str, slack_v: f64, margin_v: f64) -> Diagnostic {
    let (slack, share) = (volts(slack_v), volts(margin_v / 10.0));
    let title =
        format!("control state {state} (0b{digits}) has a slack of {slack}, less than 10 % of the margin, {share}");
    Diagnostic::new(Code::W0403, title)
        .help("levels that are off by more than the slack leave an arm uncertain: move the voltages further apart")
}

pub fn more_small_slacks(count: usize) -> Diagnostic {
    Diagnostic::new(Code::W0403, format!("{count} more control states with a slack of less than 10 % of the margin"))
        .help("move the voltages further apart, or measure them better")
}

/// `device` is its name, and where its table stands.
pub fn robot_without_row(
    span: Span,
    name: &str,
    near: Option<&str>,
    known: &[&str],
    device: &str,
    table: Option<Span>,
) -> Diagnostic {
    let diagnostic = Diagnostic::new(Code::E0532, format!("the table of `{device}` has no robot `{name}`"))
        .label(span, "not in the table");
    let diagnostic = match table {
        Some(table) => diagnostic.label(table, "the table"),
        None => diagnostic,
    };
    let few = &known[..known.len().min(12)];
    let list = format!("its robots are {}{}", listed(few.iter().copied()), rest(known.len(), 12));
    match near {
        Some(near) => diagnostic.near(near).help(format!("did you mean `{near}`? {list}")),
        None => diagnostic.help(list),
    }
}

/// The rest of a shortened list.
fn rest(count: usize, shown: usize) -> String {
    if count > shown { format!(" and {} more", count - shown) } else { String::new() }
}

pub fn robot_with_shape(span: Span, name: &str) -> Diagnostic {
    Diagnostic::new(Code::E0514, format!("robot `{name}` has the body of its device, not one of its own"))
        .label(span, "no shape belongs here")
        .help(format!(
            "write `robot {name} at pose(0 um, 0 um, 90 deg)`; `length` and `width` may be columns of the table"
        ))
}

pub fn robot_stands_nowhere(span: Span, name: &str) -> Diagnostic {
    Diagnostic::new(Code::E0515, format!("robot `{name}` has no pose"))
        .label(span, "where?")
        .help(format!("write `robot {name} at pose(0 um, 0 um, 90 deg)`: place and heading, where 0 deg faces +x"))
}

pub fn no_heading(span: Span, name: &str, found: &Value) -> Diagnostic {
    let help = match found {
        Value::Point(point) if point.len() == 2 && point[0].dimension == Dimension::LENGTH => {
            format!("write `pose({}, {}, 90 deg)`: 0 deg faces +x and 90 deg faces +y", point[0], point[1])
        }
        _ => "write `pose(0 um, 0 um, 90 deg)`: place and heading, where 0 deg faces +x and 90 deg faces +y".to_owned(),
    };
    Diagnostic::new(
        Code::E0533,
        format!("robot `{name}` needs a pose with a heading, but this is {}", found.describe()),
    )
    .label(span, "where does it face?")
    .help(help)
}

pub fn obstacle_without_place(span: Span, found: &Value) -> Diagnostic {
    Diagnostic::new(
        Code::E0515,
        format!("an obstacle of a bed needs a place or a pose, but this is {}", found.describe()),
    )
    .label(span, found.describe())
    .help("write `at (900 um, 2.5 mm)`, or `at pose(900 um, 2.5 mm, 30 deg)` for a turned shape")
}

/// A heading so large that its direction is lost in rounding.
pub fn heading_too_large(span: Span, most_deg: f64) -> Diagnostic {
    Diagnostic::new(Code::E0501, format!("a heading is more than {} deg", digits(most_deg)))
        .label(span, "too many turns to be exact")
        .help("write a heading between -180 deg and 180 deg")
}

/// A control state whose strokes carry a robot farther than can be planned.
pub fn applied_too_far(span: Span, name: &str, way_um: f64, most_um: f64) -> Diagnostic {
    Diagnostic::new(
        Code::E0501,
        format!("this carries `{name}` {}; at most {} can be planned", length(way_um), length(most_um)),
    )
    .label(span, "applied for too long")
    .help("apply it for a shorter time, or check the unit of `speed`")
}

pub fn pose_too_far(span: Span, most_um: f64) -> Diagnostic {
    Diagnostic::new(Code::E0501, format!("a place is further from the origin than {}", length(most_um)))
        .label(span, "cannot be reached")
        .help("check the units of its coordinates")
}

/// A robot whose start or goal, as `code` tells, is blocked.
pub struct BlockedRobot<'a> {
    pub code: Code,
    pub robot: &'a str,
    pub span: Span,
}

/// Actual and required distance of two bodies, for a title.
fn shortage([gap_um, kept_um]: [f64; 2], other: &str) -> String {
    if gap_um > 0.0 {
        format!("lies {} from {other}; at least {} is needed", at_most(gap_um), length(kept_um))
    } else if kept_um > 0.0 {
        format!("touches {other}; a gap of at least {} is needed", length(kept_um))
    } else {
        format!("touches {other}")
    }
}

/// `free` is the nearest pose that is clear.
pub fn robot_near_obstacle(
    what: &BlockedRobot,
    name: &str,
    obstacle: Span,
    gap_um: f64,
    kept_um: f64,
    free: Option<Pose>,
) -> Diagnostic {
    let short = shortage([gap_um, kept_um], &format!("obstacle `{name}`"));
    Diagnostic::new(what.code, format!("the body of `{}` {short}", what.robot))
        .label(what.span, if gap_um > 0.0 { "too near" } else { "covered" })
        .label(obstacle, "the obstacle")
        .help_if(free.map(|pose| format!("the nearest place that is free is {}", pose_text(&pose))))
}

/// The robot that stands too near, then the one that was there before.
pub fn robots_start_too_near(
    name: &str,
    span: Span,
    other: &str,
    other_span: Span,
    gap_um: f64,
    kept_um: f64,
) -> Diagnostic {
    let short = shortage([gap_um, kept_um], &format!("`{other}`"));
    Diagnostic::new(Code::E0534, format!("at its start, `{name}` {short}"))
        .label(span, format!("`{name}` starts here"))
        .label_elsewhere(other_span, span, format!("`{other}` starts here"))
        .help("start them further apart: all robots move with every stroke")
}

/// Accessible states as `0 (0b000)`, a few of them.
fn few_states(states: &[(usize, String)]) -> String {
    const SHOWN: usize = 12;
    let shown: Vec<String> = states.iter().take(SHOWN).map(|(index, digits)| format!("{index} (0b{digits})")).collect();
    format!("{}{}", shown.join(", "), rest(states.len(), SHOWN))
}

/// `asked` is the number or the pattern as it was written.
pub fn inaccessible_state(span: Span, asked: &str, device: &str, states: &[(usize, String)]) -> Diagnostic {
    Diagnostic::new(Code::E0531, format!("no voltage brings the arms of `{device}` to {asked}"))
        .label(span, "not accessible")
        .help(format!("its control states are {}, one digit for each row of the table", few_states(states)))
}

pub fn unknown_state(span: Span, asked: &str, device: &str, states: &[(usize, String)]) -> Diagnostic {
    let last = states.len().saturating_sub(1);
    Diagnostic::new(Code::E0531, format!("`{device}` has no control state {asked}: its states are 0 to {last}"))
        .label(span, "no such state")
        .help(format!("they are {}, one digit for each row of the table", few_states(states)))
}

pub fn pattern_of_wrong_width(span: Span, found: u32, robots: usize, device: &str) -> Diagnostic {
    Diagnostic::new(Code::E0504, format!("a word has {found} digits, but the table has {robots} robots"))
        .label(span, format!("`{device}` has {robots} robots"))
        .help(format!("write one digit for each row, the first row first, 1 for an arm that is down: {robots} digits"))
}

pub fn precision_below_step(span: Span, precision_um: f64, name: &str, step_um: f64) -> Diagnostic {
    let (precision, half, step) = (length(precision_um), length(step_um / 2.0), length(step_um));
    Diagnostic::new(Code::E0506, format!("precision {precision} is finer than half a stroke of `{name}`, {half}"))
        .label(span, format!("one stroke carries `{name}` {step}"))
        .help(format!("make it {} or more", at_least(step_um / 2.0)))
}

pub fn assembly_too_small(span: Span, count: usize) -> Diagnostic {
    let found = if count == 0 { "none" } else { "only one" };
    Diagnostic::new(Code::E0535, format!("an assembly needs two robots or more, but this names {found}"))
        .label(span, "nothing to dock with")
        .help(
            "name two robots or more, as in `assemble { D2 to pose(…), D1 to pose(…) }`; `drive` brings one to a pose",
        )
}

pub fn assembled_twice(name: &str, span: Span, earlier: Span) -> Diagnostic {
    Diagnostic::new(Code::E0535, format!("`{name}` is named twice in one assembly"))
        .label(span, "again here")
        .label_elsewhere(earlier, span, "first here")
        .help("remove one of the two: a robot docks once and stays there")
}

/// A docked robot that lies on an obstacle of a later scene.
pub fn obstacle_on_docked(run: Span, docked: &GoalPlace, obstacle: &str, at: Span) -> Diagnostic {
    let name = &docked.robot;
    Diagnostic::new(
        Code::E0530,
        format!("`{name}` has docked by then where obstacle `{obstacle}` of this run's scene lies"),
    )
    .label(run, "begins with a different scene from the previous run")
    .label(docked.span, format!("`{name}` has docked here"))
    .label(at, "the obstacle")
    .help("give the tasks of the device one scene, or keep the structure clear of obstacles in the later one")
}

pub fn unlike_robots(run: Span, device: &str, name: &str) -> Diagnostic {
    Diagnostic::new(
        Code::E0528,
        format!("tasks of `{device}` in one schedule have different robots: `{name}` is not in both scenes"),
    )
    .label(run, "not the same robots as before")
    .help("a bed keeps its robots between tasks: give all of them one scene, or scenes with robots of the same names")
}

/// A robot's goal, and where it stands in the source.
pub struct GoalPlace {
    pub robot: String,
    pub span: Span,
}

impl GoalPlace {
    fn label(&self) -> String {
        format!("goal of `{}`", self.robot)
    }
}

fn mended_at(mended: Option<Pose>, does: &str) -> Option<String> {
    mended.map(|pose| format!("a pose at which it {does} is {}", pose_text(&pose)))
}

pub fn docked_overlap(
    goal: &GoalPlace,
    other: &GoalPlace,
    depth_um: f64,
    most_um: f64,
    mended: Option<Pose>,
) -> Diagnostic {
    let (depth, most) = (at_least(depth_um), length(most_um));
    let title =
        format!("`{}` at its goal overlaps `{}` by {depth}; at most {most} is allowed", goal.robot, other.robot);
    Diagnostic::new(Code::E0536, title)
        .label(goal.span, goal.label())
        .label_elsewhere(other.span, goal.span, other.label())
        .help("put the goals further apart: a pose is that of the middle of a body")
        .help_if(mended_at(mended, "only touches"))
}

pub fn docked_apart(
    goal: &GoalPlace,
    other: &GoalPlace,
    gap_um: f64,
    most_um: f64,
    mended: Option<Pose>,
) -> Diagnostic {
    let (gap, most) = (at_least(gap_um), length(most_um));
    let title = format!(
        "`{}` at its goal touches nothing: it is {gap} from `{}`; at most {most} is allowed",
        goal.robot, other.robot
    );
    Diagnostic::new(Code::E0536, title)
        .label(goal.span, goal.label())
        .label_elsewhere(other.span, goal.span, format!("the nearest it could dock with, the {}", other.label()))
        .help("put the goal next to a robot that docks before this one: those that snap down last dock first")
        .help_if(mended_at(mended, "docks"))
}

/// `found` is the angle between the axes and their distance, if the two face each other; the distance may be up to
/// `most_um`.
pub fn not_head_on(
    goal: &GoalPlace,
    other: &GoalPlace,
    found: Option<(f64, f64)>,
    most_um: f64,
    mended: Option<Pose>,
) -> Diagnostic {
    let (one, two) = (&goal.robot, &other.robot);
    let title = match found {
        None => format!("`{one}` and `{two}` begin a structure, but do not face each other"),
        Some((_, offset_um)) if offset_um > most_um => format!(
            "`{one}` and `{two}` meet with an offset of {}; they align themselves up to {}",
            at_least(offset_um),
            length(most_um)
        ),
        Some((angle_rad, _)) => {
            format!(
                "`{one}` and `{two}` are {} from head-on, an angle that they do not keep when they touch",
                angle(angle_rad)
            )
        }
    };
    Diagnostic::new(Code::E0537, title)
        .label(goal.span, goal.label())
        .label_elsewhere(other.span, goal.span, other.label())
        .help("the first two robots of a structure align their fronts, as 90 deg meets 270 deg")
        .help_if(mended.map(|pose| format!("exactly head-on, `{one}` is at {}", pose_text(&pose))))
}

/// A robot at an angle to the edge with which it docks; `flat` is where it comes to lie.
pub fn not_flat(goal: &GoalPlace, met: &GoalPlace, angle_rad: f64, flat: Option<Pose>) -> Diagnostic {
    let title = format!(
        "`{}` at its goal is turned by {} from the edge of `{}`, an angle that it does not keep when it touches",
        goal.robot,
        angle(angle_rad),
        met.robot
    );
    Diagnostic::new(Code::E0537, title)
        .label(goal.span, goal.label())
        .label_elsewhere(met.span, goal.span, met.label())
        .help("a robot turns about the corner that touches first until its front lies along the edge")
        .help_if(flat.map(|pose| format!("flat on it, `{}` is at {}", goal.robot, pose_text(&pose))))
}

/// `asked` is the participle of the verb: `driven`, `assembled`.
pub fn docked_before(name: &str, span: Span, asked: &str, since: Span) -> Diagnostic {
    Diagnostic::new(Code::E0539, format!("`{name}` has docked by then and can no longer move"))
        .label(span, format!("{asked} here"))
        .label_elsewhere(since, span, "docked here")
        .help("drive it before it is assembled, or assemble it once")
}

pub fn goal_on_docked(goal: &GoalPlace, docked: &GoalPlace, gap_um: f64, kept_um: f64) -> Diagnostic {
    let short = shortage([gap_um, kept_um], &format!("`{}`, which has docked by then", docked.robot));
    Diagnostic::new(Code::E0502, format!("the body of `{}` {short}", goal.robot))
        .label(goal.span, if gap_um > 0.0 { "too near" } else { "covered" })
        .label_elsewhere(docked.span, goal.span, format!("`{}` has docked here", docked.robot))
        .help("choose a place further away, or assemble the robot: docked robots no longer move")
}
