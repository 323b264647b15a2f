//! A part as judged for one hand: its contacts in both planes, and whether tips reach them.

use super::errors;
use crate::check::devices::CheckedDevice;
use crate::check::scenes::SceneObject;
use crate::check::solid::{self, HandSolid};
use crate::check::value::Value;
use crate::claims::fingers::{HandPart, Section};
use crate::device::fingers::sampling::{JUNCTION_SHARE, contacts, once_round_rad};
use crate::device::fingers::{FingersFacts, HandNoun, MAX_CONTACTS, Plane, VOCABULARY};
use crate::diagnostic::{Diagnosed, Diagnostic, Sink};
use crate::geometry::distance::point_segment;
use crate::geometry::outline::{Curve, Outline};
use crate::quantity::{Dimension, Quantity};
use crate::real::Real;
use crate::source::Span;
use nalgebra::{Point2, Vector3};
use std::f64::consts::PI;
use std::sync::Arc;

/// Number of samples that find the most concave place of an outline.
const LOOKS: usize = 4096;

/// Greatest number of tip positions around a section that are tested against the surface of its solid.
const MAX_TIPS: u32 = 20_000;

/// In-plane share of a force above which it is more than rounding.
const LEAST_SHARE: f64 = 1e-9;

/// Standard gravity by definition: 3rd General Conference on Weights and Measures, 1901.
const STANDARD_GRAVITY_M_PER_S2: f64 = 9.806_65;

/// A part with the further data that a task needs.
#[derive(Debug, Clone)]
pub struct JudgedPart {
    pub part: Arc<HandPart>,
    /// Where its shape is written, if its centre of mass is unknown.
    pub uncentred: Option<Span>,
    /// Its weight, in micronewtons; 0 without a material.
    pub weight_un: f64,
    /// Why tips cannot travel around its section in the plane xz, which the part then lacks; irrelevant to tasks that
    /// turn it about z alone.
    pub xz_fault: Option<Diagnostic>,
}

/// Reads a part of a scene for a device.
pub struct PartReader<'a> {
    pub object: &'a SceneObject,
    pub device: &'a CheckedDevice,
    pub facts: &'a FingersFacts,
    pub sink: &'a mut Sink,
}

