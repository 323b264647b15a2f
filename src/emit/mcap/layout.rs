//! A Lichtblick layout beside a log: each device from above, its plots and the text of the program, without set-up.
//!
//! It has a 3D panel for each device, whose camera sees the box of its scene, a small one that follows the first mover,
//! plots of what changes, and the log. Lichtblick imports the file by "Import from file…" in its menu of layouts.

use super::foxglove::PointCloud;
use super::frames::Mover;
use super::{LogTopic, LoggedDevice, pictures};
use crate::log::{BOUND_SUFFIX, PERIOD_SUFFIX};
use crate::verify::Verified;
use prost::Message as _;
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// Greatest number of devices with a panel of their own.
const MAX_DEVICES: usize = 4;

/// Greatest number of lines in a plot.
const MAX_LINES: usize = 16;

/// The field of view of the cameras, in degrees.
const FIELD_OF_VIEW_DEG: f64 = 45.0;

/// Distance of a camera from its scene, as a multiple of the scene's size: at 45 degrees it sees 0.83 of its distance.
const DISTANCE_PER_SIZE: f64 = 1.4;

/// Extent shown by the small panel, as a share of the size of the scene.
const INSET_PART: f64 = 0.15;

/// The bytes of the file.
pub(super) fn write(verified: &Verified, topics: &[LogTopic], movers: &[Mover]) -> Vec<u8> {
    let mut panels = Panels::default();
    let devices = LoggedDevice::all(verified);
    let mut views = Vec::new();
    for device in devices.iter().take(MAX_DEVICES) {
        let Some(scene) = SceneBox::of(topics, device.name) else { continue };
        let tilt_deg = pictures(&device.job.order).tilt_deg();
        let shown = scenes(topics, device.name);
        views.push(panels.add("3D", view(device.name, scene.middle, scene.size, tilt_deg, &shown)));
        if let Some(mover) = movers.iter().find(|mover: &&Mover| mover.device == device.name) {
            views.push(panels.add("3D", view(&mover.frame, [0.0; 3], scene.size * INSET_PART, tilt_deg, &shown)));
        }
    }
    let mut sides: Vec<String> = plots(verified, topics).into_iter().map(|plot| panels.add("Plot", plot)).collect();
    sides.push(
        panels.add("RosOut", json!({ "topicToRender": "/log", "minLogLevel": 1, "searchTerms": [], "nameFilter": {} })),
    );
    let layout = split("row", [stack(&views), stack(&sides)], 58);
    let whole = json!({
        "configById": panels.configs,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": { "speed": 1 },
        "layout": layout,
    });
    let mut text = format!("{whole:#}");
    text.push('\n');
    text.into_bytes()
}

/// The settings of all panels, by id.
#[derive(Default)]
struct Panels {
    configs: serde_json::Map<String, Value>,
}

impl Panels {
    /// Adds a panel and returns its id.
    fn add(&mut self, kind: &str, config: Value) -> String {
        let id = format!("{kind}!{}", self.configs.len() + 1);
        self.configs.insert(id.clone(), config);
        id
    }
}

/// Splits the window in two, the first part taking a share in percent; one part may be missing.
fn split(direction: &str, parts: [Option<Value>; 2], percent: u32) -> Option<Value> {
    match parts {
        [Some(first), Some(second)] => {
            Some(json!({ "direction": direction, "first": first, "second": second, "splitPercentage": percent }))
        }
        [one, other] => one.or(other),
    }
}

/// Stacks panels of the same height.
fn stack(ids: &[String]) -> Option<Value> {
    let (first, rest) = ids.split_first()?;
    split("column", [Some(json!(first)), stack(rest)], 100 / ids.len() as u32)
}

/// Location of the scene of a device, in its own frame.
struct SceneBox {
    middle: [f64; 3],
    /// Length of its longest edge; above zero.
    size: f64,
}

impl SceneBox {
    /// The box around the points in the frame of the device: those of scenery, paths and goals.
    fn of(topics: &[LogTopic], device: &str) -> Option<SceneBox> {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        let own = ["scene/points", "plan/points"].map(|what| format!("/{device}/{what}"));
        for (_, data) in topics.iter().filter(|topic| own.contains(&topic.name)).flat_map(|topic| &topic.messages) {
            let Ok(cloud) = PointCloud::decode(data.as_slice()) else { continue };
            if cloud.frame_id != device {
                continue;
            }
            for point in cloud.data.chunks_exact(cloud.point_stride.max(12) as usize) {
                for axis in 0..3 {
                    let bytes = [0, 1, 2, 3].map(|byte| point[4 * axis + byte]);
                    let value = f64::from(f32::from_le_bytes(bytes));
                    (low[axis], high[axis]) = (low[axis].min(value), high[axis].max(value));
                }
            }
        }
        let size = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
        let middle = [0, 1, 2].map(|axis| (low[axis] + high[axis]) / 2.0);
        (size > 0.0 && size.is_finite()).then_some(SceneBox { middle, size })
    }
}

/// Names of the scene topics of a device.
fn scenes(topics: &[LogTopic], device: &str) -> Vec<String> {
    let own = format!("/{device}/");
    let of_device =
        topics.iter().filter(|topic| topic.schema.name == "foxglove.SceneUpdate" && topic.name.starts_with(&own));
    of_device.map(|topic| topic.name.clone()).collect()
}

