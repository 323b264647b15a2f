//! Conversion of the language's shapes to outlines in the planes of a part and to its known mass properties.

use super::errors;
use crate::check::value::{ShapeValue, Value};
use crate::device::shape::{Plane, ShapeForm};
use crate::diagnostic::{Diagnosed, Diagnostic};
use crate::geometry::mesh::Mesh;
use crate::geometry::outline::{Curve, EXPONENTS, MAX_POINTS, MIN_POINTS, MIN_UM, Outline, OutlineError};
use crate::quantity::digits;
use crate::real::Real;
use crate::source::Span;
use std::f64::consts::PI;
use std::rc::Rc;

/// Solid of a part as a hand uses it.
#[derive(Debug, Clone)]
pub struct HandSolid {
    pub xy: Outline,
    /// `None` for a flat part.
    pub xz: Option<Outline>,
    /// Its volume, where it is known, in cubic micrometres.
    pub volume_um3: Option<f64>,
    /// Its centre of mass; `None` where its outlines do not determine it.
    pub centre_um: Option<[f64; 3]>,
    /// Its greatest distance from its origin, as far as known.
    pub reach_um: f64,
    pub density_kg_per_m3: Option<f64>,
    /// Its surface, where the sections alone do not decide whether tips collide with it.
    pub surface: Option<Rc<Mesh>>,
}

/// Greatest relative deviation of a section from the rectangle that it is treated as.
const SAME_SHARE: f64 = 1e-6;

/// Greatest distance of a centre of mass from the origin that counts as rounding, as a share of the outline's reach.
const ROUNDING_SHARE: f64 = 1e-9;

/// Greatest distance of an outline's centre from the origin at which it counts as centred, as a share of its reach: the
/// corners of an outline are often rounded to three digits.
const CENTRED_SHARE: f64 = 1e-3;

/// Corner radius of a mesh's rectangular section, as a share of half its lesser width: a tip there penetrates the true
/// corner by 0.2 % of that half.
const CORNER_SHARE: f64 = 0.005;

/// The solid of a shape that hands can handle; `span` is the whole shape.
///
/// # Errors
/// Why it is impossible.
pub fn of(shape: &ShapeValue, span: Span) -> Diagnosed<HandSolid> {
    let density = shape.fields.get("material").and_then(|field| match &field.value {
        Value::Quantity(density) => Some(density.si),
        _ => None,
    });
    let solid = match shape.form {
        ShapeForm::Ellipsoid => ellipsoid(shape),
        ShapeForm::Superellipsoid => superellipsoid(shape)?,
        ShapeForm::RoundedBox => rounded_box(shape)?,
        ShapeForm::Profile => flat(profile(shape, Plane::Xy, span)?),
        ShapeForm::Sections => sections(shape, span)?,
        ShapeForm::Mesh => mesh(shape, span)?,
        ShapeForm::Disc
        | ShapeForm::Box
        | ShapeForm::Polygon
        | ShapeForm::Capsule
        | ShapeForm::Cells
        | ShapeForm::Layout
        | ShapeForm::Image => {
            let known = [ShapeForm::Ellipsoid, ShapeForm::Profile].map(ShapeForm::name);
            return Err(Box::new(errors::shape_of_other_kind(span, shape.form.name(), "part", "fingers", &known)));
        }
    };
    let field = |name: &str| shape.fields.get(name).map_or(span, |field| field.span);
    let size = match shape.form {
        ShapeForm::RoundedBox => field("size"),
        ShapeForm::Profile if shape.fields.contains_key("points") => field("points"),
        ShapeForm::Profile => field("x"),
        ShapeForm::Mesh => field("file"),
        ShapeForm::Ellipsoid
        | ShapeForm::Superellipsoid
        | ShapeForm::Sections
        | ShapeForm::Disc
        | ShapeForm::Box
        | ShapeForm::Polygon
        | ShapeForm::Capsule
        | ShapeForm::Cells
        | ShapeForm::Layout
        | ShapeForm::Image => field("axes"),
    };
    let curve = |outline: &Outline| Curve::of(outline).map_err(|fault| Box::new(outline_fault(&fault, outline, size)));
    let (xy, xz) = (curve(&solid.xy)?, solid.xz.as_ref().map(curve).transpose()?);
    let centre_um = match (solid.centre_um, xz) {
        (Some(centre_um), _) => Some(centre_um),
        (None, None) => Some(of_flat_um(&xy)),
        (None, Some(xz)) => of_sections_um(shape, [&xy, &xz])?,
    };
    Ok(HandSolid { density_kg_per_m3: density, centre_um, ..solid })
}

