//! Hands: E0425, E0540 and above.

pub use crate::check::errors::*;

use crate::check::value::Value;
use crate::device::fingers::{FingersFacts, MAX_GRASPS, Plane};
use crate::diagnostic::{Code, Diagnostic};
use crate::quantity::{Quantity, digits, round_down, round_up, significant};
use crate::real::Real;
use crate::source::Span;
use std::f64::consts::TAU;

/// Greatest turn of one step, in radians: a full turn plus rounding.
pub const MOST_RAD: f64 = TAU + 1e-9;

/// An angle of at most five digits for a message.
fn angle(rad: f64) -> String {
    let deg = rad.to_degrees();
    let deg = if deg.abs() < 1e-9 { 0.0 } else { significant(deg, 5) };
    format!("{} deg", digits(deg))
}

/// A length of at most five digits for a message.
pub fn length(um: f64) -> String {
    // A mere rounding difference is printed as 0.
    let um = if um.abs() < 1e-7 { 0.0 } else { significant(um, 5) };
    Quantity::length_um(um).to_string()
}

/// A force of at most four digits for a message.
fn force(un: f64) -> String {
    Quantity::force_un(significant(un, 4)).to_string()
}

pub fn hand_figure(name: &str, device: &str, found: &str, limit: &str) -> Diagnostic {
    Diagnostic::new(Code::E0403, format!("`{name}` of device `{device}` is {found}, but must be {limit}"))
        .help("check its unit")
}

pub fn precision_too_large(span: Span, found: Quantity, most_rad: f64) -> Diagnostic {
    Diagnostic::new(Code::E0403, format!("`precision` is {found}, but must be at most {}", angle(most_rad)))
        .label(span, "nearly any turn would do")
        .help("write how far from its goal a turn may end, as `precision: 0.5 deg`, or check the unit")
}

pub fn load_too_large(span: Span, force_un: f64, most_un: f64) -> Diagnostic {
    let [force, most] = [force_un, most_un].map(in_newtons);
    Diagnostic::new(Code::E0403, format!("`load` is {force}, but must be at most {most}"))
        .label(span, "no micro-gripper bears this")
        .help("write the force on the part, as `load: (0 uN, 0 uN, -0.2 uN)`, or check the unit")
}

pub fn tolerance_as_large_as_retract(facts: &FingersFacts) -> Diagnostic {
    let [tolerance, away] = [facts.tolerance_um, facts.slow_um()].map(length);
    let title = format!(
        "`tolerance` is {tolerance}, but must be less than {away}, the distance that a tip moves off its contact"
    );
    Diagnostic::new(Code::E0403, title).help("write a smaller `tolerance`, or a larger `retract`")
}

pub fn load_without_centre(span: Span, name: &str, shape: Span) -> Diagnostic {
    Diagnostic::new(Code::E0577, format!("`{name}` bears a load, but its centre of mass is not known"))
        .label(span, "acts at the centre of mass")
        .label(shape, "outlines that are not centred at the origin do not determine it")
        .help("state it with the outlines, as `centre_of_mass: (1.5 um, 0 um, 0 um)`")
}

pub fn part_too_heavy(span: Span, name: &str, weight_un: f64, most_un: f64) -> Diagnostic {
    let [weight, most] = [weight_un, most_un].map(in_newtons);
    Diagnostic::new(Code::E0403, format!("part `{name}` weighs {weight}, but at most {most} is allowed"))
        .label(span, "from its volume and its `material`")
        .help("check the unit of `material`: silicon has 2330 kg/m^3")
}

/// A force in a message.
fn in_newtons(force_un: f64) -> String {
    format!("{} N", digits(force_un * 1e-6))
}

pub fn gaiting_cost_not_whole(found: Quantity, most_deg: f64) -> Diagnostic {
    let nearest = found.si.to_degrees().round().clamp(1.0, most_deg);
    Diagnostic::new(
        Code::E0403,
        format!("`gaiting_cost` is {found}, but must be a whole number of degrees from 1 to {most_deg}"),
    )
    .help(format!("write `{nearest} deg`"))
}

