//! Finger symmetry: fingers are interchangeable except those that a task names, so a request with fewer unnamed fingers
//! has paths of the same cost.
//!
//! At most three fingers hold at the same time, and a finger is placed only while two hold. So three fingers represent
//! all that neither the start nor a required grasp names: whenever one is placed, one of the three is free.

use super::{Grasp, GraspAnswer, GraspPath, GraspRequest, Start};
use crate::device::fingers::{MAX_FINGERS, MAX_HOLDING};

/// The answer to a request, searched with the fewest fingers that suffice.
pub fn with_fewest_fingers(request: &GraspRequest, solve: impl Fn(&GraspRequest) -> GraspAnswer) -> GraspAnswer {
    let kept = representative_fingers(request);
    if kept.len() == request.fingers {
        return solve(request);
    }
    let reduced = |grasp: Grasp| moved(grasp, |to| kept.get(to).copied());
    let mut fewer = request.clone();
    fewer.fingers = kept.len();
    if let Start::At(grasp) = request.start {
        fewer.start = Start::At(reduced(grasp));
    }
    for leg in fewer.routes.iter_mut().flatten() {
        leg.end = leg.end.map(reduced);
    }
    match solve(&fewer) {
        GraspAnswer::Found(way) => GraspAnswer::Found(restored(way, &kept)),
        other @ (GraspAnswer::Impossible(_) | GraspAnswer::GaveUp(_)) => other,
    }
}

/// The named fingers, and up to three more.
fn representative_fingers(request: &GraspRequest) -> Vec<usize> {
    let start = match request.start {
        Start::At(grasp) => Some(grasp),
        Start::Any => None,
    };
    let pins = request.routes.iter().flatten().filter_map(|leg| leg.end);
    let named: Vec<Grasp> = start.into_iter().chain(pins).collect();
    // A finger that the device does not have stays named, so that its grasp turns out not to hold.
    let is_named = |finger: &usize| named.iter().any(|grasp| grasp.contact(*finger).is_some());
    let others = (0..request.fingers).filter(|finger| !is_named(finger)).take(MAX_HOLDING);
    let all = 0..MAX_FINGERS as usize;
    let mut kept: Vec<usize> = all.filter(is_named).chain(others).collect();
    kept.sort_unstable();
    if kept.iter().any(|finger| *finger >= request.fingers) { (0..request.fingers).collect() } else { kept }
}

/// A grasp with its fingers renumbered; `from` gives the old number of each.
fn moved(grasp: Grasp, from: impl Fn(usize) -> Option<usize>) -> Grasp {
    let mut other = Grasp([0; MAX_FINGERS as usize]);
    for (to, contact) in other.0.iter_mut().enumerate() {
        *contact = from(to).map_or(0, |from| grasp.0[from]);
    }
    other
}

fn restored(mut way: GraspPath, kept: &[usize]) -> GraspPath {
    for node in way.legs.iter_mut().flatten() {
        node.grasp = moved(node.grasp, |to| kept.iter().position(|finger| *finger == to));
    }
    way
}
