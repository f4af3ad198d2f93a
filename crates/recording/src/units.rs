use super::{Column, Quantity};

const SPELLINGS: [(&[&str], &str); 16] = [
    (&["sec", "secs", "second", "seconds", "S", "Sec", "sek", "Sek"], "s"),
    (&["msec", "millisecond", "milliseconds", "msek"], "ms"),
    (&["µs", "μs", "usec", "microsecond", "microseconds"], "us"),
    (&["nsec", "nanosecond", "nanoseconds"], "ns"),
    (&["minute", "minutes", "mins"], "min"),
    (&["metre", "metres", "meter", "meters"], "m"),
    (&["centimetre", "centimetres", "centimeter", "centimeters"], "cm"),
    (&["millimetre", "millimetres", "millimeter", "millimeters", "MM"], "mm"),
    (&["µm", "μm", "micron", "microns", "micrometre", "micrometer"], "um"),
    (&["nanometre", "nanometer", "nanometres", "nanometers"], "nm"),
    (&["newton", "newtons", "Newton", "Newtons"], "N"),
    (&["KN", "kilonewton", "kilonewtons"], "kN"),
    (&["millinewton", "millinewtons"], "mN"),
    (&["µN", "μN"], "uN"),
    (&["g", "gram", "grams", "gr", "grf"], "gf"),
    (&["kg", "kilogram", "kilograms", "kp"], "kgf"),
];

/// Units of other quantities also mark a row of units.
const OTHER: [&str; 13] = ["rad", "deg", "°", "Nm", "N.m", "N·m", "Nmm", "V", "mV", "A", "mA", "%", "°C"];

pub(super) fn accepted(text: &str) -> &str {
    let text = text.trim().trim_matches(['[', ']', '(', ')']).trim();
    SPELLINGS.iter().find(|(spellings, _)| spellings.contains(&text)).map_or(text, |(_, unit)| unit)
}

/// A mass, as a scale displays it, is a force.
pub(super) fn quantity(text: &str) -> Option<Quantity> {
    let unit = accepted(text);
    let has = |quantity: &Quantity| quantity.units().split([',', ' ']).any(|known| known != "or" && known == unit);
    Quantity::ALL.into_iter().find(has).filter(|_| !unit.is_empty())
}

pub(super) fn is_known(text: &str) -> bool {
    quantity(text).is_some() || OTHER.contains(&accepted(text))
}

pub(super) fn in_text(text: &str) -> Option<String> {
    let inside = text.split(['(', '[']).skip(1).filter_map(|rest| rest.split([')', ']', ' ', ',']).next());
    inside.map(str::to_owned).find(|unit| is_known(unit))
}

/// The unit in a name: `x (mm)`, `x [mm]`, `x_mm`, `v_mm_per_s`, `Time/s`.
pub(super) fn of_name(name: &str) -> Option<String> {
    for (open, close) in [('(', ')'), ('[', ']')] {
        let inside = name.trim_end().strip_suffix(close).and_then(|rest| rest.rsplit_once(open));
        if let Some((_, unit)) = inside.filter(|(_, unit)| unit.chars().next().is_some_and(char::is_alphabetic)) {
            return Some(unit.trim().to_owned());
        }
    }
    // No unit is the name of a signal.
    if let Some((_, unit)) = name.rsplit_once('/').filter(|(before, unit)| !before.is_empty() && is_known(unit)) {
        return Some(unit.trim().to_owned());
    }
    // A rate such as rad_s is not in seconds.
    let (base, per) = match name.strip_suffix("_per_s").or_else(|| name.strip_suffix("_s")) {
        Some(rest) => (rest, true),
        None => (name, false),
    };
    let last = |text: &str| text.rsplit_once('_').map(|(_, last)| last.to_owned());
    let lengths = ["m", "cm", "mm", "um", "nm"];
    if per {
        return match last(base) {
            Some(unit) if lengths.contains(&unit.as_str()) => Some(format!("{unit}/s")),
            Some(unit) if ["rad", "deg"].contains(&unit.as_str()) => Some(format!("{unit}/s")),
            _ => Some("s".into()),
        };
    }
    let unit = last(base)?;
    let others = ["ms", "us", "ns", "min", "sec", "N", "kN", "cN", "mN", "uN", "gf", "kgf", "g", "grams", "kg"];
    match unit.as_str() {
        "n" => Some("N".into()),
        "rad" | "deg" | "Nm" | "V" => Some(unit),
        known if lengths.contains(&known) || others.contains(&known) => Some(unit),
        _ => None,
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct IgnoredUnit {
    pub quantity: Quantity,
    pub column: String,
    pub unit: String,
    pub with_unit: String,
}

impl IgnoredUnit {
    /// `None` if factor and unit agree or the unit is of another quantity.
    pub(super) fn of(quantity: Quantity, column: &Column, unit: Option<&str>) -> Option<Self> {
        let unit = unit.map(str::to_owned).or_else(|| of_name(column.name()))?;
        let is_other = self::quantity(&unit) == Some(quantity) && accepted(&unit) != quantity.unit();
        (is_other && column.scale() == 1.0).then(|| Self {
            quantity,
            column: column.name().to_owned(),
            with_unit: format!("{}:{}", column.name(), accepted(&unit)),
            unit,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spellings_have_an_accepted_unit() {
        for (text, unit, of) in [
            ("sec", "s", Some(Quantity::Time)),
            ("(µs)", "us", Some(Quantity::Time)),
            ("[mm]", "mm", Some(Quantity::Position)),
            ("nm", "nm", Some(Quantity::Position)),
            ("µN", "uN", Some(Quantity::Force)),
            ("g", "gf", Some(Quantity::Force)),
            ("Nm", "Nm", None),
            ("", "", None),
        ] {
            assert_eq!((accepted(text), quantity(text)), (unit, of), "{text}");
        }
    }

    #[test]
    fn a_unit_that_the_factor_ignores_is_reported() {
        let ignored = |quantity, column: &str, unit| {
            IgnoredUnit::of(quantity, &column.parse().expect("a column"), unit).map(|ignored| ignored.with_unit)
        };
        assert_eq!(ignored(Quantity::Force, "load_g", None).as_deref(), Some("load_g:gf"));
        assert_eq!(ignored(Quantity::Position, "x", Some("mm")).as_deref(), Some("x:mm"));
        assert_eq!(ignored(Quantity::Force, "load_g:0.0098", None), None);
        assert_eq!(ignored(Quantity::Force, "force_n", None), None);
        assert_eq!(ignored(Quantity::Force, "tau_Nm", None), None);
    }

    #[test]
    fn names_state_units() {
        for (name, unit) in [
            ("load_g", Some("g")),
            ("timestamp_ns", Some("ns")),
            ("Time/sec", Some("sec")),
            ("Load (µN)", Some("µN")),
            ("torque_z", None),
            ("/needle/force", None),
            ("vs_rad_s", Some("rad/s")),
            ("time_s", Some("s")),
        ] {
            assert_eq!(of_name(name).as_deref(), unit, "{name}");
        }
    }
}
