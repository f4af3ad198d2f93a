//! Parquet files: a signal per column of numbers. Columns of lists and maps are omitted.

use std::fs::File;

use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type as Physical};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};

use super::{Array, Container, Fault, Format, check_size, guarded};
use crate::Limits;
use crate::error::Problem;

const BATCH: usize = 1 << 16;

pub(super) struct Parquet {
    reader: SerializedFileReader<File>,
    arrays: Vec<Array>,
    /// The column index of each array.
    columns: Vec<usize>,
    limits: Limits,
}

fn damaged(error: ParquetError) -> Problem {
    Format::Parquet.damaged(error)
}

impl Parquet {
    pub(super) fn open(file: File, limits: &Limits) -> Result<Self, Problem> {
        let reader = SerializedFileReader::new(file).map_err(damaged)?;
        let metadata = reader.metadata().file_metadata();
        let rows = usize::try_from(metadata.num_rows()).unwrap_or(usize::MAX);
        if rows > limits.max_samples {
            return Err(Problem::TooManySamples { limit: limits.max_samples });
        }
        let (mut arrays, mut columns) = (vec![], vec![]);
        for (index, column) in metadata.schema_descr().columns().iter().enumerate() {
            let is_number = !matches!(
                column.physical_type(),
                Physical::BYTE_ARRAY | Physical::FIXED_LEN_BYTE_ARRAY | Physical::INT96
            ) && !matches!(column.converted_type(), ConvertedType::DECIMAL);
            if column.max_rep_level() == 0 && is_number {
                let unit = match column.logical_type_ref() {
                    Some(LogicalType::Timestamp(stamp)) => Some(time_unit(&stamp.unit)),
                    _ => None,
                };
                arrays.push(Array { unit: unit.map(str::to_owned), ..Array::new(column.path().string(), vec![rows]) });
                columns.push(index);
            }
        }
        if arrays.is_empty() || rows < 2 {
            return Err(Problem::NoSignal(Format::Parquet));
        }
        Ok(Self { reader, arrays, columns, limits: limits.clone() })
    }

    fn column(&self, index: usize) -> Result<Vec<f64>, Fault> {
        let rows = self.arrays[index].dims[0];
        let mut values = Vec::new();
        for group in 0..self.reader.num_row_groups() {
            let group = self.reader.get_row_group(group).map_err(damaged)?;
            match group.get_column_reader(self.columns[index]).map_err(damaged)? {
                ColumnReader::BoolColumnReader(column) => numbers(column, rows, &mut values, |value| f64::from(*value)),
                ColumnReader::Int32ColumnReader(column) => {
                    numbers(column, rows, &mut values, |value| f64::from(*value))
                }
                ColumnReader::Int64ColumnReader(column) => numbers(column, rows, &mut values, |value| *value as f64),
                ColumnReader::FloatColumnReader(column) => {
                    numbers(column, rows, &mut values, |value| f64::from(*value))
                }
                ColumnReader::DoubleColumnReader(column) => numbers(column, rows, &mut values, |value| *value),
                _ => Ok(()),
            }
            .map_err(damaged)?;
        }
        if values.len() != rows {
            return Err(Format::Parquet.damaged("a column has fewer values than the file has rows").into());
        }
        Ok(values)
    }
}

fn time_unit(unit: &TimeUnit) -> &'static str {
    match unit {
        TimeUnit::MILLIS => "ms",
        TimeUnit::MICROS => "us",
        TimeUnit::NANOS => "ns",
    }
}

/// Appends up to `rows` numbers of a column, with NaN for undefined values.
fn numbers<T: DataType>(
    mut column: ColumnReaderImpl<T>,
    rows: usize,
    values: &mut Vec<f64>,
    number: impl Fn(&T::T) -> f64,
) -> Result<(), ParquetError> {
    let (mut read, mut levels) = (vec![], vec![]);
    while values.len() < rows {
        read.clear();
        levels.clear();
        let (records, ..) = column.read_records(BATCH.min(rows - values.len()), Some(&mut levels), None, &mut read)?;
        if records == 0 {
            break;
        }
        // A column without undefined values has no levels.
        if read.len() == records {
            values.extend(read.iter().map(&number));
        } else {
            let defined = levels.iter().copied().max().unwrap_or(0);
            let mut read = read.iter();
            let value = |level: &i16| if *level == defined { read.next().map_or(f64::NAN, &number) } else { f64::NAN };
            values.extend(levels.iter().map(value));
        }
    }
    Ok(())
}

impl Container for Parquet {
    fn arrays(&self) -> &[Array] {
        &self.arrays
    }

    fn values(&mut self, index: usize) -> Result<Vec<f64>, Fault> {
        check_size(self.arrays[index].len(), &self.limits)?;
        guarded(Format::Parquet, || self.column(index))
    }
}
