//! Goals and starts: within the workspace, on the lattice, clear of obstacles.

use super::*;
use crate::check::verbs::Call;
use crate::claims::ValueOrigin;
use crate::claims::dimibot::{in_robot_um, in_scene_um};
use crate::diagnostic::Code;
use crate::quantity::Dimension;
use crate::real::Real;

/// Number of rings of cells around a covered goal that are searched for a free one.
const MAX_RINGS: u32 = 64;

/// Judges the stops of one task.
pub struct StopJudge<'a> {
    facts: &'a dimibot::DimibotFacts,
    cover: &'a SceneCover,
    device: &'a str,
    precision_um: Option<f64>,
    sink: &'a mut Sink,
}

impl<'a> StopJudge<'a> {
    /// Checks of stops for one device in one scene.
    pub fn new(
        facts: &'a dimibot::DimibotFacts,
        cover: &'a SceneCover,
        device: &'a str,
        precision_um: Option<f64>,
        sink: &'a mut Sink,
    ) -> Self {
        StopJudge { facts, cover, device, precision_um, sink }
    }

    /// The cell of `start at`.
    pub fn start(&mut self, start: &Argument) -> Option<Spanned<LatticeCell>> {
        let stop = self.reach(start)?;
        let covered = self.covering(stop.cell).map(|index| self.covered(&stop, index, Code::E0505));
        start.unless(covered, self.sink)?;
        Some(Spanned::new(stop.cell, stop.span))
    }

    /// A step of the task in the kind's terms.
    pub fn step(&mut self, step: tasks::VocabularyStep) -> Option<DimibotStep> {
        let action = match step.action {
            tasks::VocabularyAction::Wait(duration_ns) => DimibotAction::Wait(duration_ns),
            tasks::VocabularyAction::Verb(Call { verb, object: Some(object), .. })
                if verb.name == DimibotVerb::Visit.name() =>
            {
                DimibotAction::Visit(self.visits(&object)?)
            }
            tasks::VocabularyAction::Verb(call) => DimibotAction::Move(self.moves(call.phrases)?),
            // The vocabulary has no simultaneous goals.
            tasks::VocabularyAction::Together(_) | tasks::VocabularyAction::Assay(_) => return None,
        };
        Some(DimibotStep { action, span: step.span })
    }

