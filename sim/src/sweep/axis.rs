//! One key of a scenario and the values it takes.

use crate::scenario::{Key, Kind, Place, Value};

/// The values of an axis.
#[derive(Debug, Clone, PartialEq)]
pub enum Levels {
    /// These, in this order.
    List(Vec<Value>),
    /// What lies between two numbers.
    Range {
        /// The first.
        from: f64,
        /// The last.
        to: f64,
        /// Whether equal steps are equal factors.
        log: bool,
        /// How many, ends included; none where the design says.
        points: Option<u64>,
    },
}

/// A key that a sweep varies.
#[derive(Debug, Clone)]
pub struct Axis {
    /// The key.
    pub key: &'static Key,
    /// Its values.
    pub levels: Levels,
    /// Where they are written.
    pub place: Place,
}

impl Axis {
    /// How many distinct values there are; none where any share has its own.
    #[must_use]
    pub fn count(&self) -> Option<u64> {
        match &self.levels {
            Levels::List(list) => Some(list.len() as u64),
            Levels::Range { points, .. } => *points,
        }
    }

    /// The value at a share of the axis, 0 to below 1: of the levels the one that the share falls on, or what lies so far
    /// between the ends.
    #[must_use]
    pub fn value(&self, share: f64) -> Value {
        let level = |count: u64| ((share * count as f64) as u64).min(count.saturating_sub(1));
        match &self.levels {
            Levels::List(list) => list[level(list.len() as u64) as usize].clone(),
            Levels::Range { from, to, log, points: Some(points) } => {
                let (k, last) = (level(*points), points.saturating_sub(1));
                // The ends are what was written, to the last bit.
                if k == 0 {
                    self.rounded(*from)
                } else if k == last {
                    self.rounded(*to)
                } else {
                    self.rounded(between(*from, *to, *log, k as f64 / last as f64))
                }
            }
            Levels::Range { from, to, log: false, points: None } if matches!(self.key.kind, Kind::Whole(_)) => {
                let (low, high) = (from.min(*to), from.max(*to));
                Value::Whole(((low + share * (high - low + 1.0)) as u64).min(high as u64))
            }
            Levels::Range { from, to, log, points: None } => self.rounded(between(*from, *to, *log, share)),
        }
    }

    /// The first value.
    #[must_use]
    pub fn first(&self) -> Value {
        self.value(0.0)
    }

    /// UnitCoordinates of the values between which all others lie: all of a list, both ends of a range.
    #[must_use]
    pub fn ends(&self) -> Vec<f64> {
        match &self.levels {
            Levels::List(list) => (0..list.len()).map(|k| (k as f64 + 0.5) / list.len() as f64).collect(),
            Levels::Range { .. } => vec![0.0, 1.0 - f64::EPSILON],
        }
    }

    /// Its numbers, in their order; none where any share has its own, or they are none.
    #[must_use]
    pub fn numbers(&self) -> Vec<f64> {
        let count = self.count().unwrap_or(0);
        (0..count).filter_map(|k| number(&self.value((k as f64 + 0.5) / count as f64))).collect()
    }

    /// Whether its values are numbers.
    #[must_use]
    pub fn is_numeric(&self) -> bool {
        matches!(self.key.kind, Kind::Number(_) | Kind::Whole(_) | Kind::Sign)
    }

    /// Whether equal steps are equal factors.
    #[must_use]
    pub fn is_log(&self) -> bool {
        matches!(self.levels, Levels::Range { log: true, .. })
    }

    fn rounded(&self, number: f64) -> Value {
        match self.key.kind {
            Kind::Whole(_) => Value::Whole(libm::round(number) as u64),
            _ => Value::Number(number),
        }
    }

    /// The values as a sweep file writes them.
    #[must_use]
    pub fn to_toml(&self) -> String {
        match &self.levels {
            Levels::List(list) => toml::Value::Array(list.iter().map(Value::to_toml).collect()).to_string(),
            Levels::Range { from, to, log, points } => {
                let points = points.map_or(String::new(), |points| format!(", points = {points}"));
                let log = if *log { ", log = true" } else { "" };
                let number = |number: f64| toml::Value::Float(number).to_string();
                format!("{{ from = {}, to = {}{points}{log} }}", number(*from), number(*to))
            }
        }
    }
}

/// What lies a share of the way from one number to another, never beyond either.
fn between(from: f64, to: f64, log: bool, share: f64) -> f64 {
    let value = if log { from * libm::exp(share * libm::log(to / from)) } else { from + share * (to - from) };
    value.clamp(from.min(to), from.max(to))
}

/// A value as a number; a word has none.
#[must_use]
pub fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Number(number) => Some(*number),
        Value::Whole(whole) => Some(*whole as f64),
        Value::Numbers(_) | Value::Flag(_) | Value::Text(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::find_key;

    fn axis(path: &str, levels: Levels) -> Axis {
        let place = Place { file: "".into(), text: "".into(), span: 0..0 };
        Axis { key: find_key(path).expect("a key"), levels, place }
    }

    #[test]
    fn a_range_has_its_ends_and_even_steps() {
        let linear = axis("scaling.force", Levels::Range { from: 0.5, to: 2.0, log: false, points: Some(4) });
        let values: Vec<_> = (0..4).map(|k| linear.value((f64::from(k) + 0.5) / 4.0)).collect();
        assert_eq!(values, [0.5, 1.0, 1.5, 2.0].map(Value::Number));
        let log = axis("detector.threshold", Levels::Range { from: 1e-3, to: 1e-1, log: true, points: Some(3) });
        assert_eq!(log.value(0.0), Value::Number(1e-3));
        assert!(matches!(log.value(0.5), Value::Number(v) if (v / 1e-2 - 1.0).abs() < 1e-15));
        assert_eq!(log.value(0.99), Value::Number(1e-1));
    }

    #[test]
    fn whole_numbers_are_equally_likely() {
        let pushes = axis("operator.pushes", Levels::Range { from: 1.0, to: 3.0, log: false, points: None });
        let count = |wanted| (0..300).filter(|k| pushes.value(f64::from(*k) / 300.0) == Value::Whole(wanted)).count();
        assert_eq!([count(1), count(2), count(3), count(4)], [100, 100, 100, 0]);
    }
}
