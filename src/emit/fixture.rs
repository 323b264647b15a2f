//! Small hand-made schedules for the tests of the formats.

use super::Provenance;
use crate::claims::dimibot::{
    Asked, DimibotAction, DimibotMethod, DimibotObjective, DimibotObstacle, DimibotObstacleBody, DimibotOrder,
    DimibotPlanner, DimibotStep as Claim, DimibotStop,
};
use crate::claims::fingers::{self, FingersOrder, Section};
use crate::claims::{self, Claims, Job, Order, Timeline};
use crate::device::Kind;
use crate::device::dimibot::{DimibotFacts, LatticeCell, Side, Simultaneous, Switch, tests::femto_st};
use crate::device::fingers::{FingersFacts as Hand, Plane, fixture};
use crate::geometry::outline::Outline;
use crate::geometry::shape::{Pose, Shape};
use crate::schedule::{
    Actuation, Channel, ChannelUnit, PlanRecord, Schedule, ScheduledStep, SourceRef, State, Swing, TimedState,
    dimibot::DimibotState, fingers::FingersState, sha256,
};
use crate::source::Span;
use crate::verify::Verified;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

/// A hand-made schedule with its provenance.
#[derive(Clone)]
pub struct FixtureSchedule {
    pub verified: Verified,
    pub provenance: Provenance,
}

impl FixtureSchedule {
    /// The same schedule after a change.
    pub fn changed(self, change: impl FnOnce(&mut Schedule)) -> FixtureSchedule {
        FixtureSchedule { verified: changed(&self.verified, change), ..self }
    }
}

/// A robot of 5 + 5 modules that passes every sort of obstacle: nine pulses of 15 ms without rests.
pub fn fetch() -> FixtureSchedule {
    let bot = Robot { device: "bot", facts: facts(5, 5, 0), wired: true };
    build("fetch", &[(bot, vec![LatticeCell { x: 19, y: 28 }, LatticeCell { x: 7, y: 14 }], 0)])
}

/// A step of the first plan, on the first line of its file.
fn named_step(task: &str, text: &str, file: &str) -> ScheduledStep {
    ScheduledStep {
        task: task.to_owned(),
        plan: 0,
        text: text.to_owned(),
        file: file.to_owned(),
        line: 1,
        column: 1,
        start_ns: 0,
        duration_ns: 0,
        reached: Vec::new(),
        operations: Vec::new(),
        span: Span::default(),
    }
}

/// Two robots of different sizes at the same time; the second rests 2.5 ms after each pulse and starts later.
pub fn pair() -> FixtureSchedule {
    let bot = Robot { device: "bot", facts: facts(5, 5, 0), wired: true };
    let aid = Robot { device: "Aid", facts: facts(3, 2, 2_500_000), wired: false };
    let way = vec![LatticeCell { x: 5, y: 2 }, LatticeCell { x: 0, y: 0 }];
    build("Pair", &[(bot, vec![LatticeCell { x: 19, y: 28 }], 0), (aid, way, 7_500_000)])
}

/// The largest robot: 20 + 20 modules, 80 channels.
pub fn large() -> FixtureSchedule {
    let bot = Robot { device: "bot", facts: facts(20, 20, 1_000_000), wired: true };
    let way = (0..40).map(|i| LatticeCell { x: (0x0005_5555 * i) % (1 << 20), y: (0x000a_bcde * i) % (1 << 20) });
    build("large", &[(bot, way.collect(), 0)])
}

/// A schedule without a single pulse.
pub fn idle() -> FixtureSchedule {
    build("idle", &[(Robot { device: "bot", facts: facts(1, 1, 0), wired: false }, Vec::new(), 0)])
}

/// A verified schedule after a change, assumed to be still verified.
pub fn changed(verified: &Verified, change: impl FnOnce(&mut Schedule)) -> Verified {
    let mut schedule = verified.schedule().clone();
    change(&mut schedule);
    Verified::assume(schedule, verified.claims().clone())
}

struct Robot {
    device: &'static str,
    facts: DimibotFacts,
    wired: bool,
}

fn facts(left: u32, right: u32, rest_ns: u64) -> DimibotFacts {
    DimibotFacts { rest_ns, repeatability_um: 0.05, tip_radius_um: 0.1, ..femto_st(left, right) }
}

