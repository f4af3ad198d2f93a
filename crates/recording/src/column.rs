//! The columns of a file, with their quantities and units.

use std::fmt;
use std::str::FromStr;

/// A column of a file, and the factor that converts its numbers to SI units, with forces positive when they resist
/// insertion.
///
/// Written as `name` (factor 1) or `name:factor`, as in `xs_rad:0.075`. The text after the last `:` is the factor only
/// if it is a number, so `force: raw` is a plain name. A column named `a:1` is written `a:1:1`. Spaces around the name
/// are ignored, here and in the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    name: String,
    scale: f64,
}

impl Column {
    /// Creates a column; its numbers are multiplied by `scale`.
    ///
    /// # Errors
    /// If the name is blank, or the scale is zero or not finite.
    pub fn new(name: &str, scale: f64) -> Result<Self, ColumnError> {
        let name = name.trim();
        if name.is_empty() {
            return Err(ColumnError::NoName);
        }
        if !scale.is_finite() || scale == 0.0 {
            let name = name.to_owned();
            return Err(ColumnError::Scale { name, scale });
        }
        Ok(Self { name: name.to_owned(), scale })
    }

    pub(super) fn plain(name: &'static str) -> Self {
        Self { name: name.to_owned(), scale: 1.0 }
    }

    /// The name in the header, without surrounding spaces; never empty.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// SI units per unit of the file: finite, never zero, and negative if the file has the opposite sign.
    #[must_use]
    pub fn scale(&self) -> f64 {
        self.scale
    }
}

/// Splits a text into the name before the last `:` and the number after it; `None` if that is not a number.
fn split_scale(text: &str) -> Option<(&str, f64)> {
    let (name, tail) = text.rsplit_once(':')?;
    let scale = tail.trim().parse().ok()?;
    Some((name, scale))
}

impl FromStr for Column {
    type Err = ColumnError;

    fn from_str(text: &str) -> Result<Self, ColumnError> {
        let (name, scale) = split_scale(text).unwrap_or((text, 1.0));
        Self::new(name, scale)
    }
}

/// The text that [`FromStr`] reads as the same column.
impl fmt::Display for Column {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.scale == 1.0 && split_scale(&self.name).is_none() {
            f.write_str(&self.name)
        } else {
            write!(f, "{}:{}", self.name, self.scale)
        }
    }
}

/// The columns of a recording's quantities.
#[derive(Clone, Debug, PartialEq)]
pub struct Columns {
    /// Time, scaled to s.
    pub time: Column,
    /// Position of the needle, scaled to m, growing into the tissue.
    pub position: Column,
    /// Velocity of the needle, scaled to m/s, if the file contains it.
    pub velocity: Option<Column>,
    /// Force on the needle, scaled to N, positive when it resists insertion.
    pub force: Column,
}

/// The error of an invalid description of a column.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ColumnError {
    /// The name is empty or consists of spaces.
    #[error("a column needs a name, as in 'force_n' or 'torque_nm:13.3'")]
    NoName,
    /// The factor is zero or not finite.
    #[error("column '{name}' has scale {scale}, must be finite and not 0")]
    Scale {
        /// The column's name.
        name: String,
        /// The factor, as given.
        scale: f64,
    },
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn parsed(text: &str) -> (String, f64) {
        let column: Column = text.parse().expect("a column");
        (column.name, column.scale)
    }

    #[test]
    fn a_scale_is_a_number_after_the_last_colon() {
        assert_eq!(parsed("xs_rad"), ("xs_rad".into(), 1.0));
        assert_eq!(parsed("xs_rad:0.075"), ("xs_rad".into(), 0.075));
        assert_eq!(parsed(" xs_rad : -1e-3 "), ("xs_rad".into(), -1e-3));
        assert_eq!(parsed("force: raw"), ("force: raw".into(), 1.0));
        assert_eq!(parsed("a:b:2"), ("a:b".into(), 2.0));
        assert_eq!(parsed("a:1:1"), ("a:1".into(), 1.0));
        assert_eq!(parsed("a:"), ("a:".into(), 1.0));
    }

    #[test]
    fn useless_columns_are_refused() {
        for text in ["", "  ", ":2", " :2"] {
            assert_eq!(text.parse::<Column>(), Err(ColumnError::NoName), "{text:?}");
        }
        for text in ["x:0", "x:-0.0", "x:inf", "x:NaN", "x:1e999"] {
            let error = text.parse::<Column>().expect_err(text);
            assert!(matches!(error, ColumnError::Scale { .. }), "{text}");
        }
        let error = "x:0".parse::<Column>().expect_err("zero");
        assert_eq!(error.to_string(), "column 'x' has scale 0, must be finite and not 0");
    }

    proptest! {
        #[test]
        fn written_columns_read_back(name in "[a-z:1. ]{1,12}", scale in proptest::num::f64::NORMAL) {
            if let Ok(column) = Column::new(&name, scale) {
                prop_assert_eq!(column.to_string().parse::<Column>(), Ok(column));
            }
            if let Ok(column) = Column::new(&name, 1.0) {
                prop_assert_eq!(column.to_string().parse::<Column>(), Ok(column));
            }
        }
    }
}
