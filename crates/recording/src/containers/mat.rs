//! MATLAB files of versions 5 to 7, by MathWorks' "MAT-File Format": arrays of numbers, also inside structures, cells
//! and old-style objects, compressed or not. Text, sparse arrays, functions and objects of classes are skipped.
//!
//! An element consists of a tag (the type and the number of bytes) and its data, padded to a multiple of 8 bytes.

use std::io::Read;
use std::ops::Range;

use flate2::read::ZlibDecoder;

use super::bytes::{Cursor, Order, Scalar};
use super::mat4::Mat4;
use super::{Array, Container, Fault, Format, check_size};
use crate::Limits;
use crate::error::Problem;

const HEADER_BYTES: usize = 128;

const MAX_DEPTH: usize = 32;

const MAX_ARRAYS: usize = 100_000;

/// Fields of a structure that contain the label of its arrays, and their unit.
const LABELS: [&str; 4] = ["label", "name", "title", "signalName"];
const UNITS: [&str; 3] = ["unit", "units", "Units"];

const COMPRESSED: u32 = 15;
const MATRIX: u32 = 14;

struct Stored {
    buffer: usize,
    range: Range<usize>,
    scalar: Scalar,
}

pub(super) struct Mat {
    order: Order,
    /// The file, followed by the content of its compressed elements.
    buffers: Vec<Vec<u8>>,
    arrays: Vec<Array>,
    stored: Vec<Stored>,
    limits: Limits,
}

pub(crate) fn open(bytes: Vec<u8>, limits: &Limits) -> Result<Box<dyn Container>, Problem> {
    let order = match bytes.get(126..HEADER_BYTES) {
        Some(b"IM") => Order::Little,
        Some(b"MI") => Order::Big,
        _ if bytes.starts_with(b"MATLAB") => return Err(Format::Mat.damaged("its header is cut off")),
        _ => return Ok(Box::new(Mat4::open(bytes, limits)?)),
    };
    Ok(Box::new(Mat::index(bytes, order, limits)?))
}

type Found = (Array, Range<usize>, Scalar);

impl Mat {
    fn index(bytes: Vec<u8>, order: Order, limits: &Limits) -> Result<Self, Problem> {
        let mut mat = Self { order, buffers: vec![], arrays: vec![], stored: vec![], limits: limits.clone() };
        let mut file = Cursor::new(&bytes, order);
        file.at = HEADER_BYTES;
        let (mut inflated, mut objects) = (vec![], vec![]);
        let mut held = 0;
        let cut = || Format::Mat.damaged("it is cut off");
        while !file.rest().is_empty() {
            let (kind, range) = element(&mut file, true).ok_or_else(cut)?;
            let found = match kind {
                COMPRESSED => {
                    let left = limits.max_bytes.saturating_sub(held);
                    let content = inflate(&bytes[range], left, limits.max_bytes)?;
                    held += content.len() as u64;
                    let mut inside = Cursor::new(&content, order);
                    let found = match element(&mut inside, false).ok_or_else(cut)? {
                        (MATRIX, range) => matrices(&content, range, order, &mut objects)?,
                        _ => vec![],
                    };
                    if found.is_empty() {
                        held -= content.len() as u64;
                    } else {
                        inflated.push(content);
                    }
                    (inflated.len(), found)
                }
                MATRIX => (0, matrices(&bytes, range, order, &mut objects)?),
                _ => continue,
            };
            let (buffer, found) = found;
            for (array, range, scalar) in found {
                mat.arrays.push(array);
                mat.stored.push(Stored { buffer, range, scalar });
            }
            if mat.arrays.len() > MAX_ARRAYS {
                return Err(Format::Mat.damaged(format!("it has more than {MAX_ARRAYS} arrays")));
            }
        }
        mat.buffers = std::iter::once(bytes).chain(inflated).collect();
        if super::vectors(&mat.arrays).is_empty() { Err(Problem::no_signal(Format::Mat, &objects)) } else { Ok(mat) }
    }
}

