//! A scene as seen by one board: obstacles, parts, reservoirs and zones.

use super::board;
use super::cells::{on_board, whole_cell};
use super::cover::{ObstacleCells, SpacedPlaces, nearest_cell};
use super::errors;
use super::zones::misplaced;
use crate::check::Checker;
use crate::check::devices::CheckedDevice;
use crate::check::figures::Figures;
use crate::check::lets::Argument;
use crate::check::objects::{ObjectNames, of_other_kind};
use crate::check::scenes::{CheckedScene, SceneObject};
use crate::check::tasks::TaskSite;
use crate::check::value::Accepted;
use crate::check::value::{ShapeValue, Value};
use crate::claims::electrode_array::{
    BoardPart, BoardZone, ElectrodeArrayObstacle, ElectrodeArrayObstacleBody, ZoneSort,
};
use crate::device::electrode_array::{
    BoardNoun, ElectrodeArrayFacts, ElectrodeCell, Electrodes, MAX_OBSTACLES, MAX_PARTS, MAX_PLACED_PARTS, MAX_ZONES,
    VOCABULARY,
};
use crate::device::shape::ShapeForm;
use crate::diagnostic::{Code, Diagnostic, Sink};
use crate::quantity::digits;
use crate::source::{Span, Spanned};
use std::collections::BTreeSet;
use std::rc::Rc;
use std::sync::Arc;

/// A scene as seen by one device.
pub struct BoardScene {
    pub obstacles: Arc<Vec<ElectrodeArrayObstacle>>,
    pub parts: Arc<Vec<BoardPart>>,
    pub names: ObjectNames,
    /// Outlets of the reservoirs.
    pub outlets: Vec<Outlet>,
    /// Reservoirs by name, as indices into `outlets`.
    pub reservoirs: ObjectNames,
    pub zones: Arc<Vec<BoardZone>>,
    /// Zones by name, as indices into `zones`.
    pub sites: ObjectNames,
    pub cover: ObstacleCells,
    /// Whether all objects of the scene are valid.
    pub is_whole: bool,
}

impl BoardScene {
    /// Names of all fluids that droplets can contain: reservoirs, and the parts that the scene puts on the board.
    pub fn fluids(&self) -> BTreeSet<&str> {
        let placed = self.parts.iter().filter(|part| part.cell.is_some()).map(|part| part.name.as_str());
        self.outlets.iter().map(|outlet| outlet.name.as_str()).chain(placed).collect()
    }

    /// Whether the reservoir or part of this name is faulty, which was already reported.
    pub fn is_faulty_fluid(&self, name: &str) -> bool {
        self.names.is_faulty(name) || self.reservoirs.is_faulty(name)
    }
}

impl Checker<'_> {
    /// The scene of a task for its device; judged once.
    pub fn board_scene(&mut self, site: &TaskSite, facts: &ElectrodeArrayFacts) -> Rc<BoardScene> {
        self.scene_met(site, |checker, scene| match scene {
            Some(scene) => judged_scene(scene, &site.device, facts, checker.sink),
            None => judged(&[], &site.device, facts, checker.sink),
        })
    }
}

fn judged_scene(
    scene: &CheckedScene,
    device: &CheckedDevice,
    facts: &ElectrodeArrayFacts,
    sink: &mut Sink,
) -> BoardScene {
    let zones = ZoneSort::ALL.iter().map(|sort| (sort.name(), MAX_ZONES));
    let most: Vec<(&str, usize)> = [(BoardNoun::Part.name(), MAX_PARTS), (BoardNoun::Obstacle.name(), MAX_OBSTACLES)]
        .into_iter()
        .chain(zones)
        .collect();
    let is_placed = |object: &SceneObject| object.noun == BoardNoun::Part.name() && object.at.is_some();
    let crowd = scene.crowd_of("placed part", MAX_PLACED_PARTS, is_placed);
    if let Some(crowd) = crowd.or_else(|| scene.crowd(&most)) {
        sink.push(crowd);
        return BoardScene { is_whole: false, ..judged(&[], device, facts, sink) };
    }
    judged(&scene.objects, device, facts, sink)
}

/// The cell where a reservoir dispenses.
pub struct Outlet {
    pub name: String,
    pub cell: ElectrodeCell,
    pub span: Span,
}

/// A part that was read, with the argument of its cell if it has one.
struct StandingPart {
    part: BoardPart,
    at: Option<Argument>,
}

