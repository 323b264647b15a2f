//! Rules of one beat: motion of each part by the electrodes that are on, and clearances between parts and obstacles.
//!
//! Every rule is checked on the whole board; the violation that is returned is that of the first part in the order of
//! the scene.

use super::JudgedBoard;
use super::assay::JudgedSplit;
use super::bodies::{SweptCells, first_touch, needed};
use super::pull::{PartPull, acting, merging, pull_of, range};
use super::stage::StepGoals;
use crate::claims::electrode_array::Bystanders;
use crate::device::electrode_array::{ElectrodeCell, Electrodes, Hold};
use crate::verify::Violation;
use crate::verify::rule::{Rule, ms};
use rustc_hash::{FxHashMap, FxHashSet};

/// Greatest number of electrodes named in a message.
const SHOWN: usize = 4;

/// A beat of a step.
pub(super) struct StepBeat<'m> {
    /// Index of the step in the run.
    pub nth: usize,
    pub at_ns: u64,
    pub goals: &'m StepGoals,
    pub on: &'m FxHashSet<ElectrodeCell>,
    /// The droplets that are split in it; both halves are on the board at its start.
    pub splits: &'m [JudgedSplit],
    /// Parts that are being dispensed and whose electrode their reservoir switches off.
    pub released: &'m [usize],
}

impl StepBeat<'_> {
    /// For either half of a split droplet, its destination and the other half.
    fn split(&self, part: usize) -> Option<(ElectrodeCell, usize)> {
        self.splits.iter().find_map(|split| match part {
            part if part == split.part => Some((split.to, split.half)),
            part if part == split.half => Some((split.comes, split.part)),
            _ => None,
        })
    }
}

/// Motion of each part on the board, by the index of the part.
pub(super) type Pulls = Vec<(usize, PartPull)>;

impl JudgedBoard<'_, '_> {
    fn broken(&self, rule: Rule, moment: &StepBeat, title: String, parts: &[usize]) -> Violation {
        let violation = self.run.violation(rule, moment.nth, moment.at_ns, title);
        parts.iter().fold(violation, |violation, part| violation.label(self.order.parts[*part].span, "this part"))
    }

    fn name(&self, part: usize) -> &str {
        &self.order.parts[part].name
    }

    /// Motion of every part, or the first violation of the rules on electrodes.
    pub(super) fn pulled(&self, moment: &StepBeat) -> Result<Pulls, Violation> {
        let tally = &self.run.tally;
        tally.count_checks(Rule::Pull, self.cells.count());
        tally.count_checks(Rule::Unused, moment.on.len());
        tally.count_checks(Rule::Broadcast, moment.on.iter().filter(|cell| self.channels.is_shared(**cell)).count());
        let pulls = self.pulls(moment)?;
        let owners = self.owners(moment, &pulls)?;
        self.strays(moment, &pulls, &owners)?;
        self.unused(moment, &owners)?;
        self.holds(moment, &pulls)?;
        Ok(pulls)
    }

    /// Every part is pulled to a single cell.
    fn pulls(&self, moment: &StepBeat) -> Result<Pulls, Violation> {
        let electrodes = self.order.facts.layout.electrodes;
        let pull = |(part, at): (usize, ElectrodeCell)| {
            let pull = match (moment.split(part), moment.goals.partner(part)) {
                (Some((to, _)), _) => Some(PartPull { from: at, to, by: vec![to] }),
                (None, Some((_, goal))) => merging(moment.on, self.order.facts.hold, at, goal),
                (None, None) => pull_of(moment.on, electrodes, at),
            };
            pull.map(|pull| (part, pull)).ok_or_else(|| {
                let (name, time) = (self.name(part), ms(moment.at_ns));
                let acting = acting(moment.on, electrodes, at);
                let on = listed(&acting);
                let title = format!("electrodes {on} at {time} pull `{name}` from {at} in no single direction");
                self.broken(self.channels.blamed(&acting), moment, title, &[part])
            })
        };
        self.cells.iter().map(pull).collect()
    }

