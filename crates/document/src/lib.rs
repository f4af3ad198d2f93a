//! The result of a study in one form for every surface.
//!
//! Terminal, report, page, JSON, CSV and Python only render a study's [`Document`]: they compute no numbers and write
//! no sentences.
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

#[derive(Debug, Clone, Default)]
pub struct Document<'a> {
    /// `stability` gives `stability.json`.
    pub name: &'static str,
    pub title: String,
    pub verdict: Verdict,
    pub warnings: Vec<Warning>,
    pub sections: Vec<Section>,
    /// By name, in drawing order: `loop` gives `loop.svg`.
    pub figures: Vec<(Cow<'static, str>, Figure<'a>)>,
    pub sketch: Option<Figure<'a>>,
    pub animation: Option<Animation>,
    pub data: Vec<DataTable<'a>>,
    pub files: Vec<TextFile>,
    /// `--json` prints it; an undefined value is `null`.
    pub json: Json,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TextFile {
    pub name: Cow<'static, str>,
    pub text: String,
}

#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Verdict {
    /// One to three, with the numbers that support them.
    pub sentences: Vec<String>,
    pub left_out: Vec<String>,
}

#[derive(Debug, Clone)]
pub struct Section {
    pub id: Cow<'static, str>,
    pub title: Cow<'static, str>,
    pub shown: Shown,
    pub blocks: Vec<Block>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Shown {
    #[default]
    Everywhere,
    InReports,
    /// In reports, and on the terminal only with `--all`.
    WithAll,
    /// A short form of a part of the report.
    OnTerminal,
}

impl Shown {
    pub fn is_on_terminal(self, all: bool) -> bool {
        match self {
            Self::Everywhere | Self::OnTerminal => true,
            Self::WithAll => all,
            Self::InReports => false,
        }
    }
}

#[derive(Debug, Clone)]
pub enum Block {
    Text(String),
    Command(String),
    Table(Table),
    Figures {
        names: Vec<Cow<'static, str>>,
        /// What a page can show of the axis.
        windows: Vec<Window>,
    },
}

#[derive(Debug, Clone, PartialEq)]
pub struct Window {
    pub label: String,
    /// In the coordinate of the axis.
    pub range: (f64, f64),
}

impl<'a> Document<'a> {
    /// Nothing if there is nothing to draw.
    pub fn figure<E>(&mut self, name: impl Into<Cow<'static, str>>, figure: Result<Figure<'a>, E>) {
        self.figures.extend(figure.ok().map(|figure| (name.into(), figure)));
    }
}

impl Section {
    pub fn new(id: impl Into<Cow<'static, str>>, title: impl Into<Cow<'static, str>>) -> Self {
        Self { id: id.into(), title: title.into(), shown: Shown::Everywhere, blocks: vec![] }
    }

    pub fn shown(self, shown: Shown) -> Self {
        Self { shown, ..self }
    }

    /// Nothing if the text is empty.
    pub fn text(&mut self, text: impl Into<String>) {
        let text = text.into();
        if !text.is_empty() {
            self.blocks.push(Block::Text(text));
        }
    }

    pub fn figure(&mut self, name: impl Into<Cow<'static, str>>) {
        self.figures([name.into()], vec![]);
    }

    /// Figures over the same horizontal axis; `windows` are the parts of it that a page can show.
    pub fn figures<N: Into<Cow<'static, str>>>(&mut self, names: impl IntoIterator<Item = N>, windows: Vec<Window>) {
        self.blocks.push(Block::Figures { names: names.into_iter().map(Into::into).collect(), windows });
    }

    pub fn table(&mut self, table: Table) {
        self.blocks.push(Block::Table(table));
    }
}

impl Verdict {
    pub fn text(&self) -> String {
        self.sentences.join(" ")
    }
}

pub trait Study {
    fn document(&self) -> Document<'_>;
}
