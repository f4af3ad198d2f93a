//! What a number may be.

use core::fmt;

use crate::error::{InvalidValue, finite, non_negative, positive, require};

/// A bounded range of numbers.
///
/// A scenario's numbers lie within all of it. Settings that a program makes are held only to the meaning of their range
/// ([`Range::check`]).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    low: f64,
    low_is_open: bool,
    high: f64,
    /// The range and its reason in words, where it has one.
    stated: Option<&'static str>,
    meaning: Meaning,
}

/// What settings that a program makes are held to.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Meaning {
    Finite,
    Positive,
    NonNegative,
    /// All of the range, in words that end the sentence "must be …".
    Within(&'static str),
}

/// The largest magnitude of a number, and the smallest one of a number that must not be 0: squares and products of such
/// numbers stay finite, and matrix exponentials keep their digits.
const EXTREME: f64 = 1e12;

impl Range {
    /// Any number of a sensible magnitude.
    pub const ANY: Self = Self::new(-EXTREME, EXTREME, Meaning::Finite);
    /// Above 0.
    pub const POSITIVE: Self = Self::new(1.0 / EXTREME, EXTREME, Meaning::Positive);
    /// At least 0.
    pub const NON_NEGATIVE: Self = Self::new(0.0, EXTREME, Meaning::NonNegative);
    /// A mass in kg: lighter ones are beyond the precision of the step.
    pub const MASS: Self = Self::new(1e-6, 1e6, Meaning::Positive);
    /// A scale between the two sides.
    pub const SCALE: Self = Self::new(0.0, 1e3, Meaning::NonNegative);
    /// From 0 to 1.
    pub const SHARE: Self = Self::new(0.0, 1.0, Meaning::Within("from 0 to 1"));
    /// Above 0 and at most 1.
    pub const POSITIVE_SHARE: Self =
        Self { low_is_open: true, ..Self::new(0.0, 1.0, Meaning::Within("above 0 and at most 1")) };
    /// At least 1.
    pub const AT_LEAST_ONE: Self = Self::new(1.0, EXTREME, Meaning::Within("at least 1"));

    const fn new(low: f64, high: f64, meaning: Meaning) -> Self {
        Self { low, low_is_open: false, high, stated: None, meaning }
    }

    /// From `low` to `high`, both allowed, for a reason: `stated` ends the sentence "must be …".
    #[must_use]
    pub const fn stated(low: f64, high: f64, stated: &'static str) -> Self {
        Self { stated: Some(stated), ..Self::new(low, high, Meaning::Within(stated)) }
    }

    /// The least number, and whether it is itself outside.
    #[must_use]
    pub fn low(&self) -> (f64, bool) {
        (self.low, self.low_is_open)
    }

    /// The greatest number.
    #[must_use]
    pub fn high(&self) -> f64 {
        self.high
    }

    /// Whether a number lies within it.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        let above = if self.low_is_open { value > self.low } else { value >= self.low };
        value.is_finite() && above && value <= self.high
    }

    /// Checks a setting that a program made.
    ///
    /// # Errors
    /// [`InvalidValue`] naming the key of a number that is not what the range means.
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
    /// The range, as the end of "must be …".
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(stated) = self.stated {
            return write!(f, "a number, {stated}");
        }
        let low = if self.low_is_open { "above" } else { "at least" };
        write!(f, "a number, {low} {} and at most {}", Plain(self.low), Plain(self.high))
    }
}

/// A bound as people write it.
struct Plain(f64);

impl fmt::Display for Plain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bound = self.0;
        if bound == 0.0 || (1e-3..1e6).contains(&bound.abs()) { write!(f, "{bound}") } else { write!(f, "{bound:e}") }
    }
}
