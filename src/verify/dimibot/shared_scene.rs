//! Robots that share a scene: their tips never touch, at any instant of the program.
//!
//! A tip is a disc whose radius is the tip radius plus the robot's repeatability. During a pulse it may be anywhere on
//! the segment that the pulse sweeps, or in the rectangle of a pulse of several modules, since modules snap at unknown
//! instants. Otherwise it is at its cell, also before the robot's first run and after its last. A pulse includes both
//! its ends, so that two pulses that meet in one instant are compared too. Cost for n pulses: n for each pair of
//! robots.

use super::super::boxes::Extent;
use super::super::clock::JudgedRun;
use super::super::evidence::{Clearance, GapUnit};
use super::super::geometry::convex::{apart_um, nearest_points, share_of_side, towards};
use super::super::rule::{Findings, Rule, Violation, ms};
use super::pulses;
use super::scene::{FrameTransform, contact_distance_um, place, swept};
use crate::claims::dimibot::DimibotOrder;
use crate::claims::{Claims, SharedScene};
use crate::device::dimibot::{DimibotFacts, LatticeCell};
use crate::quantity::digits;
use crate::source::Span;
use nalgebra::Point2;
use std::collections::{BTreeMap, BTreeSet};

/// Margin added to a tip when boxes are compared, so that rounding cannot hide a contact.
const BOX_MARGIN_UM: f64 = 1e-6;

/// Swept area of a tip from one instant to another, both included.
struct TipInterval {
    start_ns: u64,
    end_ns: u64,
    /// Corners of the area where the tip's centre may be, in scene coordinates.
    swept: Vec<Point2<f64>>,
    /// Start and end of its move, if it moves.
    way: Option<[Point2<f64>; 2]>,
    /// Index of the run, and of the schedule's step in which it moves.
    run: usize,
    step: Option<usize>,
}

/// The intervals of a robot's tip, from the first instant of a schedule to the last.
struct TipTrace<'a> {
    facts: &'a DimibotFacts,
    stretches: Vec<TipInterval>,
}

/// Checks the distance between every two robots that share a scene. `order` has the indices of the runs, those of one
/// device in the order in which it executes them.
pub(super) fn tips_apart(runs: &[JudgedRun], order: &[usize], claims: &Claims, findings: &mut Findings) {
    let frames = claims.shared.iter().flat_map(|scene| &scene.frames);
    let placed: BTreeMap<&str, FrameTransform> =
        frames.map(|(device, frame)| (&**device, FrameTransform::of(Some(frame)))).collect();
    let traces: BTreeMap<&str, TipTrace> = placed
        .into_iter()
        .filter_map(|(device, stand)| {
            let own: Vec<usize> = order.iter().copied().filter(|index| runs[*index].job.device == device).collect();
            Some((device, trace(runs, &own, &stand)?))
        })
        .collect();
    for [one, other] in pairs(&claims.shared) {
        let (Some(first), Some(second)) = (traces.get(one), traces.get(other)) else { continue };
        findings.count_checks(Rule::Encounter, first.stretches.len() + second.stretches.len());
        if let Some((stretch, beside, gap_um)) = first_touch(first, second) {
            findings.push(touch(runs, [one, other], [stretch, beside], gap_um, needed_um(first, second)));
            continue;
        }
        if let Some(nearest) = nearest([one, other], [first, second]) {
            findings.tally().near(nearest);
        }
    }
}

fn pairs(shared: &[SharedScene]) -> BTreeSet<[&str; 2]> {
    let mut pairs = BTreeSet::new();
    for scene in shared {
        let names: Vec<&str> = scene.frames.keys().map(String::as_str).collect();
        for (at, one) in names.iter().enumerate() {
            pairs.extend(names[at + 1..].iter().map(|other| [*one, *other]));
        }
    }
    pairs
}

/// Distance between two tips' centres at which they touch.
fn needed_um(one: &TipTrace, other: &TipTrace) -> f64 {
    contact_distance_um(one.facts) + contact_distance_um(other.facts)
}

fn trace<'a>(runs: &'a [JudgedRun], own: &[usize], stand: &FrameTransform) -> Option<TipTrace<'a>> {
    let first = &runs[*own.first()?];
    let order = DimibotOrder::of(&first.job.order)?;
    let facts = &order.facts;
    let mut cell = order.start.as_ref().map_or(facts.home, |start| start.value);
    let (mut at_ns, mut at_run, mut stretches) = (0, own[0], Vec::new());
    let at = |area: [LatticeCell; 2], times: [u64; 2], run, step| TipInterval {
        start_ns: times[0],
        end_ns: times[1],
        swept: swept(facts, stand, area),
        way: None,
        run,
        step,
    };
    let centre = |cell| stand.in_scene(place(facts, cell));
    for index in own {
        let Some(order) = DimibotOrder::of(&runs[*index].job.order) else { continue };
        for pulse in pulses(&runs[*index], order, cell) {
            stretches.push(at([cell, cell], [at_ns, pulse.start_ns.max(at_ns)], at_run, None));
            let end_ns = pulse.start_ns.saturating_add(facts.pulse_duration_ns);
            let moves = at(pulse.extremes(), [pulse.start_ns, end_ns], *index, Some(pulse.step));
            stretches.push(TipInterval { way: Some([pulse.before, pulse.after].map(centre)), ..moves });
            (cell, at_ns, at_run) = (pulse.after, end_ns, *index);
        }
    }
    stretches.push(at([cell, cell], [at_ns, u64::MAX], at_run, None));
    stretches.sort_by_key(|stretch| stretch.start_ns);
    Some(TipTrace { facts, stretches })
}

