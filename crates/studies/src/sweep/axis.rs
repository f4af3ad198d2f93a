use trocar_base::quantiles::{normal_quantile, normal_share};
use trocar_scenario::{KeyAt, Kind, Place, Value};

#[derive(Debug, Clone, PartialEq)]
pub enum Levels {
    List(Vec<Value>),
    Range {
        from: f64,
        to: f64,
        log: bool,
        /// Number with the ends; `None` if the design determines it.
        points: Option<u64>,
    },
    /// Truncated at three standard deviations of the logarithm.
    LogNormal {
        median: f64,
        /// About 68 % of the values are between `median / spread` and `median · spread`; above 1.
        spread: f64,
    },
}

const MAX_DEVIATIONS: f64 = 3.0;

#[derive(Debug, Clone)]
pub struct Axis {
    pub key: KeyAt,
    pub levels: Levels,
    pub place: Place,
}

impl Axis {
    /// `None` for a range without points.
    pub fn count(&self) -> Option<u64> {
        match &self.levels {
            Levels::List(list) => Some(list.len() as u64),
            Levels::Range { points, .. } => *points,
            Levels::LogNormal { .. } => None,
        }
    }

    /// A level, or an interpolation between the ends, at a coordinate from 0 to below 1.
    pub fn value(&self, coordinate: f64) -> Value {
        let level = |count: u64| ((coordinate * count as f64) as u64).min(count.saturating_sub(1));
        match &self.levels {
            Levels::List(list) => list[level(list.len() as u64) as usize].clone(),
            Levels::Range { from, to, log, points: Some(points) } => {
                let (k, last) = (level(*points), points.saturating_sub(1));
                // The ends are exact.
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
                Value::Whole(((low + coordinate * (high - low + 1.0)) as u64).min(high as u64))
            }
            Levels::Range { from, to, log, points: None } => self.rounded(between(*from, *to, *log, coordinate)),
            Levels::LogNormal { median, spread } => {
                let (low, high) = (normal_share(-MAX_DEVIATIONS), normal_share(MAX_DEVIATIONS));
                let deviations = normal_quantile(low + coordinate * (high - low));
                self.rounded(median * libm::exp(deviations * libm::log(*spread)))
            }
        }
    }

    pub fn first(&self) -> Value {
        self.value(0.0)
    }

    /// Unit coordinates of all values of a list, or of both ends of a range.
    pub fn ends(&self) -> Vec<f64> {
        match &self.levels {
            Levels::List(list) => (0..list.len()).map(|k| (k as f64 + 0.5) / list.len() as f64).collect(),
            Levels::Range { .. } | Levels::LogNormal { .. } => vec![0.0, 1.0 - f64::EPSILON],
        }
    }

    pub fn numbers(&self) -> Vec<f64> {
        let count = self.count().unwrap_or(0);
        (0..count).filter_map(|k| number(&self.value((k as f64 + 0.5) / count as f64))).collect()
    }

    pub fn is_numeric(&self) -> bool {
        matches!(self.key.kind, Kind::Number(_) | Kind::Whole(_) | Kind::Sign)
    }

    pub fn is_log(&self) -> bool {
        matches!(self.levels, Levels::Range { log: true, .. } | Levels::LogNormal { .. })
    }

    fn rounded(&self, number: f64) -> Value {
        match self.key.kind {
            Kind::Whole(_) => Value::Whole(libm::round(number) as u64),
            _ => Value::Number(number),
        }
    }

    pub fn to_toml(&self) -> String {
        match &self.levels {
            Levels::List(list) => toml::Value::Array(list.iter().map(Value::to_toml).collect()).to_string(),
            Levels::Range { from, to, log, points } => {
                let points = points.map_or(String::new(), |points| format!(", points = {points}"));
                let log = if *log { ", log = true" } else { "" };
                let number = |number: f64| toml::Value::Float(number).to_string();
                format!("{{ from = {}, to = {}{points}{log} }}", number(*from), number(*to))
            }
            Levels::LogNormal { median, spread } => {
                let number = |number: f64| toml::Value::Float(number).to_string();
                format!("{{ median = {}, spread = {} }}", number(*median), number(*spread))
            }
        }
    }
}

fn between(from: f64, to: f64, log: bool, coordinate: f64) -> f64 {
    let value = if log { from * libm::exp(coordinate * libm::log(to / from)) } else { from + coordinate * (to - from) };
    value.clamp(from.min(to), from.max(to))
}

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
    use trocar_scenario::find_key;

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
    fn a_distribution_has_its_median_spread_and_ends() {
        let axis = axis("scaling.force", Levels::LogNormal { median: 2.0, spread: 1.5 });
        let at = |coordinate| number(&axis.value(coordinate)).expect("a number");
        assert!((at(0.5) - 2.0).abs() < 1e-9);
        assert!(
            (at(0.0) - 2.0 / 1.5_f64.powi(3)).abs() < 1e-9 && (at(1.0 - 1e-16) - 2.0 * 1.5_f64.powi(3)).abs() < 1e-6
        );
        let within = (0..1000).filter(|k| (2.0 / 1.5..3.0).contains(&at((f64::from(*k) + 0.5) / 1000.0))).count();
        assert!((670..=695).contains(&within), "{within}");
    }

    #[test]
    fn whole_numbers_are_equally_likely() {
        let pushes = axis("operator.pushes", Levels::Range { from: 1.0, to: 3.0, log: false, points: None });
        let count = |wanted| (0..300).filter(|k| pushes.value(f64::from(*k) / 300.0) == Value::Whole(wanted)).count();
        assert_eq!([count(1), count(2), count(3), count(4)], [100, 100, 100, 0]);
    }
}
