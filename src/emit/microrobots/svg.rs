//! Pictures of microrobots: the bed with its obstacles, the robots with their headings and trails, and an enlarged view
//! of the docks.

use crate::claims::microrobots::{MicrorobotsAction, MicrorobotsObstacle, MicrorobotsOrder};
use crate::device::microrobots::{Arm, Robot};
use crate::emit::microrobots::motion::{BedMotion, goals, nose_corners};
use crate::emit::svg::drawing::{
    Drawing, HAIR_PT, PaperBox, PaperView, PlacedLabel, ShapeStyle, THIN_PT, TextStyle, color, decimal,
};
use crate::emit::svg::legend::{LegendSymbol, PanelLegend};
use crate::emit::svg::scenery::{self, simplified};
use crate::emit::svg::strobe::{MAX_NUMBERS, MAX_STROBES, StrobedPlace, Strobes, ranges};
use crate::emit::svg::{Panel, Pictured, Subject};
use crate::geometry::Pose;
use crate::real::Real;
use nalgebra::Point2;
use std::collections::BTreeSet;
use std::rc::Rc;

/// Widths of the panels of the bed and of the dock beside it, in columns.
const BED_SHARE: f64 = 1.25;
const DOCK_SHARE: f64 = 0.75;

/// Opacity of a robot on its way.
const PASSING: f64 = 0.45;

/// Greatest number of outlined goals.
const MAX_GOALS: usize = 400;

/// Motion of a bed, shared by its panels.
struct BedPicture<'a> {
    subject: Subject<'a>,
    motion: BedMotion<'a>,
    strobes: Strobes,
}

/// Panel of the whole bed, or of the area around the docks.
struct BedPanel<'a> {
    picture: Rc<BedPicture<'a>>,
    part: BedPart,
    has_dock: bool,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum BedPart {
    Whole,
    Dock,
}

impl Pictured for MicrorobotsOrder {
    fn panels<'a>(&'a self, subject: Subject<'a>) -> Vec<Box<dyn Panel + 'a>> {
        let motion = BedMotion::new(subject.verified, subject.device);
        let legs = motion.plans.iter().flat_map(|plan| &plan.legs).map(|leg| leg.start_ns);
        let ends = motion.plans.iter().filter_map(|plan| Some(plan.legs.last()?.end_ns));
        let all: BTreeSet<u64> = legs.chain(ends).collect();
        let schedule = subject.verified.schedule();
        let own = |plan: u32| schedule.plans.get(plan as usize).is_some_and(|plan| plan.device == subject.device);
        let steps = schedule.steps.iter().filter(|step| own(step.plan));
        let stops: BTreeSet<u64> = steps.map(|step| step.end_ns()).collect();
        let most = (MAX_NUMBERS / motion.robots.len().max(1)).min(MAX_STROBES);
        let strobes = Strobes::chosen(&all, &stops, most);
        let is_dock = |order: &MicrorobotsOrder| {
            order.steps.iter().any(|step| matches!(step.action, MicrorobotsAction::Assemble(_)))
        };
        let has_dock = motion.plans.iter().any(|plan| is_dock(plan.order));
        let picture = Rc::new(BedPicture { subject, motion, strobes });
        let panel = |part| Box::new(BedPanel { picture: Rc::clone(&picture), part, has_dock }) as Box<dyn Panel + 'a>;
        match has_dock {
            true => vec![panel(BedPart::Whole), panel(BedPart::Dock)],
            false => vec![panel(BedPart::Whole)],
        }
    }
}

impl BedPicture<'_> {
    fn order(&self) -> Option<&MicrorobotsOrder> {
        self.motion.plans.first().map(|plan| plan.order)
    }

    /// The instants whose poses are drawn.
    fn instants(&self) -> Vec<u64> {
        self.subject.moment_ns.map_or_else(|| self.strobes.instants.clone(), |t_ns| vec![t_ns])
    }

    /// The path of a robot over the moments that `is_meant` accepts.
    fn way(&self, robot: usize, is_meant: impl Fn(u64) -> bool) -> Vec<[f64; 2]> {
        let moments = self.motion.plans.iter().flat_map(|plan| &plan.moments).filter(|moment| is_meant(moment.t_ns));
        simplified(moments.map(|moment| [moment.poses[robot].x_um, moment.poses[robot].y_um]))
    }
}

