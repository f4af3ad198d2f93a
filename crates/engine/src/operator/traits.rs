//! What is known of an operator.

/// What metrics must know of an operator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OperatorTraits {
    /// Slave motion per intended motion of the master; `None` for a motion without known intention: a recorded or live
    /// hand.
    pub intended_scale: Option<f64>,
    /// Whether the operator can notice a change of the felt force.
    pub notices: bool,
}

impl OperatorTraits {
    /// An operator of whom nothing is known.
    pub const UNKNOWN: Self = Self { intended_scale: None, notices: false };
}