    /// An electrode carries one part, or two parts to the cell where they merge. Returns the part of each electrode.
    fn owners(&self, moment: &StepBeat, pulls: &Pulls) -> Result<FxHashMap<ElectrodeCell, usize>, Violation> {
        let mut owners = FxHashMap::default();
        for (part, pull) in pulls {
            for electrode in &pull.by {
                let Some(other) = owners.insert(*electrode, *part) else { continue };
                if moment.goals.partner(*part) != Some((other, *electrode)) {
                    let (one, two, at) = (self.name(other), self.name(*part), ms(moment.at_ns));
                    let title = format!("electrode {electrode} at {at} pulls both `{one}` and `{two}`");
                    return Err(self.broken(Rule::Pull, moment, title, &[other, *part]));
                }
            }
        }
        Ok(owners)
    }

    /// No electrode acts on a part that it does not carry, neither at the part's start nor at its end.
    fn strays(
        &self,
        moment: &StepBeat,
        pulls: &Pulls,
        owners: &FxHashMap<ElectrodeCell, usize>,
    ) -> Result<(), Violation> {
        let electrodes = self.order.facts.layout.electrodes;
        for (part, pull) in pulls {
            let partner = moment.goals.partner(*part);
            let meant = |electrode: &ElectrodeCell| {
                let of_partner = partner.is_some_and(|(other, goal)| {
                    let stands = pull.from == goal || pull.to == goal;
                    // The goal is on for one of the two, and not because of another electrode of its channel.
                    let is_for_them = !self.channels.is_shared(goal) || owners.contains_key(&goal);
                    (*electrode == goal && is_for_them) || (stands && owners.get(electrode) == Some(&other))
                });
                pull.by.contains(electrode) || of_partner
            };
            // Without a partner, the pull itself accounts for every electrode that acts at the start.
            let ends = [(partner.is_some(), pull.from), (pull.moves(), pull.to)];
            for (_, at) in ends.into_iter().filter(|(is_open, _)| *is_open) {
                let Some(stray) = acting(moment.on, electrodes, at).into_iter().find(|cell| !meant(cell)) else {
                    continue;
                };
                let (name, time) = (self.name(*part), ms(moment.at_ns));
                let owner =
                    owners.get(&stray).map_or(String::new(), |other| format!(", on for `{}`,", self.name(*other)));
                let title = format!("electrode {stray}{owner} also pulls `{name}` at {at}, at {time}");
                return Err(self.broken(self.channels.blamed(&[stray]), moment, title, &[*part]));
            }
        }
        Ok(())
    }

    /// Every electrode that is on carries or holds a part, or another electrode of its channel does.
    fn unused(&self, moment: &StepBeat, owners: &FxHashMap<ElectrodeCell, usize>) -> Result<(), Violation> {
        if owners.len() == moment.on.len() {
            return Ok(());
        }
        let used = self.channels.all_shared(owners.keys());
        let is_of_use = |cell: &ElectrodeCell| {
            owners.contains_key(cell) || self.channels.shared(*cell).is_some_and(|channel| used.contains(&channel))
        };
        match moment.on.iter().filter(|cell| !is_of_use(cell)).min() {
            None => Ok(()),
            Some(cell) => {
                let title = format!("electrode {cell} is on at {} but pulls no part", ms(moment.at_ns));
                Err(self.broken(Rule::Unused, moment, title, &[]))
            }
        }
    }

