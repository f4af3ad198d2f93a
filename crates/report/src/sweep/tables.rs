//! A sweep's rows as Parquet and as CSV: case number, values of the axes, seed, outcome, metrics.

use std::io::{self, Write};
use std::sync::Arc;

use parquet::basic::{Compression, ConvertedType, Encoding, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::tables::quoted;
use trocar_document::shortest;
use trocar_scenario::Value;
use trocar_studies::sweep::{AxisColumn, Design, Outcome, Rows, SweepError, text};

/// Rows of a Parquet row group, which is held in memory.
const GROUP_ROWS: usize = 1 << 16;

/// Name of the column with the numbers of the cases.
const CASE: &str = "case";

/// A column of a group of rows.
enum Column {
    Given(AxisColumn),
    /// Values, NaN if undefined; and whether the metric is a count.
    Metric(Vec<f64>, bool),
}

impl Column {
    fn field(&self, name: &str) -> Result<Arc<Type>, ParquetError> {
        let (physical, converted) = match self {
            Self::Given(AxisColumn::Whole(_)) | Self::Metric(_, true) => (Physical::INT64, ConvertedType::NONE),
            Self::Given(AxisColumn::Number(_)) | Self::Metric(_, false) => (Physical::DOUBLE, ConvertedType::NONE),
            Self::Given(AxisColumn::Text(_)) => (Physical::BYTE_ARRAY, ConvertedType::UTF8),
            Self::Given(AxisColumn::Flag(_)) => (Physical::BOOLEAN, ConvertedType::NONE),
        };
        let is_optional = matches!(self, Self::Metric(..));
        let repetition = if is_optional { Repetition::OPTIONAL } else { Repetition::REQUIRED };
        let field = Type::primitive_type_builder(name, physical).with_converted_type(converted);
        Ok(Arc::new(field.with_repetition(repetition).build()?))
    }
}

/// Returns the names of all columns.
fn names(design: &Design) -> Vec<String> {
    let axes = design.axes.iter().map(|axis| axis.key.path.to_string());
    let metrics = design.columns.iter().map(|column| column.name.clone());
    std::iter::once(CASE.to_owned())
        .chain(axes)
        .chain(["seed".to_owned(), "outcome".to_owned()])
        .chain(metrics)
        .collect()
}

/// The columns of a row group.
struct Group<'a> {
    design: &'a Design,
    columns: Vec<Column>,
    rows: usize,
}

impl<'a> Group<'a> {
    fn new(design: &'a Design) -> Self {
        let (case, seed, outcome) = (AxisColumn::Whole(vec![]), AxisColumn::Whole(vec![]), AxisColumn::Text(vec![]));
        let given = std::iter::once(case).chain(design.axes.iter().map(AxisColumn::of)).chain([seed, outcome]);
        let mut columns: Vec<Column> = given.map(Column::Given).collect();
        columns.extend(design.columns.iter().map(|column| Column::Metric(vec![], column.is_count())));
        Self { design, columns, rows: 0 }
    }

    fn push(&mut self, case: u64, values: &[Value], outcome: Outcome, metrics: &[f64]) {
        let seed = self.design.seed(case);
        let given = [Value::Whole(case)].into_iter().chain(values.iter().cloned());
        let given = given.chain([Value::Whole(seed), Value::Text(outcome.word().into())]);
        let (mut given, mut metrics) = (given, metrics.iter());
        for column in &mut self.columns {
            match column {
                Column::Given(column) => given.by_ref().take(1).for_each(|value| column.push(&value)),
                Column::Metric(column, _) => column.extend(metrics.next()),
            }
        }
        self.rows += 1;
    }

