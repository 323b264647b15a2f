//! A step that drives a robot through its stops: at once, or after initial legs that bring the bed where it can.
//!
//! A drive without a detour is kept. For others a random tree of initial legs (`initial_leg_tree`) is searched, first a
//! small one. If that finds nothing, proofs that there is no plan are tried (`proofs`), and then a large one.

use super::super::drive::{self, DriveRequest};
use super::super::free;
use super::super::initial_leg_changes::LegChanges;
use super::super::initial_leg_tree::InitialLegTree;
use super::super::initial_legs::InitialLegs;
use super::super::{Leg, MicrorobotsStepMotion};
use super::proofs::ProofEffort;
use super::{BEST_SEED, BedStepPlanner, plain};
use crate::claims::microrobots::MicrorobotsStop;
use crate::device::microrobots::MicrorobotsObjective;
use crate::diagnostic::Sink;
use crate::geometry::Pose;
use crate::plan::search::SearchBudget;
use crate::random::SplitMix64;

/// The first attempt, without initial legs, may expand 1/`FIRST_SHARE` of the step's budget.
const FIRST_SHARE: u64 = 50;

/// The same for attempts after initial legs, with the interval at which there is one with at most this share: most
/// legs that help leave a clear path, and where obstacles stand close, few attempts with more find shorter plans.
const ATTEMPT_SHARES: [(usize, u64); 3] = [(16, 500), (4, 2_000), (1, 32_000)];

/// Trees grown in search of any plan, and the initial legs of each: before the proofs that take long, then after
/// them. Where one tree is trapped, another may not be.
const SMALL_TREES: (u64, usize) = (3, 300);
const LARGE_TREES: (u64, usize) = (4, 2_000);

/// Attempts since the last better plan after which the search for a better one ends, if not more were needed for the
/// first one: with a tree, and with changes to the best initial legs.
const FEW_DRAWS: usize = 16;
const FEW_CHANGES: usize = 16;

/// A drive, and the initial legs with which it begins.
struct DriveCandidate {
    legs: Vec<Leg>,
    initial: Vec<Leg>,
}

