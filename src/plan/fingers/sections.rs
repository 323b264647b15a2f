//! The sections of a part, prepared for planning: their curves, the approach paths to their contacts, and the tables of
//! their grasp graphs.

use super::graph::{Grasp, GraspNode, GraspPath, Regrasp, TurnLeg};
use super::looks::LooksBudget;
use super::mechanics::{self, Contacts, LazyGraspEvaluator, Load, NoTables, RollingChecker, TableRequest, forbid};
use super::routes::{Holding, LegEnd, RouteTurn, TurnRoute};
use super::tables::Tables;
use super::tip_motion::{ContactReach, HandSections, PreparedSection};
use crate::claims::fingers::{FingersOrder, FingersTurn, Section};
use crate::device::fingers::{FingersFacts, Plane};
use crate::geometry::outline::{Curve, OutlineError};
use crate::real::Real;
use nalgebra::{Unit, UnitQuaternion, Vector3};
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;

/// Number of lapses in one layer after which all its steps are checked closely.
const MANY_LAPSES: u32 = 3;

/// Result of a close check of a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RollingCheck {
    /// Its grasps hold throughout.
    Sound,
    /// Some grasps lapse between two angles; the tables now exclude those steps.
    Lapsed,
}

/// A part's sections, and cached data derived from them.
pub struct Sections<'a> {
    order: &'a FingersOrder,
    xy: Ready<'a>,
    xz: Option<Ready<'a>>,
    known: BTreeMap<TableKey, Arc<Tables>>,
    /// Number of lapses found in each layer.
    lapses: BTreeMap<(TableKey, usize), u32>,
    /// Lazily evaluated grasps under a load.
    lazy: BTreeMap<LazyKey, Rc<LazyGraspEvaluator>>,
    load_evaluation: LoadEvaluation,
    looks: Rc<LooksBudget>,
}

/// Evaluation of grasps under a load.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoadEvaluation {
    /// Lazily, grasp by grasp, as the search meets them.
    Lazy,
    /// Eagerly: tables of all grasps at all angles are built before the search, which gives better bounds from the start.
    Tabulated,
}

/// A section with its prepared data.
struct Ready<'a> {
    section: &'a Section,
    curve: Curve,
    reach: ContactReach,
}

/// Key of tables: the plane and, under a load, the bits of the part's orientation at the start of the leg, and the leg's lowest and
/// highest angle.
type TableKey = (Plane, Option<([u64; 4], [i32; 2])>);

/// Key of a leg's lazily evaluated grasps: the plane, and the bits of the part's orientation at the start of the leg.
type LazyKey = (Plane, [u64; 4]);

/// Key of a plane's tables without a load, in which fingers may be removed wherever they may be placed.
fn unloaded(plane: Plane) -> TableKey {
    (plane, Some(([u64::MAX; 4], [0; 2])))
}

impl<'a> Sections<'a> {
    /// The sections of an order's part.
    ///
    /// # Errors
    /// If an outline cannot be followed; the checker rejects such parts.
    pub fn of(order: &'a FingersOrder, looks: Rc<LooksBudget>) -> Result<Sections<'a>, OutlineError> {
        let ready = |section: &'a Section| -> Result<Ready<'a>, OutlineError> {
            let curve = Curve::of(&section.outline)?;
            let reach = ContactReach::new(&curve, &order.facts, section.contacts);
            Ok(Ready { section, curve, reach })
        };
        let xz = order.part.xz.as_ref().map(ready).transpose()?;
        Ok(Sections {
            order,
            xy: ready(&order.part.xy)?,
            xz,
            known: BTreeMap::new(),
            lapses: BTreeMap::new(),
            lazy: BTreeMap::new(),
            load_evaluation: LoadEvaluation::Lazy,
            looks,
        })
    }

    /// The hand with its sections, for the motions of its fingers.
    pub fn hand(&self) -> HandSections<'_> {
        HandSections { facts: &self.order.facts, xy: self.xy.side(), xz: self.xz.as_ref().map(Ready::side) }
    }