fn inflate(bytes: &[u8], left: u64, limit: u64) -> Result<Vec<u8>, Problem> {
    let mut content = vec![];
    let read = ZlibDecoder::new(bytes).take(left.saturating_add(1)).read_to_end(&mut content);
    read.map_err(|error| Format::Mat.damaged(format!("a compressed part is damaged ({error})")))?;
    if content.len() as u64 > left { Err(Problem::TooManyBytes { limit }) } else { Ok(content) }
}

/// Reads the type and the data range of the next element. `at_top`: at the top level, a compressed element has no
/// padding.
fn element(at: &mut Cursor<'_>, at_top: bool) -> Option<(u32, Range<usize>)> {
    let first = at.u32()?;
    // A small element stores its size and up to four bytes of data in the tag.
    if first >> 16 != 0 && first & 0xffff != COMPRESSED {
        let size = (first >> 16) as usize;
        let start = at.at;
        at.take(4)?;
        return (size <= 4).then_some((first & 0xffff, start..start + size));
    }
    let size = at.index()?;
    let start = at.at;
    at.take(size)?;
    if !(at_top && first == COMPRESSED) {
        // The last element of a file can lack its padding.
        at.take((8 - size % 8) % 8 % (at.rest().len() + 1));
    }
    Some((first, start..start + size))
}

/// The arrays of an element. Appends the objects of classes, which are not read.
fn matrices(
    buffer: &[u8],
    range: Range<usize>,
    order: Order,
    objects: &mut Vec<String>,
) -> Result<Vec<Found>, Problem> {
    let mut walk = Walk { buffer, order, found: vec![], objects };
    walk.matrix(range, None, 0).ok_or_else(|| Format::Mat.damaged("the sizes of an array contradict each other"))?;
    Ok(walk.found)
}

struct Walk<'a> {
    buffer: &'a [u8],
    order: Order,
    found: Vec<Found>,
    /// The objects at the top level, with the remedy.
    objects: &'a mut Vec<String>,
}

enum Content {
    Text(String),
    Other,
}

