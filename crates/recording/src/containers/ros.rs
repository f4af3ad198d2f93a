//! ROS messages: definitions as text (`.msg`), and the numbers of serialised messages.
//!
//! ROS 2 serialises by the Common Data Representation of the Object Management Group (CDR, version 1), which aligns a
//! number to its size. ROS 1 packs the numbers without gaps. A time stamp is one number, in seconds since the first
//! stamp of the log with the same path, such as `header.stamp`.

use std::collections::HashMap;

use super::bytes::{Cursor, Order, Scalar};
use super::topics::Refusal;
use crate::room::{Room, check_name as check_path};

/// Longer arrays, such as images and point clouds, are not signals.
pub(super) const MAX_ELEMENTS: usize = 64;

const MAX_DEPTH: usize = 16;

const MAX_MESSAGE_NAME_BYTES: usize = 256;

const COLUMN_BYTES: usize = 128;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ros1,
    Cdr,
}

#[derive(Debug, Clone, PartialEq)]
enum Kind {
    Number(Scalar),
    /// Seconds and nanoseconds.
    Stamp(Scalar),
    Text,
    Message(String),
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Count {
    One,
    Fixed(usize),
    /// The number that the message states.
    Any,
}

#[derive(Debug, Clone, PartialEq)]
struct Field {
    name: String,
    kind: Kind,
    count: Count,
}

#[derive(Debug, Clone)]
pub(super) struct Definition {
    encoding: Encoding,
    root: String,
    messages: HashMap<String, Vec<Field>>,
}

impl Definition {
    pub(super) fn parse(encoding: Encoding, name: &str, text: &str) -> Result<Self, String> {
        let root = short(name);
        check_name(&root)?;
        let mut messages = HashMap::from([(root.clone(), vec![])]);
        let mut current = root.clone();
        for line in text.lines() {
            let line = line.split('#').next().unwrap_or_default().trim();
            if line.is_empty() || line.starts_with("===") {
                continue;
            }
            if let Some(name) = line.strip_prefix("MSG:") {
                current = short(name.trim());
                check_name(&current)?;
                messages.entry(current.clone()).or_default();
                continue;
            }
            if let Some(field) = Field::parse(encoding, line, &current)? {
                messages.entry(current.clone()).or_default().push(field);
            }
        }
        Ok(Self { encoding, root, messages })
    }

    fn fields(&self, name: &str) -> Result<&[Field], String> {
        self.messages.get(name).map(Vec::as_slice).ok_or_else(|| format!("the message {name} is not defined"))
    }
}

fn check_name(name: &str) -> Result<(), String> {
    if name.len() <= MAX_MESSAGE_NAME_BYTES {
        return Ok(());
    }
    Err(format!("the name of a message has {} bytes, the limit is {MAX_MESSAGE_NAME_BYTES}", name.len()))
}

fn short(name: &str) -> String {
    name.replace("/msg/", "/")
}

impl Field {
    fn parse(encoding: Encoding, line: &str, owner: &str) -> Result<Option<Self>, String> {
        let unclear = || format!("'{line}' is no field of a message");
        let (kind, rest) = line.split_once(char::is_whitespace).ok_or_else(unclear)?;
        let name: String = rest.trim_start().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        let after = rest.trim_start()[name.len()..].trim_start();
        if name.is_empty() {
            return Err(unclear());
        }
        if after.starts_with('=') {
            return Ok(None);
        }
        let (base, count) = match kind.strip_suffix(']').and_then(|kind| kind.rsplit_once('[')) {
            None => (kind, Count::One),
            Some((base, "")) => (base, Count::Any),
            Some((base, bound)) if bound.starts_with("<=") => (base, Count::Any),
            Some((base, count)) => match count.parse() {
                Ok(0) | Err(_) => return Err(unclear()),
                Ok(count) => (base, Count::Fixed(count)),
            },
        };
        let base = base.split("<=").next().unwrap_or(base);
        let kind = match base {
            "byte" if encoding == Encoding::Ros1 => Kind::Number(Scalar::I8),
            "bool" | "byte" | "char" | "uint8" => Kind::Number(Scalar::U8),
            "int8" => Kind::Number(Scalar::I8),
            "int16" => Kind::Number(Scalar::I16),
            "uint16" => Kind::Number(Scalar::U16),
            "int32" => Kind::Number(Scalar::I32),
            "uint32" => Kind::Number(Scalar::U32),
            "int64" => Kind::Number(Scalar::I64),
            "uint64" => Kind::Number(Scalar::U64),
            "float32" => Kind::Number(Scalar::F32),
            "float64" => Kind::Number(Scalar::F64),
            "string" => Kind::Text,
            "wstring" => return Err("it has a field of type wstring".to_owned()),
            "time" if encoding == Encoding::Ros1 => Kind::Stamp(Scalar::U32),
            "duration" if encoding == Encoding::Ros1 => Kind::Stamp(Scalar::I32),
            "Header" => Kind::Message("std_msgs/Header".to_owned()),
            other => match (short(other), owner.rsplit_once('/')) {
                (name, _) if name == "builtin_interfaces/Time" => Kind::Stamp(Scalar::I32),
                (name, _) if name == "builtin_interfaces/Duration" => Kind::Stamp(Scalar::I32),
                (name, Some((package, _))) if !name.contains('/') => Kind::Message(format!("{package}/{name}")),
                (name, _) => Kind::Message(name),
            },
        };
        Ok(Some(Self { name, kind, count }))
    }
}

#[derive(Debug)]
pub(super) struct Decoder {
    definition: Definition,
    names: Option<Vec<String>>,
    lengths: Vec<usize>,
    /// Index among the numbers, and the time from which it counts, in nanoseconds.
    stamps: Vec<(usize, i64)>,
}

pub(super) type FirstStamps = HashMap<String, i64>;

impl Decoder {
    pub(super) fn new(definition: Definition) -> Self {
        Self { definition, names: None, lengths: vec![], stamps: vec![] }
    }

