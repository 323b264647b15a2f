//! The operations of an assay on the clock, from the courses of its parts.

use crate::claims::electrode_array::{AssayOperation, ElectrodeArrayOrder};
use crate::device::electrode_array::ElectrodeCell;
use crate::lower::clock::LoweredOperation;

/// The operations of the step with an index and a start, each as early as the courses have it.
pub fn timed(
    order: &ElectrodeArrayOrder,
    (step, step_start_ns): (usize, u64),
    operations: &[AssayOperation],
    (courses, since): (&[&[ElectrodeCell]], &[usize]),
) -> Vec<LoweredOperation> {
    // The instant at which each part is free for its next operation, at first that at which it is there.
    let mut free = since.to_vec();
    let mut lowered = Vec::new();
    for operation in operations {
        let parts: Vec<usize> = operation.parts().filter(|part| !courses[*part].is_empty()).collect();
        let stay = operation.stay_ns.div_ceil(order.facts.step_ns) as usize;
        let begins = parts.iter().map(|part| free[*part]).min().unwrap_or(0);
        let Some(arrival) = arrival(operation, stay, &free, courses) else { continue };
        parts.iter().for_each(|part| free[*part] = arrival + stay);
        let at_ns = |instant: usize| step_start_ns + instant as u64 * order.facts.step_ns;
        lowered.push(LoweredOperation {
            step,
            span: operation.span,
            parts: parts.iter().map(|part| order.parts[*part].name.clone()).collect(),
            start_ns: at_ns(begins),
            arrival_ns: at_ns(arrival),
            end_ns: at_ns(arrival + stay),
        });
    }
    lowered
}

/// The first instant from which on all parts of an operation stay at its last stop, after they have come by the others.
fn arrival(operation: &AssayOperation, stay: usize, free: &[usize], courses: &[&[ElectrodeCell]]) -> Option<usize> {
    let longest = courses.iter().map(|course| course.len()).max()?;
    let at = |part: usize, instant: usize| courses[part].get(instant).or(courses[part].last()).copied();
    let mut from = 0;
    let mut goal = None;
    for part in operation.parts() {
        let mut instant = free[part];
        goal = at(part, instant);
        for stop in &operation.stops {
            instant = (instant..longest).find(|instant| at(part, *instant) == Some(stop.cell))?;
            goal = Some(stop.cell);
        }
        from = from.max(instant);
    }
    let mut since = from;
    for instant in from..longest + stay {
        if operation.parts().any(|part| at(part, instant) != goal) {
            since = instant + 1;
        } else if instant - since == stay {
            return Some(since);
        }
    }
    None
}
