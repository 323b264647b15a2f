//! Conversion of a path through the grasp graph to the acts of the fingers in each step of the task.

use super::graph::{GraspNode, GraspPath};
use super::routes::{LegEnd, TurnRoute};
use super::tip_motion::FingerAct;

/// Appends the finger acts of a stretch's path to the acts of the task's steps.
///
/// `begins` is the step in which the fingers first take the part; `None` if they already hold it.
pub fn follow(steps: &mut [Vec<FingerAct>], route: &TurnRoute, way: &GraspPath, begins: Option<usize>, fingers: usize) {
    for (leg, (turning, nodes)) in route.iter().zip(&way.legs).enumerate() {
        if let (0, Some(step), Some(first)) = (leg, begins, nodes.first()) {
            steps[step].push(FingerAct::Begin { plane: turning.turn.plane, grasp: first.grasp.list(fingers) });
        }
        let acts = &mut steps[turning.step];
        if turning.end != LegEnd::Released {
            acts.push(FingerAct::Turn(turning.turn.plane));
        }
        nodes.windows(2).for_each(|pair| acts.extend(act(&pair[0], &pair[1], fingers)));
    }
}

/// The act on the edge from a node to its neighbour.
fn act(from: &GraspNode, to: &GraspNode, fingers: usize) -> Option<FingerAct> {
    if from.angle != to.angle {
        return Some(FingerAct::Roll(to.angle - from.angle));
    }
    let changed = (0..fingers).find(|finger| from.grasp.contact(*finger) != to.grasp.contact(*finger))?;
    Some(match to.grasp.contact(changed) {
        Some(contact) => FingerAct::Place { finger: changed, contact: contact as u32 + 1 },
        None => FingerAct::Leave { finger: changed },
    })
}

/// Number of finger placements and removals on a path.
pub fn reconfigurations(way: &GraspPath) -> u64 {
    let changes =
        |nodes: &Vec<GraspNode>| nodes.windows(2).filter(|pair| pair[0].angle == pair[1].angle).count() as u64;
    way.legs.iter().map(changes).sum()
}
