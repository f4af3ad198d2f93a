//! The units of metrics.

use serde::Serialize;

/// The unit in which people read a quantity; the value itself stays in SI.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Unit {
    /// Metres, read in mm.
    Metre,
    /// Metres per second, read in mm/s.
    MetrePerSecond,
    /// Seconds, read in ms.
    Second,
    /// Newtons.
    Newton,
    /// Newtons per second.
    NewtonPerSecond,
    /// Joules, read in mJ.
    Joule,
    /// A share of 1, read in %.
    Share,
    /// A number as it is: a ratio, an angle in rad, a frequency in Hz.
    Number,
    /// A number of things.
    Count,
}

impl Unit {
    /// The SI unit in which values are; `"1"` for numbers without one.
    #[must_use]
    pub fn si(self) -> &'static str {
        match self {
            Self::Metre => "m",
            Self::MetrePerSecond => "m/s",
            Self::Second => "s",
            Self::Newton => "N",
            Self::NewtonPerSecond => "N/s",
            Self::Joule => "J",
            Self::Share | Self::Number | Self::Count => "1",
        }
    }
}
