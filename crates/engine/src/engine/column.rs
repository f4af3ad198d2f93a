//! A column of a trace: its declaration and its values.

/// A column of a trace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TraceColumn {
    /// Its name, also in files.
    pub name: &'static str,
    /// Its unit; empty for codes.
    pub unit: &'static str,
    /// Its meaning, in one sentence.
    pub meaning: &'static str,
}

/// The values of a column, borrowed or owned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ColumnValues<Numbers, Codes> {
    /// Numbers in the column's unit.
    Numbers(Numbers),
    /// Codes, such as modes.
    Codes(Codes),
}
