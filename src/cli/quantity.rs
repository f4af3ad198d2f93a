use trocar_recording::Column;
use trocar_scenario::{parse_column, parse_number};

/// The text may name another unit than `unit`, as in `30ms` for `s`.
pub(super) fn quantity(unit: &'static str) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text| parse_number(text, unit)
}

/// See [`parse_column`].
pub(super) fn column(unit: &'static str) -> impl Fn(&str) -> Result<Column, String> + Clone + Send + Sync + 'static {
    move |text| parse_column(text, unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_has_a_factor_or_a_unit() {
        for (text, unit, name, scale) in [
            ("x", "m", "x", 1.0),
            ("x:1e-3", "m", "x", 1e-3),
            ("x:-1", "N", "x", -1.0),
            ("x:mm", "m", "x", 1e-3),
            ("t (ms):ms", "s", "t (ms)", 1e-3),
            ("v:mm/s", "m/s", "v", 1e-3),
            ("f:kN", "N", "f", 1e3),
            ("f:-cN", "N", "f", -1e-2),
            ("f:kgf", "N", "f", 9.80665),
            ("a:b", "m", "a:b", 1.0),
            ("x:s", "m", "x:s", 1.0),
        ] {
            assert_eq!(column(unit)(text), Ok(Column::new(name, scale).expect("good")), "{text}");
        }
    }

    #[test]
    fn a_number_may_have_a_unit() {
        assert_eq!(quantity("s")("30ms"), Ok(0.03));
        assert_eq!(quantity("m")("-1e-5"), Ok(-1e-5));
        assert!(quantity("m")("3s").is_err());
    }
}
