//! Builds claims on a hand, and schedules of its tips by the law of rolling, with independent records.

use crate::claims::fingers::{FingersAction, FingersOrder, FingersStep, Section};
use crate::claims::fixture::hand_order;
use crate::claims::{Claims, Job, Order};
use crate::device::fingers::{AXES, FingersFacts, Plane, channel, fixture};
use crate::geometry::outline::{Curve, Outline};
use crate::schedule::electrode_array::ElectrodeArrayState;
use crate::schedule::fingers::FingersState;
use crate::schedule::{Actuation, Channel, ChannelUnit, PlanRecord, Schedule, State, TimedState};
use crate::source::Span;
use crate::verify::tests::{self, bare, record_of, step_of};
use nalgebra::{UnitQuaternion, Vector3};
use std::f64::consts::TAU;
use std::sync::Arc;

pub type Point = Vector3<f64>;

pub const MS: u64 = 1_000_000;

/// Lines per rolling step.
pub const CHORDS: u32 = 8;

pub fn facts() -> FingersFacts {
    FingersFacts {
        clearance_um: 0.5,
        retract_um: 5.0,
        speed_um_per_s: 1000.0,
        approach_um_per_s: 400.0,
        rolling_um_per_s: 40.0,
        support_un: 10.0,
        range_um: [100.0; 3],
        ..fixture::hand()
    }
}

/// An ellipse with these semi-axes, with as many contacts as fit.
pub fn section(semi_um: [f64; 2]) -> Section {
    with_contacts(Outline::Ellipse { semi_um })
}

/// An outline with an even number of contacts, for tips of 4.5 um and steps of nearly 20 deg.
pub fn with_contacts(outline: Outline) -> Section {
    let round_rad = TAU + Curve::of(&outline).expect("an outline").perimeter_um() / 4.5;
    let contacts = 2 * (round_rad / (TAU / 18.0) / 2.0).round() as u32;
    Section { outline, contacts, opposite: Some(1 + contacts / 2), step_rad: round_rad / f64::from(contacts) }
}

pub fn order() -> FingersOrder {
    let mut order = hand_order(facts(), Vec::new());
    let part = Arc::make_mut(&mut order.part);
    part.xy = section([16.0, 11.845]);
    part.xz = Some(section([16.0, 11.845]));
    part.position_um = [1.0, -2.0, 3.0];
    order
}

pub fn in_turn(orders: Vec<FingersOrder>) -> Claims {
    tests::in_turn("hand", orders.into_iter().map(Order::Fingers))
}

pub fn order_of(claims: &mut Claims, job: usize) -> &mut FingersOrder {
    let Order::Fingers(order) = &mut claims.jobs[job].order else { panic!("an order of a hand") };
    order
}

/// Straight lines of all tips for a duration, and the state at the end, if it is recorded.
#[derive(Debug, Clone)]
pub struct Line {
    pub duration_ns: u64,
    pub tips_um: Vec<Point>,
    pub state: Option<State>,
}

/// A hand while its schedule is being written.
#[derive(Debug, Clone)]
pub struct Day {
    pub order: FingersOrder,
    pub start_um: Vec<Point>,
    pub first: State,
    pub lines: Vec<Vec<Line>>,
    pub tips_um: Vec<Point>,
    pub position_um: Point,
    pub orientation: UnitQuaternion<f64>,
    pub plane: Plane,
    /// The contact of each finger, from 1; 0 for a free one.
    pub grasp: Vec<u32>,
    pub angle_index: i64,
    pub effort_deg: f64,
    pub reconfigurations: u32,
}

impl Day {
    pub fn new(order: FingersOrder) -> Day {
        let fingers = order.facts.fingers as usize;
        let position_um = Point::from(order.part.position_um);
        let home = |finger: usize| {
            let (y, x) = (TAU * finger as f64 / fingers as f64).sin_cos();
            position_um + Point::new(x, y, 0.0) * 31.0
        };
        let tips_um: Vec<Point> = (0..fingers).map(home).collect();
        let mut day = Day {
            order,
            start_um: tips_um.clone(),
            first: State::ElectrodeArray(ElectrodeArrayState { parts: Default::default() }),
            lines: Vec::new(),
            tips_um,
            position_um,
            orientation: UnitQuaternion::identity(),
            plane: Plane::Xy,
            grasp: vec![0; fingers],
            angle_index: 1,
            effort_deg: 0.0,
            reconfigurations: 0,
        };
        day.first = day.state();
        day
    }

    /// The continuation of this day with another order.
    pub fn after(&self, order: FingersOrder) -> Day {
        let (first, start_um) = (self.state(), self.tips_um.clone());
        Day { order, first, start_um, lines: Vec::new(), effort_deg: 0.0, reconfigurations: 0, ..self.clone() }
    }

