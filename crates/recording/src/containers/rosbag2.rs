//! Logs of ROS 2 in SQLite. Newer logs contain the definitions of their messages; for older ones the common messages of
//! forces, poses and joints are defined here.

use std::collections::HashMap;
use std::hash::Hash;

use rusqlite::{Connection, OptionalExtension, Row};

use super::mcap::DEFINITION_BYTES;
use super::ros::{Definition, Encoding};
use super::topics::{Kind, Topics};
use super::{Format, Loaded};
use crate::budget::Budget;
use crate::error::Problem;

fn damaged(error: rusqlite::Error) -> Problem {
    Format::Rosbag2.damaged(error)
}

/// Reads a log in memory, so that SQLite writes no file beside it.
pub(super) fn open(bytes: &[u8], budget: &Budget) -> Result<Loaded, Problem> {
    budget.hold("bytes", bytes.len())?;
    let mut log = Connection::open_in_memory().map_err(damaged)?;
    let left = budget.left();
    // Expressions in a damaged schema can ask for any amount of memory.
    log.execute_batch(&format!("PRAGMA trusted_schema = OFF; PRAGMA hard_heap_limit = {}", left.max(1 << 20)))
        .map_err(damaged)?;
    log.deserialize_read_exact("main", bytes, bytes.len(), true).map_err(damaged)?;
    for table in ["topics", "messages"] {
        if !has_table(&log, table)? {
            return Err(Format::Rosbag2.damaged("it has no tables 'topics' and 'messages'"));
        }
    }
    let names: HashMap<i64, Topic> =
        table(&log, "SELECT id, name, type, serialization_format FROM topics", budget, |row| {
            Ok((row.get(0)?, (row.get(1)?, row.get(2)?, row.get(3)?)))
        })?;
    let definitions: HashMap<String, String> = match has_table(&log, "message_definitions")? {
        true => table(
            &log,
            "SELECT topic_type, encoded_message_definition FROM message_definitions WHERE encoding = 'ros2msg'",
            budget,
            |row| Ok((row.get(0)?, row.get(1)?)),
        )?,
        false => HashMap::new(),
    };
    let mut topics = Topics::new(Format::Rosbag2);
    let messages = messages(&log, budget)?;
    for (time_ns, topic, data) in &messages {
        let describe = || {
            let Some(found) = names.get(topic) else {
                return Ok((format!("topic {topic}"), Kind::LeftOut("the log does not describe it".to_owned())));
            };
            let size = definitions.get(&found.1).map_or(0, String::len);
            budget.hold("definitions of messages", DEFINITION_BYTES * size)?;
            Ok((found.0.clone(), kind(found, &definitions)))
        };
        topics.push(*topic, i128::from(*time_ns), data, budget, describe)?;
    }
    topics.finish(budget)
}

