use trocar_base::unit::Unit;

pub fn readable(unit: Unit) -> (f64, &'static str) {
    match unit {
        Unit::Metre => (1e3, " mm"),
        Unit::MetrePerSecond => (1e3, " mm/s"),
        Unit::Second => (1e3, " ms"),
        Unit::Newton => (1.0, " N"),
        Unit::NewtonPerSecond => (1.0, " N/s"),
        Unit::NewtonPerMetre => (1.0, " N/m"),
        Unit::Joule => (1e3, " mJ"),
        Unit::Share => (100.0, " %"),
        Unit::Number | Unit::Count => (1.0, ""),
    }
}

/// `—` if it is undefined.
pub fn show(value: Option<f64>, unit: Unit) -> String {
    let (factor, name) = readable(unit);
    match (value, unit) {
        (None, _) => "—".into(),
        (Some(value), Unit::Second) if value >= 1.0 => format!("{} s", significant(value)),
        (Some(value), Unit::Count) => format!("{value}"),
        (Some(value), _) => format!("{}{name}", significant(factor * value)),
    }
}

/// Four significant digits, at most four decimals; very small and large numbers in scientific notation.
pub fn significant(value: f64) -> String {
    let magnitude = value.abs();
    if value == 0.0 {
        "0".into()
    } else if !(5e-5..1e6).contains(&magnitude) {
        format!("{value:.1e}")
    } else {
        format!("{value:.*}", decimals(magnitude, 4))
    }
}

/// Four significant digits, without trailing zeros.
pub fn plain(value: f64) -> String {
    let text = significant(value);
    if !text.contains('.') || text.contains('e') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

pub fn counted(count: u64, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// The shortest form that reads back to the same value.
pub fn shortest(value: f64) -> String {
    ryu::Buffer::new().format(value).to_owned()
}

/// The number of decimals, at most four, for `digits` significant digits of a magnitude.
pub fn decimals(magnitude: f64, digits: usize) -> usize {
    // After rounding: 99.996 has three integer digits if four digits are significant.
    let scientific = format!("{magnitude:.*e}", digits - 1);
    let exponent: i32 = scientific.rsplit('e').next().and_then(|exponent| exponent.parse().ok()).unwrap_or(0);
    (digits as i32 - 1 - exponent).clamp(0, 4) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_significant_digits_are_displayed() {
        let shown = [9.0, 0.0, 123.456, 0.0123456, -5.6732, 1e-12, 15361.0, 99.995].map(significant);
        assert_eq!(shown, ["9.000", "0", "123.5", "0.0123", "-5.673", "1.0e-12", "15361", "100.0"]);
        assert_eq!([500.0, 0.3, 1.0, 1e-7, 1200.0].map(plain), ["500", "0.3", "1", "1.0e-7", "1200"]);
        assert_eq!((counted(1, "case"), counted(2, "case")), ("1 case".into(), "2 cases".into()));
        assert_eq!(show(None, Unit::Metre), "—");
        assert_eq!(show(Some(0.009), Unit::Metre), "9.000 mm");
        assert_eq!(show(Some(0.0), Unit::Second), "0 ms");
    }
}
