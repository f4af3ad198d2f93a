//! For the commands that compare alarms with labels.

use clap::Args;

use super::quantity::quantity;

/// The maximum delay of a detection.
///
/// The default depends on the command. `trocar detect` counts later alarms as false, and its labels are set by eye
/// and not exact to 10 ms. `trocar roc` counts later alarms as late, up to 0.5 s, and its labels are exact.
#[derive(Debug, Args)]
pub(super) struct WithinArgs {
    /// Maximum time from a labelled rupture to an alarm that counts as its detection, in s
    #[arg(long, value_name = "S", required = false, value_parser = quantity("s"), allow_hyphen_values = true)]
    pub(super) within_s: f64,
}
