//! Tweeze: a declarative language and a verifying compiler for micro-manipulation programs.
//!
//! A `.twz` program declares devices, the obstacles around them and the tasks to be done. The compiler plans the
//! tasks, states how good each plan is, has an independent verifier replay it, and writes it for instruments,
//! simulators and viewers.
//!
//! # Architecture
//!
//! The modules in the order of the data flow:
//!
//! | module | turns | into |
//! |---|---|---|
//! | [`syntax`] | text | a [tree](syntax::tree::Tree) per file; cannot fail, broken parts become error nodes |
//! | [`check`] | trees | [`Claims`](claims::Claims): names, dimensions and values resolved; devices, scenes and goals judged |
//! | [`plan`] | claims | a [`Plan`](plan::Plan) per job, a proof that there is none, or the budget that ran out |
//! | [`lower`] | plans | one [`Schedule`](schedule::Schedule): channels and actuations in integer ns, within the limits of the instruments |
//! | [`verify`] | a schedule and the claims | a [`Verified`](verify::Verified) schedule, replayed with its own geometry |
//! | [`emit`] | a verified schedule | MCAP, JSON, CSV, VCD, SPICE, G-code; instrument scripts and samples; a player page (`assets/page`) |
//!
//! [`claims`] and [`schedule`] are the contract: the data that stages pass to one another. `check`, `plan`, `verify`
//! and [`log`], which reads MCAP logs back, build on it side by side, and none of them depends on another.
//!
//! Beside them, [`simulate`] executes plans on imperfect devices, for kinds that state their errors, and
//! [`mod@format`] rewrites a program's text in canonical form.
//!
//! [`lsp`] answers an editor's requests from the checker and the vocabulary.
//!
//! The base depends on none of them: [`source`] (files and spans), [`real`] (elementary functions with the same bits
//! on every platform), [`random`] (seeded random numbers), [`quantity`] (units and dimensions), [`geometry`],
//! [`diagnostic`] (messages to users), [`device`] (the vocabulary and facts of each kind, and those of the
//! [instruments](device::instrument) behind the channels) and [`stdlib`] (published devices and instruments, written
//! in the language itself). [`compile`] calls the stages in order; [`cli`] is the only module that touches files,
//! clock and terminal.
//!
//! # Invariants
//!
//! - **The type is the ticket.** Only `verify` makes a `Verified` value, and only a `Verified` value can be emitted.
//! - **The claims come from the program, never from a planner,** and the verifier does not see the planners:
//!   positions, swept areas, pull, rolling and holding are computed twice, by two geometries. The verifier has its
//!   own, `verify::geometry`; planners and the checker use [`geometry`]. `tests/tidy.rs` lists the few items of it
//!   that the verifier names, and tests inject faults into each of the two and check that the build is refused.
//!   Elementary functions ([`real`]) and plain figures of [`device`] are shared.
//! - **A device kind is vocabulary.** A kind is one file of facts in `device`, of `claims`, of judgements in `check`,
//!   a planner in `plan`, its states in `schedule`, a lowering in `lower`, a judge in `verify`, its motion over time
//!   and its pictures in `emit`, its lines of the report in `cli/report`, and a file of published devices in
//!   `stdlib/`, all under the same name. It adds no syntax. Each stage matches on the kind once and then works
//!   through a small trait; [`device`] lists what a fifth kind costs.
//! - **Nothing is silent.** All errors of a stage are reported in one run, each with a code, a label at the user's
//!   own text, and the fix. "No plan" is a proof; a search that gave up says so.
//! - **Same input, same bytes.** Budgets count steps and not seconds; no clock, hash order or thread reaches the output.
//!
//! `tests/tidy.rs` enforces the rules that can be executed.

// No input may make the compiler panic; tests may panic.
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

// The files of `tests/support` refer to the crate by this name, in unit tests as well as in integration tests.
#[cfg(test)]
extern crate self as tweeze;
