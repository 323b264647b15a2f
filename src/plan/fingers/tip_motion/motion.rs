//! Converts a course into a motion, act by act.

use super::rolling;
use super::sphere::{self, Arc};
use super::{FingerAct, FingersCourse, HandSections, MAX_MOVES, PreparedSection, TipMotionError};
use crate::device::fingers::{AXES, Plane};
use crate::plan::fingers::{FingersMotion, HeldGrasp, Stance, TipsMove};
use crate::real::Real;
use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector2, Vector3};

/// Positioning tolerance, in micrometres.
const THERE_UM: f64 = 1e-9;

/// Largest deviation of a tip from its contact, as a share of the tolerance.
const MAX_CONTACT_OFFSET: f64 = 0.9;

/// The motion of the fingers in a course.
pub fn motion(hand: &HandSections, course: &FingersCourse) -> Result<FingersMotion, TipMotionError> {
    if !is_sound(hand, &course.start) {
        return Err(TipMotionError::Unfit { step: 0 });
    }
    let mut walk = MotionWalk::new(hand, &course.start);
    let mut steps = Vec::with_capacity(course.steps.len());
    walk.check_range();
    for (step, acts) in course.steps.iter().enumerate() {
        walk.step = step;
        for act in acts {
            walk.act(act)?;
        }
        walk.count += walk.moves.len();
        steps.push(std::mem::take(&mut walk.moves));
    }
    walk.beyond.map_or(Ok(FingersMotion { start: course.start.clone(), steps }), Err)
}

/// Whether a stance has all fingers of the hand, and only contacts of its part.
fn is_sound(hand: &HandSections, start: &Stance) -> bool {
    let fingers = hand.facts.fingers as usize;
    let contacts = hand.side(start.hold.plane).map_or(0, |side| side.reach.contacts());
    let are_there = start.hold.grasp.iter().all(|contact| *contact as usize <= contacts);
    start.tips_um.len() == fingers && start.hold.grasp.len() == fingers && are_there
}

/// Offset of a holding tip from the nominal position on its contact.
///
/// Two sections rarely agree on a tip position to the last nanometre. A tip that continues in another plane stays where it is, and
/// rolls from there: moving it to the exact place of its contact would make it slip and turn the part.
#[derive(Debug, Clone, Copy, Default)]
struct ContactOffset {
    /// Along the outline, as a rolling coordinate.
    rolled_rad: f64,
    gap_um: f64,
    /// Out of the plane.
    height_um: f64,
}

/// Current state of the conversion.
struct MotionWalk<'a> {
    hand: &'a HandSections<'a>,
    tips_um: Vec<Vector3<f64>>,
    grasp: Vec<u32>,
    /// Offset of each finger.
    contact_offsets: Vec<ContactOffset>,
    plane: Plane,
    angle_index: i64,
    position_um: Vector3<f64>,
    /// The orientation at `base_index` of the turn, so that rounding does not accumulate over steps.
    base: UnitQuaternion<f64>,
    base_index: i64,
    /// Moves of the current step.
    moves: Vec<TipsMove>,
    /// Number of moves of the previous steps.
    count: usize,
    step: usize,
    /// The worst excess beyond a stage's range, and its size.
    beyond: Option<TipMotionError>,
    worst_um: f64,
}

