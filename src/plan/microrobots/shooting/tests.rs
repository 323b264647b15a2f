use super::lengths::{LegLengths, ShotRobot};
use super::*;
use crate::device::microrobots::Arm;
use crate::plan::microrobots::assembly::{AssemblyTerms, DIRECT};
use crate::plan::microrobots::bound;
use crate::plan::microrobots::world::fixture;
use crate::plan::microrobots::{Crew, legs_cost};
use crate::plan::search::{Meter, SearchBudget};
use crate::real::Real;

/// A request with random arms and starts, the goals at the ends of random legs, and roots some way off.
fn posed(random: &mut SplitMix64) -> (LegLengths, Vec<f64>) {
    let (robots, legs) = (1 + random.below(4), 14);
    let arms: Vec<Arm> = (0..legs * robots).map(|_| if random.below(2) == 0 { Arm::Down } else { Arm::Up }).collect();
    let least_um: Vec<f64> = (0..legs).map(|_| 60.0 * random.unit()).collect();
    let roots: Vec<f64> = (0..legs).map(|_| 5.0 + 10.0 * random.unit()).collect();
    let mut request = LegLengths { robots: Vec::new(), arms, least_um };
    for robot in 0..robots {
        let start = fixture::pose(900.0 * random.unit(), 900.0 * random.unit(), 360.0 * random.unit());
        let curve_um = [-1.0, 1.0][random.below(2)] * (150.0 + 30.0 * random.unit());
        let pace = 1.0 - 0.2 * random.unit();
        let ends = legs - random.below(3);
        let goal = (0..ends).fold(start, |pose, leg| {
            let way_um = pace * (request.least_um[leg] + roots[leg] * roots[leg]);
            followed(pose, request.arms[leg * robots + robot], way_um, curve_um)
        });
        request.robots.push(ShotRobot { curve_um, pace, start, ends, goal });
    }
    let off = roots.iter().map(|root| root + 0.3 * random.signed_unit()).collect();
    (request, off)
}

/// The pose after a leg, in many small steps.
fn followed(start: Pose, arm: Arm, way_um: f64, curve_um: f64) -> Pose {
    const STEPS: usize = 20_000;
    let step_um = way_um / STEPS as f64;
    let turn_rad = if arm == Arm::Down { step_um / curve_um } else { 0.0 };
    (0..STEPS).fold(start, |pose, _| {
        let middle_rad = pose.heading_rad + turn_rad / 2.0;
        Pose {
            x_um: pose.x_um + step_um * middle_rad.cosine(),
            y_um: pose.y_um + step_um * middle_rad.sine(),
            heading_rad: pose.heading_rad + turn_rad,
        }
    })
}

/// Goals that legs reach are found again from lengths nearby, by legs that an independent integration confirms.
#[test]
fn goals_that_can_be_reached_are_solved_for() {
    let mut random = SplitMix64::new(11);
    let mut solved = 0;
    for _ in 0..60 {
        let (request, mut roots) = posed(&mut random);
        let miss_um = request.solve(&mut roots, SolverTerms { steps: 60, ..EXACT });
        if miss_um > 1e-3 {
            continue;
        }
        solved += 1;
        for (robot, shot) in request.robots.iter().enumerate() {
            let end = (0..shot.ends).fold(shot.start, |pose, leg| {
                let way_um = shot.pace * (request.least_um[leg] + roots[leg] * roots[leg]);
                followed(pose, request.arms[leg * request.robots.len() + robot], way_um, shot.curve_um)
            });
            assert!((end.x_um - shot.goal.x_um).hypotenuse(end.y_um - shot.goal.y_um) < 0.01);
        }
    }
    assert!(solved >= 50, "{solved} of 60 solved");
}

/// A weight on the lengths makes them shorter, and the goals are still reached up to that weight.
#[test]
fn weighted_solutions_are_shorter() {
    let mut random = SplitMix64::new(12);
    let length_um = |roots: &[f64]| roots.iter().map(|root| root * root).sum::<f64>();
    let mut shorter = 0;
    for _ in 0..40 {
        let (request, roots) = posed(&mut random);
        let (mut exact, mut short) = (roots.clone(), roots);
        request.solve(&mut exact, SolverTerms { steps: 60, ..EXACT });
        let miss_um = request.solve(&mut short, SolverTerms { steps: 60, ..SHORT });
        shorter += usize::from(miss_um < 1.0 && length_um(&short) < length_um(&exact));
    }
    assert!(shorter >= 30, "{shorter} of 40 are shorter");
}

/// Plans keep the collision rules and the bound, bring every robot to its goal, are the same each time, and most are
/// faster than plans that steer one robot after the other.
#[test]
fn robots_that_move_together_arrive_sooner() {
    let mut random = SplitMix64::new(5);
    let (mut planned, mut faster) = (0, 0);
    for count in [2, 3, 3, 4] {
        let (order, docks) = fixture::assembly(count, &mut random);
        let world = CollisionWorld::new(&order);
        let poses: Vec<Pose> = order.robots.iter().map(|placed| placed.pose).collect();
        let bed = BedPoses::new(poses.clone(), vec![false; count]);
        let terms = AssemblyTerms { fine: DIRECT, most_stages: assembly::MAX_PLANS };
        let mut meter = Meter::new(SearchBudget::of(order.expansions));
        let known = assembly::assemble(&order, &poses, &bed.docked, None, &docks, &mut meter, terms).ok();
        let search = |known| ShootingSearch::new(&order, &world, &bed, &docks, known).and_then(|one| one.fastest());
        let motion = known.as_ref().map(|known| MicrorobotsStepMotion::Legs {
            legs: known.legs.clone(),
            docks: known.docks.clone(),
            stages: known.stages.clone(),
        });
        let Some(found) = search(motion.as_ref()) else { continue };
        assert_eq!(search(motion.as_ref()), Some(found.clone()), "the same plan again");
        planned += 1;
        let MicrorobotsStepMotion::Legs { legs, docks: docking, stages } = &found else { panic!("it assembles") };
        faster += usize::from(known.is_some_and(|known| legs_cost(&order, legs) < known.cost));
        assert_eq!(bed.first_collision(&world, legs, docking), None);
        assert!(legs.windows(2).all(|pair| pair[0].state != pair[1].state), "consecutive legs differ");
        assert_eq!(stages.len(), count - 1, "a pair, then one robot after the other");
        let mut end = bed.clone();
        end.follow(&world, legs, docking);
        for dock in &docks {
            assert!(end.docked[dock.robot]);
            assert!(assembly::miss(order.precision, end.poses[dock.robot], dock.goal.pose) <= 1.0);
        }
        let start = Crew { poses: poses.clone(), docked: vec![false; count] };
        assert!(legs_ns(&order, legs) >= least_ns(&order, &start, &docks), "no plan undercuts the bound");
    }
    assert!(planned == 4 && faster >= 3, "{planned} planned, {faster} faster");
}

/// The bound of an assembly alone.
fn least_ns(order: &MicrorobotsOrder, start: &Crew, docks: &[Dock]) -> u64 {
    use crate::claims::microrobots::{MicrorobotsAction, MicrorobotsStep};
    let step = MicrorobotsStep { action: MicrorobotsAction::Assemble(docks.to_vec()), span: Default::default() };
    bound::least(&MicrorobotsOrder { steps: vec![step], ..order.clone() }, start).time_ns
}
