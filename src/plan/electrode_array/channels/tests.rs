use super::broadcast::SharedChannels;
use super::*;
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell, ElectrodeMap, Electrodes, Hold};
use crate::plan::electrode_array::board::{
    Agent, BoardAnswer, BoardCosts, BoardGrid, BoardObjective, CellIndex, Instance, NoBoardPlan, Paths,
};
use crate::plan::electrode_array::joint::oracle::{Chance, Shape, fault_by, least_by, random};
use crate::plan::electrode_array::limits::limited;
use crate::plan::electrode_array::portfolio;
use crate::plan::search::SearchBudget;
use std::collections::{BTreeMap, BTreeSet};

/// A board with channels, as the definition of the rule needs it.
#[derive(Debug, Clone)]
struct Pins {
    width: u32,
    numbers: Vec<u32>,
    is_held: bool,
    standing: Vec<CellIndex>,
    stuck: Vec<CellIndex>,
    dead: BTreeSet<CellIndex>,
}

impl Pins {
    fn is_in_reach(&self, at: CellIndex, electrode: CellIndex) -> bool {
        let place = |cell: CellIndex| [i64::from(cell % self.width), i64::from(cell / self.width)];
        let ([c, r], [d, s]) = (place(at), place(electrode));
        (c - d).abs().max((r - s).abs()) <= 1
    }

    /// The rule by its definition: the electrodes that are on are those of the channels of all droplets that move or
    /// are held; within the reach of each droplet only its own electrode may be on, or that of the droplet with which
    /// it merges.
    fn allows(&self, instance: &Instance, from: &[CellIndex], to: &[CellIndex]) -> bool {
        let droplets: Vec<[CellIndex; 2]> = from
            .iter()
            .zip(to)
            .map(|(from, to)| [*from, *to])
            .chain(self.standing.iter().map(|at| [*at, *at]))
            .collect();
        let mut targets = BTreeSet::new();
        let mut besides = BTreeSet::new();
        for [from, to] in &droplets {
            if from == to && !self.is_held {
                continue;
            }
            targets.insert(*to);
            let channel = self.numbers[*to as usize];
            let on = (0..self.numbers.len() as CellIndex).filter(|cell| self.numbers[*cell as usize] == channel);
            besides.extend(on.filter(|cell| cell != to && !self.dead.contains(cell)));
        }
        let lit: BTreeSet<CellIndex> = targets.union(&besides).copied().collect();
        let of_droplet = |nth: usize| {
            let [from, to] = droplets[nth];
            let partner = instance.merges.iter().find(|pair| pair.contains(&nth)).map(|[one, other]| one + other - nth);
            lit.iter().filter(|on| self.is_in_reach(from, **on) || self.is_in_reach(to, **on)).all(|on| {
                let is_of_partner = partner.is_some_and(|partner| droplets[partner][1] == *on);
                // An electrode that is on because it shares another one's channel counts, whoever needs it.
                *on == to || (is_of_partner && !besides.contains(on))
            })
        };
        let spares = |at: &CellIndex| !lit.iter().any(|on| self.is_in_reach(*at, *on));
        (0..droplets.len()).all(of_droplet) && self.stuck.iter().all(spares)
    }

    /// The channels as the compiler has them, made from the facts of a device.
    fn channels(&self) -> Option<SharedChannels> {
        let place = |cell: CellIndex| ElectrodeCell::new(cell % self.width + 1, cell / self.width + 1);
        let map = ElectrodeMap {
            columns: self.width,
            channels: self.numbers.iter().copied().map(Some).collect(),
            disabled: {
                let mut dead: Vec<ElectrodeCell> = self.dead.iter().map(|cell| place(*cell)).collect();
                dead.sort_unstable();
                dead
            },
        };
        let facts = ElectrodeArrayFacts {
            columns: self.width,
            rows: self.numbers.len() as u32 / self.width,
            hold: if self.is_held { Hold::On } else { Hold::Off },
            map: Some(map.into()),
            ..crate::lower::electrode_array::tests::facts(Electrodes::Single)
        };
        let channels = SharedChannels::of(&facts, self.stuck.iter().map(|cell| place(*cell)))?;
        Some(channels.with_standing(&self.standing))
    }
}