    /// Budget of looks of the searches.
    pub fn looks(&self) -> &Rc<LooksBudget> {
        &self.looks
    }

    /// Selects how a load is evaluated from now on.
    pub fn set_load_evaluation(&mut self, load_evaluation: LoadEvaluation) {
        self.load_evaluation = load_evaluation;
    }

    fn ready(&self, plane: Plane) -> &Ready<'a> {
        ready(&self.xy, self.xz.as_ref(), plane)
    }

    /// Angle by which a step in a plane turns the part.
    pub fn step_rad(&self, plane: Plane) -> f64 {
        self.ready(plane).section.step_rad
    }

    /// Lower bound on the distance that every tip moves while the part turns by one step in a plane; tips may be off
    /// their contacts by the tolerance.
    pub fn least_way_um(&self, plane: Plane) -> f64 {
        let ready = self.ready(plane);
        let facts = &self.order.facts;
        let contacts = ready.contacts(facts).after(0.0);
        let step_rad = ready.section.step_rad;
        let (sin, cos) = step_rad.sine_cosine();
        let moved_um = |contact: usize| {
            let [x, y] = contacts[(contact + contacts.len() - 1) % contacts.len()].tip_um;
            let [from_x, from_y] = contacts[contact].tip_um;
            (x * cos - y * sin - from_x).hypotenuse(x * sin + y * cos - from_y)
        };
        let least_um = (0..contacts.len()).map(moved_um).fold(f64::INFINITY, f64::min);
        (least_um - 2.0 * facts.tolerance_um * step_rad).max(0.0)
    }

    /// The contact opposite the first one in a plane, counted from 0.
    fn opposite(&self, plane: Plane) -> usize {
        self.ready(plane).section.opposite.map_or(0, |contact| contact as usize - 1)
    }

    /// The legs of a route that begins in the orientation `start`.
    ///
    /// # Errors
    /// If a section has too many contacts for its tables.
    pub fn legs(&mut self, route: &TurnRoute, start: UnitQuaternion<f64>) -> Result<Vec<TurnLeg>, NoTables> {
        let mut legs = Vec::with_capacity(route.len());
        let mut orientation = start;
        let mut before: Option<Plane> = None;
        for RouteTurn { turn, end, .. } in route {
            let entry = match before {
                Some(plane) if plane != turn.plane => {
                    Regrasp::Across { old: [0, self.opposite(plane)], new: [0, self.opposite(turn.plane)] }
                }
                Some(_) | None => Regrasp::Same,
            };
            let is_release = *end == LegEnd::Released;
            let [lowest, highest] = if is_release { [0, 0] } else { self.angles(*turn) };
            let lazy = self.lazy(turn.plane, orientation);
            let tables = match &lazy {
                _ if is_release => self.releasable(turn.plane, orientation)?,
                Some(_) => self.loosest(turn.plane)?,
                None => self.tables(turn.plane, orientation, [lowest, highest])?,
            };
            let end = if let LegEnd::Pinned(grasp) = end { Some(*grasp) } else { None };
            legs.push(TurnLeg { tables, steps: turn.steps, lowest, highest, entry, end, lazy });
            orientation = self.turned(orientation, *turn);
            before = Some(turn.plane);
        }
        Ok(legs)
    }

    /// Range of angles that a turn may visit: up to one revolution beyond its start and its goal, in either direction.
    ///
    /// The paper's turns visit one revolution in their own direction. A plan that first turns the part back may need
    /// less effort, or be the only one; with this window, a task costs as much as its mirror image.
    fn angles(&self, turn: FingersTurn) -> [i32; 2] {
        let round = i32::try_from(self.order.facts.steps_per_turn).unwrap_or(i32::MAX);
        [turn.steps.min(0).saturating_sub(round), turn.steps.max(0).saturating_add(round)]
    }

    /// The orientation after a turn.
    pub fn turned(&self, orientation: UnitQuaternion<f64>, turn: FingersTurn) -> UnitQuaternion<f64> {
        let axis = Unit::new_unchecked(Vector3::from(turn.plane.normal()));
        orientation * UnitQuaternion::from_axis_angle(&axis, f64::from(turn.steps) * self.step_rad(turn.plane))
    }

    /// Checks every rolling step of a path closely, and removes from the tables the steps in which its grasp lapses.
    ///
    /// The tables check a few instants of each step, the close check many. A path that passes is still cheapest, since
    /// only edges that do not exist were removed. In a layer with repeated lapses all steps are checked closely, so
    /// that the search is not repeated for each of its edges; this may take half of the remaining looks.
    pub fn check_rolling(&mut self, route: &TurnRoute, way: &GraspPath, start: UnitQuaternion<f64>) -> RollingCheck {
        let mut orientation = start;
        let mut check = RollingCheck::Sound;
        for (turning, nodes) in route.iter().zip(&way.legs) {
            let plane = turning.turn.plane;
            let load = Load::seen(plane, &orientation, self.order.load_un, self.order.part.centre_um);
            let angles = self.angles(turning.turn);
            let key = key(plane, orientation, angles, &load);
            let ready = ready(&self.xy, self.xz.as_ref(), plane);
            let checker = RollingChecker::of(&self.order.facts, ready.contacts(&self.order.facts), load);
            for (angle, grasp) in rolls(nodes).filter(|(angle, grasp)| !checker.lasts(*angle, &contacts_of(*grasp))) {
                if let Some(lazy) = self.lazy.get(&lazy_key(plane, orientation)) {
                    lazy.forbid(angle, &contacts_of(grasp));
                    check = RollingCheck::Lapsed;
                }
                let Some(tables) = self.known.get_mut(&key) else { continue };
                let tables = Arc::make_mut(tables);
                let layer = if tables.layers.len() == 1 { 0 } else { (angle - angles[0]) as usize };
                forbid(tables, layer, &contacts_of(grasp));
                let lapses = self.lapses.entry((key, layer)).or_default();
                *lapses += 1;
                if *lapses == MANY_LAPSES {
                    self.looks.with_half(|| checker.forbid_lapses(tables, layer, angle, &self.looks));
                }
                check = RollingCheck::Lapsed;
            }
            orientation = self.turned(orientation, turning.turn);
        }
        check
    }

    /// An order in which the holding fingers, counted from 0, can leave until none is left; `None` if there is none, or
    /// if the section has too many contacts for its tables.
    ///
    /// The first of three fingers leaves as it does during a turn; while the last two leave, the support holds the
    /// part.
    pub fn leaving(&mut self, holding: Holding, orientation: UnitQuaternion<f64>) -> Option<Vec<usize>> {
        let lazy = self.lazy(holding.plane, orientation);
        let tables = lazy.is_none().then(|| self.tables(holding.plane, orientation, [0, 0])).transpose().ok()?;
        let leaves = |rest: [usize; 2], contact: usize| match (&lazy, &tables) {
            (Some(lazy), _) => lazy.leaves(0, rest, contact),
            (None, Some(tables)) => tables.layer(0).leave.has(tables.three(rest[0], rest[1], contact)),
            (None, None) => false,
        };
        let held = |finger: usize| Some((finger, holding.grasp.contact(finger)?));
        let stay: Vec<(usize, usize)> = (0..self.order.facts.fingers as usize).filter_map(held).collect();
        let mut order = Vec::new();
        let reach = &self.ready(holding.plane).reach;
        leave_in_turn(&stay, &leaves, &|contact, rest| reach.way(contact, rest).is_some(), &mut order).then_some(order)
    }

    /// Tables of a plane without a load, in which only those grasps hold that all fingers can leave.
    fn releasable(&mut self, plane: Plane, orientation: UnitQuaternion<f64>) -> Result<Arc<Tables>, NoTables> {
        let whole = self.tables(plane, orientation, [0, 0])?;
        let mut tables = Tables { contacts: whole.contacts, layers: vec![whole.layer(0).clone()] };
        let (whole, count, reach) = (whole.layer(0), tables.contacts, &self.ready(plane).reach);
        let has_way = |contact: usize, rest: &[usize]| reach.way(contact, rest).is_some();
        let can_leave = |tables: &Tables, contacts: &[usize]| {
            let stay: Vec<(usize, usize)> = contacts.iter().copied().enumerate().collect();
            let leaves = |rest: [usize; 2], contact| whole.leave.has(tables.three(rest[0], rest[1], contact));
            leave_in_turn(&stay, &leaves, &has_way, &mut Vec::new())
        };
        for i in 0..count {
            for j in i + 1..count {
                if whole.pair.has(tables.two(i, j)) && !can_leave(&tables, &[i, j]) {
                    tables.remove_pair([i, j]);
                }
                for k in j + 1..count {
                    if whole.triple.has(tables.three(i, j, k)) && !can_leave(&tables, &[i, j, k]) {
                        tables.remove_triple([i, j, k]);
                    }
                }
            }
        }
        Ok(Arc::new(tables))
    }

    /// Whether a grasp holds under the load while nothing moves.
    pub fn bears(&mut self, holding: Holding, orientation: UnitQuaternion<f64>) -> bool {
        if self.order.load_un == [0.0; 3] {
            return true;
        }
        self.under_load(holding.plane, orientation).holds(0, &contacts_of(holding.grasp))
    }

    /// Evaluator of grasps in a plane under the load, for a part in an orientation.
    fn under_load(&mut self, plane: Plane, orientation: UnitQuaternion<f64>) -> LazyGraspEvaluator {
        let facts = &self.order.facts;
        let load = Load::seen(plane, &orientation, self.order.load_un, self.order.part.centre_um);
        LazyGraspEvaluator::of(facts, &self.ready(plane).contacts(facts), load, Rc::clone(&self.looks))
    }

    /// Lazy evaluator of a leg under the load; `None` without a load, or if the leg has tables of its own.
    fn lazy(&mut self, plane: Plane, orientation: UnitQuaternion<f64>) -> Option<Rc<LazyGraspEvaluator>> {
        if self.order.load_un == [0.0; 3] || self.load_evaluation == LoadEvaluation::Tabulated {
            return None;
        }
        let key = lazy_key(plane, orientation);
        if let Some(known) = self.lazy.get(&key) {
            return Some(Rc::clone(known));
        }
        let lazy = Rc::new(self.under_load(plane, orientation));
        self.lazy.insert(key, Rc::clone(&lazy));
        Some(lazy)
    }

    /// Tables of a plane that include all grasps possible under any load: no load acts, and fingers may be removed
    /// wherever they may be placed.
    fn loosest(&mut self, plane: Plane) -> Result<Arc<Tables>, NoTables> {
        if let Some(known) = self.known.get(&unloaded(plane)) {
            return Ok(Arc::clone(known));
        }
        let facts = &self.order.facts;
        let ready = self.ready(plane);
        let asked = TableRequest { facts, contacts: ready.contacts(facts), load: Load::NONE, lowest: 0, angles: 1 };
        let mut tables = mechanics::tables(&asked, &self.looks, &mut |i, j, k| ready.reach.reaches(i, j, k))?;
        for layer in &mut tables.layers {
            layer.leave = layer.place.clone();
        }
        let tables = Arc::new(tables);
        self.known.insert(unloaded(plane), Arc::clone(&tables));
        Ok(tables)
    }

    /// The tables of a leg in a plane that begins in an orientation and visits these angles.
    fn tables(
        &mut self,
        plane: Plane,
        orientation: UnitQuaternion<f64>,
        [lowest, highest]: [i32; 2],
    ) -> Result<Arc<Tables>, NoTables> {
        let load = Load::seen(plane, &orientation, self.order.load_un, self.order.part.centre_um);
        let key = key(plane, orientation, [lowest, highest], &load);
        if let Some(known) = self.known.get(&key) {
            return Ok(Arc::clone(known));
        }
        let facts = &self.order.facts;
        let ready = self.ready(plane);
        let contacts = ready.contacts(facts);
        let angles = (highest - lowest) as usize + 1;
        let asked = TableRequest { facts, contacts, load, lowest: i64::from(lowest), angles };
        let tables = Arc::new(mechanics::tables(&asked, &self.looks, &mut |i, j, k| ready.reach.reaches(i, j, k))?);
        self.known.insert(key, Arc::clone(&tables));
        Ok(tables)
    }
}

