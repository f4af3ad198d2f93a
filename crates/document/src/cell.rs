use std::borrow::Cow;
use std::fmt::{self, Display, Formatter};

use trocar_base::unit::Unit;

use crate::number::{readable, significant};

#[derive(Debug, Clone, PartialEq)]
pub struct Number {
    pub value: f64,
    pub factor: f64,
    /// With a space before it (` mm`); empty for a plain number.
    pub unit: Cow<'static, str>,
    pub digits: Digits,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Digits {
    /// At most four digits after the point.
    Four,
    All,
    Decimals(usize),
    /// A fixed number of digits after the point, with a sign.
    Signed(usize),
}

/// [`Display`] is the same on every surface.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Not measured, not reached or undefined: `—`.
    Undefined,
    Text(String),
    Number(Number),
    Interval(Number, [f64; 2]),
    /// With the half-width of its interval.
    PlusMinus(Number, f64),
    Flag(bool),
}

impl Number {
    pub fn new(value: f64, unit: Unit) -> Self {
        let (factor, name) = readable(unit);
        let (factor, name) = if unit == Unit::Second && value >= 1.0 { (1.0, " s") } else { (factor, name) };
        let digits = if unit == Unit::Count { Digits::All } else { Digits::Four };
        Self { value, factor, unit: name.into(), digits }
    }

    /// With an SI unit such as `N/m`; empty or `1` for a plain number.
    pub fn si(value: f64, unit: impl Into<String>) -> Self {
        let unit = unit.into();
        let unit = if unit.is_empty() || unit == "1" { String::new() } else { format!(" {unit}") };
        Self { value, factor: 1.0, unit: unit.into(), digits: Digits::Four }
    }

    /// From s, displayed in ms.
    pub fn milliseconds(seconds: f64) -> Self {
        Self { factor: 1e3, ..Self::si(seconds, "ms") }
    }

    pub fn digits(self, digits: Digits) -> Self {
        Self { digits, ..self }
    }

    fn bare(&self, value: f64) -> String {
        let value = self.factor * value;
        match self.digits {
            Digits::Four => significant(value),
            Digits::All => format!("{value}"),
            Digits::Decimals(count) => format!("{value:.count$}"),
            Digits::Signed(count) => format!("{value:+.count$}"),
        }
    }
}

impl Cell {
    pub fn of(value: Option<f64>, unit: Unit) -> Self {
        value.map_or(Self::Undefined, |value| Self::Number(Number::new(value, unit)))
    }

    pub fn si(value: Option<f64>, unit: &str) -> Self {
        value.map_or(Self::Undefined, |value| Self::Number(Number::si(value, unit)))
    }

    pub fn count(count: u64) -> Self {
        Self::Number(Number::new(count as f64, Unit::Count))
    }

    pub fn flag(flag: Option<bool>) -> Self {
        flag.map_or(Self::Undefined, Self::Flag)
    }

    pub fn empty() -> Self {
        Self::Text(String::new())
    }

    /// In SI units; `None` unless the cell is a quantity.
    pub fn value(&self) -> Option<f64> {
        match self {
            Self::Number(number) | Self::Interval(number, _) | Self::PlusMinus(number, _) => Some(number.value),
            Self::Undefined | Self::Text(_) | Self::Flag(_) => None,
        }
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<Number> for Cell {
    fn from(number: Number) -> Self {
        Self::Number(number)
    }
}

impl Display for Number {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.bare(self.value), self.unit)
    }
}

impl Display for Cell {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Undefined => f.write_str("—"),
            Self::Text(text) => f.write_str(text),
            Self::Number(number) => number.fmt(f),
            Self::Interval(number, [low, high]) => {
                write!(
                    f,
                    "{} [{}, {}]{}",
                    number.bare(number.value),
                    number.bare(*low),
                    number.bare(*high),
                    number.unit
                )
            }
            Self::PlusMinus(number, half) => {
                write!(f, "{} ± {}{}", number.bare(number.value), number.bare(*half), number.unit)
            }
            Self::Flag(flag) => f.write_str(if *flag { "yes" } else { "no" }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantity_is_displayed_in_its_readable_unit() {
        assert_eq!(Cell::of(Some(0.009), Unit::Metre).to_string(), "9.000 mm");
        assert_eq!(Cell::of(Some(0.0), Unit::Second).to_string(), "0 ms");
        assert_eq!(Cell::of(Some(0.25), Unit::Second).to_string(), "250.0 ms");
        assert_eq!(Cell::of(Some(1.5), Unit::Second).to_string(), "1.500 s");
        assert_eq!(Cell::of(Some(3.0), Unit::Count).to_string(), "3");
        assert_eq!(Cell::si(Some(882.0), "N/m").to_string(), "882.0 N/m");
        assert_eq!(Cell::from(Number::si(0.12345, "").digits(Digits::Signed(2))).to_string(), "+0.12");
    }

    #[test]
    fn an_undefined_value_is_a_dash_without_a_number() {
        assert_eq!(Cell::of(None, Unit::Metre).to_string(), "—");
        assert_eq!(Cell::of(None, Unit::Metre).value(), None);
        assert_eq!(Cell::flag(None).to_string(), "—");
    }

    #[test]
    fn an_interval_has_one_unit_at_its_end() {
        let delay = Number::new(0.003, Unit::Second);
        assert_eq!(Cell::Interval(delay.clone(), [0.002, 0.005]).to_string(), "3.000 [2.000, 5.000] ms");
        assert_eq!(Cell::PlusMinus(delay, 0.001).to_string(), "3.000 ± 1.000 ms");
    }
}
