//! Columns of a run or a detection as CSV, Parquet, MATLAB files and MCAP logs. The same columns give the same bytes.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::sync::Arc;

use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{McapResult, WriteOptions};
use parquet::basic::{Compression, ConvertedType, Repetition, Type as Physical};
use parquet::data_type::{DoubleType, Int32Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use trocar_engine::engine::ColumnValues;

/// A column: its name with its unit, and its values.
pub(super) type Column<'a> = (&'a str, ColumnValues<&'a [f64], &'a [u8]>);

/// The format of a file of columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnFormat {
    /// Text with a line per row.
    Csv,
    /// Apache Parquet.
    Parquet,
    /// MATLAB, version 5 to 7: a variable per column.
    Mat,
    /// MCAP: a message of ROS 2 per row.
    Mcap,
}

impl ColumnFormat {
    /// All formats.
    pub const ALL: [Self; 4] = [Self::Csv, Self::Parquet, Self::Mat, Self::Mcap];

    /// Its word on the command line, which is the suffix of its files.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Parquet => "parquet",
            Self::Mat => "mat",
            Self::Mcap => "mcap",
        }
    }

    /// Writes columns, the first of which is the time in seconds. `topic` names their rows in a log.
    pub(super) fn write(self, topic: &str, columns: &[Column<'_>], out: &mut (dyn Write + Send)) -> io::Result<()> {
        match self {
            Self::Csv => csv(columns, out),
            Self::Parquet => parquet(columns, out).map_err(io::Error::other),
            Self::Mat => mat(columns, out),
            Self::Mcap => mcap(topic, columns, out).map_err(io::Error::other),
        }
    }
}

