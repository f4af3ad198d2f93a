#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TraceColumn {
    pub name: &'static str,
    /// Empty for codes.
    pub unit: &'static str,
    pub meaning: &'static str,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ColumnValues<Numbers, Codes> {
    Numbers(Numbers),
    Codes(Codes),
}
