use super::error::Problem;
use super::number::trimmed;
use super::{Column, Columns, Quantity};
use trocar_base::names::similarity;

/// The most frequent of `,`, `;` and tab outside quotes; `,` without any.
pub(super) fn separator(header: &[u8]) -> u8 {
    let mut counts = [(b',', 0), (b';', 0), (b'\t', 0)];
    let mut quoted = false;
    for &byte in header {
        quoted ^= byte == b'"';
        if !quoted && let Some((_, count)) = counts.iter_mut().find(|(known, _)| *known == byte) {
            *count += 1;
        }
    }
    // `max_by_key` returns the last of equal elements.
    let most = counts.iter().rev().max_by_key(|(_, count)| *count);
    most.map_or(b',', |&(separator, _)| separator)
}

#[derive(Debug)]
pub(super) struct Layout {
    /// `None` if the times follow from a rate.
    pub(super) time: Option<usize>,
    pub(super) position: usize,
    pub(super) velocity: Option<usize>,
    pub(super) force: usize,
    pub(super) width: usize,
}

impl Layout {
    pub(super) fn locate(names: &[String], columns: &Columns, has_rate: bool) -> Result<Self, Problem> {
        let find = |column, quantity| find(names, column).map_err(|problem| of_quantity(problem, quantity));
        Ok(Self {
            time: if has_rate { None } else { Some(find(&columns.time, Quantity::Time)?) },
            position: find(&columns.position, Quantity::Position)?,
            velocity: columns.velocity.as_ref().map(|column| find(column, Quantity::Velocity)).transpose()?,
            force: find(&columns.force, Quantity::Force)?,
            width: names.len(),
        })
    }
}

/// If the file contains the name before the last `:`, the text after it was meant as a unit.
fn of_quantity(problem: Problem, quantity: Quantity) -> Problem {
    let Problem::MissingColumn { name, available, nearest, .. } = problem else { return problem };
    let with_unit = name.rsplit_once(':').filter(|(column, _)| available.iter().any(|known| known == column.trim()));
    if let Some((_, unit)) = with_unit {
        return Problem::UnknownUnit { unit: unit.trim().into(), quantity };
    }
    Problem::MissingColumn { name, available, nearest, quantity: Some(quantity) }
}

pub(super) fn names<'a>(fields: impl Iterator<Item = &'a [u8]>) -> Result<Vec<String>, Problem> {
    let names: Vec<String> = fields.map(text).collect();
    if names.iter().all(|name| name.parse::<f64>().is_ok()) { Err(Problem::NoHeader) } else { Ok(names) }
}

pub(super) fn text(field: &[u8]) -> String {
    match str::from_utf8(field) {
        Ok(text) => trimmed(text).to_owned(),
        // Latin-1: its bytes are the first code points of Unicode.
        Err(_) => trimmed(&field.iter().copied().map(char::from).collect::<String>()).to_owned(),
    }
}

pub(super) fn numbered(width: usize) -> Vec<String> {
    (1..=width).map(|number| number.to_string()).collect()
}

pub(super) fn find(names: &[String], column: &Column) -> Result<usize, Problem> {
    let wanted = column.name();
    // The % can be given with the name.
    let plain = wanted.strip_prefix('%').map(str::trim).filter(|_| names.iter().all(|name| name != wanted));
    let plain = plain.unwrap_or(wanted);
    let mut found = (0..names.len()).filter(|&index| names[index] == plain);
    match (found.next(), found.count()) {
        (Some(index), 0) => Ok(index),
        (Some(_), others) => Err(Problem::AmbiguousColumn { name: wanted.into(), count: 1 + others }),
        (None, _) => match wanted.parse::<usize>() {
            Ok(number) if (1..=names.len()).contains(&number) => Ok(number - 1),
            _ => Err(Problem::MissingColumn {
                name: wanted.into(),
                available: names.to_vec(),
                nearest: nearest(names, wanted),
                quantity: None,
            }),
        },
    }
}

pub(super) fn nearest(available: &[String], wanted: &str) -> Option<Box<str>> {
    const MIN_SIMILARITY: f64 = 0.8;
    let wanted = wanted.to_lowercase();
    available
        .iter()
        .map(|name| (similarity(&name.to_lowercase(), &wanted), name))
        .filter(|(similarity, _)| *similarity >= MIN_SIMILARITY)
        .max_by(|(a, _), (b, _)| a.total_cmp(b))
        .map(|(_, name)| name.as_str().into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_frequent_separator_outside_quotes_is_used() {
        assert_eq!(separator(b"t,x,f"), b',');
        assert_eq!(separator(b"t;x;f"), b';');
        assert_eq!(separator(b"t\tx\tf"), b'\t');
        assert_eq!(separator(b"t;\"x, y, z\";f"), b';');
        assert_eq!(separator(b"t;x,f"), b',');
        assert_eq!(separator(b"t"), b',');
        assert_eq!(separator(b""), b',');
    }
}
