//! Output of electrode arrays: their motion over time, and its form in logs and pictures.

pub mod course;
mod dispensed;
pub mod mcap;
mod microdrop;
pub mod svg;

pub use dispensed::dispensed;
pub use microdrop::write as write_microdrop;
