//! Random motions that keep the plain rule are accepted; with one mutated actuation they are rejected.

use super::*;
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell, Electrodes};
use proptest::prelude::*;
use proptest::sample::Index;

const LETTERS: [char; 5] = ['R', 'L', 'U', 'D', '.'];

/// A task and the words that fulfil it.
#[derive(Debug, Clone)]
struct Scenario {
    claims: Claims,
    words: Vec<Vec<String>>,
}

impl Scenario {
    fn schedule(&self) -> Schedule {
        let steps: Vec<Vec<&str>> = self.words.iter().map(|step| step.iter().map(String::as_str).collect()).collect();
        let steps: Vec<&[&str]> = steps.iter().map(Vec::as_slice).collect();
        schedule(&self.claims, &[&steps])
    }
}

/// The random draw: kind of board, cells of obstacles and parts, and for each step and beat the attempted move of each
/// part.
type Draw = (u8, (u32, u32), Vec<(Index, Index)>, Vec<(Index, Index)>, Vec<Vec<Vec<Index>>>);

fn draw() -> impl Strategy<Value = Draw> {
    let places = |count| prop::collection::vec((any::<Index>(), any::<Index>()), count);
    let beats = prop::collection::vec(prop::collection::vec(any::<Index>(), 6), 0..12);
    (0..5u8, (6..24u32, 6..24u32), places(0..4), places(1..7), prop::collection::vec(beats, 1..4))
}

fn board(sort: u8, columns: u32, rows: u32) -> ElectrodeArrayFacts {
    let platform = platform(columns, rows);
    let chip = chip(columns, rows);
    match sort {
        0 => platform,
        1 => ElectrodeArrayFacts { separation: Separation::Apart(5), ..platform },
        2 => ElectrodeArrayFacts { separation: Separation::AsPublished, clearance: 1, ..platform },
        3 => chip,
        _ => ElectrodeArrayFacts { hold: Hold::Off, separation: Separation::Apart(3), ..chip },
    }
}

/// The test's own implementation of the rule.
struct Rules {
    facts: ElectrodeArrayFacts,
    blocks: Vec<ElectrodeCell>,
    stuck: Vec<ElectrodeCell>,
}

impl Rules {
    fn apart(&self) -> u32 {
        match self.facts.separation {
            Separation::Apart(cells) => cells,
            Separation::AsPublished => 4,
        }
    }

    fn stands(&self, at: ElectrodeCell) -> bool {
        let rim = if self.facts.layout.electrodes == Electrodes::Quad { 1 } else { 0 };
        (1 + rim..=self.facts.columns - rim).contains(&at.column)
            && (1 + rim..=self.facts.rows - rim).contains(&at.row)
            && self.blocks.iter().all(|block| block.apart(at) >= self.facts.clearance)
            && self.stuck.iter().all(|stuck| stuck.apart(at) >= self.apart())
    }

    fn clear(&self, one: [ElectrodeCell; 2], other: [ElectrodeCell; 2]) -> bool {
        one.iter().all(|one| other.iter().all(|other| one.apart(*other) >= self.apart()))
    }

    /// The letter that a part attempts, or a rest if the rule forbids it, given the paths of the others.
    fn letter(&self, part: usize, would: Index, ways: &[[ElectrodeCell; 2]]) -> char {
        let letter = LETTERS[would.index(LETTERS.len())];
        let at = ways[part][0];
        let on_board = at.column > 1 && at.row > 1;
        if !on_board || !self.stands(moved(at, letter)) {
            return '.';
        }
        let way = [at, moved(at, letter)];
        let others = ways.iter().enumerate().filter(|(other, _)| *other != part);
        if others.into_iter().all(|(_, other)| self.clear(way, *other)) { letter } else { '.' }
    }
}

