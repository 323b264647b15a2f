//! Frames in scenes: E056x, W051x.

use super::with_article;
use crate::diagnostic::{Code, Diagnostic};
use crate::quantity::digits;
use crate::source::Span;

pub fn frame_with_shape(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0560, "a frame takes no shape other than `image`")
        .label(span, "does not belong here")
        .help(
            "place a device by its name, `frame left at pose(8 um, 3 um, 90 deg)`, and a camera image under a name of its own, \
             `frame top : image { scale: 0.32 um/px } at (8 um, 3 um)`",
        )
}

pub fn frame_too_far(span: Span, limit: &str) -> Diagnostic {
    Diagnostic::new(Code::E0560, format!("a frame is farther than {limit} from the origin of its scene"))
        .label(span, "too far")
        .help("check the unit: frames are placed in micrometres, as `pose(8 um, 3 um, 90 deg)`")
}

pub fn frame_turned_too_far(span: Span, most_deg: f64) -> Diagnostic {
    Diagnostic::new(Code::E0560, format!("the heading of a frame is more than {} deg", digits(most_deg)))
        .label(span, "too many turns to be exact")
        .help("write a heading between -180 deg and 180 deg")
}

pub fn image_in_itself(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0560, "an image is placed by lengths, but this is in its own pixels")
        .label(span, "in pixels")
        .help("give the position of one pixel in the scene: `image { scale: 0.32 um/px, origin: (640 px, 512 px) } at (6 um, 4 um)`")
}

pub fn image_in_loop(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0571, "an image is declared in a loop")
        .label(span, "a scene has at most one image")
        .help("move the image out of the `for`")
}

pub fn two_images(second: Span, first: Span) -> Diagnostic {
    Diagnostic::new(Code::E0571, "a scene has two images")
        .label(second, "pixels could refer to this image or to the other")
        .label_elsewhere(first, second, "the first image")
        .help(
            "put the second image into a scene of its own: `scene other : bench { frame … }` replaces the one of `bench`",
        )
}

pub fn no_image(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0570, "a place is given in pixels, but the scene has no image")
        .label(span, "in pixels of what?")
        .help("put an image into the scene of the task: `frame top : image { scale: 0.32 um/px } at (0 um, 0 um)`")
}

pub fn pixels_in_shifted_shape(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0570, "a shape is given in pixels of the image, but its `at` puts it somewhere else")
        .label(span, "already placed here")
        .help("leave `at` out, or give the points in lengths from the origin of the shape")
}

pub fn frame_of_other_kind(span: Span, device: &str, kind: &str) -> Diagnostic {
    Diagnostic::new(Code::E0561, format!("`{device}` is {}, a kind that takes no frame in a scene", with_article(kind)))
        .label(span, "not a DiMiBot")
        .help("remove the frame: only DiMiBots have a place in a scene; the scene of any other device is in its own coordinates")
}

pub fn cell_beside_frame(span: Span, object: &str, device: &str, frame: Span) -> Diagnostic {
    Diagnostic::new(Code::E0562, format!("obstacle `{object}` is placed by cells in a scene that places `{device}`"))
        .label(span, "cells belong to one robot, and each robot has its own")
        .label_elsewhere(frame, span, "placed here")
        .help("give the obstacle a place and a shape: `box { size: (2 um, 1 um) } at (4 um, 2.5 um)`, from the origin of the scene")
}

pub fn device_at_two_places(device: &str, second: Span, first: Span) -> Diagnostic {
    Diagnostic::new(Code::E0563, format!("`{device}` has two positions in one program"))
        .label(second, "differs from the position in the other scene")
        .label_elsewhere(first, second, "placed here first")
        .help("give it the same pose in both scenes, or run them in separate programs: a device does not change its place")
}

pub fn not_held([one, other]: [&str; 2], [first, second]: [Span; 2]) -> Diagnostic {
    let title = format!("`{one}` and `{other}` run together in one scene, but are not checked against each other");
    Diagnostic::new(Code::W0510, title)
        .label(second, "runs at the same time")
        .label_elsewhere(first, second, "as this one")
        .help(format!(
            "the program does not say where they stand relative to each other: place both in their scene, `frame {one} at pose(…)` and `frame {other} at pose(…)`"
        ))
}

pub fn obstacle_out_of_all_reach(span: Span, name: &str) -> Diagnostic {
    Diagnostic::new(Code::W0501, format!("obstacle `{name}` lies outside the workspace of every robot of its scene"))
        .label(span, "never in the way")
        .help("places count from the origin of the scene; check the place and its unit")
}
