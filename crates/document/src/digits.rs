use serde::{Serialize, Serializer};

/// Of drawn values: a resolution of a hundredth of a pixel.
const SHOWN: i32 = 5;

/// Of times and axis values: a resolution of a millionth of a run.
const EXACT: i32 = 9;

/// Five significant digits; `null` if not finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Few(pub f64);

/// Nine significant digits, for times and axis values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fine(pub f64);

impl Serialize for Few {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        short(self.0, SHOWN, serializer)
    }
}

impl Serialize for Fine {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        short(self.0, EXACT, serializer)
    }
}

fn short<S: Serializer>(value: f64, digits: i32, serializer: S) -> Result<S::Ok, S::Error> {
    match rounded(value, digits) {
        None => serializer.serialize_none(),
        Some(value) if value.fract() == 0.0 && value.abs() < 1e9 => serializer.serialize_i64(value as i64),
        Some(value) => serializer.serialize_f64(value),
    }
}

fn rounded(value: f64, digits: i32) -> Option<f64> {
    if !value.is_finite() {
        return None;
    }
    if value == 0.0 {
        return Some(value);
    }
    // Powers of ten up to 22 are exact, so the result is the nearest number.
    let decimals = digits - 1 - value.abs().log10().floor() as i32;
    let scale = 10_f64.powi(decimals.abs().min(22));
    Some(if decimals >= 0 { (value * scale).round() / scale } else { (value / scale).round() * scale })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_few_and_non_finite_values_are_null() {
        let all = [0.1234567, -12345.678, 0.0, 1e-12, 3.0, f64::NAN, f64::INFINITY, 17.001];
        let text = serde_json::to_string(&all.map(Few)).expect("JSON");
        assert_eq!(text, "[0.12346,-12346,0,1e-12,3,null,null,17.001]");
        assert_eq!(serde_json::to_string(&Fine(16.9999999)).expect("JSON"), "16.9999999");
    }
}
