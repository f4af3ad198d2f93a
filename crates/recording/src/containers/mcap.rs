//! MCAP logs with messages of ROS 1, ROS 2 or JSON: a signal `/topic.field` per number of a message, and
//! `/topic.log_time` in seconds since the first message of the file.
//!
//! Unreadable messages, such as Protocol Buffers, are omitted. The file is rejected if no signal remains.

use mcap::{McapError, Message, MessageStream};
use serde_json::Value as Json;

use super::ros::{Decoder, Definition, Encoding, MAX_ELEMENTS};
use super::{Array, Container, Fault, Format};
use crate::Limits;
use crate::error::Problem;

pub(super) struct Mcap {
    arrays: Vec<Array>,
    columns: Vec<Vec<f64>>,
}

struct Topic {
    channel: u16,
    name: String,
    log_time_s: Vec<f64>,
    kind: Kind,
    columns: Vec<Vec<f64>>,
}

enum Kind {
    Ros {
        decoder: Decoder,
        row: Vec<f64>,
    },
    Json(Vec<String>),
    /// The reason why the messages are not read.
    LeftOut(String),
}

impl Kind {
    fn of(message: &Message<'_>) -> Self {
        let channel = &message.channel;
        let schema = channel.schema.as_ref();
        let definition = |encoding| {
            let Some(schema) = schema else { return Err("its schema is missing".to_owned()) };
            let text = std::str::from_utf8(&schema.data).map_err(|_| "its schema is no text")?;
            Definition::parse(encoding, &schema.name, text)
        };
        let known = match (channel.message_encoding.as_str(), schema.map(|schema| schema.encoding.as_str())) {
            ("cdr", Some("ros2msg")) => definition(Encoding::Cdr),
            ("ros1", Some("ros1msg")) => definition(Encoding::Ros1),
            ("json", _) => return Self::Json(vec![]),
            (encoding, schema) => {
                let schema = schema.map_or(String::new(), |schema| format!(" with a schema in '{schema}'"));
                Err(format!(
                    "its messages are in '{encoding}'{schema}; those of ROS (ros2msg, ros1msg) and JSON are read"
                ))
            }
        };
        known.map_or_else(Self::LeftOut, |definition| Self::Ros { decoder: Decoder::new(definition), row: vec![] })
    }
}

impl Topic {
    fn push(&mut self, data: &[u8]) -> Result<(), String> {
        match &mut self.kind {
            Kind::Ros { decoder, row } => {
                row.clear();
                decoder.decode(data, row)?;
                self.columns.resize_with(row.len(), Vec::new);
                for (column, value) in self.columns.iter_mut().zip(row) {
                    column.push(*value);
                }
            }
            Kind::Json(names) => {
                let json = serde_json::from_slice(data).map_err(|error| format!("a message is no JSON: {error}"))?;
                let row = self.log_time_s.len();
                numbers(&json, &mut String::new(), &mut |name, value| {
                    let index = names.iter().position(|known| known == name).unwrap_or_else(|| {
                        if names.len() < MAX_NUMBERS {
                            names.push(name.to_owned());
                            self.columns.push(vec![]);
                        }
                        names.len() - 1
                    });
                    // Pads for the messages without this number.
                    self.columns[index].resize(row, f64::NAN);
                    self.columns[index].push(value);
                });
                if names.len() == MAX_NUMBERS {
                    return Err(format!("its messages have {MAX_NUMBERS} numbers or more"));
                }
            }
            Kind::LeftOut(_) => {}
        }
        Ok(())
    }

    fn names(&self) -> &[String] {
        match &self.kind {
            Kind::Ros { decoder, .. } => decoder.names(),
            Kind::Json(names) => names,
            Kind::LeftOut(_) => &[],
        }
    }
}

/// Maximum number of values in the JSON messages of a topic.
const MAX_NUMBERS: usize = 1024;

