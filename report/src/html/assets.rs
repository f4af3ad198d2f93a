//! The files that every page is made of, carried in the binary.

/// Colours, type and spacing, light and dark.
pub const THEME_CSS: &str = include_str!("assets/theme.css");
/// Charts over time, drawn with uPlot.
pub const CHARTS_JS: &str = include_str!("assets/charts.js");
/// uPlot, which draws the axes and curves.
pub const UPLOT_JS: &str = include_str!("assets/uplot/uPlot.iife.min.js");
/// Its style.
pub const UPLOT_CSS: &str = include_str!("assets/uplot/uPlot.min.css");
/// Its licence (MIT).
pub const UPLOT_LICENSE: &str = include_str!("assets/uplot/LICENSE");

/// The template of a report.
pub(super) const REPORT_HTML: &str = include_str!("assets/report.html");
/// Its style.
pub(super) const REPORT_CSS: &str = include_str!("assets/report.css");
/// Its script.
pub(super) const REPORT_JS: &str = include_str!("assets/report.js");
