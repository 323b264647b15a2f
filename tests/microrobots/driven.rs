//! Robots that follow their commands exactly, driven by `tweeze control` among obstacles and each other: a run that
//! ends with `finished` is accepted by `tweeze verify`, and no two bodies ever overlap.

use super::guaranteed::overlap;
use super::random::Random;
use serde_json::{Value, json};
use std::f64::consts::PI;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Stdio};

const DONE: i32 = 0;
const STOPPED: i32 = 6;

/// Figures of the device in these programs.
const SPEED_UM_PER_S: f64 = 200.0;
const BODY_UM: [f64; 2] = [260.0, 60.0];

/// Distance after which moving robots are compared.
const SAMPLE_STEP_UM: f64 = 4.0;

/// A robot without errors that turns clockwise.
#[derive(Clone)]
struct ExactRobot {
    name: &'static str,
    snap_down_v: f64,
    release_v: f64,
    radius_um: f64,
    x_um: f64,
    y_um: f64,
    heading_rad: f64,
    is_down: bool,
}

impl ExactRobot {
    /// A robot of these programs; each starts at the origin.
    fn named(name: &'static str) -> Self {
        let (snap_down_v, release_v, radius_um) = match name {
            "D1" => (110.0, 20.0, 160.0),
            "D2" => (130.0, 35.0, 150.0),
            _ => (150.0, 50.0, 170.0),
        };
        ExactRobot { name, snap_down_v, release_v, radius_um, x_um: 0.0, y_um: 0.0, heading_rad: 0.0, is_down: false }
    }

    fn at(name: &'static str, x_um: f64, y_um: f64, heading_rad: f64) -> Self {
        ExactRobot { x_um, y_um, heading_rad, ..ExactRobot::named(name) }
    }

    fn row(&self) -> String {
        format!("    {} | {} | {} | {}\n", self.name, self.snap_down_v, self.release_v, self.radius_um)
    }

    fn start(&self) -> String {
        let to_deg = self.heading_rad.to_degrees();
        format!("  robot {} at pose({} um, {} um, {to_deg} deg)\n", self.name, self.x_um, self.y_um)
    }

    fn run(&mut self, way_um: f64) {
        let after_rad = self.heading_rad - if self.is_down { way_um / self.radius_um } else { 0.0 };
        if self.is_down {
            self.x_um -= self.radius_um * (after_rad.sin() - self.heading_rad.sin());
            self.y_um += self.radius_um * (after_rad.cos() - self.heading_rad.cos());
        } else {
            self.x_um += way_um * after_rad.cos();
            self.y_um += way_um * after_rad.sin();
        }
        self.heading_rad = after_rad;
    }

    fn corners(&self) -> [[f64; 2]; 4] {
        let [a_um, b_um] = BODY_UM.map(|side_um| side_um / 2.0);
        let (sin, cos) = self.heading_rad.sin_cos();
        [(a_um, b_um), (-a_um, b_um), (-a_um, -b_um), (a_um, -b_um)].map(|(along_um, left_um)| {
            [self.x_um + along_um * cos - left_um * sin, self.y_um + along_um * sin + left_um * cos]
        })
    }
}

/// A bed of robots without errors.
struct ExactBed {
    robots: Vec<ExactRobot>,
}

impl ExactBed {
    fn carry_out(&mut self, command: &Value, period_ns: f64) {
        if command["command"] == "rest" {
            self.robots.iter_mut().for_each(|robot| robot.is_down = false);
        }
        for segment in command["segments"].as_array().into_iter().flatten() {
            for level_v in segment["levels_v"].as_array().into_iter().flatten().filter_map(Value::as_f64) {
                for robot in &mut self.robots {
                    robot.is_down = level_v >= robot.snap_down_v || (robot.is_down && level_v > robot.release_v);
                }
            }
            let state: String = self.robots.iter().map(|robot| if robot.is_down { '1' } else { '0' }).collect();
            assert_eq!(segment["state"], state, "{command}");
            let way_um = segment["strokes"].as_f64().expect("a number") * period_ns * 1e-9 * SPEED_UM_PER_S;
            let samples = (way_um / SAMPLE_STEP_UM).ceil().max(1.0);
            for _ in 0..samples as u64 {
                self.robots.iter_mut().for_each(|robot| robot.run(way_um / samples));
                let bodies: Vec<_> = self.robots.iter().map(ExactRobot::corners).collect();
                for (at, body) in bodies.iter().enumerate() {
                    assert!(
                        !bodies[..at].iter().any(|other| overlap(body, other)),
                        "robots run into each other: {command}"
                    );
                }
            }
        }
    }

