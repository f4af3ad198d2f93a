//! What is known of an operator.

/// Properties of an operator that metrics need.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OperatorTraits {
    /// Slave motion per intended motion of the master; `None` if the intention is unknown: a recorded or live hand.
    pub intended_scale: Option<f64>,
    /// True if the operator can notice a change of the felt force.
    pub notices: bool,
}

impl OperatorTraits {
    /// An operator with unknown properties.
    pub const UNKNOWN: Self = Self { intended_scale: None, notices: false };
}
