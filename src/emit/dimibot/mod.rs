//! Output of DiMiBots: their motion over time, and its form in logs and pictures.

pub mod mcap;
pub mod motion;
pub mod svg;
