//! DiMiBots in what is written: what they do over time, and how logs and pictures show it.

pub mod course;
pub mod mcap;
pub mod svg;
