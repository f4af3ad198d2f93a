//! Equal columns give equal bytes.

use std::borrow::Cow;
use std::fmt;
use std::io::{self, Write};
use std::sync::Arc;

use parquet::basic::{Compression, ConvertedType, Encoding, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int32Type, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{ColumnPath, Type};

use trocar_document::{DataColumn, DataTable, Values};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnFormat {
    Csv,
    Parquet,
    /// MATLAB, version 5 to 7: one variable per column.
    Mat,
}

impl ColumnFormat {
    pub const ALL: [Self; 3] = [Self::Csv, Self::Parquet, Self::Mat];

    /// MATLAB files contain only numbers and codes.
    pub fn write(self, table: &DataTable<'_>, out: &mut (dyn Write + Send)) -> io::Result<()> {
        match self {
            Self::Csv | Self::Parquet => self.write_parts(out, |part| part(table)),
            Self::Mat => mat(&sampled(table)?, out),
        }
    }

    /// Writes rows in parts, which need not fit into memory together. `parts` passes tables with the same columns.
    /// Parquet writes a row group for each.
    pub fn write_parts<E: From<io::Error>>(
        self,
        out: &mut (dyn Write + Send),
        parts: impl FnOnce(&mut Part<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        match self {
            Self::Csv => {
                let mut is_first = true;
                parts(&mut |part| {
                    if std::mem::take(&mut is_first) {
                        csv_heading(part, out)?;
                    }
                    csv_rows(part, out)
                })
            }
            Self::Parquet => {
                let (mut file, mut out) = (None, Some(out));
                parts(&mut |part| {
                    if let Some(out) = out.take() {
                        file = Some(parquet_file(part, out).map_err(io::Error::other)?);
                    }
                    file.as_mut().map_or(Ok(()), |file| parquet_rows(part, file)).map_err(io::Error::other)
                })?;
                let end = file.map_or(Ok(()), |file| file.close().map(|_| ()));
                Ok(end.map_err(io::Error::other)?)
            }
            Self::Mat => Err(io::Error::other("only CSV and Parquet are written in parts").into()),
        }
    }
}

impl fmt::Display for ColumnFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Csv => "csv",
            Self::Parquet => "parquet",
            Self::Mat => "mat",
        })
    }
}

pub type Part<'a> = dyn FnMut(&DataTable<'_>) -> io::Result<()> + 'a;

type Sampled<'a> = (&'a str, Samples<'a>);

#[derive(Clone, Copy)]
enum Samples<'a> {
    Numbers(&'a [f64]),
    Codes(&'a [u8]),
}

impl Samples<'_> {
    fn len(self) -> usize {
        match self {
            Self::Numbers(numbers) => numbers.len(),
            Self::Codes(codes) => codes.len(),
        }
    }
}

fn sampled<'a>(table: &'a DataTable<'_>) -> io::Result<Vec<Sampled<'a>>> {
    let column = |DataColumn { name, values }: &'a DataColumn<'_>| match values {
        Values::Numbers(numbers) => Ok((&**name, Samples::Numbers(numbers))),
        Values::Codes(codes) => Ok((&**name, Samples::Codes(codes))),
        _ => Err(io::Error::other(format!("the column {name} has neither numbers nor codes; write CSV or Parquet"))),
    };
    table.columns.iter().map(column).collect()
}

fn csv_heading(table: &DataTable<'_>, out: &mut dyn Write) -> io::Result<()> {
    let names: Vec<_> = table.columns.iter().map(|column| quoted(&column.name)).collect();
    writeln!(out, "{}", names.join(","))
}

