//! Small schedules made by hand, for the tests of the formats.

use super::Provenance;
use crate::check::claims::dimibot::{
    Action, Asked, Body, DimibotOrder, Method, Objective, Obstacle, Planner, Step as Claim, Stop,
};
use crate::check::claims::{Claims, Job, Order, Timeline};
use crate::device::Kind;
use crate::device::dimibot::tests::femto_st;
use crate::device::dimibot::{Cell, Facts, Side, Simultaneous, Switch};
use crate::geometry::shape::{Pose, Shape};
use crate::schedule::{Actuation, Channel, PlanRecord, Schedule, SourceRef, State, Step, Swing, TimedState, Unit};
use crate::source::Span;
use crate::verify::Verified;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;

/// A robot of 5 + 5 modules that goes through every sort of obstacle: nine pulses of 15 ms without rests.
pub fn fetch() -> (Verified, Provenance) {
    let bot = Robot { device: "bot", facts: facts(5, 5, 0), wired: true };
    build("fetch", &[(bot, vec![Cell { x: 19, y: 28 }, Cell { x: 7, y: 14 }], 0)])
}

/// Two robots of different sizes at the same time; the second one rests 2.5 ms after each pulse and starts later.
pub fn pair() -> (Verified, Provenance) {
    let bot = Robot { device: "bot", facts: facts(5, 5, 0), wired: true };
    let aid = Robot { device: "Aid", facts: facts(3, 2, 2_500_000), wired: false };
    let way = vec![Cell { x: 5, y: 2 }, Cell { x: 0, y: 0 }];
    build("Pair", &[(bot, vec![Cell { x: 19, y: 28 }], 0), (aid, way, 7_500_000)])
}

/// As large as they get: 20 + 20 modules, 80 channels.
pub fn large() -> (Verified, Provenance) {
    let bot = Robot { device: "bot", facts: facts(20, 20, 1_000_000), wired: true };
    let way = (0..40).map(|i| Cell { x: (0x0005_5555 * i) % (1 << 20), y: (0x000a_bcde * i) % (1 << 20) });
    build("large", &[(bot, way.collect(), 0)])
}

/// Without a single pulse.
pub fn idle() -> (Verified, Provenance) {
    build("idle", &[(Robot { device: "bot", facts: facts(1, 1, 0), wired: false }, Vec::new(), 0)])
}

/// A schedule changed by hand.
pub fn changed(verified: &Verified, change: impl FnOnce(&mut Schedule)) -> Verified {
    let mut schedule = verified.schedule().clone();
    change(&mut schedule);
    Verified::assume(schedule, verified.claims().clone())
}

struct Robot {
    device: &'static str,
    facts: Facts,
    wired: bool,
}

fn facts(left: u32, right: u32, rest_ns: u64) -> Facts {
    Facts { rest_ns, repeatability_um: 0.05, tip_radius_um: 0.1, ..femto_st(left, right) }
}

fn build(name: &str, runs: &[(Robot, Vec<Cell>, u64)]) -> (Verified, Provenance) {
    let text = format!("// {name} µ\ntask {name} on bot {{ }}\n");
    let sha256 = Sha256::digest(&text).iter().map(|byte| format!("{byte:02x}")).collect();
    let mut schedule = Schedule {
        name: name.to_owned(),
        source: SourceRef { file: format!("{name}.twz"), sha256 },
        duration_ns: 0,
        channels: Vec::new(),
        actuations: Vec::new(),
        steps: Vec::new(),
        plans: Vec::new(),
    };
    let mut claims = Claims {
        name: name.to_owned(),
        timeline: Timeline::Together((0..runs.len()).map(Timeline::Run).collect()),
        jobs: Vec::new(),
        wires: BTreeMap::new(),
        span: Span::default(),
    };
    for (robot, way, start_ns) in runs {
        add_channels(&mut schedule, &mut claims, robot);
        claims.jobs.push(job(robot, way));
        add_plan(&mut schedule, robot, way, *start_ns);
    }
    schedule.actuations.sort_by_key(|actuation| (actuation.start_ns, actuation.channel));
    let files = vec![(format!("{name}.twz"), text), ("lab/bench.twz".to_owned(), "scene bench { }\n".to_owned())];
    let provenance = Provenance { files, settings: vec!["pitch=80um".to_owned()] };
    (Verified::assume(schedule, claims), provenance)
}

