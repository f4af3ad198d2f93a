//! The units in which quantities are displayed.

use serde::Serialize;

/// The unit in which a quantity is displayed; the value itself is in SI units.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Unit {
    /// Metres, displayed in mm.
    Metre,
    /// Metres per second, displayed in mm/s.
    MetrePerSecond,
    /// Seconds, displayed in ms.
    Second,
    /// Newtons.
    Newton,
    /// Newtons per second.
    NewtonPerSecond,
    /// Newtons per metre.
    NewtonPerMetre,
    /// Joules, displayed in mJ.
    Joule,
    /// A fraction, displayed in %.
    Share,
    /// A plain number: a ratio, an angle in rad, a frequency in Hz.
    Number,
    /// A count.
    Count,
}

impl Unit {
    /// The SI unit of the values; `"1"` for numbers without unit.
    #[must_use]
    pub fn si(self) -> &'static str {
        match self {
            Self::Metre => "m",
            Self::MetrePerSecond => "m/s",
            Self::Second => "s",
            Self::Newton => "N",
            Self::NewtonPerSecond => "N/s",
            Self::NewtonPerMetre => "N/m",
            Self::Joule => "J",
            Self::Share | Self::Number | Self::Count => "1",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::RunMetric;

    #[test]
    fn the_key_of_a_metric_ends_with_its_unit() {
        for metric in RunMetric::all() {
            let name = metric.declaration().name;
            let suffix = match metric.declaration().unit {
                Unit::Metre => "_m",
                Unit::MetrePerSecond => "_m_per_s",
                Unit::Second => "_s",
                Unit::Newton => "_n",
                Unit::NewtonPerSecond => "_n_per_s",
                Unit::NewtonPerMetre => "_n_per_m",
                Unit::Joule => "_j",
                Unit::Share | Unit::Number | Unit::Count => "",
            };
            assert!(name.ends_with(suffix), "{name}");
            let has_unit = ["_m", "_s", "_n", "_j"].iter().any(|unit| name.ends_with(unit));
            assert_eq!(has_unit, !suffix.is_empty(), "{name}");
        }
    }

    #[test]
    fn the_si_unit_is_that_of_the_name() {
        let units = [Unit::Metre, Unit::MetrePerSecond, Unit::Second, Unit::Newton, Unit::NewtonPerSecond];
        assert_eq!(units.map(Unit::si), ["m", "m/s", "s", "N", "N/s"]);
        let units = [Unit::NewtonPerMetre, Unit::Joule, Unit::Share, Unit::Number, Unit::Count];
        assert_eq!(units.map(Unit::si), ["N/m", "J", "1", "1", "1"]);
    }
}
