//! Without the feature `dop853`.

use thiserror::Error;

use super::Differential;

#[derive(Debug, Error)]
#[error("this build of trocar has no integrator, because its feature `dop853` is off")]
pub struct Failure;

pub(super) fn integrate<V>(_: impl Differential<V>, _duration_s: f64, _: &mut V) -> Result<(), Failure> {
    Err(Failure)
}