    /// The electrode under a resting droplet is on exactly where the device holds its parts.
    fn holds(&self, moment: &StepBeat, pulls: &Pulls) -> Result<(), Violation> {
        match self.order.facts.layout.electrodes {
            Electrodes::Quad => return Ok(()),
            Electrodes::Single => (),
        }
        self.run.tally.count_checks(Rule::Hold, pulls.iter().filter(|(_, pull)| !pull.moves()).count());
        // Where droplets are not held, one may rest on an electrode that is on because its channel also moves another
        // droplet.
        let moving = pulls.iter().filter(|(_, pull)| pull.moves()).flat_map(|(_, pull)| &pull.by);
        let carrying = self.channels.all_shared(moving);
        for (part, pull) in pulls.iter().filter(|(part, pull)| !pull.moves() && !moment.released.contains(part)) {
            let joined = moment.goals.partner(*part).is_some_and(|(other, goal)| {
                goal == pull.from && pulls.iter().any(|(part, pull)| *part == other && pull.moves() && pull.to == goal)
            });
            let joined = joined || self.channels.shared(pull.from).is_some_and(|channel| carrying.contains(&channel));
            let fault = match (self.order.facts.hold, moment.on.contains(&pull.from)) {
                (Hold::On, false) => "off",
                (Hold::Off, true) if !joined => "on, though the device does not hold its parts",
                (Hold::On, true) | (Hold::Off, true | false) => continue,
            };
            let (name, at, time) = (self.name(*part), pull.from, ms(moment.at_ns));
            let title = format!("`{name}` rests at {at} at {time}, but its electrode is {fault}");
            return Err(self.broken(Rule::Hold, moment, title, &[*part]));
        }
        Ok(())
    }

    /// No electrode that is on acts on a stuck part.
    pub(super) fn leaves_stuck_parts(&self, nth: usize, electrode: ElectrodeCell, at_ns: u64) -> Result<(), Violation> {
        let rule = self.channels.blamed(&[electrode]);
        self.run.tally.count_checks(rule, 1);
        let Some(stuck) = self.scene.pulled(electrode, range(self.order.facts.layout.electrodes)) else {
            return Ok(());
        };
        let stuck = &self.order.obstacles[stuck];
        let title = format!("electrode {electrode} at {} pulls the stuck part `{}`", ms(at_ns), stuck.name);
        Err(self.run.violation(rule, nth, at_ns, title).label(stuck.span, "this obstacle"))
    }

    /// A part without a goal moves only where bystanders may yield.
    pub(super) fn bystanders(&self, moment: &StepBeat, pulls: &Pulls) -> Result<(), Violation> {
        match self.order.bystanders {
            Bystanders::Yield => return Ok(()),
            Bystanders::Stay => (),
        }
        self.run
            .tally
            .count_checks(Rule::Bystander, pulls.iter().filter(|(part, _)| !moment.goals.has_goal(*part)).count());
        let moved = pulls.iter().find(|(part, pull)| pull.moves() && !moment.goals.has_goal(*part));
        let Some((part, PartPull { from, to, .. })) = moved else { return Ok(()) };
        let (name, at) = (self.name(*part), ms(moment.at_ns));
        let title = format!("`{name}` moves from {from} to {to} at {at}, but has no goal in this step");
        Err(self.broken(Rule::Bystander, moment, title, &[*part]))
    }

    /// Parts keep clear of each other and of all obstacles, anywhere on their paths of the beat.
    pub(super) fn sweeps(&self, moment: &StepBeat, pulls: &Pulls) -> Result<(), Violation> {
        self.nearest(moment, pulls);
        let explain = |(rule, title, parts): Broken| self.broken(rule, moment, title, &parts);
        self.touches(moment, pulls).map_or(Ok(()), |broken| Err(explain(broken)))?;
        self.clearances(moment.at_ns, pulls).map_or(Ok(()), |broken| Err(explain(broken)))
    }

    /// As [`Self::sweeps`], before the first beat.
    pub(super) fn stands_clear(&self) -> Result<(), Violation> {
        let at_ns = self.run.plan.start_ns;
        let rests = |(part, at): (usize, ElectrodeCell)| (part, PartPull { from: at, to: at, by: Vec::new() });
        let pulls: Pulls = self.cells.iter().map(rests).collect();
        let (goals, on) = (StepGoals::default(), FxHashSet::default());
        let moment = StepBeat { nth: 0, at_ns, goals: &goals, on: &on, splits: &[], released: &[] };
        self.nearest(&moment, &pulls);
        let broken = self.touches(&moment, &pulls).or_else(|| self.clearances(at_ns, &pulls));
        match broken {
            None => Ok(()),
            Some((rule, title, _)) => {
                Err(Violation::new(rule, at_ns, title).label(self.run.job.run_span, "at the start of this run"))
            }
        }
    }