fn scenario() -> impl Strategy<Value = Scenario> {
    draw().prop_map(|(sort, size, obstacles, places, steps)| {
        let facts = board(sort, size.0, size.1);
        let place = |(column, row): &(Index, Index)| {
            cell(1 + column.index(size.0 as usize) as u32, 1 + row.index(size.1 as usize) as u32)
        };
        let mut rules = Rules { facts: facts.clone(), blocks: Vec::new(), stuck: Vec::new() };
        let mut bodies = Vec::new();
        for (index, at) in obstacles.iter().map(place).enumerate() {
            if index % 2 == 0 {
                rules.blocks.push(at);
                bodies.push(obstacle("block", ElectrodeArrayObstacleBody::Electrodes { from: at, to: at }));
            } else {
                rules.stuck.push(at);
                bodies.push(obstacle("stuck", ElectrodeArrayObstacleBody::Fixed(at)));
            }
        }
        let mut cells: Vec<ElectrodeCell> = Vec::new();
        for at in places.iter().map(place) {
            if rules.stands(at) && cells.iter().all(|other| other.apart(at) >= rules.apart()) {
                cells.push(at);
            }
        }
        let names = ["a", "b", "c", "d", "e", "f"];
        let parts: Vec<(&str, u32, u32)> =
            cells.iter().zip(names).map(|(at, name)| (name, at.column, at.row)).collect();
        let (mut actions, mut words) = (Vec::new(), Vec::new());
        for beats in &steps {
            let (goals, step) = walk(&rules, &mut cells, beats);
            actions.extend([ElectrodeArrayAction::Move(goals), ElectrodeArrayAction::Wait(BEAT / 2)]);
            words.extend([step, Vec::new()]);
        }
        let mut order = order(facts, &parts, actions);
        order.obstacles = Arc::new(bodies);
        Scenario { claims: alone(order), words }
    })
}

/// One step: the attempted moves, as far as the rule allows them.
fn walk(rules: &Rules, cells: &mut [ElectrodeCell], beats: &[Vec<Index>]) -> (Vec<ElectrodeArrayMove>, Vec<String>) {
    let mut words = vec![String::new(); cells.len()];
    let mut stops: Vec<Vec<(u32, u32)>> = vec![Vec::new(); cells.len()];
    for beat in beats {
        let mut ways: Vec<[ElectrodeCell; 2]> = cells.iter().map(|at| [*at, *at]).collect();
        for part in 0..cells.len() {
            let letter = rules.letter(part, beat[part], &ways);
            ways[part][1] = moved(ways[part][0], letter);
            words[part].push(letter);
            if letter != '.' {
                stops[part].push(ways[part][1].pair().into());
            }
        }
        cells.iter_mut().zip(ways).for_each(|(at, way)| *at = way[1]);
    }
    let words = words.into_iter().map(|word| word.trim_end_matches('.').to_owned()).collect();
    let goals = stops.iter().enumerate().filter(|(_, stops)| !stops.is_empty()).map(|(part, stops)| go(part, stops));
    (goals.collect(), words)
}

/// One mutation, of one actuation or of two.
#[derive(Debug, Clone)]
enum Mutation {
    Drop(Index),
    Double(Index),
    Swap(Index, Index),
    Shift(Index, i64),
    Stretch(Index, i64),
    Retarget(Index, (u32, u32)),
    Reassign(Index, Index),
    Level(Index, f64),
    Add(Index, (u32, u32)),
}