impl PartReader<'_> {
    /// The part; `None` after an error.
    pub fn part(&mut self) -> Option<JudgedPart> {
        let object = self.object;
        let Some(shape) = &object.shape else {
            self.sink.push(errors::part_without_shape(object.span, &object.name));
            return None;
        };
        let forms = VOCABULARY.noun(HandNoun::Part.name()).map_or(&[][..], |noun| noun.shapes);
        if !forms.contains(&shape.value.form) {
            let known: Vec<&str> = forms.iter().map(|form| form.name()).collect();
            let form = shape.value.form.name();
            self.sink.push(errors::shape_of_other_kind(shape.span, form, &object.noun, VOCABULARY.name, &known));
            return None;
        }
        let position_um = self.position_um()?;
        // An impossible shape was already reported where it was read.
        let solid = solid::of(&shape.value, shape.span).ok()?;
        let xy = self.travelled(&solid, &solid.xy, Plane::Xy, shape.span)?;
        let xy = xy.map_err(|fault| self.sink.push(*fault)).ok()?;
        let (xz, xz_fault) = match &solid.xz {
            Some(outline) => match self.travelled(&solid, outline, Plane::Xz, shape.span)? {
                Ok(section) => (Some(section), None),
                Err(fault) => (None, Some(*fault)),
            },
            None => (None, None),
        };
        if let Err(reaches_out) = self.within_its_sections(&solid, &xy, xz.as_ref(), shape.span) {
            self.sink.push(xz_fault.unwrap_or(*reaches_out));
            return None;
        }
        let centre_um = solid.centre_um.unwrap_or_default();
        let part = HandPart { name: object.name.clone(), xy, xz, centre_um, position_um, span: object.span };
        if let Some(wrong) = out_of_range(&part, position_um, self.facts) {
            let at = object.at.as_ref().map_or(object.span, |at| at.span);
            let diagnostic = errors::part_out_of_range(at, &part.name, &wrong);
            self.sink.push(diagnostic.label(self.device.span, "of this device"));
            return None;
        }
        let weight_un = weight_un(&solid);
        if weight_un > MAX_LOAD_UN {
            self.sink.push(errors::part_too_heavy(shape.span, &part.name, weight_un, MAX_LOAD_UN));
            return None;
        }
        let uncentred = solid.centre_um.is_none().then_some(shape.span);
        Some(JudgedPart { part: Arc::new(part), uncentred, weight_un, xz_fault })
    }

    fn position_um(&mut self) -> Option<[f64; 3]> {
        let Some(at) = &self.object.at else { return Some([0.0; 3]) };
        let um = |length: Option<&Quantity>| length.map_or(0.0, |length| length.in_unit("um"));
        match &at.value {
            Value::Point(point) if point[0].dimension == Dimension::LENGTH => {
                Some([um(point.first()), um(point.get(1)), um(point.get(2))])
            }
            other => {
                self.sink.push(errors::part_place(at.span, other));
                None
            }
        }
    }

    /// A section that tips reach and travel around clear of the solid; `None` for an impossible outline, which was
    /// already reported.
    fn travelled(&self, solid: &HandSolid, outline: &Outline, plane: Plane, span: Span) -> Option<Diagnosed<Section>> {
        let section = match self.section(outline, plane, span)? {
            Ok(section) => section,
            Err(fault) => return Some(Err(fault)),
        };
        Some(self.clear_of_surface(solid, &section, plane, span).map(|()| section))
    }

    /// An outline with its contacts; an error if tips do not fit into a hollow of it, or if there are too many
    /// contacts.
    fn section(&self, outline: &Outline, plane: Plane, span: Span) -> Option<Diagnosed<Section>> {
        let curve = Curve::of(outline).ok()?;
        let tip_um = self.facts.tip_radius_um;
        let least = curve.least_curvature_per_um();
        if least * tip_um <= -1.0 + 1e-9 {
            let at = errors::Tipped { part: &self.object.name, plane, point_um: hollow(&curve), tip_radius_um: tip_um };
            return Some(Err(Box::new(errors::tip_too_large(span, &at, -1.0 / least, self.device.span))));
        }
        let (contacts, opposite) = contacts(&curve, self.facts);
        if contacts > f64::from(MAX_CONTACTS) {
            let wrong = errors::too_many_contacts(span, &self.object.name, plane, contacts, MAX_CONTACTS);
            return Some(Err(Box::new(wrong.label(self.device.span, "of this device"))));
        }
        let step_rad = once_round_rad(&curve, tip_um) / contacts;
        Some(Ok(Section { outline: outline.clone(), contacts: contacts as u32, opposite, step_rad }))
    }

    /// Checks that tips stand clear of the rest of the surface while they touch a section, at its contacts and between
    /// them, where they roll.
    fn clear_of_surface(&self, solid: &HandSolid, section: &Section, plane: Plane, span: Span) -> Diagnosed {
        let (Some(surface), Ok(curve)) = (&solid.surface, Curve::of(&section.outline)) else { return Ok(()) };
        let (tip_um, tolerance_um) = (self.facts.tip_radius_um, self.facts.tolerance_um);
        // The centre of a tip moves by the tip radius times the rolled angle, so that sampled places are at most one
        // tolerance apart, unless their number is capped.
        let apart_um = tip_um * section.step_rad;
        let between = (apart_um / tolerance_um).ceil().clamp(1.0, f64::from(MAX_TIPS / section.contacts)) as u32;
        let depth_um = |place: u32| {
            let rolled_rad = f64::from(place) / f64::from(between) * section.step_rad;
            let (centre, _) = tip_um_rolled(&curve, rolled_rad, tip_um);
            (tip_um - surface.distance_um(in_space(plane, centre)), centre)
        };
        let depths = (0..section.contacts * between).map(|place| (depth_um(place), place));
        let deepest = depths.max_by(|one, other| one.0.0.total_cmp(&other.0.0));
        let Some(((depth_um, centre), place)) = deepest.filter(|deepest| deepest.0.0 > tolerance_um) else {
            return Ok(());
        };
        let polygon = surface.section(plane.axes()).unwrap_or_default();
        let sides = polygon.iter().zip(polygon.iter().cycle().skip(1)).map(|(from, to)| [*from, *to].map(Point2::from));
        let outline_um = sides.map(|side| point_segment(centre.into(), side)).fold(f64::INFINITY, f64::min);
        let buried = errors::BuriedTip {
            plane,
            contact: place / between + 1,
            beyond: (!place.is_multiple_of(between)).then_some((place / between + 1) % section.contacts + 1),
            depth_um,
            tolerance_um,
            is_smoothed: tip_um - outline_um > tolerance_um,
        };
        Err(Box::new(errors::tip_in_solid(span, &self.object.name, &buried)))
    }

    /// Checks that nothing of the solid obstructs tips that travel around its sections.
    fn within_its_sections(&self, solid: &HandSolid, xy: &Section, xz: Option<&Section>, span: Span) -> Diagnosed {
        let sections = std::iter::once(xy).chain(xz);
        let reach_um = sections.filter_map(|section| Curve::of(&section.outline).ok()).map(|curve| curve.reach_um());
        let facts = self.facts;
        let sphere_um = facts.sphere_um(0, reach_um.fold(0.0, f64::max));
        let most_um = sphere_um - facts.tip_radius_um - facts.clearance_um - facts.tolerance_um;
        if solid.reach_um <= most_um {
            return Ok(());
        }
        Err(Box::new(errors::solid_reaches_out(span, &self.object.name, solid.reach_um, most_um)))
    }
}