impl Walk<'_> {
    /// Notes an object of a class, such as a timetable: its name, the system of classes and its class follow the flags.
    fn object(&mut self, at: &mut Cursor<'_>, bytes: &[u8]) {
        let mut text = || {
            let (_, range) = element(at, false)?;
            Some(String::from_utf8_lossy(bytes.get(range)?).into_owned())
        };
        let (Some(name), Some(_), Some(class)) = (text(), text(), text()) else { return };
        if !name.is_empty() {
            self.objects.push(format!(
                "{name} is a {class}: save its columns as arrays, as in t = seconds({name}.Time); x = {name}.x"
            ));
        }
    }

    /// Reads a matrix; inside another one its name is `given`. `None` if it is damaged.
    fn matrix(&mut self, range: Range<usize>, given: Option<&str>, depth: usize) -> Option<Content> {
        let bytes = self.buffer.get(range.clone())?;
        if bytes.is_empty() || depth > MAX_DEPTH || self.found.len() > MAX_ARRAYS {
            return Some(Content::Other);
        }
        let mut at = Cursor::new(bytes, self.order);
        let (_, flags) = element(&mut at, false)?;
        let flags = Cursor::new(bytes.get(flags)?, self.order).u32()?;
        let class = flags & 0xff;
        // Objects of classes and functions have no dimensions here.
        if matches!(class, 16 | 17) {
            if class == 17 && given.is_none() {
                self.object(&mut at, bytes);
            }
            return Some(Content::Other);
        }
        let (_, dims) = element(&mut at, false)?;
        let dims = Scalar::I32.read_all(bytes.get(dims)?, self.order);
        let dims: Vec<usize> = dims.into_iter().map(|dim| dim as usize).collect();
        let (_, own) = element(&mut at, false)?;
        let own = String::from_utf8_lossy(bytes.get(own)?).into_owned();
        let name = given.unwrap_or(&own);
        // The workspace of functions has no name.
        if name.is_empty() {
            return Some(Content::Other);
        }
        let array = Array { column_major: true, ..Array::new(name, dims) };
        match class {
            1 => self.parts(&mut at, range.start, &array, &[String::new()], depth)?,
            2 | 3 => {
                if class == 3 {
                    element(&mut at, false)?;
                }
                let (_, length) = element(&mut at, false)?;
                let length = Cursor::new(bytes.get(length)?, self.order).index()?;
                let (_, names) = element(&mut at, false)?;
                let field = |name: &[u8]| {
                    let end = name.iter().position(|byte| *byte == 0).unwrap_or(name.len());
                    format!(".{}", String::from_utf8_lossy(&name[..end]))
                };
                let names = bytes.get(names)?;
                let fields: Vec<String> = if length == 0 { vec![] } else { names.chunks(length).map(field).collect() };
                self.parts(&mut at, range.start, &array, &fields, depth)?;
            }
            4 => {
                let (kind, text) = element(&mut at, false)?;
                return Some(Content::Text(characters(bytes.get(text)?, kind, self.order)));
            }
            6..=15 => {
                if array.len() == 0 {
                    return Some(Content::Other);
                }
                let (kind, data) = element(&mut at, false)?;
                let scalar = scalar(kind)?;
                // A complex array stores its real parts first.
                if array.len().checked_mul(scalar.size())? != data.len() {
                    return None;
                }
                self.found.push((array, range.start + data.start..range.start + data.end, scalar));
            }
            _ => {}
        }
        Some(Content::Other)
    }

    /// Reads the matrices of a cell or a structure: one per element and field.
    fn parts(
        &mut self,
        at: &mut Cursor<'_>,
        start: usize,
        outer: &Array,
        fields: &[String],
        depth: usize,
    ) -> Option<()> {
        if fields.is_empty() {
            return Some(());
        }
        let is_cell = fields == [String::new()];
        for index in 0..outer.len() {
            let first = self.found.len();
            let (mut label, mut unit) = (None, None);
            for field in fields {
                let (kind, range) = element(at, false)?;
                if kind != MATRIX {
                    return None;
                }
                let index = if is_cell || outer.len() > 1 { format!("[{index}]") } else { String::new() };
                let name = format!("{}{index}{field}", outer.name);
                let content = self.matrix(start + range.start..start + range.end, Some(&name), depth + 1)?;
                if let Content::Text(text) = content {
                    let text = text.trim();
                    let field = field.trim_start_matches('.');
                    let known = |names: &[&str]| !text.is_empty() && names.contains(&field);
                    if known(&LABELS) && label.is_none() {
                        label = Some(text.to_owned());
                    } else if known(&UNITS) {
                        unit = Some(text.to_owned());
                    }
                }
            }
            for (array, ..) in &mut self.found[first..] {
                array.label = array.label.take().or_else(|| label.clone());
                array.unit = array.unit.take().or_else(|| unit.clone());
            }
        }
        Some(())
    }
}

fn scalar(kind: u32) -> Option<Scalar> {
    Some(match kind {
        1 => Scalar::I8,
        2 => Scalar::U8,
        3 => Scalar::I16,
        4 => Scalar::U16,
        5 => Scalar::I32,
        6 => Scalar::U32,
        7 => Scalar::F32,
        9 => Scalar::F64,
        12 => Scalar::I64,
        13 => Scalar::U64,
        _ => return None,
    })
}

fn characters(bytes: &[u8], kind: u32, order: Order) -> String {
    match scalar(kind) {
        Some(Scalar::U16 | Scalar::I16) => {
            let units = Scalar::U16.read_all(bytes, order);
            String::from_utf16_lossy(&units.into_iter().map(|unit| unit as u16).collect::<Vec<_>>())
        }
        _ => String::from_utf8_lossy(bytes).into_owned(),
    }
}

impl Container for Mat {
    fn arrays(&self) -> &[Array] {
        &self.arrays
    }

    fn values(&mut self, index: usize) -> Result<Vec<f64>, Fault> {
        let stored = &self.stored[index];
        check_size(self.arrays[index].len(), &self.limits)?;
        let bytes = self.buffers[stored.buffer].get(stored.range.clone());
        Ok(stored.scalar.read_all(bytes.unwrap_or_default(), self.order))
    }
}
