//! Random tasks for a small DiMiBot: as text for the compiler and as numbers for brute force.

#[path = "../support/random.rs"]
mod random;

use super::brute::{Block, Cell, Figures, Lattice, Part};
pub use random::{Random, cases};
use std::fmt::Write;

pub const OUTCOMES: [&str; 4] = ["distance", "switches", "time", "energy"];

/// Keys of the outcomes in schedules.
pub const KEYS: [&str; 4] = ["distance_um", "switches", "time_ns", "energy_j"];

/// A robot, its obstacles, and its task.
#[derive(Debug, Clone)]
pub struct Scene {
    pub lattice: Lattice,
    pub start: Cell,
    pub parts: Vec<Part>,
    stroke_um: f64,
    pulse_ms: u32,
    rest_ms: u32,
    wait_ms: u32,
    /// The device gives the start, and the task does not.
    starts_at_home: bool,
    objects: String,
    steps: String,
}

/// A limit of a task.
#[derive(Debug, Clone)]
pub struct Limit {
    pub outcome: usize,
    pub relation: &'static str,
    /// In the unit of [`Scene::outcome`].
    pub value: f64,
}

impl Limit {
    /// Whether a value keeps the limit as an upper bound; lower limits are not searched for.
    pub fn allows(&self, value: f64) -> bool {
        self.relation.starts_with('>') || self.holds(value) || (self.relation == "==" && value < self.value)
    }

    /// Whether no value at all keeps all these limits on some outcome; values at the limits, between them and beyond
    /// them are tried.
    pub fn contradict(limits: &[Limit]) -> bool {
        (0..OUTCOMES.len()).any(|outcome| {
            let of: Vec<&Limit> = limits.iter().filter(|limit| limit.outcome == outcome).collect();
            let mut at: Vec<f64> = of.iter().map(|limit| limit.value).collect();
            at.sort_by(f64::total_cmp);
            let between = at.windows(2).map(|pair| (pair[0] + pair[1]) / 2.0);
            let beyond = at.first().map(|least| least - 1.0).into_iter().chain(at.last().map(|most| most + 1.0));
            let tried: Vec<f64> = between.chain(beyond).chain(at.iter().copied()).collect();
            !of.is_empty() && !tried.into_iter().any(|value| of.iter().all(|limit| limit.holds(value)))
        })
    }

    pub fn holds(&self, value: f64) -> bool {
        let slack = self.value.abs() * 1e-9;
        match self.relation {
            "<" => value < self.value - slack,
            "<=" => value <= self.value + slack,
            "==" => (value - self.value).abs() <= slack,
            ">=" => value >= self.value - slack,
            ">" => value > self.value + slack,
            other => panic!("{other}"),
        }
    }
}

impl Scene {
    pub fn random(random: &mut Random, has_pulses: bool) -> Scene {
        let most = if has_pulses { 3 } else { 4 };
        let modules = [2 + random.below(most - 1), 2 + random.below(most - 1)];
        let mut scene = Scene {
            lattice: Lattice { modules, blocks: Vec::new() },
            start: [0, 0],
            parts: Vec::new(),
            stroke_um: f64::from(20 + random.below(30)),
            pulse_ms: 10 + random.below(10),
            rest_ms: random.below(4),
            wait_ms: 0,
            starts_at_home: random.below(4) == 0,
            objects: String::new(),
            steps: String::new(),
        };
        let most = (modules[0] + modules[1]) * if has_pulses { 4 } else { 3 };
        for number in 0..random.below(2 + most) {
            scene.add_obstacle(number, random);
        }
        scene.start = scene.free_cell(random);
        scene.set_steps(random);
        scene
    }

    fn set_steps(&mut self, random: &mut Random) {
        for _ in 0..1 + random.below(3) {
            self.add_step(random);
        }
    }