fn mutation() -> impl Strategy<Value = Mutation> {
    let index = any::<Index>;
    let beat = BEAT as i64;
    let by_ns = move || prop_oneof![Just(1), Just(-1), Just(beat), Just(-beat), Just(2 * beat), -3 * beat..3 * beat];
    let electrode = || (1..6u32, 1..6u32);
    prop_oneof![
        index().prop_map(Mutation::Drop),
        index().prop_map(Mutation::Double),
        (index(), index()).prop_map(|(one, other)| Mutation::Swap(one, other)),
        (index(), by_ns()).prop_map(|(at, by_ns)| Mutation::Shift(at, by_ns)),
        (index(), by_ns()).prop_map(|(at, by_ns)| Mutation::Stretch(at, by_ns)),
        (index(), electrode()).prop_map(|(at, to)| Mutation::Retarget(at, to)),
        (index(), index()).prop_map(|(at, to)| Mutation::Reassign(at, to)),
        (index(), prop_oneof![Just(100.0), 0.0..200.0]).prop_map(|(at, volts)| Mutation::Level(at, volts)),
        (index(), electrode()).prop_map(|(at, to)| Mutation::Add(at, to)),
    ]
}

fn mutate(schedule: &mut Schedule, mutation: &Mutation) {
    let near = |schedule: &mut Schedule, (column, row): (u32, u32)| channel(schedule, cell(column, row));
    match mutation {
        Mutation::Retarget(at, to) => {
            let to = near(schedule, *to);
            at.get_mut(&mut schedule.actuations).channel = to;
        }
        Mutation::Add(at, to) => {
            let channel = near(schedule, *to);
            let like = *at.get(&schedule.actuations);
            schedule.actuations.push(crate::schedule::Actuation { channel, ..like });
        }
        Mutation::Drop(at) => drop(schedule.actuations.remove(at.index(schedule.actuations.len()))),
        Mutation::Double(at) => schedule.actuations.push(*at.get(&schedule.actuations)),
        Mutation::Swap(one, other) => {
            let list = &mut schedule.actuations;
            let (one, other) = (one.index(list.len()), other.index(list.len()));
            (list[one].channel, list[other].channel) = (list[other].channel, list[one].channel);
        }
        Mutation::Shift(at, by_ns) => {
            let actuation = at.get_mut(&mut schedule.actuations);
            actuation.start_ns = actuation.start_ns.saturating_add_signed(*by_ns);
        }
        Mutation::Stretch(at, by_ns) => {
            let actuation = at.get_mut(&mut schedule.actuations);
            actuation.duration_ns = actuation.duration_ns.saturating_add_signed(*by_ns);
        }
        Mutation::Reassign(at, to) => {
            let to = to.index(schedule.steps.len()) as u32;
            at.get_mut(&mut schedule.actuations).step = to;
        }
        Mutation::Level(at, volts) => at.get_mut(&mut schedule.actuations).to = *volts,
    }
    schedule.actuations.sort_by_key(|actuation| (actuation.start_ns, actuation.channel));
}

