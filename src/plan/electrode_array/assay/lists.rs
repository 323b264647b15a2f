//! List scheduling: courses of the agents are planned in the order of a list.
//!
//! An agent's course goes on until its last errand, or until it waits for an agent that comes later in the list. The
//! first list begins with the agent whose errands take longest; others follow schedules that ignore conflicts. An agent
//! that finds no course moves to the front of the next list, with the agents that it meets. Once there is a plan, local
//! search changes its list: one agent moves to another place, or all agents of one droplet (every other time, of one
//! that is done last) move forward. The new list is kept if it is no worse. The agents of a first list also take turns
//! by time ([`TurnOrder`]), and the better plan counts. With many agents that is mostly the only plan. First lists are
//! tried without lanes and, except for lists with pauses and random ones, with lanes ([`super::lanes`]).

use super::bookings::NEVER;
use super::bound::AssayBounds;
use super::list_planner::{ListPlanner, ListTerms, MAX_EAGER};
use super::route::StopDistances;
use super::turn_queue::TurnOrder;
use super::{AgentCourse, AssayPlan, AssayProblem, ErrandPlace, bound};
use crate::plan::electrode_array::board::{BoardCosts, BoardObjective, BoardPlanProgress};
use crate::plan::search::Meter;
use crate::random::SplitMix64;
use std::ops::Range;

/// Most lists tried until there is a plan, and then without an improvement.
const LISTS: usize = 200;

/// First lists tried without pauses, that is, where no agent yields its turn before it has to wait.
const LISTS_WITHOUT_PAUSE: usize = 100;

/// Lists tried with pauses if an agent has several splits.
const PAUSED_LISTS: usize = 4;

/// Fewest rounds of local search, one from each first list or more; the best result counts. Each of them but the last
/// may spend 1/N of the remaining budget.
const MIN_ROUNDS: usize = 4;
const ROUND_SHARE: u64 = 2;

/// Most agents that take turns by time both without and with lanes.
const MAX_BOTH_WAYS: usize = 2_000;

/// Random seed of the changes.
const SEED: u64 = 1;

/// Reservation time of an unplanned agent's start, in instants per unit of separation; lists alternate between these.
const KEPT_SEPARATIONS: [u32; 3] = [6, 1, NEVER];

/// The best courses found.
pub(super) fn best(
    problem: &AssayProblem,
    ahead: &StopDistances,
    objective: BoardObjective,
    bounds: &AssayBounds,
    meter: &mut Meter,
) -> Option<Vec<AgentCourse>> {
    let mut planner = ListPlanner::new(problem, ahead, bounds, meter);
    let mut list: Vec<usize> = (0..problem.errands.len()).collect();
    let lengths = bound::lengths(problem, ahead);
    list.sort_by_key(|agent| std::cmp::Reverse(lengths[*agent]));
    let mut random = SplitMix64::new(SEED);
    let is_crowd = list.len() > MAX_EAGER;
    let early = if is_crowd { first_patient(&mut planner, &list) } else { Vec::new() };
    // With many agents, an eager list fails late.
    let tries = if early.is_empty() { LISTS } else { 1 };
    let eager = first_eager(&mut planner, list.clone(), 0..tries, false, &mut random);
    // A parent keeps far from its children's starts as long as these have no course; with pauses they get one sooner.
    let pausing = LISTS_WITHOUT_PAUSE..LISTS_WITHOUT_PAUSE + PAUSED_LISTS;
    let has_pauses = planner.has_several_splits();
    let paused = has_pauses.then(|| first_eager(&mut planner, list.clone(), pausing, false, &mut random)).flatten();
    let tries = KEPT_SEPARATIONS.len().min(tries);
    let by_lanes = first_eager(&mut planner, list.clone(), 0..tries, true, &mut SplitMix64::new(SEED));
    let key = |courses: &[AgentCourse]| AssayPlan::costs(courses).key(objective);
    let mut firsts: Vec<FirstList> = [eager, paused, by_lanes].into_iter().flatten().collect();
    let mut patient: Vec<Vec<AgentCourse>> = Vec::new();
    for schedule in problem.relaxed_schedules.iter().filter(|_| problem.releases.is_empty()) {
        let found = by_schedule(&mut planner, schedule);
        firsts.extend(found.0);
        patient.extend(found.1);
    }
    firsts.sort_by_key(|first| key(&first.courses));
    patient.extend(if is_crowd { early } else { first_patient(&mut planner, &list) });
    let best = Improvement { firsts, objective, least: bounds.costs }.best(&mut planner, &mut random);
    best.into_iter().chain(patient).min_by_key(|courses| key(courses))
}

