//! Bounds on the time, the control cycles and the strokes of drives, compared with all sequences of control states on
//! small beds and with shortcuts of real plans.
//!
//! The motion model is independent: it shares nothing with the planner or the verifier. `TWEEZE_ORACLE_CASES=1000` runs
//! more cases.

use super::random::{Random, cases};
use super::support::{Folder, build};
use std::f64::consts::TAU;
use std::path::Path;
use tweeze::check::Options;
use tweeze::claims::microrobots::MicrorobotsOrder;
use tweeze::compile::{self, ProgramSource};
use tweeze::diagnostic::Sink;
use tweeze::plan::microrobots::Crew;
use tweeze::plan::microrobots::bound::{self, LeastFigures};
use tweeze::schedule::microrobots::MicrorobotsState;
use tweeze::schedule::{Schedule, State};
use tweeze::source::Sources;

/// A pose: x and y in micrometres, heading in radians.
type Place = [f64; 3];

/// Moves a pose: clockwise on a circle with the arm down, straight ahead with the arm up.
fn moved(place: Place, radius_um: f64, way_um: f64, is_down: bool) -> Place {
    let [x, y, heading] = place;
    if !is_down {
        return [x + way_um * heading.cos(), y + way_um * heading.sin(), heading];
    }
    let (middle_x, middle_y) = (x + radius_um * heading.sin(), y - radius_um * heading.cos());
    let later = heading - way_um / radius_um;
    [middle_x - radius_um * later.sin(), middle_y + radius_um * later.cos(), later]
}

fn is_within(place: Place, goal: Place, [place_um, heading_rad]: [f64; 2]) -> bool {
    let turned = (place[2] - goal[2]).rem_euclid(TAU);
    (place[0] - goal[0]).hypot(place[1] - goal[1]) <= place_um && turned.min(TAU - turned) <= heading_rad
}

/// Robots whose strokes are so long that all sequences can be tried. State j lowers the arms of the first j robots.
struct Small {
    radii_um: Vec<f64>,
    stroke_um: Vec<f64>,
    starts: Vec<Place>,
    precision: [f64; 2],
}

const PERIOD_S: f64 = 0.1;
const DWELL_S: f64 = 0.02;

/// Weight of a figure that is not minimised, so that the search terminates; all of it together is less than one unit of
/// the minimised figure.
const NEARLY_NOTHING: f64 = 1e-6;

/// The figure that is minimised.
#[derive(Clone, Copy)]
enum Figure {
    Time,
    Switches,
    Strokes,
}

impl Figure {
    /// Weight of a stroke.
    fn stroke(self) -> f64 {
        match self {
            Figure::Time => PERIOD_S,
            Figure::Switches => NEARLY_NOTHING,
            Figure::Strokes => 1.0,
        }
    }
}

#[derive(Clone, Copy)]
enum Task {
    Apply {
        state: usize,
        strokes: usize,
    },
    /// A robot and its stop; `true` if the same step continues to a further stop.
    Stop(usize, Place, bool),
}

impl Small {
    fn random(chance: &mut Random, robots: usize) -> Small {
        let mut some = |from: f64, to: f64| (0..robots).map(|_| chance.thousandths(from, to)).collect::<Vec<f64>>();
        let (radii_um, stroke_um, headings) = (some(80.0, 160.0), some(15.0, 25.0), some(0.0, std::f64::consts::TAU));
        let starts = headings.iter().enumerate().map(|(at, heading)| [5000.0 * at as f64, 0.0, *heading]).collect();
        Small {
            radii_um,
            stroke_um,
            starts,
            precision: [chance.thousandths(4.0, 14.0), chance.thousandths(0.02, 0.16)],
        }
    }

    fn stroke(&self, places: &[Place], state: usize) -> Vec<Place> {
        let go =
            |(robot, place): (usize, &Place)| moved(*place, self.radii_um[robot], self.stroke_um[robot], robot < state);
        places.iter().enumerate().map(go).collect()
    }

