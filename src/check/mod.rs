//! Names, dimensions, values; is this device possible, is this scene possible.
pub mod claims;