/// Random channels on a board, some of them shared, and sometimes a part that does not move.
fn pins(instance: &mut Instance, chance: &mut Chance) -> Pins {
    let (width, cells) = (instance.board.width(), instance.board.cells());
    let (pool, percent) = (2 + chance.below(6) as u32, 10 + chance.below(60));
    let number = |(cell, chance): (usize, &mut Chance)| match chance.below(100) < percent {
        true => chance.below(u64::from(pool)) as u32,
        false => 100 + cell as u32,
    };
    let numbers = (0..cells).map(|cell| number((cell, chance))).collect();
    let mut pins = Pins {
        width,
        numbers,
        is_held: chance.below(3) > 0,
        standing: Vec::new(),
        stuck: Vec::new(),
        dead: BTreeSet::new(),
    };
    let taken: Vec<CellIndex> = instance
        .agents
        .iter()
        .flat_map(|agent| std::iter::once(agent.start).chain(agent.stops.iter().copied()))
        .collect();
    let fixed = chance.below(6);
    if fixed < 2 {
        let at = chance.below(cells as u64) as CellIndex;
        if taken.iter().all(|cell| instance.board.apart(*cell, at) >= 2) {
            instance.board.around(at, 2).for_each(|cell| instance.board.block(cell));
            if fixed == 0 { pins.standing.push(at) } else { pins.stuck.push(at) }
        }
    }
    let blocked: Vec<CellIndex> = (0..cells as CellIndex).filter(|cell| instance.board.is_blocked(*cell)).collect();
    pins.dead.extend(blocked.into_iter().filter(|cell| !pins.standing.contains(cell) && chance.below(3) == 0));
    pins
}

fn shapes() -> Vec<Shape> {
    let shape = |width, height, agents, blocked_percent, vias, merges| Shape {
        width,
        height,
        separation: 2,
        agents,
        blocked_percent,
        vias,
        merges,
    };
    vec![
        shape(3, 3, 1, 0, 1, false),
        shape(4, 4, 1, 20, 2, false),
        shape(4, 3, 2, 0, 0, false),
        shape(4, 4, 2, 10, 1, false),
        shape(4, 4, 2, 0, 0, true),
        shape(5, 3, 2, 10, 0, true),
        shape(5, 3, 3, 0, 0, false),
        shape(4, 4, 3, 0, 0, true),
        shape(7, 1, 2, 0, 0, false),
        shape(9, 1, 3, 0, 0, false),
        shape(5, 2, 2, 0, 1, false),
    ]
}

/// Compares the answers of the board planner with a plain search under the definition of the rule.
#[test]
fn optima_and_impossibility_agree_with_a_plain_search_under_the_rule() {
    let mut chance = Chance(0x0919_5eed);
    let mut met: BTreeMap<&str, usize> = BTreeMap::new();
    for shape in shapes() {
        for _ in 0..120 {
            let Some(mut instance) = random(shape, &mut chance) else { continue };
            let pins = pins(&mut instance, &mut chance);
            let bare = instance.clone();
            let Some(channels) = pins.channels() else { continue };
            instance.board.share(channels);
            let rule = |from: &[CellIndex], to: &[CellIndex]| pins.allows(&bare, from, to);
            for objective in [BoardObjective::Makespan, BoardObjective::SumOfCosts] {
                let least = least_by(&bare, objective, &rule);
                let answer = portfolio::solve(&instance, objective, None, SearchBudget::of(4_000_000));
                let word = match (&answer, least) {
                    (BoardAnswer::Found(plan), Some(least)) => {
                        assert_eq!(fault_by(&bare, &plan.paths, &rule), None, "{instance:?} {pins:?}");
                        let costs = BoardCosts::of(&plan.paths);
                        let keys = (costs.key(objective).0, plan.bounds.key(objective).0);
                        assert_eq!(keys, (least, least), "{instance:?} {pins:?}");
                        let other = |costs: BoardCosts| costs.key(objective).1;
                        assert!(other(plan.bounds) <= other(costs), "{instance:?} {pins:?}");
                        within_limits(&instance, &pins, objective, &plan.paths);
                        "found"
                    }
                    (BoardAnswer::Impossible(NoBoardPlan::Closed { .. }), None) => "closed",
                    (BoardAnswer::Impossible(NoBoardPlan::TornByChannels { .. }), None) => "torn",
                    (BoardAnswer::Impossible(NoBoardPlan::Blocked { agents }), None) => {
                        blames(&bare, agents, &rule, objective);
                        "blocked"
                    }
                    _ => panic!("{answer:?}, but {least:?}: {instance:?} {pins:?}"),
                };
                *met.entry(word).or_default() += 1;
            }
        }
    }
    let least = |word: &str| met.get(word).copied().unwrap_or(0);
    assert!(least("found") > 500 && least("torn") > 100 && least("blocked") > 30, "{met:?}");
}