    /// Measurement of a camera.
    fn measured(&self) -> Value {
        let of = |robot: &ExactRobot| {
            let heading_deg = robot.heading_rad.to_degrees();
            (robot.name.to_owned(), json!({ "x_um": robot.x_um, "y_um": robot.y_um, "heading_deg": heading_deg }))
        };
        Value::Object(self.robots.iter().map(of).collect())
    }
}

/// Controls a program from these poses; returns the last answer, or `None` if there is no plan.
fn controlled(program: &Path, record: &Path, robots: Vec<ExactRobot>) -> Option<Value> {
    let mut child = Command::new(assert_cmd::cargo::cargo_bin!("tweeze"))
        .arg("control")
        .arg(program)
        .arg("--record")
        .arg(record)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("tweeze starts");
    let mut answers = BufReader::new(child.stdout.take().expect("its answers")).lines();
    let mut input = child.stdin.take().expect("its input");
    let mut next = || answers.next().map(|line| serde_json::from_str::<Value>(&line.expect("text")).expect("JSON"));
    let Some(greeting) = next() else {
        child.wait().expect("it ends");
        return None;
    };
    let period_ns = greeting["period_ns"].as_f64().expect("a period");
    let mut bed = ExactBed { robots };
    let mut t_ns = 0;
    loop {
        writeln!(input, "{}", json!({ "t_ns": t_ns, "robots": bed.measured() })).expect("it reads");
        let answer = next().expect("an answer");
        if answer["command"] == "finished" || answer["command"] == "stop" {
            let code = if answer["command"] == "finished" { DONE } else { STOPPED };
            assert_eq!(child.wait().expect("it ends").code(), Some(code));
            return Some(answer);
        }
        bed.carry_out(&answer, period_ns);
        t_ns = answer["until_ns"].as_u64().expect("an end");
    }
}

/// A program that drives robots from their poses among obstacles.
fn program_of(robots: &[ExactRobot], obstacles: &str, drives: &str) -> String {
    let rows: String = robots.iter().map(ExactRobot::row).collect();
    let starts: String = robots.iter().map(ExactRobot::start).collect();
    format!(
        "use std.microrobots\ndevice fleet : microrobots.bed {{\n  robots: table {{\n    \
         robot | snap_down [V] | release [V] | turning_radius [um]\n{rows}  }}\n}}\n\
         scene field {{\n{starts}{obstacles}}}\ntask go on fleet in field {{\n  \
         precision: 50 um\n  heading_precision: 5 deg\n{drives}}}\n"
    )
}

fn accepts(program: &Path, record: &Path) {
    let mut verify = Command::new(assert_cmd::cargo::cargo_bin!("tweeze"));
    let run = verify.arg("verify").arg(record).arg("--against").arg(program).output().expect("tweeze runs");
    let said = String::from_utf8_lossy(&run.stderr).into_owned();
    assert_eq!(run.status.code(), Some(DONE), "{said}\n{}", std::fs::read_to_string(program).unwrap_or_default());
}

/// Result of a controlled run.
enum Ended {
    /// Finished and accepted by `tweeze verify`.
    Finished,
    /// Stopped before the named thing.
    Blocked(String),
}

