//! The topics of a log: a signal `/topic.field` per number of a message, and `/topic.log_time` in seconds since the first
//! message of the log.
//!
//! Unreadable messages, such as Protocol Buffers, are omitted. The log is rejected if no signal remains.

use std::collections::HashMap;

use super::json::JsonColumns;
use super::ros::{Decoder, Definition, FirstStamps};
use super::{Array, Format, Loaded};
use crate::error::Problem;
use crate::room::{Room, check_name};

#[derive(Default)]
pub(super) struct Topics {
    topics: Vec<Topic>,
    by_channel: HashMap<u16, usize>,
    start_ns: Option<i128>,
    first_stamps: FirstStamps,
}

struct Topic {
    name: String,
    log_time_s: Vec<f64>,
    kind: Kind,
    columns: Vec<Vec<f64>>,
}

#[derive(Debug)]
pub(super) enum Refusal {
    /// Omits the topic.
    Message(String),
    /// Refuses the file.
    File(Problem),
}

impl From<String> for Refusal {
    fn from(reason: String) -> Self {
        Self::Message(reason)
    }
}

impl From<Problem> for Refusal {
    fn from(problem: Problem) -> Self {
        Self::File(problem)
    }
}

pub(super) enum Kind {
    Ros { decoder: Decoder, row: Vec<f64> },
    Json(JsonColumns),
    LeftOut(String),
}

