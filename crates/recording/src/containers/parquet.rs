//! Parquet files: a signal per column of numbers. A column with a list of equal length per row has a signal per element.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::thread;

use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type as Physical};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::schema::types::Type;

use super::bytes::Wide;
use super::{Array, Container, Fault, Format, guarded};
use crate::error::Problem;
use crate::room::{Room, check_depth};

const BATCH: usize = 1 << 16;

const MAX_FOOTER_BYTES: u32 = 4 << 20;

/// The library recurses into groups: a group has at least eight bytes in the footer and takes at most 2 KiB of stack.
const STACK_BYTES: usize = 1 << 20;
const STACK_BYTES_PER_FOOTER_BYTE: usize = 256;

pub(super) struct Parquet {
    reader: SerializedFileReader<File>,
    arrays: Vec<Array>,
    columns: Vec<usize>,
}

fn damaged(error: ParquetError) -> Problem {
    Format::Parquet.damaged(error)
}

impl Parquet {
    pub(super) fn open(file: File, room: &Room) -> Result<Self, Problem> {
        let reader = reader(file)?;
        let metadata = reader.metadata().file_metadata();
        let rows = usize::try_from(metadata.num_rows()).unwrap_or(usize::MAX);
        let limit = room.limits().max_samples;
        if rows > limit {
            return Err(Problem::TooManySamples { limit });
        }
        let (mut arrays, mut columns, mut left_out) = (vec![], vec![], vec![]);
        for (index, column) in metadata.schema_descr().columns().iter().enumerate() {
            let is_number = !matches!(
                column.physical_type(),
                Physical::BYTE_ARRAY | Physical::FIXED_LEN_BYTE_ARRAY | Physical::INT96
            ) && !matches!(column.converted_type(), ConvertedType::DECIMAL);
            let path = column.path().string();
            if !is_number || column.max_rep_level() > 1 {
                let kind = if is_number { "lists of lists" } else { "no numbers" };
                left_out.push(format!("{path} has {kind}"));
                continue;
            }
            // The number of values gives the length of the lists.
            let values: i64 = reader.metadata().row_groups().iter().map(|group| group.column(index).num_values()).sum();
            let length = usize::try_from(values).unwrap_or(0) / rows.max(1);
            let is_list = column.max_rep_level() == 1;
            if is_list && length == 0 {
                left_out.push(format!("{path} has empty lists"));
            } else if is_list && length.checked_mul(rows) != usize::try_from(values).ok() {
                left_out.push(format!("{path} has lists of different lengths"));
            } else {
                let unit = match column.logical_type_ref() {
                    Some(LogicalType::Timestamp(stamp)) => Some(time_unit(&stamp.unit)),
                    _ => None,
                };
                // Writers name the element of a list `x.list.element` or `x.list.item`.
                let name = if is_list { path.split(".list.").next().unwrap_or(&path) } else { &path };
                let dims = if is_list { vec![rows, length] } else { vec![rows] };
                arrays.push(Array { unit: unit.map(str::to_owned), ..Array::in_room(name, dims, room)? });
                columns.push(index);
            }
        }
        if arrays.is_empty() || rows < 2 {
            return Err(Problem::no_signal(Format::Parquet, &left_out));
        }
        Ok(Self { reader, arrays, columns })
    }

    fn column(&self, index: usize, room: &Room) -> Result<Vec<f64>, Fault> {
        let rows = self.arrays[index].len();
        let mut values = Vec::new();
        let metadata = self.reader.metadata();
        let column = self.columns[index];
        let stated = |size: i64| u64::try_from(size).unwrap_or(0);
        let sizes = metadata.row_groups().iter().map(|group| stated(group.column(column).uncompressed_size()));
        room.check(sizes.fold(0, u64::saturating_add))?;
        let described = metadata.file_metadata().schema_descr().column(column);
        let length = self.arrays[index].dims.get(1).copied().unwrap_or(1);
        let list = List { rows: self.arrays[index].dims[0], length, defined: described.max_def_level() };
        let mut wide = Wide::default();
        for group in 0..metadata.num_row_groups() {
            let group = self.reader.get_row_group(group).map_err(damaged)?;
            let reader = group.get_column_reader(column).map_err(damaged)?;
            let into = &mut values;
            match reader {
                ColumnReader::BoolColumnReader(column) => numbers(column, list, into, |value| f64::from(*value)),
                ColumnReader::Int32ColumnReader(column) => numbers(column, list, into, |value| f64::from(*value)),
                ColumnReader::Int64ColumnReader(column) => numbers(column, list, into, |value| wide.number(*value)),
                ColumnReader::FloatColumnReader(column) => numbers(column, list, into, |value| f64::from(*value)),
                ColumnReader::DoubleColumnReader(column) => numbers(column, list, into, |value| *value),
                _ => Ok(()),
            }
            .map_err(damaged)?;
        }
        if values.len() != rows {
            let reason = "a column has fewer values than the file has rows, or lists of different lengths";
            return Err(Format::Parquet.damaged(reason).into());
        }
        Ok(values)
    }
}