    fn section(&self) -> &Section {
        self.order.part.section(self.plane).expect("an outline")
    }

    pub fn curve(&self) -> Curve {
        Curve::of(&self.section().outline).expect("an outline")
    }

    fn axes(&self) -> [Point; 2] {
        self.plane.axes().map(|axis| self.orientation * Point::from(axis))
    }

    pub fn state(&self) -> State {
        let q = self.orientation.into_inner();
        let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
        let tip = |(tip, contact): (&Point, &u32)| (*contact > 0).then(|| [tip.x, tip.y, tip.z]);
        State::Fingers(FingersState {
            grasp: self.grasp.clone(),
            angle_index: self.angle_index,
            plane: self.plane,
            tips_um: self.tips_um.iter().zip(&self.grasp).map(tip).collect(),
            position_um: self.position_um.into(),
            orientation: [q.w, q.i, q.j, q.k].map(|value| value * sign),
        })
    }

    /// Begins a step.
    pub fn step(mut self, action: FingersAction) -> Day {
        self.order.steps.push(FingersStep { action, span: Span::default() });
        self.lines.push(Vec::new());
        self
    }

    /// Adds a line of all tips, straight to their present positions.
    pub fn line(&mut self, duration_ns: u64) {
        let tips_um = self.tips_um.clone();
        self.lines.last_mut().expect("a step").push(Line { duration_ns, tips_um, state: None });
    }

    /// Records the state at the end of the last line.
    pub fn record(mut self) -> Day {
        let state = self.state();
        self.lines.last_mut().and_then(|lines| lines.last_mut()).expect("a line").state = Some(state);
        self
    }

    /// Position of the tip on a contact, moved off by `out_um` along the normal.
    pub fn seat_um(&self, rolled_rad: f64, out_um: f64) -> Point {
        let (curve, radius_um) = (self.curve(), self.order.facts.tip_radius_um);
        let spot = curve.point_at(curve.way_rolled_um(rolled_rad, radius_um));
        let (y, x) = spot.normal_rad.sin_cos();
        let off_um = radius_um + out_um;
        let [first, second] = self.axes();
        self.position_um + first * (spot.point_um[0] + x * off_um) + second * (spot.point_um[1] + y * off_um)
    }

    pub fn rolled_rad(&self, contact: u32) -> f64 {
        f64::from(contact - 1) * self.section().step_rad
    }

    /// A free finger flies to a point.
    pub fn fly(mut self, finger: usize, to_um: Point) -> Day {
        self.tips_um[finger] = to_um;
        self.line(100 * MS);
        self
    }

    /// A free finger approaches a contact: high above the part and round it, down, in, and slowly until it touches.
    pub fn come(self, finger: usize, contact: u32) -> Day {
        self.come_off(finger, contact, 0.0)
    }

    /// As [`Day::come`], but off the contact by a distance of the tip.
    pub fn come_off(mut self, finger: usize, contact: u32, off_um: f64) -> Day {
        let rolled_rad = self.rolled_rad(contact) + off_um / self.order.facts.tip_radius_um;
        let across = self.orientation * Point::from(self.plane.normal()) * 35.0;
        let above = self.tips_um[finger] + across;
        let over = self.seat_um(rolled_rad, 30.0) + across;
        self = self.fly(finger, above).fly(finger, over);
        for out_um in [30.0, 5.0, 0.0] {
            let to_um = self.seat_um(rolled_rad, out_um);
            self = self.fly(finger, to_um);
        }
        self.grasp[finger] = contact;
        self
    }

    /// A finger leaves its contact along the normal.
    pub fn go(mut self, finger: usize) -> Day {
        let rolled_rad = self.rolled_rad(self.grasp[finger]);
        self.grasp[finger] = 0;
        for out_um in [5.0, 30.0] {
            let to_um = self.seat_um(rolled_rad, out_um);
            self = self.fly(finger, to_um);
        }
        self
    }

    /// Counts a finger that comes or leaves.
    pub fn counted(mut self) -> Day {
        self.effort_deg += self.order.facts.gaiting_cost_deg;
        self.reconfigurations += 1;
        self
    }

    /// Turns the part by a fraction of a step, in one line; positive turns lead from contact 2 to contact 1.
    pub fn turned(&mut self, start: &Day, share: f64) {
        let turn_rad = share * self.section().step_rad;
        let axis = Point::from(self.plane.normal());
        self.orientation = start.orientation * UnitQuaternion::from_scaled_axis(axis * turn_rad);
        for finger in 0..self.grasp.len() {
            if start.grasp[finger] > 0 {
                self.tips_um[finger] = self.seat_um(self.rolled_rad(start.grasp[finger]) - turn_rad, 0.0);
            }
        }
        self.line(100 * MS);
    }

