//! The numbers of JSON objects as columns, one row per object.

use std::collections::HashMap;

use serde_json::Value as Json;

use super::ros::MAX_ELEMENTS;
use super::topics::Refusal;
use crate::error::Problem;
use crate::room::{Room, check_name};
use crate::stamp::Stamps;

const MAX_NUMBERS: usize = 1024;

#[derive(Debug, Default)]
pub(super) struct JsonColumns {
    pub(super) names: Vec<String>,
    by_name: HashMap<String, usize>,
    pub(super) columns: Vec<Vec<f64>>,
    stamps: Vec<Stamps>,
    rows: usize,
}

impl JsonColumns {
    /// Texts are values only if they are dates.
    pub(super) fn push(&mut self, text: &[u8], room: &Room) -> Result<(), Refusal> {
        let json = serde_json::from_slice(text).map_err(|error| error.to_string())?;
        let row = self.rows;
        // Most objects have the same order.
        let mut expected = 0;
        visit(&json, &mut String::new(), &mut |name, value| {
            let known = match self.names.get(expected) {
                Some(next) if next == name => Some(expected),
                _ => self.by_name.get(name).copied(),
            };
            let date = |stamps: &mut Stamps| match value {
                Leaf::Number(number) => Some(number),
                Leaf::Text(text) => stamps.time_s(text.as_bytes(), Err(Problem::EmptyField), 1.0).ok(),
            };
            let (index, number) = match known {
                Some(index) => (index, date(&mut self.stamps[index])),
                None => {
                    let mut stamps = Stamps::default();
                    let Some(number) = date(&mut stamps) else { return Ok(()) };
                    if self.names.len() == MAX_NUMBERS {
                        return Err(format!("it has more than {MAX_NUMBERS} numbers").into());
                    }
                    room.take(2 * name.len())?;
                    self.by_name.insert(name.to_owned(), self.names.len());
                    self.names.push(name.to_owned());
                    self.columns.push(vec![]);
                    self.stamps.push(stamps);
                    (self.names.len() - 1, Some(number))
                }
            };
            expected = index + 1;
            // Pads for the objects without this number. The last of equal names counts.
            self.columns[index].resize(row, f64::NAN);
            self.columns[index].push(number.unwrap_or(f64::NAN));
            Ok(())
        })?;
        self.rows += 1;
        Ok(())
    }

    pub(super) fn finish(mut self) -> impl Iterator<Item = (String, Vec<f64>, bool)> {
        self.columns.iter_mut().for_each(|column| column.resize(self.rows, f64::NAN));
        let dates: Vec<bool> = self.stamps.iter().map(Stamps::has_dates).collect();
        self.names.into_iter().zip(self.columns).zip(dates).map(|((name, column), dates)| (name, column, dates))
    }
}

enum Leaf<'a> {
    Number(f64),
    Text(&'a str),
}

fn visit<'a>(
    json: &'a Json,
    path: &mut String,
    leaf: &mut impl FnMut(&str, Leaf<'a>) -> Result<(), Refusal>,
) -> Result<(), Refusal> {
    let before = path.len();
    match json {
        Json::Number(value) => leaf(path, Leaf::Number(value.as_f64().unwrap_or(f64::NAN)))?,
        Json::Bool(value) => leaf(path, Leaf::Number(f64::from(u8::from(*value))))?,
        Json::Null => leaf(path, Leaf::Number(f64::NAN))?,
        Json::String(text) => leaf(path, Leaf::Text(text))?,
        Json::Array(elements) if elements.len() > MAX_ELEMENTS => {}
        Json::Array(elements) => {
            for (index, element) in elements.iter().enumerate() {
                path.push_str(&format!("[{index}]"));
                visit(element, path, leaf)?;
                path.truncate(before);
            }
        }
        Json::Object(fields) => {
            for (name, field) in fields {
                check_name(before + 1 + name.len())?;
                if before > 0 {
                    path.push('.');
                }
                path.push_str(name);
                visit(field, path, leaf)?;
                path.truncate(before);
            }
        }
    }
    Ok(())
}
