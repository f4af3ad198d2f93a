use std::cell::Cell;

use super::error::{Problem, excerpt};

/// Removes surrounding spaces, and quotes after a space, which CSV treats as text.
pub(super) fn trimmed(text: &str) -> &str {
    let text = text.trim();
    let inner = text.strip_prefix('"').and_then(|rest| rest.strip_suffix('"'));
    inner.map_or(text, str::trim)
}

pub(super) fn number(field: &[u8], scale: f64) -> Result<f64, Problem> {
    let text = str::from_utf8(field).map_err(|_| Problem::NotUtf8)?;
    let parsed = text.parse::<f64>().or_else(|_| trimmed(text).parse());
    match parsed.map(|value| value * scale) {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(Problem::NotFinite { text: excerpt(trimmed(text)).into(), scale }),
        Err(_) if trimmed(text).is_empty() => Err(Problem::EmptyField),
        Err(_) if trimmed(text).contains('\n') => Err(Problem::OpenQuote),
        Err(_) => Err(Problem::NotANumber(excerpt(trimmed(text)).into())),
    }
}

/// If commas do not separate fields, it can be the point or the comma. Both in one table are an error, because one of
/// them could separate thousands.
#[derive(Debug)]
pub(super) struct Decimals {
    may_be_comma: bool,
    has_point: Cell<bool>,
    has_comma: Cell<bool>,
}

impl Decimals {
    pub(super) fn new(separator: u8) -> Self {
        Self { may_be_comma: separator != b',', has_point: Cell::new(false), has_comma: Cell::new(false) }
    }

    pub(super) fn number(&self, field: &[u8], scale: f64) -> Result<f64, Problem> {
        if !self.may_be_comma {
            return number(field, scale);
        }
        let (point, comma) = (field.contains(&b'.'), field.contains(&b','));
        if !comma {
            let value = number(field, scale)?;
            self.has_point.set(self.has_point.get() | point);
            return if point && self.has_comma.get() { Err(mixed(field)) } else { Ok(value) };
        }
        let pointed: Vec<u8> = field.iter().map(|&byte| if byte == b',' { b'.' } else { byte }).collect();
        let is_one = !point && field.iter().filter(|byte| **byte == b',').count() == 1;
        let value = if is_one { number(&pointed, scale) } else { number(field, scale) };
        // The message contains the original field.
        let value = value.or_else(|_| number(field, scale))?;
        self.has_comma.set(true);
        if self.has_point.get() { Err(mixed(field)) } else { Ok(value) }
    }
}

fn mixed(field: &[u8]) -> Problem {
    Problem::MixedDecimals(excerpt(trimmed(&String::from_utf8_lossy(field))).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_usual_forms_are_read() {
        let forms = ["1e-3", "+1.0", " -2 ", "\t.5", "1.", "\"3\"", " \" 4 \" ", "1E3"];
        let values = forms.map(|form| number(form.as_bytes(), 1.0).expect(form));
        assert_eq!(values, [1e-3, 1.0, -2.0, 0.5, 1.0, 3.0, 4.0, 1e3]);
        assert_eq!(number(b"2", -0.5).expect("scaled"), -1.0);
    }

    #[test]
    fn errors_name_the_problem() {
        let message = |field: &[u8], scale| number(field, scale).expect_err("refused").to_string();
        assert_eq!(message(b"abc", 1.0), "'abc' is not a number; correct it or remove the row");
        assert_eq!(message(b"0,5", 1.0), "'0,5' is not a number; write decimals with a point");
        for thousands in ["1,234.5", "1.234,5", "1.234.567", "1'234", "1 234", "1\u{202f}234.5", "-1,234.5e3"] {
            let told = message(thousands.as_bytes(), 1.0);
            assert!(told.ends_with("is not a number; write it without thousands separators"), "{told}");
        }
        assert_eq!(message(b"1,2 mm", 1.0), "'1,2 mm' is not a number; write decimals with a point");
        assert_eq!(message(b"NaN", 1.0), "'NaN' is not finite; correct it or remove the row");
        assert_eq!(message(b"-inf", 1.0), "'-inf' is not finite; correct it or remove the row");
        let overflow = "'1e308' is not finite (with scale 100); correct it or remove the row";
        assert_eq!(message(b"1e308", 100.0), overflow);
        assert_eq!(message(b"  ", 1.0), "the field is empty; fill in a number or remove the row");
        assert_eq!(message(b"\xff1", 1.0), "the text is not UTF-8; save the file as CSV in UTF-8");
    }

    #[test]
    fn a_table_has_one_decimal_mark() {
        let commas = Decimals::new(b';');
        assert_eq!(commas.number(b" 1,5e-1 ", 2.0).expect("a number"), 0.3);
        assert_eq!(commas.number(b"-3", 1.0).expect("a number"), -3.0);
        let message = |decimals: &Decimals, field: &[u8]| decimals.number(field, 1.0).expect_err("refused").to_string();
        let mixed =
            "'1.234' and earlier numbers mix decimal points and decimal commas; write all decimals with a point";
        assert_eq!(message(&commas, b"1.234"), mixed);
        assert!(message(&commas, b"1.234,5").starts_with("'1.234,5' is not a number"));
        assert!(message(&commas, b"1,234,5").starts_with("'1,234,5' is not a number"));
        let points = Decimals::new(b'\t');
        assert_eq!(points.number(b"1.5", 1.0).expect("a number"), 1.5);
        assert!(message(&points, b"1,5").contains("mix decimal points"));
        assert!(message(&Decimals::new(b','), b"1,5").ends_with("write decimals with a point"));
    }
}
