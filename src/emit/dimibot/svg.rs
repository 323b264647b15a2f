//! Pictures of DiMiBots: lattice, obstacles with their growth, the path of the tip with its stops, and the modules.
//!
//! Robots that share a scene are drawn in one panel, in the scene's coordinates.

use crate::claims::dimibot::{DimibotObstacle, DimibotObstacleBody, DimibotOrder};
use crate::device::dimibot::{LatticeCell, Side};
use crate::emit::dimibot::motion::{extent_um, jobs, last_cell, place, poses, stops, tiles_um};
use crate::emit::svg::drawing::{
    Anchor, Drawing, HAIR_PT, PaperBox, PaperView, PlacedLabel, ShapeStyle, TEXT_PT, THIN_PT, TextStyle, WAY_PT, color,
    decimal,
};
use crate::emit::svg::legend::{LegendSymbol, PanelLegend};
use crate::emit::svg::scenery::{self, simplified};
use crate::emit::svg::strobe::{MAX_NUMBERS, MAX_STROBES, StrobedPlace, Strobes};
use crate::emit::svg::{Panel, Pictured, Subject};
use crate::geometry::Shape;
use crate::schedule::dimibot::DimibotState;
use crate::schedule::{PlanRecord, State};
use std::collections::{BTreeMap, BTreeSet};

/// Least distance of lattice points on paper; of a finer lattice only every second, fourth, … is drawn.
const LATTICE_PT: f64 = 3.0;

/// Greatest number of marked stops.
const MAX_STOPS: usize = 200;

/// Greatest width of the square of a module.
const MODULE_PT: f64 = 9.0;

/// Least width of the square of a module with a digit in it.
const DIGIT_PT: f64 = 6.5;

/// A robot with its motion.
struct LatticeRobot<'a> {
    device: &'a str,
    jobs: Vec<(&'a DimibotOrder, &'a PlanRecord)>,
    /// In its own frame.
    poses: Vec<(u64, [f64; 3])>,
    color: &'static str,
    /// Whether another robot is drawn in the same panel.
    shares_panel: bool,
}

struct LatticePanel<'a> {
    robots: Vec<LatticeRobot<'a>>,
    moment_ns: Option<u64>,
    strobes: Strobes,
    subject: Subject<'a>,
}

impl Pictured for DimibotOrder {
    fn panels<'a>(&'a self, subject: Subject<'a>) -> Vec<Box<dyn Panel + 'a>> {
        let devices = devices_in_scene(subject);
        if devices.first() != Some(&subject.device) {
            return Vec::new();
        }
        let robot = |(index, device): (usize, &&'a str)| LatticeRobot {
            device,
            jobs: jobs(subject.verified, device),
            poses: poses(subject.verified, subject.signals, device),
            color: color::in_turn(index),
            shares_panel: devices.len() > 1,
        };
        let robots: Vec<LatticeRobot> = devices.iter().enumerate().map(robot).collect();
        let strobes = strobes(&robots);
        vec![Box::new(LatticePanel { robots, moment_ns: subject.moment_ns, strobes, subject })]
    }
}

/// The devices that share a scene with the subject, itself included, in the order of their first jobs.
fn devices_in_scene(subject: Subject<'_>) -> Vec<&str> {
    let claims = subject.verified.claims();
    let Some(scene) = claims.shared.iter().find(|scene| scene.frames.contains_key(subject.device)) else {
        return vec![subject.device];
    };
    let mut devices: Vec<&str> = Vec::new();
    for job in &claims.jobs {
        if scene.frames.contains_key(&job.device) && !devices.contains(&job.device.as_str()) {
            devices.push(&job.device);
        }
    }
    devices
}

/// The instants of all states, and those at which a tip is at a stop.
fn strobes(robots: &[LatticeRobot]) -> Strobes {
    let (mut all, mut stopped) = (BTreeSet::new(), BTreeSet::new());
    for (order, plan) in robots.iter().flat_map(|robot| &robot.jobs) {
        let cells: BTreeSet<[u32; 2]> = stops(order).into_iter().map(LatticeCell::pair).collect();
        let mut last = None;
        for timed in &plan.states {
            let State::Dimibot(DimibotState { cell, .. }) = timed.state else { continue };
            if last != Some(cell) || all.is_empty() {
                all.insert(timed.t_ns);
                stopped.extend(cells.contains(&cell).then_some(timed.t_ns));
            }
            last = Some(cell);
        }
    }
    Strobes::chosen(&all, &stopped, (MAX_NUMBERS / robots.len().max(1)).min(MAX_STROBES))
}

