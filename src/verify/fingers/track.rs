//! Positions of the tips of a hand at every instant of a run.
//!
//! Input: a run whose actuations `form` and `clock` found sound. Output: [`Tracks`], which give the straight motion of
//! all tips stretch by stretch; a new stretch begins when any axis takes a new line. Promise: every axis has exactly
//! one value throughout the run, continues from its last position, and stays in its range.

use super::super::clock::JudgedRun;
use super::super::rule::{Rule, Violation, ms};
use super::Point;
use crate::claims::fingers::FingersOrder;
use crate::device::fingers::{AXES, channel, finger_axis};
use crate::quantity::digits;
use crate::schedule::Actuation;
use std::collections::BTreeMap;

/// Greatest jump of a position that counts as rounding.
const JUMP_UM: f64 = 1e-6;

/// The lines of one axis of one finger, in order of time and without a gap.
type FingerAxis<'a> = Vec<&'a Actuation>;

/// All axes of a run, finger by finger.
#[derive(Debug)]
pub(super) struct Tracks<'a> {
    axes: Vec<FingerAxis<'a>>,
    /// The instants at which any axis takes a new line, and the end of the run.
    instants_ns: Vec<u64>,
    /// Position of each axis in a run of no duration.
    still_um: Vec<f64>,
}

/// An interval in which all tips move on straight lines.
#[derive(Debug, Clone)]
pub(super) struct Stretch {
    pub start_ns: u64,
    pub end_ns: u64,
    pub from_um: Vec<Point>,
    pub to_um: Vec<Point>,
}

impl Stretch {
    /// Whether a tip does not move.
    pub fn rests(&self, finger: usize) -> bool {
        self.from_um[finger] == self.to_um[finger]
    }

    /// Position of a tip at a fraction of the stretch, 0 to 1.
    pub fn tip_um(&self, finger: usize, share: f64) -> Point {
        self.from_um[finger] + (self.to_um[finger] - self.from_um[finger]) * share
    }

    /// The instant at a fraction of the stretch, 0 to 1.
    pub fn instant_ns(&self, share: f64) -> u64 {
        self.start_ns + ((self.end_ns - self.start_ns) as f64 * share) as u64
    }
}

impl<'a> Tracks<'a> {
    /// Assembles the axes from the actuations of a run.
    ///
    /// # Errors
    /// At the first axis that has no value, jumps or leaves its range.
    pub fn of(run: &JudgedRun<'a>, order: &FingersOrder) -> Result<Self, Violation> {
        let mut axes: Vec<FingerAxis> = vec![Vec::new(); order.facts.fingers as usize * AXES.len()];
        let places = places(run, axes.len());
        for actuation in &run.actuations {
            if let Some(axis) = places.get(&actuation.channel) {
                axes[*axis].push(actuation);
            }
        }
        let before_um = before_um(run, &places, axes.len());
        run.tally.count_checks(Rule::Axis, run.actuations.len() + axes.len());
        run.tally.count_checks(Rule::Range, run.actuations.len());
        for (at, axis) in axes.iter().enumerate() {
            unbroken(run, at, axis, before_um[at])?;
            axis.iter().try_for_each(|line| in_range(run, order, at, line))?;
        }
        let starts = axes.iter().flatten().map(|line| line.start_ns);
        let mut instants_ns: Vec<u64> = starts.chain([run.plan.start_ns, run.end_ns()]).collect();
        instants_ns.sort_unstable();
        instants_ns.dedup();
        let still_um = before_um.into_iter().map(Option::unwrap_or_default).collect();
        Ok(Tracks { axes, instants_ns, still_um })
    }

    /// Number of stretches in the run.
    pub fn len(&self) -> usize {
        self.instants_ns.len() - 1
    }

    /// The instant at which a stretch starts; after the last one, the run's end.
    pub fn start_ns(&self, index: usize) -> u64 {
        self.instants_ns[index]
    }

    /// One stretch of the run.
    pub fn stretch(&self, index: usize) -> Stretch {
        let (start_ns, end_ns) = (self.instants_ns[index], self.instants_ns[index + 1]);
        let ends = |axis: &FingerAxis| {
            let after = axis.partition_point(|line| line.start_ns <= start_ns);
            let line = axis[after - 1];
            [value_um(line, start_ns), value_um(line, end_ns)]
        };
        let ends: Vec<[f64; 2]> = self.axes.iter().map(ends).collect();
        let points =
            |end: usize| ends.chunks(AXES.len()).map(move |xyz| Point::new(xyz[0][end], xyz[1][end], xyz[2][end]));
        Stretch { start_ns, end_ns, from_um: points(0).collect(), to_um: points(1).collect() }
    }

