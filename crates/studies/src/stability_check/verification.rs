//! The verification of a file `certificate.json`.

use serde::Deserialize;
use std::collections::BTreeMap;

use crate::sweep::sha256;
use nalgebra::DMatrix;
use thiserror::Error;
use trocar_stability::{Certificate, Inequality, Lyapunov, StateMap, StateSpace, Summand};

/// The first characters of a certificate file; its digest follows.
const BEGIN: &str = "{\"sha256\":\"";

/// Characters of a digest.
const DIGITS: usize = 64;

/// The error of a verification.
#[derive(Debug, Error, PartialEq, Eq)]
pub enum VerificationError {
    /// The text is not a certificate file.
    #[error("not a certificate file: {0}")]
    Form(String),
    /// The text is not the one that was written.
    #[error("the file was changed after it was written: its digest differs")]
    Changed,
    /// A certificate does not hold.
    #[error("certificate {name}: {reason}")]
    Unverified {
        /// Name of the certificate.
        name: String,
        /// The part that does not hold.
        reason: String,
    },
}

/// A verified certificate.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Verified {
    /// Name of the certificate in the file.
    pub name: String,
    /// Number of verified conditions.
    pub conditions: u64,
}

#[derive(Deserialize)]
struct File {
    certificates: BTreeMap<String, Option<serde_json::Value>>,
}

#[derive(Deserialize)]
struct Entry {
    dwell_ticks: u64,
    contraction: f64,
    decay: f64,
    spaces: BTreeMap<String, Space>,
    functions: Vec<Function>,
    maps: Vec<Map>,
    inequalities: Vec<Sum>,
    at_events: usize,
}

#[derive(Deserialize)]
struct Space {
    scale: Vec<Vec<f64>>,
}

#[derive(Deserialize)]
struct Function {
    name: String,
    space: String,
    p: Vec<Vec<f64>>,
}

#[derive(Deserialize)]
struct Map {
    name: String,
    from: String,
    to: String,
    matrix: Vec<Vec<f64>>,
}

#[derive(Deserialize)]
struct Sum {
    name: String,
    rows: String,
    powers: Option<(u64, u64)>,
    terms: Vec<Term>,
}

#[derive(Deserialize)]
struct Term {
    factor: f64,
    function: usize,
    maps: Vec<Factor>,
}

#[derive(Deserialize)]
struct Factor {
    map: usize,
    is_power: bool,
}

/// Writes the digest of the text of a JSON object, whose first entry is an empty `sha256`, into this entry.
pub(super) fn with_digest(object: &str) -> String {
    let rest = object.strip_prefix(BEGIN).and_then(|rest| rest.strip_prefix("\",")).unwrap_or(object);
    format!("{BEGIN}{}\",{rest}", sha256(rest.as_bytes()))
}

/// Verifies the text of a file `certificate.json`: that it was not changed, and every inequality of every certificate in
/// interval arithmetic.
///
/// # Errors
/// [`VerificationError`].
pub fn verify(text: &str) -> Result<Vec<Verified>, VerificationError> {
    let form = |reason: &str| VerificationError::Form(reason.to_owned());
    let after = text.strip_prefix(BEGIN).ok_or_else(|| form("it does not begin with a digest"))?;
    let (stated, rest) = after.split_at_checked(DIGITS).ok_or_else(|| form("it ends in its digest"))?;
    let rest = rest.strip_prefix("\",").ok_or_else(|| form("its digest does not end"))?;
    if sha256(rest.as_bytes()) != stated {
        return Err(VerificationError::Changed);
    }
    let file: File = serde_json::from_str(text).map_err(|error| VerificationError::Form(error.to_string()))?;
    let certificates = file.certificates.into_iter().filter_map(|(name, content)| Some((name, content?)));
    let mut all = vec![];
    for (name, content) in certificates {
        let entry: Entry =
            serde_json::from_value(content).map_err(|error| VerificationError::Form(error.to_string()))?;
        let unverified = |reason: String| VerificationError::Unverified { name: name.clone(), reason };
        let conditions = entry.certificate().map_err(unverified)?.verify().map_err(unverified)?;
        all.push(Verified { name, conditions });
    }
    if all.is_empty() { Err(form("it has no certificate with inequalities")) } else { Ok(all) }
}

fn matrix(rows: &[Vec<f64>]) -> Result<DMatrix<f64>, String> {
    let columns = rows.first().map_or(0, Vec::len);
    if rows.iter().any(|row| row.len() != columns) {
        return Err("the rows of a matrix have different lengths".to_owned());
    }
    Ok(DMatrix::from_fn(rows.len(), columns, |i, j| rows[i][j]))
}

