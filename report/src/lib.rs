//! The output of a run: tables, CSV, JSON, figures, reports and error messages. No other package formats or draws results.

mod calibration;
mod certificate;
mod columns;
mod comparison;
mod detection;
mod detections;
pub mod diagnostic;
pub mod figures;
mod files;
mod finding;
pub mod html;
mod json;
mod live;
mod loop_response;
mod metrics;
mod number;
mod pictures;
mod roc;
mod schemes;
mod seeds;
mod signals;
mod stability;
mod stability_text;
mod sweep;
mod switching;
mod table;
mod tables;
mod terminal_chart;
mod wrap;

pub use calibration::{calibrated_settings, calibration_object, calibration_text, calibration_toml, run_lengths_text};
pub use certificate::certificate_json;
pub use columns::ColumnFormat;
pub use comparison::{all_metrics_text, comparison_csv, comparison_text, facts_text, finding_text, row_cells};
pub use detection::{EVENT_COLUMNS, detection_text, event_rows, write_detection};
pub use detections::{DetectionEntry, detections_json, detections_text};
pub use files::{Folder, OutputError, stream_file, write_file};
pub use json::{comparison_json, detection_object, run_object, schemes_json, summary_json, to_json};
pub use live::live_text;
pub use loop_response::{
    locus_csv, loop_gain_csv, loop_picture, poles_csv, population_csv, population_text, step_csv,
};
pub use metrics::{declarations, metrics_markdown, trace_columns_markdown};
pub use pictures::{PictureError, comparison_pictures, detection_pictures, detections_pictures, run_pictures};
pub use roc::{roc_csv, roc_json, roc_picture, roc_text};
pub use schemes::schemes_text;
pub use seeds::{seeds_csv, seeds_text};
pub use signals::{signals_object, signals_text};
pub use stability::{boundary_csv, map_csv, ports_csv, sensitivities_csv, stability_json, stability_pictures};
pub use stability_text::stability_text;
pub use sweep::{sweep_json, sweep_pictures, sweep_summary_csv, sweep_text, write_sweep_csv, write_sweep_parquet};
pub use switching::{released_csv, switching_csv, switching_picture, switching_text};
pub use table::Table;
pub use tables::{run_text, write_trace, write_trace_csv};
pub use terminal_chart::runs_chart;
pub use wrap::{WIDTH, filled};