impl BedStepPlanner<'_> {
    /// Returns the best drive found; `None` after its error was pushed.
    pub fn driven(&self, robot: usize, stops: &[MicrorobotsStop], sink: &mut Sink) -> Option<MicrorobotsStepMotion> {
        let poses: Vec<Pose> = stops.iter().map(|stop| stop.pose).collect();
        let request = DriveRequest { order: self.order, world: self.world, bed: self.bed, robot, stops: &poses };
        let direct = drive::drive(&request, self.share(FIRST_SHARE));
        match &direct {
            Ok(driven) if driven.direct => return Some(plain(driven.legs.clone())),
            Err(stuck) if stuck.reason.is_proof() => {
                sink.push(self.why().not_driven(robot, stuck, stops));
                return None;
            }
            Ok(_) | Err(_) => {}
        }
        let goals: Vec<(usize, &MicrorobotsStop)> = stops.iter().map(|stop| (robot, stop)).collect();
        let proof = |effort: ProofEffort| direct.is_err().then(|| self.no_plan(&goals, effort)).flatten();
        if let Some(proof) = proof(ProofEffort::Quick) {
            sink.push(proof);
            return None;
        }
        let trees = |(trees, nodes): (u64, usize), seed: u64| {
            let poses = &poses;
            let tree = move |seed| InitialLegTree::new(self.world, self.bed, robot, poses, seed).take(nodes);
            (seed..seed + trees).flat_map(tree)
        };
        let best = direct.as_ref().ok().map(|driven| driven.legs.clone());
        if let Some(best) = self.driven_after_legs(&request, best, trees(SMALL_TREES, 0)) {
            return Some(plain(best));
        }
        if let Some(proof) = proof(ProofEffort::Thorough) {
            sink.push(proof);
            return None;
        }
        if let Some(best) = self.driven_after_legs(&request, None, trees(LARGE_TREES, SMALL_TREES.0)) {
            return Some(plain(best));
        }
        let driven = drive::drive(&request, self.share(1));
        if let Err(stuck) = &driven {
            sink.push(self.why().not_driven(robot, stuck, stops));
        }
        driven.ok().map(|driven| plain(driven.legs))
    }

    /// Returns the best of the drives after initial legs and of the given one.
    fn driven_after_legs(
        &self,
        request: &DriveRequest,
        direct: Option<Vec<Leg>>,
        draws: impl Iterator<Item = InitialLegs>,
    ) -> Option<Vec<Leg>> {
        let mut best = direct.map(|legs| DriveCandidate { legs, initial: Vec::new() });
        let (mut vain, mut spent) = (0, 0);
        for (at, initial) in draws.enumerate() {
            vain += 1;
            if best.is_some() && vain > FEW_DRAWS.max(spent) {
                break;
            }
            if let Some(better) = self.better(request, best.as_ref(), initial, at) {
                spent = if best.is_none() { at } else { spent };
                (best, vain) = (Some(better), 0);
            }
        }
        best.map(|best| self.improved(request, best, FEW_CHANGES.max(spent / 4)).legs)
    }

    /// Changes the initial legs of a drive until that many changes in succession do not improve it.
    fn improved(&self, request: &DriveRequest, mut best: DriveCandidate, most_vain: usize) -> DriveCandidate {
        let Some(changes) = LegChanges::new(self.world, &self.bed.docked) else { return best };
        let (mut random, mut vain) = (SplitMix64::new(BEST_SEED), 0);
        while vain < most_vain {
            vain += 1;
            let mut legs = best.initial.clone();
            changes.change(&mut legs, &mut random);
            changes.tidy(&mut legs);
            if legs == best.initial || self.bed.first_collision(self.world, &legs, &[]).is_some() {
                continue;
            }
            let mut bed = self.bed.clone();
            bed.follow(self.world, &legs, &[]);
            if let Some(better) = self.better(request, Some(&best), InitialLegs { legs, bed }, vain) {
                (best, vain) = (better, 0);
            }
        }
        best
    }

    /// A drive after initial legs, if it is better than the best one so far.
    fn better(
        &self,
        request: &DriveRequest,
        best: Option<&DriveCandidate>,
        initial: InitialLegs,
        attempt: usize,
    ) -> Option<DriveCandidate> {
        let InitialLegs { legs: initial, bed } = initial;
        if best.is_some_and(|best| self.cannot_beat(&best.legs, &initial, request, &bed.poses)) {
            return None;
        }
        let after = DriveRequest { bed: &bed, ..*request };
        let legs = self.driven_on(&after, initial.clone(), self.attempt_budget(attempt, best.is_some()))?;
        let is_better = best.is_none_or(|best| self.cost(&legs) < self.cost(&best.legs));
        let is_free = is_better && self.bed.first_collision(self.world, &legs, &[]).is_none();
        is_free.then_some(DriveCandidate { legs, initial })
    }

    /// Budget of an attempt; while there is a drive already, the largest one is not spent.
    fn attempt_budget(&self, attempt: usize, has_drive: bool) -> SearchBudget {
        let shares = if has_drive { &ATTEMPT_SHARES[1..] } else { &ATTEMPT_SHARES[..] };
        let due = shares.iter().find(|(interval, _)| (attempt + 1).is_multiple_of(*interval));
        self.share(due.map_or(1, |(_, share)| *share))
    }

    /// Initial legs and a drive from where they lead.
    fn driven_on(&self, request: &DriveRequest, mut legs: Vec<Leg>, budget: SearchBudget) -> Option<Vec<Leg>> {
        let driven = drive::drive(request, budget).ok()?;
        // A stop must be met at the end of a leg of the drive, not before its first leg.
        let first = driven.legs.first().filter(|_| !driven.met.contains(&0))?;
        if let Some(last) = legs.last_mut().filter(|last| last.state == first.state) {
            last.strokes += first.strokes;
            legs.extend(&driven.legs[1..]);
        } else {
            legs.extend(&driven.legs);
        }
        Some(legs)
    }

    /// Whether no drive through the stops, from a pose after initial legs, beats the best one so far: even without
    /// obstacles, the shortest paths take as long.
    fn cannot_beat(&self, best: &[Leg], legs: &[Leg], request: &DriveRequest, poses: &[Pose]) -> bool {
        let DriveRequest { robot, stops, .. } = *request;
        let facts = self.order.robot(robot);
        let ways = std::iter::once(&poses[robot]).chain(stops).zip(stops);
        let way_um: f64 = ways.map(|(from, to)| free::distance_um(facts, *from, *to)).sum();
        let driven: u64 = legs.iter().map(|leg| leg.strokes).sum();
        let strokes = |legs: &[Leg]| legs.iter().map(|leg| leg.strokes).sum::<u64>();
        match self.order.objective {
            MicrorobotsObjective::Time | MicrorobotsObjective::Failures => {
                driven + (way_um / facts.step_um) as u64 >= strokes(best)
            }
            MicrorobotsObjective::Switches => legs.len() >= best.len(),
        }
    }
}
