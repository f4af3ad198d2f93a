use crate::LiveSummary;
use trocar_document::{counted, show, significant};
use trocar_metrics::Unit;

/// `malformed` counts unreadable rows; `ended` names the cause of the end.
pub fn live_text(summary: &LiveSummary, rows: u64, malformed: u64, ended: &str) -> String {
    let seconds = |value: f64| format!("{} s", significant(value));
    let newton = |value| show(value, Unit::Newton);
    let interval = summary.interval_s.map_or(String::new(), |s| format!(" {} apart", show(Some(s), Unit::Second)));
    format!(
        "{}{interval} over {} ({} in contact), {}; ended by {ended}\nmean |residual| {}, σ {}, maximum {}\n{}: {malformed} \
         malformed and {} out of order skipped, {} interpolated, {} uneven, {}",
        counted(summary.samples, "sample"),
        seconds(summary.duration_s),
        seconds(summary.contact_s),
        counted(summary.alarms, "alarm"),
        newton(summary.mean_absolute_n),
        newton(summary.std_n),
        newton(summary.max_absolute_n),
        counted(rows, "row"),
        summary.not_later,
        counted(summary.interpolated, "lost sample"),
        counted(summary.uneven, "step"),
        counted(summary.restarts, "restart"),
    )
}
