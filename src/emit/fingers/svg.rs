//! Pictures of hands: the part and the tips in the plane of the turn, with one small panel per shown grasp.
//!
//! The first axis of a panel is the direction of the part's first axis when its turn began, so that the turn of the
//! part is visible.

use crate::claims::fingers::{FingersOrder, Section};
use crate::device::fingers::Plane;
use crate::emit::fingers::motion::{HandMoment, HandMotion, HandPlanMotion, PartPose, RecordedGrasp, corners};
use crate::emit::svg::drawing::{
    Drawing, HAIR_PT, PaperView, PlacedLabel, ShapeStyle, THIN_PT, TextStyle, WAY_PT, color, decimal,
};
use crate::emit::svg::legend::{LegendSymbol, PanelLegend};
use crate::emit::svg::scenery;
use crate::emit::svg::strobe::{Strobes, time};
use crate::emit::svg::{Panel, Pictured, Subject};
use crate::geometry::outline::Curve;
use crate::real::Real;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use std::collections::BTreeSet;
use std::rc::Rc;

/// Width of one of several panels, in columns.
const SHARE: f64 = 0.5;

/// Greatest number of drawn grasps: two rows.
const MAX_GRASPS: usize = 8;

/// Opacity of the inside of a part, and of a tip.
const INSIDE: f64 = 0.22;
const TIP: f64 = 0.85;

/// Radius of the arc that shows the turn of a part, as a share of its reach.
const ARC: f64 = 0.4;

struct HandPicture<'a> {
    subject: Subject<'a>,
    motion: HandMotion<'a>,
    /// Reach of everything drawn, from the middle of the part.
    reach_um: f64,
}

/// The hand at an instant.
struct GraspPanel<'a> {
    picture: Rc<HandPicture<'a>>,
    /// From 1; `None` for a single panel.
    number: Option<usize>,
    t_ns: u64,
    note: Option<String>,
}

/// View of a hand at an instant, in the plane of its turn.
struct TurnView<'p> {
    section: &'p Section,
    plane: Plane,
    /// The axes of the panel in the hand's frame.
    axes: [Vector3<f64>; 2],
    origin_um: [f64; 3],
    /// Rotation of the part since its turn began.
    turned_rad: f64,
}

impl Pictured for FingersOrder {
    fn panels<'a>(&'a self, subject: Subject<'a>) -> Vec<Box<dyn Panel + 'a>> {
        let motion = HandMotion::new(subject.verified, subject.signals, subject.device);
        let sections = [Some(&self.part.xy), self.part.xz.as_ref()].into_iter().flatten();
        let reaches = sections.filter_map(|section| Some(Curve::of(&section.outline).ok()?.reach_um()));
        let reach_um = reaches.fold(0.0, f64::max) + 2.4 * self.facts.tip_radius_um;
        let strobes = strobes(&motion, subject);
        let picture = Rc::new(HandPicture { subject, motion, reach_um });
        let panel = |number: Option<usize>, t_ns: u64| {
            let note = strobes.note.clone().filter(|_| number.is_some());
            Box::new(GraspPanel { picture: Rc::clone(&picture), number, t_ns, note }) as Box<dyn Panel + 'a>
        };
        match subject.moment_ns {
            Some(t_ns) => vec![panel(None, t_ns)],
            None => strobes.numbered().map(|(number, t_ns)| panel(Some(number), t_ns)).collect(),
        }
    }
}

/// The instants at which the set of holding fingers changes, and the ends of steps.
fn strobes(motion: &HandMotion, subject: Subject) -> Strobes {
    let schedule = subject.verified.schedule();
    let mut all = BTreeSet::new();
    for plan in &motion.plans {
        let holding = |grasp: &RecordedGrasp| grasp.contacts.iter().map(|contact| *contact > 0).collect::<Vec<_>>();
        all.extend(plan.grasps.first().map(|grasp| grasp.t_ns));
        all.extend(plan.grasps.last().map(|grasp| grasp.t_ns));
        let changed = plan.grasps.windows(2).filter(|pair| holding(&pair[0]) != holding(&pair[1]));
        all.extend(changed.map(|pair| pair[1].t_ns));
    }
    let own = |plan: u32| schedule.plans.get(plan as usize).is_some_and(|plan| plan.device == subject.device);
    let stops: BTreeSet<u64> = schedule.steps.iter().filter(|step| own(step.plan)).map(|step| step.end_ns()).collect();
    let last_ns = all.last().copied().unwrap_or(0);
    // Steps that end after the last state change nothing.
    all.extend(stops.iter().filter(|t_ns| **t_ns < last_ns));
    let mut strobes = Strobes::chosen(&all, &stops, MAX_GRASPS);
    strobes.note = strobes
        .note
        .map(|_| format!("drawn: {} of {} changes of the grasp and ends of steps", strobes.instants.len(), all.len()));
    strobes
}

