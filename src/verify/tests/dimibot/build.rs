//! Builds schedules from claims and lists of pulses, with records from an independent simulator.

use crate::claims::dimibot::{
    Asked, DimibotAction, DimibotMethod, DimibotObjective, DimibotObstacle, DimibotObstacleBody, DimibotOrder,
    DimibotPlanner, DimibotStep, DimibotStop,
};
use crate::claims::{Claims, Job, Order, Timeline, fixture};
use crate::device::dimibot::tests::femto_st;
use crate::device::dimibot::{DimibotFacts, LatticeCell, Side, Simultaneous};
use crate::geometry::shape::{Pose, Shape};
use crate::schedule::dimibot::DimibotState;
use crate::schedule::{Actuation, Channel, ChannelUnit, PlanRecord, Schedule, State, TimedState};
use crate::source::Span;
use crate::verify::tests::{MS, bare, claims, record_of, step_of};
use std::collections::BTreeMap;

pub fn facts(left: u32, right: u32) -> DimibotFacts {
    DimibotFacts { rest_ns: 5 * MS, tip_radius_um: 0.01, ..femto_st(left, right) }
}

pub fn cell(x: u32, y: u32) -> LatticeCell {
    LatticeCell { x, y }
}

pub fn stop(x: u32, y: u32) -> DimibotStop {
    DimibotStop { asked: Asked::Cell, cell: cell(x, y), span: Span::default() }
}

pub fn stops(cells: &[(u32, u32)]) -> Vec<DimibotStop> {
    cells.iter().map(|(x, y)| stop(*x, *y)).collect()
}

pub fn go(cells: &[(u32, u32)]) -> DimibotAction {
    DimibotAction::Move(stops(cells))
}

pub fn order(facts: DimibotFacts, actions: Vec<DimibotAction>) -> DimibotOrder {
    DimibotOrder {
        facts,
        frame: None,
        obstacles: Default::default(),
        objective: DimibotObjective::Distance,
        planner: DimibotPlanner { method: DimibotMethod::StagedAstar, expansions: 1000 },
        simultaneous: Simultaneous::Never,
        precision_um: None,
        start: None,
        steps: actions.into_iter().map(|action| DimibotStep { action, span: Span::default() }).collect(),
    }
}

pub fn job(task: &str, device: &str, order: DimibotOrder) -> Job {
    fixture::job(task, device, Order::Dimibot(order))
}

/// Claims of a single task.
pub fn alone(order: DimibotOrder) -> Claims {
    claims(vec![job("fetch", "bot", order)], Timeline::Run(0))
}

pub fn order_of(claims: &mut Claims, job: usize) -> &mut DimibotOrder {
    let Order::Dimibot(order) = &mut claims.jobs[job].order else { panic!("an order of a DiMiBot") };
    order
}

pub fn solid(name: &str, shape: Shape, x_um: f64, y_um: f64) -> DimibotObstacle {
    let body = DimibotObstacleBody::Solid { shape, pose: Pose { x_um, y_um, heading_rad: 0.0 } };
    DimibotObstacle { name: name.into(), body, span: Span::default() }
}

pub fn cells(name: &str, from: (u32, u32), to: (u32, u32)) -> DimibotObstacle {
    let body = DimibotObstacleBody::Cells { from: cell(from.0, from.1), to: cell(to.0, to.1) };
    DimibotObstacle { name: name.into(), body, span: Span::default() }
}