/// The most concave point of an outline.
fn hollow(curve: &Curve) -> [f64; 2] {
    let ways = (0..LOOKS).map(|look| curve.perimeter_um() * look as f64 / LOOKS as f64);
    let spots = ways.map(|way| curve.point_at(way));
    spots
        .min_by(|one, other| one.curvature_per_um.total_cmp(&other.curvature_per_um))
        .map_or([0.0; 2], |spot| spot.point_um)
}

/// Centre of a tip that touches a contact, in the plane's coordinates, and the direction of the outward normal there,
/// in radians.
pub fn tip_um_at(section: &Section, curve: &Curve, contact: u32, tip_radius_um: f64) -> ([f64; 2], f64) {
    tip_um_rolled(curve, f64::from(contact - 1) * section.step_rad, tip_radius_um)
}

/// As `tip_um_at`, for a tip that has rolled on from contact 1 by a given angle of the part's turn.
fn tip_um_rolled(curve: &Curve, rolled_rad: f64, tip_radius_um: f64) -> ([f64; 2], f64) {
    let spot = curve.point_at(curve.way_rolled_um(rolled_rad, tip_radius_um));
    let (sine, cosine) = spot.normal_rad.sine_cosine();
    let [x, y] = spot.point_um;
    ([x + tip_radius_um * cosine, y + tip_radius_um * sine], spot.normal_rad)
}

/// A place of a plane in the part's frame.
fn in_space(plane: Plane, [a, b]: [f64; 2]) -> [f64; 3] {
    let axes = plane.axes();
    std::array::from_fn(|axis| a * axes[0][axis] + b * axes[1][axis])
}

/// Whether the in-plane component of a force is more than rounding.
pub fn is_in_plane(force_un: Vector3<f64>, plane: Plane) -> bool {
    Vector3::from(plane.normal()).cross(&force_un).norm() > LEAST_SHARE * force_un.norm()
}

/// Why two fingers that hold I and J, where the x axis leaves the part, in one plane do not hold them in the other;
/// `None` if they do.
pub fn junction_fault(part: &HandPart, facts: &FingersFacts) -> Option<String> {
    let xz = part.xz.as_ref()?;
    let mut tips = Vec::new();
    for (section, plane) in [(&part.xy, Plane::Xy), (xz, Plane::Xz)] {
        let Some(opposite) = section.opposite else {
            return Some(format!(
                "in the plane {} none of its {} contacts lies where the negative x axis leaves it",
                plane.name(),
                section.contacts
            ));
        };
        let curve = Curve::of(&section.outline).ok()?;
        for contact in [1, opposite] {
            let (centre, normal_rad) = tip_um_at(section, &curve, contact, facts.tip_radius_um);
            let point = in_space(plane, centre);
            let across_rad = if contact == 1 { normal_rad } else { normal_rad - PI };
            tips.push((point, across_rad));
        }
    }
    let most_um = JUNCTION_SHARE * facts.tolerance_um;
    [("positive", 0), ("negative", 1)].into_iter().find_map(|(side, index)| {
        let (one, other) = (tips[index].0, tips[index + 2].0);
        let apart_um = one.iter().zip(other).map(|(a, b)| (a - b).whole_power(2)).sum::<f64>().sqrt();
        let leaning = [tips[index].1, tips[index + 2].1].map(|rad| (rad.sine()).abs().arc_sine().to_degrees());
        (apart_um > most_um).then(|| {
            format!(
                "where the {side} x axis leaves it, its outlines put a tip {} apart; at most {} is allowed (they lean by {:.2} deg and {:.2} deg)",
                errors::length(apart_um),
                errors::length(most_um),
                leaning[0],
                leaning[1]
            )
        })
    })
}

/// The first stage axis that does not reach around a part.
pub fn out_of_range(part: &HandPart, position_um: [f64; 3], facts: &FingersFacts) -> Option<errors::ShortStage> {
    let sections = std::iter::once(&part.xy).chain(&part.xz);
    let reach_um = sections.filter_map(|section| Curve::of(&section.outline).ok()).map(|curve| curve.reach_um());
    // The outermost free tip may be anywhere on its sphere.
    let last = facts.fingers.saturating_sub(1) as usize;
    let sphere_um = facts.sphere_um(last, reach_um.fold(0.0, f64::max));
    let (needed_um, range_um) = (position_um.map(|along_um| along_um.abs() + sphere_um), facts.range_um);
    let axis = (0..3).find(|axis| needed_um[*axis] > range_um[*axis] * (1.0 + 1e-12))?;
    Some(errors::ShortStage { axis, needed_um, range_um })
}

/// The largest force on a part, in micronewtons: far more than tips of micrometres bear.
pub const MAX_LOAD_UN: f64 = 1e6;

/// The weight of a solid of known volume and density, in micronewtons.
fn weight_un(solid: &HandSolid) -> f64 {
    match (solid.volume_um3, solid.density_kg_per_m3) {
        (Some(volume_um3), Some(density)) => density * volume_um3 * 1e-18 * STANDARD_GRAVITY_M_PER_S2 * 1e6,
        _ => 0.0,
    }
}
