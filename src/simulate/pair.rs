//! The first two robots, which are brought together.
use super::trial::{Failure, Trial};
use crate::plan::microrobots::strategy::Episode;
pub fn run(_trial: &mut Trial, _episode: &Episode) -> Result<(), Failure> {
    Ok(())
}