impl LatticeRobot<'_> {
    fn order(&self) -> Option<&DimibotOrder> {
        self.jobs.first().map(|(order, _)| *order)
    }

    /// ` of left` if several robots share the panel, else nothing.
    fn of(&self) -> String {
        if self.shares_panel { format!(" of {}", self.device) } else { String::new() }
    }

    /// A position in its own frame, converted to the scene.
    fn in_scene(&self, own_um: [f64; 2]) -> [f64; 2] {
        self.order().map_or(own_um, |order| order.in_scene_um(own_um))
    }

    /// The tip in its own frame, interpolated within a pulse.
    fn tip_um(&self, t_ns: u64) -> Option<[f64; 2]> {
        scenery::between(&self.poses, t_ns, |[x, y, _]| [*x, *y])
    }

    /// The path over the states whose instants `is_meant` accepts, in the scene.
    fn way(&self, is_meant: impl Fn(u64) -> bool) -> Vec<[f64; 2]> {
        let states = self.jobs.iter().flat_map(|(_, plan)| &plan.states).filter(|timed| is_meant(timed.t_ns));
        let places = states.map(|timed| {
            let [x, y, _] = place(timed);
            self.in_scene([x, y])
        });
        simplified(places)
    }

    /// The word of its modules at an instant, or at the end.
    fn word(&self, moment_ns: Option<u64>) -> u64 {
        let states = self.jobs.iter().flat_map(|(_, plan)| &plan.states);
        let by_then = states.clone().rfind(|timed| moment_ns.is_none_or(|t_ns| timed.t_ns <= t_ns));
        match by_then.or_else(|| states.clone().next()).map(|timed| &timed.state) {
            Some(State::Dimibot(DimibotState { word, .. })) => *word,
            Some(State::ElectrodeArray(_) | State::Microrobots(_) | State::Fingers(_)) | None => 0,
        }
    }
}

impl Panel for LatticePanel<'_> {
    fn title(&self) -> String {
        let one = |robot: &LatticeRobot| {
            let facts = robot.order().map(|order| &order.facts)?;
            let cells = Side::BOTH.map(|side| facts.cells(side));
            Some(format!("{}: {} × {} cells", robot.device, cells[0], cells[1]))
        };
        self.robots.iter().filter_map(one).collect::<Vec<_>>().join(", ")
    }

    fn extent(&self) -> [[f64; 2]; 2] {
        let corners = self.robots.iter().filter_map(|robot| {
            let order = robot.order()?;
            let ([x0, y0], [x1, y1]) = tiles_um(&order.facts, LatticeCell::default(), last_cell(&order.facts));
            Some([[x0, y0], [x1, y0], [x0, y1], [x1, y1]].map(|corner| robot.in_scene(corner)))
        });
        let tips = self.robots.iter().filter_map(|robot| robot.order()).map(|order| order.facts.tip_radius_um);
        scenery::about(corners.flatten(), tips.fold(0.0, f64::max))
    }

    fn draw(&self, view: &PaperView, to: &mut Drawing) -> PanelLegend {
        let mut legend = PanelLegend::default();
        self.robots.iter().for_each(|robot| draw_lattice(robot, view, to, &mut legend));
        draw_obstacles(&self.robots, view, to, &mut legend);
        for robot in &self.robots {
            match self.moment_ns {
                Some(t_ns) => draw_moment(robot, t_ns, view, to, &mut legend),
                None => draw_strobes(robot, &self.strobes, view, to, &mut legend),
            }
        }
        if self.moment_ns.is_none() {
            legend.under.push(self.strobes.times());
            legend.under.extend(self.strobes.note.clone());
        }
        legend
    }

    fn draw_foot(&self, room: PaperBox, top_pt: f64, to: &mut Drawing) -> f64 {
        let mut top_pt = top_pt;
        for robot in &self.robots {
            draw_modules(robot, self, PaperBox { top: top_pt, ..room }, to);
            top_pt += MODULE_PT + 3.0;
        }
        top_pt
    }
}

