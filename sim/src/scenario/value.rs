//! What a key may hold, and whether a value is that.

use toml::Value as Toml;

/// A bounded range of numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    low: f64,
    low_is_open: bool,
    high: f64,
    /// The range and its reason in words, where it has one.
    stated: Option<&'static str>,
}

/// The largest magnitude of a number, and the smallest one of a number that must not be 0: squares and products of such
/// numbers stay finite, and matrix exponentials keep their digits.
const EXTREME: f64 = 1e12;

impl Range {
    /// Any number of a sensible magnitude.
    pub const ANY: Self = Self { low: -EXTREME, low_is_open: false, high: EXTREME, stated: None };
    /// Above 0.
    pub const POSITIVE: Self = Self { low: 1.0 / EXTREME, low_is_open: false, high: EXTREME, stated: None };
    /// At least 0.
    pub const NON_NEGATIVE: Self = Self { low: 0.0, low_is_open: false, high: EXTREME, stated: None };
    /// A mass in kg: lighter ones are beyond the precision of the step.
    pub const MASS: Self = Self { low: 1e-6, low_is_open: false, high: 1e6, stated: None };
    /// A scale between the two sides.
    pub const SCALE: Self = Self { low: 0.0, low_is_open: false, high: 1e3, stated: None };
    /// From 0 to 1.
    pub const SHARE: Self = Self { low: 0.0, low_is_open: false, high: 1.0, stated: None };
    /// Above 0 and at most 1.
    pub const POSITIVE_SHARE: Self = Self { low: 0.0, low_is_open: true, high: 1.0, stated: None };
    /// At least 1.
    pub const AT_LEAST_ONE: Self = Self { low: 1.0, low_is_open: false, high: EXTREME, stated: None };

    /// From `low` to `high`, both allowed, for a reason: `stated` ends the sentence "must be …".
    #[must_use]
    pub const fn stated(low: f64, high: f64, stated: &'static str) -> Self {
        Self { low, low_is_open: false, high, stated: Some(stated) }
    }

    /// The least number, and whether it is itself outside.
    #[must_use]
    pub fn low(&self) -> (f64, bool) {
        (self.low, self.low_is_open)
    }

    /// The greatest number.
    #[must_use]
    pub fn high(&self) -> f64 {
        self.high
    }

    fn contains(&self, value: f64) -> bool {
        let above = if self.low_is_open { value > self.low } else { value >= self.low };
        value.is_finite() && above && value <= self.high
    }

    fn describe(&self) -> String {
        if let Some(stated) = self.stated {
            return format!("a number, {stated}");
        }
        let low = if self.low_is_open { "above" } else { "at least" };
        format!("a number, {low} {} and at most {}", plain(self.low), plain(self.high))
    }
}

/// A bound as people write it.
fn plain(bound: f64) -> String {
    if bound == 0.0 || (1e-3..1e6).contains(&bound.abs()) { format!("{bound}") } else { format!("{bound:e}") }
}

/// What a key holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// A number within a range.
    Number(Range),
    /// A whole number from a least to 2⁶³ - 1.
    Whole(u64),
    /// 1 or -1.
    Sign,
    /// A list of numbers of sensible magnitudes.
    Numbers,
    /// True or false.
    Flag,
    /// One of some words.
    Choice(&'static [&'static str]),
    /// Any text.
    Text,
    /// A file, relative to the scenario's folder, or `builtin:` and a name.
    File,
}

/// What a key was given or has by default.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A number.
    Number(f64),
    /// A whole number.
    Whole(u64),
    /// A list of numbers.
    Numbers(Vec<f64>),
    /// True or false.
    Flag(bool),
    /// A word or any text.
    Text(String),
}

impl Kind {
    /// What the key must hold, as the end of "must be …".
    #[must_use]
    pub fn describe(&self) -> String {
        match self {
            Self::Number(range) => range.describe(),
            Self::Whole(least) => format!("a whole number of at least {least}"),
            Self::Sign => "1 or -1".into(),
            Self::Numbers => "a list of numbers, as in [1.0, 2.5]".into(),
            Self::Flag => "true or false".into(),
            Self::Choice(words) => {
                let quoted: Vec<_> = words.iter().map(|word| format!("\"{word}\"")).collect();
                format!("one of {}", quoted.join(", "))
            }
            Self::Text => "a text, as in \"name\"".into(),
            Self::File => "the path of a file, as in \"insertion.csv\"".into(),
        }
    }

    /// The value of this kind that a TOML value is; `None` if it is none.
    #[must_use]
    pub fn accept(&self, toml: &Toml) -> Option<Value> {
        match self {
            Self::Number(range) => number(toml).filter(|&v| range.contains(v)).map(Value::Number),
            Self::Whole(least) => {
                let whole = toml.as_integer().and_then(|v| u64::try_from(v).ok())?;
                (whole >= *least).then_some(Value::Whole(whole))
            }
            Self::Sign => number(toml).filter(|v| v.abs() == 1.0).map(Value::Number),
            Self::Numbers => {
                let numbers: Option<Vec<f64>> = toml.as_array()?.iter().map(number).collect();
                numbers.filter(|list| list.iter().all(|&v| Range::ANY.contains(v))).map(Value::Numbers)
            }
            Self::Flag => toml.as_bool().map(Value::Flag),
            Self::Choice(words) => {
                let word = toml.as_str()?;
                words.contains(&word).then(|| Value::Text(word.into()))
            }
            Self::Text | Self::File => {
                toml.as_str().filter(|text| !text.is_empty()).map(|text| Value::Text(text.into()))
            }
        }
    }
}

fn number(toml: &Toml) -> Option<f64> {
    toml.as_float().or_else(|| toml.as_integer().map(|v| v as f64))
}

impl Value {
    /// The value as TOML writes it, numbers in the shortest form that reads back the same.
    #[must_use]
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
    fn a_number_is_kept_within_its_range() {
        let accept = |kind: Kind, text: &str| {
            let table: toml::Table = format!("v = {text}").parse().expect("valid");
            kind.accept(&table["v"])
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
