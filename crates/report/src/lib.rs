//! Documents as text, pages, JSON, figures and columns. It knows no study: it shows what is in a document.

mod columns;
mod document;
pub mod draw;
mod files;
pub mod html;
mod pictures;
mod sketch;
mod table;
mod terminal;
mod wrap;

pub use columns::{ColumnFormat, Part};
pub use document::write_document;
pub use files::{Folder, OutputError, write_file};
pub use pictures::PictureError;
pub use sketch::sketch;
pub use table::Table;
pub use terminal::document_text;
pub use wrap::{WIDTH, filled, wrapped};