    /// Positions of the tips at the start of the run.
    pub fn start_um(&self) -> Vec<Point> {
        match self.len() {
            0 => self.still_um.chunks(AXES.len()).map(|xyz| Point::new(xyz[0], xyz[1], xyz[2])).collect(),
            _ => self.stretch(0).from_um,
        }
    }
}

/// The axis of each channel of the run's device.
fn places(run: &JudgedRun, axes: usize) -> BTreeMap<u32, usize> {
    let place = |(index, channel): (usize, &crate::schedule::Channel)| {
        let name = channel.name.strip_prefix(&run.job.device)?.strip_prefix('.')?;
        let (finger, axis) = finger_axis(name)?;
        let at = finger.checked_mul(AXES.len())?.checked_add(axis)?;
        (at < axes).then_some((u32::try_from(index).ok()?, at))
    };
    run.schedule.channels.iter().enumerate().filter_map(place).collect()
}

/// Last position of each axis in the earlier runs; `None` if it has none.
fn before_um(run: &JudgedRun, places: &BTreeMap<u32, usize>, axes: usize) -> Vec<Option<f64>> {
    let mut last: Vec<Option<(u64, f64)>> = vec![None; axes];
    for line in run.schedule.actuations.iter().filter(|line| line.end_ns() <= run.plan.start_ns) {
        let Some(at) = places.get(&line.channel) else { continue };
        if last[*at].is_none_or(|(end_ns, _)| end_ns <= line.end_ns()) {
            last[*at] = Some((line.end_ns(), line.to));
        }
    }
    last.into_iter().map(|last| last.map(|(_, to_um)| to_um)).collect()
}

fn name(run: &JudgedRun, at: usize) -> String {
    format!("{}.{}", run.job.device, channel(at / AXES.len(), at % AXES.len()))
}

fn unbroken(run: &JudgedRun, at: usize, axis: &FingerAxis, before_um: Option<f64>) -> Result<(), Violation> {
    let (mut due_ns, mut due_um) = (run.plan.start_ns, before_um);
    let gap = |due_ns: u64, until_ns: u64| {
        let title = format!("`{}` has no value from {} to {}", name(run, at), ms(due_ns), ms(until_ns));
        Violation::new(Rule::Axis, due_ns, title).label(run.job.run_span, "in this run")
    };
    for line in axis {
        if line.start_ns != due_ns {
            return Err(gap(due_ns, line.start_ns).step(line.step as usize));
        }
        if let Some(due_um) = due_um.filter(|due_um| (due_um - line.from).abs() > JUMP_UM) {
            let (name, when) = (name(run, at), ms(line.start_ns));
            let title = format!("`{name}` jumps from {due_um} um to {} um at {when}", line.from);
            return Err(Violation::new(Rule::Axis, line.start_ns, title).step(line.step as usize));
        }
        (due_ns, due_um) = (line.end_ns(), Some(line.to));
    }
    if due_ns == run.end_ns() { Ok(()) } else { Err(gap(due_ns, run.end_ns())) }
}

fn in_range(run: &JudgedRun, order: &FingersOrder, at: usize, line: &Actuation) -> Result<(), Violation> {
    let range_um = order.facts.range_um[at % AXES.len()];
    let Some(out_um) = [line.from, line.to].into_iter().find(|value_um| value_um.abs() > range_um + JUMP_UM) else {
        return Ok(());
    };
    let (name, when, range) = (name(run, at), ms(line.start_ns), digits(range_um));
    let title = format!("`{name}` goes to {out_um} um in the motion from {when} on, but its stage reaches {range} um");
    Err(Violation::new(Rule::Range, line.start_ns, title).step(line.step as usize))
}

/// Position of an axis at an instant. Exact at both ends, so that a line that rests has one value throughout.
fn value_um(line: &Actuation, time_ns: u64) -> f64 {
    if time_ns >= line.end_ns() {
        return line.to;
    }
    let share = (time_ns - line.start_ns) as f64 / line.duration_ns as f64;
    line.from + (line.to - line.from) * share
}