impl Panel for BedPanel<'_> {
    fn title(&self) -> String {
        let device = self.picture.subject.device;
        match self.part {
            BedPart::Whole => format!("{device}: {} robots on one voltage", self.picture.motion.robots.len()),
            BedPart::Dock => "where they meet, enlarged".to_owned(),
        }
    }

    fn extent(&self) -> [[f64; 2]; 2] {
        let Some(order) = self.picture.order() else { return [[0.0; 2], [1.0; 2]] };
        let robots = (0..order.robots.len()).map(|robot| order.robot(robot));
        let longest_um = robots.map(|robot| robot.length_um.max(2.0 * robot.width_um)).fold(0.0, f64::max);
        let goals = self.picture.motion.plans.iter().flat_map(|plan| goals(plan.order)).map(|(_, stop)| stop.pose);
        let place = |pose: &Pose| [pose.x_um, pose.y_um];
        match self.part {
            BedPart::Whole => {
                let moments = self.picture.motion.plans.iter().flat_map(|plan| &plan.moments);
                let poses = moments.flat_map(|moment| moment.poses.iter().map(place));
                let obstacles = order.obstacles.iter().map(|obstacle| place(&obstacle.pose));
                let goals = goals.map(|pose| place(&pose)).collect::<Vec<_>>();
                scenery::about(poses.chain(obstacles).chain(goals), 0.6 * longest_um)
            }
            BedPart::Dock => scenery::about(goals.map(|pose| place(&pose)).collect::<Vec<_>>(), 0.9 * longest_um),
        }
    }

    fn share(&self) -> f64 {
        match (self.part, self.has_dock) {
            (BedPart::Whole, false) => 1.0,
            (BedPart::Whole, true) => BED_SHARE,
            (BedPart::Dock, _) => DOCK_SHARE,
        }
    }

    fn draw(&self, view: &PaperView, to: &mut Drawing) -> PanelLegend {
        let mut legend = PanelLegend::default();
        if self.picture.order().is_none() {
            return legend;
        }
        if self.part == BedPart::Dock {
            to.rect(view.room, ShapeStyle::line(color::FAINT, HAIR_PT), &[]);
        }
        draw_obstacles(self, view, to, &mut legend);
        draw_trails(self, view, to, &mut legend);
        draw_goals(self, view, to, &mut legend);
        draw_robots(self, view, to, &mut legend);
        if self.picture.subject.moment_ns.is_none() && self.part == BedPart::Whole {
            legend.under.push(self.picture.strobes.times());
            legend.under.extend(self.picture.strobes.note.clone());
        }
        legend
    }
}

fn draw_obstacles(panel: &BedPanel, view: &PaperView, to: &mut Drawing, legend: &mut PanelLegend) {
    let mut all: Vec<&MicrorobotsObstacle> = Vec::new();
    let mut clearance_um: f64 = 0.0;
    for plan in &panel.picture.motion.plans {
        clearance_um = clearance_um.max(plan.order.facts.clearance_um);
        for obstacle in plan.order.obstacles.iter() {
            let is_same = |other: &&MicrorobotsObstacle| {
                (&other.name, &other.shape, other.pose) == (&obstacle.name, &obstacle.shape, obstacle.pose)
            };
            if !all.iter().any(is_same) {
                all.push(obstacle);
            }
        }
    }
    for (growth_um, color) in [(clearance_um, color::GROWN), (0.0, color::OBSTACLE)] {
        all.iter().for_each(|obstacle| scenery::solid(&obstacle.shape, &obstacle.pose, growth_um, color, view, to));
    }
    if panel.part == BedPart::Whole && all.len() <= scenery::MAX_NAMES {
        for obstacle in &all {
            to.label(scenery::name(&obstacle.name, view.at(scenery::middle(&obstacle.shape, &obstacle.pose))));
        }
    }
    if !all.is_empty() {
        legend.add(
            LegendSymbol::Box,
            ShapeStyle::filled(color::OBSTACLE),
            scenery::obstacles_text(all.len(), all.len()),
        );
        legend.add(LegendSymbol::Box, ShapeStyle::filled(color::GROWN), "clearance about it");
    }
}

