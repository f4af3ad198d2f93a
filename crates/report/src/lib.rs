//! The output of a run: tables, CSV, JSON, figures, reports and error messages. No other package formats or draws results.

mod animation;
mod answer;
mod calibration;
mod columns;
mod comparison;
mod decimate;
mod detection;
mod detections;
pub mod diagnostic;
mod digits;
mod document;
pub mod figures;
mod files;
mod finding;
pub mod html;
mod json;
mod link;
mod live;
mod metrics;
mod paper;
mod pictures;
mod roc;
mod schemes;
mod seeds;
mod signals;
mod stability_figures;
mod strategies;
mod sweep;
mod table;
mod tables;
mod terminal;
mod terminal_chart;
mod wrap;

pub use animation::{Animation, DrawnTissue, Layer, LiveDrawing, LiveMoment};
pub use answer::answer_of_schemes;
pub use calibration::{calibrated_settings, calibration_object, calibration_text, calibration_toml, run_lengths_text};
pub use columns::ColumnFormat;
pub use comparison::{all_metrics_text, comparison_csv, comparison_text, facts_text, finding_text, row_cells};
pub use detection::{EVENT_COLUMNS, detection_text, event_rows, write_detection};
pub use detections::{DetectionEntry, detections_json, detections_text};
pub use document::write_document;
pub use files::{Folder, OutputError, stream_file, write_file};
pub use json::{comparison_json, detection_object, run_object, schemes_json, summary_json, to_json};
pub use link::{side_object, side_text};
pub use live::live_text;
pub use metrics::{declarations, metrics_markdown, trace_columns_markdown};
pub use paper::{paper_figures, paper_text};
pub use pictures::{
    PictureError, comparison_pictures, detection_pictures, detections_pictures, live_signals, run_pictures, run_png,
    teleoperation_axes, write_figures,
};
pub use roc::{roc_csv, roc_json, roc_picture, roc_text};
pub use schemes::schemes_text;
pub use seeds::{seeds_csv, seeds_text};
pub use signals::{signals_object, signals_text};
pub use stability_figures::stability_figures;
pub use strategies::{strategies_csv, strategies_json, strategies_picture, strategies_text};
pub use sweep::{sweep_json, sweep_pictures, sweep_summary_csv, sweep_text, write_sweep_csv, write_sweep_parquet};
pub use table::Table;
pub use tables::{run_text, write_trace, write_trace_columns, write_trace_csv};
pub use terminal::document_text;
pub use terminal_chart::runs_chart;
pub use wrap::{WIDTH, filled, wrapped};
