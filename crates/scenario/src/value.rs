use std::borrow::Cow;

use toml::Value as Toml;
use trocar_core::settings::{Constant, Fallback, Key, Kind, Range};

use super::quantity;

/// Written or default.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    Number(f64),
    Whole(u64),
    Numbers(Vec<f64>),
    Flag(bool),
    Text(String),
}

impl From<Constant> for Value {
    fn from(constant: Constant) -> Self {
        match constant {
            Constant::Number(value) => Self::Number(value),
            Constant::Whole(value) => Self::Whole(value),
            Constant::Numbers(list) => Self::Numbers(list.into()),
            Constant::Flag(value) => Self::Flag(value),
            Constant::Text(text) => Self::Text(text.into()),
        }
    }
}

/// For [`Scenario::load_with`](super::Scenario::load_with).
macro_rules! from {
    ($($Type:ty: $value:ident => $converted:expr;)*) => {
        $(impl From<$Type> for Value {
            fn from($value: $Type) -> Self {
                $converted
            }
        })*
    };
}

from! {
    f64: number => Self::Number(number);
    i32: number => u64::try_from(number).map_or(Self::Number(number.into()), Self::Whole);
    u64: number => Self::Whole(number);
    bool: flag => Self::Flag(flag);
    &str: text => Self::Text(text.into());
    String: text => Self::Text(text);
    Vec<f64>: numbers => Self::Numbers(numbers);
}

fn number(toml: &Toml) -> Option<f64> {
    toml.as_float().or_else(|| toml.as_integer().map(|v| v as f64))
}

fn without_unit<'a>(key: &Key, toml: &'a Toml) -> Cow<'a, Toml> {
    let number = |text: &str| Some(Toml::Float(quantity::parse(text, &quantity::unit_of(key.path)?).ok()?));
    let each = |list: &[Toml]| {
        let number = |item: &Toml| item.as_str().map_or_else(|| Some(item.clone()), number);
        list.iter().map(number).collect::<Option<Vec<_>>>().map(Toml::Array)
    };
    let converted = match key.kind {
        Kind::Number(_) => toml.as_str().and_then(number),
        Kind::Numbers => toml.as_array().and_then(|list| each(list)),
        Kind::Whole(_) | Kind::Sign | Kind::Flag | Kind::Choice(_) | Kind::Text | Kind::File => None,
    };
    converted.map_or(Cow::Borrowed(toml), Cow::Owned)
}

impl Value {
    /// With or without a unit; `None` if invalid. An empty text means no value for a text key without a default.
    pub fn of_key(key: &Key, toml: &Toml) -> Option<Self> {
        if matches!((key.kind, key.fallback), (Kind::Text, Fallback::Unset)) && toml.as_str() == Some("") {
            return Some(Self::Text(String::new()));
        }
        Self::accept(&key.kind, &without_unit(key, toml))
    }

    pub fn accept(kind: &Kind, toml: &Toml) -> Option<Self> {
        match kind {
            Kind::Number(range) => number(toml).filter(|&v| range.contains(v)).map(Self::Number),
            Kind::Whole(min) => {
                let whole = toml.as_integer().and_then(|v| u64::try_from(v).ok())?;
                (whole >= *min).then_some(Self::Whole(whole))
            }
            Kind::Sign => number(toml).filter(|v| v.abs() == 1.0).map(Self::Number),
            Kind::Numbers => {
                let numbers: Option<Vec<f64>> = toml.as_array()?.iter().map(number).collect();
                numbers.filter(|list| list.iter().all(|&v| Range::ANY.contains(v))).map(Self::Numbers)
            }
            Kind::Flag => toml.as_bool().map(Self::Flag),
            Kind::Choice(words) => {
                let word = toml.as_str()?;
                words.contains(&word).then(|| Self::Text(word.into()))
            }
            Kind::Text | Kind::File => {
                toml.as_str().filter(|text| !text.is_empty()).map(|text| Self::Text(text.into()))
            }
        }
    }

    /// Numbers have the shortest form that reads back the same.
    pub fn to_toml(&self) -> Toml {
        match self {
            Self::Number(v) => Toml::Float(*v),
            Self::Whole(v) => Toml::Integer(i64::try_from(*v).unwrap_or(i64::MAX)),
            Self::Numbers(list) => Toml::Array(list.iter().copied().map(Toml::Float).collect()),
            Self::Flag(v) => Toml::Boolean(*v),
            Self::Text(v) => Toml::String(v.clone()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_outside_its_range_is_rejected() {
        let accept = |kind: Kind, text: &str| {
            let table: toml::Table = format!("v = {text}").parse().expect("valid");
            Value::accept(&kind, &table["v"])
        };
        assert_eq!(accept(Kind::Number(Range::POSITIVE), "2"), Some(Value::Number(2.0)));
        for text in ["0", "-1.5", "nan", "inf", "\"2\"", "true", "[2]"] {
            assert_eq!(accept(Kind::Number(Range::POSITIVE), text), None, "{text}");
        }
        assert_eq!(accept(Kind::Numbers, "[1, 2.5]"), Some(Value::Numbers(vec![1.0, 2.5])));
        assert_eq!(accept(Kind::Numbers, "[1, nan]"), None);
        assert_eq!(accept(Kind::Whole(0), "-1"), None);
        assert_eq!(accept(Kind::Sign, "-1"), Some(Value::Number(-1.0)));
        assert_eq!(accept(Kind::Choice(&["ramp", "snap"]), "\"ramps\""), None);
    }
}
