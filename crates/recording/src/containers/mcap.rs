//! MCAP logs with messages of ROS 1, ROS 2 or JSON: a signal `/topic.field` per number of a message, and
//! `/topic.log_time` in seconds since the first message of the file.
//!
//! Unreadable messages, such as Protocol Buffers, are omitted. The file is rejected if no signal remains.

use super::json::JsonColumns;
use super::mcap_chunks::decompressed;
use super::ros::{Decoder, Definition, Encoding};
use super::{Array, Container, Fault, Format};
use crate::Limits;
use crate::error::Problem;
use mcap::{McapError, Message, MessageStream};

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
    Json(JsonColumns),
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
            ("json", _) => return Self::Json(JsonColumns::default()),
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
            Kind::Json(columns) => columns.push(data).map_err(|error| format!("a message in JSON: {error}"))?,
            Kind::LeftOut(_) => {}
        }
        Ok(())
    }

    /// Number of columns.
    fn width(&self) -> usize {
        match &self.kind {
            Kind::Json(columns) => columns.names.len(),
            _ => self.columns.len(),
        }
    }

    /// The names and the columns, and for each column true if it holds dates.
    fn finish(self) -> Vec<(String, Vec<f64>, bool)> {
        match self.kind {
            Kind::Ros { decoder, .. } => {
                let columns = decoder.names().to_vec().into_iter().zip(self.columns);
                columns.map(|(name, column)| (name, column, false)).collect()
            }
            Kind::Json(columns) => columns.finish().collect(),
            Kind::LeftOut(_) => vec![],
        }
    }
}

fn damaged(error: McapError) -> Problem {
    Format::Mcap.damaged(error)
}

impl Mcap {
    pub(super) fn open(bytes: &[u8], limits: &Limits) -> Result<Self, Problem> {
        let mut topics: Vec<Topic> = vec![];
        let (mut start, mut count) = (None, 0_u64);
        for message in MessageStream::new(&decompressed(bytes, limits)?).map_err(damaged)? {
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
            count += 8 * (1 + topic.width() as u64);
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
            let (topic_name, log_time_s) = (topic.name.clone(), topic.log_time_s.clone());
            let signals = topic.finish();
            let clock = Some(arrays.len() + signals.len());
            for (name, mut column, has_dates) in signals {
                column.resize(rows, f64::NAN);
                let whole = format!("{topic_name}.{name}");
                let unit = has_dates.then(|| "s".to_owned());
                arrays.push(Array { aliases: vec![name], unit, clock, ..Array::new(whole, vec![rows]) });
                columns.push(column);
            }
            let name = format!("{topic_name}.log_time");
            arrays.push(Array { unit: Some("s".to_owned()), clock, ..Array::new(name, vec![rows]) });
            columns.push(log_time_s);
        }
        match left_out {
            _ if !arrays.is_empty() => Ok(Self { arrays, columns }),
            Some(reason) => Err(Format::Mcap.damaged(reason)),
            None => Err(Problem::no_signal(Format::Mcap, &[])),
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