fn build(name: &str, runs: &[(Robot, Vec<LatticeCell>, u64)]) -> FixtureSchedule {
    let text = format!("// {name} µ\ntask {name} on bot {{ }}\n");
    let mut schedule = Schedule {
        holds: Vec::new(),
        bench: Default::default(),
        name: name.to_owned(),
        source: SourceRef { file: format!("{name}.twz"), sha256: sha256(&text), settings: Vec::new() },
        duration_ns: 0,
        channels: Vec::new(),
        actuations: Vec::new(),
        steps: Vec::new(),
        plans: Vec::new(),
    };
    let timeline = Timeline::Together((0..runs.len()).map(Timeline::Run).collect());
    let mut claims = claims::fixture::claims(name, Vec::new(), timeline);
    for (robot, way, start_ns) in runs {
        add_channels(&mut schedule, &mut claims, robot);
        claims.jobs.push(job(robot, way));
        add_plan(&mut schedule, robot, way, *start_ns);
    }
    schedule.actuations.sort_by_key(|actuation| (actuation.start_ns, actuation.channel));
    let files = vec![(format!("{name}.twz"), text), ("lab/bench.twz".to_owned(), "scene bench { }\n".to_owned())];
    let provenance = Provenance { files, settings: vec!["pitch=80um".to_owned()], is_recorded: false };
    FixtureSchedule { verified: Verified::assume(schedule, claims), provenance }
}

/// An unwired voltage channel.
fn voltage(name: String, device: &str) -> Channel {
    Channel { name, device: device.to_owned(), unit: ChannelUnit::Volt, wire: None, rest_v: 0.0 }
}

fn add_channels(schedule: &mut Schedule, claims: &mut Claims, robot: &Robot) {
    for side in [Side::Left, Side::Right] {
        for module in 0..robot.facts.modules(side) {
            for switch in [Switch::Set, Switch::Reset] {
                let name = format!("{}.{}", robot.device, DimibotFacts::channel(side, module, switch));
                let line = schedule.channels.len();
                let wire = robot.wired.then(|| format!("Dev1/port{}/line{}", line / 8, line % 8));
                if let Some(wire) = &wire {
                    claims.wires.insert(name.clone(), wire.clone());
                }
                schedule.channels.push(Channel { wire, ..voltage(name, robot.device) });
            }
        }
    }
}

fn job(robot: &Robot, way: &[LatticeCell]) -> Job {
    let stop = |cell: &LatticeCell| DimibotStop { asked: Asked::Cell, cell: *cell, span: Span::default() };
    let step = |cell: &LatticeCell| Claim { action: DimibotAction::Move(vec![stop(cell)]), span: Span::default() };
    let order = DimibotOrder {
        facts: robot.facts.clone(),
        frame: None,
        obstacles: std::sync::Arc::new(obstacles()),
        objective: DimibotObjective::Distance,
        planner: DimibotPlanner { method: DimibotMethod::StagedAstar, expansions: 1000 },
        simultaneous: Simultaneous::Never,
        precision_um: Some(0.25),
        start: None,
        steps: way.iter().map(step).collect(),
    };
    claims::fixture::job(&format!("go_{}", robot.device), robot.device, Order::Dimibot(order))
}

fn obstacles() -> Vec<DimibotObstacle> {
    let angle = vec![[0.0, 0.0], [2.0, 0.0], [2.0, 0.5], [0.5, 0.5], [0.5, 2.0], [0.0, 2.0]];
    let solids = [
        ("bead", Shape::Disc { radius_um: 0.8 }, Pose::at(4.0, 2.5)),
        ("slide", Shape::Box { size_um: [4.0, 0.5] }, Pose { x_um: 10.0, y_um: 3.0, heading_rad: 0.5 }),
        ("angle", Shape::Polygon { points_um: angle }, Pose::at(9.0, 9.0)),
        ("hair", Shape::Capsule { length_um: 2.0, radius_um: 0.2 }, Pose::at(2.0, 8.0)),
        ("speck", Shape::Point, Pose::at(6.0, 11.0)),
    ];
    let solids = solids.into_iter().map(|(name, shape, pose)| (name, DimibotObstacleBody::Solid { shape, pose }));
    let dust = DimibotObstacleBody::Cells { from: LatticeCell { x: 12, y: 7 }, to: LatticeCell { x: 13, y: 7 } };
    let all = solids.chain([("dust", dust)]);
    all.map(|(name, body)| DimibotObstacle { name: name.to_owned(), body, span: Span::default() }).collect()
}

/// Switches modules one after the other until each cell is reached.
fn add_plan(schedule: &mut Schedule, robot: &Robot, way: &[LatticeCell], start_ns: u64) {
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
        let named = named_step(&format!("go_{}", robot.device), &format!("move to {goal}"), &schedule.source.file);
        let (start_ns, duration_ns) = (begin_ns, t_ns - begin_ns);
        schedule.steps.push(ScheduledStep { plan, line, column: 3, start_ns, duration_ns, ..named });
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
        outcomes: BTreeMap::from([("time_ns".to_owned(), (t_ns - start_ns) as f64)]),
        start_ns,
        duration_ns: t_ns - start_ns,
        states,
        remarks: Vec::new(),
    });
}