/// Reads a small table by its first column. The first row of a key counts.
fn table<K: Eq + Hash, V>(
    log: &Connection,
    query: &str,
    budget: &Budget,
    read: impl Fn(&Row<'_>) -> rusqlite::Result<(K, V)>,
) -> Result<HashMap<K, V>, Problem> {
    let mut statement = log.prepare(query).map_err(damaged)?;
    let columns = statement.column_count();
    let mut rows = statement.query([]).map_err(damaged)?;
    let mut found = HashMap::new();
    while let Some(row) = rows.next().map_err(damaged)? {
        let size =
            |column: usize| row.get_ref(column).ok().and_then(|value| value.as_bytes().ok()).map_or(8, <[u8]>::len);
        budget.hold("topics", 128 + (0..columns).map(size).sum::<usize>())?;
        let Ok((key, value)) = read(row) else { continue };
        found.entry(key).or_insert(value);
    }
    Ok(found)
}

/// A message: its time in ns, its topic and its content.
type Message = (i64, i64, Vec<u8>);

/// The messages in the order of their times. SQLite would sort them without a limit.
fn messages(log: &Connection, budget: &Budget) -> Result<Vec<Message>, Problem> {
    let mut statement = log.prepare("SELECT timestamp, topic_id, data FROM messages").map_err(damaged)?;
    let mut rows = statement.query([]).map_err(damaged)?;
    let mut messages: Vec<Message> = vec![];
    while let Some(row) = rows.next().map_err(damaged)? {
        let data = row.get_ref(2).map_err(damaged)?.as_blob().map_err(|error| Format::Rosbag2.damaged(error))?;
        budget.hold("messages", size_of::<Message>() + data.len())?;
        messages.push((row.get(0).map_err(damaged)?, row.get(1).map_err(damaged)?, data.to_vec()));
    }
    messages.sort_by_key(|(time_ns, ..)| *time_ns);
    Ok(messages)
}

/// Returns true if the log has a table of stored values: a view and a generated column can compute without end.
fn has_table(log: &Connection, name: &str) -> Result<bool, Problem> {
    let query = "SELECT sql FROM sqlite_master WHERE type = 'table' AND name = ?1";
    let found: Option<String> = log.query_row(query, [name], |row| row.get(0)).optional().map_err(damaged)?;
    Ok(found.is_some_and(|definition| {
        let definition = definition.to_lowercase();
        let words = || definition.split(|character: char| !character.is_alphanumeric() && character != '_');
        !words().any(|word| matches!(word, "as" | "virtual" | "generated"))
    }))
}

/// Name, type and serialisation of a topic.
type Topic = (String, String, String);

/// The encoding of the messages of a topic.
fn kind((_, message, format): &Topic, definitions: &HashMap<String, String>) -> Kind {
    if format != "cdr" {
        return Kind::LeftOut(format!("its messages are in '{format}'; those in cdr are read"));
    }
    Kind::ros(match definitions.get(message).filter(|text| !text.is_empty()) {
        Some(text) => Definition::parse(Encoding::Cdr, message, text),
        None => common(message),
    })
}

/// The definition of a common message.
fn common(message: &str) -> Result<Definition, String> {
    let short = message.replace("/msg/", "/");
    let Some((_, text)) = COMMON.iter().find(|(name, _)| *name == short) else {
        return Err(format!(
            "the log does not define its messages ({message}); convert it to MCAP with `ros2 bag convert`, which adds the \
             definitions"
        ));
    };
    let others = COMMON.iter().filter(|(name, _)| *name != short);
    let parts: String = others.map(|(name, text)| format!("\n===\nMSG: {name}\n{text}")).collect();
    Definition::parse(Encoding::Cdr, message, &format!("{text}{parts}"))
}

/// The messages of forces, poses and joints, from the packages std_msgs, geometry_msgs and sensor_msgs of ROS 2.
const COMMON: [(&str, &str); 20] = [
    ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id"),
    ("std_msgs/Float32", "float32 data"),
    ("std_msgs/Float64", "float64 data"),
    ("std_msgs/Int32", "int32 data"),
    ("std_msgs/MultiArrayDimension", "string label\nuint32 size\nuint32 stride"),
    ("std_msgs/MultiArrayLayout", "MultiArrayDimension[] dim\nuint32 data_offset"),
    ("std_msgs/Float64MultiArray", "MultiArrayLayout layout\nfloat64[] data"),
    ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z"),
    ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z"),
    ("geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w"),
    ("geometry_msgs/Pose", "Point position\nQuaternion orientation"),
    ("geometry_msgs/Twist", "Vector3 linear\nVector3 angular"),
    ("geometry_msgs/Wrench", "Vector3 force\nVector3 torque"),
    ("geometry_msgs/Vector3Stamped", "std_msgs/Header header\nVector3 vector"),
    ("geometry_msgs/PointStamped", "std_msgs/Header header\nPoint point"),
    ("geometry_msgs/PoseStamped", "std_msgs/Header header\nPose pose"),
    ("geometry_msgs/TwistStamped", "std_msgs/Header header\nTwist twist"),
    ("geometry_msgs/WrenchStamped", "std_msgs/Header header\nWrench wrench"),
    ("geometry_msgs/Transform", "Vector3 translation\nQuaternion rotation"),
    (
        "sensor_msgs/JointState",
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort",
    ),
];

#[cfg(test)]
mod tests {
    use super::super::Container as _;
    use super::*;

    fn budget() -> Budget {
        Budget::new(&crate::Limits::default())
    }

    /// A log with a topic of numbers, whose messages are `time_ns` and a value.
    fn log(message: &str, definition: Option<&str>, samples: &[(i64, f64)]) -> Vec<u8> {
        let mut log = Connection::open_in_memory().expect("memory");
        log.execute_batch(
            "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);
             CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);",
        )
        .expect("tables");
        log.execute("INSERT INTO topics VALUES(1, '/force', ?1, 'cdr')", [message]).expect("a topic");
        if let Some(text) = definition {
            log.execute_batch(
                "CREATE TABLE message_definitions(topic_type TEXT, encoding TEXT, encoded_message_definition TEXT)",
            )
            .expect("a table");
            log.execute("INSERT INTO message_definitions VALUES(?1, 'ros2msg', ?2)", [message, text]).expect("a row");
        }
        for (time_ns, value) in samples {
            let data = [&[0, 1, 0, 0][..], &value.to_le_bytes()].concat();
            log.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES(1, ?1, ?2)", (time_ns, data))
                .expect("a row");
        }
        log.serialize("main").expect("bytes").to_vec()
    }

    #[test]
    fn messages_are_read_by_their_own_or_a_common_definition() {
        let samples = [(1_767_225_600_000_000_000, 1.5), (1_767_225_600_250_000_000, 2.5)];
        for (message, definition) in [("std_msgs/msg/Float64", None), ("my/msg/Force", Some("float64 data"))] {
            let mut found = open(&log(message, definition, &samples), &budget()).expect(message);
            let names: Vec<&str> = found.arrays().iter().map(|array| array.name.as_str()).collect();
            assert_eq!(names, ["/force.data", "/force.log_time"]);
            assert_eq!(
                (found.values(0, &budget()).expect("data"), found.values(1, &budget()).expect("times")),
                (vec![1.5, 2.5], vec![0.0, 0.25])
            );
        }
        let refusal = |bytes: &[u8]| open(bytes, &budget()).err().expect("refused").to_string();
        assert!(refusal(&log("my/msg/Force", None, &samples)).contains("`ros2 bag convert`"));
        assert!(refusal(b"SQLite format 3\0 and nothing").contains("that cannot be read"));
        let damaged = &log("std_msgs/msg/Float64", None, &samples)[..6000];
        assert!(refusal(damaged).contains("that cannot be read"));
    }

    #[test]
    fn every_common_definition_is_complete() {
        COMMON.iter().for_each(|(name, _)| assert!(common(name).is_ok(), "{name}"));
    }
}