    /// Weight of a control cycle: one level if all arms are up or all are down, otherwise two.
    fn cycle(&self, state: usize, figure: Figure) -> f64 {
        match figure {
            Figure::Time if state == 0 || state == self.starts.len() => DWELL_S,
            Figure::Time => 2.0 * DWELL_S,
            Figure::Switches => 1.0,
            Figure::Strokes => NEARLY_NOTHING,
        }
    }

    fn text(&self, tasks: &[Task]) -> String {
        let pose = |[x, y, heading]: Place| format!("pose({x} um, {y} um, {} deg)", heading.to_degrees());
        let mut text = "use std.microrobots\ndevice fleet : microrobots.bed {\n  robots: table {\n    \
            robot | snap_down [V] | release [V] | turning_radius [um] | speed [um/s]\n"
            .to_owned();
        for robot in 0..self.starts.len() {
            let (down, up) = (110 + 12 * robot, 20 + 13 * robot);
            let speed = self.stroke_um[robot] / PERIOD_S;
            text += &format!("    D{} | {down} | {up} | {} | {speed}\n", robot + 1, self.radii_um[robot]);
        }
        text += &format!(
            "  }}\n  margin: 2 V, drive_frequency: {} Hz, dwell: {DWELL_S} s\n}}\nscene field {{\n",
            1.0 / PERIOD_S
        );
        for (robot, start) in self.starts.iter().enumerate() {
            text += &format!("  robot D{} at {}\n", robot + 1, pose(*start));
        }
        let [place_um, heading_rad] = self.precision;
        let heading = heading_rad.to_degrees();
        text += &format!(
            "}}\ntask go on fleet in field {{\n  precision: {place_um} um\n  heading_precision: {heading} deg\n"
        );
        let mut vias = String::new();
        for task in tasks {
            match *task {
                Task::Apply { state, strokes } => {
                    text += &format!("  apply state {state} for {} s\n", PERIOD_S * strokes as f64);
                }
                Task::Stop(_, goal, true) => vias += &format!(" via {}", pose(goal)),
                Task::Stop(robot, goal, false) => {
                    text += &format!("  drive D{} to {}{vias}\n", robot + 1, pose(goal));
                    vias.clear();
                }
            }
        }
        text + "}\n"
    }

    /// The least figure over all sequences of at most `strokes` strokes, not counting applied ones.
    fn least(&self, tasks: &[Task], strokes: usize, figure: Figure) -> f64 {
        let mut search = SequenceSearch { small: self, figure, best: f64::INFINITY };
        search.go(tasks, &self.starts, None, strokes, 0.0);
        search.best
    }

    /// A random next stop: the place after random strokes, slightly displaced.
    fn somewhere(&self, chance: &mut Random, places: &mut Vec<Place>, robot: usize, strokes: usize) -> Place {
        let mut state = chance.below(self.starts.len() as u32 + 1) as usize;
        for _ in 0..strokes {
            if chance.below(3) == 0 {
                state = chance.below(self.starts.len() as u32 + 1) as usize;
            }
            *places = self.stroke(places, state);
        }
        let [x, y, heading] = places[robot];
        let mut off = |limit: f64| 0.6 * limit * (2.0 * chance.unit() - 1.0);
        [x + off(self.precision[0]), y + off(self.precision[0]), heading + off(self.precision[1])]
    }
}

/// Exhaustive search over sequences of strokes for the least figure.
struct SequenceSearch<'s> {
    small: &'s Small,
    figure: Figure,
    best: f64,
}

impl SequenceSearch<'_> {
    /// Continues from poses in a state, with `left` strokes left and the figure so far.
    fn go(&mut self, tasks: &[Task], places: &[Place], state: Option<usize>, left: usize, sum: f64) {
        if sum >= self.best {
            return;
        }
        let Some((task, later)) = tasks.split_first() else {
            self.best = sum;
            return;
        };
        match *task {
            Task::Apply { state, strokes } => {
                let places = (0..strokes).fold(places.to_vec(), |places, _| self.small.stroke(&places, state));
                let sum = sum + self.small.cycle(state, self.figure) + self.figure.stroke() * strokes as f64;
                self.go(later, &places, None, left, sum);
            }
            Task::Stop(robot, goal, is_via) => {
                if is_within(places[robot], goal, self.small.precision) {
                    // A leg may continue through an intermediate stop of its step.
                    let state = state.filter(|_| is_via && matches!(self.figure, Figure::Switches));
                    self.go(later, places, state, left, sum);
                }
                for next in (0..=self.small.starts.len()).filter(|_| left > 0) {
                    let cycle = if state == Some(next) { 0.0 } else { self.small.cycle(next, self.figure) };
                    let sum = sum + cycle + self.figure.stroke();
                    self.go(tasks, &self.small.stroke(places, next), Some(next), left - 1, sum);
                }
            }
        }
    }
}

