//! Recordings of controlled runs: those of a bed within its error bounds are accepted, and each edit is refused by the
//! rule that it breaks.
//!
//! The simulated bed keeps the bounds on the device's errors, and its robots are moved by other code than the judge's,
//! so that refusing one of its runs would be a false alarm. `TWEEZE_ORACLE_CASES=1000` runs more trials.

use super::random::cases;
use super::support::Folder;
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;
use tweeze::check::Options;
use tweeze::claims::microrobots::{MicrorobotsAction, MicrorobotsObstacle, MicrorobotsOrder};
use tweeze::claims::{Claims, Order, Relation, Requirement};
use tweeze::compile::{self, ProgramSource};
use tweeze::device::microrobots::control::ControlPhase;
use tweeze::diagnostic::Sink;
use tweeze::geometry::{Pose, Shape};
use tweeze::lower::microrobots::command::command_line;
use tweeze::plan::microrobots::MicrorobotsMotion;
use tweeze::plan::microrobots::control::{Command, Controller, Pilot};
use tweeze::plan::microrobots::simulation::{Disturbances, SimulatedBed};
use tweeze::plan::{self, Motion};
use tweeze::schedule::control::{CommandLine, CommandWord, ControlLine, MeasuredLine, SegmentLine};
use tweeze::schedule::microrobots::RecordedPose;
use tweeze::source::{Sources, Span};
use tweeze::verify::microrobots::recorded::{RecordedRun, Tolerances, judge};
use tweeze::verify::{Rule, Violation};

/// A program with three robots and the given steps.
fn program(steps: &str) -> String {
    format!(
        "use std.microrobots
device fleet : microrobots.bed {{
  robots: table {{
    robot | snap_down [V] | release [V] | turning_radius [um] | speed [um/s]
    D1    | 110           | 20          | 162                 | 200
    D2    | 122           | 33          | 160                 | 195
    D3    | 134           | 46          | 165                 | 205
  }}
  margin: 4 V
}}
scene field {{
  robot D1 at pose(4 mm, -0.5 mm, 90 deg)
  robot D2 at pose(3.5 mm, 3 mm, 0 deg)
  robot D3 at pose(-0.5 mm, 3 mm, 180 deg)
}}
task joined on fleet in field {{
{steps}
}}
"
    )
}

pub const TRIO: &str = "  apply state 0 for 1 s
  wait 300 ms
  assemble {
    D3 to pose(1.60 mm, 1.20 mm, 90 deg)
    D2 to pose(1.60 mm, 1.46 mm, 270 deg)
    D1 to pose(1.76 mm, 1.34 mm, 180 deg)
  }";

pub const DRIVEN: &str = "  drive D1 to pose(5 mm, 0 mm, 90 deg) via pose(6 mm, 1 mm, 0 deg)
  assemble {
    D3 to pose(1.60 mm, 1.20 mm, 90 deg)
    D2 to pose(1.60 mm, 1.46 mm, 270 deg)
  }";

/// A program with its plan.
pub struct Bench {
    claims: Claims,
    sources: Sources,
}

impl Bench {
    pub fn of(steps: &str) -> Bench {
        let (mut sources, mut sink) = (Sources::default(), Sink::default());
        let (text, options) = (program(steps), Options::default());
        let request =
            ProgramSource { name: "test.twz", text: &text, library: &Folder(Path::new(".")), options: &options };
        let checked = compile::check_program(&request, &mut sources, &mut sink).expect("a program without errors");
        let claims = checked.claims.into_iter().next().expect("a task");
        Bench { claims, sources }
    }

    pub fn order(&self) -> &MicrorobotsOrder {
        MicrorobotsOrder::of(&self.claims.jobs[0].order).expect("an order of microrobots")
    }

    /// The plan, if one is found.
    pub fn planned(&self) -> Option<MicrorobotsMotion> {
        let plans = plan::plan(&self.claims, &mut Sink::default(), &mut |_, _, _| ())?;
        let Motion::Microrobots(planned) = &plans.first()?.motion else { panic!("a motion of microrobots") };
        Some(planned.motion.clone())
    }

