use super::axis::Axis;
use trocar_document::Values;
use trocar_scenario::{Kind, Value};

#[derive(Debug, Clone, PartialEq)]
pub enum AxisColumn {
    Number(Vec<f64>),
    Whole(Vec<i64>),
    Flag(Vec<bool>),
    /// Words unchanged, lists in TOML.
    Text(Vec<String>),
}

impl AxisColumn {
    pub fn of(axis: &Axis) -> Self {
        match axis.key.kind {
            Kind::Number(_) | Kind::Sign => Self::Number(vec![]),
            Kind::Whole(_) => Self::Whole(vec![]),
            Kind::Flag => Self::Flag(vec![]),
            Kind::Numbers | Kind::Choice(_) | Kind::Text | Kind::File => Self::Text(vec![]),
        }
    }

    /// Ignores values of another type, which cannot occur.
    pub fn push(&mut self, value: &Value) {
        match (self, value) {
            (Self::Number(column), Value::Number(number)) => column.push(*number),
            (Self::Whole(column), Value::Whole(whole)) => column.push(i64::try_from(*whole).unwrap_or(i64::MAX)),
            (Self::Flag(column), Value::Flag(flag)) => column.push(*flag),
            (Self::Text(column), value) => column.push(text(value)),
            _ => {}
        }
    }

    pub(super) fn into_values(self) -> Values<'static> {
        match self {
            Self::Number(column) => Values::Numbers(column.into()),
            Self::Whole(column) => Values::Whole(column.into_iter().map(i64::cast_unsigned).collect()),
            Self::Flag(column) => Values::Switches(column),
            Self::Text(column) => Values::Texts(column.into_iter().map(Into::into).collect()),
        }
    }
}

fn text(value: &Value) -> String {
    match value {
        Value::Text(text) => text.clone(),
        other => other.to_toml().to_string(),
    }
}