/// The planner's bounds for the first task of a program.
fn proven(text: &str) -> LeastFigures {
    let (mut sources, mut sink, options) = (Sources::default(), Sink::default(), Options::default());
    let request = ProgramSource { name: "test.twz", text, library: &Folder(Path::new(".")), options: &options };
    let checked = compile::check_program(&request, &mut sources, &mut sink).expect("a program without errors");
    let order = MicrorobotsOrder::of(&checked.claims[0].jobs[0].order).expect("an order of microrobots");
    let poses = order.robots.iter().map(|placed| placed.pose).collect();
    bound::least(order, &Crew { poses, docked: vec![false; order.robots.len()] })
}

/// Builds and compares; returns whether there was a plan.
fn holds(small: &Small, tasks: &[Task], strokes: usize) -> bool {
    let text = small.text(tasks);
    let built = build(&text);
    assert!(!built.refused, "{text}");
    let Some(verified) = built.schedules.first() else { return false };
    let plan = &verified.schedule().plans[0];
    let least_s = small.least(tasks, strokes, Figure::Time);
    let proven = proven(&text);
    let [switches, all_strokes] = [Figure::Switches, Figure::Strokes].map(|figure| small.least(tasks, strokes, figure));
    assert!(proven.switches as f64 <= switches, "{proven:?}, but {switches} cycles do\n{text}");
    assert!(proven.strokes as f64 <= all_strokes, "{proven:?}, but {all_strokes} strokes do\n{text}");
    assert!(plan.bound <= plan.cost + 1e-9, "{text}");
    assert!(plan.bound <= least_s + 1e-9, "bound {}, but there is a plan of {least_s}\n{text}", plan.bound);
    assert!(!plan.optimal || plan.cost <= least_s + 1e-9, "said to be optimal\n{text}");
    true
}

fn compared(seed: u64, usual: usize, mut one: impl FnMut(&mut Random) -> bool) {
    let mut chance = Random::new(seed);
    let (mut found, wanted) = (0, cases(usual));
    for _ in 0..20 * wanted {
        found += usize::from(one(&mut chance));
        if found == wanted {
            return;
        }
    }
    panic!("only {found} of {wanted} programs have plans");
}

#[test]
fn no_sequence_of_states_beats_the_bound_of_a_drive() {
    compared(11, 60, |chance| {
        let small = Small::random(chance, 1);
        let mut places = small.starts.clone();
        let strokes = 3 + chance.below(9) as usize;
        let goal = small.somewhere(chance, &mut places, 0, strokes);
        holds(&small, &[Task::Stop(0, goal, false)], 13)
    });
}

#[test]
fn no_sequence_of_states_beats_the_bound_of_stops_and_steps() {
    compared(12, 60, |chance| {
        let small = Small::random(chance, 1);
        let mut places = small.starts.clone();
        let first = small.somewhere(chance, &mut places, 0, 5);
        let second = small.somewhere(chance, &mut places, 0, 5);
        let is_via = chance.below(2) == 0;
        holds(&small, &[Task::Stop(0, first, is_via), Task::Stop(0, second, false)], 12)
    });
}

/// More stops than the bound relates to one another and than the planner has alternatives: limits of the search do not
/// affect any claim.
#[test]
fn no_sequence_of_states_beats_the_bound_of_many_stops() {
    compared(15, 30, |chance| {
        let small = Small::random(chance, 1);
        let mut places = small.starts.clone();
        let stops = 10 + chance.below(3) as usize;
        let tasks: Vec<Task> = (1..=stops)
            .map(|stop| {
                let goal = small.somewhere(chance, &mut places, 0, 1);
                Task::Stop(0, goal, stop < stops && chance.below(3) != 0)
            })
            .collect();
        holds(&small, &tasks, stops + 2)
    });
}