fn reader(mut file: File) -> Result<SerializedFileReader<File>, Problem> {
    // The library reports a file without them.
    let mut size = [0; 4];
    let mut tail = || {
        file.seek(SeekFrom::End(-8))?;
        file.read_exact(&mut size)
    };
    let footer_bytes = tail().map_or(0, |()| u32::from_le_bytes(size));
    if footer_bytes > MAX_FOOTER_BYTES {
        let part = format!("a footer of {footer_bytes} bytes").into();
        return Err(Problem::OverLimit { part, limit: MAX_FOOTER_BYTES as usize });
    }
    let open = move || {
        let reader = SerializedFileReader::new(file).map_err(damaged)?;
        let mut level: Vec<&Type> = vec![reader.metadata().file_metadata().schema()];
        for depth in 0.. {
            check_depth(depth)?;
            level = level
                .iter()
                .filter(|group| group.is_group())
                .flat_map(|group| group.get_fields())
                .map(|part| &**part)
                .collect();
            if level.is_empty() {
                break;
            }
        }
        Ok(reader)
    };
    let stack_bytes = STACK_BYTES + STACK_BYTES_PER_FOOTER_BYTE * footer_bytes as usize;
    let thread = thread::Builder::new().stack_size(stack_bytes).spawn(|| guarded(Format::Parquet, open));
    let opened = thread.map_err(Problem::Unreadable)?.join();
    opened.unwrap_or_else(|_| Err(Format::Parquet.damaged("its footer contradicts itself")))
}

fn time_unit(unit: &TimeUnit) -> &'static str {
    match unit {
        TimeUnit::MILLIS => "ms",
        TimeUnit::MICROS => "us",
        TimeUnit::NANOS => "ns",
    }
}

/// Without lists the length is 1.
#[derive(Clone, Copy)]
struct List {
    rows: usize,
    length: usize,
    /// The definition level of a defined value.
    defined: i16,
}

fn numbers<T: DataType>(
    mut column: ColumnReaderImpl<T>,
    List { rows, length, defined }: List,
    values: &mut Vec<f64>,
    mut number: impl FnMut(&T::T) -> f64,
) -> Result<(), ParquetError> {
    let (mut read, mut levels, mut lists) = (vec![], vec![], vec![]);
    while values.len() < rows * length {
        read.clear();
        levels.clear();
        lists.clear();
        let records = BATCH.min(rows - values.len() / length);
        let (records, ..) = column.read_records(records, Some(&mut levels), Some(&mut lists), &mut read)?;
        if records == 0 {
            break;
        }
        // A new row has the repetition level 0.
        let is_uneven = |(at, level): (usize, &i16)| (*level == 0) != (at % length == 0);
        if lists.iter().enumerate().any(is_uneven) {
            return Err(ParquetError::General("the lists of a column have different lengths".into()));
        }
        if defined == 0 {
            values.extend(read.iter().map(&mut number));
        } else {
            let mut read = read.iter();
            let mut value =
                |level: &i16| if *level == defined { read.next().map_or(f64::NAN, &mut number) } else { f64::NAN };
            values.extend(levels.iter().map(&mut value));
        }
    }
    Ok(())
}

impl Container for Parquet {
    fn arrays(&self) -> &[Array] {
        &self.arrays
    }

    fn values(&mut self, index: usize, room: &Room) -> Result<Vec<f64>, Fault> {
        guarded(Format::Parquet, || self.column(index, room))
    }
}
