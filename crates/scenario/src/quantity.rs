//! Quantities with their unit: "30ms", "3 mm", "0.5 N/mm".

use trocar_recording::{Column, ColumnError, Quantity, offset_splits};

/// Standard gravity in m/s²: 1 kgf is 9.80665 N.
const GRAVITY: f64 = 9.80665;

/// The size in SI units is `10^decade · 60^sixties · 9.80665^gravities`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Unit {
    /// Exponents of kilogram, metre and second.
    dimensions: [i32; 3],
    decade: i32,
    sixties: i32,
    gravities: i32,
}

impl Unit {
    const fn new(dimensions: [i32; 3], decade: i32, sixties: i32) -> Self {
        Self { dimensions, decade, sixties, gravities: 0 }
    }

    fn times(self, other: Self, power: i32) -> Self {
        Self {
            dimensions: std::array::from_fn(|i| self.dimensions[i] + power * other.dimensions[i]),
            decade: self.decade + power * other.decade,
            sixties: self.sixties + power * other.sixties,
            gravities: self.gravities + power * other.gravities,
        }
    }

    fn parse(text: &str) -> Option<Self> {
        let mut unit = Self::default();
        for (index, factors) in text.split('/').enumerate() {
            let sign = if index == 0 { 1 } else { -1 };
            if index > 0 && factors.trim().is_empty() {
                return None;
            }
            for factor in factors.split([' ', '*', '·']).filter(|factor| !factor.is_empty() && *factor != "1") {
                let (symbol, power) = power(factor);
                unit = unit.times(Self::symbol(symbol)?, sign * power);
            }
        }
        Some(unit)
    }

    fn symbol(symbol: &str) -> Option<Self> {
        let known = |symbol: &str| SYMBOLS.iter().find(|(name, _)| *name == symbol).map(|(_, unit)| *unit);
        known(symbol).or_else(|| {
            let (decade, rest) =
                PREFIXES.iter().find_map(|(prefix, decade)| Some((*decade, symbol.strip_prefix(prefix)?)))?;
            let unit = known(rest).filter(|unit| unit.sixties == 0)?;
            Some(Self { decade: unit.decade + decade, ..unit })
        })
    }
}

const SYMBOLS: [(&str, Unit); 9] = [
    ("m", Unit::new([0, 1, 0], 0, 0)),
    ("s", Unit::new([0, 0, 1], 0, 0)),
    ("min", Unit::new([0, 0, 1], 0, 1)),
    ("g", Unit::new([1, 0, 0], -3, 0)),
    ("N", Unit::new([1, 1, -2], 0, 0)),
    ("gf", Unit { gravities: 1, ..Unit::new([1, 1, -2], -3, 0) }),
    ("J", Unit::new([1, 2, -2], 0, 0)),
    ("W", Unit::new([1, 2, -3], 0, 0)),
    ("Hz", Unit::new([0, 0, -1], 0, 0)),
];

const PREFIXES: [(&str, i32); 8] =
    [("n", -9), ("µ", -6), ("μ", -6), ("u", -6), ("m", -3), ("c", -2), ("k", 3), ("M", 6)];

/// `m²`, `m^2` and `m2` are all the square of a metre.
fn power(factor: &str) -> (&str, i32) {
    for (ending, power) in [("^2", 2), ("²", 2), ("2", 2), ("^3", 3), ("³", 3), ("3", 3)] {
        if let Some(symbol) = factor.strip_suffix(ending) {
            return (symbol, power);
        }
    }
    (factor, 1)
}

/// The unit of a key from the ending of its name: `N/m` for `stiffness_n_per_m`; `None` without one.
pub fn unit_of(path: &str) -> Option<String> {
    let name = path.rsplit('.').next().unwrap_or(path);
    let mut symbols: Vec<&str> = vec![];
    for word in name.split('_').skip(1).collect::<Vec<_>>().into_iter().rev() {
        let symbol = match word {
            "n" => "N",
            "n2" => "N²",
            "j" => "J",
            "hz" => "Hz",
            "m" | "s" | "kg" => word,
            "m2" => "m²",
            "s2" => "s²",
            "per" => "/",
            _ => break,
        };
        symbols.push(symbol);
    }
    symbols.reverse();
    let text = symbols.join("·").replace("·/·", "/").replace("/·", "1/");
    (!text.is_empty()).then_some(text)
}

/// Converts to the key's unit.
pub fn parse(text: &str, unit: &str) -> Result<f64, String> {
    let text = text.trim();
    let is_number = |end: &usize| {
        let number = text[..*end].trim_end();
        number.ends_with(|c: char| c.is_ascii_digit() || c == '.') && number.parse::<f64>().is_ok()
    };
    let ends = (1..=text.len()).rev().filter(|end| text.is_char_boundary(*end));
    let no_number = || format!("write a number, or a number and its unit, as in \"2 {unit}\"");
    let end = ends.into_iter().find(is_number).ok_or_else(no_number)?;
    let (number, written) = (text[..end].trim_end(), text[end..].trim());
    let number: f64 = number.parse().map_err(|_| no_number())?;
    if written.is_empty() {
        return Err(format!("write {number} without quotes, or \"{number} {unit}\""));
    }
    let (quantity, units) = units_of(unit);
    let given =
        Unit::parse(written).ok_or_else(|| format!("{written} is not a known unit of {quantity}; use {units}"))?;
    let si = Unit::parse(unit).unwrap_or_default();
    if given.dimensions != si.dimensions {
        return Err(format!("{written} is not a unit of {quantity}; use {units}"));
    }
    let (decade, sixties, gravities) =
        (given.decade - si.decade, given.sixties - si.sixties, given.gravities - si.gravities);
    let number = if gravities == 0 { number } else { number * GRAVITY.powi(gravities) };
    // Division by a power of ten is exact to the last bit.
    let scaled = if decade < 0 { number / 10f64.powi(-decade) } else { number * 10f64.powi(decade) };
    Ok(scaled * 60f64.powi(sixties))
}

