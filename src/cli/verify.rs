//! `tweeze verify`.
use super::Exit;
use super::arguments::VerifyArguments;
pub fn run(_: &VerifyArguments) -> Exit {
    Exit::Files
}
