//! The files of every page, embedded in the binary.

/// Colours, fonts and spacing, for the light and the dark theme.
pub const THEME_CSS: &str = include_str!("assets/theme.css");
/// Charts, drawn from the descriptions of figures.
pub const CHARTS_JS: &str = include_str!("assets/charts.js");
/// The animation of a rupture.
pub const ANIMATION_JS: &str = include_str!("assets/animation.js");
/// The template of a report.
pub(super) const REPORT_HTML: &str = include_str!("assets/report.html");
/// The style of a report.
pub(super) const REPORT_CSS: &str = include_str!("assets/report.css");
/// The script of a report.
pub(super) const REPORT_JS: &str = include_str!("assets/report.js");
