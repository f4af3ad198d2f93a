//! Logs of ROS 2 in SQLite. Newer logs contain the definitions of their messages; for older ones the common messages of
//! forces, poses and joints are defined here.

use rusqlite::{Connection, OptionalExtension};

use super::ros::{Definition, Encoding};
use super::topics::{Kind, Topics};
use super::{Format, Loaded};
use crate::Limits;
use crate::error::Problem;

fn damaged(error: rusqlite::Error) -> Problem {
    Format::Rosbag2.damaged(error)
}

/// Reads a log in memory, so that SQLite writes no file beside it.
pub(super) fn open(bytes: &[u8], limits: &Limits) -> Result<Loaded, Problem> {
    let mut log = Connection::open_in_memory().map_err(damaged)?;
    log.deserialize_read_exact("main", bytes, bytes.len(), true).map_err(damaged)?;
    if !has_table(&log, "topics")? || !has_table(&log, "messages")? {
        return Err(Format::Rosbag2.damaged("it has no tables 'topics' and 'messages'"));
    }
    let has_definitions = has_table(&log, "message_definitions")?;
    let mut rows = log
        .prepare(
            "SELECT messages.topic_id, messages.timestamp, messages.data FROM messages ORDER BY messages.timestamp",
        )
        .map_err(damaged)?;
    let mut rows = rows.query([]).map_err(damaged)?;
    let mut topics = Topics::new();
    while let Some(row) = rows.next().map_err(damaged)? {
        let (topic, time_ns): (i64, i64) = (row.get(0).map_err(damaged)?, row.get(1).map_err(damaged)?);
        let data = row.get_ref(2).map_err(damaged)?.as_blob().map_err(|error| Format::Rosbag2.damaged(error))?;
        let describe = || describe(&log, topic, has_definitions);
        topics.push(topic, i128::from(time_ns), data, limits, describe)?;
    }
    topics.finish(Format::Rosbag2)
}

/// Returns true if the log has a table, which is not a view: a view can compute without end.
fn has_table(log: &Connection, name: &str) -> Result<bool, Problem> {
    let query = "SELECT 1 FROM sqlite_master WHERE type = 'table' AND name = ?1";
    let found = log.query_row(query, [name], |_| Ok(())).optional();
    found.map(|found| found.is_some()).map_err(damaged)
}

/// The name and the encoding of a topic.
fn describe(log: &Connection, topic: i64, has_definitions: bool) -> (String, Kind) {
    let query = "SELECT name, type, serialization_format FROM topics WHERE id = ?1";
    let found: Result<(String, String, String), _> =
        log.query_row(query, [topic], |row| Ok((row.get(0)?, row.get(1)?, row.get(2)?)));
    let (name, message, format) = match found {
        Ok(found) => found,
        Err(error) => return (format!("topic {topic}"), Kind::LeftOut(error.to_string())),
    };
    if format != "cdr" {
        return (name, Kind::LeftOut(format!("its messages are in '{format}'; those in cdr are read")));
    }
    let query =
        "SELECT encoded_message_definition FROM message_definitions WHERE topic_type = ?1 AND encoding = 'ros2msg'";
    let of_log: Option<String> =
        if has_definitions { log.query_row(query, [&message], |row| row.get(0)).ok() } else { None };
    let definition = match of_log.filter(|text| !text.is_empty()) {
        Some(text) => Definition::parse(Encoding::Cdr, &message, &text),
        None => common(&message),
    };
    (name, Kind::ros(definition))
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
            let mut found = open(&log(message, definition, &samples), &Limits::default()).expect(message);
            let names: Vec<&str> = found.arrays().iter().map(|array| array.name.as_str()).collect();
            assert_eq!(names, ["/force.data", "/force.log_time"]);
            assert_eq!(
                (found.values(0).expect("data"), found.values(1).expect("times")),
                (vec![1.5, 2.5], vec![0.0, 0.25])
            );
        }
        let refusal = |bytes: &[u8]| open(bytes, &Limits::default()).err().expect("refused").to_string();
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
