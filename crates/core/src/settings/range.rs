use core::fmt;

use crate::error::{InvalidValue, finite, non_negative, positive, require};

/// Bounds for scenario files; a program's settings need only satisfy [`Range::check`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    low: f64,
    low_is_open: bool,
    high: f64,
    stated: Option<&'static str>,
    meaning: Meaning,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Meaning {
    Finite,
    Positive,
    NonNegative,
    /// Ends the sentence "must be …".
    Within(&'static str),
}

/// Products stay finite, and matrix exponentials keep their digits.
const MAX_MAGNITUDE: f64 = 1e12;

impl Range {
    /// Of magnitude up to 1e12.
    pub const ANY: Self = Self::new(-MAX_MAGNITUDE, MAX_MAGNITUDE, Meaning::Finite);
    /// Above 0.
    pub const POSITIVE: Self = Self::new(1.0 / MAX_MAGNITUDE, MAX_MAGNITUDE, Meaning::Positive);
    /// At least 0.
    pub const NON_NEGATIVE: Self = Self::new(0.0, MAX_MAGNITUDE, Meaning::NonNegative);
    /// In kg; the step is not precise for smaller masses.
    pub const MASS: Self = Self::new(1e-6, 1e6, Meaning::Positive);
    /// A scale between master and slave.
    pub const SCALE: Self = Self::new(0.0, 1e3, Meaning::NonNegative);
    /// In m.
    pub const ENCODER_STEP: Self = Self::new(0.0, 0.01, Meaning::NonNegative);
    /// From 0 to 1.
    pub const SHARE: Self = Self::new(0.0, 1.0, Meaning::Within("from 0 to 1"));
    /// Above 0 and at most 1.
    pub const POSITIVE_SHARE: Self =
        Self { low_is_open: true, ..Self::new(0.0, 1.0, Meaning::Within("above 0 and at most 1")) };
    /// At least 1.
    pub const AT_LEAST_ONE: Self = Self::new(1.0, MAX_MAGNITUDE, Meaning::Within("at least 1"));

    const fn new(low: f64, high: f64, meaning: Meaning) -> Self {
        Self { low, low_is_open: false, high, stated: None, meaning }
    }

    /// Includes both bounds; `stated` ends "must be …".
    #[must_use]
    pub const fn stated(low: f64, high: f64, stated: &'static str) -> Self {
        Self { stated: Some(stated), ..Self::new(low, high, Meaning::Within(stated)) }
    }

    /// The bound, and true if it is excluded.
    #[must_use]
    pub fn low(&self) -> (f64, bool) {
        (self.low, self.low_is_open)
    }

    /// The upper bound.
    #[must_use]
    pub fn high(&self) -> f64 {
        self.high
    }

    /// True within the bounds.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        let above = if self.low_is_open { value > self.low } else { value >= self.low };
        value.is_finite() && above && value <= self.high
    }

    /// Checks a program's setting against the meaning of the range.
    pub fn check(&self, key: &'static str, value: f64) -> Result<(), InvalidValue> {
        match self.meaning {
            Meaning::Finite => finite(key, value),
            Meaning::Positive => positive(key, value),
            Meaning::NonNegative => non_negative(key, value),
            Meaning::Within(requirement) => require(key, value, self.contains(value), requirement),
        }
        .map(drop)
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(stated) = self.stated {
            return write!(f, "a number, {stated}");
        }
        let low = if self.low_is_open { "above" } else { "at least" };
        write!(f, "a number, {low} {} and at most {}", Plain(self.low), Plain(self.high))
    }
}

struct Plain(f64);

impl fmt::Display for Plain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bound = self.0;
        if bound == 0.0 || (1e-3..1e6).contains(&bound.abs()) { write!(f, "{bound}") } else { write!(f, "{bound:e}") }
    }
}
