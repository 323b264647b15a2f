//! The only module that uses the `foxglove` crate: its message types and their encoding.
//!
//! The crate is young and pinned exactly; compare logs before and after raising the pin.

pub use foxglove::messages::*;

use foxglove::Encode;

/// Name and descriptor of a message type.
pub struct MessageSchema {
    pub name: String,
    pub descriptor: Vec<u8>,
}

/// The schema of a message type. Every type used here has one.
pub fn schema<T: Encode>() -> Option<MessageSchema> {
    T::get_schema().map(|schema| MessageSchema { name: schema.name, descriptor: schema.data.into_owned() })
}

/// A message as protobuf bytes. A `Vec` takes any length, so encoding into it cannot fail.
pub fn encode<T: prost::Message>(message: &T) -> Vec<u8> {
    message.encode_to_vec()
}

/// An instant of the schedule as a timestamp; the log's clock begins at 0. It saturates after 136 years.
pub fn timestamp(t_ns: u64) -> Option<Timestamp> {
    let seconds = u32::try_from(t_ns / 1_000_000_000).unwrap_or(u32::MAX);
    Timestamp::new_checked(seconds, (t_ns % 1_000_000_000) as u32)
}

/// A pose without rotation.
pub fn pose_at(place: [f64; 3]) -> Option<Pose> {
    turned_pose(place, [1.0, 0.0])
}

/// A pose turned about z, so that its x axis has the direction of a unit vector in the plane.
///
/// The sine and cosine of the half angle come from square roots, which are the same on every machine; those of angles
/// are not.
pub fn turned_pose([x, y, z]: [f64; 3], [cos, sin]: [f64; 2]) -> Option<Pose> {
    let half = |cos: f64| ((1.0 + cos) / 2.0).max(0.0).sqrt();
    let orientation = Quaternion { x: 0.0, y: 0.0, z: half(-cos).copysign(sin), w: half(cos) };
    Some(Pose { position: Some(Vector3 { x, y, z }), orientation: Some(orientation) })
}

/// A pose whose x axis has the direction of a unit vector.
pub fn pointed_pose([x, y, z]: [f64; 3], [u, v, w]: [f64; 3]) -> Option<Pose> {
    // Shortest rotation from x to the vector, by its half angle; for the opposite direction any perpendicular axis will
    // do.
    let half = ((1.0 + u) / 2.0).max(0.0).sqrt();
    let orientation = match half {
        0.0 => Quaternion { x: 0.0, y: 0.0, z: 1.0, w: 0.0 },
        _ => Quaternion { x: 0.0, y: -w / (2.0 * half), z: v / (2.0 * half), w: half },
    };
    Some(Pose { position: Some(Vector3 { x, y, z }), orientation: Some(orientation) })
}
