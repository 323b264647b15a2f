//! The sections of a part made ready for planning: their curves, the ways to their contacts, and the tables of their grasp graphs.

use super::graph::{Entry, Leg};
use super::mechanics::{self, Asked, Contacts, Load, TooManyGrasps};
use super::routes::{Holding, Route, Turning};
use super::tables::Tables;
use super::ways::{Hand, Reach, Side};
use crate::check::claims::fingers::{FingersOrder, Section, Turn};
use crate::device::fingers::Plane;
use crate::geometry::outline::{Curve, OutlineError};
use nalgebra::{Unit, UnitQuaternion, Vector3};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A part's sections, and what has been made of them so far.
pub struct Sections<'a> {
    order: &'a FingersOrder,
    xy: Ready<'a>,
    xz: Option<Ready<'a>>,
    known: BTreeMap<Key, Arc<Tables>>,
}

/// A section with what is asked of it all the time.
struct Ready<'a> {
    section: &'a Section,
    curve: Curve,
    reach: Reach,
}

/// What tables depend on: the plane, and where there is a load also the part's orientation when the leg begins, bit for bit, and
/// its lowest angle.
type Key = (Plane, Option<([u64; 4], i32)>);

impl<'a> Sections<'a> {
    /// The sections of an order's part.
    ///
    /// # Errors
    /// Where an outline cannot be followed; the checker refuses such parts.
    pub fn of(order: &'a FingersOrder) -> Result<Sections<'a>, OutlineError> {
        let ready = |section: &'a Section| -> Result<Ready<'a>, OutlineError> {
            let curve = Curve::of(&section.outline)?;
            let reach = Reach::new(&curve, &order.facts, section.contacts);
            Ok(Ready { section, curve, reach })
        };
        let xz = order.part.xz.as_ref().map(ready).transpose()?;
        Ok(Sections { order, xy: ready(&order.part.xy)?, xz, known: BTreeMap::new() })
    }

    /// The hand with its sections, for the ways of its fingers.
    pub fn hand(&self) -> Hand<'_> {
        Hand { facts: &self.order.facts, xy: self.xy.side(), xz: self.xz.as_ref().map(Ready::side) }
    }

    fn ready(&self, plane: Plane) -> &Ready<'a> {
        match plane {
            Plane::Xy => &self.xy,
            Plane::Xz => self.xz.as_ref().expect("the checker lets flat parts turn about z only"),
        }
    }

    /// By how much a step in a plane turns the part.
    pub fn step_rad(&self, plane: Plane) -> f64 {
        self.ready(plane).section.step_rad
    }

    /// The contact opposite to the first one in a plane, from 0.
    fn opposite(&self, plane: Plane) -> usize {
        self.ready(plane).section.opposite.map_or(0, |contact| contact as usize - 1)
    }

    /// The legs of a route that begins in an orientation.
    ///
    /// # Errors
    /// Where a section has too many contacts for its tables.
    pub fn legs(&mut self, route: &Route, start: UnitQuaternion<f64>) -> Result<Vec<Leg>, TooManyGrasps> {
        let mut legs = Vec::with_capacity(route.len());
        let mut orientation = start;
        let mut before: Option<Plane> = None;
        for Turning { turn, pin, .. } in route {
            let entry = match before {
                Some(plane) if plane != turn.plane => {
                    Entry::Across { old: [0, self.opposite(plane)], new: [0, self.opposite(turn.plane)] }
                }
                Some(_) | None => Entry::Same,
            };
            let [lowest, highest] = self.angles(*turn);
            let tables = self.tables(turn.plane, orientation, [lowest, highest])?;
            legs.push(Leg { tables, steps: turn.steps, lowest, highest, entry, end: *pin });
            orientation = self.turned(orientation, *turn);
            before = Some(turn.plane);
        }
        Ok(legs)
    }

    /// The angles that a turn may visit: once round on its own side, as in the paper.
    fn angles(&self, turn: Turn) -> [i32; 2] {
        let round = i32::try_from(self.order.facts.steps_per_turn).unwrap_or(i32::MAX);
        if turn.steps < 0 { [turn.steps.min(-round), 0] } else { [0, turn.steps.max(round)] }
    }

    /// The orientation after a turn.
    pub fn turned(&self, orientation: UnitQuaternion<f64>, turn: Turn) -> UnitQuaternion<f64> {
        let axis = Unit::new_unchecked(Vector3::from(turn.plane.normal()));
        orientation * UnitQuaternion::from_axis_angle(&axis, f64::from(turn.steps) * self.step_rad(turn.plane))
    }

    /// An order in which the fingers that hold, counted from 0, can leave until none is left; `None` if there is none, or if the
    /// section has too many contacts for its tables.
    ///
    /// Of three fingers the first one leaves as in a turn; what the part then rests on holds it against the last two.
    pub fn leaving(&mut self, holding: Holding, orientation: UnitQuaternion<f64>) -> Option<Vec<usize>> {
        let tables = self.tables(holding.plane, orientation, [0, 0]).ok()?;
        let reach = &self.ready(holding.plane).reach;
        let held = |finger: &usize| Some((*finger, holding.grasp.contact(*finger)?));
        let mut stay: Vec<(usize, usize)> = (0..self.order.facts.fingers as usize).filter_map(|f| held(&f)).collect();
        let mut order = Vec::new();
        while !stay.is_empty() {
            let goes = (0..stay.len()).find(|index| {
                let rest: Vec<usize> =
                    stay.iter().map(|(_, contact)| *contact).filter(|c| *c != stay[*index].1).collect();
                let holds = match rest.as_slice() {
                    [i, j] => tables.layer(0).leave.has(tables.three(*i, *j, stay[*index].1)),
                    _ => true,
                };
                holds && reach.way(stay[*index].1, &rest).is_some()
            })?;
            order.push(stay.remove(goes).0);
        }
        Some(order)
    }

    /// The tables of a leg in a plane that begins in an orientation and visits these angles.
    fn tables(
        &mut self,
        plane: Plane,
        orientation: UnitQuaternion<f64>,
        [lowest, highest]: [i32; 2],
    ) -> Result<Arc<Tables>, TooManyGrasps> {
        let load = Load::seen(plane, &orientation, self.order.load_un, self.order.part.centre_um);
        let turned = orientation.coords.as_slice().iter().map(|number| number.to_bits());
        let mut bits = [0; 4];
        bits.iter_mut().zip(turned).for_each(|(bits, of)| *bits = of);
        let key = (plane, (!load.is_none()).then_some((bits, lowest)));
        if let Some(known) = self.known.get(&key) {
            return Ok(Arc::clone(known));
        }
        let facts = &self.order.facts;
        let ready = self.ready(plane);
        let contacts = Contacts::of(ready.section, &ready.curve, facts.tip_radius_um);
        let angles = (highest - lowest) as usize + 1;
        let asked = Asked { facts, contacts, load, lowest: i64::from(lowest), angles };
        let tables = Arc::new(mechanics::tables(&asked, &mut |i, j, k| ready.reach.reaches(i, j, k))?);
        self.known.insert(key, Arc::clone(&tables));
        Ok(tables)
    }
}

impl Ready<'_> {
    fn side(&self) -> Side<'_> {
        Side { section: self.section, curve: &self.curve, reach: &self.reach }
    }
}
