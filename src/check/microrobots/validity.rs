//! Validity of a table's relays, and the diagnostics of its faults.

use super::errors::{self, Limit};
use super::relays::{self, AllowedGaps, Analysis, Mend, Problem, RelayRow, Source, TableFault, Transition};
use super::table::RobotTable;
use crate::check::devices::CheckedDevice;
use crate::check::figures::Figures;
use crate::check::labels::DeviceLabel;
use crate::device::microrobots::{Arm, ControlState, MAX_LEVELS, MicrorobotsFacts, Robot};
use crate::diagnostic::{Diagnostic, Sink};

/// A control state with a slack below this share of the margin gets a warning.
const SMALL_SLACK: f64 = 0.1;

/// Greatest number of control states with a warning of their own.
const MAX_WARNINGS: usize = 8;

/// The control states of a bed; `None` after an error.
pub fn states(
    facts: &MicrorobotsFacts,
    table: &RobotTable,
    device: &CheckedDevice,
    sink: &mut Sink,
) -> Option<Vec<ControlState>> {
    let source = source(facts, device)?;
    let judge = TableJudge { facts, table, device, most_levels: source.most_levels };
    let errors = sink.errors();
    (0..facts.robots.len()).filter_map(|row| judge.upside_down(row)).for_each(|wrong| sink.push(wrong));
    (sink.errors() == errors).then_some(())?;
    let analysis = relays::analyse(&rows(facts), source, gaps(device));
    let faults: Vec<Diagnostic> =
        analysis.faults.iter().map(|fault| judge.fault_diagnostic(fault, &analysis)).collect();
    let rest = faults.last().filter(|_| analysis.more_faults > 0).map(|last| {
        let labels = [DeviceLabel::cell(table.span, "in this table")];
        device.labelled(errors::more_faults(last.code, analysis.more_faults), labels)
    });
    faults.into_iter().chain(rest).for_each(|wrong| sink.push(wrong));
    (sink.errors() == errors).then_some(())?;
    judge.warnings(&analysis).into_iter().for_each(|warning| sink.push(warning));
    Some(analysis.states)
}

fn rows(facts: &MicrorobotsFacts) -> Vec<RelayRow> {
    let row = |robot: &Robot| RelayRow { snap_down_v: robot.snap_down_v, release_v: robot.release_v };
    facts.robots.iter().map(row).collect()
}

fn source(facts: &MicrorobotsFacts, device: &CheckedDevice) -> Option<Source> {
    let MicrorobotsFacts { margin_v, relax_v, flex_v, max_v, .. } = *facts;
    Some(Source { margin_v, relax_v, flex_v, max_v, most_levels: device.fields.count("levels")? as usize })
}

fn gaps(device: &CheckedDevice) -> AllowedGaps {
    if device.fields.is_set("non_string") { AllowedGaps::Any } else { AllowedGaps::String }
}

/// Reports the faults of a table, at the rows concerned.
struct TableJudge<'a> {
    facts: &'a MicrorobotsFacts,
    table: &'a RobotTable<'a>,
    device: &'a CheckedDevice,
    most_levels: usize,
}

