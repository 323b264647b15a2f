//! Frames: the places of devices and of camera images in a scene.
//!
//! `frame left at pose(…)` in a scene puts the frame of the device `left` there; a frame with a shape is that of an image
//! ([`super::camera`]), whose pixels are converted here, where a place or a pose is accepted.

use super::camera::{Camera, View, is_in_pixels};
use super::scope::{DeclarationPlace, DeclarationSort, Scope};
use super::shapes::{MAX_HEADING_RAD, pose_of};
use super::value::{ListValue, Value};
use super::{Checker, errors};
use crate::device::shape::ShapeForm;
use crate::device::{Frames, Kind, MAX_REACH_UM};
use crate::geometry::shape::Pose;
use crate::source::{Span, Spanned};
use crate::syntax::tree::{self, Ident, IndexedName, Path};
use std::rc::Rc;

/// The noun of a scene that places a device. It belongs to the language, not to a kind.
pub const NOUN: &str = "frame";

/// Placement of a device in a scene.
#[derive(Debug, Clone)]
pub struct DeviceFrame {
    pub device: DeclarationPlace,
    pub pose: Pose,
    /// Span of the device's name in the scene.
    pub span: Span,
}

impl Checker<'_> {
    /// The frame of a device in a scene; `None` after an error.
    pub fn frame(&mut self, object: &tree::Object, scope: &Scope) -> Option<DeviceFrame> {
        let name = &object.name;
        let text = self.joined(&name.name.text, &name.indices, scope)?;
        let segment = IndexedName { name: Ident { text, span: name.span }, indices: Vec::new(), span: name.span };
        let path = Path { segments: vec![segment], span: name.span };
        let device = self.resolve(&path, scope, DeclarationSort::Device)?;
        let kind = self.inherited::<Kind>(device)?.root;
        if kind.vocabulary().frames == Frames::No {
            self.sink.push(errors::frame_of_other_kind(name.span, self.named(device).0, kind.name()));
            return None;
        }
        let pose = self.pose_of_frame(object, scope)?;
        Some(DeviceFrame { device, pose, span: name.span })
    }

    fn pose_of_frame(&mut self, object: &tree::Object, scope: &Scope) -> Option<Pose> {
        let Some(at) = &object.at else { return Some(Pose::at(0.0, 0.0)) };
        let value = self.evaluate(at, scope);
        let value = self.in_scene(value, at.span, scope);
        self.frame_pose(&value, at.span)
    }

    /// The camera image that a scene's entries place; `Ok(None)` if there is none, `Err` after an error.
    pub fn image(&mut self, entries: &[tree::SceneEntry], scope: &Scope) -> Result<Option<Camera>, ()> {
        let mut found: Option<Camera> = None;
        for entry in entries {
            let tree::SceneEntry::Object(object) = entry else { continue };
            let Some(shape) = object.shape.as_ref().filter(|_| object.noun.text == NOUN) else {
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
        Camera::new(&image, pose, object.name.span)
    }

    /// The pose of an object in scene coordinates; `None` after an error.
    pub fn frame_pose(&mut self, value: &Value, span: Span) -> Option<Pose> {
        if value.is_unknown() {
            return None;
        }
        let Some(pose) = pose_of(value) else {
            self.sink.push(errors::wrong_place(span, value, "a place or a pose for a frame"));
            return None;
        };
        if pose.x_um.abs().max(pose.y_um.abs()) > MAX_REACH_UM {
            self.sink.push(errors::frame_too_far(span, "100 mm"));
            return None;
        }
        if pose.heading_rad.abs() > MAX_HEADING_RAD {
            self.sink.push(errors::frame_turned_too_far(span, MAX_HEADING_RAD.to_degrees()));
            return None;
        }
        Some(pose)
    }

    /// A value with its pixels converted into scene coordinates; [`Value::Unknown`] after an error.
    pub fn in_scene(&mut self, value: Value, span: Span, scope: &Scope) -> Value {
        match &value {
            Value::List(list) if list.iter().any(|element| is_in_pixels(&element.value)) => {
                let mut seen = Vec::with_capacity(list.len());
                for element in list.iter() {
                    let inside = if span.contains(element.span) { element.span } else { span };
                    let one = self.one_in_scene(element.value.clone(), inside, scope);
                    if one.is_unknown() && !element.value.is_unknown() {
                        // The other elements have the same fault.
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
}
