//! MATLAB files of versions 5 to 7, by MathWorks' "MAT-File Format": arrays of numbers, also inside structures, cells
//! and old-style objects. Text, sparse arrays, functions and objects of classes are skipped.
//!
//! An element consists of a tag (the type and the number of bytes) and its data, padded to a multiple of 8 bytes.

use std::ops::Range;

use flate2::read::ZlibDecoder;

use super::bytes::{Cursor, Order, Scalar};
use super::{Array, Container, Fault, Format};
use crate::error::Problem;
use crate::room::{MAX_DIMENSIONS, Room, check_depth, check_name, recover, short};

const HEADER_BYTES: usize = 128;

const MAX_TEXT_BYTES: usize = 1000;

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
}

pub(crate) fn open(bytes: Vec<u8>, room: &Room) -> Result<Box<dyn Container>, Problem> {
    let order = match bytes.get(126..HEADER_BYTES) {
        Some(b"IM") => Order::Little,
        Some(b"MI") => Order::Big,
        _ if bytes.starts_with(b"MATLAB") => return Err(Format::Mat.damaged("its header is cut off")),
        _ => return Err(Problem::NotRead(Format::Mat4)),
    };
    Ok(Box::new(Mat::index(bytes, order, room)?))
}

type Found = (Array, Range<usize>, Scalar);

impl Mat {
    fn index(bytes: Vec<u8>, order: Order, room: &Room) -> Result<Self, Problem> {
        let mut mat = Self { order, buffers: vec![], arrays: vec![], stored: vec![] };
        let mut file = Cursor::new(&bytes, order);
        file.at = HEADER_BYTES;
        let (mut inflated, mut objects) = (vec![], vec![]);
        let cut = || Format::Mat.damaged("it is cut off");
        while !file.rest().is_empty() {
            let (kind, range) = element(&mut file, true).ok_or_else(cut)?;
            let found = match kind {
                COMPRESSED => {
                    let content =
                        room.read(ZlibDecoder::new(&bytes[range])).map_err(|error| recover(Format::Mat, error))?;
                    let mut inside = Cursor::new(&content, order);
                    let found = match element(&mut inside, false).ok_or_else(cut)? {
                        (MATRIX, range) => matrices(&content, range, order, room, &mut objects)?,
                        _ => vec![],
                    };
                    inflated.push(content);
                    (inflated.len(), found)
                }
                MATRIX => (0, matrices(&bytes, range, order, room, &mut objects)?),
                _ => continue,
            };
            let (buffer, found) = found;
            for (array, range, scalar) in found {
                mat.arrays.push(array);
                mat.stored.push(Stored { buffer, range, scalar });
            }
        }
        mat.buffers = std::iter::once(bytes).chain(inflated).collect();
        if super::has_signals(&mat.arrays) { Ok(mat) } else { Err(Problem::no_signal(Format::Mat, &objects)) }
    }
}

/// Returns type and data range. `at_top`: at the top level, a compressed element has no padding.
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

fn matrices(
    buffer: &[u8],
    range: Range<usize>,
    order: Order,
    room: &Room,
    objects: &mut Vec<String>,
) -> Result<Vec<Found>, Problem> {
    let mut walk = Walk { buffer, order, room, found: vec![], objects };
    match walk.matrix(range, None, 0) {
        Ok(_) => Ok(walk.found),
        Err(Stop::Damaged) => Err(Format::Mat.damaged("the sizes of an array contradict each other")),
        Err(Stop::Problem(problem)) => Err(problem),
    }
}

enum Stop {
    Damaged,
    Problem(Problem),
}

impl From<Problem> for Stop {
    fn from(problem: Problem) -> Self {
        Self::Problem(problem)
    }
}

fn part(at: &mut Cursor<'_>) -> Result<(u32, Range<usize>), Stop> {
    element(at, false).ok_or(Stop::Damaged)
}

fn slice(bytes: &[u8], range: Range<usize>) -> Result<&[u8], Stop> {
    bytes.get(range).ok_or(Stop::Damaged)
}

struct Walk<'a> {
    buffer: &'a [u8],
    order: Order,
    room: &'a Room,
    found: Vec<Found>,
    objects: &'a mut Vec<String>,
}

enum Content {
    Text(String),
    Other,
}

