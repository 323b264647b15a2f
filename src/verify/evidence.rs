//! What a verification looked at: how often each rule was asked, and how near things came to one another.
//!
//! Every function that can find a rule broken first tells the [`Tally`] how many things it asks the rule of: in the tests of this stage a
//! violation of a rule that was asked of nothing is a panic. Distances are those by which the rules judge.

use super::catalogue::Rule;
use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;

/// What stands behind the word "verified".
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Evidence {
    /// The rules that were asked of anything, in their order, with the number of things.
    pub checks: Vec<(Rule, u64)>,
    /// The least distance of each sort on each device.
    pub clearances: Vec<Clearance>,
}

/// The least distance that two things have in a schedule.
#[derive(Debug, Clone, PartialEq)]
pub struct Clearance {
    /// The rule that limits it.
    pub rule: Rule,
    pub device: String,
    /// What comes near to each other.
    pub between: [String; 2],
    /// In micrometres between surfaces, or electrodes between centres.
    pub apart: f64,
    /// The least gap that the rule allows.
    pub needed: f64,
    /// By how much the true least gap may be smaller, where a path is followed in steps.
    pub within: f64,
    pub unit: GapUnit,
    pub t_ns: u64,
    /// The two points that are nearest to each other, in the coordinates of the scene, the board or the hand; z is 0 but for hands.
    pub points: [[f64; 3]; 2],
}

/// Unit of a gap.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GapUnit {
    Micrometres,
    Electrodes,
}

/// Evidence while it is gathered; the rules share it.
#[derive(Debug)]
pub(super) struct Tally {
    /// By rule.
    checks: Vec<Cell<u64>>,
    nearest: RefCell<BTreeMap<Rule, BTreeMap<String, Clearance>>>,
}

impl Default for Tally {
    fn default() -> Tally {
        Tally { checks: vec![Cell::new(0); Rule::ALL.len()], nearest: RefCell::default() }
    }
}

impl Tally {
    /// A rule is asked of a number of things.
    pub fn asked(&self, rule: Rule, times: usize) {
        let count = &self.checks[rule as usize];
        count.set(count.get().saturating_add(times as u64));
    }

    /// How often a rule was asked.
    pub fn times(&self, rule: Rule) -> u64 {
        self.checks[rule as usize].get()
    }

    /// The least gap of a sort that was met on a device so far; infinite before the first.
    pub fn least(&self, rule: Rule, device: &str) -> f64 {
        let nearest = self.nearest.borrow();
        nearest.get(&rule).and_then(|devices| devices.get(device)).map_or(f64::INFINITY, |found| found.apart)
    }

    /// Keeps a gap that is less than all of its sort before it.
    pub fn near(&self, found: Clearance) {
        if found.apart < self.least(found.rule, &found.device) {
            let mut nearest = self.nearest.borrow_mut();
            nearest.entry(found.rule).or_default().insert(found.device.clone(), found);
        }
    }

    /// The least gap of a sort on a device may be smaller by some length.
    pub fn off_by(&self, rule: Rule, device: &str, within: f64) {
        let mut nearest = self.nearest.borrow_mut();
        if let Some(found) = nearest.get_mut(&rule).and_then(|devices| devices.get_mut(device)) {
            found.within = found.within.max(within);
        }
    }

    /// What was gathered.
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
            within: 0.0,
            unit,
            t_ns: 0,
            points,
        }
    }

    #[test]
    fn rules_that_were_asked_are_counted_in_their_order() {
        let tally = Tally::default();
        for (rule, times) in [(Rule::Sweep, 2), (Rule::Pulse, 3), (Rule::Sweep, 5), (Rule::Busy, 0)] {
            tally.asked(rule, times);
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
        tally.off_by(Rule::Graze, "bot", 0.2);
        tally.off_by(Rule::Graze, "bot", 0.1);
        tally.off_by(Rule::Meet, "bot", 0.1);
        let [arm, graze] = apart;
        let graze = Clearance { within: 0.2, ..graze };
        assert_eq!(tally.evidence().clearances, [arm, first, graze]);
    }

    #[test]
    fn each_rule_has_a_place_of_its_own() {
        assert!(Rule::ALL.iter().enumerate().all(|(at, rule)| *rule as usize == at));
    }
}