pub fn step_divides_no_turn(step: Quantity) -> Diagnostic {
    let deg = step.si.to_degrees();
    let divisors: Vec<u32> = (1..=90).filter(|divisor| 360 % divisor == 0).collect();
    let below = divisors.iter().rev().find(|divisor| f64::from(**divisor) < deg);
    let above = divisors.iter().find(|divisor| f64::from(**divisor) > deg);
    let nearest: Vec<String> = [below, above].into_iter().flatten().map(|divisor| format!("`{divisor} deg`")).collect();
    Diagnostic::new(Code::E0425, format!("a rotation step of {step} does not divide 360 deg"))
        .help(format!("the nearest that do are {}", nearest.join(" and ")))
}

pub fn step_out_of_limits(step: Quantity, steps: f64, [least, most]: [u32; 2]) -> Diagnostic {
    let title = format!(
        "a rotation step of {step} makes {} steps of a full turn; {least} to {most} are allowed",
        digits(steps)
    );
    Diagnostic::new(Code::E0425, title).help("write a step from 1 deg to 90 deg, as `20 deg`")
}

pub fn part_without_shape(span: Span, name: &str) -> Diagnostic {
    Diagnostic::new(Code::E0514, format!("part `{name}` has no shape for the fingers to hold"))
        .label(span, "without a shape")
        .help(format!("write `part {name} : ellipsoid {{ axes: (16 um, 12 um, 12 um) }}`"))
}

pub fn part_place(span: Span, found: &Value) -> Diagnostic {
    Diagnostic::new(Code::E0515, format!("a part must be at a point in space, but this is {}", found.describe_fully()))
        .label(span, found.describe())
        .help("write `at (0 um, 0 um, 5 um)`, or leave it out for the hand's origin; at first, the axes of the part are along those of the hand")
}

/// A concave place that is too narrow for the tips.
pub fn tip_too_large(span: Span, at: &Tipped, radius_um: f64, device: Span) -> Diagnostic {
    let (least, name) = (length(radius_um), at.part);
    let title = format!(
        "a tip of radius {} does not fit into the hollow of `{name}`, of radius {least}",
        length(at.tip_radius_um)
    );
    Diagnostic::new(Code::E0540, title)
        .label(span, format!("near {} in the plane {}", at.place(), at.plane.name()))
        .label(device, "the tips of this device")
        .help(format!(
            "use tips with a radius of less than {}, which reach everywhere",
            length(round_down(radius_um, 2))
        ))
}

/// A place on a part, for a message.
pub struct Tipped<'a> {
    pub part: &'a str,
    pub plane: Plane,
    /// In the plane's coordinates.
    pub point_um: [f64; 2],
    pub tip_radius_um: f64,
}

impl Tipped<'_> {
    fn place(&self) -> String {
        let [a, b] = self.point_um;
        match self.plane {
            Plane::Xy => format!("x = {}, y = {}", length(a), length(b)),
            Plane::Xz => format!("x = {}, z = {}", length(a), length(-b)),
        }
    }
}

pub fn too_many_contacts(span: Span, name: &str, plane: Plane, found: f64, most: u32) -> Diagnostic {
    let title =
        format!("`{name}` has {} contacts in the plane {}; the limit is {most}", digits(found.round()), plane.name());
    Diagnostic::new(Code::E0541, title)
        .label(span, "too large for these tips and this step")
        .help("make `step` larger, or the tips: there are (360 deg + perimeter / tip radius) / step contacts")
}