fn timed(facts: &DimibotFacts, cell: LatticeCell, t_ns: u64) -> TimedState {
    let state = DimibotState { word: facts.word(cell), cell: [cell.x, cell.y], position_um: facts.place_um(cell) };
    TimedState { t_ns, state: State::Dimibot(state) }
}

/// One device of 301 channels, too many for a field each; three of them change, some on slopes.
pub fn crowd() -> FixtureSchedule {
    idle().changed(|schedule| {
        schedule.name = "crowd".to_owned();
        schedule.duration_ns = 1000;
        let channel = |i| voltage(format!("bot.e{i}"), "bot");
        schedule.channels = (0..301).map(channel).collect();
        schedule.steps = vec![ScheduledStep { duration_ns: 1000, ..named_step("go_bot", "wait 1 us", "crowd.twz") }];
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
    })
}

/// A bed of microrobots: five drive trains with the levels between them, and a rest.
pub fn bed() -> FixtureSchedule {
    let (claims, schedule) = crate::lower::microrobots::tests::bed();
    let files = vec![("bed.twz".to_owned(), crate::lower::microrobots::tests::SOURCE.to_owned())];
    let provenance = Provenance { files, settings: Vec::new(), is_recorded: false };
    FixtureSchedule { verified: Verified::assume(schedule, claims), provenance }
}

/// The same bed with a single drive train of `strokes` strokes of 50 us.
pub fn train(strokes: u64) -> FixtureSchedule {
    bed().changed(|schedule| {
        schedule.actuations.truncate(3);
        schedule.steps.truncate(1);
        schedule.actuations[2].duration_ns = strokes * 50_000;
        schedule.duration_ns = schedule.actuations[2].end_ns();
    })
}

/// Two channels of one device that swing at different periods, one of them with levels of one nanosecond, and a third
/// that does not swing.
pub fn paces() -> FixtureSchedule {
    idle().changed(|schedule| {
        schedule.name = "paces".to_owned();
        schedule.duration_ns = 100;
        let channel = |i| voltage(format!("bot.e{i}"), "bot");
        schedule.channels = (0..3).map(channel).collect();
        let crowd = crowd().verified;
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
    })
}

/// The bed, plus a stage that moves there and back at instants of its own.
pub fn mixed() -> FixtureSchedule {
    bed().changed(|schedule| {
        schedule.name = "mixed".to_owned();
        let channel = schedule.channels.len() as u32;
        let (name, device) = ("hand.f1.x".to_owned(), "hand".to_owned());
        schedule.channels.push(Channel {
            name,
            device,
            unit: ChannelUnit::Micrometre,
            wire: Some("stage1/x".to_owned()),
            rest_v: 0.0,
        });
        let go = |start_ns, duration_ns, from, to| Actuation {
            channel,
            start_ns,
            duration_ns,
            from,
            to,
            swing: None,
            step: 0,
        };
        let way = [go(1_000_001, 20_000_000, -3.0, 12.0), go(21_000_001, 5_000_000, 12.0, 12.0)];
        schedule.actuations.extend(way.into_iter().chain([go(40_000_000, 20_333_333, 12.0, 5.5)]));
        schedule.actuations.sort_by_key(|actuation| (actuation.start_ns, actuation.channel));
    })
}

/// Radii of the ball and of the fingertips of [`hand`], and the number of contacts on the ball.
const BALL_UM: f64 = 14.0;
const TIP_UM: f64 = 4.5;
const CONTACTS: u32 = 74;

/// Distance of the free tips of [`hand`] from the middle of the ball.
const FREE_UM: f64 = 28.5;

/// Rotation of the ball from one contact to the next.
fn step_rad() -> f64 {
    TAU * (1.0 + BALL_UM / TIP_UM) / f64::from(CONTACTS)
}

