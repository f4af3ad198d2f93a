//! Errors that name a value out of range and its requirement.

use core::fmt;

use thiserror::Error;

/// A value outside its allowed range.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{name}{} is {value}, must be {requirement}", OfItem(*item))]
pub struct InvalidValue {
    /// Dotted key of a scenario (`slave.velocity_gain`).
    pub name: &'static str,
    /// The rejected value.
    pub value: f64,
    /// Ends the sentence "… must be".
    pub requirement: &'static str,
    /// From 0; the key has a `*` for the item.
    pub item: Option<usize>,
}

impl InvalidValue {
    /// Adds the index of the list item.
    #[must_use]
    pub fn of_item(self, index: usize) -> Self {
        Self { item: Some(index), ..self }
    }
}

struct OfItem(Option<usize>);

impl fmt::Display for OfItem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.map_or(Ok(()), |index| write!(f, " of item {}", index + 1))
    }
}

/// `value` must be finite and above 0.
pub fn positive(name: &'static str, value: f64) -> Result<f64, InvalidValue> {
    require(name, value, value.is_finite() && value > 0.0, "a positive, finite number")
}

/// `value` must be finite and at least 0.
pub fn non_negative(name: &'static str, value: f64) -> Result<f64, InvalidValue> {
    require(name, value, value.is_finite() && value >= 0.0, "a finite number of at least 0")
}

/// `value` must be finite.
pub fn finite(name: &'static str, value: f64) -> Result<f64, InvalidValue> {
    require(name, value, value.is_finite(), "a finite number")
}

/// `holds` must be true.
pub fn require(name: &'static str, value: f64, holds: bool, requirement: &'static str) -> Result<f64, InvalidValue> {
    if holds { Ok(value) } else { Err(InvalidValue { name, value, requirement, item: None }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_message_names_the_key_the_number_and_the_remedy() {
        let error = non_negative("slave.velocity_gain", -2.0).expect_err("negative");
        assert_eq!(error.to_string(), "slave.velocity_gain is -2, must be a finite number of at least 0");
    }

    #[test]
    fn the_message_counts_the_items_of_a_list_from_one() {
        let error = positive("tissue.layer.*.thickness_m", 0.0).expect_err("not positive").of_item(2);
        assert_eq!(error.to_string(), "tissue.layer.*.thickness_m of item 3 is 0, must be a positive, finite number");
    }

    #[test]
    fn nan_and_infinity_are_refused() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(positive("x", value).is_err());
            assert!(non_negative("x", value).is_err());
            assert!(finite("x", value).is_err());
        }
        assert!(positive("x", 0.0).is_err());
        assert_eq!(non_negative("x", 0.0), Ok(0.0));
    }
}