impl Kind {
    pub(super) fn ros(definition: Result<Definition, String>) -> Self {
        definition.map_or_else(Self::LeftOut, |definition| Self::Ros { decoder: Decoder::new(definition), row: vec![] })
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Meaning {
    Number,
    /// In s, from one time in all topics.
    SharedTime,
    /// In s, from the first one of the column.
    OwnTime,
}

impl Topic {
    fn push(&mut self, data: &[u8], first_stamps: &mut FirstStamps, room: &Room) -> Result<(), Refusal> {
        match &mut self.kind {
            Kind::Ros { decoder, row } => {
                decoder.decode(data, row, first_stamps, room)?;
                self.columns.resize_with(row.len(), Vec::new);
                for (column, value) in self.columns.iter_mut().zip(row) {
                    column.push(*value);
                }
            }
            Kind::Json(columns) => columns.push(data, room).map_err(|refusal| match refusal {
                Refusal::Message(reason) => Refusal::Message(format!("a message in JSON: {reason}")),
                file => file,
            })?,
            Kind::LeftOut(_) => {}
        }
        Ok(())
    }

    fn width(&self) -> usize {
        match &self.kind {
            Kind::Json(columns) => columns.names.len(),
            _ => self.columns.len(),
        }
    }

    fn finish(self) -> Vec<(String, Vec<f64>, Meaning)> {
        match self.kind {
            Kind::Ros { decoder, .. } => {
                let names = decoder.names().iter().cloned().zip(self.columns).enumerate();
                let meaning = |index| if decoder.is_stamp(index) { Meaning::SharedTime } else { Meaning::Number };
                names.map(|(index, (name, column))| (name, column, meaning(index))).collect()
            }
            Kind::Json(columns) => {
                let meaning = |has_dates| if has_dates { Meaning::OwnTime } else { Meaning::Number };
                columns.finish().map(|(name, column, has_dates)| (name, column, meaning(has_dates))).collect()
            }
            Kind::LeftOut(_) => vec![],
        }
    }
}

impl Topics {
    pub(super) fn push(
        &mut self,
        channel: u16,
        log_time_ns: i128,
        data: &[u8],
        room: &Room,
        describe: impl FnOnce() -> Result<(String, Kind), Problem>,
    ) -> Result<(), Problem> {
        let start_ns = *self.start_ns.get_or_insert(log_time_ns);
        let index = match self.by_channel.get(&channel) {
            Some(index) => *index,
            None => {
                let (name, kind) = describe()?;
                check_name(name.len())?;
                room.take(size_of::<Topic>() + name.len())?;
                self.topics.push(Topic { name, log_time_s: vec![], kind, columns: vec![] });
                self.by_channel.insert(channel, self.topics.len() - 1);
                self.topics.len() - 1
            }
        };
        let topic = &mut self.topics[index];
        if matches!(topic.kind, Kind::LeftOut(_)) {
            return Ok(());
        }
        let limit = room.limits().max_samples;
        if topic.log_time_s.len() >= limit {
            return Err(Problem::TooManySamples { limit });
        }
        room.take_values(1 + topic.width())?;
        match topic.push(data, &mut self.first_stamps, room) {
            Ok(()) => topic.log_time_s.push(1e-9 * (log_time_ns - start_ns) as f64),
            Err(Refusal::Message(reason)) => {
                topic.kind = Kind::LeftOut(reason);
                topic.columns = vec![];
            }
            Err(Refusal::File(problem)) => return Err(problem),
        }
        Ok(())
    }

    pub(super) fn finish(self, room: &Room) -> Result<Loaded, Problem> {
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
            let log_time = ("log_time".to_owned(), log_time_s, Meaning::SharedTime);
            for (name, mut column, meaning) in signals.into_iter().chain([log_time]) {
                column.resize(rows, f64::NAN);
                check_name(topic_name.len() + 1 + name.len())?;
                let array = Array::in_room(&format!("{topic_name}.{name}"), vec![rows], room)?;
                let unit = (meaning != Meaning::Number).then(|| "s".to_owned());
                let is_shared_time = meaning == Meaning::SharedTime;
                arrays.push(Array { aliases: vec![name], unit, clock, is_shared_time, ..array });
                columns.push(column);
            }
        }
        match left_out {
            Some(reason) if arrays.is_empty() => Err(Format::Mcap.damaged(reason)),
            _ => Loaded::new(Format::Mcap, arrays, columns, &[]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::ros::Encoding;
    use super::*;
    use crate::{Columns, Limits, Recording, RecordingError};

    /// A log of the topics `/a` and `/b`. Each value is the time of its stamp, in s since the first stamp of the log;
    /// the messages of `/b` are logged 30 ms late.
    fn log(stamp_of_b: &str) -> Loaded {
        let (mut topics, room) = (Topics::default(), Room::new(&Limits::default()));
        let start_ns = 1_700_000_000_000_000_000_i128;
        for k in 0..100 {
            for (channel, name, due, late_ns) in [(1, "/a", k % 10 == 0, 0), (2, "/b", k > 2, 30_000_000)] {
                let (since_ns, field) = (1_000_000 * i128::from(k), if channel == 1 { "stamp" } else { stamp_of_b });
                let stamp_ns = start_ns + since_ns;
                let seconds = u32::try_from(stamp_ns / 1_000_000_000).expect("seconds").to_le_bytes();
                let rest = u32::try_from(stamp_ns % 1_000_000_000).expect("nanoseconds").to_le_bytes();
                let data = [&seconds[..], &rest, &(1e-9 * since_ns as f64).to_le_bytes()].concat();
                let definition =
                    || Definition::parse(Encoding::Ros1, "lab/Sample", &format!("time {field}\nfloat64 value"));
                let describe = || Ok((name.to_owned(), Kind::ros(definition())));
                if due {
                    topics.push(channel, stamp_ns + late_ns, &data, &room, describe).expect("a message");
                }
            }
        }
        topics.finish(&room).expect("two topics")
    }

    fn joined_by(time: &str, mut log: Loaded) -> Result<Recording, RecordingError> {
        let column = |name: &str| name.parse().expect("a column");
        let columns =
            Columns { time: column(time), position: column("/a.value"), velocity: None, force: column("/b.value") };
        super::super::read::read("log.mcap", &mut log, &columns, &Room::new(&Limits::default()))
    }

    #[test]
    fn topics_are_joined_by_their_stamps_or_by_the_log_times() {
        let largest = |recording: &Recording| {
            let pairs = recording.position_m().iter().zip(recording.force_n());
            pairs.map(|(position, force)| (position - force).abs()).fold(0.0, f64::max)
        };
        let by_stamp = joined_by("/a.stamp", log("stamp")).expect("joined");
        assert!(largest(&by_stamp) < 1e-9, "{}", largest(&by_stamp));
        // By the log times, the force is 30 ms late.
        let by_log_time = joined_by("/a.log_time", log("stamp")).expect("joined");
        assert!((largest(&by_log_time) - 0.03).abs() < 1e-9, "{}", largest(&by_log_time));
    }

    #[test]
    fn a_stamp_that_the_other_topic_lacks_joins_nothing() {
        let error = joined_by("/a.stamp", log("other")).expect_err("no shared time").to_string();
        assert!(error.contains("give --time /a.log_time"), "{error}");
    }
}
