//! Turns diagnostics into text: the only place that knows miette.
