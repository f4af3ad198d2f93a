//! Renders documents as text, pages, JSON, figures and data files. It is independent of the studies.

mod columns;
mod document;
pub mod draw;
mod files;
mod folder;
pub mod html;
mod manifest;
mod pictures;
mod sketch;
mod stage;
mod table;
mod terminal;
mod wrap;

pub use columns::{ColumnFormat, Part};
pub use document::write_document;
pub use files::{OutputError, write_file};
pub use folder::{Destination, Folder};
pub use manifest::{MANIFEST, Manifest};
pub use pictures::PictureError;
pub use sketch::sketch;
pub use stage::discard_all;
pub use table::Table;
pub use terminal::document_text;
pub use wrap::{WIDTH, filled, wrapped};
