#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OperatorTraits {
    /// `None` for a recorded hand.
    pub intended_scale: Option<f64>,
    pub notices: bool,
}

impl OperatorTraits {
    pub const UNKNOWN: Self = Self { intended_scale: None, notices: false };
}
