//! The only place that knows the `foxglove` crate: its message types, and how one becomes bytes.
//!
//! The crate is young and pinned exactly; whoever raises the pin compares logs before and after.

pub use foxglove::messages::*;

use foxglove::Encode;

/// Name and descriptor of a message type.
pub struct Schema {
    pub name: String,
    pub descriptor: Vec<u8>,
}

/// The schema of a message type. Every type used here has one.
pub fn schema<T: Encode>() -> Option<Schema> {
    T::get_schema().map(|schema| Schema { name: schema.name, descriptor: schema.data.into_owned() })
}

/// A message as protobuf bytes. A `Vec` takes any length, so encoding into it cannot fail.
pub fn encode<T: prost::Message>(message: &T) -> Vec<u8> {
    message.encode_to_vec()
}

/// An instant of the schedule; the log's clock begins at 0. It stops after 136 years.
pub fn timestamp(t_ns: u64) -> Option<Timestamp> {
    let seconds = u32::try_from(t_ns / 1_000_000_000).unwrap_or(u32::MAX);
    Timestamp::new_checked(seconds, (t_ns % 1_000_000_000) as u32)
}

/// A pose without rotation.
pub fn pose_at([x, y, z]: [f64; 3]) -> Option<Pose> {
    turned_pose([x, y, z], 0.0)
}

/// A pose turned about z, counter-clockwise.
pub fn turned_pose([x, y, z]: [f64; 3], heading_rad: f64) -> Option<Pose> {
    let half = heading_rad / 2.0;
    Some(Pose {
        position: Some(Vector3 { x, y, z }),
        orientation: Some(Quaternion { x: 0.0, y: 0.0, z: half.sin(), w: half.cos() }),
    })
}
