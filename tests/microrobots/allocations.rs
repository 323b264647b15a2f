//! The controller allocates before the first measurement and never again, so that its response time does not depend on
//! the allocator.

use super::recorded::{Bench, DRIVEN, TRIO};
use allocation_counter::measure;
use tweeze::geometry::Pose;
use tweeze::plan::microrobots::control::{Command, ControlPhase, Controller, Pilot};
use tweeze::plan::microrobots::simulation::{Disturbances, SimulatedBed};

/// Counts the allocations of a controller.
struct CountedPilot<'a> {
    controller: Controller<'a>,
    answers: u64,
    allocations: u64,
    /// Control phases in which it answered.
    phases: Vec<ControlPhase>,
}

impl Pilot for CountedPilot<'_> {
    fn observe(&mut self, measured: &[Option<Pose>], now_ns: u64) -> Command<'_> {
        let CountedPilot { controller, answers, allocations, phases } = self;
        *allocations += measure(|| _ = controller.observe(measured, now_ns)).count_total;
        *answers += 1;
        if !phases.contains(&controller.phase()) {
            phases.push(controller.phase());
        }
        controller.last()
    }

    fn step(&self) -> usize {
        self.controller.step()
    }

    fn phase(&self) -> ControlPhase {
        self.controller.phase()
    }
}

#[test]
fn no_answer_of_the_controller_allocates() {
    const TRIALS: u64 = 8;
    assert!(measure(|| drop(std::hint::black_box(vec![1_u8]))).count_total > 0, "allocations are counted");
    let (mut answers, mut phases) = (0, Vec::new());
    let lost = Disturbances { lost: 0.02, wrong: 0.02, stalls: 0.02, slips: 0.01, ..Disturbances::default() };
    for steps in [TRIO, DRIVEN] {
        let bench = Bench::of(steps);
        let (order, motion) = (bench.order(), bench.motion());
        for disturbances in [Disturbances::default(), lost] {
            let bed = SimulatedBed::new(order, &motion, disturbances).expect("an assembly");
            for index in 0..TRIALS {
                let controller = Controller::new(order, &motion).expect("errors are stated");
                let mut pilot = CountedPilot { controller, answers: 0, allocations: 0, phases: Vec::new() };
                bed.trial(3, index, &mut pilot);
                assert_eq!(pilot.allocations, 0, "trial {index} of\n{steps}\nin one of {:?}", pilot.phases);
                answers += pilot.answers;
                phases.extend(pilot.phases);
            }
        }
    }
    assert!(answers > 1_000, "only {answers} answers");
    for phase in [
        ControlPhase::Legs,
        ControlPhase::Wait,
        ControlPhase::Approach,
        ControlPhase::Timing,
        ControlPhase::Meeting,
        ControlPhase::Fine,
        ControlPhase::Contact,
    ] {
        assert!(phases.contains(&phase), "{phase:?} was not tried");
    }
}
