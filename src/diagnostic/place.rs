//! Places of a scene that diagnostics are about, for pictures of them.

use crate::source::Span;

/// A place of a scene as a program writes it.
#[derive(Debug, Clone, PartialEq)]
pub struct WrittenPlace {
    pub span: Span,
    /// The device whose task names it; `None` for a place of an object in a scene.
    pub device: Option<String>,
    pub unit: PlaceUnit,
    pub at: [f64; 2],
}

/// Unit of a [`WrittenPlace`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlaceUnit {
    /// Cells of a lattice or electrodes of a board, as the program counts them.
    Cells,
    /// Micrometres in the scene.
    Micrometres,
}