/// Three fingers that turn a ball by two steps, one finger taking the place of another, and lift it. The run begins 7
/// ms after the schedule and ends 3 ms before it.
pub fn hand() -> FixtureSchedule {
    let verified = idle().verified;
    let text = "task turn on hand { }\n";
    let mut schedule = verified.schedule().clone();
    schedule.name = "turn".to_owned();
    schedule.source.file = "turn.twz".to_owned();
    schedule.source.sha256 = sha256(text);
    let facts = hand_facts();
    let wire = |name: &str| (name == "f1.x").then(|| "stage1/x".to_owned());
    let channel = |name: String| Channel {
        name: format!("hand.{name}"),
        device: "hand".to_owned(),
        unit: ChannelUnit::Micrometre,
        wire: wire(&name),
        rest_v: 0.0,
    };
    schedule.channels = facts.channels().into_iter().map(channel).collect();
    let mut hand = Gesture::new();
    hand.perform();
    schedule.duration_ns = hand.t_ns + 3_000_000;
    schedule.actuations = hand.actuations;
    schedule.actuations.sort_by_key(|actuation| (actuation.start_ns, actuation.channel));
    schedule.steps = hand.steps;
    schedule.plans = vec![PlanRecord {
        task: "turn".to_owned(),
        device: "hand".to_owned(),
        kind: Kind::Fingers,
        planner: "by hand".to_owned(),
        objective: "effort".to_owned(),
        unit: "deg".to_owned(),
        cost: 440.0,
        bound: 400.0,
        optimal: false,
        bounds: Default::default(),
        outcomes: BTreeMap::from([("reconfigurations".to_owned(), 2.0)]),
        start_ns: 7_000_000,
        duration_ns: hand.t_ns - 7_000_000,
        states: hand.states,
        remarks: Vec::new(),
    }];
    let mut claims = verified.claims().clone();
    claims.name = "turn".to_owned();
    claims.wires = BTreeMap::from([("hand.f1.x".to_owned(), "stage1/x".to_owned())]);
    claims.jobs = vec![claims::fixture::job("turn", "hand", Order::Fingers(hand_order(facts)))];
    let provenance =
        Provenance { files: vec![("turn.twz".to_owned(), text.to_owned())], settings: Vec::new(), is_recorded: false };
    FixtureSchedule { verified: Verified::assume(schedule, claims), provenance }
}

fn hand_facts() -> Hand {
    Hand {
        tip_radius_um: TIP_UM,
        clearance_um: 0.5,
        retract_um: 2.0,
        speed_um_per_s: 1000.0,
        approach_um_per_s: 100.0,
        rolling_um_per_s: 200.0,
        support_un: 3.0,
        range_um: [60.0; 3],
        ..fixture::hand()
    }
}

fn hand_order(facts: Hand) -> FingersOrder {
    let outline = Outline::Ellipse { semi_um: [BALL_UM; 2] };
    let section = Section { outline, contacts: CONTACTS, opposite: Some(1 + CONTACTS / 2), step_rad: step_rad() };
    let actions = [
        fingers::FingersAction::Grasp(Some(vec![1, 38, 0])),
        fingers::FingersAction::Rotate { plane: Plane::Xy, steps: 2, angle_rad: 2.0 * step_rad() },
        fingers::FingersAction::Translate([0.0, 0.0, 5.0]),
        fingers::FingersAction::Wait(50_000_000),
    ];
    let steps = actions.into_iter().map(|action| fingers::FingersStep { action, span: Span::default() }).collect();
    let mut order = claims::fixture::hand_order(facts, steps);
    let part = std::sync::Arc::make_mut(&mut order.part);
    part.xy = section.clone();
    part.xz = Some(section);
    FingersOrder { expansions: 1, ..order }
}

/// Motion of three fingers, move by move.
struct Gesture {
    t_ns: u64,
    tips_um: [[f64; 3]; 3],
    /// Contact that each finger holds, from 1; 0 for a free finger.
    grasp: [u32; 3],
    turned: i64,
    height_um: f64,
    actuations: Vec<Actuation>,
    steps: Vec<ScheduledStep>,
    states: Vec<TimedState>,
}

/// A point on a circle around the axis of the ball.
fn on_circle(angle_rad: f64, radius_um: f64, height_um: f64) -> [f64; 3] {
    [angle_rad.cos() * radius_um, angle_rad.sin() * radius_um, height_um]
}

impl Gesture {
    fn new() -> Gesture {
        let homes = [0.0, TAU / 3.0, 2.0 * TAU / 3.0].map(|angle_rad| on_circle(angle_rad, FREE_UM, 0.0));
        let (actuations, steps, states) = (Vec::new(), Vec::new(), Vec::new());
        Gesture { t_ns: 7_000_000, tips_um: homes, grasp: [0; 3], turned: 0, height_um: 0.0, actuations, steps, states }
    }