    /// Another task for the same robot with the same obstacles.
    pub fn another(&self, random: &mut Random) -> Scene {
        let mut other = Scene { parts: Vec::new(), wait_ms: 0, steps: String::new(), ..self.clone() };
        other.set_steps(random);
        other
    }

    /// A task with a single visit to `places` places.
    pub fn long_visit(random: &mut Random, places: u32) -> Scene {
        let mut scene = Scene::random(random, true);
        let places: Vec<Cell> = (0..places).map(|_| scene.free_cell(random)).collect();
        let texts: Vec<String> = places.iter().map(|cell| format!("({}, {})", cell[0], cell[1])).collect();
        scene.steps = format!("  visit [{}]\n", texts.join(", "));
        scene.parts = vec![Part::All(places)];
        scene.wait_ms = 0;
        scene
    }

    /// A cell written as a cell, as a word, or as a place that it is nearest to.
    fn target(&self, cell: Cell, random: &mut Random) -> String {
        let [left, right] = self.lattice.modules.map(|modules| modules as usize);
        match random.below(4) {
            0 => format!("0b{:0left$b}_{:0right$b}", cell[0], cell[1]),
            1 => {
                let near = |axis: usize, random: &mut Random| {
                    let last = f64::from((1_u32 << self.lattice.modules[axis]) - 1);
                    let at = f64::from(cell[axis]) + random.thousandths(-0.3, 0.3);
                    at.clamp(0.0, last) * self.pitch_um(axis)
                };
                format!("({} um, {} um)", near(0, random), near(1, random))
            }
            _ => format!("({}, {})", cell[0], cell[1]),
        }
    }

    fn free_cell(&self, random: &mut Random) -> Cell {
        let drawn = |random: &mut Random| self.lattice.modules.map(|modules| random.below(1 << modules));
        (0..200).map(|_| drawn(random)).find(|cell| self.lattice.is_free(*cell, *cell)).unwrap_or([0, 0])
    }

    /// Distance of neighbouring cells (equations 2 and 6 of the paper).
    pub fn pitch_um(&self, axis: usize) -> f64 {
        0.138 * self.stroke_um * std::f64::consts::SQRT_2 / f64::from(1 << (self.lattice.modules[axis] - 1))
    }

    fn add_obstacle(&mut self, number: u32, random: &mut Random) {
        let at = self.lattice.modules.map(|modules| random.below(1 << modules));
        let gap = random.below(3) as usize;
        // Blocks on a cell, or a disc in the gap after a cell along one axis.
        let block = match gap {
            2 => Block { low: at.map(|at| 2 * at), high: at.map(|at| 2 * at) },
            axis => {
                let mut half = at.map(|at| 2 * at);
                half[axis] += 1;
                Block { low: half, high: half }
            }
        };
        let _ = match gap {
            2 => writeln!(self.objects, "  obstacle o{number} at ({}, {})", at[0], at[1]),
            _ => {
                let place = [0, 1].map(|axis| f64::from(block.low[axis]) / 2.0 * self.pitch_um(axis));
                let radius = 0.3 * self.pitch_um(0).min(self.pitch_um(1));
                let shape = format!("disc {{ radius: {radius} um }}");
                writeln!(self.objects, "  obstacle o{number} : {shape} at ({} um, {} um)", place[0], place[1])
            }
        };
        self.lattice.blocks.push(block);
    }

    fn add_step(&mut self, random: &mut Random) {
        match random.below(5) {
            0 => {
                let wait_ms = 1 + random.below(20);
                self.wait_ms += wait_ms;
                let _ = writeln!(self.steps, "  wait {wait_ms} ms");
            }
            1 | 2 => {
                let via: Vec<Cell> = (0..random.below(3)).map(|_| self.free_cell(random)).collect();
                let goal = self.free_cell(random);
                let text: String = via.iter().map(|cell| format!(" via {}", self.target(*cell, random))).collect();
                let _ = writeln!(self.steps, "  move to {}{text}", self.target(goal, random));
                self.parts.extend(via.into_iter().chain([goal]).map(Part::To));
            }
            _ => {
                let places: Vec<Cell> = (0..1 + random.below(4)).map(|_| self.free_cell(random)).collect();
                let text: Vec<String> = places.iter().map(|cell| self.target(*cell, random)).collect();
                let _ = writeln!(self.steps, "  visit [{}]", text.join(", "));
                self.parts.push(Part::All(places));
            }
        }
    }