fn add_channels(schedule: &mut Schedule, claims: &mut Claims, robot: &Robot) {
    for side in [Side::Left, Side::Right] {
        for module in 0..robot.facts.modules(side) {
            for switch in [Switch::Set, Switch::Reset] {
                let name = format!("{}.{}", robot.device, Facts::channel(side, module, switch));
                let line = schedule.channels.len();
                let wire = robot.wired.then(|| format!("Dev1/port{}/line{}", line / 8, line % 8));
                if let Some(wire) = &wire {
                    claims.wires.insert(name.clone(), wire.clone());
                }
                let device = robot.device.to_owned();
                schedule.channels.push(Channel { name, device, unit: Unit::Volt, wire });
            }
        }
    }
}

fn job(robot: &Robot, way: &[Cell]) -> Job {
    let stop = |cell: &Cell| Stop { asked: Asked::Cell, cell: *cell, span: Span::default() };
    let step = |cell: &Cell| Claim { action: Action::Move(vec![stop(cell)]), span: Span::default() };
    let order = DimibotOrder {
        facts: robot.facts.clone(),
        obstacles: std::sync::Arc::new(obstacles()),
        objective: Objective::Distance,
        planner: Planner { method: Method::StagedAstar, expansions: 1000 },
        simultaneous: Simultaneous::Never,
        precision_um: Some(0.25),
        start: None,
        steps: way.iter().map(step).collect(),
    };
    Job {
        task: format!("go_{}", robot.device),
        device: robot.device.to_owned(),
        requirements: Vec::new(),
        order: Order::Dimibot(order),
        span: Span::default(),
        run_span: Span::default(),
    }
}

fn obstacles() -> Vec<Obstacle> {
    let angle = vec![[0.0, 0.0], [2.0, 0.0], [2.0, 0.5], [0.5, 0.5], [0.5, 2.0], [0.0, 2.0]];
    let solids = [
        ("bead", Shape::Disc { radius_um: 0.8 }, Pose::at(4.0, 2.5)),
        ("slide", Shape::Box { size_um: [4.0, 0.5] }, Pose { x_um: 10.0, y_um: 3.0, heading_rad: 0.5 }),
        ("angle", Shape::Polygon { points_um: angle }, Pose::at(9.0, 9.0)),
        ("hair", Shape::Capsule { length_um: 2.0, radius_um: 0.2 }, Pose::at(2.0, 8.0)),
        ("speck", Shape::Point, Pose::at(6.0, 11.0)),
    ];
    let solids = solids.into_iter().map(|(name, shape, pose)| (name, Body::Solid { shape, pose }));
    let dust = Body::Cells { from: Cell { x: 12, y: 7 }, to: Cell { x: 13, y: 7 } };
    let all = solids.chain([("dust", dust)]);
    all.map(|(name, body)| Obstacle { name: name.to_owned(), body, span: Span::default() }).collect()
}

/// Switches one module after the other until each cell is reached.
fn add_plan(schedule: &mut Schedule, robot: &Robot, way: &[Cell], start_ns: u64) {
    let facts = &robot.facts;
    let first = schedule.channels.iter().position(|channel| channel.device == robot.device).unwrap_or(0);
    let plan = schedule.plans.len() as u32;
    let mut t_ns = start_ns;
    let mut cell = facts.home;
    let mut states = vec![timed(facts, cell, t_ns)];
    for (line, goal) in (3..).zip(way) {
        let step = schedule.steps.len() as u32;
        let begin_ns = t_ns;
        for module in 0..facts.left + facts.right {
            let right = module.checked_sub(facts.left);
            let bit = 1 << right.unwrap_or(module);
            let (state, goal) = if right.is_some() { (&mut cell.y, goal.y) } else { (&mut cell.x, goal.x) };
            if (*state ^ goal) & bit == 0 {
                continue;
            }
            *state ^= bit;
            let channel = first as u32 + 2 * module + u32::from(*state & bit == 0);
            let (duration_ns, volts) = (facts.pulse_duration_ns, facts.pulse_voltage_v);
            schedule.actuations.push(Actuation {
                channel,
                start_ns: t_ns,
                duration_ns,
                from: volts,
                to: volts,
                swing: None,
                step,
            });
            states.push(timed(facts, cell, t_ns + duration_ns));
            t_ns += duration_ns + facts.rest_ns;
        }
        schedule.steps.push(Step {
            task: format!("go_{}", robot.device),
            plan,
            text: format!("move to {goal}"),
            file: schedule.source.file.clone(),
            line,
            column: 3,
            start_ns: begin_ns,
            duration_ns: t_ns - begin_ns,
            span: Span::default(),
        });
    }
    schedule.duration_ns = schedule.duration_ns.max(t_ns);
    schedule.plans.push(PlanRecord {
        task: format!("go_{}", robot.device),
        device: robot.device.to_owned(),
        kind: Kind::Dimibot,
        planner: "by hand".to_owned(),
        objective: "distance".to_owned(),
        unit: "um".to_owned(),
        cost: 0.1 + 0.2,
        bound: 0.1,
        optimal: false,
        bounds: Default::default(),
        outcomes: BTreeMap::from([("time".to_owned(), (t_ns - start_ns) as f64 / 1e9)]),
        start_ns,
        duration_ns: t_ns - start_ns,
        states,
        remarks: Vec::new(),
    });
}

