//! The results of a command on one self-contained page.
//!
//! A page loads no other file and contains no date and no path, so equal results give equal bytes. All text from
//! scenarios and recordings is escaped.

pub mod assets;
mod document;
mod page;

pub use document::{Again, document_html};
pub use page::HtmlError;
pub use trocar_document::command_line;