/// A 3D panel that follows a frame.
fn view(frame: &str, middle: [f64; 3], size: f64, tilt_deg: f64, shown: &[String]) -> Value {
    let distance = size * DISTANCE_PER_SIZE;
    let topics: serde_json::Map<String, Value> =
        shown.iter().map(|name| (name.clone(), json!({ "visible": true }))).collect();
    json!({
        "cameraState": {
            "perspective": false, "phi": tilt_deg, "thetaOffset": 0.0, "distance": distance, "targetOffset": middle,
            "target": [0, 0, 0], "targetOrientation": [0, 0, 0, 1], "fovy": FIELD_OF_VIEW_DEG,
            "near": distance / 1000.0, "far": distance * 1000.0,
        },
        "followMode": "follow-none",
        "followTf": frame,
        "scene": { "transforms": { "visible": false, "enablePreloading": true }, "backgroundColor": "#ffffff" },
        "topics": topics, "layers": {}, "transforms": {}, "publish": {}, "imageMode": {},
    })
}

/// One plot per device: the cells of the parts of a board, otherwise the driven channels.
fn plots(verified: &Verified, topics: &[LogTopic]) -> Vec<Value> {
    let schedule = verified.schedule();
    let driven = schedule.actuations.iter().filter_map(|actuation| schedule.channels.get(actuation.channel as usize));
    let driven: BTreeSet<&str> = driven.map(|channel| channel.name.as_str()).collect();
    let is_cells = |topic: &&LogTopic| topic.name.ends_with("/cells");
    let devices: BTreeSet<&str> =
        topics.iter().filter(is_cells).filter_map(|topic| topic.name.strip_suffix("/cells")).collect();
    let of_topic = |topic: &LogTopic| {
        let is_field = |name: &str| ![".wire", BOUND_SUFFIX, PERIOD_SUFFIX].iter().any(|suffix| name.ends_with(suffix));
        let of_cells = is_cells(&topic);
        let device = topic.name.rsplit_once('/').map_or("", |(device, _)| device);
        let is_series = topic.name.ends_with("/voltages") || topic.name.ends_with("/positions");
        let is_plotted = of_cells || is_series && !devices.contains(device);
        let fields = topic.metadata.iter().filter(|(name, _)| is_plotted && is_field(name));
        let fields = fields.filter(|(_, channel)| of_cells || driven.contains(channel.as_str()));
        let lines: Vec<Value> = fields.take(MAX_LINES).map(|(name, _)| line(&topic.name, name)).collect();
        (!lines.is_empty())
            .then(|| json!({ "paths": lines, "xAxisVal": "timestamp", "showLegend": true, "isSynced": true }))
    };
    topics.iter().filter_map(of_topic).take(MAX_DEVICES).collect()
}

fn line(topic: &str, field: &str) -> Value {
    json!({
        "value": format!("{topic}.{field}"), "enabled": true, "timestampMethod": "receiveTime", "showLine": true, "label": field,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emit::mcap::topics_and_movers;
    use crate::emit::{Signals, fixture};

    /// Every 3D panel, with its camera.
    fn views(layout: &Value) -> Vec<&Value> {
        let configs = layout["configById"].as_object().unwrap();
        configs.iter().filter(|(id, _)| id.starts_with("3D!")).map(|(_, config)| config).collect()
    }

    #[test]
    fn a_layout_names_topics_of_the_log_and_its_cameras_see_the_scenes() {
        for make in [fixture::fetch, fixture::pair, fixture::bed, fixture::hand] {
            let verified = make().verified;
            let (topics, movers) = topics_and_movers(&verified, &Signals::new(verified.schedule()));
            let layout: Value = serde_json::from_slice(&write(&verified, &topics, &movers)).unwrap();
            let names: BTreeSet<&str> = topics.iter().map(|topic| topic.name.as_str()).collect();
            let views = views(&layout);
            assert_eq!(views.len(), 2 * LoggedDevice::all(&verified).len(), "a view and a small one for each device");
            for view in views {
                assert!(view["topics"].as_object().unwrap().keys().all(|name| names.contains(name.as_str())));
                let frame = view["followTf"].as_str().unwrap();
                let Some(scene) = SceneBox::of(&topics, frame) else {
                    assert!(movers.iter().any(|mover| mover.frame == frame), "{frame} is no frame");
                    continue;
                };
                let camera = &view["cameraState"];
                let seen = camera["distance"].as_f64().unwrap() * 2.0 * (FIELD_OF_VIEW_DEG / 2.0).to_radians().tan();
                let offset = &camera["targetOffset"];
                let off =
                    (0..3).map(|axis| (offset[axis].as_f64().unwrap() - scene.middle[axis]).abs()).fold(0.0, f64::max);
                assert!(off < 1e-9 && seen >= scene.size, "{frame}: {seen} of {}", scene.size);
            }
            let plots = layout["configById"].as_object().unwrap().iter().filter(|(id, _)| id.starts_with("Plot!"));
            let lines: Vec<&str> = plots
                .flat_map(|(_, plot)| plot["paths"].as_array().unwrap())
                .map(|path| path["value"].as_str().unwrap())
                .collect();
            assert!(!lines.is_empty());
            for line in lines {
                let (topic, field) = line.split_once('.').unwrap();
                let topic = topics.iter().find(|known| known.name == topic).unwrap();
                assert!(topic.metadata.contains_key(field), "{line}");
            }
        }
    }
}
