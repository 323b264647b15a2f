//! The sections of a part made ready for planning: their curves, the ways to their contacts, and the tables of their grasp graphs.

use super::graph::{Entry, Grasp, Leg, Node, Way};
use super::mechanics::{self, Asked, Closer, Contacts, Load, TooManyGrasps, forbid};
use super::routes::{Holding, Route, Turning};
use super::tables::Tables;
use super::ways::{Hand, Reach, Side};
use crate::check::claims::fingers::{FingersOrder, Section, Turn};
use crate::device::fingers::{Facts, Plane};
use crate::geometry::outline::{Curve, OutlineError};
use nalgebra::{Unit, UnitQuaternion, Vector3};
use std::collections::BTreeMap;
use std::sync::Arc;

/// After so many lapses of one layer all its steps are looked at closely.
const MANY_LAPSES: u32 = 3;

/// What a closer look at a way says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sifted {
    /// Its grasps hold all the way.
    Sound,
    /// Some lapsed between two angles; the tables know it now.
    Lapsed,
}

/// A part's sections, and what has been made of them so far.
pub struct Sections<'a> {
    order: &'a FingersOrder,
    xy: Ready<'a>,
    xz: Option<Ready<'a>>,
    known: BTreeMap<Key, Arc<Tables>>,
    /// How many grasps of a layer were found to lapse.
    lapses: BTreeMap<(Key, usize), u32>,
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
        Ok(Sections { order, xy: ready(&order.part.xy)?, xz, known: BTreeMap::new(), lapses: BTreeMap::new() })
    }

    /// The hand with its sections, for the ways of its fingers.
    pub fn hand(&self) -> Hand<'_> {
        Hand { facts: &self.order.facts, xy: self.xy.side(), xz: self.xz.as_ref().map(Ready::side) }
    }

    fn ready(&self, plane: Plane) -> &Ready<'a> {
        ready(&self.xy, self.xz.as_ref(), plane)
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

    /// Looks closer at every step that a way rolls, and takes those out of the tables in which its grasp lapses; whether there were any.
    ///
    /// The tables look at a few instants of each step, a closer look at many. A way that passes is cheapest still, since only edges
    /// that do not exist were taken out. Where a layer lapses again and again, all of it is looked at closely, so that the search is
    /// not repeated for each of its edges.
    pub fn sift(&mut self, route: &Route, way: &Way, start: UnitQuaternion<f64>) -> Sifted {
        let mut orientation = start;
        let mut sifted = Sifted::Sound;
        for (turning, nodes) in route.iter().zip(&way.legs) {
            let plane = turning.turn.plane;
            let load = Load::seen(plane, &orientation, self.order.load_un, self.order.part.centre_um);
            let [lowest, _] = self.angles(turning.turn);
            let key = key(plane, orientation, lowest, &load);
            let ready = ready(&self.xy, self.xz.as_ref(), plane);
            let closer = Closer::of(&self.order.facts, ready.contacts(&self.order.facts), load);
            for (angle, grasp) in rolls(nodes).filter(|(angle, grasp)| !closer.lasts(*angle, &contacts_of(*grasp))) {
                let Some(tables) = self.known.get_mut(&key) else { continue };
                let tables = Arc::make_mut(tables);
                let layer = if tables.layers.len() == 1 { 0 } else { (angle - lowest) as usize };
                forbid(tables, layer, &contacts_of(grasp));
                let lapses = self.lapses.entry((key, layer)).or_default();
                *lapses += 1;
                if *lapses == MANY_LAPSES {
                    closer.sift(tables, layer, angle);
                }
                sifted = Sifted::Lapsed;
            }
            orientation = self.turned(orientation, turning.turn);
        }
        sifted
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
        let key = key(plane, orientation, lowest, &load);
        if let Some(known) = self.known.get(&key) {
            return Ok(Arc::clone(known));
        }
        let facts = &self.order.facts;
        let ready = self.ready(plane);
        let contacts = ready.contacts(facts);
        let angles = (highest - lowest) as usize + 1;
        let asked = Asked { facts, contacts, load, lowest: i64::from(lowest), angles };
        let tables = Arc::new(mechanics::tables(&asked, &mut |i, j, k| ready.reach.reaches(i, j, k))?);
        self.known.insert(key, Arc::clone(&tables));
        Ok(tables)
    }
}

fn ready<'s, 'a>(xy: &'s Ready<'a>, xz: Option<&'s Ready<'a>>, plane: Plane) -> &'s Ready<'a> {
    match plane {
        Plane::Xy => xy,
        Plane::Xz => xz.expect("the checker lets flat parts turn about z only"),
    }
}

/// The contacts that a grasp holds, from 0.
fn contacts_of(grasp: Grasp) -> Vec<usize> {
    (0..grasp.0.len()).filter_map(|finger| grasp.contact(finger)).collect()
}

/// The steps that a leg rolls: the lower angle of each, and the grasp there.
fn rolls(nodes: &[Node]) -> impl Iterator<Item = (i32, Grasp)> {
    let steps = nodes.windows(2).filter(|pair| pair[0].angle != pair[1].angle);
    steps.filter_map(|pair| pair.iter().min_by_key(|node| node.angle)).map(|node| (node.angle, node.grasp))
}

/// What the tables of a leg are known by.
fn key(plane: Plane, orientation: UnitQuaternion<f64>, lowest: i32, load: &Load) -> Key {
    let [x, y, z, w]: [f64; 4] = orientation.coords.into();
    (plane, (!load.is_across()).then_some(([x, y, z, w].map(f64::to_bits), lowest)))
}

impl Ready<'_> {
    fn contacts(&self, facts: &Facts) -> Contacts<'_> {
        Contacts::of(self.section, &self.curve, facts.tip_radius_um)
    }

    fn side(&self) -> Side<'_> {
        Side { section: self.section, curve: &self.curve, reach: &self.reach }
    }
}