impl Entry {
    fn certificate(self) -> Result<Certificate, String> {
        let names: Vec<String> = self.spaces.keys().cloned().collect();
        let place = |name: &String| {
            names.iter().position(|known| known == name).ok_or_else(|| format!("the space {name} is not defined"))
        };
        let space = |(name, space): (&String, &Space)| -> Result<StateSpace, String> {
            Ok(StateSpace { name: name.clone(), states: vec![], scale: matrix(&space.scale)? })
        };
        let function = |one: &Function| -> Result<Lyapunov, String> {
            Ok(Lyapunov { name: one.name.clone(), matrix: matrix(&one.p)?, space: place(&one.space)? })
        };
        let map = |one: &Map| -> Result<StateMap, String> {
            let (from, to) = (place(&one.from)?, place(&one.to)?);
            Ok(StateMap { name: one.name.clone(), from, to, matrix: matrix(&one.matrix)? })
        };
        let summand = |term: &Term| Summand {
            factor: term.factor,
            function: term.function,
            maps: term.maps.iter().map(|factor| (factor.map, factor.is_power)).collect(),
        };
        let inequality = |one: &Sum| -> Result<Inequality, String> {
            let terms = one.terms.iter().map(summand).collect();
            Ok(Inequality { name: one.name.clone(), rows: place(&one.rows)?, powers: one.powers, terms })
        };
        Ok(Certificate {
            dwell_ticks: self.dwell_ticks,
            contraction: self.contraction,
            decay: self.decay,
            margin: 0.0,
            conditions: 0,
            at_events: self.at_events,
            spaces: self.spaces.iter().map(space).collect::<Result<_, _>>()?,
            functions: self.functions.iter().map(function).collect::<Result<_, _>>()?,
            maps: self.maps.iter().map(map).collect::<Result<_, _>>()?,
            inequalities: self.inequalities.iter().map(inequality).collect::<Result<_, _>>()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `V = p x²` with `x_{k+1} = 0.5 x_k`: `p - 0.25 p > 0` holds.
    fn file(p: f64, factor: f64) -> String {
        let object = format!(
            "{{\"sha256\":\"\",\"certificates\":{{\"statement\":{{\"dwell_ticks\":1,\"contraction\":1.0,\"decay\":1.0,\"at_events\":0,\
             \"spaces\":{{\"X\":{{\"scale\":[[1.0]]}}}},\"functions\":[{{\"name\":\"v\",\"space\":\"X\",\"p\":[[{p}]]}}],\
             \"maps\":[{{\"name\":\"one\",\"from\":\"X\",\"to\":\"X\",\"matrix\":[[1.0]]}},\
             {{\"name\":\"a\",\"from\":\"X\",\"to\":\"X\",\"matrix\":[[0.5]]}}],\
             \"inequalities\":[{{\"name\":\"decays\",\"rows\":\"X\",\"powers\":[1,3],\"terms\":[\
             {{\"factor\":{factor},\"function\":0,\"maps\":[{{\"map\":0,\"is_power\":false}}]}},\
             {{\"factor\":-1.0,\"function\":0,\"maps\":[{{\"map\":1,\"is_power\":true}}]}}]}}]}}}}}}"
        );
        with_digest(&object)
    }

    #[test]
    fn a_certificate_that_holds_is_verified_for_every_power() {
        assert_eq!(verify(&file(2.0, 1.0)), Ok(vec![Verified { name: "statement".into(), conditions: 3 }]));
    }

    #[test]
    fn a_certificate_that_does_not_hold_is_refused_even_with_a_digest_that_fits() {
        for (p, factor) in [(-2.0, 1.0), (2.0, 0.2), (2.0, 0.25), (f64::MAX, 1.0)] {
            assert!(matches!(verify(&file(p, factor)), Err(VerificationError::Unverified { .. })), "{p} {factor}");
        }
    }

    #[test]
    fn one_changed_digit_is_found_anywhere_in_the_file() {
        let text = file(2.125, 1.0);
        for (at, digit) in text.char_indices().filter(|(_, letter)| letter.is_ascii_digit()) {
            let other = if digit == '9' { '8' } else { char::from(digit as u8 + 1) };
            let mut changed = text.clone();
            changed.replace_range(at..=at, &other.to_string());
            assert!(verify(&changed).is_err(), "{changed}");
        }
    }

    #[test]
    fn a_file_with_another_content_is_named_as_such() {
        for text in
            ["", "{}", "{\"sha256\":\"12", &with_digest("{}"), &with_digest("{\"sha256\":\"\",\"certificates\":{}}")]
        {
            assert!(matches!(verify(text), Err(VerificationError::Form(_))), "{text}");
        }
        // Indices and names that do not exist.
        for (part, other) in
            [("\"map\":1", "\"map\":9"), ("\"rows\":\"X\"", "\"rows\":\"Y\""), ("[[1.0]]", "[[1.0,2.0]]")]
        {
            let text = file(2.0, 1.0).replace(part, other);
            let text = with_digest(&format!("{BEGIN}\",{}", &text[BEGIN.len() + DIGITS + 2..]));
            assert!(matches!(verify(&text), Err(VerificationError::Unverified { .. })), "{other}");
        }
    }
}
