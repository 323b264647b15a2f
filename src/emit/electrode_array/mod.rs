//! Boards of electrodes in what is written: what they do over time, and how logs and pictures show it.

pub mod course;
pub mod mcap;
mod microdrop;
pub mod svg;

pub use microdrop::write as write_microdrop;
