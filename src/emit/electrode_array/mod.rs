//! Boards of electrodes in what is written: what they do over time, and how logs and pictures show it.

pub mod course;
mod dispensed;
pub mod mcap;
mod microdrop;
pub mod svg;

pub use dispensed::dispensed;
pub use microdrop::write as write_microdrop;
