//! MCAP logs with messages of ROS 1, ROS 2 or JSON.

use mcap::io::MessageReader;
use mcap::read::LinearReader;
use mcap::records::Record;
use mcap::sans_io::LinearReaderOptions;
use mcap::{McapError, Message};

use super::json::JsonColumns;
use super::ros::{Definition, Encoding};
use super::topics::{Kind, Topics};
use super::{Format, Loaded};
use crate::error::Problem;
use crate::room::Room;

/// Bytes of a parsed definition per byte of its text.
const DEFINITION_BYTES: usize = 16;

pub(super) fn open(bytes: &[u8], room: &Room) -> Result<Loaded, Problem> {
    for record in LinearReader::new(bytes).map_err(damaged)? {
        if let Record::Chunk { header, .. } = record.map_err(damaged)? {
            room.take(usize::try_from(header.uncompressed_size).unwrap_or(usize::MAX))?;
        }
    }
    let largest = usize::try_from(room.limits().max_bytes).unwrap_or(usize::MAX);
    let options = LinearReaderOptions::default()
        .with_record_length_limit(largest)
        .with_validate_chunk_crcs(true)
        .with_validate_data_section_crc(true)
        .with_validate_summary_section_crc(true);
    let mut topics = Topics::default();
    for message in MessageReader::new_with_options(bytes, options) {
        let message = message.map_err(damaged)?;
        let channel = &message.channel;
        let describe = || {
            let schema = channel.schema.as_ref().map_or(0, |schema| schema.data.len());
            // Channels can share one definition.
            room.take(DEFINITION_BYTES * schema)?;
            Ok((channel.topic.clone(), kind(&message)))
        };
        topics.push(channel.id, i128::from(message.log_time), &message.data, room, describe)?;
    }
    topics.finish(room)
}

fn damaged(error: McapError) -> Problem {
    Format::Mcap.damaged(error)
}

fn kind(message: &Message<'_>) -> Kind {
    let channel = &message.channel;
    let schema = channel.schema.as_ref();
    let definition = |encoding| {
        let Some(schema) = schema else { return Err("its schema is missing".to_owned()) };
        let text = std::str::from_utf8(&schema.data).map_err(|_| "its schema is no text")?;
        Definition::parse(encoding, &schema.name, text)
    };
    Kind::ros(match (channel.message_encoding.as_str(), schema.map(|schema| schema.encoding.as_str())) {
        ("cdr", Some("ros2msg")) => definition(Encoding::Cdr),
        ("ros1", Some("ros1msg")) => definition(Encoding::Ros1),
        ("json", _) => return Kind::Json(JsonColumns::default()),
        (encoding, schema) => {
            let schema = schema.map_or(String::new(), |schema| format!(" with a schema in '{schema}'"));
            Err(format!("its messages are in '{encoding}'{schema}; those of ROS (ros2msg, ros1msg) and JSON are read"))
        }
    })
}
