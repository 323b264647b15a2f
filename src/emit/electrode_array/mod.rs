//! Output of electrode arrays: their motion over time, and its form in logs and pictures.

mod dispensed;
pub mod mcap;
mod microdrop;
pub mod motion;
pub mod svg;

pub use dispensed::dispensed;
pub use microdrop::write as write_microdrop;