    pub fn motion(&self) -> MicrorobotsMotion {
        self.planned().expect("a plan")
    }

    /// The lines of some trials, and whether each succeeded.
    fn trials(&self, disturbances: Disturbances, trials: u64) -> Vec<(Vec<ControlLine>, bool)> {
        let (order, motion) = (self.order(), self.motion());
        let bed = SimulatedBed::new(order, &motion, disturbances).expect("an assembly");
        let text_lines: Vec<u32> = order.steps.iter().map(|step| self.sources.position(step.span).line).collect();
        let trial = |index: u64| {
            let controller = Controller::new(order, &motion).expect("errors are stated");
            let mut recorder = RecordingPilot { order, controller, text_lines: text_lines.clone(), lines: Vec::new() };
            let ended = bed.trial(3, index, &mut recorder);
            (recorder.lines, ended.failure.is_none())
        };
        (0..trials).map(trial).collect()
    }

    fn judged(&self, lines: &[ControlLine], tolerances: Tolerances) -> Result<RecordedRun, Vec<Violation>> {
        let lines: Vec<&ControlLine> = lines.iter().collect();
        judge(&lines, &self.claims, &self.sources, tolerances)
    }

    /// The rules that lines break.
    fn broken(&self, lines: &[ControlLine]) -> BTreeSet<Rule> {
        self.judged(lines, Tolerances::default()).err().into_iter().flatten().map(|violation| violation.rule).collect()
    }

    /// The bench with changed claims.
    fn changed(&self, change: impl FnOnce(&mut MicrorobotsOrder)) -> Bench {
        let mut claims = self.claims.clone();
        let Order::Microrobots(order) = &mut claims.jobs[0].order else { panic!("an order of microrobots") };
        change(order);
        Bench { claims, sources: self.sources.clone() }
    }
}

/// A controller that records its exchange.
struct RecordingPilot<'a> {
    order: &'a MicrorobotsOrder,
    controller: Controller<'a>,
    text_lines: Vec<u32>,
    lines: Vec<ControlLine>,
}

impl Pilot for RecordingPilot<'_> {
    fn observe(&mut self, measured: &[Option<Pose>], now_ns: u64) -> Command<'_> {
        let robots = measured.iter().enumerate();
        let robots =
            robots.map(|(robot, pose)| (self.order.robot(robot).name.clone(), pose.map(RecordedPose::from))).collect();
        self.lines.push(ControlLine::Measured(MeasuredLine { t_ns: now_ns, robots }));
        self.controller.observe(measured, now_ns);
        let line = command_line(self.order, &self.text_lines, &self.controller, now_ns);
        self.lines.push(ControlLine::Command(line));
        self.controller.last()
    }

    fn step(&self) -> usize {
        self.controller.step()
    }

    fn phase(&self) -> ControlPhase {
        self.controller.phase()
    }
}

/// A drive with errors ends as near as the errors allow, which is farther than the task asks.
const DRIVEN_TOLERANCES: Tolerances = Tolerances { path_um: 0.0, goal_um: 1000.0, heading_rad: 3.2, time_ns: 0 };

#[test]
fn runs_of_a_bed_within_its_errors_are_accepted() {
    for (steps, tolerances) in [(TRIO, Tolerances::default()), (DRIVEN, DRIVEN_TOLERANCES)] {
        let bench = Bench::of(steps);
        let mut accepted = 0;
        let late = Disturbances { delay_ns: 50_000_000, ..Disturbances::default() };
        let trials = bench.trials(Disturbances::default(), cases(40) / 2).into_iter();
        for (index, (lines, succeeded)) in trials.chain(bench.trials(late, cases(40) / 2)).enumerate() {
            match bench.judged(&lines, tolerances) {
                Ok(run) => {
                    assert!(run.set_aside == 0 && run.measurements * 2 == lines.len() as u64, "{index}: {run:?}");
                    assert_eq!(run.goals.len(), 3, "{index}: {run:?}");
                    accepted += 1;
                }
                Err(violations) => {
                    let rules: Vec<Rule> = violations.iter().map(|violation| violation.rule).collect();
                    assert!(!succeeded && rules == [Rule::GivenUp], "{index}: {violations:?}");
                }
            }
        }
        assert!(accepted * 2 >= cases(40), "{accepted}");
    }
}

