//! What a study says: an answer, warnings, tables, figures and data, in one form for every surface.
//!
//! A study returns a [`Document`]. Terminal, report, page, JSON, CSV and Python render documents: they compute no number and word no
//! sentence of their own. This crate knows no study and no renderer.

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

/// What a study says.
#[derive(Debug, Clone, Default)]
pub struct Document<'a> {
    /// The stem of its files: `stability` gives `stability.json`.
    pub name: &'static str,
    /// What was studied: a scenario, a recording, a sweep.
    pub title: String,
    /// The answer.
    pub verdict: Verdict,
    /// The warnings, in the order in which they are printed.
    pub warnings: Vec<Warning>,
    /// Texts and tables, in the order in which they are shown.
    pub sections: Vec<Section>,
    /// The figures by name, in the order in which they are drawn: `loop` gives `loop.svg`.
    pub figures: Vec<(Cow<'static, str>, Figure<'a>)>,
    /// A small figure for a terminal.
    pub sketch: Option<Figure<'a>>,
    /// The animation, which a page plays below the answer.
    pub animation: Option<Animation>,
    /// Long columns, each a file.
    pub data: Vec<DataTable<'a>>,
    /// Other files: scenarios, certificates.
    pub files: Vec<TextFile>,
    /// The content of the JSON file, which `--json` prints. An undefined value is `null`.
    pub json: Json,
}

/// A file of text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TextFile {
    /// Its name.
    pub name: Cow<'static, str>,
    /// Its content.
    pub text: String,
}

/// The answer of a study, in one to three sentences.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Verdict {
    /// The sentences, with the numbers they rest on.
    pub sentences: Vec<String>,
    /// What the answer leaves out, as further sentences.
    pub left_out: Vec<String>,
}

/// A part of a document under one heading.
#[derive(Debug, Clone)]
pub struct Section {
    /// The anchor of its heading.
    pub id: Cow<'static, str>,
    /// Its heading.
    pub title: Cow<'static, str>,
    /// Where it is shown.
    pub shown: Shown,
    /// Texts and tables, from top to bottom.
    pub blocks: Vec<Block>,
}

/// Where a section or a table is shown. Every report has all of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Shown {
    /// On every surface.
    #[default]
    Everywhere,
    /// In reports only.
    InReports,
    /// On the terminal only with `--all`, and in reports.
    WithAll,
    /// On the terminal only: a shorter form of what a report shows in full.
    OnTerminal,
}

impl Shown {
    /// True if the terminal shows it; with `all`, also what it shows on request.
    #[must_use]
    pub fn is_on_terminal(self, all: bool) -> bool {
        match self {
            Self::Everywhere | Self::OnTerminal => true,
            Self::WithAll => all,
            Self::InReports => false,
        }
    }
}

/// A piece of a section.
#[derive(Debug, Clone)]
pub enum Block {
    /// A paragraph, or a line of a list.
    Text(String),
    /// A command that can be pasted into a shell, on one line.
    Command(String),
    /// A table.
    Table(Table),
    /// Figures over the same horizontal axis, by name.
    Figures {
        /// Their names.
        names: Vec<Cow<'static, str>>,
        /// Parts of the axis that a page offers to show.
        windows: Vec<Window>,
    },
}

/// A part of a horizontal axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Window {
    /// What it shows.
    pub label: String,
    /// Its start and end, in the coordinate of the axis.
    pub range: (f64, f64),
}

impl<'a> Document<'a> {
    /// Adds a figure; nothing if there is nothing to draw.
    pub fn figure<E>(&mut self, name: impl Into<Cow<'static, str>>, figure: Result<Figure<'a>, E>) {
        self.figures.extend(figure.ok().map(|figure| (name.into(), figure)));
    }
}

impl Section {
    /// A section that is shown everywhere.
    #[must_use]
    pub fn new(id: impl Into<Cow<'static, str>>, title: impl Into<Cow<'static, str>>) -> Self {
        Self { id: id.into(), title: title.into(), shown: Shown::Everywhere, blocks: vec![] }
    }

    /// The same, shown elsewhere.
    #[must_use]
    pub fn shown(self, shown: Shown) -> Self {
        Self { shown, ..self }
    }

    /// Adds a paragraph; nothing if the text is empty.
    pub fn text(&mut self, text: impl Into<String>) {
        let text = text.into();
        if !text.is_empty() {
            self.blocks.push(Block::Text(text));
        }
    }

    /// Adds the figure of a name.
    pub fn figure(&mut self, name: impl Into<Cow<'static, str>>) {
        self.figures([name.into()], vec![]);
    }

    /// Adds figures over the same horizontal axis, with the parts of it that a page offers to show.
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

/// A study that can say what it found.
pub trait Study {
    /// Everything that any surface shows of it.
    fn document(&self) -> Document<'_>;
}
