//! Camera frames: conversion of pixels into scene coordinates.
//!
//! `frame top : image { scale: 0.32 um/px } at pose(…)` places the image of a camera in a scene. Input: values of a program,
//! with places and poses in pixels. Output: the same in lengths from the origin of the scene. Promise: this is done once, where a
//! place or a pose of the scene or of a task in it is accepted; no later stage handles pixels.
//!
//! In an image x counts along its rows to the right and y down its columns, as cameras and programs for images count. A heading is
//! counter-clockwise in the image: 90 deg faces up, towards smaller y. The heading of the frame is the direction of the rows in the
//! scene; `mirrored` means that the image shows the scene from behind.

use super::figures::Figures;
use super::scope::{DeclarationPlace, Scope};
use super::value::{ListValue, PoseValue, ShapeValue, Value};
use super::{Checker, errors, shapes};
use crate::device::dimibot::MAX_REACH_UM;
use crate::device::shape::ShapeForm;
use crate::geometry::shape::Pose;
use crate::quantity::{Dimension, Quantity};
use crate::source::{Span, Spanned};
use crate::syntax::tree;
use nalgebra::Point2;
use std::rc::Rc;

/// Placement of a camera image in a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Pose of the pixel at the place of the frame; its heading is that of the image's rows.
    pose: Pose,
    origin_px: [f64; 2],
    scale_um: f64,
    is_mirrored: bool,
    /// Its name where it is declared.
    pub span: Span,
}

/// The image that places in pixels refer to, as far as known.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum View {
    /// There is none.
    #[default]
    None,
    /// Its scene has errors.
    Unknown,
    /// Pixels are not converted: the value belongs to a shape that is placed by its own `at`.
    Shifted,
    Image(Camera),
}

impl Camera {
    /// The scene's coordinates of a place in the image.
    pub fn place_um(&self, [x_px, y_px]: [f64; 2]) -> [f64; 2] {
        let along_um = (x_px - self.origin_px[0]) * self.scale_um;
        let down_um = (y_px - self.origin_px[1]) * self.scale_um;
        let across_um = if self.is_mirrored { down_um } else { -down_um };
        (self.pose.isometry() * Point2::new(along_um, across_um)).coords.into()
    }

    /// A heading in the scene, from one that is counter-clockwise as the image shows it.
    pub fn heading_rad(&self, shown_rad: f64) -> f64 {
        self.pose.heading_rad + if self.is_mirrored { -shown_rad } else { shown_rad }
    }

    /// A value with its places and poses in the scene's coordinates; those in lengths stay as they are.
    fn seen(&self, value: &Value) -> Value {
        let place =
            |x: Quantity, y: Quantity| self.place_um([x.si, y.si]).map(|um| Quantity::new(um / 1e6, Dimension::LENGTH));
        match value {
            Value::Point(point) => Value::Point(place(point[0], point[1]).to_vec()),
            Value::Pose(pose) => {
                let [x, y] = place(pose.x, pose.y);
                let heading = Quantity::new(self.heading_rad(pose.heading.si), Dimension::ANGLE);
                Value::Pose(PoseValue { x, y, heading })
            }
            other => other.clone(),
        }
    }
}

/// Whether a value is a place or a pose in pixels.
fn is_in_pixels(value: &Value) -> bool {
    match value {
        Value::Point(point) => point.len() == 2 && point[0].dimension == Dimension::PIXELS,
        Value::Pose(pose) => pose.x.dimension == Dimension::PIXELS,
        _ => false,
    }
}

