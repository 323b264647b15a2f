//! `tweeze simulate`.

use super::Exit;
use super::arguments::SimulateArguments;

/// Runs the assemblies of a program against robots and measurements with errors.
pub fn run(arguments: &SimulateArguments) -> Exit {
    let _ = arguments;
    Exit::Done
}
