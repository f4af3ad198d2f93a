//! Apache Arrow in a file, which is also Feather, version 2: a signal per column of numbers. A column with a list of equal
//! length per row has a signal per element.

use std::io::Cursor;
use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::types::{
    DurationMicrosecondType, DurationMillisecondType, DurationNanosecondType, DurationSecondType, Float32Type,
    Float64Type, Int8Type, Int16Type, Int32Type, Int64Type, TimestampMicrosecondType, TimestampMillisecondType,
    TimestampNanosecondType, TimestampSecondType, UInt8Type, UInt16Type, UInt32Type, UInt64Type,
};
use arrow_array::{Array as _, ArrayRef, ArrowPrimitiveType, PrimitiveArray};
use arrow_ipc::reader::FileReader;
use arrow_schema::{ArrowError, DataType, TimeUnit};

use super::bytes::Wide;
use super::{Array, Format, Loaded, unpack};
use crate::budget::{Budget, recover};
use crate::error::Problem;

fn damaged(error: ArrowError) -> Problem {
    Format::Arrow.damaged(error)
}

pub(super) fn open(bytes: Vec<u8>, budget: &Budget) -> Result<Loaded, Problem> {
    check_blocks(&bytes, budget)?;
    let limit = budget.limits().max_samples;
    let reader = FileReader::try_new(Cursor::new(bytes), None).map_err(damaged)?;
    let schema = reader.schema();
    let mut columns: Vec<Column> = schema.fields().iter().map(|field| Column::new(field.data_type())).collect();
    let mut rows = 0_usize;
    for batch in reader {
        let batch = batch.map_err(damaged)?;
        rows += batch.num_rows();
        if rows > limit {
            return Err(Problem::TooManySamples { limit });
        }
        for (column, array) in columns.iter_mut().zip(batch.columns()) {
            column.push(array, budget)?;
        }
    }
    let (mut arrays, mut values, mut left_out) = (vec![], vec![], vec![]);
    for (field, column) in schema.fields().iter().zip(columns) {
        if let Some(reason) = column.left_out {
            left_out.push(format!("{} {reason}", field.name()));
            continue;
        }
        let dims = column.length.map_or(vec![rows], |length| vec![rows, length]);
        arrays.push(Array { unit: column.unit.map(str::to_owned), ..budget.array(field.name(), dims)? });
        values.push(column.values);
    }
    Loaded::new(Format::Arrow, arrays, values, &left_out)
}

const PART: &str = "decompressed content";

/// Work of a block besides its bytes, and work per byte of its description.
const BLOCK_BYTES: usize = 4096;
const BYTES_PER_DESCRIPTION: usize = 16;

/// Largest ratio of a decompressed size to the compressed one, of LZ4.
const MAX_EXPANSION: usize = 256;

