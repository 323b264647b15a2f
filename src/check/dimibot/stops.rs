//! Goals and starts: within the workspace, on the lattice, clear of obstacles.

use super::*;
use crate::geometry::distance;
use nalgebra::Point2;

/// How many rings of cells round a covered goal are searched for a free one.
const MAX_RINGS: u32 = 64;

/// Judges the stops of one task.
pub struct Judge<'a> {
    facts: &'a dimibot::Facts,
    obstacles: &'a [Obstacle],
    device: &'a str,
    precision_um: Option<f64>,
    sink: &'a mut Sink,
    covering: BTreeMap<Cell, Option<usize>>,
}

impl<'a> Judge<'a> {
    /// A judge for one device in one scene.
    pub fn new(
        facts: &'a dimibot::Facts,
        obstacles: &'a [Obstacle],
        device: &'a str,
        precision_um: Option<f64>,
        sink: &'a mut Sink,
    ) -> Self {
        Judge { facts, obstacles, device, precision_um, sink, covering: BTreeMap::new() }
    }

    /// The cell of `start at`.
    pub fn start(&mut self, start: &Spanned<Value>) -> Option<Spanned<Cell>> {
        let stop = self.reach(start)?;
        match self.covering(stop.cell) {
            Some(index) => {
                let (what, obstacle, why, free) = self.covered(&stop, index);
                self.sink.push(errors::start_on_obstacle(stop.span, &what, obstacle, &why, free));
                None
            }
            None => Some(Spanned::new(stop.cell, stop.span)),
        }
    }

    /// A step of the task in the kind's terms.
    pub fn step(&mut self, step: tasks::Step) -> Option<Step> {
        let action = match step.action {
            tasks::Action::Wait(duration_ns) => Action::Wait(duration_ns),
            tasks::Action::Verb { verb, object: Some(object), .. } if verb.name == "visit" => {
                Action::Visit(self.visits(&object)?)
            }
            tasks::Action::Verb { phrases, .. } => Action::Move(self.moves(phrases)?),
        };
        Some(Step { action, span: step.span })
    }

