//! The output of a run: tables, CSV, JSON, figures, reports and error messages. No other package formats or draws results.

mod animation;
mod columns;
pub mod diagnostic;
mod document;
pub mod draw;
mod files;
pub mod html;
mod json;
mod pictures;
mod sweep_rows;
mod table;
mod terminal;
mod terminal_chart;
mod trace;
mod wrap;

pub use animation::{Animation, DrawnTissue, Layer, LiveDrawing, LiveMoment};
pub use columns::ColumnFormat;
pub use document::{write_document, write_table};
pub use files::{Folder, OutputError, stream_file, write_file};
pub use json::to_json;
pub use pictures::PictureError;
pub use sweep_rows::{write_sweep_csv, write_sweep_parquet};
pub use table::Table;
pub use terminal::document_text;
pub use terminal_chart::runs_chart;
pub use trace::{write_trace, write_trace_columns, write_trace_csv};
pub use wrap::{WIDTH, filled, wrapped};