fn draw_trails(panel: &BedPanel, view: &PaperView, to: &mut Drawing, legend: &mut PanelLegend) {
    let picture = &panel.picture;
    let moment_ns = picture.subject.moment_ns;
    let here = moment_ns.and_then(|t_ns| picture.motion.at(t_ns)).map(|(_, _, poses)| poses);
    let mut remark = String::new();
    for robot in 0..picture.motion.robots.len() {
        let place = here.as_ref().map(|poses| [poses[robot].x_um, poses[robot].y_um]);
        let behind = picture.way(robot, |t_ns| moment_ns.is_none_or(|moment_ns| t_ns <= moment_ns));
        let way = scenery::thinned(&simplified(behind.into_iter().chain(place)));
        to.line(&view.all(way.points), ShapeStyle::line(color::in_turn(robot), THIN_PT), &[]);
        remark = way.remark;
        if let Some(t_ns) = moment_ns {
            let ahead = picture.way(robot, |other_ns| other_ns > t_ns);
            let way = scenery::thinned(&simplified(place.into_iter().chain(ahead)));
            to.line(&view.all(way.points), ShapeStyle::line(color::AHEAD, HAIR_PT).dashed("2 2"), &[]);
        }
    }
    let text = if moment_ns.is_some() { "trail so far" } else { "trail" };
    legend.add(LegendSymbol::Line, ShapeStyle::line(color::AHEAD, THIN_PT), format!("{text}{remark}"));
    if moment_ns.is_some() {
        legend.add(LegendSymbol::Line, ShapeStyle::line(color::AHEAD, HAIR_PT).dashed("2 2"), "its way ahead");
    }
}

fn draw_goals(panel: &BedPanel, view: &PaperView, to: &mut Drawing, legend: &mut PanelLegend) {
    let style = ShapeStyle::line(color::STOP, 0.8).dashed("2 1.5");
    let plans = &panel.picture.motion.plans;
    let all = plans.iter().flat_map(|plan| goals(plan.order).map(|(robot, stop)| (plan.order.robot(robot), stop.pose)));
    for (robot, pose) in all.take(MAX_GOALS) {
        to.shape(&placed(&corners(robot), &pose, view), style, &[("goal", robot.name.clone())]);
    }
    if plans.iter().any(|plan| goals(plan.order).next().is_some()) {
        legend.add(LegendSymbol::Box, style, "goal pose");
    }
}

fn corners(robot: &Robot) -> [Point2<f64>; 4] {
    let (a, b) = (robot.length_um / 2.0, robot.width_um / 2.0);
    [Point2::new(-a, -b), Point2::new(a, -b), Point2::new(a, b), Point2::new(-a, b)]
}

/// Points of a robot's frame on paper.
fn placed(points: &[Point2<f64>], pose: &Pose, view: &PaperView) -> Vec<[f64; 2]> {
    let frame = pose.isometry();
    view.all(points.iter().map(|point| {
        let point = frame * point;
        [point.x, point.y]
    }))
}

fn draw_robots(panel: &BedPanel, view: &PaperView, to: &mut Drawing, legend: &mut PanelLegend) {
    let picture = &panel.picture;
    let instants = picture.instants();
    let is_moment = picture.subject.moment_ns.is_some();
    // The last ones lie above the others.
    for (number, t_ns) in (1..).zip(&instants) {
        let Some((plan, leg, poses)) = picture.motion.at(*t_ns) else { continue };
        let is_last = number == instants.len();
        if panel.part == BedPart::Dock && !is_last {
            continue;
        }
        for (robot, pose) in poses.iter().enumerate() {
            let facts = plan.order.robot(robot);
            let fill = color::in_turn(robot);
            let style = match (is_last, number) {
                (true, _) => ShapeStyle::filled(fill).with_stroke(color::INK, THIN_PT),
                (false, 1) => ShapeStyle::filled(color::PAPER).with_stroke(fill, 1.0),
                (false, _) => ShapeStyle::filled(fill).with_opacity(PASSING),
            };
            to.shape(&placed(&corners(facts), pose, view), style, &attributes_of(panel, &facts.name, pose, *t_ns));
            let nose = ShapeStyle::filled(if number == 1 && !is_last { fill } else { color::INK });
            to.shape(&placed(&nose_corners(facts), pose, view), nose, &[]);
            if leg.movers[robot].arm == Arm::Down && is_moment {
                draw_arm(facts, pose, view, to);
            }
        }
    }
    label_robots(panel, &instants, view, to);
    let grey = color::AHEAD;
    if is_moment {
        legend.add(
            LegendSymbol::Box,
            ShapeStyle::filled(grey).with_stroke(color::INK, THIN_PT),
            "robot, black in front",
        );
        legend.add(
            LegendSymbol::Disc,
            ShapeStyle::filled(color::ALARM).with_stroke(color::INK, HAIR_PT),
            "arm down: it turns",
        );
    } else {
        legend.add(LegendSymbol::Box, ShapeStyle::filled(color::PAPER).with_stroke(grey, 1.0), "robot at its start");
        legend.add(LegendSymbol::Box, ShapeStyle::filled(grey).with_opacity(PASSING), "at a numbered instant");
        legend.add(
            LegendSymbol::Box,
            ShapeStyle::filled(grey).with_stroke(color::INK, THIN_PT),
            "at its end, black in front",
        );
    }
}

