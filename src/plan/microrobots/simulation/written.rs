//! A stage of a plan carried out as written: leg by leg, without measurements.
//!
//! Input: a trial without errors. Output: its robots docked at the ends of the legs, or their collision, or the distance by which they
//! missed their goals. The checks are the same as in the closed loop: the true bodies, and their final places.

use super::trial::{ContactManners, FailureReason, Met, Trial, TrialFailure};
use crate::device::microrobots::wrapped_rad;
use crate::geometry::Pose;
use crate::plan::microrobots::AssemblyStage;
use crate::plan::microrobots::strategy::Episode;
use crate::real::Real;

/// Carries out the legs of a stage.
pub fn run(trial: &mut Trial, episode: &Episode) -> Result<(), TrialFailure> {
    let goals = match *episode.stage {
        AssemblyStage::Pair { first, second, goals, .. } => vec![(first, goals[0]), (second, goals[1])],
        AssemblyStage::Single { robot, goal, .. } => vec![(robot, goal)],
        AssemblyStage::Departure { .. } => return depart(trial, episode),
        AssemblyStage::Escort { .. } => return Ok(()),
    };
    let Some(&(robot, _)) = goals.first() else { return Ok(()) };
    trial.begin(goals.iter().map(|(robot, _)| *robot).collect());
    let (facts, fine) = (trial.order.robot(robot), trial.order.facts.fine);
    let way_um = |strokes: u64| facts.step_um * strokes as f64;
    let mut left_um: f64 = episode.legs.iter().map(|leg| way_um(leg.strokes)).sum();
    for leg in episode.legs {
        // The last stretch is long enough for any robot that comes near its partner in it.
        let apart_um = (left_um - fine.length_um - fine.cycle_um).clamp(0.0, way_um(leg.strokes));
        trial.drive(leg.state, robot, apart_um, ContactManners::Apart)?;
        trial.drive(leg.state, robot, way_um(leg.strokes) - apart_um, ContactManners::Docking)?;
        left_um -= way_um(leg.strokes);
    }
    goals.into_iter().try_for_each(|(robot, goal)| dock(trial, robot, goal))
}

/// Carries out the legs by which the whole bed departs, with errors that change from interval to interval.
pub fn depart(trial: &mut Trial, episode: &Episode) -> Result<(), TrialFailure> {
    let moving: Vec<usize> = (0..trial.poses.len()).filter(|robot| !trial.docked[*robot]).collect();
    let Some(&robot) = moving.first() else { return Ok(()) };
    trial.begin(moving);
    let facts = &trial.order.facts;
    let (step_um, interval) =
        (trial.order.robot(robot).step_um, (trial.errors.replan_ns / facts.period_ns.max(1)).max(1));
    for leg in episode.legs {
        let mut left = leg.strokes;
        while left > 0 {
            let strokes = left.min(interval);
            trial.drive(leg.state, robot, step_um * strokes as f64, ContactManners::Apart)?;
            if !trial.errors.are_zero() {
                trial.tick();
            }
            left -= strokes;
        }
    }
    Ok(())
}

/// The final place of a robot, in the frame of its goal.
fn dock(trial: &mut Trial, robot: usize, goal: Pose) -> Result<(), TrialFailure> {
    let (pose, docking) = (trial.poses[robot], trial.order.facts.docking);
    let (dx_um, dy_um) = (pose.x_um - goal.x_um, pose.y_um - goal.y_um);
    let (sin, cos) = goal.heading_rad.sine_cosine();
    let (along_um, across_um) = (dx_um * cos + dy_um * sin, dy_um * cos - dx_um * sin);
    let off_rad = wrapped_rad(pose.heading_rad - goal.heading_rad);
    trial.met.push(Met { robot, across_um, along_um, incidence_rad: off_rad, heading_rad: off_rad });
    if off_rad.abs() > docking.sticking_rad {
        return Err((robot, FailureReason::Angle));
    }
    let precision_um = trial.order.precision.place_um;
    if along_um.hypotenuse(across_um) > precision_um.max(docking.tolerance_um) {
        return Err((robot, FailureReason::Misplaced));
    }
    trial.docked[robot] = true;
    Ok(())
}