/// Floats have the shortest form that reads back to the same value; an undefined value is an empty cell.
fn csv_rows(table: &DataTable<'_>, out: &mut dyn Write) -> io::Result<()> {
    let mut number = ryu::Buffer::new();
    let mut line = String::with_capacity(400);
    for row in 0..table.rows() {
        line.clear();
        for column in &table.columns {
            match &column.values {
                Values::Numbers(values) => line.push_str(number.format(values[row])),
                Values::Optional(values) => {
                    line.push_str(values[row].map_or("", |value| number.format(value)));
                }
                Values::Whole(values) => line.push_str(&values[row].to_string()),
                Values::OptionalWhole(values) => {
                    line.push_str(&values[row].map_or(String::new(), |value| value.to_string()));
                }
                Values::Codes(values) => line.push_str(&values[row].to_string()),
                Values::Flags(values) => line.push_str(match values[row] {
                    Some(true) => "1",
                    Some(false) => "0",
                    None => "",
                }),
                Values::Switches(values) => line.push_str(if values[row] { "true" } else { "false" }),
                Values::Texts(values) => line.push_str(&quoted(&values[row])),
            }
            line.push(',');
        }
        line.pop();
        line.push('\n');
        out.write_all(line.as_bytes())?;
    }
    Ok(())
}

fn quoted(text: &str) -> Cow<'_, str> {
    if text.contains([',', '"']) { format!("\"{}\"", text.replace('"', "\"\"")).into() } else { text.into() }
}

type ParquetFile<'a> = SerializedFileWriter<&'a mut (dyn Write + Send)>;

fn parquet_file<'a>(table: &DataTable<'_>, out: &'a mut (dyn Write + Send)) -> Result<ParquetFile<'a>, ParquetError> {
    let field = |DataColumn { name, values }: &DataColumn<'_>| {
        let (physical, converted) = match values {
            Values::Numbers(_) | Values::Optional(_) => (Physical::DOUBLE, ConvertedType::NONE),
            Values::Whole(_) | Values::OptionalWhole(_) => (Physical::INT64, ConvertedType::NONE),
            Values::Codes(_) => (Physical::INT32, ConvertedType::UINT_8),
            Values::Flags(_) | Values::Switches(_) => (Physical::BOOLEAN, ConvertedType::NONE),
            Values::Texts(_) => (Physical::BYTE_ARRAY, ConvertedType::UTF8),
        };
        let is_optional = matches!(values, Values::Optional(_) | Values::OptionalWhole(_) | Values::Flags(_));
        let repetition = if is_optional { Repetition::OPTIONAL } else { Repetition::REQUIRED };
        let field = Type::primitive_type_builder(name, physical).with_converted_type(converted);
        Ok(Arc::new(field.with_repetition(repetition).build()?))
    };
    let fields = table.columns.iter().map(field).collect::<Result<Vec<_>, ParquetError>>()?;
    let schema = Type::group_type_builder("columns").with_fields(fields).build()?;
    let version = ("trocar.version", env!("CARGO_PKG_VERSION").to_owned());
    let metadata = std::iter::once(version).chain(table.metadata.iter().cloned());
    let metadata = metadata.map(|(key, value)| KeyValue::new(key.to_owned(), value)).collect();
    let mut properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_created_by(format!("trocar {}", env!("CARGO_PKG_VERSION")))
        .set_key_value_metadata(Some(metadata));
    for column in table.columns.iter().filter(|column| matches!(column.values, Values::Whole(_))) {
        // Delta encoding suits case numbers, which increase, mostly by 1, and are unique.
        let path = ColumnPath::from(&*column.name);
        properties = properties
            .set_column_dictionary_enabled(path.clone(), false)
            .set_column_encoding(path, Encoding::DELTA_BINARY_PACKED);
    }
    SerializedFileWriter::new(out, Arc::new(schema), Arc::new(properties.build()))
}

fn parquet_rows(table: &DataTable<'_>, file: &mut ParquetFile<'_>) -> Result<(), ParquetError> {
    let mut group = file.next_row_group()?;
    for column in &table.columns {
        let Some(mut writer) = group.next_column()? else { break };
        match &column.values {
            Values::Numbers(values) => required::<DoubleType>(&mut writer, values)?,
            Values::Optional(values) => optional::<DoubleType>(&mut writer, values.iter().copied())?,
            Values::Whole(values) => {
                required::<Int64Type>(&mut writer, &values.iter().copied().map(signed).collect::<Vec<_>>())?;
            }
            Values::OptionalWhole(values) => {
                optional::<Int64Type>(&mut writer, values.iter().map(|value| value.map(signed)))?;
            }
            Values::Codes(values) => {
                required::<Int32Type>(&mut writer, &values.iter().copied().map(i32::from).collect::<Vec<_>>())?;
            }
            Values::Flags(values) => optional::<BoolType>(&mut writer, values.iter().copied())?,
            Values::Switches(values) => required::<BoolType>(&mut writer, values)?,
            Values::Texts(values) => {
                let texts: Vec<ByteArray> = values.iter().map(|text| ByteArray::from(&**text)).collect();
                required::<ByteArrayType>(&mut writer, &texts)?;
            }
        }
        writer.close()?;
    }
    group.close()?;
    Ok(())
}

