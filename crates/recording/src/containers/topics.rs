//! The topics of a log: a signal `/topic.field` per number of a message, and `/topic.log_time` in seconds since the first
//! message of the log.
//!
//! Unreadable messages, such as Protocol Buffers, are omitted. The log is rejected if no signal remains.

use super::json::JsonColumns;
use super::ros::{Decoder, Definition};
use super::{Array, Format, Loaded};
use crate::Limits;
use crate::error::Problem;

/// The topics of a log while its messages are read.
pub(super) struct Topics {
    topics: Vec<Topic>,
    start_ns: Option<i128>,
    bytes: u64,
}

struct Topic {
    channel: i64,
    name: String,
    log_time_s: Vec<f64>,
    kind: Kind,
    columns: Vec<Vec<f64>>,
}

/// The encoding of the messages of a topic.
pub(super) enum Kind {
    Ros {
        decoder: Decoder,
        row: Vec<f64>,
    },
    Json(JsonColumns),
    /// The reason why the messages are not read.
    LeftOut(String),
}

impl Kind {
    /// Messages of ROS, or the reason why they are not read.
    pub(super) fn ros(definition: Result<Definition, String>) -> Self {
        definition.map_or_else(Self::LeftOut, |definition| Self::Ros { decoder: Decoder::new(definition), row: vec![] })
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

impl Topics {
    pub(super) fn new() -> Self {
        Self { topics: vec![], start_ns: None, bytes: 0 }
    }

    /// Adds a message of a channel. `describe` gives the name and the encoding of a new channel.
    pub(super) fn push(
        &mut self,
        channel: i64,
        log_time_ns: i128,
        data: &[u8],
        limits: &Limits,
        describe: impl FnOnce() -> (String, Kind),
    ) -> Result<(), Problem> {
        let start_ns = *self.start_ns.get_or_insert(log_time_ns);
        let known = self.topics.iter().position(|topic| topic.channel == channel);
        let index = known.unwrap_or_else(|| {
            let (name, kind) = describe();
            self.topics.push(Topic { channel, name, log_time_s: vec![], kind, columns: vec![] });
            self.topics.len() - 1
        });
        let topic = &mut self.topics[index];
        if matches!(topic.kind, Kind::LeftOut(_)) {
            return Ok(());
        }
        if topic.log_time_s.len() >= limits.max_samples {
            return Err(Problem::TooManySamples { limit: limits.max_samples });
        }
        if let Err(reason) = topic.push(data) {
            topic.kind = Kind::LeftOut(reason);
            topic.columns = vec![];
            return Ok(());
        }
        topic.log_time_s.push(1e-9 * (log_time_ns - start_ns) as f64);
        self.bytes += 8 * (1 + topic.width() as u64);
        if self.bytes > limits.max_bytes {
            return Err(Problem::TooManyBytes { limit: limits.max_bytes });
        }
        Ok(())
    }

    pub(super) fn finish(self, format: Format) -> Result<Loaded, Problem> {
        let left_out = self.topics.iter().find_map(|topic| match &topic.kind {
            Kind::LeftOut(reason) => Some(format!("the topic {} cannot be read: {reason}", topic.name)),
            _ => None,
        });
        let (mut arrays, mut columns) = (vec![], vec![]);
        for topic in self.topics {
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
            Some(reason) if arrays.is_empty() => Err(format.damaged(reason)),
            _ => Loaded::new(format, arrays, columns, &[]),
        }
    }
}