fn draw_lattice(robot: &LatticeRobot, view: &PaperView, to: &mut Drawing, legend: &mut PanelLegend) {
    let Some(order) = robot.order() else { return };
    let facts = &order.facts;
    let [x, y] = extent_um(facts);
    let corners = [[0.0, 0.0], [x, 0.0], [x, y], [0.0, y]].map(|corner| robot.in_scene(corner));
    to.shape(&view.all(corners), ShapeStyle::line(color::FAINT, HAIR_PT), &[]);
    let strides = Side::BOTH.map(|side| {
        let apart_pt = facts.pitch_um(side) * view.scale;
        let wanted = (LATTICE_PT / apart_pt.max(f64::MIN_POSITIVE)).max(1.0);
        (0..u32::BITS - 1).map(|bit| 1u32 << bit).find(|stride| f64::from(*stride) >= wanted).unwrap_or(1 << 30)
    });
    let columns = (0..facts.cells(Side::Left)).step_by(strides[0] as usize);
    let places = columns.flat_map(|x| {
        let rows = (0..facts.cells(Side::Right)).step_by(strides[1] as usize);
        rows.map(move |y| LatticeCell { x, y })
    });
    to.dots(places.map(|cell| view.at(robot.in_scene(facts.place_um(cell)))), 0.9, color::DOTS);
    let each =
        |stride: u32| if stride == 1 { "each".to_owned() } else { format!("every {}", scenery::ordinal(stride)) };
    let text = match strides {
        [1, 1] => "lattice cell".to_owned(),
        [x, y] => format!("lattice cell, {} along x, {} along y", each(x), each(y)),
    };
    legend.add(LegendSymbol::Disc, ShapeStyle::filled(color::DOTS), text);
}

fn draw_obstacles(robots: &[LatticeRobot], view: &PaperView, to: &mut Drawing, legend: &mut PanelLegend) {
    // Robots share the obstacles of their scene: each is drawn once, with the largest growth.
    let mut obstacles: BTreeMap<&str, Vec<(&DimibotObstacle, &DimibotOrder)>> = BTreeMap::new();
    let mut growth_um: f64 = 0.0;
    for (order, _) in robots.iter().flat_map(|robot| &robot.jobs) {
        growth_um = growth_um.max(order.facts.growth_um());
        for obstacle in order.obstacles.iter() {
            let known = obstacles.entry(&obstacle.name).or_default();
            if !known.iter().any(|(other, _)| other.body == obstacle.body) {
                known.push((obstacle, order));
            }
        }
    }
    let all: Vec<(&DimibotObstacle, &DimibotOrder)> = obstacles.into_values().flatten().collect();
    if all.is_empty() {
        return;
    }
    let drawn = &all[..all.len().min(scenery::MAX_OBSTACLES)];
    let solids: Vec<(&Shape, &crate::geometry::Pose)> = drawn
        .iter()
        .filter_map(|(obstacle, _)| match &obstacle.body {
            DimibotObstacleBody::Solid { shape, pose } => Some((shape, pose)),
            DimibotObstacleBody::Cells { .. } => None,
        })
        .collect();
    for (grown_um, color) in [(growth_um, color::GROWN), (0.0, color::OBSTACLE)] {
        solids.iter().for_each(|(shape, pose)| scenery::solid(shape, pose, grown_um, color, view, to));
    }
    for (obstacle, order) in drawn {
        let at = match &obstacle.body {
            DimibotObstacleBody::Solid { shape, pose } => scenery::middle(shape, pose),
            DimibotObstacleBody::Cells { from, to: last } => {
                let ([x0, y0], [x1, y1]) = tiles_um(&order.facts, *from, *last);
                let corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map(|corner| order.in_scene_um(corner));
                to.shape(&view.all(corners), ShapeStyle::filled(color::OBSTACLE), &[]);
                order.in_scene_um([(x0 + x1) / 2.0, (y0 + y1) / 2.0])
            }
        };
        if all.len() <= scenery::MAX_NAMES {
            to.label(scenery::name(&obstacle.name, view.at(at)));
        }
    }
    legend.add(LegendSymbol::Box, ShapeStyle::filled(color::OBSTACLE), scenery::obstacles_text(all.len(), drawn.len()));
    if !solids.is_empty() {
        legend.add(LegendSymbol::Box, ShapeStyle::filled(color::GROWN), "kept free for tip radius and repeatability");
    }
}