/// Whether fingers on contacts, as (finger, contact), can leave one after the other; `order` receives the fingers in
/// that order. `leaves` states whether the third of three may leave while two stay, `has_way` whether a finger has a
/// way out beside those that stay.
fn leave_in_turn(
    stay: &[(usize, usize)],
    leaves: &dyn Fn([usize; 2], usize) -> bool,
    has_way: &dyn Fn(usize, &[usize]) -> bool,
    order: &mut Vec<usize>,
) -> bool {
    stay.is_empty()
        || stay.iter().any(|(finger, contact)| {
            let others: Vec<(usize, usize)> = stay.iter().copied().filter(|(other, _)| other != finger).collect();
            let rest: Vec<usize> = others.iter().map(|(_, contact)| *contact).collect();
            let may_go = if let [i, j] = *rest { leaves([i, j], *contact) } else { true };
            order.push(*finger);
            let is_free = may_go && has_way(*contact, &rest) && leave_in_turn(&others, leaves, has_way, order);
            if !is_free {
                order.pop();
            }
            is_free
        })
}

fn ready<'s, 'a>(xy: &'s Ready<'a>, xz: Option<&'s Ready<'a>>, plane: Plane) -> &'s Ready<'a> {
    match plane {
        Plane::Xy => xy,
        Plane::Xz => xz.expect("the checker allows flat parts to turn about z only"),
    }
}

