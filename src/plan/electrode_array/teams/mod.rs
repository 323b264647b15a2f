//! Plans of a stage in which some goals are interchangeable: teams of agents, each with as many goals as agents.
//!
//! Problem: target assignment and path finding (H. Ma, S. Koenig, "Optimal target assignment and path finding for teams
//! of agents", AAMAS 2016), with separation. Method: goals are assigned by the distances of the agents alone
//! (`assignment`), and the stage with these goals is planned as any other (`portfolio`). Where its plan does not meet
//! the bound, all other assignments follow in the order of their bounds, if there are at most `MOST_ASSIGNMENTS`;
//! otherwise some in which an agent that arrives late has exchanged its goal with another.
//!
//! Guaranteed: plans are legal. The bound on the steps is that of the bottleneck assignment, and the bound on the sum
//! of costs that of the assignment with the least sum, so both hold for every assignment. Where all assignments with a
//! lower bound were searched, the bound is the least that was proven for any of them. "No plan" is proven for every
//! assignment. The same input and budget give the same plan. Cost: one step of the budget is one of `portfolio`.

pub mod assigned;
mod assignment;
pub mod loose;
pub mod shared;

use super::board::{
    Agent, BoardAnswer, BoardCosts, BoardObjective, BoardPlan, CellIndex, Instance, NoBoardPlan, Paths,
};
use super::{fast, portfolio};
use crate::plan::search::{Meter, SearchAnswer, SearchBudget};
use assignment::PairCosts;

/// Most assignments that are all searched: those of a team of six.
const MOST_ASSIGNMENTS: usize = 720;

/// If there are more: most assignments tried until one has a plan.
const MOST_TRIES: usize = 8;

/// Most exchanges of two goals tried for a better plan, and 1/N of the remaining budget for each.
const MOST_EXCHANGES: usize = 32;
const EXCHANGE_SHARE: u64 = 16;

/// 1/N of the budget for the first assignment.
const FIRST_SHARE: u64 = 2;

/// Why a stage with teams has no plan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NoTeamPlan {
    /// `goals` goals of a team, among them `goal`, lie where only `agents` of its agents can get.
    Cut { team: usize, goal: CellIndex, goals: usize, agents: usize },
    /// An agent that belongs to no team cannot reach a stop.
    Alone(NoBoardPlan),
    /// Whichever goals the agents take, they cannot pass one another.
    Blocked,
}

/// Plans a stage, or proves that there is no plan. `teams` are agents with one stop each; the goals of a team are the
/// stops of its agents.
pub fn solve(
    instance: &Instance,
    teams: &[Vec<usize>],
    objective: BoardObjective,
    budget: SearchBudget,
) -> SearchAnswer<BoardPlan, NoTeamPlan, BoardCosts> {
    let mut meter = Meter::new(budget);
    let alone = match fast::bounds(&without_teams(instance, teams)) {
        Ok(alone) => alone,
        Err(why) => return SearchAnswer::Impossible(NoTeamPlan::Alone(why)),
    };
    let mut distances = fast::Distances::of(&instance.board);
    let mut costs: Vec<PairCosts> = Vec::with_capacity(teams.len());
    for team in teams {
        let fields = team.iter().map(|agent| distances.to(&instance.board, instance.agents[*agent].goal(), &mut meter));
        let fields: Vec<fast::DistanceField> = fields.collect();
        let reach = |agent: &usize, field: &fast::DistanceField| match field.from(instance.agents[*agent].start) {
            fast::UNREACHABLE => None,
            steps => Some(steps),
        };
        costs.push(team.iter().map(|agent| fields.iter().map(|field| reach(agent, field)).collect()).collect());
    }
    let (mut bounds, mut first) = (alone, Vec::with_capacity(teams.len()));
    for (team, costs) in costs.iter().enumerate() {
        let Some(steps) = assignment::bottleneck(costs) else {
            return SearchAnswer::Impossible(cut(instance, team, &teams[team], costs));
        };
        let most = match objective {
            BoardObjective::Makespan => steps,
            BoardObjective::SumOfCosts => u32::MAX - 1,
        };
        let least = assignment::least_sum(costs, u32::MAX - 1).unwrap_or_default();
        bounds.makespan = bounds.makespan.max(u64::from(steps));
        bounds.sum_of_costs += BoardCosts::from_pairs(costs, &least).sum_of_costs;
        first.push(assignment::least_sum(costs, most).unwrap_or(least));
    }
    let terms = TeamTerms { instance, teams, costs: &costs, alone, objective };
    TeamSearch { terms, bounds, meter, best: None }.run(first)
}

