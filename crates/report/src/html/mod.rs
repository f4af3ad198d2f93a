//! `report.html`: the results of a command on one self-contained page.
//!
//! A page consists of [`page::Section`]s. [`page::Page::render`] inserts them into the template `assets/report.html`,
//! with style, scripts and the descriptions of the figures. A page loads no other file and contains no date and no
//! path, so equal results give equal bytes. All text from scenarios and recordings is escaped.

pub mod assets;
mod document;
mod page;

pub use document::{Again, document_html};
pub use page::HtmlError;
pub use trocar_document::command_line;
