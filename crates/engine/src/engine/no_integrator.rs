//! The integrator of a build without the feature `dop853`: every step fails.

use thiserror::Error;

use super::Differential;

/// The reason why this build does not integrate.
#[derive(Debug, Error)]
#[error("this build of trocar has no integrator, because its feature `dop853` is off")]
pub struct Failure;

pub(super) fn integrate<V>(_: impl Differential<V>, _duration_s: f64, _: &mut V) -> Result<(), Failure> {
    Err(Failure)
}