/// The stage with the agents of teams kept at their starts, for the costs of the other agents alone.
fn without_teams(instance: &Instance, teams: &[Vec<usize>]) -> Instance {
    let mut rest = instance.clone();
    for agent in teams.iter().flatten() {
        let start = rest.agents[*agent].start;
        rest.agents[*agent].stops = vec![start];
    }
    rest
}

/// A goal in a region with more goals of the team than agents that can reach it. The region and these agents are both
/// found from the agents that reach the goal, since paths lead in both directions.
fn cut(instance: &Instance, team: usize, agents: &[usize], costs: &PairCosts) -> NoTeamPlan {
    let reaches = |goal: usize| (0..agents.len()).filter(move |agent| costs[*agent][goal].is_some());
    let beside = |goal: usize| match reaches(goal).next() {
        Some(agent) => (0..agents.len()).filter(|other| costs[agent][*other].is_some()).count(),
        None => 1,
    };
    let is_short = |goal: &usize| beside(*goal) > reaches(*goal).count();
    let goal = (0..agents.len()).find(is_short).unwrap_or_default();
    let cell = instance.agents[agents[goal]].goal();
    NoTeamPlan::Cut { team, goal: cell, goals: beside(goal), agents: reaches(goal).count() }
}

impl BoardCosts {
    /// The costs of a team whose agents take these goals, each alone.
    fn from_pairs(costs: &PairCosts, goals: &[usize]) -> BoardCosts {
        let taken = goals.iter().enumerate().filter_map(|(agent, goal)| costs[agent][*goal]).map(u64::from);
        BoardCosts { makespan: taken.clone().max().unwrap_or(0), sum_of_costs: taken.sum() }
    }
}

/// Terms of the search for an assignment.
struct TeamTerms<'a> {
    instance: &'a Instance,
    teams: &'a [Vec<usize>],
    /// By team: the costs of its pairs.
    costs: &'a [PairCosts],
    /// The costs of the agents that belong to no team, each alone.
    alone: BoardCosts,
    objective: BoardObjective,
}

/// An assignment of goals to the agents of each team.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct TeamChoice {
    /// Lower bounds, that on the objective first.
    key: (u64, u64),
    /// The sum of the squares of all distances, to break ties: with a smaller one, agents cross less often.
    squares: u64,
    goals: Vec<Vec<usize>>,
}

impl TeamTerms<'_> {
    fn choice(&self, goals: Vec<Vec<usize>>) -> TeamChoice {
        let teams = self.costs.iter().zip(&goals).map(|(costs, goals)| BoardCosts::from_pairs(costs, goals));
        let bounds = teams.fold(self.alone, |sum, own| BoardCosts {
            makespan: sum.makespan.max(own.makespan),
            sum_of_costs: sum.sum_of_costs + own.sum_of_costs,
        });
        let square = |(costs, goals): (&PairCosts, &Vec<usize>)| -> u64 {
            let taken = goals.iter().enumerate().filter_map(|(agent, goal)| costs[agent][*goal]);
            taken.map(|cost| u64::from(cost) * u64::from(cost)).sum()
        };
        let squares = self.costs.iter().zip(&goals).map(square).sum();
        TeamChoice { key: bounds.key(self.objective), squares, goals }
    }

    /// The stage with these goals.
    fn stage(&self, choice: &TeamChoice) -> Instance {
        let mut stage = self.instance.clone();
        for (team, goals) in self.teams.iter().zip(&choice.goals) {
            for (agent, goal) in team.iter().zip(goals) {
                let Agent { stops, .. } = &mut stage.agents[*agent];
                *stops = vec![self.instance.agents[team[*goal]].goal()];
            }
        }
        stage
    }

    /// All assignments that the distances allow, the one with the least bound first; `None` if there are too many.
    fn all(&self) -> Option<Vec<TeamChoice>> {
        let sizes = self.teams.iter().flat_map(|team| 1..=team.len());
        sizes.into_iter().try_fold(1usize, |all, size| all.checked_mul(size)).filter(|all| *all <= MOST_ASSIGNMENTS)?;
        let mut all: Vec<Vec<Vec<usize>>> = vec![Vec::new()];
        for costs in self.costs {
            let own = orders(costs);
            all = all
                .iter()
                .flat_map(|head| own.iter().map(|last| [head.as_slice(), std::slice::from_ref(last)].concat()))
                .collect();
        }
        let mut all: Vec<TeamChoice> = all.into_iter().map(|goals| self.choice(goals)).collect();
        all.sort_unstable();
        Some(all)
    }

    /// The assignment with the goals of two agents of a team exchanged; `None` if one of them cannot reach its new
    /// goal.
    fn exchanged(&self, choice: &TeamChoice, [one, other]: [usize; 2]) -> Option<TeamChoice> {
        let place = |agent: usize| {
            let of_team = |team: &Vec<usize>| team.iter().position(|own| *own == agent);
            self.teams.iter().enumerate().find_map(|(nth, team)| Some((nth, of_team(team)?)))
        };
        let ((team, one), (same, other)) = (place(one)?, place(other)?);
        let mut goals = choice.goals.clone();
        goals.get_mut(team).filter(|_| team == same)?.swap(one, other);
        let costs = &self.costs[team];
        let can_come = [one, other].iter().all(|agent| costs[*agent][goals[team][*agent]].is_some());
        can_come.then(|| self.choice(goals))
    }
}

