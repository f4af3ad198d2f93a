//! The values of an axis in many cases.

use super::axis::Axis;
use trocar_scenario::{Kind, Value};

/// The values of an axis, one per case, in the type of its key.
#[derive(Debug, Clone, PartialEq)]
pub enum AxisColumn {
    /// Numbers, including signs.
    Number(Vec<f64>),
    /// Whole numbers.
    Whole(Vec<i64>),
    /// Booleans.
    Flag(Vec<bool>),
    /// All others: words unchanged, lists in TOML.
    Text(Vec<String>),
}

impl AxisColumn {
    /// Returns an empty column for an axis.
    #[must_use]
    pub fn of(axis: &Axis) -> Self {
        match axis.key.kind {
            Kind::Number(_) | Kind::Sign => Self::Number(vec![]),
            Kind::Whole(_) => Self::Whole(vec![]),
            Kind::Flag => Self::Flag(vec![]),
            Kind::Numbers | Kind::Choice(_) | Kind::Text | Kind::File => Self::Text(vec![]),
        }
    }

    /// Appends a value of the axis. Values of another type, which an axis does not have, are ignored.
    pub fn push(&mut self, value: &Value) {
        match (self, value) {
            (Self::Number(column), Value::Number(number)) => column.push(*number),
            (Self::Whole(column), Value::Whole(whole)) => column.push(i64::try_from(*whole).unwrap_or(i64::MAX)),
            (Self::Flag(column), Value::Flag(flag)) => column.push(*flag),
            (Self::Text(column), value) => column.push(text(value)),
            _ => {}
        }
    }

    /// Removes the values and keeps the capacity.
    pub fn clear(&mut self) {
        match self {
            Self::Number(column) => column.clear(),
            Self::Whole(column) => column.clear(),
            Self::Flag(column) => column.clear(),
            Self::Text(column) => column.clear(),
        }
    }
}

/// Returns a value in the form of a text column.
#[must_use]
pub fn text(value: &Value) -> String {
    match value {
        Value::Text(text) => text.clone(),
        other => other.to_toml().to_string(),
    }
}