/// The contacts that a grasp holds, counted from 0.
fn contacts_of(grasp: Grasp) -> Vec<usize> {
    (0..grasp.0.len()).filter_map(|finger| grasp.contact(finger)).collect()
}

/// The rolling steps of a leg: the lower angle of each, and its grasp.
fn rolls(nodes: &[GraspNode]) -> impl Iterator<Item = (i32, Grasp)> {
    let steps = nodes.windows(2).filter(|pair| pair[0].angle != pair[1].angle);
    steps.filter_map(|pair| pair.iter().min_by_key(|node| node.angle)).map(|node| (node.angle, node.grasp))
}

/// Cache key of a leg's lazily evaluated grasps.
fn lazy_key(plane: Plane, orientation: UnitQuaternion<f64>) -> LazyKey {
    let [x, y, z, w]: [f64; 4] = orientation.coords.into();
    (plane, [x, y, z, w].map(f64::to_bits))
}

/// Cache key of a leg's tables.
fn key(plane: Plane, orientation: UnitQuaternion<f64>, angles: [i32; 2], load: &Load) -> TableKey {
    let [x, y, z, w]: [f64; 4] = orientation.coords.into();
    (plane, (!load.is_across()).then_some(([x, y, z, w].map(f64::to_bits), angles)))
}

impl Ready<'_> {
    fn contacts(&self, facts: &FingersFacts) -> Contacts<'_> {
        Contacts::of(self.section, &self.curve, facts.tip_radius_um)
    }

    fn side(&self) -> PreparedSection<'_> {
        PreparedSection { section: self.section, curve: &self.curve, reach: &self.reach }
    }
}