/// Two intervals that overlap in time, with the least distance between the tips' centres in them.
type NearTips<'a> = (&'a TipInterval, &'a TipInterval, f64);

/// The first two intervals in which two tips may touch.
fn first_touch<'a>(one: &'a TipTrace, other: &'a TipTrace) -> Option<NearTips<'a>> {
    let needed_um = needed_um(one, other);
    let mut touch = None;
    meet(one, other, needed_um, |near| {
        touch = Some(near).filter(|(_, _, distance_um)| *distance_um <= needed_um);
        touch.map_or(Some(needed_um), |_| None)
    });
    touch
}

/// The least clearance between two tips.
fn nearest(devices: [&str; 2], [one, other]: [&TipTrace; 2]) -> Option<Clearance> {
    let mut nearest: Option<NearTips> = None;
    meet(one, other, f64::INFINITY, |near| {
        nearest = nearest.filter(|(_, _, least_um)| *least_um <= near.2).or(Some(near));
        nearest.map(|(_, _, least_um)| least_um)
    });
    let (stretch, beside, distance_um) = nearest?;
    let [a, b] = nearest_points(&stretch.swept, &beside.swept)?;
    let (first, second) = (one.facts, other.facts);
    let points = [towards(a, b, first.tip_radius_um), towards(b, a, second.tip_radius_um)];
    let moves = [(stretch, a, first), (beside, b, second)].into_iter();
    let on_way = moves.filter_map(|(tip, at, facts)| {
        let after_ns = facts.pulse_duration_ns as f64 * share_of_side(tip.way?, at);
        Some(tip.start_ns.saturating_add(after_ns.round() as u64))
    });
    let common = [stretch.start_ns.max(beside.start_ns), stretch.end_ns.min(beside.end_ns)];
    let within = on_way.clone().find(|t_ns| (common[0]..=common[1]).contains(t_ns));
    Some(Clearance {
        rule: Rule::Encounter,
        device: devices[0].to_owned(),
        between: devices.map(str::to_owned),
        apart: distance_um - first.tip_radius_um - second.tip_radius_um,
        needed: first.repeatability_um + second.repeatability_um,
        error_bound: 0.0,
        unit: GapUnit::Micrometres,
        t_ns: within.or(on_way.clone().next()).unwrap_or(common[0]).clamp(common[0], common[1]),
        points: points.map(|point| [point.x, point.y, 0.0]),
    })
}

/// Visits the pairs of intervals that overlap in time and in which the centres of two tips may be within a distance.
/// The visitor returns the distance for the rest of the search, which may be less, or `None` to end it.
fn meet<'a>(
    one: &'a TipTrace,
    other: &'a TipTrace,
    mut within_um: f64,
    mut visit: impl FnMut(NearTips<'a>) -> Option<f64>,
) {
    let mut from = 0;
    for stretch in &one.stretches {
        // Intervals are in order of time, so one that ended before this one began is also over for all later ones.
        while other.stretches.get(from).is_some_and(|beside| beside.end_ns < stretch.start_ns) {
            from += 1;
        }
        for beside in other.stretches[from..].iter().take_while(|beside| beside.start_ns <= stretch.end_ns) {
            let near = Extent::of(&stretch.swept).widened(within_um + BOX_MARGIN_UM).meets(&Extent::of(&beside.swept));
            if !near || beside.end_ns < stretch.start_ns {
                continue;
            }
            let Some(less_um) = visit((stretch, beside, apart_um(&stretch.swept, &beside.swept))) else { return };
            within_um = less_um;
        }
    }
}

fn touch(
    runs: &[JudgedRun],
    devices: [&str; 2],
    stretches: [&TipInterval; 2],
    distance_um: f64,
    needed_um: f64,
) -> Violation {
    let [one, other] = devices;
    let time_ns = stretches[0].start_ns.max(stretches[1].start_ns);
    let title = format!(
        "the tips of `{one}` and `{other}` may come within {} um of each other at {}; more than {} um is needed",
        digits(distance_um),
        ms(time_ns),
        digits(needed_um)
    );
    let mut violation = Violation::new(Rule::Encounter, time_ns, title);
    if let Some(step) = stretches.iter().find_map(|stretch| stretch.step) {
        violation = violation.step(step);
    }
    for (device, stretch) in devices.into_iter().zip(stretches) {
        let what = if stretch.step.is_some() { "moves" } else { "stands" };
        violation = violation.label(span(&runs[stretch.run], stretch.step), format!("`{device}` {what} there"));
    }
    violation
}

/// The step in which a robot moves, or the run before or after which it stands.
fn span(run: &JudgedRun, step: Option<usize>) -> Span {
    let steps = DimibotOrder::of(&run.job.order).map(|order| order.steps.as_slice()).unwrap_or_default();
    let nth = step.and_then(|step| run.steps.iter().position(|index| *index == step));
    nth.and_then(|nth| steps.get(nth)).map_or(run.job.run_span, |step| step.span)
}
