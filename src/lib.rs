//! Tweeze: a declarative language and a verifying compiler for micro-manipulation programs.
//!
//! A `.twz` program says which devices there are, what stands in their way and what has to get done. The compiler finds out how,
//! proves how good its plan is, has an independent verifier replay it, and writes it for instruments, simulators and viewers.
//!
//! # How the house is built
//!
//! Reading the modules in this order is reading the flow of data:
//!
//! | module | turns | into |
//! |---|---|---|
//! | [`syntax`] | text | a [tree](syntax::tree::Tree) per file; it cannot fail, broken parts are error nodes |
//! | [`check`] | trees | [`Claims`](claims::Claims): every name, dimension and value resolved; devices, scenes and goals judged |
//! | [`plan`] | claims | a [`Plan`](plan::Plan) for each job, or a proof that there is none, or the budget that ran out |
//! | [`lower`] | plans | one [`Schedule`](schedule::Schedule): channels and actuations in integer nanoseconds, within what the program's instruments can play |
//! | [`verify`] | a schedule and the claims | a [`Verified`](verify::Verified) schedule, replayed by geometry of its own |
//! | [`emit`] | a verified schedule | MCAP, JSON, CSV, VCD, SPICE and G-code files, scripts and samples for the instruments of the program, a page (`assets/page`) that plays it, and a picture |
//!
//! [`claims`] and [`schedule`] are the contract: data that the stages hand to one another. `check`, `plan`, `verify` and [`log`], which
//! reads MCAP logs back, stand side by side on it, and none of them sees another.
//!
//! Beside them [`simulate`] carries plans out with imperfect devices, where a kind says its errors, and [`mod@format`] turns the text of
//! a program into its canonical form.
//!
//! [`lsp`] answers what an editor asks while a program is written, from the checker and the vocabulary.
//!
//! They stand on a base that knows nothing of them: [`source`] (files and spans), [`real`] (elementary functions that are the same on
//! every platform), [`random`] (numbers that a seed determines), [`quantity`] (units and dimensions),
//! [`geometry`], [`diagnostic`] (what is said to people), [`device`] (the vocabulary and facts of each kind, and those of the
//! [instruments](device::instrument) behind the channels) and [`stdlib`] (published devices and instruments, in the language itself). [`compile`] calls the
//! stages in their order; [`cli`] is the only place that touches files, clock and terminal.
//!
//! # What holds it together
//!
//! - **The type is the ticket.** Only `verify` makes a `Verified` value, and only a `Verified` value can be emitted.
//! - **The claims come from the program, never from a planner,** and the verifier sees no planner: where things are, what they sweep, pull,
//!   roll on and hold is worked out twice, by two geometries. The verifier's own is `verify::geometry`; planners and the checker measure
//!   with [`geometry`]. `tests/tidy.rs` lists what the verifier names of it, and tests put faults into each of the two and see the build
//!   refuse. Elementary functions ([`real`]) and plain figures of [`device`] are shared.
//! - **A device kind is vocabulary.** It is one file of facts in `device`, of `claims`, of judgements in `check`, a planner in `plan`, its
//!   states in `schedule`, a lowering in `lower`, a judge in `verify`, its motion over time and its pictures in `emit`, its lines of the
//!   report in `cli/report`, and a file of published devices in `stdlib/`, all of one name. It adds no syntax. Each stage asks for the
//!   kind once and works through a small trait from there; what a fifth kind costs stands in [`device`].
//! - **Nothing is silent.** All errors of a stage are reported in one run, each with a code, the user's own text labelled, and the
//!   mend. "No plan" is a proof; a search that gave up says so.
//! - **Same input, same bytes.** Budgets count steps and not seconds; no clock, hash order or thread reaches the output.
//!
//! `tests/tidy.rs` holds the rules that can be executed.

// No input may make the compiler panic; tests may.
#![cfg_attr(not(test), warn(clippy::panic, clippy::unwrap_used))]
// Tests compare with the platform's mathematics on purpose.
#![cfg_attr(test, allow(clippy::disallowed_methods))]

pub mod check;
pub mod claims;
pub mod cli;
pub mod compile;
pub mod device;
pub mod diagnostic;
pub mod emit;
pub mod format;
pub mod geometry;
pub mod log;
pub mod lower;
pub mod lsp;
pub mod plan;
pub mod quantity;
pub mod random;
pub mod real;
pub mod schedule;
pub mod simulate;
pub mod source;
pub mod stdlib;
pub mod syntax;
pub mod verify;

// The files of `tests/support` name the crate so, wherever they are used.
#[cfg(test)]
extern crate self as tweeze;