    fn perform(&mut self) {
        self.record();
        self.step("grasp bead at (1, 38, 0)");
        self.to(100, 0, on_circle(0.0, BALL_UM + TIP_UM, 0.0));
        self.arc(1, [TAU / 3.0, PI], 80);
        self.to(100, 1, on_circle(PI, BALL_UM + TIP_UM, 0.0));
        self.grasp = [1, 38, 0];
        self.record();
        self.step("rotate bead by 40 deg about z");
        self.roll();
        let angle_rad = self.angle_rad(57);
        self.arc(2, [2.0 * TAU / 3.0, angle_rad], 80);
        self.to(100, 2, on_circle(angle_rad, BALL_UM + TIP_UM, 0.0));
        self.grasp[2] = 57;
        self.record();
        let angle_rad = self.angle_rad(self.grasp[1]);
        self.to(100, 1, on_circle(angle_rad, FREE_UM, 0.0));
        self.grasp[1] = 0;
        self.record();
        self.roll();
        self.step("translate bead by (0 um, 0 um, 5 um)");
        self.height_um = 5.0;
        self.go(50_000_000, self.tips_um.map(|[x, y, _]| [x, y, 5.0]));
        self.record();
        self.step("wait 50 ms");
        self.go(50_000_000, self.tips_um);
        self.end_step();
    }

    /// Current angle of a contact in the hand's frame.
    fn angle_rad(&self, contact: u32) -> f64 {
        f64::from(contact - 1) * TAU / f64::from(CONTACTS) + self.turned as f64 * step_rad()
    }

    /// Rolls all holding fingers by one step.
    fn roll(&mut self) {
        let angles_rad = self.grasp.map(|contact| self.angle_rad(contact.max(1)));
        for chord in 1..=4 {
            let rolled_rad = f64::from(chord) / 4.0 * (step_rad() - TAU / f64::from(CONTACTS));
            let mut tips_um = self.tips_um;
            for finger in (0..3).filter(|finger| self.grasp[*finger] > 0) {
                tips_um[finger] = on_circle(angles_rad[finger] + rolled_rad, BALL_UM + TIP_UM, 0.0);
            }
            self.go(25_000_000, tips_um);
        }
        self.turned += 1;
        self.grasp = self.grasp.map(|contact| if contact == 1 { CONTACTS } else { contact.saturating_sub(1) });
        self.record();
    }

    fn arc(&mut self, finger: usize, [from_rad, to_rad]: [f64; 2], milliseconds: u64) {
        for chord in 1..=4 {
            let angle_rad = from_rad + (to_rad - from_rad) * f64::from(chord) / 4.0;
            self.to(milliseconds / 4, finger, on_circle(angle_rad, FREE_UM, 0.0));
        }
    }

    fn to(&mut self, milliseconds: u64, finger: usize, tip_um: [f64; 3]) {
        let mut tips_um = self.tips_um;
        tips_um[finger] = tip_um;
        self.go(milliseconds * 1_000_000, tips_um);
    }

    fn go(&mut self, duration_ns: u64, tips_um: [[f64; 3]; 3]) {
        let step = self.steps.len() as u32 - 1;
        let ends = self.tips_um.into_iter().flatten().zip(tips_um.into_iter().flatten());
        for (channel, (from, to)) in (0..).zip(ends) {
            let start_ns = self.t_ns;
            let last = self.actuations.iter_mut().rfind(|last| last.channel == channel && last.step == step);
            match last.filter(|last| last.from == last.to && from == to) {
                Some(last) => last.duration_ns += duration_ns,
                None => self.actuations.push(Actuation { channel, start_ns, duration_ns, from, to, swing: None, step }),
            }
        }
        (self.t_ns, self.tips_um) = (self.t_ns + duration_ns, tips_um);
    }

    fn step(&mut self, text: &str) {
        self.end_step();
        self.steps.push(ScheduledStep { start_ns: self.t_ns, ..named_step("turn", text, "turn.twz") });
    }

    fn end_step(&mut self) {
        if let Some(step) = self.steps.last_mut() {
            step.duration_ns = self.t_ns - step.start_ns;
        }
    }

    fn record(&mut self) {
        let (sin, cos) = (self.turned as f64 * step_rad() / 2.0).sin_cos();
        let tips = self.grasp.iter().zip(self.tips_um);
        let state = State::Fingers(FingersState {
            grasp: self.grasp.to_vec(),
            angle_index: 1 + self.turned,
            plane: Plane::Xy,
            tips_um: tips.map(|(contact, tip_um)| (*contact > 0).then_some(tip_um)).collect(),
            position_um: [0.0, 0.0, self.height_um],
            orientation: [cos, 0.0, 0.0, sin],
        });
        self.states.push(TimedState { t_ns: self.t_ns, state });
    }
}