    /// Rolls by whole steps and records each of them.
    pub fn roll(mut self, steps: i64) -> Day {
        let count = self.section().contacts;
        for _ in 0..steps.unsigned_abs() {
            let (start, way) = (self.clone(), steps.signum());
            for chord in 1..=CHORDS {
                self.turned(&start, way as f64 * f64::from(chord) / f64::from(CHORDS));
            }
            for contact in self.grasp.iter_mut().filter(|contact| **contact > 0) {
                *contact = (i64::from(*contact) - 1 - way).rem_euclid(i64::from(count)) as u32 + 1;
            }
            self.angle_index += way;
            let holding = self.grasp.iter().filter(|contact| **contact > 0).count();
            self.effort_deg += holding as f64 * 360.0 / f64::from(self.order.facts.steps_per_turn);
            self = self.record();
        }
        self
    }

    /// Begins another turn, in a plane in which the fingers hold as well.
    pub fn turn(mut self, plane: Plane) -> Day {
        if plane != self.plane {
            let opposite = [self.section().opposite, self.order.part.section(plane).and_then(|s| s.opposite)];
            for contact in self.grasp.iter_mut().filter(|contact| Some(**contact) == opposite[0]) {
                *contact = opposite[1].expect("a contact");
            }
        }
        (self.plane, self.angle_index) = (plane, 1);
        self
    }

    /// Carries the part with all fingers.
    pub fn carry(mut self, by: [f64; 3]) -> Day {
        let half_um = Point::from(by) / 2.0;
        for _ in 0..2 {
            self.tips_um.iter_mut().for_each(|tip_um| *tip_um += half_um);
            self.position_um += half_um;
            self.line(100 * MS);
        }
        self.record()
    }

    /// Rests for a duration.
    pub fn still(mut self, duration_ns: u64) -> Day {
        self.line(duration_ns);
        self
    }

    pub fn rotate(self, plane: Plane, steps: i64) -> Day {
        let day = self.turn(plane);
        let angle_rad = day.section().step_rad * steps as f64;
        day.step(FingersAction::Rotate { plane, steps: steps as i32, angle_rad })
    }

    pub fn both(&self) -> (Schedule, Claims) {
        let claims = in_turn(vec![self.order.clone()]);
        (schedule(&claims, std::slice::from_ref(self)), claims)
    }
}

/// The schedule of successive days, with their records.
pub fn schedule(claims: &Claims, days: &[Day]) -> Schedule {
    let mut schedule = bare(claims);
    let fingers = days[0].order.facts.fingers as usize;
    for (finger, axis) in (0..fingers).flat_map(|finger| (0..AXES.len()).map(move |axis| (finger, axis))) {
        let name = format!("hand.{}", channel(finger, axis));
        schedule.channels.push(Channel {
            name,
            device: "hand".into(),
            unit: ChannelUnit::Micrometre,
            wire: None,
            rest_v: 0.0,
        });
    }
    for (index, day) in days.iter().enumerate() {
        run(&mut schedule, &claims.jobs[index], index, day);
    }
    schedule.actuations.sort_by_key(|actuation| (actuation.start_ns, actuation.channel));
    schedule
}

fn run(schedule: &mut Schedule, job: &Job, index: usize, day: &Day) {
    let start_ns = schedule.duration_ns;
    let mut at_ns = start_ns;
    let mut states = vec![TimedState { t_ns: start_ns, state: day.first.clone() }];
    let mut tips_um = day.start_um.clone();
    for lines in &day.lines {
        let step_ns = at_ns;
        for line in lines {
            let step = schedule.steps.len() as u32;
            let ends =
                tips_um.iter().zip(&line.tips_um).flat_map(|(from, to)| (0..3).map(|axis| (from[axis], to[axis])));
            for (channel, (from, to)) in ends.enumerate() {
                let (channel, start_ns, duration_ns) = (channel as u32, at_ns, line.duration_ns);
                schedule.actuations.push(Actuation { channel, start_ns, duration_ns, from, to, swing: None, step });
            }
            at_ns += line.duration_ns;
            tips_um.clone_from(&line.tips_um);
            states.extend(line.state.clone().map(|state| TimedState { t_ns: at_ns, state }));
        }
        schedule.steps.push(step_of(job, index, [step_ns, at_ns]));
    }
    let (effort_deg, reconfigurations) = (day.effort_deg, f64::from(day.reconfigurations));
    let outcomes =
        [("effort_deg", effort_deg), ("reconfigurations", reconfigurations), ("time_ns", (at_ns - start_ns) as f64)];
    schedule.plans.push(PlanRecord {
        cost: effort_deg,
        outcomes: outcomes.map(|(name, value)| (name.to_owned(), value)).into(),
        states,
        ..record_of(job, "joint_astar", ["effort", "deg"], [start_ns, at_ns])
    });
    schedule.duration_ns = at_ns;
}
