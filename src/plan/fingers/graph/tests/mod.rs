//! Comparison with a plain Dijkstra search over an explicit graph, and the cases of the paper.

mod cases;
mod oracle;
mod paper;
mod random;
