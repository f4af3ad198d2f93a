//! How a pair stands in noise: what `compare` adds to its table, and what a page gets once its controls rest.

use serde_json::json;

use super::frame::table;
use super::pair::Pair;
use super::protocol::Answer;
use super::state::StateError;
use crate::compare::check_in_noise;

/// The whole table of a pair, detection in noise included.
///
/// # Errors
/// [`StateError`].
pub(super) fn in_noise(id: u32, pair: &Pair) -> Result<Answer, StateError> {
    let checks = pair.runs.iter().map(|run| check_in_noise(&run.scenario)).collect::<Result<Vec<_>, _>>()?;
    Ok(Answer::json(&json!({ "type": "table", "id": id, "table": table(&pair.runs, &checks) })))
}
