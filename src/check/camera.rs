//! Camera frames: conversion of pixels into scene coordinates.
//!
//! `frame top : image { scale: 0.32 um/px } at pose(…)` places the image of a camera in a scene. Input: values of a
//! program, with places and poses in pixels. Output: the same in lengths from the origin of the scene. Promise: this is
//! done once, where a place or a pose of the scene or of a task in it is accepted; no later stage handles pixels.
//!
//! In an image x counts along its rows to the right and y down its columns, as cameras and programs for images count. A
//! heading is counter-clockwise in the image: 90 deg faces up, towards smaller y. The heading of the frame is the
//! direction of the rows in the scene; `mirrored` means that the image shows the scene from behind.

use super::figures::Figures;
use super::value::{PoseValue, ShapeValue, Value};
use crate::geometry::shape::Pose;
use crate::quantity::{Dimension, Quantity};
use crate::source::Span;
use nalgebra::Point2;

/// Placement of a camera image in a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Pose of the pixel at the place of the frame; its heading is that of the image's rows.
    pose: Pose,
    origin_px: [f64; 2],
    scale_um: f64,
    is_mirrored: bool,
    /// Span of its name in its declaration.
    pub span: Span,
}

/// The image that places in pixels refer to, as far as known.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum View {
    /// There is no image.
    #[default]
    None,
    /// Its scene has errors.
    Unknown,
    /// Pixels are not converted: the value belongs to a shape that is placed by its own `at`.
    Shifted,
    Image(Camera),
}

impl Camera {
    /// The image that a shape describes, with its origin pixel at `pose`; `span` is its name. `None` where its scale is
    /// unknown.
    pub fn new(image: &ShapeValue, pose: Pose, span: Span) -> Option<Camera> {
        let origin_px = match image.fields.get("origin").map(|field| &field.value) {
            Some(Value::Point(point)) => [point[0].si, point[1].si],
            _ => [0.0, 0.0],
        };
        let scale_um = image.fields.quantity("scale")?.in_unit("um/px");
        Some(Camera { pose, origin_px, scale_um, is_mirrored: image.fields.is_set("mirrored"), span })
    }

    /// Scene coordinates of a place in the image.
    pub fn place_um(&self, [x_px, y_px]: [f64; 2]) -> [f64; 2] {
        let along_um = (x_px - self.origin_px[0]) * self.scale_um;
        let down_um = (y_px - self.origin_px[1]) * self.scale_um;
        let across_um = if self.is_mirrored { down_um } else { -down_um };
        (self.pose.isometry() * Point2::new(along_um, across_um)).coords.into()
    }

    /// Heading in the scene of a heading that is counter-clockwise as the image shows it.
    pub fn heading_rad(&self, shown_rad: f64) -> f64 {
        self.pose.heading_rad + if self.is_mirrored { -shown_rad } else { shown_rad }
    }

    /// A place or a pose in pixels, converted to the scene's coordinates; other sorts of value stay as they are. Places
    /// in lengths must not be passed.
    pub fn seen(&self, value: &Value) -> Value {
        let place = |x: Quantity, y: Quantity| self.place_um([x.si, y.si]).map(Quantity::length_um);
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
pub fn is_in_pixels(value: &Value) -> bool {
    match value {
        Value::Point(point) => point.len() == 2 && point[0].dimension == Dimension::PIXELS,
        Value::Pose(pose) => pose.x.dimension == Dimension::PIXELS,
        _ => false,
    }
}