/// The centre of mass of a flat part of uniform thickness: the centroid of its outline.
fn of_flat_um(outline: &Curve) -> [f64; 3] {
    let [x, y] = outline.centre_um();
    // For a symmetrical outline it is the origin but for rounding.
    if is_centred(outline, ROUNDING_SHARE) { [0.0; 3] } else { [x, y, 0.0] }
}

/// Whether the centre of an outline is at the origin, to a share of its reach.
fn is_centred(outline: &Curve, share: f64) -> bool {
    let [x, y] = outline.centre_um();
    x.hypotenuse(y) <= share * outline.reach_um()
}

/// The centre of mass of a solid of two sections: as stated, or the origin if both sections are centred there, else
/// `None`.
///
/// # Errors
/// The stated one is outside of the part.
fn of_sections_um(shape: &ShapeValue, outlines: [&Curve; 2]) -> Diagnosed<Option<[f64; 3]>> {
    let Some(stated) = shape.fields.get("centre_of_mass") else {
        let is_origin = outlines.iter().all(|outline| is_centred(outline, CENTRED_SHARE));
        return Ok(is_origin.then_some([0.0; 3]));
    };
    let [x, y, z] = vector_um(shape, "centre_of_mass");
    let reach_um = outlines.map(Curve::reach_um).into_iter().fold(0.0, f64::max);
    if x.hypotenuse(y).hypotenuse(z) > reach_um {
        let what =
            format!("the centre of mass is farther from the origin than the part reaches, {} um", digits(reach_um));
        let help = "give it in the axes of the outlines, or check its unit";
        return Err(Box::new(errors::bad_shape(stated.span, &what, "outside the part", help)));
    }
    Ok(Some([x, y, z]))
}

fn flat(xy: Outline) -> HandSolid {
    HandSolid { xy, xz: None, volume_um3: None, centre_um: None, reach_um: 0.0, density_kg_per_m3: None, surface: None }
}

fn vector_um(shape: &ShapeValue, field: &str) -> [f64; 3] {
    match shape.fields.get(field).map(|field| &field.value) {
        Some(Value::Point(point)) if point.len() == 3 => [0, 1, 2].map(|axis: usize| point[axis].in_unit("um")),
        _ => [0.0; 3],
    }
}

fn ellipsoid(shape: &ShapeValue) -> HandSolid {
    let [a, b, c] = vector_um(shape, "axes");
    HandSolid {
        xy: Outline::Ellipse { semi_um: [a, b] },
        xz: Some(Outline::Ellipse { semi_um: [a, c] }),
        volume_um3: Some(4.0 / 3.0 * PI * a * b * c),
        centre_um: Some([0.0; 3]),
        reach_um: a.max(b).max(c),
        density_kg_per_m3: None,
        surface: None,
    }
}

fn superellipsoid(shape: &ShapeValue) -> Diagnosed<HandSolid> {
    let [a, b, c] = vector_um(shape, "axes");
    let given = shape.fields.get("exponent");
    let exponent = match given.map(|field| &field.value) {
        Some(Value::Quantity(number)) => number.si,
        _ => EXPONENTS[0],
    };
    if let Some(field) = given
        && !(EXPONENTS[0]..=EXPONENTS[1]).contains(&exponent)
    {
        let what = format!(
            "the exponent of a superellipsoid is {}, but must be from {} to {}",
            digits(exponent),
            EXPONENTS[0],
            EXPONENTS[1]
        );
        let help = "2 makes an ellipsoid; use a `rounded_box` for flatter flanks";
        return Err(Box::new(errors::bad_shape(field.span, &what, "out of its range", help)));
    }
    Ok(HandSolid {
        xy: Outline::Superellipse { semi_um: [a, b], exponent },
        xz: Some(Outline::Superellipse { semi_um: [a, c], exponent }),
        volume_um3: Some(8.0 * a * b * c * super_share(exponent)),
        centre_um: Some([0.0; 3]),
        reach_um: super_reach([a, b, c], exponent),
        density_kg_per_m3: None,
        surface: None,
    })
}

/// The share of its box that |x|^n + |y|^n + |z|^n = 1 fills: Γ(1 + 1/n)³ / Γ(1 + 3/n), which is Dirichlet's integral.
fn super_share(n: f64) -> f64 {
    (3.0 * log_gamma(1.0 + 1.0 / n) - log_gamma(1.0 + 3.0 / n)).exponential()
}

