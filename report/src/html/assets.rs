//! The files of every page, embedded in the binary.

/// Colours, fonts and spacing, for the light and the dark theme.
pub const THEME_CSS: &str = include_str!("assets/theme.css");
/// Charts, drawn with uPlot.
pub const CHARTS_JS: &str = include_str!("assets/charts.js");
/// The animation of a rupture.
pub const ANIMATION_JS: &str = include_str!("assets/animation.js");
/// The plotting library uPlot.
pub const UPLOT_JS: &str = include_str!("assets/uplot/uPlot.iife.min.js");
/// The style of uPlot.
pub const UPLOT_CSS: &str = include_str!("assets/uplot/uPlot.min.css");
/// The licence of uPlot (MIT).
pub const UPLOT_LICENSE: &str = include_str!("assets/uplot/LICENSE");

/// The template of a report.
pub(super) const REPORT_HTML: &str = include_str!("assets/report.html");
/// The style of a report.
pub(super) const REPORT_CSS: &str = include_str!("assets/report.css");
/// The script of a report.
pub(super) const REPORT_JS: &str = include_str!("assets/report.js");
