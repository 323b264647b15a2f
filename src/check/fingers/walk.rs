//! Tracks orientation, hold and position of the part from step to step; they are known before planning, because goals
//! are fixed.
//!
//! The runs of a schedule are walked in order, and orientations become turns. Where several decompositions lead to an
//! orientation, each of them may have been taken, and the following checks hold after every one.

use super::errors;
use super::orientation::{self, MAX_DECOMPOSITIONS, Orientation};
use super::part;
use super::step;
use crate::claims::fingers::{FingersAction, FingersOrder, FingersTurn, HandPart};
use crate::claims::{Job, Order};
use crate::device::fingers::Plane;
use crate::diagnostic::{Diagnosed, Sink};
use crate::source::Span;
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Orientations nearer to each other than this count as one.
const SAME_RAD: f64 = 1e-9;

/// Greatest number of orientations that a part may have after a step.
const MAX_REACHED: usize = 256;

/// Placeholder for an orientation in the hand's frame until the runs are walked.
pub fn absolute(goal: [f64; 4]) -> FingersAction {
    FingersAction::Orient { goal, turns: Vec::new(), left_out_steps: None }
}

/// Placeholder for an orientation relative to the part's present one until the runs are walked; marked by one
/// decomposition without turns.
pub fn relative(goal: Orientation) -> FingersAction {
    FingersAction::Orient { goal: orientation::written(&goal), turns: vec![Vec::new()], left_out_steps: None }
}

/// Greatest number of larger precisions tried until one serves all orientations of a schedule.
const MAX_PRECISIONS: usize = 8;

/// Checks the demands of a schedule on each hand and its part, run after run.
pub fn check_hands(jobs: &mut [Job], sink: &mut Sink) {
    // Behind a missed orientation others may be missed by more, so the runs are walked again with larger precisions.
    if !jobs.iter().any(|job| matches!(job.order, Order::Fingers(_))) {
        return;
    }
    let mut asked = jobs.to_vec();
    let Some(mut needed_rad) = walk(jobs, None, sink) else { return };
    for _ in 0..MAX_PRECISIONS {
        let mut again = asked.clone();
        let orders = again
            .iter_mut()
            .filter_map(|job| if let Order::Fingers(order) = &mut job.order { Some(order) } else { None });
        orders.for_each(|order| order.precision_rad = order.precision_rad.max(needed_rad));
        match walk(&mut again, None, &mut Sink::default()) {
            Some(more_rad) if more_rad > needed_rad => needed_rad = more_rad,
            Some(_) | None => break,
        }
    }
    walk(&mut asked, Some(needed_rad), sink);
}

/// Walks through the runs up to the first fault, which is reported. A missed orientation is reported only if
/// `needed_rad` is given, which its help names; otherwise the precision that accepts it is returned, rounded as
/// messages show it.
fn walk(jobs: &mut [Job], needed_rad: Option<f64>, sink: &mut Sink) -> Option<f64> {
    let mut hands: BTreeMap<String, HandWalk> = BTreeMap::new();
    for job in jobs {
        let (span, run_span) = (job.span, job.run_span);
        let Order::Fingers(order) = &mut job.order else { continue };
        let hand = hands.entry(job.device.clone()).or_insert_with(|| HandWalk::of(order));
        if !hand.is_alike(&order.part) {
            sink.push(errors::other_part(run_span, &job.device, &hand.part.name, &order.part.name));
            return None;
        }
        hand.needed_rad = needed_rad;
        order.part = Arc::clone(&hand.part);
        for index in 0..order.steps.len() {
            let at = order.steps[index].span;
            let run = if run_span == span { at } else { run_span };
            let mut action = order.steps[index].action.clone();
            if let Err(wrong) = hand.advance(&mut action, at, order) {
                if let (None, Some(missed_rad)) = (needed_rad, hand.missed_rad) {
                    return Some(errors::precision_for(missed_rad));
                }
                sink.push(wrong.label_elsewhere(run, at, "run here"));
                return None;
            }
            order.steps[index].action = action;
        }
    }
    None
}

/// Whether fingers hold the part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PartHold {
    Held,
    /// Free since the release there, if there was one.
    Free(Option<Span>),
}