/// The logarithm of Γ for arguments from 1, by Stirling's series from 10 upwards.
fn log_gamma(x: f64) -> f64 {
    let (mut x, mut below) = (x, 0.0);
    while x < 10.0 {
        below += x.natural_logarithm();
        x += 1.0;
    }
    let series = 1.0 / (12.0 * x) - 1.0 / (360.0 * x.whole_power(3)) + 1.0 / (1260.0 * x.whole_power(5))
        - 1.0 / (1680.0 * x.whole_power(7));
    (x - 0.5) * x.natural_logarithm() - x + 0.5 * (2.0 * PI).natural_logarithm() + series - below
}

/// Greatest distance of a superellipsoid from its origin, by Lagrange's condition.
pub(super) fn super_reach(axes: [f64; 3], n: f64) -> f64 {
    let greatest = axes.into_iter().fold(0.0, f64::max);
    if n - 2.0 < 1e-3 {
        return greatest;
    }
    let power = 2.0 * n / (n - 2.0);
    greatest * axes.iter().map(|axis| (axis / greatest).power(power)).sum::<f64>().power(1.0 / power)
}

fn rounded_box(shape: &ShapeValue) -> Diagnosed<HandSolid> {
    let half = vector_um(shape, "size").map(|side| side / 2.0);
    let least = half.into_iter().fold(f64::INFINITY, f64::min);
    let given = shape.fields.get("radius");
    let radius = match given.map(|field| &field.value) {
        Some(Value::Quantity(length)) => length.in_unit("um"),
        _ => 0.0,
    };
    if let Some(field) = given
        && (radius > least * (1.0 + 1e-12) || radius < MIN_UM)
    {
        let text = |um: f64| format!("{} um", digits(um));
        let what =
            format!("edges are rounded by {}, but this must be from {} to {}", text(radius), text(MIN_UM), text(least));
        let help = "the greatest is half the least width";
        return Err(Box::new(errors::bad_shape(field.span, &what, "out of its range", help)));
    }
    let radius = radius.min(least);
    let inner = half.map(|half| half - radius);
    let [a, b, c] = inner.map(|inner| 2.0 * inner);
    let outline = |other: usize| Outline::RoundedRectangle {
        half_um: [half[0], half[other]],
        radius_um: radius,
        centre_um: [0.0; 2],
    };
    Ok(HandSolid {
        xy: outline(1),
        xz: Some(outline(2)),
        // Steiner's formula for a box and a ball.
        volume_um3: Some(
            a * b * c
                + 2.0 * radius * (a * b + b * c + c * a)
                + PI * radius.whole_power(2) * (a + b + c)
                + 4.0 / 3.0 * PI * radius.whole_power(3),
        ),
        centre_um: Some([0.0; 3]),
        reach_um: inner.iter().map(|inner| inner * inner).sum::<f64>().sqrt() + radius,
        density_kg_per_m3: None,
        surface: None,
    })
}

/// A mesh with its two sections, smoothed.
fn mesh(shape: &ShapeValue, span: Span) -> Diagnosed<HandSolid> {
    let field = |name: &str| shape.fields.get(name).map_or(span, |field| field.span);
    let unit_um = match shape.fields.get("unit").map(|field| &field.value) {
        Some(Value::Quantity(length)) => length.in_unit("um"),
        _ => 0.0,
    };
    let Some(Value::Mesh(file)) = shape.fields.get("file").map(|field| &field.value) else {
        return Err(Box::new(errors::mesh_file_not_plain(field("file"))));
    };
    let wrong = |why: &str| Box::new(errors::bad_mesh(field("file"), &file.path, why));
    let surface = file.mesh.placed([0.0; 3], unit_um).map_err(|fault| wrong(&fault.to_string()))?;
    let outline = |plane: Plane| {
        let at = |why: String| wrong(&format!("has no outline in its plane {}: {why}", plane.name()));
        let polygon = surface.section(plane.axes()).map_err(|fault| at(format!("it {fault}")))?;
        let outline = match rectangle(&polygon) {
            Some(outline) => outline,
            None => Outline::from_polygon(&polygon).map_err(|fault| outline_error(&fault, &at))?,
        };
        Curve::of(&outline).map_err(|fault| outline_error(&fault, &at))?;
        Ok::<Outline, Box<Diagnostic>>(outline)
    };
    let reach_um = surface.corners().flatten().map(|[x, y, z]| x.hypotenuse(y).hypotenuse(z)).fold(0.0, f64::max);
    Ok(HandSolid {
        xy: outline(Plane::Xy)?,
        xz: Some(outline(Plane::Xz)?),
        volume_um3: Some(surface.volume_um3()),
        centre_um: Some(surface.centre_um()),
        reach_um,
        density_kg_per_m3: None,
        surface: Some(Rc::new(surface)),
    })
}

