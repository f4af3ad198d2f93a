//! NumPy's files: an array in `.npy`, or several in a ZIP archive, `.npz`.
//!
//! A structured array gives a signal per field. Texts, objects and complex numbers are omitted.

use std::io::Cursor;

use npyz::{DType, Endianness, NpyHeader, Order as Layout, TypeChar, TypeStr};

use super::bytes::{Order, Scalar, Wide};
use super::{Array, Format, Loaded};
use crate::error::Problem;
use crate::room::{Room, check_name, recover};

/// Largest depth of brackets in a header, because its parser takes exponential time in the depth.
const MAX_DEPTH: i32 = 16;

const MAX_HEADER_BYTES: usize = 1 << 20;

const UNNAMED: &str = "array";

#[derive(Default)]
struct Numpy {
    arrays: Vec<Array>,
    values: Vec<Vec<f64>>,
    left_out: Vec<String>,
}

pub(super) fn open_array(bytes: &[u8], room: &Room) -> Result<Loaded, Problem> {
    let mut found = Numpy::default();
    found.add(Format::Npy, UNNAMED, bytes, room)?;
    found.finish(Format::Npy)
}

pub(super) fn open_archive(bytes: Vec<u8>, room: &Room) -> Result<Loaded, Problem> {
    let mut found = Numpy::default();
    let damaged = |error: &dyn std::fmt::Display| Format::Npz.damaged(error);
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).map_err(|error| damaged(&error))?;
    for index in 0..archive.len() {
        let entry = archive.by_index(index).map_err(|error| damaged(&error))?;
        let file = entry.name().map_err(|error| damaged(&error))?.into_owned();
        let Some(name) = npyz::npz::array_name_from_file_name(&file) else { continue };
        check_name(name.len())?;
        let array = room.read(entry).map_err(|error| recover(Format::Npz, error))?;
        found.add(Format::Npz, name, &array, room)?;
    }
    found.finish(Format::Npz)
}

impl Numpy {
    fn add(&mut self, format: Format, name: &str, bytes: &[u8], room: &Room) -> Result<(), Problem> {
        check_header(bytes).map_err(|reason| format.damaged(reason))?;
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
                    room.take_values(count)?;
                    let mut wide = Wide::default();
                    let mut read = |element: &[u8]| match scalar {
                        Scalar::I64 => Some(wide.number(whole(element.get(at..)?, order)?)),
                        _ => scalar.read(element.get(at..)?, order),
                    };
                    let values = data.chunks_exact(stride).take(count).map(|element| read(element).unwrap_or(f64::NAN));
                    let array = Array::in_room(field.unwrap_or(name), dims.clone(), room)?;
                    self.arrays.push(Array { column_major, unit: unit.map(str::to_owned), ..array });
                    self.values.push(values.collect());
                }
                None => self.left_out.push(format!("{} is {}", field.unwrap_or(name), of_field.descr())),
            }
            at += size;
        }
        Ok(())
    }

    fn finish(self, format: Format) -> Result<Loaded, Problem> {
        Loaded::new(format, self.arrays, self.values, &self.left_out)
    }
}

fn check_header(bytes: &[u8]) -> Result<(), &'static str> {
    const CUT_OFF: &str = "its header is cut off";
    let version = *bytes.get(6).ok_or(CUT_OFF)?;
    let (length, rest) = if version == 1 {
        let (length, rest) = bytes.get(8..).and_then(<[u8]>::split_first_chunk).ok_or(CUT_OFF)?;
        (usize::from(u16::from_le_bytes(*length)), rest)
    } else {
        let (length, rest) = bytes.get(8..).and_then(<[u8]>::split_first_chunk).ok_or(CUT_OFF)?;
        (u32::from_le_bytes(*length) as usize, rest)
    };
    let header = rest.get(..length).ok_or(CUT_OFF)?;
    if length > MAX_HEADER_BYTES {
        return Err("its header is longer than 1 MiB");
    }
    let mut depth = 0;
    for byte in header {
        match byte {
            b'[' | b'(' | b'{' => depth += 1,
            b']' | b')' | b'}' => depth -= 1,
            _ => {}
        }
        if depth > MAX_DEPTH {
            return Err("its header is nested too deeply");
        }
    }
    Ok(())
}

fn whole(bytes: &[u8], order: Order) -> Option<i64> {
    let bytes = *bytes.first_chunk()?;
    Some(if order == Order::Little { i64::from_le_bytes(bytes) } else { i64::from_be_bytes(bytes) })
}

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

#[cfg(test)]
mod tests {
    use super::*;

    fn npy(version: u8, header: &[u8]) -> Vec<u8> {
        let length = (header.len() as u32).to_le_bytes();
        let length = if version == 1 { &length[..2] } else { &length[..] };
        [b"\x93NUMPY", &[version, 0][..], length, header].concat()
    }

    #[test]
    fn a_deeply_nested_header_and_one_that_is_cut_off_are_refused_at_once() {
        let refused = |bytes: &[u8]| match open_array(bytes, &Room::new(&crate::Limits::default())) {
            Err(problem) => problem.to_string(),
            Ok(_) => "read".to_owned(),
        };
        for version in [1, 2, 3] {
            assert!(refused(&npy(version, &[b'['; 5000])).contains("nested too deeply"));
            let closed = [[b'['; 40], [b']'; 40]].concat();
            assert!(refused(&npy(version, &closed)).contains("nested too deeply"));
        }
        let far = [b"\x93NUMPY\x02\0", &u32::MAX.to_le_bytes()[..], b"{}"].concat();
        for bytes in [&far[..], b"\x93NUMPY", b"\x93NUMPY\x01\0\x20"] {
            assert!(refused(bytes).contains("header is cut off"), "{bytes:?}");
        }
    }
}