fn rows(columns: &[Column<'_>]) -> usize {
    columns.first().map_or(0, |(_, values)| match values {
        ColumnValues::Numbers(numbers) => numbers.len(),
        ColumnValues::Codes(codes) => codes.len(),
    })
}

/// Writes columns as CSV. Floats have the shortest form that reads back to the same value.
pub(super) fn csv(columns: &[Column<'_>], out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "{}", columns.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(","))?;
    let mut buffer = ryu::Buffer::new();
    let mut line = String::with_capacity(400);
    for row in 0..rows(columns) {
        line.clear();
        for (_, column) in columns {
            match column {
                ColumnValues::Numbers(numbers) => line.push_str(buffer.format(numbers[row])),
                ColumnValues::Codes(codes) => line.push_str(&codes[row].to_string()),
            }
            line.push(',');
        }
        line.pop();
        line.push('\n');
        out.write_all(line.as_bytes())?;
    }
    Ok(())
}

fn parquet(columns: &[Column<'_>], out: &mut (dyn Write + Send)) -> Result<(), ParquetError> {
    let field = |(name, values): &Column<'_>| {
        let (physical, converted) = match values {
            ColumnValues::Numbers(_) => (Physical::DOUBLE, ConvertedType::NONE),
            ColumnValues::Codes(_) => (Physical::INT32, ConvertedType::UINT_8),
        };
        let field = Type::primitive_type_builder(name, physical).with_converted_type(converted);
        Ok(Arc::new(field.with_repetition(Repetition::REQUIRED).build()?))
    };
    let fields = columns.iter().map(field).collect::<Result<Vec<_>, ParquetError>>()?;
    let schema = Type::group_type_builder("columns").with_fields(fields).build()?;
    let version = KeyValue::new("trocar.version".to_owned(), env!("CARGO_PKG_VERSION").to_owned());
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_created_by(format!("trocar {}", env!("CARGO_PKG_VERSION")))
        .set_key_value_metadata(Some(vec![version]))
        .build();
    let mut file = SerializedFileWriter::new(out, Arc::new(schema), Arc::new(properties))?;
    let mut group = file.next_row_group()?;
    for (_, values) in columns {
        let Some(mut writer) = group.next_column()? else { break };
        match values {
            ColumnValues::Numbers(numbers) => writer.typed::<DoubleType>().write_batch(numbers, None, None)?,
            ColumnValues::Codes(codes) => {
                let codes: Vec<i32> = codes.iter().copied().map(i32::from).collect();
                writer.typed::<Int32Type>().write_batch(&codes, None, None)?
            }
        };
        writer.close()?;
    }
    group.close()?;
    file.close()?;
    Ok(())
}

/// Writes columns as an MCAP log: a message of ROS 2 per row, with a field per column. A message's time is that of its row, from 0
/// or from the first row if that is negative.
fn mcap(topic: &str, columns: &[Column<'_>], out: &mut (dyn Write + Send)) -> McapResult<()> {
    let mut definition = String::new();
    for (name, values) in columns {
        let kind = match values {
            ColumnValues::Numbers(_) => "float64",
            ColumnValues::Codes(_) => "uint8",
        };
        definition.push_str(&format!("{kind} {name}\n"));
    }
    let mut log = WriteOptions::new()
        .compression(None)
        .profile("ros2")
        .library(format!("trocar {}", env!("CARGO_PKG_VERSION")))
        .disable_seeking(true)
        .create(NoSeek::new(out))?;
    let schema = log.add_schema("trocar/msg/Row", "ros2msg", definition.as_bytes())?;
    let channel_id = log.add_channel(schema, &format!("/trocar/{topic}"), "cdr", &BTreeMap::new())?;
    let time_ns = |row: usize| match columns.first() {
        Some((_, ColumnValues::Numbers(times))) => (1e9 * (times[row] - times[0].min(0.0))).round() as u64,
        _ => 0,
    };
    // CDR aligns a number to its size, from the end of the four bytes that give the order of the bytes.
    const HEADER: [u8; 4] = [0, 1, 0, 0];
    let mut message = vec![];
    for row in 0..rows(columns) {
        message.clear();
        message.extend_from_slice(&HEADER);
        for (_, column) in columns {
            match column {
                ColumnValues::Numbers(numbers) => {
                    message.resize(HEADER.len() + (message.len() - HEADER.len()).next_multiple_of(8), 0);
                    message.extend_from_slice(&numbers[row].to_le_bytes());
                }
                ColumnValues::Codes(codes) => message.push(codes[row]),
            }
        }
        let time_ns = time_ns(row);
        let header = MessageHeader { channel_id, sequence: row as u32, log_time: time_ns, publish_time: time_ns };
        log.write_to_known_channel(&header, &message)?;
    }
    log.finish()?;
    Ok(())
}

/// Writes columns as a MATLAB file, uncompressed: an array of N x 1 per column. The header has no date.
fn mat(columns: &[Column<'_>], out: &mut dyn Write) -> io::Result<()> {
    const MATRIX: u32 = 14;
    let text = format!("MATLAB 5.0 MAT-file, written by trocar {}", env!("CARGO_PKG_VERSION"));
    out.write_all(format!("{text:<116}").as_bytes())?;
    out.write_all(&[0; 8])?;
    out.write_all(&0x0100_u16.to_le_bytes())?;
    out.write_all(b"IM")?;
    for (name, values) in columns {
        let rows = match values {
            ColumnValues::Numbers(numbers) => numbers.len(),
            ColumnValues::Codes(codes) => codes.len(),
        };
        // The classes double and uint8, with the types of their elements.
        let (class, kind, size) = match values {
            ColumnValues::Numbers(_) => (6_u32, 9, 8 * rows),
            ColumnValues::Codes(_) => (9, 2, rows),
        };
        let mut head = vec![];
        element(&mut head, 6, &[class.to_le_bytes(), [0; 4]].concat());
        element(&mut head, 5, &[count(rows)?.to_le_bytes(), 1_u32.to_le_bytes()].concat());
        element(&mut head, 1, name.as_bytes());
        let padding = (8 - size % 8) % 8;
        out.write_all(&MATRIX.to_le_bytes())?;
        out.write_all(&count(head.len() + 8 + size + padding)?.to_le_bytes())?;
        out.write_all(&head)?;
        out.write_all(&(kind as u32).to_le_bytes())?;
        out.write_all(&count(size)?.to_le_bytes())?;
        match values {
            ColumnValues::Numbers(numbers) => {
                for number in *numbers {
                    out.write_all(&number.to_le_bytes())?;
                }
            }
            ColumnValues::Codes(codes) => out.write_all(codes)?,
        }
        out.write_all(&[0; 8][..padding])?;
    }
    Ok(())
}

/// A size of the MATLAB format, which has 32 bits.
fn count(size: usize) -> io::Result<u32> {
    u32::try_from(size)
        .map_err(|_| io::Error::other("a column is longer than 4 GiB, the limit of MATLAB files; use Parquet"))
}

fn element(bytes: &mut Vec<u8>, kind: u32, content: &[u8]) {
    bytes.extend_from_slice(&kind.to_le_bytes());
    bytes.extend_from_slice(&(content.len() as u32).to_le_bytes());
    bytes.extend_from_slice(content);
    bytes.resize(bytes.len().next_multiple_of(8), 0);
}