/// Visits the numbers and Booleans of a JSON message, with their paths.
fn numbers(json: &Json, path: &mut String, number: &mut impl FnMut(&str, f64)) {
    let before = path.len();
    match json {
        Json::Number(value) => number(path, value.as_f64().unwrap_or(f64::NAN)),
        Json::Bool(value) => number(path, f64::from(u8::from(*value))),
        Json::Null => number(path, f64::NAN),
        Json::String(_) => {}
        Json::Array(elements) if elements.len() > MAX_ELEMENTS => {}
        Json::Array(elements) => {
            for (index, element) in elements.iter().enumerate() {
                path.push_str(&format!("[{index}]"));
                numbers(element, path, number);
                path.truncate(before);
            }
        }
        Json::Object(fields) => {
            for (name, field) in fields {
                if before > 0 {
                    path.push('.');
                }
                path.push_str(name);
                numbers(field, path, number);
                path.truncate(before);
            }
        }
    }
}

fn damaged(error: McapError) -> Problem {
    match error {
        McapError::UnsupportedCompression(name) => Format::Mcap.damaged(format_args!(
            "its chunks are compressed by '{name}'; `mcap compress --compression none` writes it without"
        )),
        other => Format::Mcap.damaged(other),
    }
}

impl Mcap {
    pub(super) fn open(bytes: &[u8], limits: &Limits) -> Result<Self, Problem> {
        let mut topics: Vec<Topic> = vec![];
        let (mut start, mut count) = (None, 0_u64);
        for message in MessageStream::new(bytes).map_err(damaged)? {
            let message = message.map_err(damaged)?;
            let origin = *start.get_or_insert(message.log_time);
            let known = topics.iter().position(|topic| topic.channel == message.channel.id);
            let index = known.unwrap_or_else(|| {
                topics.push(Topic {
                    channel: message.channel.id,
                    name: message.channel.topic.clone(),
                    log_time_s: vec![],
                    kind: Kind::of(&message),
                    columns: vec![],
                });
                topics.len() - 1
            });
            let topic = &mut topics[index];
            if matches!(topic.kind, Kind::LeftOut(_)) {
                continue;
            }
            if topic.log_time_s.len() >= limits.max_samples {
                return Err(Problem::TooManySamples { limit: limits.max_samples });
            }
            if let Err(reason) = topic.push(&message.data) {
                topic.kind = Kind::LeftOut(reason);
                topic.columns = vec![];
                continue;
            }
            topic.log_time_s.push(1e-9 * (i128::from(message.log_time) - i128::from(origin)) as f64);
            count += 8 * (1 + topic.columns.len() as u64);
            if count > limits.max_bytes {
                return Err(Problem::TooManyBytes { limit: limits.max_bytes });
            }
        }
        let left_out = topics.iter().find_map(|topic| match &topic.kind {
            Kind::LeftOut(reason) => Some(format!("the topic {} cannot be read: {reason}", topic.name)),
            _ => None,
        });
        let (mut arrays, mut columns) = (vec![], vec![]);
        for topic in topics {
            let rows = topic.log_time_s.len();
            if rows < 2 || matches!(topic.kind, Kind::LeftOut(_)) {
                continue;
            }
            for (name, mut column) in topic.names().to_vec().into_iter().zip(topic.columns) {
                column.resize(rows, f64::NAN);
                let whole = format!("{}.{name}", topic.name);
                arrays.push(Array { aliases: vec![name], ..Array::new(whole, vec![rows]) });
                columns.push(column);
            }
            let name = format!("{}.log_time", topic.name);
            arrays.push(Array { unit: Some("s".to_owned()), ..Array::new(name, vec![rows]) });
            columns.push(topic.log_time_s);
        }
        match left_out {
            _ if !arrays.is_empty() => Ok(Self { arrays, columns }),
            Some(reason) => Err(Format::Mcap.damaged(reason)),
            None => Err(Problem::NoSignal(Format::Mcap)),
        }
    }
}

impl Container for Mcap {
    fn arrays(&self) -> &[Array] {
        &self.arrays
    }

    fn values(&mut self, index: usize) -> Result<Vec<f64>, Fault> {
        Ok(self.columns[index].clone())
    }
}
