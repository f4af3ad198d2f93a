use serde::Serialize;

/// The unit in which a quantity is displayed; the value itself is in SI units.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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

    #[test]
    fn the_si_unit_agrees_with_the_name() {
        let units = [Unit::Metre, Unit::MetrePerSecond, Unit::Second, Unit::Newton, Unit::NewtonPerSecond];
        assert_eq!(units.map(Unit::si), ["m", "m/s", "s", "N", "N/s"]);
        let units = [Unit::NewtonPerMetre, Unit::Joule, Unit::Share, Unit::Number, Unit::Count];
        assert_eq!(units.map(Unit::si), ["N/m", "J", "1", "1", "1"]);
    }
}
