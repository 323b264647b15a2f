//! What a verification checked: number of checks per rule, and the least clearances.
//!
//! Every function that can find a rule broken first counts its checks in the [`Tally`]; in the tests of this stage, a
//! violation of a rule without a check is a panic. The distances are those by which the rules judge.

use super::catalogue::Rule;
use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;

/// The evidence for the word "verified".
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Evidence {
    /// The rules that were checked at least once, in their order, each with the number of checks.
    pub checks: Vec<(Rule, u64)>,
    /// The least clearance of each rule on each device.
    pub clearances: Vec<Clearance>,
}

/// The least distance between two things in a schedule.
#[derive(Debug, Clone, PartialEq)]
pub struct Clearance {
    /// The rule that limits it.
    pub rule: Rule,
    pub device: String,
    /// Names of the two things.
    pub between: [String; 2],
    /// Distance in `unit`: micrometres between surfaces, or electrodes between centres.
    pub apart: f64,
    /// Least distance that the rule allows, in `unit`.
    pub needed: f64,
    /// Upper bound on the error where a path is sampled: the true least distance may be smaller by this much, in
    /// `unit`.
    pub error_bound: f64,
    pub unit: GapUnit,
    pub t_ns: u64,
    /// The nearest points of the two, in the coordinates of the scene, the board or the hand; z is 0 except for hands.
    pub points: [[f64; 3]; 2],
}

/// Unit of a gap.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GapUnit {
    Micrometres,
    Electrodes,
}

/// Evidence while it is collected; shared by the rules.
#[derive(Debug)]
pub(super) struct Tally {
    /// Number of checks, by rule.
    checks: Vec<Cell<u64>>,
    nearest: RefCell<BTreeMap<Rule, BTreeMap<String, Clearance>>>,
}

impl Default for Tally {
    fn default() -> Tally {
        Tally { checks: vec![Cell::new(0); Rule::ALL.len()], nearest: RefCell::default() }
    }
}

impl Tally {
    /// Counts checks of a rule.
    pub fn count_checks(&self, rule: Rule, times: usize) {
        let count = &self.checks[rule as usize];
        count.set(count.get().saturating_add(times as u64));
    }

    /// Number of checks of a rule so far.
    pub fn times(&self, rule: Rule) -> u64 {
        self.checks[rule as usize].get()
    }

    /// The least distance under a rule on a device so far; infinite before the first.
    pub fn least(&self, rule: Rule, device: &str) -> f64 {
        let nearest = self.nearest.borrow();
        nearest.get(&rule).and_then(|devices| devices.get(device)).map_or(f64::INFINITY, |found| found.apart)
    }

    /// Keeps a distance that is less than all earlier ones of its rule and device.
    pub fn near(&self, found: Clearance) {
        if found.apart < self.least(found.rule, &found.device) {
            let mut nearest = self.nearest.borrow_mut();
            nearest.entry(found.rule).or_default().insert(found.device.clone(), found);
        }
    }

    /// Widens the error bound of the least distance under a rule on a device.
    pub fn widen_error(&self, rule: Rule, device: &str, error_bound: f64) {
        let mut nearest = self.nearest.borrow_mut();
        if let Some(found) = nearest.get_mut(&rule).and_then(|devices| devices.get_mut(device)) {
            found.error_bound = found.error_bound.max(error_bound);
        }
    }

    /// The evidence collected so far.
    pub fn evidence(&self) -> Evidence {
        let checks = Rule::ALL.iter().map(|rule| (*rule, self.times(*rule))).filter(|(_, times)| *times > 0).collect();
        let clearances = self.nearest.borrow().values().flat_map(BTreeMap::values).cloned().collect();
        Evidence { checks, clearances }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clearance(rule: Rule, device: &str, gap_um: f64) -> Clearance {
        let between = ["tip".to_owned(), "bead".to_owned()];
        let (unit, points) = (GapUnit::Micrometres, [[0.0; 3], [gap_um, 0.0, 0.0]]);
        Clearance {
            rule,
            device: device.to_owned(),
            between,
            apart: gap_um,
            needed: 0.1,
            error_bound: 0.0,
            unit,
            t_ns: 0,
            points,
        }
    }

    #[test]
    fn rules_that_were_asked_are_counted_in_their_order() {
        let tally = Tally::default();
        for (rule, times) in [(Rule::Sweep, 2), (Rule::Pulse, 3), (Rule::Sweep, 5), (Rule::Busy, 0)] {
            tally.count_checks(rule, times);
        }
        assert_eq!(tally.evidence().checks, [(Rule::Pulse, 3), (Rule::Sweep, 7)]);
        assert_eq!((tally.times(Rule::Sweep), tally.times(Rule::Busy)), (7, 0));
    }

    #[test]
    fn the_first_of_the_least_gaps_of_each_sort_and_device_is_kept() {
        let tally = Tally::default();
        assert_eq!(tally.least(Rule::Sweep, "bot"), f64::INFINITY);
        let first = Clearance { t_ns: 7, ..clearance(Rule::Sweep, "bot", 1.5) };
        let others = [clearance(Rule::Sweep, "bot", 2.0), clearance(Rule::Sweep, "bot", 1.5)];
        let apart = [clearance(Rule::Sweep, "arm", 9.0), clearance(Rule::Graze, "bot", 3.0)];
        [clearance(Rule::Sweep, "bot", 4.0), first.clone()]
            .into_iter()
            .chain(others)
            .for_each(|found| tally.near(found));
        apart.clone().into_iter().for_each(|found| tally.near(found));
        assert_eq!(tally.least(Rule::Sweep, "bot"), 1.5);
        tally.widen_error(Rule::Graze, "bot", 0.2);
        tally.widen_error(Rule::Graze, "bot", 0.1);
        tally.widen_error(Rule::Meet, "bot", 0.1);
        let [arm, graze] = apart;
        let graze = Clearance { error_bound: 0.2, ..graze };
        assert_eq!(tally.evidence().clearances, [arm, first, graze]);
    }

    #[test]
    fn each_rule_has_a_place_of_its_own() {
        assert!(Rule::ALL.iter().enumerate().all(|(at, rule)| *rule as usize == at));
    }
}