/// A load makes grasps differ from angle to angle, so that there are more of them than the planner considers.
pub fn too_many_grasps(span: Span, name: &str, [contacts, angles]: [usize; 2], steps: u32) -> Diagnostic {
    let grasps = contacts.pow(3) * angles;
    let title = format!(
        "{contacts} contacts of `{name}` at {angles} angles make {grasps} grasps of three; the limit is {MAX_GRASPS}"
    );
    // Contacts and angles both grow with the steps of a turn.
    let per_step = contacts as f64 / f64::from(steps);
    let fits =
        |steps: &u32| (per_step * f64::from(*steps) + 1.0).whole_power(3) * f64::from(steps + 1) <= MAX_GRASPS as f64;
    let most = (1..steps).rev().filter(|steps| 360 % steps == 0).find(fits);
    let step = most.map_or_else(|| "a larger `step`".to_owned(), |steps| format!("`step: {} deg`", 360 / steps));
    Diagnostic::new(Code::E0541, title)
        .label(span, "under a load in the plane of this turn, grasps differ from angle to angle")
        .help(format!("use {step}, or leave the load and the part's `material` out"))
}

/// A tip that touches a section of a solid but penetrates the solid.
pub struct BuriedTip {
    pub plane: Plane,
    pub contact: u32,
    /// The contact to which it rolls from there; `None` where it is at its contact.
    pub beyond: Option<u32>,
    pub depth_um: f64,
    pub tolerance_um: f64,
    /// Whether it penetrates the section as well, whose corners are smoothed.
    pub is_smoothed: bool,
}

pub fn tip_in_solid(span: Span, name: &str, tip: &BuriedTip) -> Diagnostic {
    let (plane, contact) = (tip.plane.name(), tip.contact);
    let place = match tip.beyond {
        None => format!("a tip at contact {contact} in the plane {plane}"),
        Some(beyond) => format!("a tip that rolls from contact {contact} to {beyond} in the plane {plane}"),
    };
    let [depth, tolerance] = [tip.depth_um, tip.tolerance_um].map(length);
    let title = format!("{place} would penetrate `{name}` by {depth}; at most {tolerance} is allowed");
    let (label, help) = match tip.is_smoothed {
        true => (
            "its section has corners there, which are smoothed",
            "write the solid with more triangles, or give the device a larger `tolerance`",
        ),
        false => (
            "its surface leans over the section there",
            "turn or move the solid in its file until its surface is perpendicular to its planes xy and xz",
        ),
    };
    Diagnostic::new(Code::E0552, title).label(span, label).help(help)
}

pub fn solid_reaches_out(span: Span, name: &str, reach_um: f64, most_um: f64) -> Diagnostic {
    let title = format!(
        "`{name}` reaches {} from its origin, but tips travel around it where nothing may reach further than {}",
        length(reach_um),
        length(most_um)
    );
    Diagnostic::new(Code::E0552, title)
        .label(span, "beyond its sections")
        .help("round its corners, or use larger tips: they travel just far enough outside its sections for one to pass another")
}

/// A stage axis that does not reach around a part.
pub struct ShortStage {
    /// 0 to 2 for x to z.
    pub axis: usize,
    /// From the hand's origin, along each axis.
    pub needed_um: [f64; 3],
    pub range_um: [f64; 3],
}

pub fn part_out_of_range(span: Span, name: &str, stage: &ShortStage) -> Diagnostic {
    let ShortStage { axis, needed_um, range_um } = *stage;
    let title = format!(
        "tips around `{name}` must go to {} along {}, but the stages reach {}",
        length(needed_um[axis]),
        crate::device::fingers::AXES[axis],
        length(range_um[axis])
    );
    let enough: Vec<String> = needed_um
        .iter()
        .zip(range_um)
        .map(|(needed, range)| if *needed > range { length(round_up(*needed, 2)) } else { length(range) })
        .collect();
    Diagnostic::new(Code::E0550, title)
        .label(span, "out of range")
        .help(format!("stay nearer to the hand's origin, or use stages of `range: ({})`", enough.join(", ")))
}

pub fn two_parts(first: (&str, Span), second: (&str, Span)) -> Diagnostic {
    Diagnostic::new(Code::E0551, format!("a task turns one part, but this one names `{}` and `{}`", first.0, second.0))
        .label(second.1, format!("`{}` here", second.0))
        .label(first.1, format!("`{}` here", first.0))
        .help("write a task for each part, for two hands: one hand turns one part in a program")
}

