//! The output of a sweep: rows, findings and figures.

mod pictures;
mod tables;
mod text;

pub(super) use pictures::heat_figure;
pub use pictures::sweep_pictures;
pub use tables::{write_sweep_csv, write_sweep_parquet};
pub(super) use text::{SUMMARY_HEADING, heading, summary_row};
pub use text::{sweep_json, sweep_summary_csv, sweep_text};