/// Writes a program into a folder and controls it; `None` if there is no plan.
fn ended(folder: &Path, text: &str, robots: Vec<ExactRobot>) -> Option<Ended> {
    let (program, record) = (folder.join("drive.twz"), folder.join("run.mcap"));
    std::fs::write(&program, text).expect("a program is written");
    let _ = std::fs::remove_file(&record);
    let last = controlled(&program, &record, robots)?;
    if last["command"] == "finished" {
        accepts(&program, &record);
        return Some(Ended::Finished);
    }
    assert_eq!(last["reason"], "blocked", "{last}\n{text}");
    let thing = last["in_the_way"].as_str().unwrap_or_else(|| panic!("nothing is in the way: {last}\n{text}"));
    Some(Ended::Blocked(thing.to_owned()))
}

#[test]
fn a_run_straight_ahead_begins_without_a_circle() {
    let folder = tempfile::tempdir().expect("a folder");
    let record = folder.path().join("run.mcap");
    let program = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/found/microrobots-lag-circle.twz");
    let last = controlled(&program, &record, vec![ExactRobot::named("D1")]).expect("a plan");
    assert_eq!(last["command"], "finished", "{last}");
    assert!(last["t_ns"].as_u64().is_some_and(|t_ns| t_ns < 5_500_000_000), "{last}");
    accepts(&program, &record);
}

#[test]
fn no_drive_goes_through_a_stone() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut chance = Random::new(5);
    let mut finished = 0;
    for _ in 0..CASES {
        let stones: String = (0..1 + chance.below(4))
            .map(|nth| {
                let (at_um, to_rad) = (chance.thousandths(200.0, 700.0), chance.thousandths(0.0, 2.0 * PI));
                let (x_um, y_um) = ((at_um * to_rad.cos()).round(), (at_um * to_rad.sin()).round());
                format!("  obstacle stone{nth} : disc {{ radius: 60 um }} at ({x_um} um, {y_um} um)\n")
            })
            .collect();
        let goal = match chance.below(2) {
            0 => format!("{} um, {} um, 0 deg", 600 + chance.below(900), chance.below(40)),
            _ => format!(
                "{} um, {} um, {} deg",
                chance.thousandths(-900.0, 900.0).round(),
                chance.thousandths(-900.0, 900.0).round(),
                chance.below(360)
            ),
        };
        let robots = vec![ExactRobot::named("D1")];
        let text = program_of(&robots, &stones, &format!("  drive D1 to pose({goal})\n"));
        match ended(folder.path(), &text, robots) {
            None => {}
            Some(Ended::Finished) => finished += 1,
            // A single robot among obstacles at rest finds another way.
            Some(Ended::Blocked(thing)) => panic!("it stopped before {thing}\n{text}"),
        }
    }
    assert!(3 * finished > 2 * CASES, "{finished} finished");
}

#[test]
fn no_drive_goes_through_another_robot() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut chance = Random::new(8);
    let (mut finished, mut blocked) = (0, 0);
    for _ in 0..CASES {
        let mut placed = |name, middle_um: f64| {
            let across_um = chance.thousandths(-900.0, 900.0).round();
            ExactRobot::at(
                name,
                middle_um + chance.thousandths(-150.0, 150.0).round(),
                across_um,
                f64::from(chance.below(360)).to_radians(),
            )
        };
        let robots = vec![placed("D1", -1000.0), placed("D2", 0.0), placed("D3", 1000.0)];
        let goals: String = ["D1", "D2", "D3"]
            .map(|name| {
                let [x_um, y_um] = [0; 2].map(|_| chance.thousandths(-1200.0, 1200.0).round());
                format!("  drive {name} to pose({x_um} um, {y_um} um, {} deg)\n", chance.below(360))
            })
            .concat();
        let text = program_of(&robots, "", &goals);
        match ended(folder.path(), &text, robots) {
            None => {}
            Some(Ended::Finished) => finished += 1,
            Some(Ended::Blocked(other)) => {
                blocked += 1;
                assert!(other.starts_with('D'), "{other}\n{text}");
            }
        }
    }
    println!("{finished} finished, {blocked} stopped before another robot");
    assert!(2 * finished > CASES && blocked >= 1, "{finished} finished, {blocked} stopped before another robot");
}

/// Number of random programs.
const CASES: u32 = 40;
