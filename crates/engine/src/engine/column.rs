//! A column of a trace: its declaration and its values.

/// Declaration of a column of a trace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TraceColumn {
    /// Name, also in files.
    pub name: &'static str,
    /// Unit; empty for codes.
    pub unit: &'static str,
    /// Meaning, in one sentence.
    pub meaning: &'static str,
}

/// Values of a column, borrowed or owned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ColumnValues<Numbers, Codes> {
    /// Numbers in the column's unit.
    Numbers(Numbers),
    /// Codes, such as modes.
    Codes(Codes),
}
