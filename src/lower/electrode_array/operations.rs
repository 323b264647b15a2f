//! Times of the operations of an assay, derived from the courses of its parts.

use crate::claims::electrode_array::{AssayOperation, ElectrodeArrayOrder};
use crate::device::electrode_array::ElectrodeArrayFacts;
use crate::lower::clock::LoweredOperation;
use crate::plan::electrode_array::PartCourse;

/// The operations of a step, given by its index and start, each as early as the courses allow: with the texts as
/// asked, at the places that the plan has chosen.
pub fn timed(
    order: &ElectrodeArrayOrder,
    step: usize,
    step_start_ns: u64,
    asked: &[AssayOperation],
    placed: &[AssayOperation],
    courses: &[PartCourse],
) -> Vec<LoweredOperation> {
    let facts = &order.facts;
    // The instant at which each part is free for its next operation; at first, the one at which it appears.
    let mut free: Vec<usize> = courses.iter().map(|course| course.since).collect();
    let mut lowered = Vec::new();
    let longest = courses.iter().map(PartCourse::until).max().unwrap_or(0);
    // The instant at which each operation so far ends.
    let mut ends: Vec<usize> = Vec::with_capacity(placed.len());
    for (asked, operation) in asked.iter().zip(placed) {
        let parts: Vec<usize> = operation.all_parts().filter(|part| !courses[*part].cells.is_empty()).collect();
        let begins = operation.parts().filter(|part| parts.contains(part)).map(|part| free[part]).min().unwrap_or(0);
        let times = match operation.splits.map(|half| courses[half.part].since) {
            Some(end) => pulled_apart(&courses[operation.part], begins, end).map(|arrival| (arrival, end)),
            None => {
                let stay = operation.stay_steps(facts) as usize;
                let begins = operation.after.iter().filter_map(|earlier| ends.get(*earlier)).max();
                arrival(operation, facts, &free, begins.copied().unwrap_or(0), courses, longest)
                    .map(|arrival| (arrival, arrival + stay))
            }
        };
        ends.push(times.map_or(0, |(_, end)| end));
        let Some((arrival, end)) = times else { continue };
        parts.iter().for_each(|part| free[*part] = end);
        let at_ns = |instant: usize| step_start_ns + instant as u64 * facts.step_ns;
        lowered.push(LoweredOperation {
            step,
            span: operation.span,
            parts: parts.iter().map(|part| order.parts[*part].name.clone()).collect(),
            at: operation.stops.last().filter(|_| !asked.among.is_empty()).map(|stop| stop.cell.pair()),
            start_ns: at_ns(begins),
            arrival_ns: at_ns(arrival),
            end_ns: at_ns(end),
        });
    }
    lowered
}

/// The first instant, not before `from`, since which a part has stayed where it is split; the split ends at `end`.
fn pulled_apart(course: &PartCourse, from: usize, end: usize) -> Option<usize> {
    let last = end.checked_sub(1)?;
    (from..=last).rev().take_while(|instant| course.at(*instant) == course.at(last)).last()
}

/// The first instant, not before `begins`, from which all parts of an operation stay at its last stop, or are mixed
/// from there, after they have passed the other stops. `longest` is the instant after the last one of all courses.
fn arrival(
    operation: &AssayOperation,
    facts: &ElectrodeArrayFacts,
    free: &[usize],
    begins: usize,
    courses: &[PartCourse],
    longest: usize,
) -> Option<usize> {
    let stay = operation.stay_steps(facts) as usize;
    let mut from = begins;
    let mut goal = None;
    for part in operation.parts() {
        let mut instant = free[part];
        goal = courses[part].at(instant);
        for stop in &operation.stops {
            instant = (instant..longest).find(|instant| courses[part].at(*instant) == Some(stop.cell))?;
            goal = Some(stop.cell);
        }
        from = from.max(instant);
    }
    if operation.mixes {
        let (course, around) = (&courses[operation.part], facts.mixing_loop(goal?));
        let is_mixed = |since: &usize| {
            let instants = 0..=stay;
            let mut steps = instants.map(|step| (course.at(since + step), Some(around[step % around.len()])));
            steps.all(|(is, due)| is == due)
        };
        return (from..longest).find(is_mixed);
    }
    let mut since = from;
    for instant in from..longest + stay {
        if operation.parts().any(|part| courses[part].at(instant) != goal) {
            since = instant + 1;
        } else if instant - since == stay {
            return Some(since);
        }
    }
    None
}
