//! A robot that follows its commands exactly, driven by `tweeze control` among stones: what ends with `finished` is accepted by `tweeze verify`.

use super::random::Random;
use serde_json::{Value, json};
use std::f64::consts::PI;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Stdio};

const DONE: i32 = 0;
const STOPPED: i32 = 6;

/// Of the device in the programs here.
const RADIUS_UM: f64 = 160.0;
const SPEED_UM_PER_S: f64 = 200.0;
const SNAP_DOWN_V: f64 = 110.0;
const RELEASE_V: f64 = 20.0;

/// A bed with one robot that turns clockwise and has no errors.
struct ExactBed {
    x_um: f64,
    y_um: f64,
    heading_rad: f64,
    is_down: bool,
}

impl ExactBed {
    fn carry_out(&mut self, command: &Value, period_ns: f64) {
        if command["command"] == "rest" {
            self.is_down = false;
        }
        for segment in command["segments"].as_array().into_iter().flatten() {
            for level_v in segment["levels_v"].as_array().into_iter().flatten().filter_map(Value::as_f64) {
                self.is_down = level_v >= SNAP_DOWN_V || (self.is_down && level_v > RELEASE_V);
            }
            assert_eq!(segment["state"], if self.is_down { "1" } else { "0" }, "{command}");
            let way_um = segment["strokes"].as_f64().expect("a number") * period_ns * 1e-9 * SPEED_UM_PER_S;
            let after_rad = self.heading_rad - if self.is_down { way_um / RADIUS_UM } else { 0.0 };
            if self.is_down {
                self.x_um -= RADIUS_UM * (after_rad.sin() - self.heading_rad.sin());
                self.y_um += RADIUS_UM * (after_rad.cos() - self.heading_rad.cos());
            } else {
                self.x_um += way_um * after_rad.cos();
                self.y_um += way_um * after_rad.sin();
            }
            self.heading_rad = after_rad;
        }
    }
}

/// Controls a program from the pose at which its robot starts; the last answer, or `None` if it has no plan.
fn controlled(program: &Path, record: &Path) -> Option<Value> {
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
    let mut bed = ExactBed { x_um: 0.0, y_um: 0.0, heading_rad: 0.0, is_down: false };
    let mut t_ns = 0;
    loop {
        let pose = json!({ "x_um": bed.x_um, "y_um": bed.y_um, "heading_deg": bed.heading_rad * 180.0 / PI });
        writeln!(input, "{}", json!({ "t_ns": t_ns, "robots": { "D1": pose } })).expect("it reads");
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

fn accepts(program: &Path, record: &Path) {
    let mut verify = Command::new(assert_cmd::cargo::cargo_bin!("tweeze"));
    let run = verify.arg("verify").arg(record).arg("--against").arg(program).output().expect("tweeze runs");
    let said = String::from_utf8_lossy(&run.stderr).into_owned();
    assert_eq!(run.status.code(), Some(DONE), "{said}\n{}", std::fs::read_to_string(program).unwrap_or_default());
}

#[test]
fn a_run_straight_ahead_begins_without_a_circle() {
    let folder = tempfile::tempdir().expect("a folder");
    let record = folder.path().join("run.mcap");
    let program = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/found/microrobots-lag-circle.twz");
    let last = controlled(&program, &record).expect("a plan");
    assert_eq!(last["command"], "finished", "{last}");
    assert!(last["t_ns"].as_u64().is_some_and(|t_ns| t_ns < 5_500_000_000), "{last}");
    accepts(&program, &record);
}

#[test]
fn no_drive_goes_through_a_stone() {
    let folder = tempfile::tempdir().expect("a folder");
    let (program, record) = (folder.path().join("drive.twz"), folder.path().join("run.mcap"));
    let mut chance = Random(5);
    let (mut finished, mut blocked) = (0, 0);
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
        let text = format!(
            "use std.microrobots\ndevice fleet : microrobots.bed {{\n  robots: table {{\n    \
             robot | snap_down [V] | release [V] | turning_radius [um]\n    D1 | 110 | 20 | 160\n  }}\n}}\n\
             scene field {{\n  robot D1 at pose(0 mm, 0 mm, 0 deg)\n{stones}}}\ntask go on fleet in field {{\n  \
             precision: 50 um\n  heading_precision: 5 deg\n  drive D1 to pose({goal})\n}}\n"
        );
        std::fs::write(&program, &text).expect("a program is written");
        let _ = std::fs::remove_file(&record);
        let Some(last) = controlled(&program, &record) else { continue };
        if last["command"] == "finished" {
            finished += 1;
            accepts(&program, &record);
        } else {
            blocked += 1;
            assert_eq!(last["reason"], "blocked", "{last}\n{text}");
            assert!(include_str!("../../schema/control.schema.json").contains("\"blocked\""), "the schema has it");
        }
    }
    println!("{finished} finished, {blocked} stopped before a stone");
    assert!(3 * finished > 2 * CASES && blocked >= 1, "{finished} finished, {blocked} stopped before a stone");
}

/// Random drives.
const CASES: u32 = 40;