fn timed(facts: &Facts, cell: Cell, t_ns: u64) -> TimedState {
    let state = State::Dimibot { word: facts.word(cell), cell: [cell.x, cell.y], position_um: facts.place_um(cell) };
    TimedState { t_ns, state }
}

/// One device of 301 channels, too many for a field each, three of which change, on slopes too.
pub fn crowd() -> (Verified, Provenance) {
    let (verified, provenance) = idle();
    let crowd = changed(&verified, |schedule| {
        schedule.name = "crowd".to_owned();
        schedule.duration_ns = 1000;
        let channel = |i| Channel { name: format!("bot.e{i}"), device: "bot".into(), unit: Unit::Volt, wire: None };
        schedule.channels = (0..301).map(channel).collect();
        schedule.steps = vec![Step {
            task: "go_bot".to_owned(),
            plan: 0,
            text: "wait 1 us".to_owned(),
            file: "crowd.twz".to_owned(),
            line: 1,
            column: 1,
            start_ns: 0,
            duration_ns: 1000,
            span: Span::default(),
        }];
        let pulse = |channel, start_ns, from, to| Actuation {
            channel,
            start_ns,
            duration_ns: 300,
            from,
            to,
            swing: None,
            step: 0,
        };
        schedule.actuations = vec![
            pulse(0, 0, 1.0, 2.0),
            pulse(7, 100, -0.1, 0.3),
            pulse(0, 300, 2.0, 5.0),
            pulse(300, 500, 7.0, 7.0),
            pulse(0, 601, 3.0, 3.0),
        ];
    });
    (crowd, provenance)
}

/// A bed of microrobots: five drive trains with the levels between them, and a rest.
pub fn bed() -> (Verified, Provenance) {
    let (claims, schedule) = crate::schedule::microrobots::tests::bed();
    let files = vec![("bed.twz".to_owned(), crate::schedule::microrobots::tests::SOURCE.to_owned())];
    (Verified::assume(schedule, claims), Provenance { files, settings: Vec::new() })
}

/// The same bed with a single drive train of so many strokes of 50 us.
pub fn train(strokes: u64) -> Verified {
    let (bed, _) = bed();
    changed(&bed, |schedule| {
        schedule.actuations.truncate(3);
        schedule.steps.truncate(1);
        schedule.actuations[2].duration_ns = strokes * 50_000;
        schedule.duration_ns = schedule.actuations[2].end_ns();
    })
}

/// Two channels of one device that swing at different paces, one of them with levels of a nanosecond, beside one that does not.
pub fn paces() -> (Verified, Provenance) {
    let (verified, provenance) = idle();
    let paces = changed(&verified, |schedule| {
        schedule.name = "paces".to_owned();
        schedule.duration_ns = 100;
        let channel = |i| Channel { name: format!("bot.e{i}"), device: "bot".into(), unit: Unit::Volt, wire: None };
        schedule.channels = (0..3).map(channel).collect();
        let crowd = crowd().0;
        schedule.steps = crowd.schedule().steps.clone();
        schedule.steps[0].duration_ns = 100;
        let act = |channel, start_ns, duration_ns, from, to, period_ns: Option<u64>| Actuation {
            channel,
            start_ns,
            duration_ns,
            from,
            to,
            swing: period_ns.map(|period_ns| Swing { period_ns, levels: [from, to] }),
            step: 0,
        };
        schedule.actuations = vec![
            act(0, 0, 30, 5.0, -2.5, Some(6)),
            act(1, 0, 7, 4.0, 4.0, None),
            act(1, 8, 20, 1.0, 3.0, Some(10)),
            act(2, 10, 80, 1.5, 1.5, None),
            act(0, 30, 20, 2.0, 2.0, None),
            act(1, 40, 12, 8.0, 6.0, Some(2)),
            act(0, 60, 40, 0.0, 1.0, Some(20)),
        ];
    });
    (paces, provenance)
}