fn turned(pose: &PartPose, [x, y, z]: [f64; 3]) -> Vector3<f64> {
    let [w, i, j, k] = pose.orientation;
    UnitQuaternion::new_normalize(Quaternion::new(w, i, j, k)) * Vector3::new(x, y, z)
}

impl<'p> TurnView<'p> {
    /// The view at an instant; while the part turns towards the next grasp, that of this turn.
    fn new(plan: &'p HandPlanMotion, index: usize, moment: &HandMoment) -> Option<TurnView<'p>> {
        let here = &plan.grasps[index];
        let is_moving = |next: &&RecordedGrasp| {
            moment.part.orientation != here.part.orientation && next.part.orientation != here.part.orientation
        };
        let meant = plan.grasps.get(index + 1).filter(is_moving).unwrap_or(here);
        let section = plan.order.part.section(meant.plane)?;
        let meant_rad = (meant.angle_index - 1) as f64 * section.step_rad;
        let (sin, cos) = meant_rad.sine_cosine();
        let [first, second] = meant.plane.axes().map(|axis| turned(&meant.part, axis));
        let axes = [first * cos - second * sin, first * sin + second * cos];
        let [now, _] = meant.plane.axes().map(|axis| turned(&moment.part, axis));
        let now_rad = now.dot(&axes[1]).arc_tangent_over(now.dot(&axes[0]));
        // The whole turns, which the angle alone does not show.
        let whole = ((meant_rad - now_rad) / std::f64::consts::TAU).round();
        let turned_rad = now_rad + whole * std::f64::consts::TAU;
        Some(TurnView { section, plane: meant.plane, axes, origin_um: moment.part.position_um, turned_rad })
    }

    /// A point of the hand's frame in the panel, and its height above the panel.
    fn seen(&self, place_um: [f64; 3]) -> ([f64; 2], f64) {
        let [x, y, z] = [0, 1, 2].map(|axis| place_um[axis] - self.origin_um[axis]);
        let away = Vector3::new(x, y, z);
        ([self.axes[0].dot(&away), self.axes[1].dot(&away)], self.axes[0].cross(&self.axes[1]).dot(&away))
    }

    /// A point of the section in the panel.
    fn of_section(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.turned_rad.sine_cosine();
        [x * cos - y * sin, x * sin + y * cos]
    }
}

impl Panel for GraspPanel<'_> {
    fn title(&self) -> String {
        let device = self.picture.subject.device;
        let at = time(self.t_ns);
        match self.number {
            Some(number) => format!("{number}: {device} at {at}"),
            None => format!("{device} at {at}"),
        }
    }

    fn extent(&self) -> [[f64; 2]; 2] {
        let reach_um = self.picture.reach_um;
        [[-reach_um; 2], [reach_um; 2]]
    }

    fn share(&self) -> f64 {
        if self.number.is_some() { SHARE } else { 1.0 }
    }

    fn draw(&self, view: &PaperView, to: &mut Drawing) -> PanelLegend {
        let mut legend = PanelLegend::default();
        let picture = &self.picture;
        let Some((plan, index, moment)) = picture.motion.at(picture.subject.signals, self.t_ns) else { return legend };
        let Some(turn) = TurnView::new(plan, index, &moment) else { return legend };
        let grasp = &plan.grasps[index];
        to.rect(view.room, ShapeStyle::line(color::FAINT, HAIR_PT), &[]);
        draw_part(self, plan, &turn, &moment, view, to);
        draw_tips(self, plan, grasp, &turn, &moment, view, to);
        legend.under.extend(self.words(grasp, &turn));
        legend.notes.extend(self.note.clone());
        legend.add(LegendSymbol::Box, ShapeStyle::line(color::INK, THIN_PT), "part, cut in the plane of its turn");
        legend.add(LegendSymbol::Line, ShapeStyle::line(color::INK, HAIR_PT), "its x axis");
        legend.add(LegendSymbol::Line, ShapeStyle::line(color::STOP, WAY_PT), "turned since the turn began");
        legend.add(
            LegendSymbol::Disc,
            ShapeStyle::filled(color::in_turn(1)).with_stroke(color::INK, THIN_PT),
            "tip that holds",
        );
        legend.add(
            LegendSymbol::Disc,
            ShapeStyle::line(color::SOFT, THIN_PT).dashed("2 1.5"),
            "free tip, above or below the plane",
        );
        legend
    }
}