    /// Value of an outcome for a plan's figures, in um, switches, ms and mJ (20 V and 100 mA).
    pub fn outcome(&self, outcome: usize, [distance, switches, pulses]: Figures) -> f64 {
        match outcome {
            0 => distance as f64 * self.pitch_um(0).min(self.pitch_um(1)),
            1 => switches as f64,
            2 => (pulses * u64::from(self.pulse_ms + self.rest_ms) + u64::from(self.wait_ms)) as f64,
            _ => switches as f64 * 2.0 * f64::from(self.pulse_ms),
        }
    }

    /// Figures in order of importance for an objective.
    pub fn key(&self, objective: usize, [distance, switches, pulses]: Figures) -> Figures {
        match objective {
            0 => [distance, switches, pulses],
            2 => [pulses, distance, switches],
            _ => [switches, distance, pulses],
        }
    }

    /// Limits at or near the figures of some best plan.
    pub fn limits(&self, front: &[Figures], random: &mut Random) -> Vec<Limit> {
        let unit = |outcome: usize| self.outcome(outcome, [1, 1, 1]) - self.outcome(outcome, [0, 0, 0]);
        let count = 1 + random.below(3);
        let mut limit = |_| {
            let outcome = random.below(4) as usize;
            let relation = ["<=", "<=", "<=", "<", "<", ">=", "==", ">"][random.below(8) as usize];
            let near = front.get(random.below(front.len().max(1) as u32) as usize).copied().unwrap_or([5, 5, 5]);
            let off = [0.0, 0.0, 0.5, 1.0, -1.0][random.below(5) as usize] * unit(outcome);
            Limit { outcome, relation, value: (self.outcome(outcome, near) + off).max(0.0) }
        };
        (0..count).map(&mut limit).collect()
    }

    /// A program with one task.
    pub fn text(&self, settings: &str, limits: &[Limit]) -> String {
        format!(
            "use std.dimibot\n{}{}",
            self.robot("bot"),
            self.task("go", "bot", settings, limits, !self.starts_at_home)
        )
    }

    /// The robot and its obstacles.
    pub fn robot(&self, name: &str) -> String {
        let [left, right] = self.lattice.modules;
        let home =
            if self.starts_at_home { format!(", home: ({}, {})", self.start[0], self.start[1]) } else { String::new() };
        format!(
            "device {name} : dimibot.femto_st {{ left: {left}, right: {right}, stroke: {} um, pulse_duration: {} ms, \
             rest: {} ms, tip_radius: 0 um, repeatability: 0 nm{home} }}\nscene bench_{name} {{\n{}}}\n",
            self.stroke_um, self.pulse_ms, self.rest_ms, self.objects,
        )
    }

    /// A task of a robot.
    pub fn task(&self, name: &str, robot: &str, settings: &str, limits: &[Limit], says_start: bool) -> String {
        let unit = [" um", "", " ms", " mJ"];
        let limits: String = limits
            .iter()
            .map(|limit| {
                let (name, unit) = (OUTCOMES[limit.outcome], unit[limit.outcome]);
                format!("  require {name} {} {}{unit}\n", limit.relation, limit.value)
            })
            .collect();
        let start =
            if says_start { format!("  start at ({}, {})\n", self.start[0], self.start[1]) } else { String::new() };
        format!("task {name} on {robot} in bench_{robot} {{\n{settings}{limits}{start}{}}}\n", self.steps)
    }

    /// Whether a robot starts where its device says.
    pub fn starts_at_home(&self) -> bool {
        self.starts_at_home
    }
}