/// Checks limits at the optimum and one below it.
fn within_limits(instance: &Instance, pins: &Pins, objective: BoardObjective, paths: &Paths) {
    let least = BoardCosts::of(paths).makespan;
    if objective == BoardObjective::SumOfCosts {
        return;
    }
    for objective in [BoardObjective::Makespan, BoardObjective::SumOfCosts] {
        let solve = |limit| portfolio::solve(instance, objective, Some(limit), SearchBudget::of(4_000_000));
        let at = solve(least);
        let BoardAnswer::Found(plan) = &at else { panic!("{at:?}: {instance:?} {pins:?}") };
        assert_eq!(BoardCosts::of(&plan.paths).makespan, least);
        if least > 0 {
            let below = solve(least - 1);
            let is_proven =
                matches!(&below, BoardAnswer::Impossible(NoBoardPlan::TooFewSteps { least: known }) if *known <= least);
            assert!(is_proven, "{below:?}: {instance:?} {pins:?}");
        }
    }
    let known = limited::figures(paths);
    assert_eq!(known[0], least);
}

/// Checks that blamed agents have no plan without the others either.
fn blames(
    instance: &Instance,
    agents: &[usize],
    rule: &dyn Fn(&[CellIndex], &[CellIndex]) -> bool,
    objective: BoardObjective,
) {
    assert!(!agents.is_empty() && agents.is_sorted());
    if agents.len() == instance.agents.len() || !instance.merges.is_empty() {
        return;
    }
    let own = agents.iter().map(|agent| instance.agents[*agent].clone()).collect();
    let alone = Instance { agents: own, ..instance.clone() };
    assert_eq!(least_by(&alone, objective, rule), None);
}

/// A bus of three phases: every third electrode shares a channel, and a droplet can travel along it. So can several at
/// the pitch of the bus.
#[test]
fn a_bus_of_three_phases_carries_droplets_at_its_pitch() {
    let bus = |starts: &[CellIndex], goals: &[CellIndex], phases: u32| {
        let mut board = BoardGrid::new(12, 1);
        let numbers = (0..12).map(|cell| Some(cell % phases)).collect();
        board.share(SharedChannels::new(12, numbers, Hold::On));
        let agents =
            starts.iter().zip(goals).map(|(start, goal)| Agent { start: *start, stops: vec![*goal] }).collect();
        let instance = Instance { board, separation: 2, agents, merges: Vec::new() };
        portfolio::solve(&instance, BoardObjective::Makespan, None, SearchBudget::of(1_000_000))
    };
    let steps = |answer: &BoardAnswer| match answer {
        BoardAnswer::Found(plan) => Some((BoardCosts::of(&plan.paths).makespan, plan.bounds.makespan)),
        BoardAnswer::Impossible(_) | BoardAnswer::GaveUp(_) => None,
    };
    // One droplet: with three or four phases, no step has another electrode of its channel within reach of its ends;
    // with two phases it has.
    assert_eq!(steps(&bus(&[0], &[11], 4)), Some((11, 11)));
    assert_eq!(steps(&bus(&[0], &[11], 3)), Some((11, 11)));
    assert_eq!(bus(&[0], &[11], 2), BoardAnswer::Impossible(NoBoardPlan::TornByChannels { agent: 0, stop: 0 }));
    // Several droplets at the pitch of the bus travel together.
    assert_eq!(steps(&bus(&[0, 4], &[3, 7], 4)), Some((3, 3)));
    // At another distance they would tear each other apart.
    let blocked = BoardAnswer::Impossible(NoBoardPlan::Blocked { agents: vec![0, 1] });
    assert_eq!(bus(&[0, 5], &[6, 11], 3), blocked);
}

#[test]
fn a_budget_that_ends_proves_nothing() {
    let mut board = BoardGrid::new(10, 10);
    board.share(SharedChannels::new(10, (0..100).map(|cell| Some(cell % 31)).collect(), Hold::On));
    let agents = vec![
        Agent { start: 0, stops: vec![99] },
        Agent { start: 99, stops: vec![0] },
        Agent { start: 9, stops: vec![90] },
        Agent { start: 90, stops: vec![9] },
    ];
    let instance = Instance { board, separation: 2, agents, merges: Vec::new() };
    for steps in [1, 50, 500, 5_000] {
        for objective in [BoardObjective::Makespan, BoardObjective::SumOfCosts] {
            match portfolio::solve(&instance, objective, None, SearchBudget::of(steps)) {
                BoardAnswer::Found(plan) => {
                    assert!(plan.bounds.makespan >= 18 && are_kept_by_paths(&instance, &plan.paths))
                }
                BoardAnswer::GaveUp(bounds) => assert!(bounds.makespan >= 18 && bounds.sum_of_costs >= 72),
                BoardAnswer::Impossible(why) => panic!("{why:?} after {steps} steps"),
            }
        }
    }
}
