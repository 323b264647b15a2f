//! Report of plans for microrobots.

mod beds;

pub use beds::suggest;

use super::{Note, ReportTopic, ReportedDevice, ReportedOrder, ReportedRun, length, reached};
use crate::check::microrobots::CheckedBed;
use crate::claims::Claims;
use crate::claims::microrobots::MicrorobotsOrder;
use crate::diagnostic::Remark;
use crate::plan::microrobots::reliability::EXPECTED;

impl ReportedOrder for MicrorobotsOrder {
    /// Whether each goal of an assembly is guaranteed under the device's error bounds, where robots end, and which robots
    /// are absent.
    fn notes(&self, run: &ReportedRun) -> Vec<Note> {
        let remark = |remark: &Remark| match remark.subject.as_str() {
            EXPECTED => (ReportTopic::Expected, remark.text.clone()),
            subject => (ReportTopic::Guaranteed, format!("{subject}: {}", remark.text)),
        };
        let assured = run.remarks().map(remark);
        assured.chain(reached(run)).chain(absent(self)).collect()
    }
}

impl ReportedDevice for CheckedBed {
    fn describe(&self, name: &str, _claims: &[Claims]) -> String {
        beds::describe(name, self)
    }
}

/// The robots of the table that the scene leaves out.
fn absent(order: &MicrorobotsOrder) -> Option<Note> {
    let is_absent = |row: &usize| order.robots.iter().all(|robot| robot.row != *row);
    let rows = (0..order.facts.robots.len()).filter(is_absent);
    let names: Vec<&str> = rows.map(|row| order.facts.robots[row].name.as_str()).collect();
    let line = format!("{} in the table but not in the scene; assumed absent from the bed", names.join(", "));
    (!names.is_empty()).then_some((ReportTopic::Absent, line))
}
