//! Legs of the whole bed between the dockings of an assembly.
//!
//! Problem: while one robot docks, the others orbit where they are. So a robot may wait in the way of another one, far
//! from its place, or in a bad phase of its orbit. Method: after each docking the legs of the whole bed are searched
//! again for the robots that are left, from the poses that they have then, and the rest of the assembly is planned
//! after them. Guaranteed: an assembly becomes no worse. Not guaranteed: that it becomes better. Cost: `DESCENTS`
//! descents and assemblies of what is left for each docking.

use super::super::initial_leg_search::InitialLegSearch;
use super::super::initial_legs::InitialLegs;
use super::super::world::BedPoses;
use super::super::{AssemblyStage, Leg, MicrorobotsStepMotion, RobotDocking};
use super::BedStepPlanner;
use crate::claims::microrobots::Dock;
use crate::plan::search::Meter;

/// Descents to the legs after one docking; more of them hardly help.
const DESCENTS: usize = 2;

/// An assembly up to one of its dockings, and the bed then.
struct PartialAssembly {
    legs: Vec<Leg>,
    docks: Vec<RobotDocking>,
    stages: Vec<AssemblyStage>,
    bed: BedPoses,
}

impl BedStepPlanner<'_> {
    /// Replaces what comes after each docking by something better, if it is found.
    pub fn regroup(&self, motion: &mut MicrorobotsStepMotion, docks: &[Dock], meter: &mut Meter) {
        for docked in 1..docks.len() {
            let Some(part) = self.part(motion, docked) else { continue };
            let left: Vec<Dock> = docks.iter().filter(|dock| !part.bed.docked[dock.robot]).cloned().collect();
            let before = part.legs.last().map(|leg| leg.state);
            let search = InitialLegSearch::new(self.order, self.roomy, self.world, &part.bed, &left, before);
            let Some(search) = search else { continue };
            for initial in search.descents(DESCENTS) {
                let other = self.continued(&part, initial, &left, meter);
                if let Some(other) = other.filter(|other| self.cost(other.legs()) < self.cost(motion.legs())) {
                    *motion = other;
                }
            }
        }
    }

    /// Another way on after a part of an assembly: legs of the whole bed, and the assembly of the robots that are left.
    fn continued(
        &self,
        part: &PartialAssembly,
        initial: InitialLegs,
        left: &[Dock],
        meter: &mut Meter,
    ) -> Option<MicrorobotsStepMotion> {
        let later = self.after(&part.bed, initial, left, meter, self.fine_motions())?;
        let MicrorobotsStepMotion::Legs { legs, docks, stages } = later else { return None };
        let docks = docks.into_iter().map(|dock| RobotDocking { leg: dock.leg + part.legs.len(), ..dock });
        Some(MicrorobotsStepMotion::Legs {
            legs: part.legs.iter().copied().chain(legs).collect(),
            docks: part.docks.iter().copied().chain(docks).collect(),
            stages: part.stages.iter().cloned().chain(stages).collect(),
        })
    }

    /// The part of an assembly up to the docking of exactly its first `docked` robots; `None` if more dock at that time.
    fn part(&self, motion: &MicrorobotsStepMotion, docked: usize) -> Option<PartialAssembly> {
        let MicrorobotsStepMotion::Legs { legs, docks, stages } = motion else { return None };
        let last = docks.get(docked.checked_sub(1)?)?;
        let docks_last = |stage: &AssemblyStage| match stage {
            AssemblyStage::Pair { first, second, .. } => [*first, *second].contains(&last.robot),
            AssemblyStage::Single { robot, .. } => *robot == last.robot,
            AssemblyStage::Escort { .. } | AssemblyStage::BedLegs { .. } => false,
        };
        let stage = stages.iter().position(docks_last)?;
        let is_last = docks.get(docked).is_none_or(|next| next.leg > last.leg);
        let (legs, docks) = (legs[..=last.leg].to_vec(), docks[..docked].to_vec());
        let mut bed = self.bed.clone();
        bed.follow(self.world, &legs, &docks);
        is_last.then(|| PartialAssembly { legs, docks, stages: stages[..=stage].to_vec(), bed })
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::assembly::{self, AssemblyTerms, DIRECT};
    use super::super::super::world::CollisionWorld;
    use super::super::super::world::fixture;
    use super::super::InitialLegChoice;
    use super::*;
    use crate::claims::microrobots::{MicrorobotsAction, MicrorobotsStep};
    use crate::geometry::Pose;
    use crate::plan::search::SearchBudget;
    use crate::random::SplitMix64;

    /// An assembly becomes no worse, keeps the collision rules and brings every robot to its goal. Many become better.
    #[test]
    fn regrouped_assemblies_are_shorter_and_arrive() {
        let mut random = SplitMix64::new(5);
        let (mut planned, mut shorter) = (0, 0);
        for _ in 0..12 {
            let (order, docks) = fixture::assembly(5, &mut random);
            let world = CollisionWorld::new(&order);
            let poses: Vec<Pose> = order.robots.iter().map(|placed| placed.pose).collect();
            let start = BedPoses::new(poses.clone(), vec![false; poses.len()]);
            let step = MicrorobotsStep { action: MicrorobotsAction::Assemble(docks.clone()), span: Default::default() };
            let planner = BedStepPlanner {
                order: &order,
                roomy: &order,
                world: &world,
                bed: &start,
                step: &step,
                is_given: true,
                initial_legs: InitialLegChoice::Best,
            };
            let mut meter = Meter::new(SearchBudget::of(order.expansions));
            let terms = AssemblyTerms { fine: DIRECT, most_stages: assembly::MAX_PLANS };
            let found = assembly::assemble(&order, &poses, &start.docked, None, &docks, &mut meter, terms);
            let Ok(assembly::Assembled { legs, docks: docking, stages, .. }) = found else { continue };
            planned += 1;
            let before = planner.cost(&legs);
            let mut motion = MicrorobotsStepMotion::Legs { legs, docks: docking, stages };
            planner.regroup(&mut motion, &docks, &mut meter);
            assert!(planner.cost(motion.legs()) <= before);
            shorter += usize::from(planner.cost(motion.legs()) < before);
            let MicrorobotsStepMotion::Legs { legs, docks: docking, .. } = &motion else { panic!("it assembles") };
            assert_eq!(start.first_collision(&world, legs, docking), None);
            assert!(legs.windows(2).all(|pair| pair[0].state != pair[1].state), "consecutive legs differ");
            let mut end = start.clone();
            end.follow(&world, legs, docking);
            for dock in &docks {
                let (at, goal) = (end.poses[dock.robot], dock.goal.pose);
                assert!(end.docked[dock.robot]);
                assert!((at.x_um - goal.x_um).abs().max((at.y_um - goal.y_um).abs()) <= order.precision.place_um);
            }
        }
        assert!(planned >= 6 && shorter * 2 >= planned, "{shorter} of {planned} assemblies became shorter");
    }
}
