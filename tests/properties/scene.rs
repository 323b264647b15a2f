//! Random programs for one DiMiBot: as text for the compiler and as numbers for the oracle.

#[path = "../support/random.rs"]
pub mod random;

use super::geometry::{Body, Point};
pub use random::Random;
use std::fmt::Write;

pub type Cell = [u32; 2];

/// An obstacle.
#[derive(Debug, Clone)]
pub enum Obstacle {
    /// Both corners included, the lower one first.
    Cells(Cell, Cell),
    /// Not yet grown by the tip and the repeatability.
    Solid(Body),
}

/// A robot, its obstacles, and its task.
#[derive(Debug, Clone)]
pub struct Scene {
    /// Left and right.
    pub modules: [u32; 2],
    pub growth_um: f64,
    pub pulse_ms: u32,
    pub rest_ms: u32,
    pub obstacles: Vec<Obstacle>,
    pub start: Cell,
    /// Stops of a `move`: intermediate places, then the goal.
    pub stops: Vec<Cell>,
    /// Places of a following `visit`, in any order.
    pub visits: Vec<Cell>,
    device: String,
    objects: String,
}

impl Scene {
    pub fn random(random: &mut Random, most_modules: u32) -> Scene {
        let modules = [1 + random.below(most_modules), 1 + random.below(most_modules)];
        let (tip_um, repeatability_nm) = (random.thousandths(0.0, 0.4), random.below(150));
        let (pulse_ms, rest_ms) = (10 + random.below(10), random.below(4));
        let device = format!(
            "left: {}, right: {}, tip_radius: {tip_um} um, repeatability: {repeatability_nm} nm, \
             pulse_duration: {pulse_ms} ms, rest: {rest_ms} ms",
            modules[0], modules[1]
        );
        let mut scene = Scene {
            modules,
            growth_um: tip_um + f64::from(repeatability_nm) / 1000.0,
            pulse_ms,
            rest_ms,
            obstacles: Vec::new(),
            start: [0, 0],
            stops: Vec::new(),
            visits: Vec::new(),
            device,
            objects: String::new(),
        };
        for number in 0..random.below(2 + (modules[0] + modules[1]) * 4) {
            scene.add_obstacle(number, random);
        }
        scene.start = scene.some_cell(random);
        scene.stops = (0..1 + random.below(3) / 2).map(|_| scene.some_cell(random)).collect();
        scene
    }

    /// Redraws a covered start or stop, in most cases.
    pub fn leave_obstacles(&mut self, random: &mut Random, is_free: impl Fn(Cell) -> bool) {
        let (start, mut stops) = (self.start, std::mem::take(&mut self.stops));
        let mut drawn = |cell: Cell| {
            let tries = if is_free(cell) || random.below(8) == 0 { 0 } else { 50 };
            (0..tries).map(|_| self.some_cell(random)).find(|cell| is_free(*cell)).unwrap_or(cell)
        };
        let start = drawn(start);
        stops.iter_mut().for_each(|stop| *stop = drawn(*stop));
        (self.start, self.stops) = (start, stops);
    }

    pub fn some_cell(&self, random: &mut Random) -> Cell {
        self.modules.map(|modules| random.below(1 << modules))
    }

    /// Distance of neighbouring cells along each axis (equations 2 and 6 of the paper).
    pub fn pitch_um(&self) -> Point {
        self.modules.map(|modules| 0.138 * 35.0 * std::f64::consts::SQRT_2 / f64::from(1 << (modules - 1)))
    }

    fn add_obstacle(&mut self, number: u32, random: &mut Random) {
        let name = format!("  obstacle o{number}");
        if random.below(2) == 0 {
            let low = self.some_cell(random);
            let high = low.map(|at| at + random.below(5) / 3);
            let _ = match low == high {
                true => writeln!(self.objects, "{name} at ({}, {})", low[0], low[1]),
                false => writeln!(
                    self.objects,
                    "{name} : cells {{ from: ({}, {}), to: ({}, {}) }}",
                    high[0], low[1], low[0], high[1]
                ),
            };
            self.obstacles.push(Obstacle::Cells(low, high));
            return;
        }
        let size = self.pitch_um()[0].min(self.pitch_um()[1]).max(0.9);
        let (shape, outline, radius) = shape(random, size);
        let at = [random.thousandths(-1.0, 14.0), random.thousandths(-1.0, 14.0)];
        let degrees = random.below(360);
        let _ = match random.below(3) {
            0 => writeln!(self.objects, "{name}{shape} at ({} um, {} um)", at[0], at[1]),
            _ => writeln!(self.objects, "{name}{shape} at pose({} um, {} um, {degrees} deg)", at[0], at[1]),
        };
        let turned = self.objects.ends_with("deg)\n");
        let angle = if turned { f64::from(degrees).to_radians() } else { 0.0 };
        let (sine, cosine) = angle.sin_cos();
        let place = |[x, y]: Point| [at[0] + cosine * x - sine * y, at[1] + sine * x + cosine * y];
        self.obstacles.push(Obstacle::Solid(Body { outline: outline.into_iter().map(place).collect(), radius }));
    }

    /// The program, with one task for each set of settings.
    pub fn text(&self, settings: &[String]) -> String {
        let mut text = format!(
            "use std.dimibot\n\ndevice bot : dimibot.femto_st {{ {} }}\n\nscene bench {{\n{}}}\n",
            self.device, self.objects
        );
        let cell = |[x, y]: Cell| format!("({x}, {y})");
        for (number, settings) in settings.iter().enumerate() {
            let (goal, via) = self.stops.split_last().expect("there is a goal");
            let via: String = via.iter().map(|stop| format!(" via {}", cell(*stop))).collect();
            let _ = writeln!(
                text,
                "\ntask t{number} on bot in bench {{\n  {settings}\n  start at {}\n  move to {}{via}\n  wait 3 ms",
                cell(self.start),
                cell(*goal)
            );
            if !self.visits.is_empty() {
                let visits: Vec<String> = self.visits.iter().map(|stop| cell(*stop)).collect();
                let _ = writeln!(text, "  visit [{}]", visits.join(", "));
            }
            text.push_str("}\n");
        }
        text
    }
}

/// Text of a random shape, the corners of its core in its own frame, and the radius around them.
fn shape(random: &mut Random, size: f64) -> (String, Vec<Point>, f64) {
    let mut length = |least: f64| random.thousandths(least, least + size);
    let (a, b) = (length(0.1), length(0.1));
    match random.below(5) {
        0 => (String::new(), vec![[0.0, 0.0]], 0.0),
        1 => (format!(" : disc {{ radius: {a} um }}"), vec![[0.0, 0.0]], a),
        2 => {
            let corners = vec![[-a / 2.0, -b / 2.0], [a / 2.0, -b / 2.0], [a / 2.0, b / 2.0], [-a / 2.0, b / 2.0]];
            (format!(" : box {{ size: ({a} um, {b} um) }}"), corners, 0.0)
        }
        3 => {
            let core = vec![[-a / 2.0, 0.0], [a / 2.0, 0.0]];
            (format!(" : capsule {{ length: {a} um, radius: {b} um }}"), core, b)
        }
        _ => {
            // An arrowhead: not convex; its corners are in order around the origin.
            let corners = vec![[a, 0.0], [-b, a], [-b / 4.0, 0.0], [-b, -a]];
            let places: Vec<String> = corners.iter().map(|[x, y]| format!("({x} um, {y} um)")).collect();
            (format!(" : polygon {{ points: [{}] }}", places.join(", ")), corners, 0.0)
        }
    }
}