fn judged(
    objects: &[Rc<SceneObject>],
    device: &CheckedDevice,
    facts: &ElectrodeArrayFacts,
    sink: &mut Sink,
) -> BoardScene {
    let before = sink.errors();
    let (mut obstacles, mut standing, mut outlets, mut zones) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let (mut names, mut reservoirs) = (ObjectNames::default(), ObjectNames::default());
    let mut sites = ObjectNames::default();
    let is_droplet = facts.layout.electrodes == Electrodes::Single;
    let may_come = is_droplet || objects.iter().any(|object| object.noun == BoardNoun::Reservoir.name());
    for object in objects {
        if let Some(sort) = ZoneSort::find(&object.noun) {
            let zone = BoardSceneReader { object, device, facts, sink }.zone(sort, &zones);
            sites.insert(&object.name, zone.as_ref().map(|_| zones.len()));
            names.insert_other(&object.name, sort.name(), object.span);
            reservoirs.insert_other(&object.name, sort.name(), object.span);
            zones.extend(zone);
            continue;
        }
        let Some(noun) = BoardNoun::find(&object.noun) else {
            sink.push(of_other_kind(object, &VOCABULARY));
            continue;
        };
        let names_other = |names: &mut ObjectNames| names.insert_other(&object.name, noun.name(), object.span);
        names_other(&mut sites);
        let mut reader = BoardSceneReader { object, device, facts, sink };
        match noun {
            BoardNoun::Part => {
                let part = reader.part(may_come);
                names.insert(&object.name, part.as_ref().map(|_| standing.len()));
                names_other(&mut reservoirs);
                standing.extend(part);
            }
            BoardNoun::Reservoir => {
                let outlet = reader.outlet(&outlets);
                reservoirs.insert(&object.name, outlet.as_ref().map(|_| outlets.len()));
                names_other(&mut names);
                outlets.extend(outlet);
            }
            BoardNoun::Obstacle => {
                let obstacle = reader.obstacle();
                names_other(&mut names);
                names_other(&mut reservoirs);
                obstacles.extend(obstacle);
            }
        }
    }
    let cover = ObstacleCells::of(&obstacles, facts);
    starts(&standing, &obstacles, &cover, facts, sink);
    for outlet in &outlets {
        if let Some(obstacle) = cover.covering(outlet.cell) {
            let free = nearest_cell(outlet.cell, facts, |cell| cover.covering(cell).is_none());
            let place = BlockedCell { code: Code::E0505, cell: outlet.cell, span: outlet.span };
            sink.push(on_obstacle(&place, &obstacles[obstacle], facts, free));
        }
    }
    BoardScene {
        obstacles: Arc::new(obstacles),
        parts: Arc::new(standing.into_iter().map(|standing| standing.part).collect()),
        names,
        outlets,
        reservoirs,
        zones: Arc::new(zones),
        sites,
        cover,
        is_whole: sink.errors() == before,
    }
}

/// Reads one object of a scene.
struct BoardSceneReader<'a> {
    object: &'a SceneObject,
    device: &'a CheckedDevice,
    facts: &'a ElectrodeArrayFacts,
    sink: &'a mut Sink,
}