impl TableJudge<'_> {
    fn name(&self, row: usize) -> &str {
        &self.facts.robots[row].name
    }

    fn cell(&self, row: usize, transition: Transition, text: impl Into<String>) -> DeviceLabel {
        DeviceLabel::cell(self.table.place(row, column(transition)), text)
    }

    /// Both voltages of a row under one label, if the row stands on one line as rows do.
    fn row(&self, row: usize) -> DeviceLabel {
        let [down, up] = [Transition::SnapDown, Transition::Release].map(|which| self.table.place(row, column(which)));
        let robot = &self.facts.robots[row];
        DeviceLabel::cell(down.to(up), errors::relay_label(&robot.name, robot.snap_down_v, robot.release_v))
    }

    /// Diagnostic for an arm that is not released below its snap-down voltage.
    fn upside_down(&self, row: usize) -> Option<Diagnostic> {
        let robot = &self.facts.robots[row];
        (robot.release_v >= robot.snap_down_v).then(|| {
            let labels = [
                self.cell(row, Transition::Release, "not below `snap_down`"),
                self.cell(row, Transition::SnapDown, "the arm goes down here"),
            ];
            let wrong = errors::release_above_snap_down(&robot.name, robot.release_v, robot.snap_down_v);
            self.device.labelled(wrong, labels)
        })
    }

    fn fault_diagnostic(&self, fault: &TableFault, analysis: &Analysis) -> Diagnostic {
        let (wrong, labels) = self.fault(&fault.problem, analysis);
        let mend = fault.mend.as_ref().map(|mend| self.mend(mend, &fault.problem));
        let mends: Vec<String> = mend.into_iter().chain(self.other_level(&fault.problem)).collect();
        let wrong = wrong.help_if((!mends.is_empty()).then(|| mends.join("; or ")));
        self.device.labelled(wrong, labels)
    }

    /// Help for a level of the device that would suit every row, if the drive train still swings with it.
    fn other_level(&self, problem: &Problem) -> Option<String> {
        let MicrorobotsFacts { margin_v, relax_v, flex_v, .. } = *self.facts;
        let robots = &self.facts.robots;
        let highest = |voltage: fn(&Robot) -> f64| robots.iter().map(voltage).fold(0.0, f64::max);
        let lowest_v = robots.iter().map(|robot| robot.snap_down_v).fold(f64::INFINITY, f64::min);
        match problem {
            Problem::Hold { .. } => {
                let least_v = highest(|robot| robot.release_v) + 2.0 * margin_v;
                (least_v < flex_v).then(|| errors::level_mend("relax", [relax_v, least_v]))
            }
            Problem::Drive { .. } => {
                let most_v = lowest_v - 2.0 * margin_v;
                (most_v > relax_v).then(|| errors::level_mend("flex", [flex_v, most_v]))
            }
            Problem::Range { .. } => {
                let least_v = highest(|robot| robot.snap_down_v) + margin_v;
                Some(errors::level_mend("max_voltage", [self.facts.max_v, least_v]))
            }
            Problem::Floor { .. }
            | Problem::Narrow { .. }
            | Problem::Nested { .. }
            | Problem::Alike { .. }
            | Problem::NoSequence { .. }
            | Problem::Crowd { .. } => None,
        }
    }

    fn mend(&self, mend: &Mend, problem: &Problem) -> String {
        let robot = &self.facts.robots[mend.row];
        let now_v = self.voltage(mend.row, mend.transition);
        let mend = errors::voltage_mend(column(mend.transition), &robot.name, [now_v, mend.to_v]);
        match problem {
            Problem::Nested { .. } => format!("{mend}; or give the device `non_string: true`"),
            Problem::NoSequence { levels, .. } if *levels <= MAX_LEVELS as usize => {
                format!("{mend}; or allow longer control cycles, `levels: {levels}`")
            }
            Problem::NoSequence { .. }
            | Problem::Hold { .. }
            | Problem::Drive { .. }
            | Problem::Range { .. }
            | Problem::Floor { .. }
            | Problem::Narrow { .. }
            | Problem::Alike { .. }
            | Problem::Crowd { .. } => mend,
        }
    }

    fn fault(&self, problem: &Problem, analysis: &Analysis) -> (Diagnostic, Vec<DeviceLabel>) {
        match *problem {
            Problem::Hold { row, most_v } => self.limit(row, Limit::Hold { relax_v: self.facts.relax_v, most_v }),
            Problem::Drive { row, least_v } => self.limit(row, Limit::Drive { flex_v: self.facts.flex_v, least_v }),
            Problem::Range { row, most_v } => self.limit(row, Limit::Range { max_v: self.facts.max_v, most_v }),
            Problem::Floor { row, least_v } => self.limit(row, Limit::Floor { least_v }),
            Problem::Narrow { row, gap_v, least_v } => {
                (errors::narrow_gap(self.name(row), gap_v, least_v), vec![self.row(row)])
            }
            Problem::Nested { outer, inner, snap_down_gap_v, release_gap_v, .. } => {
                let gaps_v = [snap_down_gap_v, release_gap_v];
                let wrong = errors::nested_gaps(self.name(outer), self.name(inner), gaps_v);
                (wrong, vec![self.row(outer), self.row(inner)])
            }
            Problem::Alike { one, other, snap_down_gap_v, release_gap_v, least_v } => {
                let gaps_v = [snap_down_gap_v, release_gap_v];
                let wrong = errors::alike_robots(self.name(one), self.name(other), gaps_v, least_v);
                (wrong, vec![self.row(one), self.row(other)])
            }
            Problem::NoSequence { state, levels, snap_down, release, least_v } => {
                let lowered: Vec<&str> = analysis.order.iter().take(state).map(|row| self.name(*row)).collect();
                let wrong = errors::no_sequence(state, &lowered, [levels, self.most_levels], least_v);
                let gaps = [(snap_down, Transition::SnapDown), (release, Transition::Release)];
                let labels = gaps.into_iter().flat_map(|(gap, transition)| self.gap(gap, transition)).collect();
                (wrong, labels)
            }
            Problem::Crowd { most } => {
                (errors::too_many_states(most), vec![DeviceLabel::cell(self.table.span, "of this table")])
            }
        }
    }

    /// A voltage that clashes with a level of the device.
    fn limit(&self, row: usize, limit: Limit) -> (Diagnostic, Vec<DeviceLabel>) {
        let robot = &self.facts.robots[row];
        let (transition, found_v, field) = match limit {
            Limit::Hold { .. } => (Transition::Release, robot.release_v, Some("relax")),
            Limit::Drive { .. } => (Transition::SnapDown, robot.snap_down_v, Some("flex")),
            Limit::Range { .. } => (Transition::SnapDown, robot.snap_down_v, Some("max_voltage")),
            Limit::Floor { .. } => (Transition::Release, robot.release_v, None),
        };
        let mut labels = vec![self.cell(row, transition, limit.label())];
        labels.extend(field.map(|field| DeviceLabel::field(field, "against this level")));
        labels.push(DeviceLabel::field("margin", "known no better than this"));
        (errors::voltage_out_of_limit(&robot.name, found_v, limit, self.facts.margin_v), labels)
    }

    /// Labels of the two cells that a state would have to separate by one voltage.
    fn gap(&self, gap: relays::RowGap, transition: Transition) -> Vec<DeviceLabel> {
        let (down, up) = (self.name(gap.down), self.name(gap.up));
        let [low, high] = errors::gap_labels(column(transition), [down, up], gap.gap_v);
        vec![self.cell(gap.down, transition, low), self.cell(gap.up, transition, high)]
    }

    /// Warnings of states with little slack; of very many states the first ones, then their number.
    fn warnings(&self, analysis: &Analysis) -> Vec<Diagnostic> {
        let least_v = SMALL_SLACK * self.facts.margin_v;
        let is_thin = |(_, state): &(usize, &ControlState)| state.slack_v < least_v;
        let thin: Vec<(usize, &ControlState)> = analysis.states.iter().enumerate().filter(is_thin).collect();
        let shown = thin.iter().take(MAX_WARNINGS).map(|(index, state)| {
            let wrong = errors::small_slack(*index, &state.digits(), state.slack_v, self.facts.margin_v);
            self.device.labelled(wrong, self.binding(state))
        });
        let rest = thin.len().checked_sub(MAX_WARNINGS + 1).map(|rest| {
            let labels = [DeviceLabel::cell(self.table.span, "of this table")];
            self.device.labelled(errors::more_small_slacks(rest + 1), labels)
        });
        shown.chain(rest).collect()
    }

    /// Labels of the cells that limit the slack of a state.
    fn binding(&self, state: &ControlState) -> Vec<DeviceLabel> {
        let facts = self.facts;
        let is_binding = |slack_v: f64| (slack_v - state.slack_v).abs() <= 1e-9 * facts.max_v;
        let rows = 0..facts.robots.len();
        let gaps = rows.clone().flat_map(|down| rows.clone().map(move |up| (down, up)));
        let separate = gaps.filter(|(down, up)| state.arms[*down] == Arm::Down && state.arms[*up] == Arm::Up);
        let gap = separate
            .flat_map(|(down, up)| {
                [Transition::SnapDown, Transition::Release].map(|transition| {
                    let gap_v = self.voltage(up, transition) - self.voltage(down, transition);
                    (relays::RowGap { down, up, gap_v }, transition)
                })
            })
            .find(|(gap, _)| is_binding(gap.gap_v.abs() / 2.0 - facts.margin_v));
        if let Some((gap, transition)) = gap {
            return self.gap(gap, transition);
        }
        let below_v = |row: &usize| (facts.max_v - facts.robots[*row].snap_down_v - facts.margin_v) / 2.0;
        if let Some(row) = rows.clone().find(|row| is_binding(below_v(row))) {
            return vec![self.cell(row, Transition::SnapDown, "barely below `max_voltage`")];
        }
        let above_v = |row: &usize| (facts.robots[*row].release_v - facts.margin_v) / 2.0;
        match rows.into_iter().find(|row| is_binding(above_v(row))) {
            Some(row) => vec![self.cell(row, Transition::Release, "barely above 0 V")],
            None => vec![DeviceLabel::cell(self.table.span, "in this table")],
        }
    }

    fn voltage(&self, row: usize, transition: Transition) -> f64 {
        match transition {
            Transition::SnapDown => self.facts.robots[row].snap_down_v,
            Transition::Release => self.facts.robots[row].release_v,
        }
    }
}

fn column(transition: Transition) -> &'static str {
    match transition {
        Transition::SnapDown => "snap_down",
        Transition::Release => "release",
    }
}