/// State of a hand between two steps.
struct HandWalk {
    part: Arc<HandPart>,
    hold: PartHold,
    /// The planes in which the part may have been turned last since it was grasped.
    planes: BTreeSet<Plane>,
    /// Each orientation that the part may have; never empty.
    reached: Vec<Orientation>,
    position_um: [f64; 3],
    /// Why the part cannot be handed over from one plane to the other; `None` if it can.
    junction_fault: Option<String>,
    /// The precision that serves all orientations of the schedule, where it is known.
    needed_rad: Option<f64>,
    /// Error of the missed orientation, if there is one.
    missed_rad: Option<f64>,
}

/// The decompositions of an orientation, and the fewest steps of those that were left out, if any.
type Decompositions = (Vec<Vec<FingersTurn>>, Option<u32>);

impl HandWalk {
    fn of(order: &FingersOrder) -> HandWalk {
        HandWalk {
            part: Arc::clone(&order.part),
            hold: PartHold::Free(None),
            planes: BTreeSet::new(),
            reached: vec![Orientation::identity()],
            position_um: order.part.position_um,
            junction_fault: part::junction_fault(&order.part, &order.facts),
            needed_rad: None,
            missed_rad: None,
        }
    }

    /// Whether a part of another scene is the one that the hand has turned before.
    fn is_alike(&self, part: &Arc<HandPart>) -> bool {
        let own = &self.part;
        Arc::ptr_eq(own, part) || (own.name == part.name && own.xy == part.xy && own.xz == part.xz)
    }

    fn advance(&mut self, action: &mut FingersAction, at: Span, order: &FingersOrder) -> Diagnosed {
        match action {
            FingersAction::Wait(_) => {}
            FingersAction::Grasp(_) => self.hold = PartHold::Held,
            FingersAction::Rotate { plane, steps, .. } => {
                self.check_grasp_count(*plane, at, order)?;
                self.rotate(FingersTurn { plane: *plane, steps: *steps }, at)?;
            }
            FingersAction::Orient { goal, turns, left_out_steps } => {
                let given = orientation::read(*goal);
                let (asked, absolute) = if turns.is_empty() {
                    (errors::AskedTurn::Orientation, given)
                } else {
                    (errors::AskedTurn::TurnAboutX, self.reached[0] * given)
                };
                *goal = orientation::written(&absolute);
                (*turns, *left_out_steps) = self.orient(asked, &absolute, at, order)?;
            }
            FingersAction::Translate(by_um) => self.translate(*by_um, at, order)?,
            FingersAction::Release => {
                if let PartHold::Free(released) = self.hold {
                    return Err(Box::new(errors::nothing_held(at, "release", released)));
                }
                self.hold = PartHold::Free(Some(at));
                self.planes.clear();
            }
        }
        Ok(())
    }

    /// Checks that the grasps of a turn are few enough to be searched: under a load in the plane they differ from angle
    /// to angle.
    fn check_grasp_count(&self, plane: Plane, at: Span, order: &FingersOrder) -> Diagnosed {
        let Some(section) = self.part.section(plane) else { return Ok(()) };
        let load_un = Vector3::from(order.load_un);
        if !self.reached.iter().all(|from| part::is_in_plane(from.inverse() * load_un, plane)) {
            return Ok(());
        }
        if step::are_few_grasps(section.contacts, order.facts.steps_per_turn) {
            return Ok(());
        }
        let (contacts, angles) = (section.contacts as usize, order.facts.steps_per_turn as usize + 1);
        Err(Box::new(errors::too_many_grasps(at, &self.part.name, [contacts, angles], order.facts.steps_per_turn)))
    }

    fn rotate(&mut self, turn: FingersTurn, at: Span) -> Diagnosed {
        if let Some(why) = &self.junction_fault
            && self.planes.iter().any(|plane| *plane != turn.plane)
        {
            return Err(Box::new(errors::no_junction(at, &self.part.name, why, self.part.span)));
        }
        self.hold = PartHold::Held;
        self.planes = BTreeSet::from([turn.plane]);
        let by = orientation::after(&[turn], &self.part);
        self.reached.iter_mut().for_each(|reached| *reached *= by);
        Ok(())
    }

