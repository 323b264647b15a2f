//! Sound schedules of random scenes with one mutation: each mutant is rejected, or identical to the original.

use super::*;
use crate::claims::dimibot::{DimibotAction, DimibotObstacle, DimibotObstacleBody};
use crate::device::dimibot::{DimibotFacts, LatticeCell, Side, Simultaneous};
use crate::geometry::shape::Shape;
use proptest::prelude::*;
use proptest::sample::Index;

/// A program with one run, and the pulses of a sound schedule.
#[derive(Debug, Clone)]
struct Scenario {
    claims: Claims,
    pulses: Vec<Vec<String>>,
}

impl Scenario {
    fn schedule(&self) -> Schedule {
        let steps: Vec<Vec<&str>> = self.pulses.iter().map(|step| step.iter().map(String::as_str).collect()).collect();
        let steps: Vec<&[&str]> = steps.iter().map(Vec::as_slice).collect();
        schedule(&self.claims, &[&steps])
    }
}

/// The random draw: robot, a walk with the modules of each pulse and the kind of its step, and bodies in fractions of
/// the workspace.
type Draw = ((u32, u32, bool, bool), Vec<(Index, Option<Index>, u8)>, Vec<(f64, f64, f64)>);

fn draw() -> impl Strategy<Value = Draw> {
    let robot = (1..=5u32, 1..=5u32, any::<bool>(), any::<bool>());
    let walk = prop::collection::vec((any::<Index>(), any::<Option<Index>>(), 0..5u8), 1..8);
    let bodies = prop::collection::vec((-0.1..1.1f64, -0.1..1.1f64, 0.0..0.1f64), 0..8);
    (robot, walk, bodies)
}

fn scenario() -> impl Strategy<Value = Scenario> {
    draw().prop_map(|((left, right, rests, safe), walk, bodies)| {
        let mut facts = facts(left, right);
        facts.rest_ns = if rests { 5 * MS } else { 0 };
        let mut order = order(facts.clone(), Vec::new());
        order.simultaneous = if safe { Simultaneous::Safe } else { Simultaneous::Never };
        let (mut cell, mut pulses, mut actions) = (facts.home, Vec::new(), Vec::new());
        let mut areas = vec![[cell, cell]];
        for (first, second, sort) in walk {
            let (names, low, high, after) = pulse(&facts, cell, first, second.filter(|_| safe));
            areas.push([low, high]);
            cell = after;
            take(&mut actions, &mut pulses, sort, names, cell);
        }
        let size_um = [
            facts.pitch_um(Side::Left) * f64::from(facts.cells(Side::Left)),
            facts.pitch_um(Side::Right) * f64::from(facts.cells(Side::Right)),
        ];
        let bodies = bodies.into_iter().map(|(x, y, radius)| {
            solid("bead", Shape::Disc { radius_um: radius * size_um[0] }, x * size_um[0], y * size_um[1])
        });
        let clear = |body: &DimibotObstacle| areas.iter().all(|area| gap(&facts, body, *area) > facts.growth_um());
        order.obstacles = std::sync::Arc::new(bodies.filter(clear).collect());
        order.steps = actions
            .into_iter()
            .map(|action| crate::claims::dimibot::DimibotStep { action, span: Default::default() })
            .collect();
        Scenario { claims: alone(order), pulses }
    })
}

/// Adds a pulse to the current step, or begins a new one.
fn take(actions: &mut Vec<DimibotAction>, pulses: &mut Vec<Vec<String>>, sort: u8, names: String, to: LatticeCell) {
    let goal = stop(to.x, to.y);
    match (sort, actions.last_mut()) {
        (0 | 1, Some(DimibotAction::Move(stops))) => stops.push(goal),
        (2, Some(DimibotAction::Move(stops))) => *stops.last_mut().expect("a goal") = goal,
        (0 | 1, Some(DimibotAction::Visit(stops))) => stops.insert(0, goal),
        (3, _) => {
            actions.extend([DimibotAction::Wait(7 * MS), DimibotAction::Visit(vec![goal])]);
            pulses.extend([vec![], vec![names]]);
            return;
        }
        (_, _) => {
            actions.push(DimibotAction::Move(vec![goal]));
            return pulses.push(vec![names]);
        }
    }
    pulses.last_mut().expect("a step").push(names);
}