    /// The stops of a `move`: those of `via` in the order of writing, then the goal.
    fn moves(&mut self, phrases: Vec<(&'static str, Spanned<Value>)>) -> Option<Vec<Stop>> {
        let (via, to): (Vec<_>, Vec<_>) = phrases.into_iter().partition(|(preposition, _)| *preposition == "via");
        let stops: Vec<Option<Stop>> = via.iter().chain(&to).map(|(_, target)| self.stop(target)).collect();
        stops.into_iter().collect()
    }

    fn visits(&mut self, object: &Spanned<Value>) -> Option<Vec<Stop>> {
        let Value::List(list) = &object.value else { return None };
        if list.len() > dimibot::MAX_VISITS {
            self.sink.push(errors::too_many_visits(object.span, list.len(), dimibot::MAX_VISITS));
            return None;
        }
        let stops: Vec<Option<Stop>> = list.iter().map(|target| self.stop(target)).collect();
        stops.into_iter().collect()
    }

    /// A goal, clear of obstacles.
    fn stop(&mut self, target: &Spanned<Value>) -> Option<Stop> {
        let stop = self.reach(target)?;
        match self.covering(stop.cell) {
            Some(index) => {
                let (what, obstacle, why, free) = self.covered(&stop, index);
                self.sink.push(errors::on_obstacle(stop.span, &what, obstacle, &why, free));
                None
            }
            None => Some(stop),
        }
    }

    /// The cell of a target, within the workspace and the precision.
    fn reach(&mut self, target: &Spanned<Value>) -> Option<Stop> {
        let (asked, cell) = match &target.value {
            Value::Word(word) => (Asked::Cell, word_cell(*word, target.span, self.facts, self.device, self.sink)?),
            Value::Point(point) if point[0].dimension == Dimension::NUMBER => (Asked::Cell, self.cell(target)?),
            Value::Point(point) => {
                let place_um = shapes::point_um(point);
                (Asked::Place(place_um), self.nearest(place_um, target.span)?)
            }
            _ => return None,
        };
        Some(Stop { asked, cell, span: target.span })
    }

    fn cell(&mut self, target: &Spanned<Value>) -> Option<Cell> {
        let Some([x, y]) = whole_cell(&target.value) else {
            self.sink.push(errors::wrong_place(target.span, &target.value, "whole cells"));
            return None;
        };
        let inside = (0..i64::from(self.facts.cells(Side::Left))).contains(&x)
            && (0..i64::from(self.facts.cells(Side::Right))).contains(&y);
        if inside {
            return Some(Cell { x: x as u32, y: y as u32 });
        }
        let (last_x, last_y) = (self.facts.cells(Side::Left) - 1, self.facts.cells(Side::Right) - 1);
        let extent = format!("(0, 0) to ({last_x}, {last_y})");
        let nearest = Cell { x: x.clamp(0, last_x.into()) as u32, y: y.clamp(0, last_y.into()) as u32 };
        let help = format!("the nearest cell is {nearest}{}", modules_for_cell(x.max(y), x.min(y)));
        self.sink.push(errors::outside_workspace(target.span, &format!("cell ({x}, {y})"), &extent, help));
        None
    }

    fn nearest(&mut self, place_um: [f64; 2], span: Span) -> Option<Cell> {
        let Some(cell) = self.facts.nearest_cell(place_um) else {
            self.outside(place_um, span);
            return None;
        };
        let off_um = self.off_um(cell, place_um);
        match self.precision_um {
            Some(precision_um) if off_um > precision_um => {
                self.sink.push(errors::off_lattice(
                    span,
                    &length(off_um),
                    &length(precision_um),
                    self.finer(place_um, cell),
                ));
                None
            }
            _ => Some(cell),
        }
    }

    fn off_um(&self, cell: Cell, place_um: [f64; 2]) -> f64 {
        let [x_um, y_um] = self.facts.place_um(cell);
        (x_um - place_um[0]).hypot(y_um - place_um[1])
    }

    fn outside(&mut self, place_um: [f64; 2], span: Span) {
        let last = Cell { x: self.facts.cells(Side::Left) - 1, y: self.facts.cells(Side::Right) - 1 };
        let [width_um, height_um] = self.facts.place_um(last);
        let extent = format!("(0 um, 0 um) to {}", place(width_um, height_um));
        let cell = self.facts.clamped_cell(place_um);
        let [x_um, y_um] = self.facts.place_um(cell);
        let nearest = format!("the nearest reachable place is {}, cell {cell}", place(x_um, y_um));
        let help = format!("{nearest}{}", self.modules_to_reach(place_um));
        self.sink.push(errors::outside_workspace(
            span,
            &format!("place {}", place(place_um[0], place_um[1])),
            &extent,
            help,
        ));
    }

    /// How many modules would bring a place into the workspace, if any number does.
    fn modules_to_reach(&self, place_um: [f64; 2]) -> String {
        if place_um[0] < 0.0 || place_um[1] < 0.0 {
            return "; places count from word 0, so none is negative".to_owned();
        }
        match self.fewest_modules(|facts| facts.nearest_cell(place_um).is_some()) {
            Some(modules) => format!("; {modules} modules a side would reach it"),
            None => {
                let reach_um = 2.0 * self.facts.gain * self.facts.stroke_um * std::f64::consts::SQRT_2;
                format!("; no number of modules reaches beyond {}, a larger stroke or gain would", length(reach_um))
            }
        }
    }

    fn finer(&self, place_um: [f64; 2], cell: Cell) -> String {
        let [x_um, y_um] = self.facts.place_um(cell);
        let nearest = format!("the nearest reachable place is {}, cell {cell}", place(x_um, y_um));
        let precision_um = self.precision_um.unwrap_or(f64::INFINITY);
        let close = |facts: &dimibot::Facts| {
            facts.nearest_cell(place_um).is_some_and(|cell| {
                let [x_um, y_um] = facts.place_um(cell);
                (x_um - place_um[0]).hypot(y_um - place_um[1]) <= precision_um
            })
        };
        match self.fewest_modules(close) {
            Some(modules) => format!("{nearest}; {modules} modules a side would come within the precision"),
            None => nearest,
        }
    }

    /// The least number of modules on both sides for which a robot like this one passes a test.
    fn fewest_modules(&self, test: impl Fn(&dimibot::Facts) -> bool) -> Option<u32> {
        (1..=dimibot::MAX_MODULES)
            .find(|modules| test(&dimibot::Facts { left: *modules, right: *modules, ..self.facts.clone() }))
    }

    /// The first obstacle that covers a cell.
    fn covering(&mut self, cell: Cell) -> Option<usize> {
        if let Some(known) = self.covering.get(&cell) {
            return *known;
        }
        let found = (0..self.obstacles.len()).find(|index| self.covers(&self.obstacles[*index].body, cell));
        self.covering.insert(cell, found);
        found
    }

    fn covers(&self, body: &Body, cell: Cell) -> bool {
        match body {
            Body::Cells { from, to } => (from.x..=to.x).contains(&cell.x) && (from.y..=to.y).contains(&cell.y),
            Body::Solid { shape, pose } => self.clearance_um(shape, pose, cell) <= self.facts.growth_um(),
        }
    }

    fn clearance_um(&self, shape: &Shape, pose: &Pose, cell: Cell) -> f64 {
        let [x_um, y_um] = self.facts.place_um(cell);
        let at = Point2::new(x_um, y_um);
        let body = shape.grown(pose, 0.0);
        body.map_or(f64::INFINITY, |body| distance::segment_core([at, at], &body.core) - body.radius_um)
    }

    /// What, on which obstacle, why, and what is free instead.
    fn covered(&mut self, stop: &Stop, index: usize) -> (String, (&'a str, Span), String, Option<String>) {
        let obstacle = &self.obstacles[index];
        let what = match stop.asked {
            Asked::Cell => format!("cell {}", stop.cell),
            Asked::Place([x_um, y_um]) => format!("place {} (cell {})", place(x_um, y_um), stop.cell),
        };
        let why = match &obstacle.body {
            Body::Cells { .. } => "a covered cell".to_owned(),
            Body::Solid { shape, pose } => {
                let clearance = length(self.clearance_um(shape, pose, stop.cell));
                format!(
                    "{clearance} from its rim, tip and repeatability need more than {}",
                    length(self.facts.growth_um())
                )
            }
        };
        let free = self.nearest_free(stop.cell).map(|cell| {
            let [x_um, y_um] = self.facts.place_um(cell);
            format!("the nearest free cell is {cell}, at {}", place(x_um, y_um))
        });
        (what, (&obstacle.name, obstacle.span), why, free)
    }

    fn nearest_free(&mut self, cell: Cell) -> Option<Cell> {
        for ring in 1..=MAX_RINGS {
            let free: Vec<Cell> = ring_of(cell, ring, self.facts).filter(|at| self.covering(*at).is_none()).collect();
            let squared = |at: &Cell| u64::from(at.x.abs_diff(cell.x)).pow(2) + u64::from(at.y.abs_diff(cell.y)).pow(2);
            if let Some(best) = free.into_iter().min_by_key(squared) {
                return Some(best);
            }
        }
        None
    }
}

/// The cells at a Chebyshev distance, in a fixed order.
fn ring_of(cell: Cell, ring: u32, facts: &dimibot::Facts) -> impl Iterator<Item = Cell> + use<> {
    let (width, height, ring) =
        (i64::from(facts.cells(Side::Left)), i64::from(facts.cells(Side::Right)), i64::from(ring));
    let (x, y) = (i64::from(cell.x), i64::from(cell.y));
    (-ring..=ring)
        .flat_map(move |dy| {
            let step = if dy.abs() == ring { 1 } else { 2 * ring };
            (-ring..=ring).step_by(step as usize).map(move |dx| (x + dx, y + dy))
        })
        .filter(move |(x, y)| (0..width).contains(x) && (0..height).contains(y))
        .map(|(x, y)| Cell { x: x as u32, y: y as u32 })
}

/// A place for a message.
fn place(x_um: f64, y_um: f64) -> String {
    format!("({}, {})", length(x_um), length(y_um))
}

fn modules_for_cell(largest: i64, least: i64) -> String {
    if least < 0 {
        return "; cells count from 0".to_owned();
    }
    match (1..=dimibot::MAX_MODULES).find(|modules| largest < 1 << modules) {
        Some(modules) => format!("; {modules} modules on that side would reach it"),
        None => format!("; a side has at most {} modules", dimibot::MAX_MODULES),
    }
}

fn word_cell(word: ModuleWord, span: Span, facts: &dimibot::Facts, device: &str, sink: &mut Sink) -> Option<Cell> {
    if word.width != facts.left + facts.right {
        sink.push(errors::word_of_wrong_width(span, word.width, facts.left, facts.right, device));
        return None;
    }
    Some(facts.cell(word.bits))
}

/// The cell of a state that no scene is known for: a device's home.
pub fn state(value: &Spanned<Value>, facts: &dimibot::Facts, device: &str, sink: &mut Sink) -> Option<Cell> {
    Judge::new(facts, &[], device, None, sink).start(value).map(|cell| cell.value)
}