/// Lost and wrong measurements are set aside if nothing was done about them; otherwise the reaction breaks the path
/// rule.
#[test]
fn disturbances_are_set_aside_or_named() {
    let bench = Bench::of(TRIO);
    let (mut set_aside, mut strayed) = (0, 0);
    let camera = Disturbances { lost: 0.01, wrong: 0.005, ..Disturbances::default() };
    for (lines, _) in bench.trials(camera, cases(20)) {
        match bench.judged(&lines, Tolerances::default()) {
            Ok(run) => set_aside += run.set_aside,
            Err(violations) => {
                let allowed = [Rule::GivenUp, Rule::Path, Rule::Meet];
                assert!(violations.iter().all(|violation| allowed.contains(&violation.rule)), "{violations:?}");
            }
        }
    }
    let slips = Disturbances { stalls: 0.02, slips: 0.02, ..Disturbances::default() };
    for (lines, _) in bench.trials(slips, cases(20)) {
        strayed += u64::from(bench.broken(&lines).contains(&Rule::Path));
    }
    assert!(set_aside > 0 && strayed * 10 >= cases(20) * 8, "{set_aside} set aside, {strayed} strayed");
}

/// The driving commands among some lines, with their indices.
fn drives<'l>(lines: &'l mut [ControlLine]) -> Vec<(usize, &'l mut CommandLine)> {
    let command = |(at, line): (usize, &'l mut ControlLine)| match line {
        ControlLine::Command(command) if command.segments.as_ref().is_some_and(|segments| !segments.is_empty()) => {
            Some((at, command))
        }
        ControlLine::Command(_) | ControlLine::Measured(_) => None,
    };
    lines.iter_mut().enumerate().filter_map(command).collect()
}

fn segments(command: &mut CommandLine) -> &mut Vec<SegmentLine> {
    command.segments.as_mut().expect("a drive has segments")
}

fn moved(line: &mut ControlLine, robot: &str, by_um: f64) {
    let ControlLine::Measured(measured) = line else { panic!("a measurement") };
    let pose = measured.robots.get_mut(robot).and_then(Option::as_mut).expect("a robot of the scene");
    pose.x_um += by_um;
}

/// The recording of a successful trial.
fn good(bench: &Bench) -> Vec<ControlLine> {
    good_within(bench, Tolerances::default())
}