#[test]
fn no_sequence_of_states_beats_the_bound_of_two_robots() {
    compared(13, 40, |chance| {
        let small = Small::random(chance, 2);
        let mut places = small.starts.clone();
        let mut tasks = Vec::new();
        if chance.below(2) == 0 {
            let (state, strokes) = (chance.below(3) as usize, 1 + chance.below(4) as usize);
            places = (0..strokes).fold(places, |places, _| small.stroke(&places, state));
            tasks.push(Task::Apply { state, strokes });
        }
        for robot in if chance.below(2) == 0 { [0, 1] } else { [1, 0] } {
            tasks.push(Task::Stop(robot, small.somewhere(chance, &mut places, robot, 3), false));
        }
        holds(&small, &tasks, 7)
    });
}

/// The strokes of one robot in a schedule: whether its arm is down, and the number of strokes.
fn trains(schedule: &Schedule, row: usize) -> Vec<(bool, i64)> {
    let states = schedule.plans[0].states.iter().map(|timed| match &timed.state {
        State::Microrobots(MicrorobotsState { arms, .. }) => arms[row] == 1,
        other => panic!("a state of a bed: {other:?}"),
    });
    let trains = schedule.actuations.iter().filter_map(|one| Some((one.duration_ns / one.swing?.period_ns) as i64));
    states.zip(trains).collect()
}

/// Shortens trains by hill climbing while the end stays within the precision; returns the remaining number of strokes.
fn shortened(chance: &mut Random, mut trains: Vec<(bool, i64)>, end: impl Fn(&[(bool, i64)]) -> bool) -> i64 {
    let sum = |trains: &[(bool, i64)]| trains.iter().map(|train| train.1).sum::<i64>();
    for round in 0..4000 {
        let mut other = trains.clone();
        let most = [3, 30, 300][round % 3];
        for _ in 0..1 + chance.below(3) {
            let at = chance.below(other.len() as u32) as usize;
            other[at].1 += i64::from(chance.below(2 * most + 1)) - i64::from(most);
        }
        if other.iter().all(|train| train.1 >= 1) && sum(&other) < sum(&trains) && end(&other) {
            trains = other;
        }
    }
    sum(&trains)
}

/// With the figures of real robots: plans are shortened within the precision, down to the bound and never below it.
#[test]
fn shortcuts_within_the_precision_stay_above_the_bound() {
    let mut spared = 0;
    compared(14, 40, |chance| {
        let start = [0.0, 0.0, chance.unit() * TAU];
        let side = 600.0;
        let goal = [chance.thousandths(-side, side), chance.thousandths(-side, side), chance.unit() * TAU];
        let small =
            Small { radii_um: vec![141.0], stroke_um: vec![0.01], starts: vec![start], precision: [0.5, 0.008_726] };
        let text = small.text(&[Task::Stop(0, goal, false)]);
        let built = build(&text);
        let Some(verified) = built.schedules.first() else { return false };
        let schedule = verified.schedule();
        let plan = &schedule.plans[0];
        let trains = trains(schedule, 0);
        let ends = |trains: &[(bool, i64)]| {
            let go = |place, (is_down, strokes): &(bool, i64)| moved(place, 141.0, 0.01 * *strokes as f64, *is_down);
            is_within(trains.iter().fold(start, go), goal, [0.5, 0.008_726])
        };
        assert!(ends(&trains), "{text}");
        let before: i64 = trains.iter().map(|train| train.1).sum();
        let cycles_s = DWELL_S * trains.len() as f64;
        let left = shortened(chance, trains, ends);
        spared += usize::from(left < before);
        let least_s = PERIOD_S * left as f64 + cycles_s;
        assert!(plan.bound <= least_s + 1e-9, "bound {}, but there is a plan of {least_s}\n{text}", plan.bound);
        assert!(!plan.optimal || left >= before, "said to be optimal\n{text}");
        true
    });
    assert!(spared > 20, "only {spared} plans could be shortened: the search is too weak to say anything");
}
