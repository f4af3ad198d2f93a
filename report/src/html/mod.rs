//! `report.html`: what a command found, on one page that needs nothing but itself.
//!
//! Pages are made of [`page::Section`]s; [`page::Page::render`] puts them into the template `assets/report.html` together
//! with the style, the plotting library (uPlot, MIT), `assets/charts.js`, `assets/report.js`, and the numbers that these draw. A
//! page loads nothing, holds no date and no path, and the same results give the same bytes. Whatever comes out of scenarios and
//! recordings is escaped.

pub mod assets;
mod bars;
mod chart;
mod command;
mod compared;
mod detected;
mod digits;
mod events;
mod map;
mod page;
mod signals;
mod stable;
mod swept;
mod thin;

pub use command::command_line;
pub use compared::{comparison_html, run_html};
pub use detected::{DetectionPage, detection_html, detections_html};
pub use page::HtmlError;
pub use stable::{StabilityPage, stability_html};
pub use swept::{DrawnCases, SweepPage, sweep_html};