impl Checker<'_> {
    /// A value with its pixels converted into scene coordinates; [`Value::Unknown`] after an error.
    pub fn in_scene(&mut self, value: Value, span: Span, scope: &Scope) -> Value {
        match &value {
            Value::List(list) if list.iter().any(|element| is_in_pixels(&element.value)) => {
                let mut seen = Vec::with_capacity(list.len());
                for element in list.iter() {
                    let inside = if span.contains(element.span) { element.span } else { span };
                    let one = self.one_in_scene(element.value.clone(), inside, scope);
                    if one.is_unknown() && !element.value.is_unknown() {
                        // The others have the same fault.
                        return Value::Unknown;
                    }
                    seen.push(Spanned::new(one, element.span));
                }
                Value::List(Rc::new(ListValue::new(seen)))
            }
            _ => self.one_in_scene(value, span, scope),
        }
    }

    fn one_in_scene(&mut self, value: Value, span: Span, scope: &Scope) -> Value {
        if !is_in_pixels(&value) {
            return value;
        }
        let seen = match scope.view {
            View::Image(camera) => camera.seen(&value),
            View::Unknown => return Value::Unknown,
            View::None => return self.unknown(errors::no_image(span)),
            View::Shifted => return self.unknown(errors::pixels_in_shifted_shape(span)),
        };
        let is_finite = match &seen {
            Value::Point(point) => point.iter().all(|coordinate| coordinate.si.is_finite()),
            Value::Pose(pose) => [pose.x, pose.y, pose.heading].iter().all(|part| part.si.is_finite()),
            _ => true,
        };
        if is_finite { seen } else { self.unknown(errors::not_finite(span)) }
    }

    /// The image of a scene, out of its entries; `Err` after an error, `Ok(None)` where they put none.
    pub fn image(&mut self, entries: &[tree::SceneEntry], scope: &Scope) -> Result<Option<Camera>, ()> {
        let mut found: Option<Camera> = None;
        for entry in entries {
            let tree::SceneEntry::Object(object) = entry else { continue };
            let Some(shape) = object.shape.as_ref().filter(|_| object.noun.text == super::frames::NOUN) else {
                continue;
            };
            let camera = self.camera(object, shape, scope).ok_or(())?;
            if let Some(first) = found {
                self.sink.push(errors::two_images(camera.span, first.span));
                return Err(());
            }
            found = Some(camera);
        }
        Ok(found)
    }

    fn camera(&mut self, object: &tree::Object, shape: &tree::Expr, scope: &Scope) -> Option<Camera> {
        let image = match self.evaluate(shape, scope) {
            Value::Shape(image) if image.form == ShapeForm::Image => image,
            Value::Unknown => return None,
            _ => {
                self.sink.push(errors::frame_with_shape(shape.span));
                return None;
            }
        };
        self.object_name(&object.name, scope)?;
        let pose = match &object.at {
            None => Pose::at(0.0, 0.0),
            Some(at) => {
                let value = self.evaluate(at, scope);
                if is_in_pixels(&value) {
                    self.sink.push(errors::image_in_itself(at.span));
                    return None;
                }
                self.frame_pose(&value, at.span)?
            }
        };
        Some(Camera { pose, span: object.name.span, ..read(&image)? })
    }

    /// The pose of an object in scene coordinates; `None` after an error.
    pub fn frame_pose(&mut self, value: &Value, span: Span) -> Option<Pose> {
        if value.is_unknown() {
            return None;
        }
        let Some(pose) = shapes::pose_of(value) else {
            self.sink.push(errors::wrong_place(span, value, "a place or a pose for a frame"));
            return None;
        };
        if pose.x_um.abs().max(pose.y_um.abs()) > MAX_REACH_UM {
            self.sink.push(errors::frame_too_far(span, "100 mm"));
            return None;
        }
        if pose.heading_rad.abs() > shapes::MAX_HEADING_RAD {
            self.sink.push(errors::frame_turned_too_far(span, shapes::MAX_HEADING_RAD.to_degrees()));
            return None;
        }
        Some(pose)
    }

    /// The view that a task has of its scene.
    pub fn view_of(&mut self, scene: Option<Option<DeclarationPlace>>) -> View {
        match scene {
            None => View::None,
            Some(None) => View::Unknown,
            Some(Some(place)) => self.scene(place).map_or(View::Unknown, |scene| scene.view()),
        }
    }
}

/// An image by its fields, put at the origin; `None` where its scale is not known.
fn read(image: &ShapeValue) -> Option<Camera> {
    let origin_px = match image.fields.get("origin").map(|field| &field.value) {
        Some(Value::Point(point)) => [point[0].si, point[1].si],
        _ => [0.0, 0.0],
    };
    Some(Camera {
        pose: Pose::at(0.0, 0.0),
        origin_px,
        scale_um: image.fields.quantity("scale")?.in_unit("um/px"),
        is_mirrored: image.fields.is_set("mirrored"),
        span: Span::default(),
    })
}