impl Walk<'_> {
    /// An object of a class, such as a timetable.
    fn object(&mut self, at: &mut Cursor<'_>, bytes: &[u8]) {
        let mut text = || {
            let (_, range) = element(at, false)?;
            let text = bytes.get(range)?;
            Some(short(&String::from_utf8_lossy(&text[..text.len().min(MAX_TEXT_BYTES)])))
        };
        let (Some(name), Some(_), Some(class)) = (text(), text(), text()) else { return };
        const MAX_OBJECTS: usize = 100;
        if !name.is_empty() && self.objects.len() < MAX_OBJECTS {
            self.objects.push(format!(
                "{name} is a {class}: save its columns as arrays, as in t = seconds({name}.Time); x = {name}.x"
            ));
        }
    }

    fn matrix(&mut self, range: Range<usize>, given: Option<&str>, depth: usize) -> Result<Content, Stop> {
        let bytes = slice(self.buffer, range.clone())?;
        if bytes.is_empty() {
            return Ok(Content::Other);
        }
        check_depth(depth)?;
        let mut at = Cursor::new(bytes, self.order);
        let (_, flags) = part(&mut at)?;
        let flags = Cursor::new(slice(bytes, flags)?, self.order).u32().ok_or(Stop::Damaged)?;
        let class = flags & 0xff;
        // Objects of classes have no dimensions here.
        if matches!(class, 16 | 17) {
            if class == 17 && given.is_none() {
                self.object(&mut at, bytes);
            }
            return Ok(Content::Other);
        }
        let (_, dims) = part(&mut at)?;
        let dims = slice(bytes, dims)?;
        // More are refused.
        let dims = Scalar::I32.read_all(&dims[..dims.len().min(4 * (MAX_DIMENSIONS + 1))], self.order);
        let dims: Vec<usize> = dims.into_iter().map(|dim| dim as usize).collect();
        let (_, own) = part(&mut at)?;
        let own = slice(bytes, own)?;
        check_name(own.len())?;
        let own = String::from_utf8_lossy(own).into_owned();
        let name = given.unwrap_or(&own);
        // The workspace of functions is unnamed.
        if name.is_empty() {
            return Ok(Content::Other);
        }
        let array = Array { column_major: true, ..Array::in_room(name, dims, self.room)? };
        match class {
            1 => self.parts(&mut at, range.start, &array, &[String::new()], depth)?,
            2 | 3 => {
                if class == 3 {
                    part(&mut at)?;
                }
                let (_, length) = part(&mut at)?;
                let length = Cursor::new(slice(bytes, length)?, self.order).index().ok_or(Stop::Damaged)?;
                let (_, names) = part(&mut at)?;
                let field = |name: &[u8]| {
                    let end = name.iter().position(|byte| *byte == 0).unwrap_or(name.len());
                    format!(".{}", String::from_utf8_lossy(&name[..end]))
                };
                let names = slice(bytes, names)?;
                check_name(length.min(names.len()))?;
                let fields: Vec<String> = if length == 0 { vec![] } else { names.chunks(length).map(field).collect() };
                self.parts(&mut at, range.start, &array, &fields, depth)?;
            }
            4 => {
                let (kind, text) = part(&mut at)?;
                let text = slice(bytes, text)?;
                let text = &text[..text.len().min(MAX_TEXT_BYTES)];
                return Ok(Content::Text(short(&characters(text, kind, self.order))));
            }
            6..=15 => {
                if array.len() == 0 {
                    return Ok(Content::Other);
                }
                let (kind, data) = part(&mut at)?;
                let scalar = scalar(kind).ok_or(Stop::Damaged)?;
                // A complex array stores its real parts first.
                if array.len().checked_mul(scalar.size()) != Some(data.len()) {
                    return Err(Stop::Damaged);
                }
                self.found.push((array, range.start + data.start..range.start + data.end, scalar));
            }
            _ => {}
        }
        Ok(Content::Other)
    }

    fn parts(
        &mut self,
        at: &mut Cursor<'_>,
        start: usize,
        outer: &Array,
        fields: &[String],
        depth: usize,
    ) -> Result<(), Stop> {
        if fields.is_empty() {
            return Ok(());
        }
        let is_cell = fields == [String::new()];
        for index in 0..outer.len() {
            let first = self.found.len();
            let (mut label, mut unit) = (None, None);
            for field in fields {
                let (kind, range) = part(at)?;
                if kind != MATRIX {
                    return Err(Stop::Damaged);
                }
                let index = if is_cell || outer.len() > 1 { format!("[{index}]") } else { String::new() };
                check_name(outer.name.len() + index.len() + field.len())?;
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
        Ok(())
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

    fn values(&mut self, index: usize, _: &Room) -> Result<Vec<f64>, Fault> {
        let stored = &self.stored[index];
        let bytes = self.buffers[stored.buffer].get(stored.range.clone());
        Ok(stored.scalar.read_all(bytes.unwrap_or_default(), self.order))
    }
}