impl GraspPanel<'_> {
    /// The step that ends or continues, the angle, and the holding fingers.
    fn words(&self, grasp: &RecordedGrasp, turn: &TurnView) -> Vec<String> {
        let schedule = self.picture.subject.verified.schedule();
        let own = |plan: u32| {
            schedule.plans.get(plan as usize).is_some_and(|plan| plan.device == self.picture.subject.device)
        };
        let during = schedule.steps.iter().filter(|step| own(step.plan)).find(|step| {
            let end_ns = step.end_ns();
            step.start_ns <= self.t_ns && self.t_ns <= end_ns
        });
        let held = grasp.contacts.iter().enumerate().filter(|(_, contact)| **contact > 0);
        let held: Vec<String> = held.map(|(finger, contact)| format!("f{} on {contact}", finger + 1)).collect();
        let held = if held.is_empty() { "no finger holds".to_owned() } else { held.join(", ") };
        let angle = format!("{} deg in {}", decimal(turn.turned_rad.to_degrees(), 1), turn.plane.name());
        let step = during.map(|step| match step.end_ns() == self.t_ns {
            true => format!("end of: {}", step.text),
            false => format!("in: {}", step.text),
        });
        step.into_iter().chain([format!("{angle}; {held}")]).collect()
    }
}

fn draw_part(
    panel: &GraspPanel,
    plan: &HandPlanMotion,
    turn: &TurnView,
    moment: &HandMoment,
    view: &PaperView,
    to: &mut Drawing,
) {
    let outline: Vec<[f64; 2]> = corners(turn.section).into_iter().map(|corner| turn.of_section(corner)).collect();
    let outline = view.all(outline);
    to.shape(&outline, ShapeStyle::filled(color::in_turn(0)).with_opacity(INSIDE), &[]);
    let [x, y, z] = moment.part.position_um.map(|value| decimal(value, 6));
    let orientation = moment.part.orientation.map(|value| decimal(value, 9)).join(" ");
    let facts = [
        ("device", panel.picture.subject.device.to_owned()),
        ("part", plan.order.part.name.clone()),
        ("t-ns", panel.t_ns.to_string()),
        ("x-um", x),
        ("y-um", y),
        ("z-um", z),
        ("orientation", orientation),
    ];
    to.shape(&outline, ShapeStyle::line(color::INK, THIN_PT), &facts);
    if let Ok(curve) = Curve::of(&turn.section.outline) {
        let nose = turn.of_section(curve.point_at(0.0).point_um);
        to.line(&view.all([[0.0; 2], nose]), ShapeStyle::line(color::INK, HAIR_PT), &[]);
        to.disc(view.at(nose), 1.3, ShapeStyle::filled(color::INK), &[]);
        let arc = scenery::arc([0.0; 2], ARC * curve.reach_um(), [0.0, turn.turned_rad]);
        if turn.turned_rad != 0.0 {
            to.line(&view.all(arc), ShapeStyle::line(color::STOP, WAY_PT), &[]);
        }
    }
}

fn draw_tips(
    panel: &GraspPanel,
    plan: &HandPlanMotion,
    grasp: &RecordedGrasp,
    turn: &TurnView,
    moment: &HandMoment,
    view: &PaperView,
    to: &mut Drawing,
) {
    let radius_pt = plan.order.facts.tip_radius_um * view.scale;
    let mut tips: Vec<(usize, [f64; 2], f64)> = Vec::new();
    for (finger, tip_um) in moment.tips_um.iter().enumerate() {
        let (place, height_um) = turn.seen(*tip_um);
        tips.push((finger, place, height_um));
    }
    // Free tips are below, and lower ones first.
    let is_held = |finger: usize| grasp.contacts.get(finger).is_some_and(|contact| *contact > 0);
    tips.sort_by(|a, b| (is_held(a.0), a.2).partial_cmp(&(is_held(b.0), b.2)).unwrap_or(std::cmp::Ordering::Equal));
    for (finger, place, _) in tips {
        let at = view.at(place);
        let [x, y, z] = moment.tips_um[finger].map(|value| decimal(value, 6));
        let facts = [
            ("device", panel.picture.subject.device.to_owned()),
            ("finger", (finger + 1).to_string()),
            ("t-ns", panel.t_ns.to_string()),
            ("x-um", x),
            ("y-um", y),
            ("z-um", z),
        ];
        // Not the colour of the part.
        let tint = color::in_turn(finger + 1);
        let style = match is_held(finger) {
            true => ShapeStyle::filled(tint).with_stroke(color::INK, THIN_PT).with_opacity(TIP),
            false => ShapeStyle::line(tint, THIN_PT).dashed("2 1.5"),
        };
        to.disc(at, radius_pt, style, &facts);
        let text_style = TextStyle::SMALL.bold();
        let text = format!("f{}", finger + 1);
        if view.room.surrounds(at) {
            let may_cover = 2.0 * radius_pt > text_style.width_pt(&text);
            to.label(PlacedLabel { text, text_style, at, radius_pt, may_cover });
        }
    }
}