/// Draws rings around the stops, with their cells.
fn draw_stops(
    robot: &LatticeRobot,
    named: &BTreeMap<[u32; 2], String>,
    view: &PaperView,
    to: &mut Drawing,
    legend: &mut PanelLegend,
) {
    let mut met = BTreeSet::new();
    for (order, _) in &robot.jobs {
        for cell in stops(order).into_iter().filter(|cell| met.insert(cell.pair())).take(MAX_STOPS) {
            let at = view.at(robot.in_scene(order.facts.place_um(cell)));
            to.disc(at, 4.0, ShapeStyle::line(color::STOP, 1.0), &[("stop", format!("{} {}", cell.x, cell.y))]);
            to.mark(PaperBox::about(at, 4.0));
            let text = match named.get(&cell.pair()) {
                Some(numbers) => format!("{numbers} {cell}"),
                None => cell.to_string(),
            };
            let text_style = TextStyle::SMALL.bold().colored(color::STOP);
            to.label(PlacedLabel { text, text_style, at, radius_pt: 4.0, may_cover: false });
        }
    }
    if !met.is_empty() {
        legend.add(LegendSymbol::Disc, ShapeStyle::line(color::STOP, 1.0), "stop, with its cell");
    }
}

fn draw_strobes(robot: &LatticeRobot, strobes: &Strobes, view: &PaperView, to: &mut Drawing, legend: &mut PanelLegend) {
    let Some(order) = robot.order() else { return };
    let way = scenery::thinned(&robot.way(|_| true));
    to.line(&view.all(way.points), ShapeStyle::line(robot.color, WAY_PT), &[]);
    legend.add(
        LegendSymbol::Line,
        ShapeStyle::line(robot.color, WAY_PT),
        format!("path of the tip{}, from state to state{}", robot.of(), way.remark),
    );
    let places = StrobedPlace::all(strobes, |t_ns| robot.tip_um(t_ns));
    let cell = |place: &StrobedPlace| order.facts.nearest_cell(place.place).map(LatticeCell::pair);
    let stops: BTreeSet<[u32; 2]> =
        robot.jobs.iter().flat_map(|(order, _)| stops(order)).map(LatticeCell::pair).collect();
    let mut named = BTreeMap::new();
    let mut passed = Vec::new();
    for place in &places {
        let at = view.at(robot.in_scene(place.place));
        let style = ShapeStyle::filled(robot.color).with_stroke(color::INK, HAIR_PT);
        let tip = order.facts.tip_radius_um * view.scale;
        to.disc(at, tip.clamp(1.8, 6.0), style, &tip_attributes(robot, place));
        to.mark(PaperBox::about(at, 2.0));
        match cell(place).filter(|cell| stops.contains(cell)) {
            Some(cell) => drop(named.insert(cell, place.numbers())),
            None => passed.push((place, at)),
        }
    }
    draw_stops(robot, &named, view, to, legend);
    for (at, numbers) in StrobedPlace::clustered(passed) {
        to.label(scenery::numbers(&numbers, at, 2.0));
    }
    let style = ShapeStyle::filled(robot.color).with_stroke(color::INK, HAIR_PT);
    legend.add(LegendSymbol::Disc, style, format!("tip{}, numbered", robot.of()));
}

/// Data attributes of a drawn tip, in the robot's own frame as in the schedule.
fn tip_attributes<'f>(robot: &LatticeRobot, place: &StrobedPlace) -> Vec<(&'f str, String)> {
    let [x, y] = place.place;
    let mut facts = vec![("device", robot.device.to_owned()), ("t-ns", place.instants())];
    facts.extend([("x-um", decimal(x, 6)), ("y-um", decimal(y, 6))]);
    if let Some(frame) = robot.order().and_then(|order| order.frame) {
        facts.push(("frame", format!("{} {} {}", frame.x_um, frame.y_um, decimal(frame.heading_rad, 12))));
    }
    facts
}

