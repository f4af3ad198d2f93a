//! How a pair stands in noise: what `compare` adds to its table, and what a page gets once its controls rest.

use super::pair::Pair;
use super::state::StateError;
use crate::compare::{NoiseCheck, check_in_noise};

/// Detection in noise, of both runs.
///
/// # Errors
/// [`StateError`].
pub(super) fn in_noise(pair: &Pair) -> Result<Vec<NoiseCheck>, StateError> {
    let checks = pair.runs.iter().map(|run| check_in_noise(&run.scenario)).collect::<Result<Vec<_>, _>>()?;
    Ok(checks)
}