/// The name of the quantity with an SI unit, and its usual units.
fn units_of(unit: &str) -> (&str, String) {
    if let Some(quantity) = Quantity::ALL.into_iter().find(|quantity| quantity.unit() == unit) {
        let name = if quantity == Quantity::Position { "length" } else { quantity.name() };
        return (name, quantity.units().to_owned());
    }
    match unit {
        "kg" => ("mass", "kg or g".into()),
        "N/m" => ("stiffness", "N/m, N/mm or mN/mm".into()),
        "N·s/m" => ("damping", "N·s/m or N·s/mm".into()),
        "Hz" => ("frequency", "Hz, kHz or 1/s".into()),
        "J" => ("energy", "J or mJ".into()),
        _ => ("this quantity", format!("{unit} or a multiple of it")),
    }
}

/// Parses `COLUMN`, `COLUMN:FACTOR`, or a column with its unit, for example `x:mm` if `unit` is `m`; `-mm` also changes
/// the sign. An offset can follow, in `unit` or with a unit, as in `x:-mm+100mm`. Any other text after the colon is
/// part of the name.
pub fn parse_column(text: &str, unit: &str) -> Result<Column, String> {
    let with_unit = text.rsplit_once(':').and_then(|(name, written)| {
        let scale = |written: &str| {
            let (sign, unit_of_file) = written.strip_prefix('-').map_or(("", written), |rest| ("-", rest));
            written.trim().parse().ok().or_else(|| parse(&format!("{sign}1 {unit_of_file}"), unit).ok())
        };
        let shifted =
            || offset_splits(written).find_map(|(of, offset)| Some((scale(of)?, parse_number(offset, unit).ok()?)));
        let (scale, offset) = scale(written).map(|scale| (scale, 0.0)).or_else(shifted)?;
        Some(Column::new(name, scale).and_then(|column: Column| column.with_offset(offset)))
    });
    let with_unit: Option<Result<Column, ColumnError>> = with_unit;
    with_unit.unwrap_or_else(|| text.parse()).map_err(|error| error.to_string())
}

pub fn parse_number(text: &str, unit: &str) -> Result<f64, String> {
    text.trim().parse().or_else(|_| parse(text, unit))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::KEYS;

    #[test]
    fn a_unit_is_converted_to_the_unit_of_the_key() {
        for (text, unit, value) in [
            ("30ms", "s", 0.03),
            ("3 mm", "m", 0.003),
            ("5N", "N", 5.0),
            ("-0.5 N/mm", "N/m", -500.0),
            ("20 mm/s", "m/s", 0.02),
            ("1.5e2 Hz", "Hz", 150.0),
            ("2 kHz", "Hz", 2000.0),
            ("250 g", "kg", 0.25),
            ("4 N·s/m", "N·s/m", 4.0),
            ("4 N*s/mm", "N·s/m", 4000.0),
            ("1 min", "s", 60.0),
            ("12 µm", "m", 12e-6),
            ("250 ns", "s", 250e-9),
            ("3 nN", "N", 3e-9),
            ("3 mN/mm²", "N/m²", 3000.0),
            ("1 kgf", "N", 9.80665),
            ("100 gf", "N", 0.980665),
            ("2 gf/mm", "N/m", 19.6133),
            ("10 1/s", "1/s", 10.0),
        ] {
            assert_eq!(parse(text, unit), Ok(value), "{text}");
        }
    }

    #[test]
    fn an_invalid_quantity_is_rejected_with_the_reason() {
        for (text, phrase) in [
            ("30", "write 30 without quotes"),
            ("ms", "write a number"),
            ("3 mm", "mm is not a unit of time; use s, ms, us, ns or min"),
            ("3 parsec", "parsec is not a known unit of time; use s, ms, us, ns or min"),
            ("inf s", "write a number"),
            ("nan", "write a number"),
            ("3 s/", "not a known unit"),
            ("", "write a number"),
            ("é3", "write a number"),
        ] {
            let error = parse(text, "s").expect_err(text);
            assert!(error.contains(phrase), "{text}: {error}");
        }
    }

    #[test]
    fn every_listed_unit_is_known() {
        for unit in ["s", "m", "m/s", "N", "kg", "N/m", "N·s/m", "Hz", "J"] {
            let (_, units) = units_of(unit);
            for listed in units.replace(" or ", ", ").split(", ") {
                assert!(parse(&format!("1 {listed}"), unit).is_ok(), "{listed}");
            }
        }
    }

    #[test]
    fn the_unit_of_a_key_follows_from_the_ending_of_its_name() {
        for (path, unit) in [
            ("channel.forward_delay_s", Some("s")),
            ("arm.b_a_n_s_per_m", Some("N·s/m")),
            ("arm.m_h_kg", Some("kg")),
            ("tissue.layer.skin.stiffening_n_per_m2", Some("N/m²")),
            ("actuator.slave_command_rate_limit_per_s", Some("1/s")),
            ("tissue.damping_s_per_m", Some("s/m")),
            ("scaling.force", None),
            ("slave.numerator", None),
            ("tissue.mu", None),
        ] {
            assert_eq!(unit_of(path).as_deref(), unit, "{path}");
        }
        let with_unit = KEYS.iter().filter_map(|key| unit_of(key.path));
        assert!(with_unit.clone().count() > 80);
        with_unit.for_each(|unit| assert!(Unit::parse(&unit).is_some(), "{unit}"));
    }
}