fn draw_moment(robot: &LatticeRobot, t_ns: u64, view: &PaperView, to: &mut Drawing, legend: &mut PanelLegend) {
    let (Some(order), Some(tip_um)) = (robot.order(), robot.tip_um(t_ns)) else { return };
    let here = robot.in_scene(tip_um);
    let mut behind = robot.way(|other_ns| other_ns <= t_ns);
    behind.push(here);
    let ahead: Vec<[f64; 2]> = std::iter::once(here).chain(robot.way(|other_ns| other_ns > t_ns)).collect();
    let (behind, ahead) = (scenery::thinned(&behind), scenery::thinned(&ahead));
    to.line(&view.all(ahead.points), ShapeStyle::line(color::AHEAD, THIN_PT).dashed("2 2"), &[]);
    to.line(&view.all(behind.points), ShapeStyle::line(robot.color, WAY_PT), &[]);
    let at = view.at(here);
    let tip_pt = (order.facts.tip_radius_um * view.scale).clamp(2.4, 8.0);
    let place = StrobedPlace { place: tip_um, strobes: vec![(1, t_ns)] };
    to.disc(
        at,
        tip_pt,
        ShapeStyle::filled(robot.color).with_stroke(color::INK, THIN_PT),
        &tip_attributes(robot, &place),
    );
    to.mark(PaperBox::about(at, tip_pt));
    draw_stops(robot, &BTreeMap::new(), view, to, legend);
    legend.add(
        LegendSymbol::Disc,
        ShapeStyle::filled(robot.color).with_stroke(color::INK, THIN_PT),
        format!("tip{}", robot.of()),
    );
    legend.add(LegendSymbol::Line, ShapeStyle::line(robot.color, WAY_PT), format!("where it was{}", behind.remark));
    legend.add(
        LegendSymbol::Line,
        ShapeStyle::line(color::AHEAD, THIN_PT).dashed("2 2"),
        format!("where it will be{}", ahead.remark),
    );
    legend.add(
        LegendSymbol::Box,
        ShapeStyle::filled(robot.color).with_stroke(color::SOFT, HAIR_PT),
        format!("module at 1{}", robot.of()),
    );
    legend.add(
        LegendSymbol::Box,
        ShapeStyle::filled(color::LIT).with_stroke(color::SOFT, HAIR_PT),
        "module that is being switched",
    );
}

/// Draws the modules as squares, the top one first, filled at 1; at an instant those being switched are highlighted.
fn draw_modules(robot: &LatticeRobot, panel: &LatticePanel, room: PaperBox, to: &mut Drawing) {
    let Some(order) = robot.order() else { return };
    let facts = &order.facts;
    let word = robot.word(panel.moment_ns);
    let lit = panel.moment_ns.map_or_else(BTreeSet::new, |t_ns| pulsed(panel.subject, robot.device, t_ns));
    let when = if panel.moment_ns.is_some() { "now" } else { "at the end" };
    let text = match panel.robots.len() {
        1 => format!("modules {when}"),
        _ => format!("modules of {} {when}", robot.device),
    };
    let base = room.top + TEXT_PT;
    to.text([room.left, base], &text, TextStyle::SMALL.colored(color::SOFT));
    let mut left = room.left + TextStyle::SMALL.width_pt(&text) + 6.0;
    let count = f64::from(facts.left + facts.right);
    let size_pt = ((room.right - left - 34.0) / count).clamp(1.5, MODULE_PT);
    for (side, name, shift) in [(Side::Left, "bl", facts.right), (Side::Right, "br", 0)] {
        to.text([left, base], name, TextStyle::SMALL);
        left += TextStyle::SMALL.width_pt(name) + 2.0;
        for module in (0..facts.modules(side)).rev() {
            let is_set = (word >> (shift + module)) & 1 == 1;
            let is_lit = lit.contains(&format!("{name}{module}"));
            let fill = match (is_lit, is_set) {
                (true, _) => color::LIT,
                (false, true) => robot.color,
                (false, false) => color::PANEL,
            };
            let square =
                PaperBox { left, right: left + size_pt - 1.0, top: room.top, bottom: room.top + MODULE_PT - 0.5 };
            let facts =
                [("module", format!("{}.{name}{module}", robot.device)), ("state", u8::from(is_set).to_string())];
            to.rect(square, ShapeStyle::filled(fill).with_stroke(color::SOFT, HAIR_PT), &facts);
            if size_pt >= DIGIT_PT {
                let [x, _] = square.middle();
                let text_style = TextStyle::SMALL.anchored(Anchor::Middle);
                to.text([x, base - 0.2], if is_set { "1" } else { "0" }, text_style);
            }
            left += size_pt;
        }
        left += 6.0;
    }
}

/// The modules of a device that are being switched at an instant, such as `bl3`.
fn pulsed(subject: Subject, device: &str, t_ns: u64) -> BTreeSet<String> {
    let channels = subject.signals.schedule.channels.iter().enumerate().filter(|(_, channel)| channel.device == device);
    let on = channels.filter(|(index, _)| subject.signals.value(*index, t_ns) != 0.0);
    on.filter_map(|(_, channel)| {
        Some(channel.name.strip_prefix(device)?.strip_prefix('.')?.split('.').next()?.to_owned())
    })
    .collect()
}
