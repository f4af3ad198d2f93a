//! Long columns: traces, maps, rows of sweeps.

use std::borrow::Cow;

#[derive(Debug, Clone)]
pub struct DataTable<'a> {
    /// `stability_map` gives `stability_map.csv`.
    pub name: Cow<'static, str>,
    /// All of the same length.
    pub columns: Vec<DataColumn<'a>>,
    /// One row per sample or tick, in numbers and codes, the time first.
    pub is_sampled: bool,
    pub metadata: Vec<(&'static str, String)>,
}

/// The name ends with the unit.
#[derive(Debug, Clone)]
pub struct DataColumn<'a> {
    pub name: Cow<'a, str>,
    pub values: Values<'a>,
}

/// An undefined value is an empty cell in text, otherwise a null.
#[derive(Debug, Clone)]
pub enum Values<'a> {
    Numbers(Cow<'a, [f64]>),
    Optional(Vec<Option<f64>>),
    Whole(Vec<u64>),
    OptionalWhole(Vec<Option<u64>>),
    Codes(Cow<'a, [u8]>),
    /// 1 or 0 in text.
    Flags(Vec<Option<bool>>),
    /// `true` or `false` in text, as in a scenario.
    Switches(Vec<bool>),
    Texts(Vec<Cow<'a, str>>),
}

impl Values<'_> {
    pub fn len(&self) -> usize {
        match self {
            Self::Numbers(values) => values.len(),
            Self::Optional(values) => values.len(),
            Self::Whole(values) => values.len(),
            Self::OptionalWhole(values) => values.len(),
            Self::Codes(values) => values.len(),
            Self::Flags(values) => values.len(),
            Self::Switches(values) => values.len(),
            Self::Texts(values) => values.len(),
        }
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl<'a> DataTable<'a> {
    pub fn new(name: impl Into<Cow<'static, str>>) -> Self {
        Self { name: name.into(), columns: vec![], is_sampled: false, metadata: vec![] }
    }

    pub fn sampled(self) -> Self {
        Self { is_sampled: true, ..self }
    }

    pub fn with(mut self, name: impl Into<Cow<'a, str>>, values: Values<'a>) -> Self {
        self.columns.push(DataColumn { name: name.into(), values });
        self
    }

    pub fn numbers(self, name: impl Into<Cow<'a, str>>, values: impl IntoIterator<Item = f64>) -> Self {
        self.with(name, Values::Numbers(values.into_iter().collect()))
    }

    pub fn optional(self, name: impl Into<Cow<'a, str>>, values: impl IntoIterator<Item = Option<f64>>) -> Self {
        self.with(name, Values::Optional(values.into_iter().collect()))
    }

    pub fn whole(self, name: impl Into<Cow<'a, str>>, values: impl IntoIterator<Item = u64>) -> Self {
        self.with(name, Values::Whole(values.into_iter().collect()))
    }

    pub fn flags(self, name: impl Into<Cow<'a, str>>, values: impl IntoIterator<Item = bool>) -> Self {
        self.with(name, Values::Flags(values.into_iter().map(Some).collect()))
    }

    pub fn texts<T: Into<Cow<'a, str>>>(
        self,
        name: impl Into<Cow<'a, str>>,
        values: impl IntoIterator<Item = T>,
    ) -> Self {
        self.with(name, Values::Texts(values.into_iter().map(Into::into).collect()))
    }

    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }
}
