//! The option `--within-s` of the commands that judge alarms by labels.

use clap::Args;

use super::quantity::quantity;

/// The longest delay of a detection.
///
/// The default belongs to the command, because the two commands treat later alarms differently. `trocar detect` counts them as false,
/// and labels that a person set by eye are not exact to 10 ms. `trocar roc` counts them as late, up to 0.5 s, and its labels are exact.
#[derive(Debug, Args)]
pub(super) struct WithinArgs {
    /// How long after a labelled rupture an alarm counts as in time, in s
    #[arg(long, value_name = "S", required = false, value_parser = quantity("s"), allow_hyphen_values = true)]
    pub(super) within_s: f64,
}
