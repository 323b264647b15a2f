//! Frames in scenes: E056x, W051x.

use super::with_article;
use crate::diagnostic::{Code, Diagnostic};
use crate::quantity::digits;
use crate::source::Span;

pub fn frame_with_shape(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0560, "a frame has no shape")
        .label(span, "does not belong here")
        .help("a frame is a place and a heading: `frame left at pose(8 um, 3 um, 90 deg)`")
}

pub fn frame_too_far(span: Span, limit: &str) -> Diagnostic {
    Diagnostic::new(Code::E0560, format!("a frame farther than {limit} from the origin of its scene"))
        .label(span, "too far")
        .help("check the unit: frames are placed in micrometres, as `pose(8 um, 3 um, 90 deg)`")
}

pub fn frame_turned_too_far(span: Span, most_deg: f64) -> Diagnostic {
    Diagnostic::new(Code::E0560, format!("a frame with a heading of more than {} deg", digits(most_deg)))
        .label(span, "so many turns cannot be told apart")
        .help("write a heading between -180 deg and 180 deg")
}

pub fn frame_of_other_kind(span: Span, device: &str, kind: &str) -> Diagnostic {
    Diagnostic::new(Code::E0561, format!("`{device}` is {}, which has no frame in a scene yet", with_article(kind)))
        .label(span, "not a DiMiBot")
        .help("take the frame out: only DiMiBots have a place in a scene; the scene of any other device is in its own coordinates")
}

pub fn cell_beside_frame(span: Span, object: &str, device: &str, frame: Span) -> Diagnostic {
    Diagnostic::new(Code::E0562, format!("obstacle `{object}` stands on cells, in a scene that places `{device}`"))
        .label(span, "cells are those of one robot, each robot has its own")
        .label_elsewhere(frame, span, "placed here")
        .help("give the obstacle a place and a shape: `box { size: (2 um, 1 um) } at (4 um, 2.5 um)`, from the origin of the scene")
}

pub fn device_at_two_places(device: &str, second: Span, first: Span) -> Diagnostic {
    Diagnostic::new(Code::E0563, format!("`{device}` stands at two places in one program"))
        .label(second, "another place than in the other scene")
        .label_elsewhere(first, second, "placed here first")
        .help("a device does not change its place: give it the same pose in both scenes, or run them in programs of their own")
}

pub fn not_held([one, other]: [&str; 2], [first, second]: [Span; 2]) -> Diagnostic {
    let title = format!("`{one}` and `{other}` run together in one scene, but are not held against each other");
    Diagnostic::new(Code::W0510, title)
        .label(second, "runs at the same time")
        .label_elsewhere(first, second, "as this one")
        .help(format!(
            "nobody knows where they are to each other: place both in their scene, `frame {one} at pose(…)` and `frame {other} at pose(…)`"
        ))
}

pub fn obstacle_out_of_all_reach(span: Span, name: &str) -> Diagnostic {
    Diagnostic::new(Code::W0501, format!("obstacle `{name}` lies outside the workspace of every robot of its scene"))
        .label(span, "never in the way")
        .help("places count from the origin of the scene; check the place and its unit")
}
