//! MATLAB files of version 4: consecutive matrices, each with a header of 20 bytes. The format has no signature.

use std::ops::Range;

use super::bytes::{Cursor, Order, Scalar};
use super::{Array, Container, Fault, Format};
use crate::budget::Budget;
use crate::error::Problem;

/// Maximum number of bytes of a name; MATLAB 4 allowed 19.
const MAX_NAME_BYTES: usize = 256;

pub(super) struct Mat4 {
    bytes: Vec<u8>,
    order: Order,
    arrays: Vec<Array>,
    stored: Vec<(Range<usize>, Scalar)>,
}

impl Mat4 {
    pub(super) fn open(bytes: Vec<u8>, budget: &Budget) -> Result<Self, Problem> {
        let refuse = || Format::Mat.damaged("it is neither of version 4 nor of a later one, or it is cut off");
        // The first number of a file is below 5000 in its byte order.
        let first = Cursor::new(&bytes, Order::Little).u32().ok_or_else(refuse)?;
        let order = if first < 5000 { Order::Little } else { Order::Big };
        let mut mat = Self { bytes: vec![], order, arrays: vec![], stored: vec![] };
        let mut at = Cursor::new(&bytes, order);
        while !at.rest().is_empty() {
            if let Some((name, dims, range, scalar)) = matrix(&mut at).ok_or_else(refuse)? {
                let array = budget.array(&name, dims)?;
                mat.arrays.push(Array { column_major: true, ..array });
                mat.stored.push((range, scalar));
            }
        }
        mat.bytes = bytes;
        if super::has_signals(&mat.arrays) { Ok(mat) } else { Err(Problem::no_signal(Format::Mat, &[])) }
    }
}

/// The name, the dimensions, the range and the type of an array.
type Found = (String, Vec<usize>, Range<usize>, Scalar);

/// Reads a matrix; `Some(None)` for one without numbers, `None` if it is damaged.
fn matrix(at: &mut Cursor<'_>) -> Option<Option<Found>> {
    let kind = at.u32()?;
    let (rows, columns) = (at.index()?, at.index()?);
    let is_complex = at.u32()?;
    let name = at.index().filter(|length| (1..=MAX_NAME_BYTES).contains(length))?;
    let name = at.take(name)?.split(|byte| *byte == 0).next()?;
    let name = str::from_utf8(name).ok()?.to_owned();
    if kind / 1000 > 1 || kind / 100 % 10 != 0 || is_complex > 1 || name.is_empty() {
        return None;
    }
    let scalar = match kind / 10 % 10 {
        0 => Scalar::F64,
        1 => Scalar::F32,
        2 => Scalar::I32,
        3 => Scalar::I16,
        4 => Scalar::U16,
        5 => Scalar::U8,
        _ => return None,
    };
    let size = rows.checked_mul(columns)?.checked_mul(scalar.size())?;
    let start = at.at;
    at.take(size)?;
    if is_complex == 1 {
        at.take(size)?;
    }
    // 0 means numbers, 1 text, 2 a sparse matrix.
    match kind % 10 {
        0 => Some(Some((name, vec![rows, columns], start..start + size, scalar))),
        1 | 2 => Some(None),
        _ => None,
    }
}

impl Container for Mat4 {
    fn arrays(&self) -> &[Array] {
        &self.arrays
    }

    fn values(&mut self, index: usize, budget: &Budget) -> Result<Vec<f64>, Fault> {
        let (range, scalar) = &self.stored[index];
        budget.values(self.arrays[index].len())?;
        Ok(scalar.read_all(self.bytes.get(range.clone()).unwrap_or_default(), self.order))
    }
}
