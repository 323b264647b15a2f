//! Checks courses that ignore shared channels against their rule.

use super::{AgentCourse, AssayProblem};
use crate::plan::electrode_array::channels::broadcast::{AgentStep, PulledStep};

/// Whether the courses of an assay keep the rule until the last errand is done.
pub fn are_kept_by_courses(problem: &AssayProblem, courses: &[AgentCourse]) -> bool {
    let Some(channels) = problem.instance.board.channels() else { return true };
    let end = courses.iter().map(AgentCourse::until).max().unwrap_or(1).saturating_sub(1);
    (0..end).all(|instant| {
        let step = |agent: usize| step_of(problem, courses, agent, instant);
        channels.go_together(&(0..courses.len()).filter_map(step).collect::<Vec<_>>())
    })
}

/// The step of an agent from an instant on, with the cell to which its other half is pulled if it splits; `None` if it
/// is not on the board.
fn step_of(problem: &AssayProblem, courses: &[AgentCourse], agent: usize, instant: u32) -> Option<PulledStep> {
    let course = &courses[agent];
    let to = course.at(instant + 1)?;
    if problem.is_gone[agent] && instant + 1 >= course.until() {
        return None;
    }
    if let Some(parent) = problem.parents[agent].filter(|_| course.since == instant + 1) {
        let step = AgentStep { from: courses[parent].at(instant)?, to };
        return Some(PulledStep { step, split_electrode: courses[parent].at(instant + 1) });
    }
    if instant < course.since {
        return None;
    }
    let comes_now = |child: usize| problem.parents[child] == Some(agent) && courses[child].since == instant + 1;
    let half = (0..courses.len()).find(|child| comes_now(*child)).and_then(|child| courses[child].at(instant + 1));
    Some(PulledStep { step: AgentStep { from: course.at(instant)?, to }, split_electrode: half })
}