    pub(super) fn names(&self) -> &[String] {
        self.names.as_deref().unwrap_or_default()
    }

    pub(super) fn is_stamp(&self, index: usize) -> bool {
        self.stamps.binary_search_by_key(&index, |(stamp, _)| *stamp).is_ok()
    }

    pub(super) fn decode(
        &mut self,
        bytes: &[u8],
        values: &mut Vec<f64>,
        first_stamps: &mut FirstStamps,
        room: &Room,
    ) -> Result<(), Refusal> {
        values.clear();
        let mut reader = Reader {
            room,
            definition: &self.definition,
            cursor: Cursor::new(bytes, Order::Little),
            start: 0,
            values,
            path: String::new(),
            names: self.names.is_none().then(Vec::new),
            lengths: vec![],
            stamps: vec![],
            known_stamps: &self.stamps,
        };
        if self.definition.encoding == Encoding::Cdr {
            reader.header()?;
        }
        reader.message(&self.definition.root, 0)?;
        let Reader { names, lengths, stamps, .. } = reader;
        match names {
            Some(names) => {
                for (index, stamp) in stamps {
                    let first = *first_stamps.entry(names[index].clone()).or_insert(stamp);
                    values[index] = seconds_between(first, stamp);
                    self.stamps.push((index, first));
                }
                (self.names, self.lengths) = (Some(names), lengths);
            }
            None if lengths != self.lengths => return Err("the length of an array in it changes".to_owned().into()),
            None => {}
        }
        Ok(())
    }
}

struct Reader<'a> {
    room: &'a Room,
    definition: &'a Definition,
    cursor: Cursor<'a>,
    /// The origin of the alignment.
    start: usize,
    values: &'a mut Vec<f64>,
    path: String,
    names: Option<Vec<String>>,
    lengths: Vec<usize>,
    stamps: Vec<(usize, i64)>,
    known_stamps: &'a [(usize, i64)],
}

fn seconds_between(from_ns: i64, to_ns: i64) -> f64 {
    1e-9 * (i128::from(to_ns) - i128::from(from_ns)) as f64
}

fn cut_off() -> String {
    "a message is cut off".to_owned()
}