/// The outline of a section that is an axis-aligned rectangle around the origin: smoothing would make its sides wavy.
/// `None` for other sections, and where the x axis leaves it near a corner.
fn rectangle(polygon: &[[f64; 2]]) -> Option<Outline> {
    let ends = [0, 1].map(|axis: usize| {
        let places = || polygon.iter().map(|point| point[axis]);
        [places().fold(f64::INFINITY, f64::min), places().fold(f64::NEG_INFINITY, f64::max)]
    });
    let half_um = ends.map(|[low, high]| (high - low) / 2.0);
    let least_um = half_um[0].min(half_um[1]);
    let (slack_um, radius_um) = (SAME_SHARE * least_um, (CORNER_SHARE * least_um).max(MIN_UM));
    // Numbers in a file are rounded: a section whose centre is off by no more than that is centred.
    let centre_um = ends.map(|[low, high]| (low + high) / 2.0).map(|at| if at.abs() <= slack_um { 0.0 } else { at });
    let off_um = |point: &[f64; 2], axis: usize| ((point[axis] - centre_um[axis]).abs() - half_um[axis]).abs();
    if !polygon.iter().all(|point| off_um(point, 0) <= slack_um || off_um(point, 1) <= slack_um) {
        return None;
    }
    let has_corner = |signs: [f64; 2]| {
        let place = |axis: usize| centre_um[axis] + signs[axis] * half_um[axis];
        let is_there = |point: &[f64; 2]| (0..2).all(|axis| (point[axis] - place(axis)).abs() <= slack_um);
        polygon.iter().any(is_there)
    };
    let next = polygon.iter().cycle().skip(1);
    let twice_um2: f64 = polygon.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum();
    let is_whole = (twice_um2.abs() - 8.0 * half_um[0] * half_um[1]).abs() <= SAME_SHARE * half_um[0] * half_um[1];
    let corners = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
    let is_round_origin = centre_um[0].abs() < half_um[0] && centre_um[1].abs() < half_um[1] - radius_um;
    (is_whole && is_round_origin && corners.into_iter().all(has_corner)).then_some(Outline::RoundedRectangle {
        half_um,
        radius_um,
        centre_um,
    })
}

/// Diagnostic for a section whose outline cannot be sampled.
fn outline_error(fault: &OutlineError, at: &dyn Fn(String) -> Box<Diagnostic>) -> Box<Diagnostic> {
    let point = |[x, y]: [f64; 2]| format!("({} um, {} um)", digits(x), digits(y));
    at(match fault {
        OutlineError::Number => "it is too large or too small; check `unit`".to_owned(),
        OutlineError::TooFewPoints(_) | OutlineError::NoArea | OutlineError::RepeatedPoint(_) => {
            "too few triangles meet it".to_owned()
        }
        OutlineError::Thin => "it is thinner than 1 nm".to_owned(),
        OutlineError::TooManyPoints(count) => format!("{count} triangles meet it, which is too many"),
        OutlineError::Crossing { .. } => "it crosses itself".to_owned(),
        OutlineError::Rough { point_um } => format!("it has a corner near {}", point(*point_um)),
        OutlineError::OffOrigin => "the origin of the file does not lie inside it".to_owned(),
    })
}

/// A solid of two profiles; the one in the plane xz is written by x and z.
fn sections(shape: &ShapeValue, span: Span) -> Diagnosed<HandSolid> {
    let plane = |name: &str, plane: Plane| match shape.fields.get(name) {
        Some(field) => match &field.value {
            Value::Shape(shape) => {
                let outline = profile(shape, plane, field.span)?;
                Curve::of(&outline).map_err(|fault| Box::new(outline_fault(&fault, &outline, field.span)))?;
                Ok(outline)
            }
            _ => Err(Box::new(errors::mesh_file_not_plain(field.span))),
        },
        None => Err(Box::new(errors::mesh_file_not_plain(span))),
    };
    let (xy, xz) = (plane("xy", Plane::Xy)?, plane("xz", Plane::Xz)?);
    Ok(HandSolid { xz: Some(xz), ..flat(xy) })
}

