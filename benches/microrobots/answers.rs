//! Response time of the controller, over whole assemblies.

use crate::fields::{self, checked};
use std::time::Instant;
use tweeze::claims::microrobots::MicrorobotsOrder;
use tweeze::diagnostic::Sink;
use tweeze::geometry::Pose;
use tweeze::plan::microrobots::control::{Command, ControlPhase, Controller, Pilot};
use tweeze::plan::microrobots::simulation::{Disturbances, SimulatedBed};
use tweeze::plan::{self, Motion};

/// Trials of each plan; then their seed.
const TRIALS: u64 = 20;
const SEED: u64 = 7;

/// Side of the fields.
const SIDE_UM: f64 = 4_000.0;

/// Time limit for an answer.
const LIMIT_US: f64 = 5_000.0;

/// Number of times that each answer is computed; the least time counts, so that other programs disturb little.
const REPEATS: usize = 3;

/// A controller with timed answers.
struct TimedPilot<'a> {
    controller: Controller<'a>,
    answers_us: Vec<f64>,
}

impl Pilot for TimedPilot<'_> {
    fn observe(&mut self, measured: &[Option<Pose>], now_ns: u64) -> Command<'_> {
        let mut least_us = f64::INFINITY;
        for _ in 0..REPEATS {
            let mut same = self.controller.clone();
            let start = Instant::now();
            std::hint::black_box(same.observe(measured, now_ns));
            least_us = least_us.min(start.elapsed().as_secs_f64() * 1e6);
        }
        self.answers_us.push(least_us);
        self.controller.observe(measured, now_ns)
    }

    fn step(&self) -> usize {
        self.controller.step()
    }

    fn phase(&self) -> ControlPhase {
        self.controller.phase()
    }
}

/// Times of all answers in trials of the plan for one field; `None` if it has no plan.
fn answers_us(count: usize, seed: u64) -> Option<Vec<f64>> {
    let claims = checked(&fields::assembly(count, SIDE_UM, seed, "time"))?;
    let order: &MicrorobotsOrder = fields::order(&claims);
    let plan = plan::plan(&claims, &mut Sink::default(), &mut |_, _, _| ())?.pop()?;
    let Motion::Microrobots(planned) = &plan.motion else { return None };
    let bed = SimulatedBed::new(order, &planned.motion, Disturbances::default())?;
    let mut all_us = Vec::new();
    for index in 0..TRIALS {
        let mut pilot = TimedPilot { controller: Controller::new(order, &planned.motion)?, answers_us: Vec::new() };
        bed.trial(SEED, index, &mut pilot);
        all_us.append(&mut pilot.answers_us);
    }
    Some(all_us)
}

/// One row for each number of robots.
pub fn table() {
    println!("\nAnswers of the controller in {TRIALS} trials of each of 4 fields of 4 mm, in microseconds.\n");
    println!("| robots | answers | median | p99 | longest | over {LIMIT_US:.0} us |");
    println!("|---|---|---|---|---|---|");
    for count in 3..=6 {
        let mut all_us: Vec<f64> = (0..4).filter_map(|seed| answers_us(count, seed)).flatten().collect();
        all_us.sort_by(f64::total_cmp);
        let at = |share: f64| all_us.get((all_us.len() as f64 * share) as usize).copied().unwrap_or(f64::NAN);
        let longest_us = all_us.last().copied().unwrap_or(f64::NAN);
        let late = all_us.iter().filter(|answer_us| **answer_us > LIMIT_US).count();
        println!("| {count} | {} | {:.1} | {:.1} | {longest_us:.1} | {late} |", all_us.len(), at(0.5), at(0.99));
    }
}