pub fn which_part(span: Span, known: &[&str]) -> Diagnostic {
    let title = format!("this task names none of the {} parts of its scene", known.len());
    Diagnostic::new(Code::E0551, title)
        .label(span, "which one?")
        .help(format!("name it in a step, as `grasp {}`", known.first().copied().unwrap_or("bead")))
}

pub fn no_part(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0211, "the scene of this task has no part to turn")
        .label(span, "a task of a hand")
        .help("declare one: `scene cell { part bead : ellipsoid { axes: (16 um, 12 um, 12 um) } }` and `task … on hand in cell`")
}

/// An angle that is not a whole number of steps.
///
/// `step_deg` is a step of the device with which all turns of the task are whole steps, if one is known.
pub fn no_whole_steps(
    span: Span,
    asked_rad: f64,
    step_rad: f64,
    precision_rad: f64,
    step_deg: Option<f64>,
) -> Diagnostic {
    let below = (asked_rad / step_rad).floor();
    // One step of a task turns by a full turn at most.
    let within: Vec<f64> = [below, below + 1.0]
        .map(|steps| steps * step_rad)
        .into_iter()
        .filter(|end_rad| end_rad.abs() <= MOST_RAD)
        .collect();
    let off_deg = within.iter().map(|end_rad| (asked_rad - end_rad).abs()).fold(f64::INFINITY, f64::min).to_degrees();
    let ends = within.iter().map(|end_rad| angle(*end_rad)).collect::<Vec<_>>().join(" and ");
    let (nearest, once, these) = if within.len() == 2 {
        (format!("the nearest are {ends}"), "", "one of these angles")
    } else {
        (format!("the nearest up to 360 deg is {ends}"), " and at most 360 deg", "this angle")
    };
    let title =
        format!("a turn by {} is not a whole number of steps of {}; {nearest}", angle(asked_rad), angle(step_rad));
    Diagnostic::new(Code::E0543, title)
        .label(span, format!("no whole number of steps within {}{once}", angle(precision_rad)))
        .help(match step_deg {
            Some(step_deg) => format!(
                "write `step: {}` in the device, so that this task's turns are whole steps; or use {these}",
                step_text(step_deg)
            ),
            None => format!(
                "write {these}, or `precision: {} deg` among the settings to accept that error",
                digits(round_up(off_deg, 2))
            ),
        })
}

/// A step of a device as it can be written: as a fraction of a turn if it is not a whole number of degrees.
fn step_text(step_deg: f64) -> String {
    if (step_deg - step_deg.round()).abs() < 1e-9 {
        format!("{} deg", digits(step_deg.round()))
    } else {
        format!("360 deg / {}", digits((360.0 / step_deg).round()))
    }
}

pub fn turn_too_far(span: Span, asked_rad: f64) -> Diagnostic {
    Diagnostic::new(
        Code::E0544,
        format!("a turn by {} is too far: one step turns by at most 360 deg", angle(asked_rad)),
    )
    .label(span, "more than a full turn")
    .help("write several steps one below the other")
}

/// Goal that whole steps miss.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AskedTurn {
    Orientation,
    TurnAboutX,
}

/// Mends for a missed orientation.
pub struct OrientationMend {
    /// A step of the device, if one is known.
    pub step_deg: Option<f64>,
    /// A precision with which all orientations of the schedule are reached, as far as it is known.
    pub needed_rad: f64,
}

/// The precision that accepts a miss, rounded up as messages show it in degrees.
pub fn precision_for(off_rad: f64) -> f64 {
    round_up(off_rad.to_degrees(), 2).to_radians()
}

