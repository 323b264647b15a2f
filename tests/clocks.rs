//! A schedule whose clock runs at another speed is refused in every kind: all times of it are judged, not recorded only.

mod support;

use std::path::Path;
use support::build_in;
use tweeze::schedule::Schedule;
use tweeze::verify::{Rule, Verdict, verify};

/// One program of each kind.
const PROGRAMS: [(&str, &str); 4] = [
    (
        "dimibot",
        "use std.dimibot\ndevice bot : dimibot.femto_st { left: 5, right: 5 }\ntask go on bot { move to (3, 5) }\n",
    ),
    (
        "electrode_array",
        "use std.electrode_array as ea\ndevice plate : ea.smart_platform { columns: 12, rows: 12 }\n\
         scene tray { part m1 : ea.micropart at (3, 3) }\ntask go on plate in tray { move m1 to (7, 3) }\n",
    ),
    ("microrobots", include_str!("../examples/microrobots_drive.twz")),
    (
        "fingers",
        "use std.fingers as f\ndevice hand : f.three_fingers {}\n\
         scene cell { part bead : ellipsoid { axes: (16 um, 11.845 um, 11.845 um) } }\n\
         task flip on hand in cell { rotate bead by 40 deg about z }\n",
    ),
];

/// All times of a schedule divided, and the figures that depend on them set right.
fn hastened(schedule: &Schedule, divisor: u64) -> Schedule {
    let mut forged = schedule.clone();
    let quick = |time_ns: &mut u64| *time_ns /= divisor;
    quick(&mut forged.duration_ns);
    for line in &mut forged.actuations {
        let end_ns = line.end_ns() / divisor;
        quick(&mut line.start_ns);
        line.duration_ns = end_ns - line.start_ns;
        if let Some(swing) = &mut line.swing {
            swing.period_ns /= divisor;
        }
    }
    for step in &mut forged.steps {
        let end_ns = (step.start_ns + step.duration_ns) / divisor;
        quick(&mut step.start_ns);
        step.duration_ns = end_ns - step.start_ns;
    }
    for plan in &mut forged.plans {
        let end_ns = (plan.start_ns + plan.duration_ns) / divisor;
        quick(&mut plan.start_ns);
        plan.duration_ns = end_ns - plan.start_ns;
        plan.states.iter_mut().for_each(|state| quick(&mut state.t_ns));
        plan.outcomes.insert("time".to_owned(), plan.duration_ns as f64 / 1e9);
        if plan.objective == "time" {
            let scale = if plan.unit == "ms" { 1e6 } else { 1e9 };
            plan.cost = plan.duration_ns as f64 / scale;
            plan.bound = plan.cost;
        }
    }
    forged
}

#[test]
fn a_clock_that_is_divided_is_refused_in_every_kind() {
    for (kind, text) in PROGRAMS {
        let built = build_in(Path::new("examples"), text);
        assert!(!built.schedules.is_empty(), "{kind}: {:?}", built.codes);
        let (schedule, claims) = (built.schedules[0].schedule(), built.schedules[0].claims());
        assert!(matches!(verify(schedule.clone(), claims), Verdict::Accepted(_)), "{kind}");
        for divisor in [2, 10, 1000] {
            let Verdict::Rejected(violations) = verify(hastened(schedule, divisor), claims) else {
                panic!("{kind}: a clock divided by {divisor} is accepted")
            };
            let rules: Vec<Rule> = violations.iter().map(|violation| violation.rule).collect();
            assert!(kind != "fingers" || rules.iter().all(|rule| *rule == Rule::Speed), "{rules:?}");
        }
    }
}
