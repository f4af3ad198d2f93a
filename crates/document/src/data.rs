//! Long columns: traces, maps, rows of sweeps.

use std::borrow::Cow;

/// A data file with columns in SI units.
#[derive(Debug, Clone)]
pub struct DataTable<'a> {
    /// The stem of the file's name: `stability_map` gives `stability_map.csv`.
    pub name: Cow<'static, str>,
    /// The columns, all of the same length.
    pub columns: Vec<DataColumn<'a>>,
    /// True for one row per sample or tick, in numbers and codes, with the time first. Such tables are written in the
    /// requested formats.
    pub is_sampled: bool,
    /// Keys and values for formats that support metadata.
    pub metadata: Vec<(&'static str, String)>,
}

/// A column. Its name ends with the unit.
#[derive(Debug, Clone)]
pub struct DataColumn<'a> {
    /// The name.
    pub name: Cow<'a, str>,
    /// The values.
    pub values: Values<'a>,
}

/// The values of a column. An undefined value is an empty cell in text, otherwise a null.
#[derive(Debug, Clone)]
pub enum Values<'a> {
    /// Numbers.
    Numbers(Cow<'a, [f64]>),
    /// Numbers, some of them undefined.
    Optional(Vec<Option<f64>>),
    /// Whole numbers.
    Whole(Vec<u64>),
    /// Whole numbers, some of them undefined.
    OptionalWhole(Vec<Option<u64>>),
    /// Codes from 0 to 255.
    Codes(Cow<'a, [u8]>),
    /// Flags, 1 or 0 in text, some of them undefined.
    Flags(Vec<Option<bool>>),
    /// Values of a switch, `true` or `false` in text as in a scenario.
    Switches(Vec<bool>),
    /// Texts.
    Texts(Vec<Cow<'a, str>>),
}

impl Values<'_> {
    /// The number of rows.
    #[must_use]
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

    /// True if there are no rows.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl<'a> DataTable<'a> {
    /// Creates a table without columns.
    #[must_use]
    pub fn new(name: impl Into<Cow<'static, str>>) -> Self {
        Self { name: name.into(), columns: vec![], is_sampled: false, metadata: vec![] }
    }

    /// Marks the table as having one row per sample.
    #[must_use]
    pub fn sampled(self) -> Self {
        Self { is_sampled: true, ..self }
    }

    /// Adds a column.
    #[must_use]
    pub fn with(mut self, name: impl Into<Cow<'a, str>>, values: Values<'a>) -> Self {
        self.columns.push(DataColumn { name: name.into(), values });
        self
    }

    /// Adds a column of numbers.
    #[must_use]
    pub fn numbers(self, name: impl Into<Cow<'a, str>>, values: impl IntoIterator<Item = f64>) -> Self {
        self.with(name, Values::Numbers(values.into_iter().collect()))
    }

    /// Adds a column of numbers, some of them undefined.
    #[must_use]
    pub fn optional(self, name: impl Into<Cow<'a, str>>, values: impl IntoIterator<Item = Option<f64>>) -> Self {
        self.with(name, Values::Optional(values.into_iter().collect()))
    }

    /// Adds a column of counts.
    #[must_use]
    pub fn whole(self, name: impl Into<Cow<'a, str>>, values: impl IntoIterator<Item = u64>) -> Self {
        self.with(name, Values::Whole(values.into_iter().collect()))
    }

    /// Adds a column of flags.
    #[must_use]
    pub fn flags(self, name: impl Into<Cow<'a, str>>, values: impl IntoIterator<Item = bool>) -> Self {
        self.with(name, Values::Flags(values.into_iter().map(Some).collect()))
    }

    /// Adds a column of texts.
    #[must_use]
    pub fn texts<T: Into<Cow<'a, str>>>(
        self,
        name: impl Into<Cow<'a, str>>,
        values: impl IntoIterator<Item = T>,
    ) -> Self {
        self.with(name, Values::Texts(values.into_iter().map(Into::into).collect()))
    }

    /// The number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }
}