/// All assignments of the goals of a team that its agents can reach.
fn orders(costs: &PairCosts) -> Vec<Vec<usize>> {
    let mut all: Vec<Vec<usize>> = vec![Vec::new()];
    for own in costs {
        let longer = |head: &Vec<usize>| {
            let head = head.clone();
            let free = (0..costs.len()).filter(|goal| own[*goal].is_some());
            let free: Vec<usize> = free.filter(|goal| !head.contains(goal)).collect();
            free.into_iter().map(move |goal| [head.as_slice(), &[goal]].concat())
        };
        all = all.iter().flat_map(longer).collect();
    }
    all
}

struct TeamSearch<'a> {
    terms: TeamTerms<'a>,
    /// Lower bounds that hold for every assignment.
    bounds: BoardCosts,
    meter: Meter,
    best: Option<(Paths, BoardCosts)>,
}

impl TeamSearch<'_> {
    fn run(mut self, first: Vec<Vec<usize>>) -> SearchAnswer<BoardPlan, NoTeamPlan, BoardCosts> {
        let first = self.terms.choice(first);
        match self.terms.all() {
            Some(all) => self.each(first, all),
            None => {
                let tried = self.some(first);
                self.exchange(tried);
                self.answer()
            }
        }
    }

    /// Searches the assignments in turn, until no other one can be better.
    fn each(mut self, first: TeamChoice, all: Vec<TeamChoice>) -> SearchAnswer<BoardPlan, NoTeamPlan, BoardCosts> {
        // The least bound proven for any assignment so far; `None` if none has a plan.
        let mut floor: Option<u64> = None;
        let mut lower = |own: u64| floor = Some(floor.map_or(own, |floor| floor.min(own)));
        let rest = all.iter().filter(|choice| **choice != first);
        for (nth, choice) in std::iter::once(&first).chain(rest).enumerate() {
            if self.cost().is_some_and(|cost| cost <= choice.key.0) {
                // No later assignment is below it.
                lower(choice.key.0);
                if nth > 0 {
                    break;
                }
                continue;
            }
            let left = self.meter.left().steps;
            let steps = if nth == 0 { left / FIRST_SHARE } else { (left / (all.len() - nth) as u64).max(1) };
            match self.search(choice, steps) {
                BoardAnswer::Found(BoardPlan { bounds, .. }) | BoardAnswer::GaveUp(bounds) => {
                    lower(bounds.key(self.terms.objective).0.max(choice.key.0));
                }
                BoardAnswer::Impossible(NoBoardPlan::TooFewSteps { least }) => lower(least.max(choice.key.0)),
                BoardAnswer::Impossible(
                    NoBoardPlan::Closed { .. } | NoBoardPlan::TornByChannels { .. } | NoBoardPlan::Blocked { .. },
                ) => {}
            }
        }
        match (floor, self.cost()) {
            (None, None) => return SearchAnswer::Impossible(NoTeamPlan::Blocked),
            (floor, cost) => {
                let least = floor.into_iter().chain(cost).min().unwrap_or(0);
                let of_objective = match self.terms.objective {
                    BoardObjective::Makespan => &mut self.bounds.makespan,
                    BoardObjective::SumOfCosts => &mut self.bounds.sum_of_costs,
                };
                *of_objective = (*of_objective).max(least);
            }
        }
        self.answer()
    }

    /// Searches one assignment; while one has no plan, continues with another in which two agents that block each other
    /// have exchanged their goals. Returns the assignments tried, that of the best known plan last.
    fn some(&mut self, first: TeamChoice) -> Vec<TeamChoice> {
        let (mut tried, mut next) = (Vec::new(), Some(first));
        while let Some(choice) = next.take().filter(|_| tried.len() < MOST_TRIES) {
            let steps = self.meter.left().steps / FIRST_SHARE;
            let answer = self.search(&choice, steps);
            tried.push(choice.clone());
            let BoardAnswer::Impossible(NoBoardPlan::Blocked { agents }) = answer else { break };
            let pairs = agents.iter().enumerate().flat_map(|(at, one)| agents[..at].iter().map(|other| [*one, *other]));
            let mut exchanged = pairs.filter_map(|pair| self.terms.exchanged(&choice, pair));
            next = exchanged.find(|next| !tried.contains(next));
        }
        tried
    }

    /// Improves the plan while it does not meet the bound, by exchanging the goal of an agent that arrives late with
    /// that of another.
    fn exchange(&mut self, mut tried: Vec<TeamChoice>) {
        let Some(mut own) = tried.last().cloned() else { return };
        for _ in 0..MOST_EXCHANGES {
            let Some(cost) = self.cost().filter(|cost| *cost > self.bounds.key(self.terms.objective).0) else { return };
            let late = self.late();
            let pairs = self.terms.teams.iter().flatten().flat_map(|other| late.iter().map(|one| [*one, *other]));
            let exchanged = pairs.filter_map(|pair| self.terms.exchanged(&own, pair));
            let next = exchanged.filter(|next| next.key.0 < cost && !tried.contains(next)).min();
            let Some(next) = next else { return };
            self.search(&next, self.meter.left().steps / EXCHANGE_SHARE);
            if self.cost().is_some_and(|better| better < cost) {
                own = next.clone();
            }
            tried.push(next);
        }
    }

    /// The agents of teams that determine the cost of the best known plan: those that arrive last, or those with the
    /// longest detour.
    fn late(&self) -> Vec<usize> {
        let Some((paths, _)) = &self.best else { return Vec::new() };
        let lateness = |agent: usize| match self.terms.objective {
            BoardObjective::Makespan => paths[agent].len(),
            BoardObjective::SumOfCosts => {
                let ends = [paths[agent].first(), paths[agent].last()].map(|cell| cell.copied().unwrap_or_default());
                paths[agent].len()
                    - (self.terms.instance.board.manhattan(ends[0], ends[1]) as usize).min(paths[agent].len())
            }
        };
        let all = || self.terms.teams.iter().flatten().copied();
        let most = all().map(lateness).max();
        all().filter(|agent| Some(lateness(*agent)) == most).collect()
    }

    /// Plans an assignment, and keeps the plan if it is better than the best known one.
    fn search(&mut self, choice: &TeamChoice, steps: u64) -> BoardAnswer {
        let stage = self.terms.stage(choice);
        let objective = self.terms.objective;
        let limit = match objective {
            BoardObjective::Makespan => self.cost().map(|cost| cost.saturating_sub(1)),
            BoardObjective::SumOfCosts => None,
        };
        let answer = self.meter.share(steps, |meter| portfolio::solve_metered(&stage, objective, limit, meter));
        if let BoardAnswer::Found(BoardPlan { paths, .. }) = &answer {
            let costs = BoardCosts::of(paths);
            if self.best.as_ref().is_none_or(|(_, held)| costs.key(objective) < held.key(objective)) {
                self.best = Some((paths.clone(), costs));
            }
        }
        answer
    }

    /// The objective's cost of the best known plan.
    fn cost(&self) -> Option<u64> {
        self.best.as_ref().map(|(_, costs)| costs.key(self.terms.objective).0)
    }

    fn answer(self) -> SearchAnswer<BoardPlan, NoTeamPlan, BoardCosts> {
        match self.best {
            Some((paths, _)) => SearchAnswer::Found(BoardPlan { paths, bounds: self.bounds }),
            None => SearchAnswer::GaveUp(self.bounds),
        }
    }
}