impl BoardSceneReader<'_> {
    /// A part; one without a place is a droplet that is dispensed or split off later.
    fn part(&mut self, may_come: bool) -> Option<StandingPart> {
        let shape = self.object.shape.as_ref();
        let is_carried = shape.is_none_or(|shape| self.is_carried(shape));
        let (name, span) = (self.object.name.clone(), self.object.span);
        if may_come && self.object.at.is_none() {
            let part = BoardPart { name, cell: None, span };
            return is_carried.then_some(StandingPart { part, at: None });
        }
        let at = self.place()?;
        let cell = self.reached(&at)?;
        let part = BoardPart { name, cell: Some(cell), span };
        is_carried.then_some(StandingPart { part, at: Some(at) })
    }

    /// The outlet of a reservoir, on an electrode that no other outlet has.
    fn outlet(&mut self, others: &[Outlet]) -> Option<Outlet> {
        let at = self.place()?;
        let cell = self.reached(&at)?;
        let span = at.span;
        if let Some(other) = others.iter().find(|other| other.cell == cell) {
            let wrong = errors::outlets_on_one_cell(&self.object.name, cell, span, other.span);
            self.sink.push(errors::given_at(wrong, &at));
            return None;
        }
        if let Some(pads) = &self.facts.reservoirs
            && pads.at(cell).is_none()
        {
            let outlets: Vec<ElectrodeCell> = pads.sequences.iter().map(|sequence| sequence.outlet).collect();
            let wrong = errors::no_reservoir_there(&self.object.name, cell, span, &outlets);
            self.sink.push(errors::given_at(wrong, &at));
            return None;
        }
        if let [one, other, ..] = self.facts.on_channel_of(cell)[..] {
            let sibling = if one == cell { other } else { one };
            let wrong = errors::outlet_on_shared_channel(&self.object.name, cell, sibling, span);
            self.sink.push(errors::given_at(wrong, &at));
            return None;
        }
        Some(Outlet { name: self.object.name.clone(), cell, span })
    }

    /// The cell at a place, if the centre of a part can take it; `None` after an error.
    fn reached(&mut self, at: &Argument) -> Option<ElectrodeCell> {
        let cell = self.cell(at)?;
        if self.facts.reaches(cell) {
            return Some(cell);
        }
        let nearest = nearest_cell(cell, self.facts, |_| true);
        let wrong =
            errors::part_out_of_reach(at.span, [&self.object.noun, &self.object.name], cell, self.facts, nearest);
        self.sink.push(errors::given_at(wrong, at));
        None
    }

    /// Whether a part has the layout that the device carries.
    fn is_carried(&mut self, shape: &Spanned<ShapeValue>) -> bool {
        let object = self.object;
        if shape.value.form != ShapeForm::Layout {
            let known = [ShapeForm::Layout.name()];
            let form = shape.value.form.name();
            self.sink.push(errors::shape_of_other_kind(shape.span, form, &object.noun, VOCABULARY.name, &known));
            return false;
        }
        let own = self.facts.layout;
        let is_own = board::layout_of(&shape.value).is_some_and(|layout| {
            layout.electrodes == own.electrodes
                && (layout.half_width_pitches - own.half_width_pitches).abs() <= 1e-9 * own.half_width_pitches
        });
        if !is_own {
            let describe = |shape: &ShapeValue| {
                let half = shape.fields.si("half_width").unwrap_or_default();
                (board::electrodes_text(shape), digits(half))
            };
            let carried = self.device.fields.get("part").map(|part| (&part.value, part.span));
            let Some((Value::Shape(carried), span)) = carried else { return false };
            let found = (shape.span, describe(&shape.value));
            self.sink.push(errors::part_of_other_layout(&object.name, found, (span, describe(carried))));
        }
        is_own
    }

    /// The argument of `at`.
    fn place(&mut self) -> Option<Argument> {
        let object = self.object;
        match &object.at {
            Some(at) => Some(Argument { value: at.value.clone(), span: at.span, origin: object.origin.clone() }),
            None => {
                self.sink.push(errors::stands_nowhere(object.span, &object.noun, &object.name));
                None
            }
        }
    }

    /// The whole-number cell of a place, possibly off the board.
    fn whole_cell(&mut self, at: &Argument) -> Option<[i64; 2]> {
        let cell = whole_cell(&at.value);
        if cell.is_none() {
            self.sink.push(errors::given_at(errors::no_cell(at.span, &at.value), at));
        }
        cell
    }

    /// The cell of the board at a place; `None` after an error.
    fn cell(&mut self, at: &Argument) -> Option<ElectrodeCell> {
        let pair = self.whole_cell(at)?;
        let cell = on_board(pair, self.facts);
        if cell.is_none() {
            let object = self.object;
            let wrong = errors::off_board(at.span, &object.noun, &object.name, pair, self.facts, &self.device.name);
            self.sink.push(errors::given_at(wrong, at));
        }
        cell
    }

    /// The electrodes of a heater, detector or magnet, disjoint from others of its sort.
    fn zone(&mut self, sort: ZoneSort, before: &[BoardZone]) -> Option<BoardZone> {
        let (name, span) = (self.object.name.clone(), self.object.span);
        let (from, to) = match &self.object.shape {
            None => {
                let at = self.place()?;
                let cell = self.cell(&at)?;
                (cell, cell)
            }
            Some(shape) if shape.value.form == ShapeForm::Cells => match self.block(&shape.value.fields)? {
                ElectrodeArrayObstacleBody::Electrodes { from, to } => (from, to),
                ElectrodeArrayObstacleBody::Fixed(cell) => (cell, cell),
            },
            Some(shape) => {
                let (form, known) = (shape.value.form.name(), [ShapeForm::Cells.name()]);
                self.sink.push(errors::shape_of_other_kind(shape.span, form, sort.name(), VOCABULARY.name, &known));
                return None;
            }
        };
        let zone = BoardZone { name, sort, from, to, span };
        self.sink.push_if_some(misplaced(&zone, before, self.facts))?;
        Some(zone)
    }

    fn obstacle(&mut self) -> Option<ElectrodeArrayObstacle> {
        let body = match &self.object.shape {
            None => {
                let at = self.place()?;
                let cell = self.cell(&at)?;
                ElectrodeArrayObstacleBody::Electrodes { from: cell, to: cell }
            }
            Some(shape) if shape.value.form == ShapeForm::Cells => self.block(&shape.value.fields)?,
            Some(shape) if shape.value.form == ShapeForm::Layout => {
                let is_carried = self.is_carried(shape);
                let at = self.place()?;
                let cell = self.cell(&at).filter(|_| is_carried)?;
                ElectrodeArrayObstacleBody::Fixed(cell)
            }
            Some(shape) => {
                let known = [ShapeForm::Cells.name(), ShapeForm::Layout.name()];
                let (form, noun) = (shape.value.form.name(), &self.object.noun);
                self.sink.push(errors::shape_of_other_kind(shape.span, form, noun, VOCABULARY.name, &known));
                return None;
            }
        };
        Some(ElectrodeArrayObstacle { name: self.object.name.clone(), body, span: self.object.span })
    }

    /// A block of electrodes, clipped to the board.
    fn block(&mut self, fields: &Accepted) -> Option<ElectrodeArrayObstacleBody> {
        let corners = ["from", "to"].map(|name| fields.get(name));
        let [Some(from), Some(to)] = corners else { return None };
        let shift = match &self.object.at {
            None => [0, 0],
            Some(_) => {
                let at = self.place()?;
                self.whole_cell(&at)?
            }
        };
        let from_cell = self.whole_cell(&Argument::plain(from))?;
        let to_cell = self.whole_cell(&Argument::plain(to))?;
        let low = [0, 1].map(|axis| from_cell[axis].min(to_cell[axis]).saturating_add(shift[axis]));
        let high = [0, 1].map(|axis| from_cell[axis].max(to_cell[axis]).saturating_add(shift[axis]));
        let last = [self.facts.columns, self.facts.rows].map(i64::from);
        if (0..2).any(|axis| high[axis] < 1 || low[axis] > last[axis]) {
            let (object, shape) = (self.object, self.object.shape.as_ref()?);
            let wrong = errors::off_board(shape.span, &object.noun, &object.name, low, self.facts, &self.device.name);
            self.sink.push(wrong);
            return None;
        }
        let clip = |at: [i64; 2]| ElectrodeCell::new(at[0].clamp(1, last[0]) as u32, at[1].clamp(1, last[1]) as u32);
        Some(ElectrodeArrayObstacleBody::Electrodes { from: clip(low), to: clip(high) })
    }
}