/// The best courses found from a random first list.
pub(super) fn by_random_list(
    problem: &AssayProblem,
    ahead: &StopDistances,
    objective: BoardObjective,
    bounds: &AssayBounds,
    seed: u64,
    meter: &mut Meter,
) -> Option<Vec<AgentCourse>> {
    let mut planner = ListPlanner::new(problem, ahead, bounds, meter);
    let mut random = SplitMix64::new(seed);
    let mut list: Vec<usize> = (0..problem.errands.len()).collect();
    (1..list.len()).rev().for_each(|last| list.swap(last, below(&mut random, last + 1)));
    let first = first_eager(&mut planner, list, 0..2 * KEPT_SEPARATIONS.len(), false, &mut random)?;
    Improvement { firsts: vec![first], objective, least: bounds.costs }.best(&mut planner, &mut random)
}

/// A list that yields a plan.
struct FirstList {
    courses: Vec<AgentCourse>,
    list: Vec<usize>,
    terms: ListTerms,
}

/// Tries lists until one yields a plan; after a failure, the agents that blocked a course move to the front.
fn first_eager(
    planner: &mut ListPlanner,
    mut list: Vec<usize>,
    tries: Range<usize>,
    keeps_lanes: bool,
    random: &mut SplitMix64,
) -> Option<FirstList> {
    let problem = planner.problem;
    for nth in tries {
        if planner.meter.left().steps == 0 {
            break;
        }
        let terms = ListTerms {
            kept_separations: KEPT_SEPARATIONS[nth % KEPT_SEPARATIONS.len()],
            turns: TurnOrder::Eager,
            pauses: nth >= LISTS_WITHOUT_PAUSE,
            keeps_lanes,
        };
        match planner.courses(&list, terms) {
            Ok(courses) => return Some(FirstList { courses, list, terms }),
            Err(failed) => {
                let mut first = vec![failed];
                first.extend(problem.errands[failed].iter().filter_map(|errand| errand.meets));
                first.extend(problem.parents[failed]);
                first.dedup();
                // Repeating the same order would fail again.
                if nth % 2 == 1 {
                    list = moved(&list, random);
                }
                list.retain(|agent| !first.contains(agent));
                list.splice(0..0, first);
            }
        }
    }
    None
}

/// Lists in the order of a schedule that ignores conflicts, and courses in which no errand begins earlier than in that
/// schedule.
fn by_schedule(planner: &mut ListPlanner, schedule: &[Vec<u32>]) -> (Vec<FirstList>, Vec<Vec<AgentCourse>>) {
    let (problem, ahead, bounds) = (planner.problem, planner.ahead, planner.bounds);
    let mut released = AssayProblem { releases: problem.unheld(), ..problem.clone() };
    for (agent, own) in schedule.iter().enumerate() {
        for (errand, begin) in own.iter().enumerate() {
            if let Some((place, until)) = problem.held_back_by(ErrandPlace { agent, errand }, *begin) {
                let release = &mut released.releases[place.agent][place.errand];
                *release = until.max(*release);
            }
        }
    }
    let begin = |agent: &usize| {
        let first = usize::from(problem.enters[*agent]);
        schedule[*agent].get(first).copied().unwrap_or(0)
    };
    let mut list: Vec<usize> = (0..problem.errands.len()).collect();
    list.sort_by_key(begin);
    let mut fresh = ListPlanner::new(problem, ahead, bounds, planner.meter);
    let mut eager = |keeps_lanes| {
        let mut random = SplitMix64::new(SEED);
        first_eager(&mut fresh, list.clone(), 0..KEPT_SEPARATIONS.len(), keeps_lanes, &mut random)
    };
    let eager = [eager(false), eager(true)].into_iter().flatten().collect();
    let mut held = ListPlanner::new(&released, ahead, bounds, planner.meter);
    let patient = first_patient(&mut held, &list);
    (eager, patient)
}

/// Courses of a list whose agents take their turns by time, without and with lanes. The order of the list hardly
/// changes them.
fn first_patient(planner: &mut ListPlanner, list: &[usize]) -> Vec<Vec<AgentCourse>> {
    let mut first = |keeps_lanes| {
        KEPT_SEPARATIONS.into_iter().find_map(|kept_separations| {
            let terms = ListTerms { kept_separations, turns: TurnOrder::Patient, pauses: false, keeps_lanes };
            planner.courses(list, terms).ok()
        })
    };
    let is_short = list.len() <= MAX_BOTH_WAYS;
    [first(false), is_short.then(|| first(true)).flatten()].into_iter().flatten().collect()
}