impl<'a> MotionWalk<'a> {
    fn new(hand: &'a HandSections<'a>, start: &Stance) -> Self {
        let [w, x, y, z] = start.hold.orientation;
        let mut walk = MotionWalk {
            hand,
            contact_offsets: vec![ContactOffset::default(); start.hold.grasp.len()],
            tips_um: start.tips_um.iter().map(|tip| Vector3::from(*tip)).collect(),
            grasp: start.hold.grasp.clone(),
            plane: start.hold.plane,
            angle_index: start.hold.angle_index,
            position_um: Vector3::from(start.hold.position_um),
            base: UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)),
            base_index: start.hold.angle_index,
            moves: Vec::new(),
            count: 0,
            step: 0,
            beyond: None,
            worst_um: 0.0,
        };
        (0..walk.grasp.len()).for_each(|finger| walk.measure_contact_offset(finger));
        walk
    }

    /// Makes a holding finger continue from the position of its tip.
    fn measure_contact_offset(&mut self, finger: usize) {
        self.contact_offsets[finger] = ContactOffset::default();
        let (contact, Some(side)) = (self.grasp[finger], self.hand.side(self.plane)) else { return };
        if contact == 0 {
            return;
        }
        let from_origin = self.orientation(0.0).inverse() * (self.tips_um[finger] - self.position_um);
        let along = |axis: [f64; 3]| Vector3::from(axis).dot(&from_origin);
        let nearest = side.curve.nearest(self.plane.axes().map(along));
        let tip_radius_um = self.hand.facts.tip_radius_um;
        let round_rad = f64::from(side.section.contacts) * side.section.step_rad;
        let off_rad =
            side.curve.rolled_rad(nearest.way_um, tip_radius_um) - f64::from(contact - 1) * side.section.step_rad;
        self.contact_offsets[finger] = ContactOffset {
            rolled_rad: off_rad - round_rad * (off_rad / round_rad).round(),
            gap_um: nearest.distance_um - tip_radius_um,
            height_um: along(self.plane.normal()),
        };
    }

    /// Distance of a holding tip from the nominal position on its contact.
    fn contact_offset_um(&self, finger: usize) -> f64 {
        let ContactOffset { rolled_rad, gap_um, height_um } = self.contact_offsets[finger];
        Vector3::new(rolled_rad * self.hand.facts.tip_radius_um, gap_um, height_um).norm()
    }

    fn act(&mut self, act: &FingerAct) -> Result<(), TipMotionError> {
        match act {
            FingerAct::Begin { plane, grasp } => self.begin(*plane, grasp),
            FingerAct::Turn(plane) => self.turn(*plane),
            FingerAct::Roll(steps) => (0..steps.unsigned_abs()).try_for_each(|_| self.roll(i64::from(steps.signum()))),
            FingerAct::Place { finger, contact } => {
                self.come(*finger, *contact)?;
                self.record();
                Ok(())
            }
            FingerAct::Leave { finger } => {
                self.go(*finger)?;
                self.record();
                Ok(())
            }
            FingerAct::Release { order } => self.release(order),
            FingerAct::Translate(by_um) => self.translate(Vector3::from(*by_um)),
            FingerAct::Wait(0) => Ok(()),
            FingerAct::Wait(duration_ns) => self.push(*duration_ns, self.tips_um.clone()),
        }
    }

    fn begin(&mut self, plane: Plane, grasp: &[u32]) -> Result<(), TipMotionError> {
        let is_free = self.grasp.iter().all(|contact| *contact == 0);
        if !is_free || grasp.len() != self.grasp.len() {
            return Err(self.unfit());
        }
        self.turn(plane)?;
        let side = self.side()?;
        let comers: Vec<usize> = (0..grasp.len()).filter(|finger| grasp[*finger] != 0).collect();
        let contacts: Vec<usize> = comers.iter().map(|finger| grasp[*finger] as usize - 1).collect();
        if contacts.iter().any(|contact| *contact >= side.reach.contacts()) {
            return Err(self.unfit());
        }
        let Some(order) = side.reach.order(&contacts) else {
            let finger = comers.last().copied().unwrap_or(0);
            return Err(self.blocked(finger, grasp[finger]));
        };
        order.iter().try_for_each(|index| self.come(comers[*index], grasp[comers[*index]]))?;
        self.record();
        Ok(())
    }

    /// Restarts the count of angles for a new turn.
    fn turn(&mut self, plane: Plane) -> Result<(), TipMotionError> {
        self.base = self.orientation(0.0);
        (self.base_index, self.angle_index) = (1, 1);
        if plane != self.plane {
            let old = self.side()?.section.opposite;
            self.plane = plane;
            let new = self.side()?.section.opposite;
            for finger in 0..self.grasp.len() {
                self.cross(finger, [old, new])?;
            }
        }
        Ok(())
    }

    /// Renumbers a finger's contact for the new plane, in which it must be at the same place.
    fn cross(&mut self, finger: usize, [old, new]: [Option<u32>; 2]) -> Result<(), TipMotionError> {
        let contact = self.grasp[finger];
        if contact > 1 {
            self.grasp[finger] = new.filter(|_| old == Some(contact)).ok_or(self.unfit())?;
        }
        self.measure_contact_offset(finger);
        let off_um = self.contact_offset_um(finger);
        if off_um <= MAX_CONTACT_OFFSET * self.hand.facts.tolerance_um {
            return Ok(());
        }
        Err(TipMotionError::OffContact { step: self.step, finger, contact: self.grasp[finger], off_um })
    }

    /// Rolls by one step of the turn, in chords of equal angles.
    fn roll(&mut self, sense: i64) -> Result<(), TipMotionError> {
        let side = self.side()?;
        if self.grasp.iter().filter(|contact| **contact != 0).count() < 2 {
            return Err(self.unfit());
        }
        let step_rad = side.section.step_rad;
        let chords = rolling::chords(side.curve, self.hand.facts, step_rad).ok_or(self.too_fine())?;
        for chord in 1..=chords {
            let rolled_rad = sense as f64 * step_rad * f64::from(chord) / f64::from(chords);
            let mut tips_um = self.tips_um.clone();
            for (finger, tip) in tips_um.iter_mut().enumerate().filter(|(finger, _)| self.grasp[*finger] != 0) {
                *tip = self.touch(finger, rolled_rad)?;
            }
            self.glide(tips_um, self.hand.facts.rolling_um_per_s)?;
        }
        let contacts = i64::from(side.section.contacts);
        let next = |contact: u32| ((i64::from(contact) - 1 - sense).rem_euclid(contacts) + 1) as u32;
        for contact in self.grasp.iter_mut().filter(|contact| **contact != 0) {
            *contact = next(*contact);
        }
        self.angle_index += sense;
        self.record();
        Ok(())
    }

    /// Moves a free finger to a contact: on its sphere to the end of the approach path, then inward, slowly at the end.
    fn come(&mut self, finger: usize, contact: u32) -> Result<(), TipMotionError> {
        if self.grasp.get(finger) != Some(&0) || contact == 0 {
            return Err(self.unfit());
        }
        let [touch_um, bend_um, end_um] = self.way(finger, contact)?;
        self.clear(finger, [bend_um, end_um])?;
        let from = (self.tips_um[finger] - self.position_um).try_normalize(0.0).unwrap_or(Vector3::x());
        let to = (end_um - self.position_um).normalize();
        self.travel(finger, Arc::between(from, to))?;
        self.shift(finger, end_um, self.hand.facts.speed_um_per_s)?;
        self.shift(finger, bend_um, self.hand.facts.speed_um_per_s)?;
        self.shift(finger, touch_um, self.hand.facts.approach_um_per_s)?;
        self.grasp[finger] = contact;
        self.contact_offsets[finger] = ContactOffset::default();
        Ok(())
    }

    /// Moves a finger from its contact back to its sphere.
    fn go(&mut self, finger: usize) -> Result<(), TipMotionError> {
        let contact = self.grasp.get(finger).copied().filter(|contact| *contact != 0).ok_or(self.unfit())?;
        self.grasp[finger] = 0;
        let [_, bend_um, end_um] = self.way(finger, contact)?;
        self.clear(finger, [bend_um, end_um])?;
        self.shift(finger, bend_um, self.hand.facts.approach_um_per_s)?;
        self.shift(finger, end_um, self.hand.facts.speed_um_per_s)
    }

    fn release(&mut self, order: &[usize]) -> Result<(), TipMotionError> {
        order.iter().try_for_each(|finger| self.go(*finger))?;
        let is_free = self.grasp.iter().all(|contact| *contact == 0);
        self.record();
        if is_free { Ok(()) } else { Err(self.unfit()) }
    }

    fn translate(&mut self, by_um: Vector3<f64>) -> Result<(), TipMotionError> {
        self.position_um += by_um;
        let tips_um: Vec<Vector3<f64>> = self.tips_um.iter().map(|tip| tip + by_um).collect();
        // Free tips move along.
        let (facts, any_free) = (self.hand.facts, self.grasp.contains(&0));
        let free_um_per_s = if any_free { facts.speed_um_per_s } else { f64::INFINITY };
        self.push(duration_ns(by_um.norm(), facts.rolling_um_per_s.min(free_um_per_s)), tips_um)?;
        self.record();
        Ok(())
    }

    /// Moves free fingers aside, on their spheres, if a segment would come too near to their tips.
    fn clear(&mut self, finger: usize, segment: [Vector3<f64>; 2]) -> Result<(), TipMotionError> {
        let facts = self.hand.facts;
        let apart_um = 2.0 * facts.tip_radius_um + facts.clearance_um;
        let segment = segment.map(|point| point - self.position_um);
        for other in (0..self.grasp.len()).filter(|other| *other != finger) {
            if self.grasp[other] != 0 {
                continue;
            }
            let place = self.tips_um[other] - self.position_um;
            if let Some(arc) = sphere::aside(place, segment, apart_um) {
                self.travel(other, arc)?;
                self.shift(other, self.position_um + arc.at(arc.angle_rad) * place.norm(), facts.speed_um_per_s)?;
            }
        }
        Ok(())
    }

    /// Moves a free finger along a great circle of its sphere, except for the last chord.
    fn travel(&mut self, finger: usize, arc: Arc) -> Result<(), TipMotionError> {
        let facts = self.hand.facts;
        let radius_um = self.hand.sphere_um(finger);
        let chords = arc.chords(radius_um, facts.tolerance_um).ok_or(self.too_fine())?;
        for chord in 1..chords {
            let angle_rad = arc.angle_rad * f64::from(chord) / f64::from(chords);
            self.shift(finger, self.position_um + arc.at(angle_rad) * radius_um, facts.speed_um_per_s)?;
        }
        Ok(())
    }

    /// Touch, bend and end of a finger's path to or from a contact, in the hand's frame, given the other holding fingers.
    fn way(&self, finger: usize, contact: u32) -> Result<[Vector3<f64>; 3], TipMotionError> {
        let reach = self.side()?.reach;
        let index = |contact: &u32| *contact as usize - 1;
        let holding: Vec<usize> = self.grasp.iter().filter(|contact| **contact != 0).map(index).collect();
        if index(&contact) >= reach.contacts() {
            return Err(self.unfit());
        }
        let way = reach.way(index(&contact), &holding).ok_or(self.blocked(finger, contact))?;
        let orientation = self.orientation(0.0);
        let placed = |place: Vector2<f64>| self.placed(orientation, place);
        Ok([placed(way.touch_um), placed(way.bend_um), placed(way.end_um(self.hand.sphere_um(finger)))])
    }

    /// The centre of a holding tip, in the hand's frame, after the part has rolled further by an angle.
    fn touch(&self, finger: usize, rolled_rad: f64) -> Result<Vector3<f64>, TipMotionError> {
        let (side, offset) = (self.side()?, self.contact_offsets[finger]);
        let from_rad = f64::from(self.grasp[finger] - 1) * side.section.step_rad + offset.rolled_rad;
        let (tip, normal_rad) = rolling::tip(side.curve, self.hand.facts, from_rad - rolled_rad);
        let (sin, cos) = normal_rad.sine_cosine();
        let orientation = self.orientation(rolled_rad);
        let across = orientation * Vector3::from(self.plane.normal());
        Ok(self.placed(orientation, tip + Vector2::new(cos, sin) * offset.gap_um) + across * offset.height_um)
    }

    fn placed(&self, orientation: UnitQuaternion<f64>, place: Vector2<f64>) -> Vector3<f64> {
        let [first, second] = self.plane.axes().map(Vector3::from);
        self.position_um + orientation * (first * place.x + second * place.y)
    }

    /// The part's orientation after it has turned further by an angle.
    fn orientation(&self, further_rad: f64) -> UnitQuaternion<f64> {
        let steps = (self.angle_index - self.base_index) as f64;
        let step_rad = self.hand.side(self.plane).map_or(0.0, |side| side.section.step_rad);
        let axis = Unit::new_unchecked(Vector3::from(self.plane.normal()));
        self.base * UnitQuaternion::from_axis_angle(&axis, steps * step_rad + further_rad)
    }

    fn side(&self) -> Result<PreparedSection<'a>, TipMotionError> {
        self.hand.side(self.plane).ok_or(self.unfit())
    }

    /// Moves one finger in a straight line.
    fn shift(&mut self, finger: usize, to_um: Vector3<f64>, speed_um_per_s: f64) -> Result<(), TipMotionError> {
        let mut tips_um = self.tips_um.clone();
        tips_um[finger] = to_um;
        self.glide(tips_um, speed_um_per_s)
    }

    /// Moves all tips in straight lines, the fastest one at the given speed.
    fn glide(&mut self, tips_um: Vec<Vector3<f64>>, speed_um_per_s: f64) -> Result<(), TipMotionError> {
        let lengths = tips_um.iter().zip(&self.tips_um).map(|(to, from)| (to - from).norm());
        let longest_um = lengths.fold(0.0, f64::max);
        if longest_um <= THERE_UM { Ok(()) } else { self.push(duration_ns(longest_um, speed_um_per_s), tips_um) }
    }

    fn push(&mut self, duration_ns: u64, tips_um: Vec<Vector3<f64>>) -> Result<(), TipMotionError> {
        if self.count + self.moves.len() >= MAX_MOVES {
            return Err(self.too_fine());
        }
        self.tips_um = tips_um;
        self.check_range();
        let tips_um = self.tips_um.iter().map(|tip| [tip.x, tip.y, tip.z]).collect();
        self.moves.push(TipsMove { duration_ns, tips_um, state: None });
        Ok(())
    }

    /// Records the state at the end of the last move.
    fn record(&mut self) {
        let orientation = self.orientation(0.0).normalize();
        let orientation = if orientation.w < 0.0 { -orientation } else { orientation };
        let state = HeldGrasp {
            grasp: self.grasp.clone(),
            plane: self.plane,
            angle_index: self.angle_index,
            position_um: [self.position_um.x, self.position_um.y, self.position_um.z],
            orientation: [orientation.w, orientation.i, orientation.j, orientation.k],
        };
        if let Some(last) = self.moves.last_mut() {
            last.state = Some(state);
        }
    }

    fn check_range(&mut self) {
        for (finger, tip) in self.tips_um.iter().enumerate() {
            for axis in 0..AXES.len() {
                let over_um = tip[axis].abs() - self.hand.facts.range_um[axis];
                // NaN counts as out of range.
                let beyond_um = if over_um.is_nan() { f64::INFINITY } else { over_um };
                if beyond_um > self.worst_um {
                    self.worst_um = beyond_um;
                    self.beyond = Some(TipMotionError::Range { step: self.step, finger, axis, beyond_um });
                }
            }
        }
    }

    fn unfit(&self) -> TipMotionError {
        TipMotionError::Unfit { step: self.step }
    }

    fn too_fine(&self) -> TipMotionError {
        TipMotionError::TooFine { step: self.step }
    }

    fn blocked(&self, finger: usize, contact: u32) -> TipMotionError {
        TipMotionError::Blocked { step: self.step, finger, contact }
    }
}

/// Duration of a path, in whole nanoseconds, at least one.
fn duration_ns(length_um: f64, speed_um_per_s: f64) -> u64 {
    ((length_um / speed_um_per_s * 1e9).ceil() as u64).max(1)
}