type Edit = (&'static str, Rule, fn(&mut Vec<ControlLine>));

const EDITS: [Edit; 22] = [
    ("a command is missing", Rule::Exchange, |lines| drop(lines.remove(21))),
    ("a measurement is missing", Rule::Exchange, |lines| drop(lines.remove(20))),
    ("a command has another time", Rule::Exchange, |lines| drives(lines)[9].1.t_ns += 1),
    ("a command ends later", Rule::Exchange, |lines| {
        let mut drives = drives(lines);
        drives[9].1.until_ns = drives[9].1.until_ns.map(|until_ns| until_ns + 1);
    }),
    ("a command has another line", Rule::Exchange, |lines| drives(lines)[9].1.line = Some(1)),
    ("a command is of a later step", Rule::Exchange, |lines| drives(lines)[0].1.step = 2),
    ("a step comes back", Rule::Exchange, |lines| {
        let mut drives = drives(lines);
        let (step, line) = (drives[0].1.step, drives[0].1.line);
        let last = drives.len() - 1;
        (drives[last].1.step, drives[last].1.line) = (step, line);
    }),
    ("a robot of another scene is driven", Rule::Exchange, |lines| drives(lines)[9].1.driven.push("D9".to_owned())),
    ("a robot is docked before its step", Rule::Exchange, |lines| drives(lines)[0].1.docked.push("D1".to_owned())),
    ("a docked robot is free again", Rule::Exchange, |lines| {
        let mut drives = drives(lines);
        let last = drives.len() - 1;
        drives[last].1.docked.clear();
    }),
    ("an unknown robot is measured", Rule::Exchange, |lines| {
        let ControlLine::Measured(measured) = &mut lines[20] else { panic!("a measurement") };
        measured.robots.insert("D9".to_owned(), None);
    }),
    ("lines follow the end", Rule::Exchange, |lines| lines.extend_from_within(20..22)),
    ("it breaks off", Rule::GivenUp, |lines| lines.truncate(40)),
    ("it is stopped", Rule::GivenUp, |lines| {
        let Some(ControlLine::Command(last)) = lines.last_mut() else { panic!("a command") };
        last.command = CommandWord::Stop;
    }),
    ("a level is beyond the source", Rule::Level, |lines| {
        let mut drives = drives(lines);
        segments(drives[0].1)[0].levels_v[0] = 1e4;
    }),
    ("a level is missing", Rule::Control, |lines| {
        let mut turning: Vec<_> = drives(lines).into_iter().map(|(_, command)| command).collect();
        let segment = turning.iter_mut().flat_map(|command| segments(command).iter_mut());
        let long = segment.into_iter().find(|segment| segment.levels_v.len() > 1).expect("a cycle of two levels");
        long.levels_v.truncate(1);
    }),
    ("a state has another name", Rule::Control, |lines| {
        let mut drives = drives(lines);
        let segment = &mut segments(drives[9].1)[0];
        segment.state = if segment.state == "111" { "000" } else { "111" }.to_owned();
    }),
    ("a segment has no strokes", Rule::Train, |lines| segments(drives(lines)[9].1)[0].strokes = 0),
    ("an apply is shorter", Rule::Apply, |lines| segments(drives(lines)[1].1)[0].strokes -= 1),
    ("a robot jumps for one measurement that is acted upon", Rule::Path, |lines| {
        let at = drives(lines)[30].0;
        moved(&mut lines[at - 1], "D2", 40.0);
    }),
    ("a robot slips and stays there", Rule::Path, |lines| {
        let at = drives(lines)[30].0;
        (at - 1..lines.len()).step_by(2).for_each(|at| moved(&mut lines[at], "D1", 40.0));
    }),
    ("a robot is measured within another one", Rule::Path, |lines| {
        let last = lines.len() - 2;
        moved(&mut lines[last], "D1", -300.0);
    }),
];

#[test]
fn every_edit_is_refused_by_the_rule_that_it_breaks() {
    let bench = Bench::of(TRIO);
    let lines = good(&bench);
    for (name, rule, edit) in EDITS {
        let mut edited = lines.clone();
        edit(&mut edited);
        let broken = bench.broken(&edited);
        assert!(broken.contains(&rule), "{name}: {broken:?}");
    }
}

/// The same recording breaks changed claims of the program.
#[test]
fn a_recording_is_held_against_the_claims() {
    let bench = Bench::of(TRIO);
    let lines = good(&bench);
    let broken = |change: fn(&mut MicrorobotsOrder)| bench.changed(change).broken(&lines);
    let obstacle = broken(|order| {
        let pose = Pose { x_um: 1600.0, y_um: 1200.0, heading_rad: 0.0 };
        let shape = Shape::Disc { radius_um: 20.0 };
        let stone = MicrorobotsObstacle { name: "stone".to_owned(), shape, pose, span: Span::default() };
        Arc::make_mut(&mut order.obstacles).push(stone);
    });
    assert_eq!(obstacle, BTreeSet::from([Rule::Graze]));
    let larger = broken(|order| {
        let robots = Arc::make_mut(&mut order.facts);
        robots.robots.iter_mut().for_each(|robot| robot.length_um *= 1.3);
    });
    assert!(larger.contains(&Rule::Meet), "{larger:?}");
    let smaller = broken(|order| {
        let robots = Arc::make_mut(&mut order.facts);
        robots.robots.iter_mut().for_each(|robot| robot.length_um *= 0.7);
    });
    assert!(smaller.contains(&Rule::Dock), "{smaller:?}");
    let slower = broken(|order| Arc::make_mut(&mut order.facts).robots[0].step_um *= 0.9);
    assert_eq!(slower, BTreeSet::from([Rule::Path]));
    let elsewhere = broken(|order| {
        let MicrorobotsAction::Assemble(docks) = &mut order.steps[2].action else { panic!("an assembly") };
        docks[2].goal.pose.y_um += 100.0;
    });
    assert_eq!(elsewhere, BTreeSet::from([Rule::Dock]));
    let longer = broken(|order| order.steps[1].action = MicrorobotsAction::Wait(400_000_000));
    assert_eq!(longer, BTreeSet::from([Rule::Exchange]));
    let arms = broken(|order| {
        let facts = Arc::make_mut(&mut order.facts);
        facts.robots[0].snap_down_v = 60.0;
    });
    assert!(arms.contains(&Rule::Arm) || arms.contains(&Rule::Control), "{arms:?}");
    let mut hasty = bench.changed(|_| ());
    let limit =
        Requirement { outcome: "time".to_owned(), relation: Relation::AtMost, limit: 10.0, span: Span::default() };
    hasty.claims.jobs[0].requirements.push(limit);
    assert_eq!(hasty.broken(&lines), BTreeSet::from([Rule::Requirement]));
    let granted = Tolerances { time_ns: 3_600_000_000_000, ..Tolerances::default() };
    assert!(hasty.judged(&lines, granted).is_ok());
}

/// The arm of a docked robot is lowered, and a rest is replaced by a drive.
#[test]
fn docked_arms_and_rests_are_held() {
    let bench = Bench::of(TRIO);
    let lines = good(&bench);
    let mut twisted = lines.clone();
    let mut after: Vec<_> = drives(&mut twisted).into_iter().map(|(_, command)| command).collect();
    let late = after.iter_mut().rev().find(|command| !command.docked.is_empty()).expect("a drive beside docked robots");
    let late_segments = segments(late);
    // The same strokes in the state that lowers all arms.
    let states = &bench.order().states;
    let all = states.iter().find(|state| state.digits() == "111").expect("a state with all arms down");
    for segment in late_segments.iter_mut() {
        (segment.state, segment.levels_v) = (all.digits(), all.levels_v.clone());
    }
    let broken = bench.judged(&twisted, Tolerances::default()).expect_err("a docked arm is down");
    assert!(broken.iter().any(|violation| violation.rule == Rule::Twist), "{broken:?}");
    let mut driven = lines;
    let rest = driven.iter_mut().find_map(|line| match line {
        ControlLine::Command(command) if command.command == CommandWord::Rest => Some(command),
        ControlLine::Command(_) | ControlLine::Measured(_) => None,
    });
    let rest = rest.expect("a rest");
    (rest.command, rest.segments) = (CommandWord::Drive, Some(Vec::new()));
    rest.until_ns = Some(rest.t_ns + 200_000_000);
    assert!(bench.broken(&driven).contains(&Rule::Wait));
}

#[test]
fn a_driven_robot_comes_by_its_stops() {
    let bench = Bench::of(DRIVEN);
    let lines = good_within(&bench, DRIVEN_TOLERANCES);
    let strict = bench.judged(&lines, Tolerances::default()).expect_err("nothing can be driven so exactly");
    assert!(strict.iter().all(|violation| violation.rule == Rule::Goal), "{strict:?}");
    let elsewhere = bench.changed(|order| {
        let MicrorobotsAction::Drive { stops, .. } = &mut order.steps[0].action else { panic!("a drive") };
        stops[0].pose.x_um += 3000.0;
    });
    let missed = elsewhere.judged(&lines, DRIVEN_TOLERANCES).expect_err("a stop is missed");
    assert!(missed.iter().any(|violation| violation.title.contains("stop in its turn")), "{missed:?}");
}

fn good_within(bench: &Bench, tolerances: Tolerances) -> Vec<ControlLine> {
    let trials = bench.trials(Disturbances::default(), 8);
    let lines = trials.into_iter().find_map(|(lines, succeeded)| succeeded.then_some(lines)).expect("one succeeds");
    assert!(bench.judged(&lines, tolerances).is_ok());
    lines
}