/// The pulses of each step of each job, in order. A pulse is a list of channels, separated by spaces.
pub type Pulses<'a> = &'a [&'a [&'a [&'a str]]];

/// The schedule of these pulses without idle time, with true records.
pub fn schedule(claims: &Claims, pulses: Pulses) -> Schedule {
    let mut schedule = Schedule {
        bench: Default::default(),
        channels: channels(claims),
        plans: claims.jobs.iter().map(empty_plan).collect(),
        ..bare(claims)
    };
    schedule.duration_ns = lay(&claims.timeline, 0, claims, pulses, &mut schedule);
    schedule.actuations.sort_by_key(|actuation| (actuation.start_ns, actuation.channel));
    record(&mut schedule, claims);
    schedule
}

fn channels(claims: &Claims) -> Vec<Channel> {
    let mut channels: Vec<Channel> = Vec::new();
    for job in &claims.jobs {
        let Order::Dimibot(order) = &job.order else { panic!("an order of a DiMiBot") };
        for (side, count) in [("bl", order.facts.left), ("br", order.facts.right)] {
            for (module, switch) in (0..count).flat_map(|module| [(module, "set"), (module, "reset")]) {
                let name = format!("{}.{side}{module}.{switch}", job.device);
                let wire = claims.wires.get(&name).cloned();
                if !channels.iter().any(|channel| channel.name == name) {
                    channels.push(Channel {
                        name,
                        device: job.device.clone(),
                        unit: ChannelUnit::Volt,
                        wire,
                        rest_v: 0.0,
                    });
                }
            }
        }
    }
    channels
}

fn empty_plan(job: &Job) -> PlanRecord {
    let Order::Dimibot(order) = &job.order else { panic!("an order of a DiMiBot") };
    let (objective, unit) = match order.objective {
        DimibotObjective::Distance => ("distance", "um"),
        DimibotObjective::Switches => ("switches", ""),
        DimibotObjective::Time => ("time", "ms"),
        DimibotObjective::Energy => ("energy", "mJ"),
    };
    PlanRecord { optimal: true, ..record_of(job, "staged_astar", [objective, unit], [0, 0]) }
}

fn lay(part: &Timeline, start_ns: u64, claims: &Claims, pulses: Pulses, schedule: &mut Schedule) -> u64 {
    match part {
        Timeline::Wait(duration_ns) => start_ns + duration_ns,
        Timeline::Sequence(parts) => {
            parts.iter().fold(start_ns, |at_ns, part| lay(part, at_ns, claims, pulses, schedule))
        }
        Timeline::Together(parts) => {
            let ends = parts.iter().map(|part| lay(part, start_ns, claims, pulses, schedule));
            ends.max().unwrap_or(start_ns)
        }
        Timeline::Run(index) => lay_run(*index, start_ns, claims, pulses[*index], schedule),
    }
}

fn lay_run(index: usize, start_ns: u64, claims: &Claims, pulses: &[&[&str]], schedule: &mut Schedule) -> u64 {
    let job = &claims.jobs[index];
    let Order::Dimibot(order) = &job.order else { panic!("an order of a DiMiBot") };
    let DimibotFacts { pulse_voltage_v: volts, pulse_duration_ns, rest_ns, .. } = order.facts;
    let mut at_ns = start_ns;
    for (nth, claimed) in order.steps.iter().enumerate() {
        let (step, step_ns) = (schedule.steps.len() as u32, at_ns);
        for names in pulses[nth] {
            for name in names.split(' ') {
                let name = format!("{}.{name}", job.device);
                let channel = channel(schedule, &name);
                let shape = Actuation {
                    channel,
                    start_ns: at_ns,
                    duration_ns: pulse_duration_ns,
                    from: volts,
                    to: volts,
                    swing: None,
                    step,
                };
                schedule.actuations.push(shape);
            }
            at_ns += pulse_duration_ns + rest_ns;
        }
        if let DimibotAction::Wait(duration_ns) = claimed.action {
            at_ns = step_ns + duration_ns;
        }
        schedule.steps.push(step_of(job, index, [step_ns, at_ns]));
    }
    schedule.plans[index].start_ns = start_ns;
    schedule.plans[index].duration_ns = at_ns - start_ns;
    at_ns
}

/// The index of a channel.
pub fn channel(schedule: &Schedule, name: &str) -> u32 {
    schedule.channels.iter().position(|channel| channel.name == name).expect("a channel of this name") as u32
}

/// Writes the states, outcomes, cost and bound that follow from the actuations, however wrong these are.
pub fn record(schedule: &mut Schedule, claims: &Claims) {
    let mut standing: BTreeMap<&str, LatticeCell> = BTreeMap::new();
    let mut jobs: Vec<usize> = (0..claims.jobs.len()).collect();
    jobs.sort_by_key(|index| (schedule.plans[*index].start_ns, *index));
    for index in jobs {
        let Order::Dimibot(order) = &claims.jobs[index].order else { panic!("an order of a DiMiBot") };
        let first = order.start.as_ref().map_or(order.facts.home, |start| start.value);
        let start = *standing.entry(&claims.jobs[index].device).or_insert(first);
        let end = record_run(schedule, index, order, start);
        standing.insert(&claims.jobs[index].device, end);
    }
}

fn record_run(schedule: &mut Schedule, index: usize, order: &DimibotOrder, start: LatticeCell) -> LatticeCell {
    let facts = &order.facts;
    let of_run = |actuation: &&Actuation| schedule.steps[actuation.step as usize].plan as usize == index;
    let mut actuations: Vec<Actuation> = schedule.actuations.iter().filter(of_run).copied().collect();
    actuations.sort_by_key(|actuation| (actuation.start_ns, actuation.channel));
    let (mut cell, mut switches, mut distance_um) = (start, 0, 0.0);
    let mut states = vec![state(facts, schedule.plans[index].start_ns, cell)];
    for pulse in actuations.chunk_by(|one, other| one.start_ns == other.start_ns) {
        let parts: Vec<(Side, u32, bool)> = pulse.iter().map(|part| parsed(schedule, part.channel)).collect();
        let before = cell;
        for (side, module, set) in &parts {
            let bits = if *side == Side::Left { &mut cell.x } else { &mut cell.y };
            let opposed = parts.contains(&(*side, *module, !set));
            if (*bits >> module & 1 == 1) != *set && !opposed {
                *bits ^= 1 << module;
                switches += 1;
                distance_um += f64::from(1 << module) * facts.pitch_um(*side);
            }
        }
        if cell != before {
            states.push(state(facts, pulse[0].start_ns + facts.pulse_duration_ns, cell));
        }
    }
    let plan = &mut schedule.plans[index];
    let seconds = plan.duration_ns as f64 / 1e9;
    let energy_j = actuations.len() as f64 * facts.switch_energy_j();
    let outcomes = [
        ("distance_um", distance_um),
        ("switches", f64::from(switches)),
        ("time_ns", plan.duration_ns as f64),
        ("energy_j", energy_j),
    ];
    plan.outcomes = outcomes.map(|(name, value)| (name.to_owned(), value)).into();
    plan.cost = match order.objective {
        DimibotObjective::Distance => distance_um,
        DimibotObjective::Switches => f64::from(switches),
        DimibotObjective::Time => seconds * 1e3,
        DimibotObjective::Energy => energy_j * 1e3,
    };
    plan.bound = plan.cost;
    plan.states = states;
    cell
}

fn state(facts: &DimibotFacts, t_ns: u64, cell: LatticeCell) -> TimedState {
    let state = State::Dimibot(DimibotState {
        word: facts.word(cell),
        cell: [cell.x, cell.y],
        position_um: facts.place_um(cell),
    });
    TimedState { t_ns, state }
}

/// Side, module and whether the module is set, from a channel's name.
fn parsed(schedule: &Schedule, channel: u32) -> (Side, u32, bool) {
    let name = schedule.channels[channel as usize].name.split('.').collect::<Vec<_>>();
    let side = if name[1].starts_with("bl") { Side::Left } else { Side::Right };
    (side, name[1][2..].parse().expect("a number"), name[2] == "set")
}
