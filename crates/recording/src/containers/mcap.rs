//! MCAP logs with messages of ROS 1, ROS 2 or JSON.

use std::borrow::Cow;

use mcap::read::Options;
use mcap::{McapError, Message, MessageStream};

use super::json::JsonColumns;
use super::mcap_chunks::decompressed;
use super::ros::{Definition, Encoding};
use super::topics::{Kind, Topics};
use super::{Format, Loaded};
use crate::budget::Budget;
use crate::error::Problem;

/// Memory in bytes per byte of a definition.
const DEFINITION_BYTES: usize = 128;

pub(super) fn open(bytes: &[u8], budget: &Budget) -> Result<Loaded, Problem> {
    let mut topics = Topics::new(Format::Mcap);
    let plain = decompressed(bytes, budget)?;
    for message in MessageStream::new_with_options(&plain, Options::ValidateChunkCrcs.into()).map_err(damaged)? {
        let message = message.map_err(damaged)?;
        let channel = &message.channel;
        let describe = || {
            let schema = channel.schema.as_ref().map_or(0, |schema| schema.data.len());
            // The channels of a log can refer to one definition.
            budget.hold("definitions of messages", DEFINITION_BYTES * schema)?;
            Ok((channel.topic.clone(), kind(&message)))
        };
        topics.push(i64::from(channel.id), i128::from(message.log_time), &message.data, budget, describe)?;
    }
    if let Cow::Owned(plain) = plain {
        budget.release(plain.len());
    }
    topics.finish(budget)
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