fn signed(value: u64) -> i64 {
    i64::try_from(value).unwrap_or(i64::MAX)
}

fn required<T: DataType>(writer: &mut SerializedColumnWriter<'_>, values: &[T::T]) -> Result<(), ParquetError> {
    writer.typed::<T>().write_batch(values, None, None)?;
    Ok(())
}

fn optional<T: DataType>(
    writer: &mut SerializedColumnWriter<'_>,
    values: impl Iterator<Item = Option<T::T>> + Clone,
) -> Result<(), ParquetError> {
    let levels: Vec<i16> = values.clone().map(|value| i16::from(value.is_some())).collect();
    let defined: Vec<T::T> = values.flatten().collect();
    writer.typed::<T>().write_batch(&defined, Some(&levels), None)?;
    Ok(())
}

/// An N x 1 array per column. The header has no date.
fn mat(columns: &[Sampled<'_>], out: &mut dyn Write) -> io::Result<()> {
    const MATRIX: u32 = 14;
    let text = format!("MATLAB 5.0 MAT-file, written by trocar {}", env!("CARGO_PKG_VERSION"));
    out.write_all(format!("{text:<116}").as_bytes())?;
    out.write_all(&[0; 8])?;
    out.write_all(&0x0100_u16.to_le_bytes())?;
    out.write_all(b"IM")?;
    for (name, values) in columns {
        let rows = values.len();
        // The classes double and uint8, with their element types.
        let (class, kind, size) = match values {
            Samples::Numbers(_) => (6_u32, 9, 8 * rows),
            Samples::Codes(_) => (9, 2, rows),
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
            Samples::Numbers(numbers) => {
                for number in *numbers {
                    out.write_all(&number.to_le_bytes())?;
                }
            }
            Samples::Codes(codes) => out.write_all(codes)?,
        }
        out.write_all(&[0; 8][..padding])?;
    }
    Ok(())
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn undefined_values_are_empty_cells_and_flags_are_1_and_0() {
        let table = DataTable::new("t")
            .texts("name", ["a,b", "c"])
            .optional("x_m", [Some(0.1), None])
            .flags("is_stable", [true, false])
            .whole("count", [3, 4])
            .with("sample", Values::OptionalWhole(vec![None, Some(5)]))
            .with("is_on", Values::Switches(vec![true, false]));
        let mut text = vec![];
        ColumnFormat::Csv.write(&table, &mut text).expect("written");
        let expected = "name,x_m,is_stable,count,sample,is_on\n\"a,b\",0.1,1,3,,true\nc,,0,4,5,false\n";
        assert_eq!(String::from_utf8(text).expect("text"), expected);
        let error = ColumnFormat::Mat.write(&table, &mut vec![]).expect_err("texts");
        assert!(error.to_string().contains("the column name"), "{error}");
    }

    #[test]
    fn parts_have_one_heading_and_a_format_without_parts_is_rejected() {
        let part = |number: f64| DataTable::new("t").numbers("x_m", [number]);
        let write = |format: ColumnFormat, out: &mut Vec<u8>| {
            format.write_parts(out, |each| [1.0, 2.0].into_iter().try_for_each(|number| each(&part(number))))
        };
        let mut text = vec![];
        write(ColumnFormat::Csv, &mut text).expect("written");
        assert_eq!(text, b"x_m\n1.0\n2.0\n");
        assert!(write(ColumnFormat::Mat, &mut vec![]).is_err());
    }
}
