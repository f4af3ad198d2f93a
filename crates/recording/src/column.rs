use std::fmt;
use std::str::FromStr;

/// A column of a file, and the factor and the offset that convert its numbers to SI units, with forces positive when
/// they resist insertion: `number · factor + offset`.
///
/// Written as `name` (factor 1), `name:factor`, as in `xs_rad:0.075`, or `name:factor+offset`, as in `z_m:-1+0.1`. The
/// text after the last `:` is the factor only if it is a number, so `force: raw` is a plain name. A column named `a:1`
/// is written `a:1:1`.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    name: String,
    scale: f64,
    offset: f64,
}

impl Column {
    pub fn new(name: &str, scale: f64) -> Result<Self, ColumnError> {
        let name = name.trim();
        if name.is_empty() {
            return Err(ColumnError::NoName);
        }
        if !scale.is_finite() || scale == 0.0 {
            let name = name.to_owned();
            return Err(ColumnError::Scale { name, scale });
        }
        Ok(Self { name: name.to_owned(), scale, offset: 0.0 })
    }

    pub fn with_offset(self, offset: f64) -> Result<Self, ColumnError> {
        if offset.is_finite() {
            Ok(Self { offset, ..self })
        } else {
            Err(ColumnError::Offset { name: self.name, offset })
        }
    }

    pub(super) fn plain(name: &'static str) -> Self {
        Self { name: name.to_owned(), scale: 1.0, offset: 0.0 }
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    /// Finite, never zero, and negative if the file has the opposite sign.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    pub fn offset(&self) -> f64 {
        self.offset
    }

    pub(super) fn convert(&self, number: f64) -> f64 {
        self.shift(number * self.scale)
    }

    /// Adds the offset to a scaled number. Adding 0 would change the sign of -0.
    pub(super) fn shift(&self, scaled: f64) -> f64 {
        if self.offset == 0.0 { scaled } else { scaled + self.offset }
    }
}

/// Splits at the sign of an offset: `-1+0.1` is `-1` and `+0.1`. Signs of the factor and of an exponent do not count.
pub fn offset_splits(text: &str) -> impl Iterator<Item = (&str, &str)> {
    let is_split = |(at, sign): &(usize, char)| *at > 0 && matches!(sign, '+' | '-');
    text.char_indices().filter(is_split).map(|(at, _)| text.split_at(at))
}

fn split_scale(text: &str) -> Option<(&str, f64, f64)> {
    let (name, tail) = text.rsplit_once(':')?;
    let number = |text: &str| text.trim().parse::<f64>().ok();
    if let Some(scale) = number(tail) {
        return Some((name, scale, 0.0));
    }
    offset_splits(tail).find_map(|(scale, offset)| Some((name, number(scale)?, number(offset)?)))
}

impl FromStr for Column {
    type Err = ColumnError;

    fn from_str(text: &str) -> Result<Self, ColumnError> {
        let (name, scale, offset) = split_scale(text).unwrap_or((text, 1.0, 0.0));
        Self::new(name, scale)?.with_offset(offset)
    }
}

impl fmt::Display for Column {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, scale, offset } = self;
        if *offset != 0.0 {
            write!(f, "{name}:{scale}{offset:+}")
        } else if *scale == 1.0 && split_scale(name).is_none() {
            f.write_str(name)
        } else {
            write!(f, "{name}:{scale}")
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct Columns {
    pub time: Column,
    /// Scaled to m, growing into the tissue.
    pub position: Column,
    pub velocity: Option<Column>,
    /// Scaled to N, positive when it resists insertion.
    pub force: Column,
}

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ColumnError {
    #[error("a column needs a name, as in 'force_n' or 'torque_nm:13.3'")]
    NoName,
    #[error("column '{name}' has scale {scale}, must be finite and not 0")]
    Scale { name: String, scale: f64 },
    #[error("column '{name}' has the offset {offset}, must be finite")]
    Offset { name: String, offset: f64 },
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
    fn an_offset_follows_the_factor() {
        let offset = |text: &str| text.parse::<Column>().map(|column| (column.name, column.scale, column.offset));
        assert_eq!(offset("z_m:-1+0.1"), Ok(("z_m".into(), -1.0, 0.1)));
        assert_eq!(offset("z:1e-3-2e-1"), Ok(("z".into(), 1e-3, -0.2)));
        assert_eq!(offset("z:1e-3"), Ok(("z".into(), 1e-3, 0.0)));
        assert_eq!(offset("a-1+2"), Ok(("a-1+2".into(), 1.0, 0.0)));
        assert_eq!("z:-1+0.1".parse::<Column>().expect("a column").convert(0.1), 0.0);
        assert!(matches!("z:1+inf".parse::<Column>(), Err(ColumnError::Offset { .. })));
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
        fn written_columns_read_back(
            name in "[a-z:1. +-]{1,12}",
            scale in proptest::num::f64::NORMAL,
            offset in proptest::num::f64::NORMAL,
        ) {
            if let Ok(column) = Column::new(&name, scale) {
                prop_assert_eq!(column.to_string().parse::<Column>(), Ok(column.clone()));
                let shifted = column.with_offset(offset).expect("finite");
                prop_assert_eq!(shifted.to_string().parse::<Column>(), Ok(shifted));
            }
            if let Ok(column) = Column::new(&name, 1.0) {
                prop_assert_eq!(column.to_string().parse::<Column>(), Ok(column));
            }
        }
    }
}