/// A random walk, then the path to a goal, cut at the first arrival there: as a word and as cells.
fn to_goal(
    start: ElectrodeCell,
    stroll: &[usize],
    rows_first: bool,
    goal: ElectrodeCell,
) -> (String, Vec<ElectrodeCell>) {
    let (mut word, mut path) = (String::new(), vec![start]);
    let mut stroll = stroll.iter();
    while let Some(at) = path.last().copied().filter(|at| *at != goal) {
        let columns = if at.column < goal.column { 'R' } else { 'L' };
        let rows = if at.row < goal.row { 'U' } else { 'D' };
        let straight = if at.column == goal.column || (rows_first && at.row != goal.row) { rows } else { columns };
        let letter = stroll.next().map_or(straight, |letter| LETTERS[*letter]);
        path.push(moved(at, letter));
        word.push(letter);
    }
    (word, path)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    /// A mutant passes only if its actuations are those of the original.
    #[test]
    fn a_mutant_is_refused_or_the_same(scenario in scenario(), mutations in prop::collection::vec(mutation(), 5)) {
        let sound = scenario.schedule();
        prop_assert_eq!(rules(&sound, &scenario.claims), vec![]);
        for mutation in mutations.iter().filter(|_| !sound.actuations.is_empty()) {
            let mut mutant = sound.clone();
            mutate(&mut mutant, mutation);
            let refused = !rules(&mutant, &scenario.claims).is_empty();
            prop_assert_eq!(refused, mutant.actuations != sound.actuations, "{:?}", mutation);
        }
    }

    /// Two droplets that merge keep the rule except at their goal, and stay there once they have arrived.
    #[test]
    fn merging_is_judged_by_the_rule_besides_the_goal(
        is_held: bool,
        starts in [(0..7u32, 0..7u32), (0..7u32, 0..7u32)],
        strolls in [prop::collection::vec(0..5usize, 0..4), prop::collection::vec(0..5usize, 0..4)],
        rows_first in any::<[bool; 2]>(),
    ) {
        let goal = cell(8, 8);
        let starts = starts.map(|(column, row)| cell(5 + column, 5 + row));
        let [one, other] = [0, 1].map(|at| to_goal(starts[at], &strolls[at], rows_first[at], goal));
        let position = |path: &[ElectrodeCell], instant: usize| path[instant.min(path.len() - 1)];
        let near = |a: ElectrodeCell, b: ElectrodeCell| a != goal && b != goal && a.apart(b) < 2;
        // Before the first step nothing moves to the goal, so parts keep apart as usual.
        let safe = starts[0].apart(starts[1]) >= 2 && (0..one.1.len().max(other.1.len())).all(|t| {
            let now = [position(&one.1, t), position(&other.1, t)];
            let next = [position(&one.1, t + 1), position(&other.1, t + 1)];
            !(near(now[0], now[1]) || near(now[0], next[1]) || near(next[0], now[1]))
        });
        let facts = ElectrodeArrayFacts { hold: if is_held { Hold::On } else { Hold::Off }, ..chip(20, 20) };
        let names = [("a", starts[0]), ("b", starts[1])].map(|(name, at)| (name, at.column, at.row));
        let (schedule, claims) = one_step(moving(facts, &names, vec![merge(0, 1, (8, 8))]), &[&one.0, &other.0]);
        let accepted = rules(&schedule, &claims).is_empty();
        // A droplet that is not held follows the other one's electrode if it rests beside the goal.
        prop_assert!(safe || !accepted);
        prop_assert!(accepted || !safe || !is_held);
    }

    /// Random moves, not filtered by the rule, are accepted exactly if they keep it.
    #[test]
    fn free_words_are_judged_by_the_rule(
        sort in 0..5u8,
        offsets in (2..8u32, 0..8u32),
        words in prop::collection::vec((0..5usize, 0..5usize), 1..4),
    ) {
        let facts = board(sort, 30, 30);
        let rule = Rules { facts: facts.clone(), blocks: Vec::new(), stuck: Vec::new() };
        let mut ends = [cell(12, 12), cell(12 + offsets.0, 12 + offsets.1)];
        let starts = ends;
        let mut safe = starts[0].apart(starts[1]) >= rule.apart();
        let mut spelt = [String::new(), String::new()];
        for (one, other) in words {
            let letters = [LETTERS[one], LETTERS[other]];
            let next = [moved(ends[0], letters[0]), moved(ends[1], letters[1])];
            safe &= rule.clear([ends[0], next[0]], [ends[1], next[1]]);
            spelt[0].push(letters[0]);
            spelt[1].push(letters[1]);
            ends = next;
        }
        // A third part far away moves last, so that no beat at the end is idle.
        let far = "R".repeat(spelt[0].len());
        let parts = [("a", 12, 12), ("b", starts[1].column, starts[1].row), ("far", 25, 28)];
        let goal = (25 + far.len() as u32, 28);
        let facts = ElectrodeArrayFacts { columns: 40, rows: 40, ..facts };
        let goals = vec![go(0, &[ends[0].pair().into()]), go(1, &[ends[1].pair().into()]), go(2, &[goal])];
        let (schedule, claims) = one_step(moving(facts, &parts, goals), &[&spelt[0], &spelt[1], &far]);
        prop_assert_eq!(rules(&schedule, &claims).is_empty(), safe);
    }
}