    /// The stops of a `move`: those of `via` in the order of writing, then the goal.
    fn moves(&mut self, phrases: Vec<(&'static str, Argument)>) -> Option<Vec<DimibotStop>> {
        let (via, to): (Vec<_>, Vec<_>) = phrases.into_iter().partition(|(preposition, _)| *preposition == "via");
        let stops: Vec<Option<DimibotStop>> = via.iter().chain(&to).map(|(_, target)| self.stop(target)).collect();
        stops.into_iter().collect()
    }

    fn visits(&mut self, object: &Argument) -> Option<Vec<DimibotStop>> {
        let Value::List(list) = &object.value else { return None };
        if list.len() > dimibot::MAX_VISITS {
            self.sink.push(errors::too_many_visits(object.span, list.len(), dimibot::MAX_VISITS));
            return None;
        }
        let stops: Vec<Option<DimibotStop>> =
            list.iter().map(|target| self.stop(&element(target, object.span))).collect();
        stops.into_iter().collect()
    }

    /// A goal, clear of obstacles.
    fn stop(&mut self, target: &Argument) -> Option<DimibotStop> {
        let stop = self.reach(target)?;
        let covered = self.covering(stop.cell).map(|index| self.covered(&stop, index, Code::E0502));
        target.unless(covered, self.sink)?;
        Some(stop)
    }

    /// The cell of a target, within the workspace and the precision.
    fn reach(&mut self, target: &Argument) -> Option<DimibotStop> {
        let (asked, cell) = match &target.value {
            Value::Word(word) => (Asked::Cell, self.word_cell(*word, target)?),
            Value::Point(point) if point[0].dimension == Dimension::NUMBER => (Asked::Cell, self.cell(target)?),
            Value::Point(point) => {
                let place_um = shapes::point_um(point);
                (Asked::Place(place_um), self.nearest(place_um, target)?)
            }
            _ => return None,
        };
        Some(DimibotStop { asked, cell, span: target.span })
    }

    fn cell(&mut self, target: &Argument) -> Option<LatticeCell> {
        let Some([x, y]) = whole_cell(&target.value) else {
            let wrong = errors::wrong_place(target.span, &target.value, "whole cells");
            target.unless(Some(wrong), self.sink)?;
            return None;
        };
        let inside = (0..i64::from(self.facts.cells(Side::Left))).contains(&x)
            && (0..i64::from(self.facts.cells(Side::Right))).contains(&y);
        if inside {
            return Some(LatticeCell { x: x as u32, y: y as u32 });
        }
        let last = last_cell(self.facts);
        let extent = format!("(0, 0) to {last}");
        let nearest = LatticeCell { x: x.clamp(0, last.x.into()) as u32, y: y.clamp(0, last.y.into()) as u32 };
        let help = format!("the nearest cell is {nearest}{}", self.modules_for_cell(x, y));
        let wrong = errors::outside_workspace(target.span, &format!("cell ({x}, {y})"), &extent, help);
        target.unless(Some(wrong), self.sink)?;
        None
    }

    fn nearest(&mut self, asked_um: [f64; 2], target: &Argument) -> Option<LatticeCell> {
        let place_um = in_robot_um(asked_um, self.cover.frame.as_ref());
        let cell = self.facts.nearest_cell(place_um).filter(|_| within_workspace(self.facts, place_um));
        let wrong = match (cell, self.precision_um) {
            (None, _) => Some(self.outside(place_um, target.span)),
            (Some(cell), Some(precision_um)) if self.off_um(cell, place_um) > precision_um => {
                Some(self.off_lattice(place_um, cell, precision_um, target.span))
            }
            (Some(_), _) => None,
        };
        target.unless(wrong, self.sink)?;
        cell
    }

    fn off_lattice(&self, place_um: [f64; 2], cell: LatticeCell, precision_um: f64, span: Span) -> Diagnostic {
        let off = length(self.off_um(cell, place_um));
        errors::off_lattice(span, &off, &length(precision_um), self.finer(place_um, cell, precision_um))
    }

    fn off_um(&self, cell: LatticeCell, place_um: [f64; 2]) -> f64 {
        let [x_um, y_um] = self.facts.place_um(cell);
        (x_um - place_um[0]).hypotenuse(y_um - place_um[1])
    }

    fn outside(&self, place_um: [f64; 2], span: Span) -> Diagnostic {
        let mut extent = format!("(0 um, 0 um) to {}", place(self.facts.place_um(last_cell(self.facts))));
        let cell = self.facts.clamped_cell(place_um);
        let nearest = self.place_of(cell);
        let help = format!("the nearest reachable place is {nearest}{}", self.modules_to_reach(place_um));
        if self.cover.frame.is_some() {
            extent.push_str(&format!(" in the frame of `{}`, where it is {}", self.device, place(place_um)));
        }
        let asked_um = in_scene_um(place_um, self.cover.frame.as_ref());
        errors::outside_workspace(span, &format!("place {}", place(asked_um)), &extent, help)
    }

    /// A cell's place in the scene.
    fn scene_um(&self, cell: LatticeCell) -> [f64; 2] {
        in_scene_um(self.facts.place_um(cell), self.cover.frame.as_ref())
    }

    /// A cell's place for a message.
    fn place_of(&self, cell: LatticeCell) -> String {
        format!("{}, cell {cell}", place(self.scene_um(cell)))
    }

    /// Help with the number of modules that would bring a place into the workspace, if any number does.
    fn modules_to_reach(&self, place_um: [f64; 2]) -> String {
        if place_um[0] < 0.0 || place_um[1] < 0.0 {
            return match self.cover.frame {
                Some(_) => "; a robot reaches only what lies along its own axes from its frame".to_owned(),
                None => "; places count from word 0, so none is negative".to_owned(),
            };
        }
        match self.fewest_modules(|facts| within_workspace(facts, place_um)) {
            Some(modules) => format!("; {modules} modules a side would reach it"),
            None => {
                let reach_um = 2.0 * self.facts.gain * self.facts.stroke_um * std::f64::consts::SQRT_2;
                format!("; no number of modules reaches beyond {}, but a larger stroke or gain would", length(reach_um))
            }
        }
    }

    fn finer(&self, place_um: [f64; 2], cell: LatticeCell, precision_um: f64) -> String {
        let nearest = format!("the nearest reachable place is {}", self.place_of(cell));
        let close = |facts: &dimibot::DimibotFacts| {
            facts.nearest_cell(place_um).is_some_and(|cell| {
                let [x_um, y_um] = facts.place_um(cell);
                (x_um - place_um[0]).hypotenuse(y_um - place_um[1]) <= precision_um
            })
        };
        match self.fewest_modules(close) {
            Some(modules) => format!("{nearest}; {modules} modules a side would come within the precision"),
            None => nearest,
        }
    }

    /// Help with the number of modules with which a cell would exist, on the sides that have too few.
    fn modules_for_cell(&self, x: i64, y: i64) -> String {
        if x < 0 || y < 0 {
            return "; cells count from 0".to_owned();
        }
        let needed = |index: i64| (1..=dimibot::MAX_MODULES).find(|modules| index < 1 << modules);
        let sides = [(x, self.facts.left, "left"), (y, self.facts.right, "right")];
        let short = sides.into_iter().filter(|(index, has, _)| needed(*index).is_none_or(|modules| modules > *has));
        let parts: Option<Vec<String>> = short
            .map(|(index, _, side)| needed(index).map(|modules| format!("{modules} modules on the {side}")))
            .collect();
        match parts {
            Some(parts) => format!("; {} would reach it", parts.join(" and ")),
            None => format!("; a side has at most {} modules", dimibot::MAX_MODULES),
        }
    }

    fn word_cell(&mut self, word: ModuleWord, target: &Argument) -> Option<LatticeCell> {
        let (left, right) = (self.facts.left, self.facts.right);
        let wrong = (word.width != left + right)
            .then(|| errors::word_of_wrong_width(target.span, word.width, left, right, self.device));
        target.unless(wrong, self.sink)?;
        Some(self.facts.cell(word.bits))
    }

    /// The least number of modules on both sides for which a robot like this one passes a test.
    fn fewest_modules(&self, test: impl Fn(&dimibot::DimibotFacts) -> bool) -> Option<u32> {
        (1..=dimibot::MAX_MODULES)
            .find(|modules| test(&dimibot::DimibotFacts { left: *modules, right: *modules, ..self.facts.clone() }))
    }

    fn covering(&self, cell: LatticeCell) -> Option<usize> {
        self.cover.covering(cell, self.facts)
    }

    /// Diagnostic for a covered cell: the obstacle, the reason, and the nearest free cell.
    fn covered(&self, stop: &DimibotStop, index: usize, code: Code) -> Diagnostic {
        let obstacle = &self.cover.obstacles[index];
        let what = match stop.asked {
            Asked::Cell => format!("cell {}", stop.cell),
            Asked::Place(place_um) => format!("place {}, cell {},", place(place_um), stop.cell),
        };
        let growth = length(self.facts.growth_um());
        let why = match &*self.cover.body(index) {
            DimibotObstacleBody::Cells { .. } => "this cell is covered".to_owned(),
            DimibotObstacleBody::Solid { shape, pose } => match clearance_um(shape, pose, stop.cell, self.facts) {
                inside if inside <= 0.0 => format!("{} inside its rim", length(-inside)),
                clear => format!("{} from its rim; tip and repeatability need more than {growth}", length(clear)),
            },
        };
        let free = self.nearest_free(stop.cell).map(|cell| {
            let place = place(self.scene_um(cell));
            format!("the nearest free cell is {cell}, at {place}")
        });
        errors::on_obstacle(code, stop.span, &what, &obstacle.name, obstacle.span, &why, free)
    }

    fn nearest_free(&self, cell: LatticeCell) -> Option<LatticeCell> {
        for ring in 1..=MAX_RINGS {
            let free: Vec<LatticeCell> =
                ring_of(cell, ring, self.facts).filter(|at| self.covering(*at).is_none()).collect();
            let squared =
                |at: &LatticeCell| u64::from(at.x.abs_diff(cell.x)).pow(2) + u64::from(at.y.abs_diff(cell.y)).pow(2);
            if let Some(best) = free.into_iter().min_by_key(squared) {
                return Some(best);
            }
        }
        None
    }
}

/// Whether a place lies between the outermost cells, with a slack of the robot's repeatability or, if greater, of
/// 1/1000 of the pitch for printed numbers.
fn within_workspace(facts: &dimibot::DimibotFacts, place_um: [f64; 2]) -> bool {
    let last = facts.place_um(LatticeCell { x: facts.cells(Side::Left) - 1, y: facts.cells(Side::Right) - 1 });
    Side::BOTH.iter().all(|side| {
        let slack_um = facts.repeatability_um.max(facts.pitch_um(*side) / 1e3);
        let at_um = place_um[side.index()];
        (-slack_um..=last[side.index()] + slack_um).contains(&at_um)
    })
}

/// The cells at a Chebyshev distance, in a fixed order.
fn ring_of(cell: LatticeCell, ring: u32, facts: &dimibot::DimibotFacts) -> impl Iterator<Item = LatticeCell> + use<> {
    let (width, height, ring) =
        (i64::from(facts.cells(Side::Left)), i64::from(facts.cells(Side::Right)), i64::from(ring));
    let (x, y) = (i64::from(cell.x), i64::from(cell.y));
    (-ring..=ring)
        .flat_map(move |dy| {
            let step = if dy.abs() == ring { 1 } else { 2 * ring };
            (-ring..=ring).step_by(step as usize).map(move |dx| (x + dx, y + dy))
        })
        .filter(move |(x, y)| (0..width).contains(x) && (0..height).contains(y))
        .map(|(x, y)| LatticeCell { x: x as u32, y: y as u32 })
}

/// A place for a message.
fn place([x_um, y_um]: [f64; 2]) -> String {
    format!("({}, {})", length(x_um), length(y_um))
}

/// Argument for an element of a visited list; its origin is the step, if the list is given elsewhere.
fn element(target: &Spanned<Value>, list: Span) -> Argument {
    let origin = (!list.contains(target.span)).then(|| ValueOrigin { span: list, text: "visited here".to_owned() });
    Argument { value: target.value.clone(), span: target.span, origin }
}

/// The cell of a state without a scene: a device's home.
pub fn state(value: &Argument, facts: &dimibot::DimibotFacts, device: &str, sink: &mut Sink) -> Option<LatticeCell> {
    let nothing = SceneCover::of(Vec::new(), facts, None);
    StopJudge::new(facts, &nothing, device, None, sink).start(value).map(|cell| cell.value)
}