    /// The decompositions that reach an orientation from every possible present one; if these are too many to be
    /// searched, also a lower bound on the steps of those left out.
    fn orient(
        &mut self,
        asked: errors::AskedTurn,
        goal: &Orientation,
        at: Span,
        order: &FingersOrder,
    ) -> Diagnosed<Decompositions> {
        let precision_rad = order.precision_rad;
        let mut sequences = orientation::decompositions(&(self.reached[0].inverse() * goal), &self.part);
        if sequences.is_empty() {
            return Err(Box::new(errors::flat_part(at, &self.part.name, "not to this orientation", self.part.span)));
        }
        for sequence in &mut sequences {
            let by = orientation::after(&sequence.turns, &self.part);
            sequence.off_rad = self.reached.iter().map(|reached| (reached * by).angle_to(goal)).fold(0.0, f64::max);
        }
        let best_rad = sequences.iter().map(|sequence| sequence.off_rad).fold(f64::INFINITY, f64::min);
        sequences.retain(|sequence| sequence.off_rad <= precision_rad);
        if sequences.is_empty() {
            let step_deg = self.fitting_step(asked, goal, order);
            self.missed_rad = Some(best_rad);
            let mend = errors::OrientationMend { step_deg, needed_rad: self.needed_rad.unwrap_or(best_rad) };
            return Err(Box::new(errors::orientation_missed(at, asked, best_rad, precision_rad, &mend)));
        }
        if let Some(why) = &self.junction_fault {
            let planes = |turns: &[FingersTurn]| {
                turns.iter().map(|turn| turn.plane).chain(self.planes.iter().copied()).collect()
            };
            sequences.retain(|sequence| BTreeSet::<Plane>::len(&planes(&sequence.turns)) <= 1);
            if sequences.is_empty() {
                return Err(Box::new(errors::no_junction(at, &self.part.name, why, self.part.span)));
            }
        }
        let most = MAX_DECOMPOSITIONS.min((MAX_REACHED / self.reached.len()).max(1));
        let steps = |sequence: &orientation::TurnSequence| {
            sequence.turns.iter().map(|turn| turn.steps.unsigned_abs()).sum::<u32>()
        };
        let left_out_steps = sequences.iter().skip(most).map(steps).min();
        sequences.truncate(most);
        self.take(&sequences);
        Ok((sequences.into_iter().map(|sequence| sequence.turns).collect(), left_out_steps))
    }

    /// A `step` of the device with which an orientation is reached. It is sought only where the turns before do not
    /// matter: the part is not turned yet, or the goal is relative to its present orientation.
    fn fitting_step(&self, asked: errors::AskedTurn, goal: &Orientation, order: &FingersOrder) -> Option<f64> {
        let [reached] = self.reached.as_slice() else { return None };
        let is_known = asked == errors::AskedTurn::TurnAboutX || reached.angle() < SAME_RAD;
        let turns: Vec<(Plane, f64)> = order
            .steps
            .iter()
            .filter_map(|step| match step.action {
                FingersAction::Rotate { plane, angle_rad, .. } => Some((plane, angle_rad)),
                FingersAction::Orient { .. }
                | FingersAction::Grasp(_)
                | FingersAction::Translate(_)
                | FingersAction::Release
                | FingersAction::Wait(_) => None,
            })
            .collect();
        let wanted = step::WantedTurn::Orientation(&(reached.inverse() * goal), &turns);
        let is_loaded = order.load_un.iter().any(|force_un| *force_un != 0.0);
        let demand = step::TurnDemand { precision_rad: order.precision_rad, is_loaded };
        is_known.then(|| step::nearest_fitting_step(&self.part, &order.facts, &wanted, &demand)).flatten()
    }

    /// Updates the state after a step for which any one of several decompositions may be taken.
    fn take(&mut self, sequences: &[orientation::TurnSequence]) {
        let before = std::mem::take(&mut self.planes);
        let mut reached: Vec<Orientation> = Vec::new();
        for sequence in sequences {
            match sequence.turns.last() {
                Some(turn) => drop(self.planes.insert(turn.plane)),
                None => self.planes.extend(&before),
            }
            let by = orientation::after(&sequence.turns, &self.part);
            for now in self.reached.iter().map(|from| from * by) {
                if reached.iter().all(|known| known.angle_to(&now) > SAME_RAD) {
                    reached.push(now);
                }
            }
        }
        self.reached = reached;
        self.hold = PartHold::Held;
    }

    fn translate(&mut self, by_um: [f64; 3], at: Span, order: &FingersOrder) -> Diagnosed {
        if let PartHold::Free(released) = self.hold {
            return Err(Box::new(errors::nothing_held(at, "translate", released)));
        }
        for (position_um, by_um) in self.position_um.iter_mut().zip(by_um) {
            *position_um += by_um;
        }
        match part::out_of_range(&self.part, self.position_um, &order.facts) {
            Some(wrong) => Err(Box::new(errors::part_out_of_range(at, &self.part.name, &wrong))),
            None => Ok(()),
        }
    }
}
