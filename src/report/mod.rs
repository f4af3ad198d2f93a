//! What a run leaves for people and programs to read: tables, CSV, JSON, figures, errors. Only this floor draws or prints.

pub mod diagnostic;
pub mod figures;
mod files;
mod json;
mod number;
mod pictures;
mod roc;
mod seeds;
mod table;
mod tables;

pub use files::{Folder, OutputError, write_file};
pub use json::{comparison_json, detection_json, summary_json};
pub use pictures::{PictureError, comparison_pictures, detection_pictures, run_pictures};
pub use roc::{roc_csv, roc_json, roc_picture, roc_text};
pub use seeds::{seeds_csv, seeds_text};
pub use table::Table;
pub use tables::{
    comparison_csv, comparison_text, detection_text, facts_text, run_text, write_detection_csv, write_trace_csv,
};