/// A pulse of one or two modules: its channels, the corners of the area that it may sweep, and the cell after it.
fn pulse(
    facts: &DimibotFacts,
    cell: LatticeCell,
    first: Index,
    second: Option<Index>,
) -> (String, LatticeCell, LatticeCell, LatticeCell) {
    let count = (facts.left + facts.right) as usize;
    let mut modules: Vec<usize> = [Some(first), second].into_iter().flatten().map(|index| index.index(count)).collect();
    modules.dedup();
    let (mut low, mut high, mut after, mut names) = (cell, cell, cell, Vec::new());
    for module in modules {
        let (side, module) =
            if module < facts.left as usize { ("bl", module) } else { ("br", module - facts.left as usize) };
        let bit = 1 << module;
        let was = (if side == "bl" { cell.x } else { cell.y }) & bit != 0;
        for (corner, applies) in [(&mut low, was), (&mut high, !was), (&mut after, true)] {
            let bits = if side == "bl" { &mut corner.x } else { &mut corner.y };
            *bits ^= if applies { bit } else { 0 };
        }
        names.push(format!("{side}{module}.{}", if was { "reset" } else { "set" }));
    }
    (names.join(" "), low, high, after)
}

/// Distance between a rectangle of cells and the surface of a disc.
fn gap(facts: &DimibotFacts, body: &DimibotObstacle, [low, high]: [LatticeCell; 2]) -> f64 {
    let DimibotObstacleBody::Solid { shape: Shape::Disc { radius_um }, pose } = &body.body else {
        panic!("discs alone are drawn")
    };
    let (from, to) = (facts.place_um(low), facts.place_um(high));
    let nearest = [0, 1].map(|axis| [pose.x_um, pose.y_um][axis].clamp(from[axis], to[axis]));
    (pose.x_um - nearest[0]).hypot(pose.y_um - nearest[1]) - radius_um
}

/// One mutation, of one actuation or of two.
#[derive(Debug, Clone)]
enum Mutation {
    Drop(Index),
    Double(Index),
    Swap(Index, Index),
    Shift(Index, i64),
    Stretch(Index, i64),
    Retarget(Index, Index),
    Reassign(Index, Index),
    Level(Index, f64),
}

fn mutation() -> impl Strategy<Value = Mutation> {
    let index = any::<Index>;
    let by_ns =
        || prop_oneof![Just(1), Just(-1), Just(20 * MS as i64), Just(-15 * MS as i64), -90_000_000..90_000_000i64];
    prop_oneof![
        index().prop_map(Mutation::Drop),
        index().prop_map(Mutation::Double),
        (index(), index()).prop_map(|(one, other)| Mutation::Swap(one, other)),
        (index(), by_ns()).prop_map(|(at, by_ns)| Mutation::Shift(at, by_ns)),
        (index(), by_ns()).prop_map(|(at, by_ns)| Mutation::Stretch(at, by_ns)),
        (index(), index()).prop_map(|(at, to)| Mutation::Retarget(at, to)),
        (index(), index()).prop_map(|(at, to)| Mutation::Reassign(at, to)),
        (index(), prop_oneof![Just(20.0), 0.0..40.0]).prop_map(|(at, volts)| Mutation::Level(at, volts)),
    ]
}

fn mutate(schedule: &mut Schedule, mutation: &Mutation) {
    let Schedule { actuations: list, channels, steps, .. } = schedule;
    let by = |value: u64, by_ns: i64| value.saturating_add_signed(by_ns);
    match mutation {
        Mutation::Drop(at) => drop(list.remove(at.index(list.len()))),
        Mutation::Double(at) => list.push(list[at.index(list.len())]),
        Mutation::Swap(one, other) => {
            let (one, other) = (one.index(list.len()), other.index(list.len()));
            (list[one].channel, list[other].channel) = (list[other].channel, list[one].channel);
        }
        Mutation::Shift(at, by_ns) => at.get_mut(list).start_ns = by(at.get(list).start_ns, *by_ns),
        Mutation::Stretch(at, by_ns) => at.get_mut(list).duration_ns = by(at.get(list).duration_ns, *by_ns),
        Mutation::Retarget(at, to) => at.get_mut(list).channel = to.index(channels.len()) as u32,
        Mutation::Reassign(at, to) => at.get_mut(list).step = to.index(steps.len()) as u32,
        Mutation::Level(at, volts) => at.get_mut(list).to = *volts,
    }
    list.sort_by_key(|actuation| (actuation.start_ns, actuation.channel));
}