/// Checks that the stated sizes of the compressed buffers are within the limit, because the library allocates them. The
/// stated size is the first eight bytes of a buffer.
fn check_blocks(bytes: &[u8], budget: &Budget) -> Result<(), Problem> {
    let cut_off = || Format::Arrow.damaged("it is cut off");
    let at = |from: usize, length: usize| bytes.get(from..from.checked_add(length)?);
    // The file ends with the footer, its size in four bytes, and six bytes of the signature.
    let end = bytes.len().checked_sub(10).ok_or_else(cut_off)?;
    let size =
        at(end, 4).and_then(|size| size.first_chunk()).map(|size| i32::from_le_bytes(*size)).ok_or_else(cut_off)?;
    let from = usize::try_from(size).ok().and_then(|size| end.checked_sub(size)).ok_or_else(cut_off)?;
    let invalid = |error| Format::Arrow.damaged(error);
    let footer = arrow_ipc::root_as_footer(&bytes[from..end]).map_err(invalid)?;
    let batches = footer.recordBatches().into_iter().flatten().map(|block| (block, true));
    let dictionaries = footer.dictionaries().into_iter().flatten().map(|block| (block, false));
    let mut largest = 0_usize;
    for (block, is_batch) in batches.chain(dictionaries) {
        let offset = usize::try_from(block.offset()).map_err(|_| cut_off())?;
        let length = usize::try_from(block.metaDataLength()).map_err(|_| cut_off())?;
        let metadata = at(offset, length).ok_or_else(cut_off)?;
        // The footer can name a block many times. The library reads all of it each time.
        let body = usize::try_from(block.bodyLength()).map_err(|_| cut_off())?;
        budget.work("blocks", BLOCK_BYTES + length.saturating_mul(BYTES_PER_DESCRIPTION).saturating_add(body))?;
        // A message begins with its size, after a mark in newer versions.
        let skip = if metadata.starts_with(&[0xff; 4]) { 8 } else { 4 };
        let message = arrow_ipc::root_as_message(metadata.get(skip..).unwrap_or_default()).map_err(invalid)?;
        let batch =
            message.header_as_record_batch().or_else(|| message.header_as_dictionary_batch().and_then(|d| d.data()));
        let Some(batch) = batch.filter(|batch| batch.compression().is_some()) else { continue };
        let mut all = 0_usize;
        for buffer in batch.buffers().into_iter().flatten() {
            let place = usize::try_from(buffer.offset()).ok().and_then(|place| (offset + length).checked_add(place));
            let stated = place.and_then(|place| at(place, 8)).and_then(|bytes| bytes.first_chunk());
            let stated = stated.map_or(0, |bytes| i64::from_le_bytes(*bytes)).max(0);
            let stated = usize::try_from(stated).unwrap_or(usize::MAX);
            let packed = usize::try_from(buffer.length()).unwrap_or(0);
            // The library compares the stated size after it has decompressed the buffer.
            if packed.saturating_mul(MAX_EXPANSION) > budget.left() {
                let packed = place.and_then(|place| at(place + 8, packed.saturating_sub(8))).ok_or_else(cut_off)?;
                let size = unpack::lz4(packed, budget).map_err(|error| recover(Format::Arrow, error))?.len();
                budget.release(size);
            }
            budget.work(PART, stated)?;
            all = all.saturating_add(stated);
        }
        if is_batch {
            largest = largest.max(all);
        } else {
            budget.hold(PART, all)?;
        }
    }
    // One batch is in memory at a time.
    budget.hold(PART, largest)
}

/// The numbers of a column.
#[derive(Default)]
struct Column {
    unit: Option<&'static str>,
    /// Number of elements of the lists; `None` for numbers.
    length: Option<usize>,
    values: Vec<f64>,
    wide: Wide,
    left_out: Option<String>,
}

impl Column {
    fn new(kind: &DataType) -> Self {
        let unit = match kind {
            DataType::Timestamp(unit, _) | DataType::Duration(unit) => Some(match unit {
                TimeUnit::Second => "s",
                TimeUnit::Millisecond => "ms",
                TimeUnit::Microsecond => "us",
                TimeUnit::Nanosecond => "ns",
            }),
            _ => None,
        };
        Self { unit, ..Self::default() }
    }

    fn push(&mut self, array: &ArrayRef, budget: &Budget) -> Result<(), Problem> {
        if self.left_out.is_some() {
            return Ok(());
        }
        let lists = match array.data_type() {
            DataType::FixedSizeList(_, length) => {
                let length = usize::try_from(*length).unwrap_or(0);
                Some((array.as_fixed_size_list().values().clone(), vec![length; array.len()]))
            }
            DataType::List(_) => {
                let list = array.as_list::<i32>();
                let ends = list.value_offsets();
                let (Some(&from), Some(&to)) = (ends.first(), ends.last()) else { return Ok(()) };
                let lengths = ends.windows(2).map(|pair| (pair[1] - pair[0]) as usize).collect();
                Some((list.values().slice(from as usize, (to - from) as usize), lengths))
            }
            _ => None,
        };
        let Some((elements, lengths)) = lists else {
            budget.keep_values(array.len())?;
            self.numbers(array);
            return Ok(());
        };
        let length = *self.length.get_or_insert(lengths.first().copied().unwrap_or(0));
        if length == 0 || lengths.iter().any(|other| *other != length) {
            self.left_out = Some("has lists of different lengths".to_owned());
        } else {
            budget.keep_values(elements.len())?;
            self.numbers(&elements);
        }
        Ok(())
    }