    fn write<W: Write + Send>(&mut self, file: &mut SerializedFileWriter<W>) -> Result<(), ParquetError> {
        let mut group = file.next_row_group()?;
        for column in &mut self.columns {
            let Some(mut writer) = group.next_column()? else { break };
            match column {
                Column::Given(AxisColumn::Whole(values)) => {
                    writer.typed::<Int64Type>().write_batch(values, None, None)?;
                }
                Column::Given(AxisColumn::Number(values)) => {
                    writer.typed::<DoubleType>().write_batch(values, None, None)?;
                }
                Column::Given(AxisColumn::Text(values)) => {
                    let texts: Vec<ByteArray> = values.drain(..).map(|text| text.into_bytes().into()).collect();
                    writer.typed::<ByteArrayType>().write_batch(&texts, None, None)?;
                }
                Column::Given(AxisColumn::Flag(values)) => {
                    writer.typed::<BoolType>().write_batch(values, None, None)?;
                }
                Column::Metric(values, is_count) => {
                    let levels: Vec<i16> = values.iter().map(|value| i16::from(!value.is_nan())).collect();
                    let defined = values.iter().filter(|value| !value.is_nan());
                    if *is_count {
                        let whole: Vec<i64> = defined.map(|value| *value as i64).collect();
                        writer.typed::<Int64Type>().write_batch(&whole, Some(&levels), None)?;
                    } else {
                        let numbers: Vec<f64> = defined.copied().collect();
                        writer.typed::<DoubleType>().write_batch(&numbers, Some(&levels), None)?;
                    }
                }
            }
            writer.close()?;
        }
        group.close()?;
        for column in &mut self.columns {
            match column {
                Column::Given(values) => values.clear(),
                Column::Metric(values, _) => values.clear(),
            }
        }
        self.rows = 0;
        Ok(())
    }
}

/// Writes the rows as Parquet. The same rows give the same bytes.
///
/// # Errors
/// Returns the errors of the rows unchanged, and [`SweepError::Io`] if writing fails.
pub fn write_sweep_parquet(
    design: &Design,
    hash: &str,
    rows: &Rows,
    out: &mut (dyn Write + Send),
) -> Result<(), SweepError> {
    let failed = |error: ParquetError| SweepError::Io { path: "cases.parquet".into(), source: io::Error::other(error) };
    let mut group = Group::new(design);
    let fields: Result<Vec<_>, _> = names(design).iter().zip(&group.columns).map(|(name, c)| c.field(name)).collect();
    let schema =
        fields.and_then(|fields| Type::group_type_builder("sweep").with_fields(fields).build()).map_err(failed)?;
    let metadata = vec![KeyValue::new("trocar.sweep_sha256".to_owned(), hash.to_owned())];
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        // They count up, mostly by 1, and none occurs twice.
        .set_column_dictionary_enabled(CASE.into(), false)
        .set_column_encoding(CASE.into(), Encoding::DELTA_BINARY_PACKED)
        .set_created_by(format!("trocar {}", env!("CARGO_PKG_VERSION")))
        .set_key_value_metadata(Some(metadata))
        .build();
    let mut file = SerializedFileWriter::new(out, Arc::new(schema), Arc::new(properties)).map_err(failed)?;
    let (sampler, mut coordinates, mut values) = (design.coordinates(), vec![], vec![]);
    rows.each(|case, outcome, metrics| {
        sampler.values(case, &mut coordinates, &mut values);
        group.push(case, &values, outcome, metrics);
        if group.rows == GROUP_ROWS { group.write(&mut file).map_err(failed) } else { Ok(()) }
    })?;
    if group.rows > 0 {
        group.write(&mut file).map_err(failed)?;
    }
    file.close().map_err(failed)?;
    Ok(())
}

/// Writes the rows as CSV. Floats have the shortest form that reads back to the same value. An undefined value is an empty cell.
///
/// # Errors
/// Returns the errors of the rows unchanged, and [`SweepError::Io`] if writing fails.
pub fn write_sweep_csv(design: &Design, rows: &Rows, out: &mut dyn Write) -> Result<(), SweepError> {
    let failed = |source: io::Error| SweepError::Io { path: "cases.csv".into(), source };
    writeln!(out, "{}", names(design).join(",")).map_err(failed)?;
    let (sampler, mut coordinates, mut values) = (design.coordinates(), vec![], vec![]);
    let (mut line, mut buffer) = (String::new(), ryu::Buffer::new());
    rows.each(|case, outcome, metrics| {
        sampler.values(case, &mut coordinates, &mut values);
        line.clear();
        line.push_str(&case.to_string());
        for value in &values {
            line.push(',');
            match value {
                Value::Number(number) => line.push_str(buffer.format(*number)),
                other => line.push_str(&quoted(&text(other))),
            }
        }
        line.push_str(&format!(",{},{}", design.seed(case), outcome.word()));
        for (column, metric) in design.columns.iter().zip(metrics) {
            line.push(',');
            if column.is_count() && !metric.is_nan() {
                line.push_str(&(*metric as i64).to_string());
            } else if !metric.is_nan() {
                line.push_str(&shortest(*metric));
            }
        }
        line.push('\n');
        out.write_all(line.as_bytes()).map_err(failed)
    })
}