/// Local search for better lists.
struct Improvement {
    /// The best one first.
    firsts: Vec<FirstList>,
    objective: BoardObjective,
    /// Lower bounds on every plan.
    least: BoardCosts,
}

impl Improvement {
    /// The best courses of several rounds, which start from the first lists in turn; `None` if there is no first list.
    fn best(self, planner: &mut ListPlanner, random: &mut SplitMix64) -> Option<Vec<AgentCourse>> {
        let mut best = self.firsts.first()?.courses.clone();
        let costs = AssayPlan::costs(&best);
        let mut progress = BoardPlanProgress::begin(self.objective, costs, self.least);
        let rounds = MIN_ROUNDS.max(self.firsts.len());
        for (nth, first) in self.firsts.iter().cycle().take(rounds).enumerate() {
            if self.is_least(&best) {
                break;
            }
            let left = planner.meter.left().steps;
            let kept = if nth + 1 == rounds { 0 } else { left - left / ROUND_SHARE };
            let found = self.round(planner, first, kept, random, &mut progress);
            if self.key(&found) < self.key(&best) {
                best = found;
            }
        }
        Some(best)
    }

    fn is_least(&self, courses: &[AgentCourse]) -> bool {
        AssayPlan::is_least(courses, self.objective, self.least)
    }

    fn key(&self, courses: &[AgentCourse]) -> (u64, u64) {
        AssayPlan::costs(courses).key(self.objective)
    }

    /// One round: changes the list until no change has improved it for a while, and returns its courses. Leaves `kept`
    /// steps of the budget.
    fn round(
        &self,
        planner: &mut ListPlanner,
        first: &FirstList,
        kept: u64,
        random: &mut SplitMix64,
        progress: &mut BoardPlanProgress,
    ) -> Vec<AgentCourse> {
        let (mut courses, mut list) = (first.courses.clone(), first.list.clone());
        let droplet_of = bound::droplet_of(planner.problem);
        let mut idle = 0;
        while !self.is_least(&courses) && idle < LISTS && list.len() > 1 && planner.meter.left().steps > kept {
            planner.limit = match self.objective {
                BoardObjective::Makespan => u32::try_from(AssayPlan::costs(&courses).makespan).unwrap_or(NEVER),
                BoardObjective::SumOfCosts => NEVER,
            };
            let other = match idle % 3 {
                0 => moved(&list, random),
                1 => advanced(&list, &droplet_of, &[below(random, droplet_of.len())], random),
                _ => advanced(&list, &droplet_of, &last_done(&courses), random),
            };
            idle += 1;
            let Ok(found) = planner.courses(&other, first.terms) else { continue };
            if self.key(&found) < self.key(&courses) {
                idle = 0;
                progress.offer(AssayPlan::costs(&found), self.least);
            }
            if self.key(&found) <= self.key(&courses) {
                (courses, list) = (found, other);
            }
        }
        courses
    }
}

/// The list with one random agent moved to a random place.
fn moved(list: &[usize], random: &mut SplitMix64) -> Vec<usize> {
    moved_to(list, below(random, list.len()), below(random, list.len()))
}

/// The list with the agent at index `from` moved to index `to`.
pub(super) fn moved_to(list: &[usize], from: usize, to: usize) -> Vec<usize> {
    let mut list = list.to_vec();
    if from < list.len() {
        let agent = list.remove(from);
        list.insert(to, agent);
    }
    list
}

/// The list with all agents of one droplet moved forward together. The droplet is that of a random agent among `some`.
fn advanced(list: &[usize], droplet_of: &[usize], some: &[usize], random: &mut SplitMix64) -> Vec<usize> {
    let Some(agent) = some.get(below(random, some.len())) else { return list.to_vec() };
    let droplet = droplet_of[*agent];
    let (own, mut others): (Vec<usize>, Vec<usize>) = list.iter().partition(|agent| droplet_of[**agent] == droplet);
    let first = list.iter().position(|agent| droplet_of[*agent] == droplet).unwrap_or(0);
    let to = below(random, first + 1);
    others.splice(to..to, own);
    others
}

/// The agents whose courses end last.
pub(super) fn last_done(courses: &[AgentCourse]) -> Vec<usize> {
    let length = |agent: &usize| courses[*agent].until();
    let longest = (0..courses.len()).map(|agent| length(&agent)).max();
    (0..courses.len()).filter(|agent| Some(length(agent)) == longest).collect()
}

/// A random number below `count`; 0 if `count` is 0.
pub(super) fn below(random: &mut SplitMix64, count: usize) -> usize {
    (random.next_u64() % count.max(1) as u64) as usize
}
