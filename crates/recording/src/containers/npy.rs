//! NumPy's files: an array in `.npy`, or several arrays in a ZIP archive, `.npz`.
//!
//! A structured array gives a signal per field. Texts, objects and complex numbers are omitted.

use std::io::Cursor;

use npyz::{DType, Endianness, NpyHeader, Order as Layout, TypeChar, TypeStr};

use super::bytes::{Order, Scalar, Wide};
use super::{Array, Container, Fault, Format, unpack};
use crate::Limits;
use crate::error::Problem;

/// A file without names for its arrays gives them this one.
const UNNAMED: &str = "array";

pub(super) struct Numpy {
    arrays: Vec<Array>,
    values: Vec<Vec<f64>>,
    left_out: Vec<String>,
    /// The size of the numbers, in bytes.
    size: u64,
}

impl Numpy {
    /// Reads an array.
    pub(super) fn of_array(bytes: &[u8], limits: &Limits) -> Result<Self, Problem> {
        let mut found = Self { arrays: vec![], values: vec![], left_out: vec![], size: 0 };
        found.add(Format::Npy, UNNAMED, bytes, limits)?;
        found.finish(Format::Npy)
    }

    /// Reads the arrays of an archive.
    pub(super) fn of_archive(bytes: Vec<u8>, limits: &Limits) -> Result<Self, Problem> {
        let mut found = Self { arrays: vec![], values: vec![], left_out: vec![], size: 0 };
        let damaged = |error: &dyn std::fmt::Display| Format::Npz.damaged(error);
        let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).map_err(|error| damaged(&error))?;
        let mut left = limits.max_bytes;
        for index in 0..archive.len() {
            let entry = archive.by_index(index).map_err(|error| damaged(&error))?;
            let file = entry.name().map_err(|error| damaged(&error))?.into_owned();
            let Some(name) = npyz::npz::array_name_from_file_name(&file) else { continue };
            let array = unpack::bounded(entry, left).map_err(|error| damaged(&error))?;
            left = left.saturating_sub(array.len() as u64);
            found.add(Format::Npz, name, &array, limits)?;
        }
        found.finish(Format::Npz)
    }

    fn add(&mut self, format: Format, name: &str, bytes: &[u8], limits: &Limits) -> Result<(), Problem> {
        let mut data = bytes;
        let header = NpyHeader::from_reader(&mut data).map_err(|error| format.damaged(error))?;
        let dims = header.shape().iter().map(|dim| usize::try_from(*dim)).collect::<Result<Vec<_>, _>>();
        let dims = dims.map_err(|error| format.damaged(error))?;
        let column_major = header.order() == Layout::Fortran;
        let dtype = header.dtype();
        let fields: Vec<(Option<&str>, &DType)> = match &dtype {
            DType::Record(fields) => fields.iter().map(|field| (Some(&*field.name), &field.dtype)).collect(),
            other => vec![(None, other)],
        };
        let Some(stride) = dtype.num_bytes().filter(|bytes| *bytes > 0) else {
            self.left_out.push(format!("{name} is {}", dtype.descr()));
            return Ok(());
        };
        let count = dims.iter().fold(1_usize, |product, dim| product.saturating_mul(*dim));
        if count.checked_mul(stride).is_none_or(|size| size > data.len()) {
            return Err(format.damaged(format!("the array {name} is cut off")));
        }
        let mut at = 0;
        for (field, of_field) in fields {
            let size = of_field.num_bytes().unwrap_or(0);
            match number(of_field) {
                Some((scalar, order, unit)) => {
                    // A number of one byte in the file has eight in memory.
                    self.size = self.size.saturating_add(8 * count as u64);
                    if self.size > limits.max_bytes {
                        return Err(Problem::TooManyBytes { limit: limits.max_bytes });
                    }
                    let mut wide = Wide::default();
                    let mut read = |element: &[u8]| match scalar {
                        Scalar::I64 => Some(wide.number(whole(element.get(at..)?, order)?)),
                        _ => scalar.read(element.get(at..)?, order),
                    };
                    let values = data.chunks_exact(stride).take(count).map(|element| read(element).unwrap_or(f64::NAN));
                    let array = Array::new(field.unwrap_or(name), dims.clone());
                    self.arrays.push(Array { column_major, unit: unit.map(str::to_owned), ..array });
                    self.values.push(values.collect());
                }
                None => self.left_out.push(format!("{} is {}", field.unwrap_or(name), of_field.descr())),
            }
            at += size;
        }
        Ok(())
    }

    fn finish(self, format: Format) -> Result<Self, Problem> {
        if super::vectors(&self.arrays).is_empty() { Err(Problem::no_signal(format, &self.left_out)) } else { Ok(self) }
    }
}

fn whole(bytes: &[u8], order: Order) -> Option<i64> {
    let bytes = *bytes.first_chunk()?;
    Some(if order == Order::Little { i64::from_le_bytes(bytes) } else { i64::from_be_bytes(bytes) })
}

/// The encoding of a number, and the unit of a time.
fn number(dtype: &DType) -> Option<(Scalar, Order, Option<&'static str>)> {
    let DType::Plain(kind) = dtype else { return None };
    let order = if kind.endianness() == Endianness::Big { Order::Big } else { Order::Little };
    let scalar = match (kind.type_char(), kind.size_field()) {
        (TypeChar::Bool, 1) | (TypeChar::Uint, 1) => Scalar::U8,
        (TypeChar::Int, 1) => Scalar::I8,
        (TypeChar::Int, 2) => Scalar::I16,
        (TypeChar::Uint, 2) => Scalar::U16,
        (TypeChar::Int, 4) => Scalar::I32,
        (TypeChar::Uint, 4) => Scalar::U32,
        (TypeChar::Int | TypeChar::DateTime | TypeChar::TimeDelta, 8) => Scalar::I64,
        (TypeChar::Uint, 8) => Scalar::U64,
        (TypeChar::Float, 4) => Scalar::F32,
        (TypeChar::Float, 8) => Scalar::F64,
        _ => return None,
    };
    Some((scalar, order, unit(kind)))
}

fn unit(kind: &TypeStr) -> Option<&'static str> {
    let written = kind.to_string();
    ["s", "ms", "us", "ns"].into_iter().find(|unit| written.ends_with(&format!("[{unit}]")))
}

impl Container for Numpy {
    fn arrays(&self) -> &[Array] {
        &self.arrays
    }

    fn values(&mut self, index: usize) -> Result<Vec<f64>, Fault> {
        Ok(self.values[index].clone())
    }
}
