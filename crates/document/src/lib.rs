//! The result of a study (answer, warnings, tables, figures and data) in one form for every surface.
//!
//! A study returns a [`Document`]. Terminal, report, page, JSON, CSV and Python only render documents: they compute no
//! numbers and write no sentences.

pub mod animation;
mod cell;
mod command;
mod data;
mod digits;
pub mod figure;
mod json;
mod number;
mod table;

pub use animation::Animation;
pub use cell::{Cell, Digits, Number};
pub use command::command_line;
pub use data::{DataColumn, DataTable, Values};
pub use digits::{Few, Fine};
pub use figure::Figure;
pub use json::{json_of, schema_of, to_json};
pub use number::{counted, decimals, plain, readable, shortest, show, significant};
pub use table::{Column, Row, Table};
pub use trocar_base::unit::Unit;

use std::borrow::Cow;

use serde_json::Value as Json;
use trocar_base::warning::Warning;

/// The result of a study.
#[derive(Debug, Clone, Default)]
pub struct Document<'a> {
    /// The stem of the file names: `stability` gives `stability.json`.
    pub name: &'static str,
    /// The subject: a scenario, a recording, a sweep.
    pub title: String,
    /// The answer.
    pub verdict: Verdict,
    /// The warnings in the order of printing.
    pub warnings: Vec<Warning>,
    /// Texts and tables in the order of display.
    pub sections: Vec<Section>,
    /// The figures by name, in drawing order: `loop` gives `loop.svg`.
    pub figures: Vec<(Cow<'static, str>, Figure<'a>)>,
    /// A small figure for a terminal.
    pub sketch: Option<Figure<'a>>,
    /// The animation below the answer on a page.
    pub animation: Option<Animation>,
    /// Long columns, one file for each table.
    pub data: Vec<DataTable<'a>>,
    /// Other files: scenarios, certificates.
    pub files: Vec<TextFile>,
    /// The content of the JSON file, which `--json` prints. An undefined value is `null`.
    pub json: Json,
}

/// A text file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TextFile {
    /// The name.
    pub name: Cow<'static, str>,
    /// The content.
    pub text: String,
}

/// The answer of a study, in one to three sentences.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Verdict {
    /// The sentences, with the numbers that support them.
    pub sentences: Vec<String>,
    /// The limitations of the answer, as further sentences.
    pub left_out: Vec<String>,
}

/// A part of a document under one heading.
#[derive(Debug, Clone)]
pub struct Section {
    /// The anchor of the heading.
    pub id: Cow<'static, str>,
    /// The heading.
    pub title: Cow<'static, str>,
    /// The surfaces that display the section.
    pub shown: Shown,
    /// Texts and tables, from top to bottom.
    pub blocks: Vec<Block>,
}

/// The surfaces that display a section or a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Shown {
    /// On every surface.
    #[default]
    Everywhere,
    /// Only in reports.
    InReports,
    /// In reports, and on the terminal only with `--all`.
    WithAll,
    /// Only on the terminal: a short form of a part of the report.
    OnTerminal,
}

impl Shown {
    /// True if the terminal displays it, with or without `--all`.
    #[must_use]
    pub fn is_on_terminal(self, all: bool) -> bool {
        match self {
            Self::Everywhere | Self::OnTerminal => true,
            Self::WithAll => all,
            Self::InReports => false,
        }
    }
}

/// A part of a section.
#[derive(Debug, Clone)]
pub enum Block {
    /// A paragraph, or a line of a list.
    Text(String),
    /// A command for a shell, on one line.
    Command(String),
    /// A table.
    Table(Table),
    /// Figures over the same horizontal axis, by name.
    Figures {
        /// The names of the figures.
        names: Vec<Cow<'static, str>>,
        /// Parts of the axis that a page can show.
        windows: Vec<Window>,
    },
}

/// A part of a horizontal axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Window {
    /// The label.
    pub label: String,
    /// Start and end in the coordinate of the axis.
    pub range: (f64, f64),
}

impl<'a> Document<'a> {
    /// Adds a figure, unless there is nothing to draw.
    pub fn figure<E>(&mut self, name: impl Into<Cow<'static, str>>, figure: Result<Figure<'a>, E>) {
        self.figures.extend(figure.ok().map(|figure| (name.into(), figure)));
    }
}

impl Section {
    /// Creates a section that is displayed everywhere.
    #[must_use]
    pub fn new(id: impl Into<Cow<'static, str>>, title: impl Into<Cow<'static, str>>) -> Self {
        Self { id: id.into(), title: title.into(), shown: Shown::Everywhere, blocks: vec![] }
    }

    /// Sets the surfaces.
    #[must_use]
    pub fn shown(self, shown: Shown) -> Self {
        Self { shown, ..self }
    }

    /// Adds a paragraph, unless the text is empty.
    pub fn text(&mut self, text: impl Into<String>) {
        let text = text.into();
        if !text.is_empty() {
            self.blocks.push(Block::Text(text));
        }
    }

    /// Adds a figure by its name.
    pub fn figure(&mut self, name: impl Into<Cow<'static, str>>) {
        self.figures([name.into()], vec![]);
    }

    /// Adds figures over the same horizontal axis, and the parts of it that a page can show.
    pub fn figures<N: Into<Cow<'static, str>>>(&mut self, names: impl IntoIterator<Item = N>, windows: Vec<Window>) {
        self.blocks.push(Block::Figures { names: names.into_iter().map(Into::into).collect(), windows });
    }

    /// Adds a table.
    pub fn table(&mut self, table: Table) {
        self.blocks.push(Block::Table(table));
    }
}

impl Verdict {
    /// The answer as one paragraph.
    #[must_use]
    pub fn text(&self) -> String {
        self.sentences.join(" ")
    }
}

/// A study with a document.
pub trait Study {
    /// Returns all that any surface may show of the result.
    fn document(&self) -> Document<'_>;
}