/// Reports parts that start too near to obstacles or to each other.
fn starts(
    standing: &[StandingPart],
    obstacles: &[ElectrodeArrayObstacle],
    cover: &ObstacleCells,
    facts: &ElectrodeArrayFacts,
    sink: &mut Sink,
) {
    let apart = facts.separation.apart();
    let mut spread: SpacedPlaces<(&StandingPart, Span)> = SpacedPlaces::new(apart);
    for one in standing {
        let StandingPart { part, at: Some(at) } = one else { continue };
        let Some(own) = part.cell else { continue };
        if let Some(obstacle) = cover.covering(own) {
            let free = nearest_cell(own, facts, |cell| cover.covering(cell).is_none());
            let place = BlockedCell { code: Code::E0505, cell: own, span: at.span };
            sink.push(errors::given_at(on_obstacle(&place, &obstacles[obstacle], facts, free), at));
            continue;
        }
        if let Some((cell, (other, other_span))) = spread.near(own) {
            let is_free = |cell| cover.covering(cell).is_none() && spread.near(cell).is_none();
            let free = nearest_cell(own, facts, is_free);
            let places = [
                errors::PartPlace { name: &part.name, cell: own, span: at.span },
                errors::PartPlace { name: &other.part.name, cell, span: other_span },
            ];
            sink.push(errors::given_at(errors::starts_too_near(places, apart, free), at));
            continue;
        }
        spread.put(own, (one, at.span));
    }
}

/// A start or goal that an obstacle keeps parts from, with the code of the diagnostic.
pub struct BlockedCell {
    pub code: Code,
    pub cell: ElectrodeCell,
    pub span: Span,
}

/// Diagnostic for a cell too near to an obstacle.
pub fn on_obstacle(
    place: &BlockedCell,
    obstacle: &ElectrodeArrayObstacle,
    facts: &ElectrodeArrayFacts,
    free: Option<ElectrodeCell>,
) -> Diagnostic {
    let (distance, apart) = distance_to(obstacle, place.cell, facts);
    errors::near_obstacle(
        Spanned::new(place.cell, place.span),
        place.code,
        &obstacle.name,
        obstacle.span,
        distance,
        apart,
        free,
    )
}

/// Actual and required distance of a centre from an obstacle, in electrodes.
pub fn distance_to(
    obstacle: &ElectrodeArrayObstacle,
    centre: ElectrodeCell,
    facts: &ElectrodeArrayFacts,
) -> (u32, u32) {
    match obstacle.body {
        ElectrodeArrayObstacleBody::Electrodes { from, to } => {
            let near =
                ElectrodeCell::new(centre.column.clamp(from.column, to.column), centre.row.clamp(from.row, to.row));
            (centre.apart(near), facts.clearance)
        }
        ElectrodeArrayObstacleBody::Fixed(cell) => (centre.apart(cell), facts.separation.apart()),
    }
}
