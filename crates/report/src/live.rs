//! The summary of a live stream, as text.

use super::wrap::wrapped;
use trocar_document::{show, significant};
use trocar_metrics::Unit;
use trocar_studies::detect::LiveSummary;

/// Returns the summary of a live stream. `rows` counts the rows below the header, `malformed` those that cannot be read, and
/// `ended` names the cause of the end.
#[must_use]
pub fn live_text(summary: &LiveSummary, rows: u64, malformed: u64, ended: &str) -> String {
    let plural = |count: u64, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
    let seconds = |value: f64| format!("{} s", significant(value));
    let newton = |value| show(value, Unit::Newton);
    let interval = summary.interval_s.map_or(String::new(), |s| format!(" {} apart", show(Some(s), Unit::Second)));
    let text = format!(
        "{}{interval} over {} ({} in contact), {}; ended by {ended}\nmean |residual| {}, σ {}, maximum {}\n{}: {malformed} \
         malformed and {} out of order skipped, {} interpolated, {} uneven, {}",
        plural(summary.samples, "sample"),
        seconds(summary.duration_s),
        seconds(summary.contact_s),
        plural(summary.alarms, "alarm"),
        newton(summary.mean_absolute_n),
        newton(summary.std_n),
        newton(summary.max_absolute_n),
        plural(rows, "row"),
        summary.not_later,
        plural(summary.interpolated, "lost sample"),
        plural(summary.uneven, "step"),
        plural(summary.restarts, "restart"),
    );
    wrapped(&text, 0)
}
