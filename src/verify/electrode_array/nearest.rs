//! Least distances of parts from one another and from obstacles, for the evidence.
//!
//! Distances are those by which [`super::bodies`] judges: between the cells in which parts may be in a beat, in
//! electrodes from centre to centre.

use super::JudgedBoard;
use super::beat::{Pulls, StepBeat};
use super::bodies::{SweptCells, first_touch, needed};
use super::pull::PartPull;
use crate::device::electrode_array::ElectrodeCell;
use crate::verify::evidence::{Clearance, GapUnit};
use crate::verify::rule::Rule;

impl JudgedBoard<'_, '_> {
    /// Records the distances of a beat that are less than all before.
    pub(super) fn nearest(&self, moment: &StepBeat, pulls: &Pulls) {
        let device = &self.run.job.device;
        let farthest = self.order.facts.columns.max(self.order.facts.rows);
        let least = |rule| match self.run.tally.least(rule, device) {
            least if least < f64::from(farthest) => least as u32,
            _ => farthest,
        };
        let paths: Vec<SweptCells> = pulls.iter().map(|(_, pull)| SweptCells::new(pull.from, pull.to)).collect();
        let apart = |one: usize, other: usize| self.apart(moment, [&pulls[one], &pulls[other]]);
        let mut within = least(Rule::Touch);
        // No accepted schedule has a distance below the needed one.
        let mut nearest = None;
        while within > needed(&self.order.facts) {
            let Some(found) = first_touch(&paths, within, apart) else { break };
            (within, nearest) = (found.2, Some(found));
        }
        if let Some((one, other, _)) = nearest {
            let pair = [&pulls[one], &pulls[other]];
            if let Some([first, second]) = self.spans(moment, pair) {
                let cells = first.nearest(&second);
                let between = pair.map(|(part, _)| self.order.parts[*part].name.clone());
                self.keep(Rule::Touch, moment.at_ns, between, &pair[0].1, Some(&pair[1].1), cells);
            }
        }
        let due = needed(&self.order.facts);
        self.near_bodies(moment, pulls, Rule::Touch, due, |within, pull| {
            self.scene.nearest_stuck(&SweptCells::new(pull.from, pull.to), within)
        });
        self.near_bodies(moment, pulls, Rule::Clearance, self.order.facts.clearance, |within, pull| {
            self.scene.nearest_block(pull.to, within)
        });
    }

    /// Records the least distance of a part from an obstacle.
    fn near_bodies(
        &self,
        moment: &StepBeat,
        pulls: &Pulls,
        rule: Rule,
        due: u32,
        find: impl Fn(u32, &PartPull) -> Option<(usize, [ElectrodeCell; 2])>,
    ) {
        let farthest = self.order.facts.columns.max(self.order.facts.rows);
        for (part, pull) in pulls {
            let least = self.run.tally.least(rule, &self.run.job.device).min(f64::from(farthest));
            if least <= f64::from(due) {
                return;
            }
            let Some((obstacle, cells)) = find(least as u32 - 1, pull) else { continue };
            let between = [&self.order.parts[*part].name, &self.order.obstacles[obstacle].name].map(String::clone);
            self.keep(rule, moment.at_ns, between, pull, None, cells);
        }
    }

    /// Records the distance of a part from another one, or from an obstacle, with its instant.
    fn keep(
        &self,
        rule: Rule,
        at_ns: u64,
        between: [String; 2],
        pull: &PartPull,
        other: Option<&PartPull>,
        cells: [ElectrodeCell; 2],
    ) {
        let arrives = |pull: &PartPull, cell: ElectrodeCell| pull.moves().then_some(cell == pull.to);
        let both = [arrives(pull, cells[0]), other.and_then(|other| arrives(other, cells[1]))];
        let step_ns = self.order.facts.step_ns;
        let after_ns = match (both.contains(&Some(false)), both.contains(&Some(true))) {
            (true, true) => step_ns / 2,
            (false, true) => step_ns,
            (true | false, false) => 0,
        };
        let facts = &self.order.facts;
        let due = if rule == Rule::Touch { needed(facts) } else { facts.clearance };
        self.run.tally.near(Clearance {
            rule,
            device: self.run.job.device.clone(),
            between,
            apart: f64::from(cells[0].apart(cells[1])),
            needed: f64::from(due),
            error_bound: 0.0,
            unit: GapUnit::Electrodes,
            t_ns: at_ns + after_ns,
            points: cells.map(|cell| [f64::from(cell.column), f64::from(cell.row), 0.0]),
        });
    }
}