/// The outline of a profile, counter-clockwise in the coordinates of a plane.
fn profile(shape: &ShapeValue, plane: Plane, span: Span) -> Diagnosed<Outline> {
    let points_um = match (shape.fields.get("points"), shape.fields.get("x"), shape.fields.get("y")) {
        (Some(points), None, None) => match &points.value {
            Value::List(list) if list.len() > MAX_POINTS => return Err(Box::new(too_many(list.len(), points.span))),
            Value::List(list) => list.iter().filter_map(|point| place_um(&point.value)).collect(),
            _ => Vec::new(),
        },
        (None, Some(x), Some(y)) => match (&x.value, &y.value) {
            (Value::Curve(x), Value::Curve(y)) => x.iter().zip(y.iter()).map(|(x, y)| [*x, *y]).collect(),
            _ => Vec::new(),
        },
        (Some(points), _, _) => {
            let help = "remove one of them";
            let what = "a profile has both points and a curve";
            return Err(Box::new(errors::bad_shape(points.span, what, "`x` or `y` is given as well", help)));
        }
        (None, _, _) => {
            let help = "write `profile { points: [(9 um, 0 um), (0 um, 5 um), …] }`, or `profile { x: 9 um * cos(t), y: 5 um * sin(t) }`";
            return Err(Box::new(errors::bad_shape(
                span,
                "a profile lacks its outline",
                "no `points`, and not both `x` and `y`",
                help,
            )));
        }
    };
    let mut points_um: Vec<[f64; 2]> = match plane {
        Plane::Xy => points_um,
        Plane::Xz => points_um.into_iter().map(|[x, z]: [f64; 2]| [x, -z]).collect(),
    };
    if turns_clockwise(&points_um) {
        points_um.reverse();
    }
    Ok(Outline::Spline { points_um })
}

fn place_um(value: &Value) -> Option<[f64; 2]> {
    match value {
        Value::Point(point) if point.len() == 2 => Some([point[0].in_unit("um"), point[1].in_unit("um")]),
        _ => None,
    }
}

fn turns_clockwise(points: &[[f64; 2]]) -> bool {
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>() < 0.0
}

fn too_many(count: usize, span: Span) -> Diagnostic {
    let what = format!("an outline has {count} points; at most {MAX_POINTS} are allowed");
    errors::bad_shape(span, &what, "too many points", "use every tenth: a smooth curve is drawn through them")
}

/// Diagnostic for an outline that cannot be sampled.
fn outline_fault(fault: &OutlineError, outline: &Outline, span: Span) -> Diagnostic {
    let point = |[x, y]: [f64; 2]| format!("({} um, {} um)", digits(x), digits(y));
    let place = |index: usize| match outline {
        Outline::Spline { points_um } => {
            points_um.get(index).map_or(String::new(), |at| format!(" near {}", point(*at)))
        }
        Outline::Ellipse { .. } | Outline::Superellipse { .. } | Outline::RoundedRectangle { .. } => String::new(),
    };
    let in_order = "give the points in order round the outline";
    match fault {
        OutlineError::Number => errors::bad_shape(
            span,
            "an outline is too large or too small to follow",
            "1 nm to 1 m are allowed",
            "check its units",
        ),
        OutlineError::TooFewPoints(count) => {
            let what = format!("an outline has {count} points; at least {MIN_POINTS} are needed");
            errors::bad_shape(span, &what, "too few points", "add points: a smooth curve is drawn through them")
        }
        OutlineError::TooManyPoints(count) => too_many(*count, span),
        OutlineError::RepeatedPoint(index) => {
            let what = format!("an outline has the same point twice{}", place(*index));
            errors::bad_shape(span, &what, "two neighbouring points coincide", "remove one of the two")
        }
        OutlineError::NoArea => errors::bad_shape(
            span,
            "an outline encloses no area",
            "its points lie on one line, or it crosses itself",
            "give the points in order round it",
        ),
        OutlineError::Thin => errors::bad_shape(
            span,
            "an outline is thinner than 1 nm",
            "too thin to follow",
            "check the units of its figures",
        ),
        OutlineError::Crossing { ways_um } => {
            let ways = ways_um.map(|way| format!("{} um", digits(way))).join(" and ");
            let what = format!("an outline crosses itself, {ways} along it");
            errors::bad_shape(span, &what, "not a simple outline", in_order)
        }
        OutlineError::Rough { point_um } => {
            let what = format!("an outline has a corner near {}", point(*point_um));
            errors::bad_shape(
                span,
                &what,
                "tips roll on smooth outlines",
                "round it, so that the outline turns less at each point",
            )
        }
        OutlineError::OffOrigin => {
            let why = "the x axis must meet it on both sides of the origin";
            errors::bad_shape(
                span,
                "an outline does not lie around its origin",
                why,
                "move its points until the origin is inside",
            )
        }
    }
}