fn attributes_of(panel: &BedPanel, robot: &str, pose: &Pose, t_ns: u64) -> Vec<(&'static str, String)> {
    let heading = decimal(pose.heading_rad.to_degrees(), 6);
    vec![
        ("device", panel.picture.subject.device.to_owned()),
        ("robot", robot.to_owned()),
        ("t-ns", t_ns.to_string()),
        ("x-um", decimal(pose.x_um, 6)),
        ("y-um", decimal(pose.y_um, 6)),
        ("heading-deg", heading),
    ]
}

/// Draws the arm, which reaches out at the front, on the side to which the robot turns.
fn draw_arm(robot: &Robot, pose: &Pose, view: &PaperView, to: &mut Drawing) {
    let (x, y) = (0.3 * robot.length_um, robot.turning.sign() * robot.width_um);
    let arm = placed(&[Point2::new(x, 0.0), Point2::new(x, y)], pose, view);
    to.line(&arm, ShapeStyle::line(color::INK, THIN_PT), &[]);
    let radius_pt = (0.22 * robot.width_um * view.scale).max(1.4);
    to.disc(arm[1], radius_pt, ShapeStyle::filled(color::ALARM).with_stroke(color::INK, HAIR_PT), &[]);
}

/// Labels robots: names at the start, at a single instant and in the dock; otherwise strobe numbers.
fn label_robots(panel: &BedPanel, instants: &[u64], view: &PaperView, to: &mut Drawing) {
    let picture = &panel.picture;
    let Some(order) = picture.order() else { return };
    let strobes = Strobes { instants: instants.to_vec(), note: None };
    let mut numbered: Vec<PlacedLabel> = Vec::new();
    for robot in 0..order.robots.len() {
        let facts = order.robot(robot);
        let radius_pt = (0.3 * facts.length_um.hypotenuse(facts.width_um) * view.scale).max(2.0);
        let pose = |t_ns: u64| picture.motion.at(t_ns).map(|(_, _, poses)| poses[robot]);
        let places = StrobedPlace::all(&strobes, |t_ns| pose(t_ns).map(|pose| [pose.x_um, pose.y_um]));
        let name =
            |at, text| PlacedLabel { text, text_style: TextStyle::SMALL.bold(), at, radius_pt, may_cover: false };
        if let (BedPart::Dock, Some(last)) = (panel.part, places.last()) {
            let at = view.at(last.place);
            // Robots elsewhere are named in the panel of the whole bed.
            if !view.room.surrounds(at) {
                continue;
            }
            to.mark(PaperBox::about(at, radius_pt));
            to.label(PlacedLabel { may_cover: true, ..name(at, facts.name.clone()) });
            continue;
        }
        let clusters = StrobedPlace::clustered(places.iter().map(|place| (place, view.at(place.place))));
        for (index, (at, numbers)) in clusters.into_iter().enumerate() {
            to.mark(PaperBox::about(at, radius_pt));
            match (index, instants.len()) {
                (0, 1) => to.label(name(at, facts.name.clone())),
                (0, _) => to.label(name(at, format!("{} {}", facts.name, ranges(&numbers)))),
                (_, _) => numbered.push(scenery::numbers(&numbers, at, radius_pt)),
            }
        }
    }
    numbered.into_iter().for_each(|label| to.label(label));
}