impl Reader<'_> {
    /// Only the plain representations of version 1 are supported.
    fn header(&mut self) -> Result<(), String> {
        self.cursor.order = match self.cursor.take(4).ok_or_else(cut_off)? {
            [0, 0, ..] => Order::Big,
            [0, 1, ..] => Order::Little,
            other => return Err(format!("it has the representation {}, of CDR 1 only 0 and 1 are read", other[1])),
        };
        self.start = self.cursor.at;
        Ok(())
    }

    fn align(&mut self, size: usize) -> Result<(), String> {
        if self.definition.encoding == Encoding::Cdr {
            let past = (self.cursor.at - self.start) % size;
            if past > 0 {
                self.cursor.take(size - past).ok_or_else(cut_off)?;
            }
        }
        Ok(())
    }

    fn number(&mut self, scalar: Scalar) -> Result<f64, String> {
        self.align(scalar.size())?;
        let order = self.cursor.order;
        self.cursor.take(scalar.size()).and_then(|bytes| scalar.read(bytes, order)).ok_or_else(cut_off)
    }

    fn length(&mut self) -> Result<usize, String> {
        self.align(4)?;
        self.cursor.index().ok_or_else(cut_off)
    }

    fn message(&mut self, name: &str, depth: usize) -> Result<(), Refusal> {
        if depth > MAX_DEPTH {
            return Err(format!("messages are nested deeper than {MAX_DEPTH}").into());
        }
        let definition = self.definition;
        let fields = definition.fields(name)?;
        // An empty message has one byte in ROS 2 and none in ROS 1. Without empty messages every field has at least one
        // byte, and the size of the file bounds the work.
        if fields.is_empty() {
            return Err(format!("the message {name} has no fields").into());
        }
        for field in fields {
            self.field(field, depth)?;
        }
        Ok(())
    }

    fn field(&mut self, field: &Field, depth: usize) -> Result<(), Refusal> {
        let before = self.path.len();
        check_path(before + 1 + field.name.len())?;
        if before > 0 {
            self.path.push('.');
        }
        self.path.push_str(&field.name);
        let count = match field.count {
            Count::One => None,
            Count::Fixed(count) => Some(count),
            Count::Any => Some(self.length()?),
        };
        match count {
            None => self.element(&field.kind, depth)?,
            Some(count) => self.array(&field.kind, count, depth)?,
        }
        self.path.truncate(before);
        Ok(())
    }

    fn array(&mut self, kind: &Kind, count: usize, depth: usize) -> Result<(), Refusal> {
        // An element has at least one byte, which bounds this loop.
        if count > self.cursor.rest().len() {
            return Err(cut_off().into());
        }
        let is_long = count > MAX_ELEMENTS;
        if let (true, Kind::Number(scalar)) = (is_long, kind) {
            self.align(scalar.size())?;
            return Ok(self.cursor.take(count * scalar.size()).map(drop).ok_or_else(cut_off)?);
        }
        if !is_long && *kind != Kind::Text {
            self.lengths.push(count);
        }
        let kept = (self.values.len(), self.lengths.len(), self.stamps.len());
        let names = if is_long { self.names.take() } else { None };
        let before = self.path.len();
        for index in 0..count {
            if self.names.is_some() {
                self.path.push_str(&format!("[{index}]"));
            }
            self.element(kind, depth)?;
            self.path.truncate(before);
            if is_long {
                self.values.truncate(kept.0);
                self.lengths.truncate(kept.1);
                self.stamps.truncate(kept.2);
            }
        }
        self.names = names.or(self.names.take());
        Ok(())
    }

    fn element(&mut self, kind: &Kind, depth: usize) -> Result<(), Refusal> {
        let value = match kind {
            Kind::Number(scalar) => self.number(*scalar)?,
            Kind::Stamp(seconds) => {
                let (seconds, fraction) = (self.number(*seconds)?, self.number(Scalar::U32)?);
                let stamp = 1_000_000_000 * seconds as i64 + fraction as i64;
                // The first complete message sets what its stamps count from.
                let (_, first) = self.known_stamps.get(self.stamps.len()).copied().unwrap_or((0, stamp));
                self.stamps.push((self.values.len(), stamp));
                seconds_between(first, stamp)
            }
            Kind::Text => {
                let length = self.length()?;
                return Ok(self.cursor.take(length).map(drop).ok_or_else(cut_off)?);
            }
            Kind::Message(name) => return self.message(name, depth + 1),
        };
        if let Some(names) = &mut self.names {
            self.room.take(self.path.len() + COLUMN_BYTES)?;
            names.push(self.path.clone());
        }
        self.values.push(value);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WRENCH: &str = "\
# A force.
std_msgs/Header header
Wrench wrench
float64[] joints
uint8 STATE_ON=1
uint8[2] state
string<=8 note \"none\"
float32 gain 1.0
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: geometry_msgs/Wrench
Vector3 force
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y";

    fn message(order: Order, seconds: i32, joints: &[f64]) -> Vec<u8> {
        let mut bytes = vec![0, u8::from(order == Order::Little), 0, 0];
        macro_rules! put {
            ($value:expr) => {{
                let value = $value;
                let size = size_of_val(&value);
                while (bytes.len() - 4) % size != 0 {
                    bytes.push(0xaa);
                }
                match order {
                    Order::Little => bytes.extend(value.to_le_bytes()),
                    Order::Big => bytes.extend(value.to_be_bytes()),
                }
            }};
        }
        put!(seconds);
        put!(250_000_000_u32);
        put!(4_u32);
        bytes.extend(b"arm\0");
        put!(1.5_f64);
        put!(-2.5_f64);
        put!(joints.len() as u32);
        for joint in joints {
            put!(*joint);
        }
        bytes.extend([1, 2]);
        put!(1_u32);
        bytes.extend(b"\0");
        put!(0.5_f32);
        bytes
    }

    fn room() -> Room {
        Room::new(&crate::Limits::default())
    }

    fn reason(refusal: Refusal) -> String {
        match refusal {
            Refusal::Message(reason) => reason,
            Refusal::File(problem) => problem.to_string(),
        }
    }

    fn decoder() -> Decoder {
        Decoder::new(Definition::parse(Encoding::Cdr, "geometry_msgs/msg/WrenchStamped", WRENCH).expect("a definition"))
    }

    fn decode(decoder: &mut Decoder, bytes: &[u8]) -> Result<Vec<f64>, String> {
        let mut values = vec![];
        decoder.decode(bytes, &mut values, &mut FirstStamps::new(), &room()).map_err(reason)?;
        Ok(values)
    }

    #[test]
    fn numbers_of_nested_messages_are_aligned_and_named() {
        for order in [Order::Little, Order::Big] {
            let mut decoder = decoder();
            let values = decode(&mut decoder, &message(order, 1_700_000_000, &[7.0])).expect("numbers");
            let names =
                ["header.stamp", "wrench.force.x", "wrench.force.y", "joints[0]", "state[0]", "state[1]", "gain"];
            assert_eq!(decoder.names(), names);
            assert_eq!(values, [0.0, 1.5, -2.5, 7.0, 1.0, 2.0, 0.5]);
            let values = decode(&mut decoder, &message(order, 1_700_000_002, &[8.0])).expect("numbers");
            assert_eq!(values[..4], [2.0, 1.5, -2.5, 8.0]);
            let refused = decode(&mut decoder, &message(order, 0, &[7.0, 8.0])).expect_err("another length");
            assert_eq!(refused, "the length of an array in it changes");
        }
    }

    #[test]
    fn messages_of_ros_1_are_packed() {
        let text = "time t\nuint8 a\nfloat64 b\nstring c\nint16 d\nbyte e";
        let definition = Definition::parse(Encoding::Ros1, "lab/Sample", text).expect("a definition");
        let mut decoder = Decoder::new(definition);
        let mut bytes = [[9_u32.to_le_bytes(), 5_u32.to_le_bytes()].concat(), vec![3]].concat();
        bytes.extend(2.5_f64.to_le_bytes());
        bytes.extend([1, 0, 0, 0, b'x']);
        bytes.extend((-4_i16).to_le_bytes());
        // A byte of ROS 1 is signed.
        bytes.push(0xff);
        let values = decode(&mut decoder, &bytes).expect("numbers");
        assert_eq!((values, decoder.names().join(" ").as_str()), (vec![0.0, 3.0, 2.5, -4.0, -1.0], "t a b d e"));
    }

    #[test]
    fn long_arrays_are_omitted() {
        let text = "Point[] points\nuint8[] image\nfloat64 after\n===\nMSG: lab/Point\nfloat32[2] x";
        let definition = Definition::parse(Encoding::Cdr, "lab/Cloud", text).expect("a definition");
        let mut decoder = Decoder::new(definition);
        let mut bytes = vec![0, 1, 0, 0];
        bytes.extend(65_u32.to_le_bytes());
        bytes.extend([0; 65 * 8]);
        bytes.extend(100_u32.to_le_bytes());
        bytes.extend([0; 100]);
        bytes.resize(4 + (bytes.len() - 4).next_multiple_of(8), 0);
        bytes.extend(6.5_f64.to_le_bytes());
        let values = decode(&mut decoder, &bytes).expect("numbers");
        assert_eq!((values, decoder.names()), (vec![6.5], &["after".to_owned()][..]));
    }

    #[test]
    fn damaged_messages_and_definitions_are_refused() {
        let whole = message(Order::Little, 3, &[7.0]);
        for len in 0..whole.len() {
            assert!(decode(&mut decoder(), &whole[..len]).is_err(), "{len}");
        }
        let refused = |text: &str, bytes: &[u8]| {
            let definition = Definition::parse(Encoding::Cdr, "lab/A", text);
            definition.and_then(|definition| decode(&mut Decoder::new(definition), bytes)).expect_err("refused")
        };
        assert_eq!(refused("A again", &[0, 1, 0, 0]), "messages are nested deeper than 16");
        assert_eq!(refused("lab/B b", &[0, 1, 0, 0]), "the message lab/B is not defined");
        assert_eq!(refused("wstring w", &[]), "it has a field of type wstring");
        assert_eq!(refused("float64", &[]), "'float64' is no field of a message");
        assert_eq!(refused("float64[x] y", &[]), "'float64[x] y' is no field of a message");
        assert_eq!(refused("float64[] y", &[0, 1, 0, 0, 255, 255, 255, 255]), "a message is cut off");
        assert!(refused("float64 y", &[0, 7, 0, 0]).contains("representation 7"));
        let empty = "E[] e\n===\nMSG: lab/E";
        assert_eq!(refused(empty, &[0, 1, 0, 0, 2, 0, 0, 0, 9, 9]), "the message lab/E has no fields");
        assert_eq!(refused("uint8[0] y", &[]), "'uint8[0] y' is no field of a message");
    }
}