    fn numbers(&mut self, array: &ArrayRef) {
        match array.data_type() {
            DataType::Float64 => self.of::<Float64Type>(array, |value| value),
            DataType::Float32 => self.of::<Float32Type>(array, f64::from),
            DataType::Int8 => self.of::<Int8Type>(array, f64::from),
            DataType::Int16 => self.of::<Int16Type>(array, f64::from),
            DataType::Int32 => self.of::<Int32Type>(array, f64::from),
            DataType::UInt8 => self.of::<UInt8Type>(array, f64::from),
            DataType::UInt16 => self.of::<UInt16Type>(array, f64::from),
            DataType::UInt32 => self.of::<UInt32Type>(array, f64::from),
            DataType::UInt64 => self.of::<UInt64Type>(array, |value| value as f64),
            DataType::Int64 => self.whole::<Int64Type>(array),
            DataType::Timestamp(TimeUnit::Second, _) => self.whole::<TimestampSecondType>(array),
            DataType::Timestamp(TimeUnit::Millisecond, _) => self.whole::<TimestampMillisecondType>(array),
            DataType::Timestamp(TimeUnit::Microsecond, _) => self.whole::<TimestampMicrosecondType>(array),
            DataType::Timestamp(TimeUnit::Nanosecond, _) => self.whole::<TimestampNanosecondType>(array),
            DataType::Duration(TimeUnit::Second) => self.whole::<DurationSecondType>(array),
            DataType::Duration(TimeUnit::Millisecond) => self.whole::<DurationMillisecondType>(array),
            DataType::Duration(TimeUnit::Microsecond) => self.whole::<DurationMicrosecondType>(array),
            DataType::Duration(TimeUnit::Nanosecond) => self.whole::<DurationNanosecondType>(array),
            DataType::Boolean => {
                let flag = |value: Option<bool>| value.map_or(f64::NAN, |value| f64::from(u8::from(value)));
                self.values.extend(array.as_boolean().iter().map(flag));
            }
            other => self.left_out = Some(format!("is of the type {other}")),
        }
    }

    fn of<T: ArrowPrimitiveType>(&mut self, array: &Arc<dyn arrow_array::Array>, number: impl Fn(T::Native) -> f64) {
        let array: &PrimitiveArray<T> = array.as_primitive();
        self.values.extend(array.iter().map(|value| value.map_or(f64::NAN, &number)));
    }

    fn whole<T: ArrowPrimitiveType<Native = i64>>(&mut self, array: &Arc<dyn arrow_array::Array>) {
        let array: &PrimitiveArray<T> = array.as_primitive();
        let Self { values, wide, .. } = self;
        values.extend(array.iter().map(|value| value.map_or(f64::NAN, |value| wide.number(value))));
    }
}

#[cfg(test)]
mod tests {
    use super::super::Container as _;
    use super::*;

    fn budget() -> Budget {
        Budget::new(&crate::Limits::default())
    }

    fn stored(name: &str) -> Vec<u8> {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/formats/");
        std::fs::read(format!("{folder}{name}")).expect("there")
    }

    #[test]
    fn feather_and_arrow_are_read_with_their_lists_and_time_stamps() {
        let mut table = open(stored("table.feather"), &budget()).expect("Feather");
        let names: Vec<&str> = table.arrays().iter().map(|array| array.name.as_str()).collect();
        assert_eq!(names, ["time_s", "position_m", "force_n"]);
        assert_eq!(table.values(0, &budget()).expect("times")[700], 0.7);
        let mut lists = open(stored("lists.arrow"), &budget()).expect("Arrow");
        let array = &lists.arrays()[1];
        assert_eq!((array.name.as_str(), &*array.dims), ("state", &[1000, 2][..]));
        assert_eq!(lists.arrays()[0].unit.as_deref(), Some("ns"));
        assert_eq!(lists.values(0, &budget()).expect("times")[700], 7e8);
        assert_eq!(lists.values(1, &budget()).expect("states")[1400..1402], table_row(&mut table, 700));
    }

    /// The position and the force of a row.
    fn table_row(table: &mut Loaded, row: usize) -> [f64; 2] {
        [1, 2].map(|column| table.values(column, &budget()).expect("a column")[row])
    }

    #[test]
    fn damaged_files_and_too_many_bytes_are_refused() {
        let whole = stored("table.feather");
        let few = Budget::new(&crate::Limits { max_memory_bytes: 10_000, ..crate::Limits::default() });
        assert!(matches!(open(whole.clone(), &few), Err(Problem::OverBudget { .. })));
        for cut in [0, 8, 9, 100, whole.len() / 2, whole.len() - 1] {
            assert!(open(whole[..cut].to_vec(), &budget()).is_err(), "cut to {cut} bytes");
        }
    }
}
