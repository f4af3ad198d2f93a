//! What an axis was in each of many cases.

use super::axis::Axis;
use crate::scenario::{Kind, Value};

/// The values of an axis, one per case, as the kind of its key is best kept.
#[derive(Debug, Clone, PartialEq)]
pub enum AxisColumn {
    /// Of keys that are numbers, signs included.
    Number(Vec<f64>),
    /// Of keys that are whole numbers.
    Whole(Vec<i64>),
    /// Of keys that are true or false.
    Flag(Vec<bool>),
    /// Of all others: words as they are, lists as TOML writes them.
    Text(Vec<String>),
}

impl AxisColumn {
    /// An empty column for an axis.
    #[must_use]
    pub fn of(axis: &Axis) -> Self {
        match axis.key.kind {
            Kind::Number(_) | Kind::Sign => Self::Number(vec![]),
            Kind::Whole(_) => Self::Whole(vec![]),
            Kind::Flag => Self::Flag(vec![]),
            Kind::Numbers | Kind::Choice(_) | Kind::Text | Kind::File => Self::Text(vec![]),
        }
    }

    /// Adds a value of the axis. One of another kind is passed over; an axis has none.
    pub fn push(&mut self, value: &Value) {
        match (self, value) {
            (Self::Number(column), Value::Number(number)) => column.push(*number),
            (Self::Whole(column), Value::Whole(whole)) => column.push(i64::try_from(*whole).unwrap_or(i64::MAX)),
            (Self::Flag(column), Value::Flag(flag)) => column.push(*flag),
            (Self::Text(column), value) => column.push(text(value)),
            _ => {}
        }
    }

    /// Forgets the values and keeps the room.
    pub fn clear(&mut self) {
        match self {
            Self::Number(column) => column.clear(),
            Self::Whole(column) => column.clear(),
            Self::Flag(column) => column.clear(),
            Self::Text(column) => column.clear(),
        }
    }
}

/// A value as a text column holds it.
#[must_use]
pub fn text(value: &Value) -> String {
    match value {
        Value::Text(text) => text.clone(),
        other => other.to_toml().to_string(),
    }
}