/// An orientation that whole steps do not reach.
pub fn orientation_missed(
    span: Span,
    asked: AskedTurn,
    off_rad: f64,
    precision_rad: f64,
    mend: &OrientationMend,
) -> Diagnostic {
    let (what, angles) = match asked {
        AskedTurn::Orientation => ("orientation", "angles that are whole steps"),
        AskedTurn::TurnAboutX => (
            "turn about x",
            "a `step` that divides 90 deg and the angle: the part is turned by 90 deg about z, and back after the turn about y",
        ),
    };
    let title = format!(
        "whole steps come no nearer to this {what} than {}, but the precision is {}",
        angle(off_rad),
        angle(precision_rad)
    );
    let precision = digits(round_up(mend.needed_rad.max(off_rad).to_degrees(), 2));
    let whole =
        if mend.needed_rad > precision_for(off_rad) { "that error and those of the others" } else { "that error" };
    Diagnostic::new(Code::E0545, title).label(span, "not reached").help(match mend.step_deg {
        Some(step_deg) => format!("write `step: {}` in the device to reach it", step_text(step_deg)),
        None => {
            format!("use {angles}; or write `precision: {precision} deg` among the settings to accept {whole}")
        }
    })
}

pub fn other_part(run: Span, device: &str, first: &str, now: &str) -> Diagnostic {
    let title = if first == now {
        format!("`{device}` has turned `{first}` so far, but the `{now}` of this scene has another shape")
    } else {
        format!("`{device}` has turned `{first}` so far, and cannot turn `{now}` in the same schedule")
    };
    Diagnostic::new(Code::E0528, title)
        .label(run, "not the part that was turned before")
        .help("a hand keeps its part between tasks: write a program, or another device, for each part")
}

pub fn flat_part(span: Span, name: &str, what: &str, declared: Span) -> Diagnostic {
    Diagnostic::new(Code::E0546, format!("`{name}` is flat and turns about z only, {what}"))
        .label(span, "out of its plane")
        .label(declared, "declared by its outline in the plane xy")
        .help("give it a solid shape, as `ellipsoid` or `sections { xy: …, xz: … }`, or turn it about z")
}

/// Two planes between which the part cannot be handed over.
pub fn no_junction(span: Span, name: &str, why: &str, declared: Span) -> Diagnostic {
    Diagnostic::new(Code::E0542, format!("`{name}` cannot be handed over from one plane to the other: {why}"))
        .label(span, "in another plane than the part is held in")
        .label(declared, "this part")
        .help("between two planes a finger holds each of the places where the x axis leaves the part: make its outlines in both \
               planes meet there, at right angles to the axis; or `release` it between them")
}

pub fn bad_grasp(span: Span, what: String, help: String) -> Diagnostic {
    Diagnostic::new(Code::E0547, what).label(span, "not a possible grasp").help(help)
}

pub fn tips_too_near(span: Span, one: u32, other: u32, distance_um: f64, least_um: f64) -> Diagnostic {
    let title = format!(
        "tips at contacts {one} and {other} are {} apart; at least {} is needed",
        length(distance_um),
        length(least_um)
    );
    Diagnostic::new(Code::E0547, title)
        .label(span, "too near to each other")
        .help("use contacts further apart: the least distance is twice `tip_radius` plus `clearance`")
}

pub fn nothing_held(span: Span, what: &str, released: Option<Span>) -> Diagnostic {
    let diagnostic = Diagnostic::new(Code::E0548, format!("`{what}` needs a part that fingers hold, but none does"))
        .label(span, "not held");
    match released {
        Some(released) => diagnostic.label(released, "released here"),
        None => diagnostic,
    }
    .help(format!("`grasp` or `rotate` it before, or leave `{what}` out"))
}

/// A part that would stick to the last finger.
pub fn sticks(span: Span, needed_un: f64, support_un: f64, pull_off_un: f64, safety: f64) -> Diagnostic {
    let title = format!(
        "the part would stick to the last finger: {} holds it down, but {} is needed",
        force(support_un),
        force(needed_un)
    );
    Diagnostic::new(Code::E0549, title).label(span, "released here").help(format!(
        "give the device `support: {}` (`pull_off` of {} times `removal_safety` of {}), or leave the part held",
        force(needed_un),
        force(pull_off_un),
        digits(safety)
    ))
}
