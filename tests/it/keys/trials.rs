//! The other values that the test gives a key.

use trocar::scenario::{Key, Kind, Value};

use super::scenarios::Scenarios;

/// Returns values of a key other than its present one, in the form of a setting.
pub fn trial_values(key: &Key, now: Option<&Value>, scenarios: &Scenarios) -> Vec<String> {
    if let Some(written) = scenarios.values_of(key.path) {
        return written;
    }
    let candidates: Vec<Value> = match (key.kind, now) {
        (Kind::Number(_), Some(Value::Number(now))) if *now != 0.0 => {
            [1.25 * now, 0.8 * now, 2.0 * now, 0.25 * now, 0.01 * now, 100.0 * now].map(Value::Number).into()
        }
        (Kind::Number(_), _) => [0.01, 1.0, 100.0, 1e-4].map(Value::Number).into(),
        (Kind::Whole(_), Some(Value::Whole(now))) => vec![Value::Whole(now + 1), Value::Whole(now / 2)],
        (Kind::Sign, _) => [1.0, -1.0].map(Value::Number).into(),
        (Kind::Numbers, Some(Value::Numbers(now))) => {
            vec![Value::Numbers(now.iter().map(|number| 1.25 * number).collect())]
        }
        (Kind::Flag, Some(Value::Flag(now))) => vec![Value::Flag(!now)],
        (Kind::Choice(words), _) => words.iter().map(|word| Value::Text((*word).into())).collect(),
        _ => panic!("{} needs values of its own", key.path),
    };
    let is_other = |value: &Value| Some(value) != now && Value::accept(&key.kind, &value.to_toml()).is_some();
    candidates.into_iter().filter(is_other).map(|value| value.to_toml().to_string()).collect()
}