    /// Swept cells of two parts while they must keep their distance; `None` if they need not.
    pub(super) fn spans(
        &self,
        moment: &StepBeat,
        [(part, pull), (second, other)]: [&(usize, PartPull); 2],
    ) -> Option<[SweptCells; 2]> {
        if moment.split(*part).is_some_and(|(_, half)| half == *second) {
            return Some([pull, other].map(|pull| SweptCells::new(pull.to, pull.to)));
        }
        match moment.goals.partner(*part).filter(|(partner, _)| partner == second) {
            None => Some([pull, other].map(|pull| SweptCells::new(pull.from, pull.to))),
            Some((_, goal)) => {
                let besides = |pull: &PartPull| SweptCells::besides(pull.from, pull.to, goal);
                Some([besides(pull)?, besides(other)?])
            }
        }
    }

    /// Distance between two parts; `None` if they need not keep one.
    pub(super) fn apart(&self, moment: &StepBeat, pair: [&(usize, PartPull); 2]) -> Option<u32> {
        self.spans(moment, pair).map(|[one, other]| one.apart(&other))
    }

    /// Two parts keep the separation. Between two parts that merge, their common goal and moves to or from it are
    /// exempt; the two halves of a split need it only at their destinations.
    fn touches(&self, moment: &StepBeat, pulls: &Pulls) -> Option<Broken> {
        let at_ns = moment.at_ns;
        let needed = needed(&self.order.facts);
        self.run.tally.count_checks(Rule::Touch, pulls.len());
        let paths: Vec<SweptCells> = pulls.iter().map(|(_, pull)| SweptCells::new(pull.from, pull.to)).collect();
        let apart = |one: usize, other: usize| self.apart(moment, [&pulls[one], &pulls[other]]);
        let time = ms(at_ns);
        let described = |(part, pull): &(usize, PartPull)| match pull.moves() {
            true => format!("`{}` on its way from {} to {}", self.name(*part), pull.from, pull.to),
            false => format!("`{}` at {}", self.name(*part), pull.from),
        };
        if let Some((one, other, near)) = first_touch(&paths, needed, apart) {
            let (first, second) = (described(&pulls[one]), described(&pulls[other]));
            let title = format!(
                "{first} and {second} come as near as {near} at {time}; at least {needed} electrodes are needed"
            );
            return Some((Rule::Touch, title, vec![pulls[one].0, pulls[other].0]));
        }
        let near_stuck = |(pull, way): (&(usize, PartPull), &SweptCells)| Some((pull.clone(), self.scene.stuck(way)?));
        let (pull, (stuck, near)) = pulls.iter().zip(&paths).find_map(near_stuck)?;
        let (first, stuck) = (described(&pull), &self.order.obstacles[stuck].name);
        let title =
            format!("{first} comes as near as {near} to `{stuck}` at {time}; at least {needed} electrodes are needed");
        Some((Rule::Touch, title, vec![pull.0]))
    }

    /// Where a part rests or arrives, it keeps the clearance from electrodes that an obstacle covers.
    fn clearances(&self, at_ns: u64, pulls: &Pulls) -> Option<Broken> {
        self.run.tally.count_checks(Rule::Clearance, pulls.len());
        let near = |(part, pull): &(usize, PartPull)| Some((*part, pull.to, self.scene.blocked(pull.to)?));
        let (part, at, (obstacle, near)) = pulls.iter().find_map(near)?;
        let (name, obstacle, time) = (self.name(part), &self.order.obstacles[obstacle].name, ms(at_ns));
        let due = self.order.facts.clearance;
        let title =
            format!("`{name}` comes to {at} at {time}, {near} from `{obstacle}`; at least {due} electrodes are needed");
        Some((Rule::Clearance, title, vec![part]))
    }
}

/// A broken rule, the title of its violation, and the parts concerned.
type Broken = (Rule, String, Vec<usize>);

/// A list of electrodes for a message.
fn listed(cells: &[ElectrodeCell]) -> String {
    let shown: Vec<String> = cells.iter().take(SHOWN).map(ElectrodeCell::to_string).collect();
    match cells.len().saturating_sub(SHOWN) {
        0 => shown.join(", "),
        others => format!("{} and {others} more", shown.join(", ")),
    }
}