fn bytes(schedule: &Schedule) -> Vec<u8> {
    serde_json::to_vec(schedule).expect("a schedule is JSON")
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    /// A mutant passes only if it is byte for byte the original schedule, as after swapping equals or shifting by
    /// nothing.
    #[test]
    fn a_mutant_is_refused_or_the_same(scenario in scenario(), mutation in mutation()) {
        let sound = scenario.schedule();
        prop_assert_eq!(rules(&sound, &scenario.claims), vec![]);
        let mut mutant = sound.clone();
        mutate(&mut mutant, &mutation);
        let refused = !rules(&mutant, &scenario.claims).is_empty();
        prop_assert_eq!(refused, bytes(&mutant) != bytes(&sound));
    }

    /// A forger who also corrects the records gains only schedules that an independent simulator finds sound.
    #[test]
    fn an_exchange_with_true_records_is_judged_as_the_simulator_does(
        scenario in scenario(),
        (one, other) in any::<(Index, Index)>(),
    ) {
        let mut mutant = scenario.schedule();
        mutate(&mut mutant, &Mutation::Swap(one, other));
        record(&mut mutant, &scenario.claims);
        let sound = simulated(&mutant, &scenario.claims);
        prop_assert_eq!(rules(&mutant, &scenario.claims).is_empty(), sound);
    }
}

/// Whether pulses have an effect, keep clear of all bodies and reach the stops; times are assumed to be right.
fn simulated(schedule: &Schedule, claims: &Claims) -> bool {
    let Order::Dimibot(order) = &claims.jobs[0].order else { panic!("an order of a DiMiBot") };
    let facts = &order.facts;
    let (mut cell, mut sound) = (facts.home, true);
    for (nth, step) in order.steps.iter().enumerate() {
        let mut met = vec![cell];
        let own: Vec<_> = schedule.actuations.iter().filter(|actuation| actuation.step as usize == nth).collect();
        for together in own.chunk_by(|a, b| a.start_ns == b.start_ns) {
            let names = together.iter().map(|actuation| schedule.channels[actuation.channel as usize].name.as_str());
            let (mut low, mut high, mut after, mut touched) = (cell, cell, cell, Vec::new());
            for name in names {
                let parts: Vec<&str> = name.split('.').collect();
                let (left, bit) = (parts[1].starts_with("bl"), 1 << parts[1][2..].parse::<u32>().unwrap());
                let set = parts[2] == "set";
                sound &= !touched.contains(&parts[1].to_owned());
                touched.push(parts[1].to_owned());
                let bits = |cell: LatticeCell| if left { cell.x } else { cell.y };
                sound &= (bits(after) & bit != 0) != set;
                let flip = |cell: LatticeCell| {
                    if left { LatticeCell { x: cell.x ^ bit, ..cell } } else { LatticeCell { y: cell.y ^ bit, ..cell } }
                };
                after = flip(after);
                (low, high) = if set { (low, flip(high)) } else { (flip(low), high) };
            }
            sound = sound && order.obstacles.iter().all(|body| gap(facts, body, [low, high]) > facts.growth_um());
            cell = after;
            met.push(cell);
        }
        sound &= match &step.action {
            DimibotAction::Wait(_) => own.is_empty(),
            DimibotAction::Visit(stops) => {
                stops.iter().all(|stop| met.contains(&stop.cell)) && stops.iter().any(|stop| stop.cell == cell)
            }
            DimibotAction::Move(stops) => {
                let mut rest = met.iter();
                stops.iter().all(|stop| in_turn(&mut rest, stop.cell))
                    && stops.last().is_some_and(|stop| stop.cell == cell)
            }
        };
    }
    sound
}

/// Advances to a cell, which the next stop may use again.
fn in_turn(rest: &mut std::slice::Iter<'_, LatticeCell>, cell: LatticeCell) -> bool {
    let found = rest.as_slice().iter().position(|met| *met == cell);
    found.map(|at| *rest = rest.as_slice()[at..].iter()).is_some()
}
