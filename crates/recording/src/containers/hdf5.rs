//! HDF5 files: a signal `/group/dataset` per dataset of numbers, and `/group/table.field` per field of a compound
//! dataset. MATLAB 7.3 files are also read, with the names of earlier versions: `scope.signals[0].values`. A library
//! reads the files; [`guarded`] converts its panics to errors.

use std::rc::Rc;

use hdf5_pure::{AttrValue, DType, Dataset, Datatype, DatatypeByteOrder, File, Group, Object};

use super::bytes::{Order, Scalar};
use super::{Array, Container, Fault, Format, guarded};
use crate::error::Problem;
use crate::room::{Room, check_name, short};

const MAX_DEPTH: usize = 16;

/// Room of a link in bytes. Links can form cycles.
const LINK_BYTES: usize = 4096;

const UNITS: [&str; 4] = ["units", "unit", "Units", "Unit"];

const LABELS: [&str; 3] = ["label", "title", "name"];

struct Field {
    offset: usize,
    scalar: Scalar,
    order: Order,
}

struct Stored {
    dataset: Rc<Dataset>,
    field: Option<Field>,
}

pub(super) struct Hdf5 {
    arrays: Vec<Array>,
    stored: Vec<Stored>,
}

struct Walk<'a> {
    room: &'a Room,
    found: Hdf5,
    is_matlab: bool,
    /// The names in each enclosing group.
    outer: Vec<Vec<String>>,
}

fn damaged(error: impl std::fmt::Display) -> Problem {
    Format::Hdf5.damaged(error)
}

impl Hdf5 {
    pub(super) fn open(bytes: Vec<u8>, room: &Room) -> Result<Self, Problem> {
        let is_matlab = bytes.starts_with(b"MATLAB");
        let file = File::from_bytes(bytes).map_err(damaged)?;
        let found = Self { arrays: vec![], stored: vec![] };
        let mut walk = Walk { room, found, is_matlab, outer: vec![] };
        walk.group(&file.root(), "", 0)?;
        let found = walk.found;
        if super::has_signals(&found.arrays) { Ok(found) } else { Err(Problem::no_signal(Format::Hdf5, &[])) }
    }
}

impl Walk<'_> {
    fn name(&self, outer: &str, name: &str) -> Result<String, Problem> {
        check_name(outer.len() + 1 + name.len())?;
        Ok(match (self.is_matlab, outer.is_empty()) {
            (false, _) => format!("{outer}/{name}"),
            (true, true) => name.to_owned(),
            (true, false) => format!("{outer}.{name}"),
        })
    }

    fn group(&mut self, group: &Group, path: &str, depth: usize) -> Result<(), Problem> {
        if depth > MAX_DEPTH {
            return Ok(());
        }
        let first = self.found.arrays.len();
        let mut label = None;
        let datasets: Vec<(String, Dataset)> = group.iter_datasets().map_err(damaged)?.collect();
        let groups: Vec<(String, Group)> = group.iter_groups().map_err(damaged)?.collect();
        self.room.take(LINK_BYTES * (datasets.len() + groups.len()))?;
        // A link can lead back to an enclosing group. The library does not identify equal groups, so their names are
        // compared.
        let of_groups = groups.iter().map(|(name, _)| name);
        let names: Vec<String> = datasets.iter().map(|(name, _)| name).chain(of_groups).cloned().collect();
        if !datasets.is_empty() && !groups.is_empty() && self.outer.contains(&names) {
            return Ok(());
        }
        self.outer.push(names);
        for (name, dataset) in datasets {
            if self.is_matlab && label.is_none() && LABELS.contains(&name.as_str()) {
                label = text(&dataset);
            }
            self.dataset(dataset, path, &name, depth + 1)?;
        }
        for array in &mut self.found.arrays[first..] {
            array.label = array.label.take().or_else(|| label.clone());
        }
        for (name, inner) in groups {
            // MATLAB stores the targets of references there.
            if self.is_matlab && name.starts_with('#') {
                continue;
            }
            let path = self.name(path, &name)?;
            self.group(&inner, &path, depth + 1)?;
        }
        self.outer.pop();
        Ok(())
    }

    fn dataset(&mut self, dataset: Dataset, outer: &str, name: &str, depth: usize) -> Result<(), Problem> {
        if depth > MAX_DEPTH {
            return Ok(());
        }
        let (Ok(kind), Ok(shape)) = (dataset.dtype(), dataset.shape()) else { return Ok(()) };
        let mut dims = shape.into_iter().map(|dim| usize::try_from(dim).unwrap_or(usize::MAX)).collect::<Vec<_>>();
        if self.is_matlab {
            dims.reverse();
        }
        let attributes = dataset.attrs().unwrap_or_default();
        let unit = UNITS.iter().find_map(|name| match attributes.get(*name)? {
            AttrValue::String(text) | AttrValue::AsciiString(text) => Some(short(text.trim_end_matches('\0'))),
            _ => None,
        });
        let path = self.name(outer, name)?;
        let is_matlab = self.is_matlab;
        let array = |room: &Room, name: &str| {
            let array = Array::in_room(name, dims.clone(), room)?;
            Ok::<_, Problem>(Array { unit: unit.clone(), column_major: is_matlab, ..array })
        };
        match kind {
            DType::ObjectReference if self.is_matlab => {
                let is_cell = class(&attributes) == Some("cell");
                for (index, object) in dataset.dereference().unwrap_or_default().into_iter().enumerate() {
                    // The elements of a structure array are in its fields.
                    let (outer, name) = match is_cell {
                        true => (outer.to_owned(), format!("{name}[{index}]")),
                        false => (format!("{outer}[{index}]"), name.to_owned()),
                    };
                    match object {
                        Object::Group(group) => {
                            let path = self.name(&outer, &name)?;
                            self.group(&group, &path, depth + 1)?;
                        }
                        Object::Dataset(dataset) => self.dataset(*dataset, &outer, &name, depth + 1)?,
                        _ => {}
                    }
                }
            }
            DType::Compound(_) => {
                let Ok(Datatype::Compound { members, .. }) = dataset.datatype() else { return Ok(()) };
                let dataset = Rc::new(dataset);
                for member in members {
                    let Some((scalar, order)) = scalar(&member.datatype) else { continue };
                    let dataset = Rc::clone(&dataset);
                    let offset = member.byte_offset as usize;
                    check_name(path.len() + 1 + member.name.len())?;
                    let path = format!("{path}.{}", member.name);
                    self.found.arrays.push(array(self.room, &path)?);
                    self.found.stored.push(Stored { dataset, field: Some(Field { offset, scalar, order }) });
                }
            }
            DType::F32 | DType::F64 | DType::I8 | DType::I16 | DType::I32 | DType::I64 => {
                self.keep(array(self.room, &path)?, dataset);
            }
            DType::U8 | DType::U16 | DType::U32 | DType::U64 if class(&attributes) != Some("char") => {
                self.keep(array(self.room, &path)?, dataset);
            }
            _ => {}
        }
        Ok(())
    }

    fn keep(&mut self, array: Array, dataset: Dataset) {
        self.found.arrays.push(array);
        self.found.stored.push(Stored { dataset: Rc::new(dataset), field: None });
    }
}

fn class(attributes: &std::collections::HashMap<String, AttrValue>) -> Option<&str> {
    match attributes.get("MATLAB_class")? {
        AttrValue::String(class) | AttrValue::AsciiString(class) => Some(class.trim_end_matches('\0')),
        _ => None,
    }
}

fn text(dataset: &Dataset) -> Option<String> {
    const MAX_CHARACTERS: u64 = 1000;
    let attributes = dataset.attrs().ok()?;
    let count: u64 = dataset.shape().ok()?.iter().product();
    if class(&attributes) != Some("char") || count > MAX_CHARACTERS || attributes.contains_key("MATLAB_empty") {
        return None;
    }
    let text = String::from_utf16_lossy(&dataset.read_u16().ok()?);
    let text = text.trim();
    (!text.is_empty()).then(|| short(text))
}

fn scalar(kind: &Datatype) -> Option<(Scalar, Order)> {
    let order = |order: &DatatypeByteOrder| match order {
        DatatypeByteOrder::LittleEndian => Some(Order::Little),
        DatatypeByteOrder::BigEndian => Some(Order::Big),
        DatatypeByteOrder::Vax => None,
    };
    match kind {
        Datatype::FixedPoint { size, byte_order, layout } => {
            let scalar = match (size, layout.signed) {
                (1, true) => Scalar::I8,
                (1, false) => Scalar::U8,
                (2, true) => Scalar::I16,
                (2, false) => Scalar::U16,
                (4, true) => Scalar::I32,
                (4, false) => Scalar::U32,
                (8, true) => Scalar::I64,
                (8, false) => Scalar::U64,
                _ => return None,
            };
            Some((scalar, order(byte_order)?))
        }
        Datatype::FloatingPoint { size: 4, byte_order, .. } => Some((Scalar::F32, order(byte_order)?)),
        Datatype::FloatingPoint { size: 8, byte_order, .. } => Some((Scalar::F64, order(byte_order)?)),
        _ => None,
    }
}

impl Stored {
    /// Checks the stated sizes before the library allocates memory for them.
    fn values(&self, room: &Room) -> Result<Vec<f64>, Fault> {
        let chunk = self.dataset.chunk_shape().map_err(damaged)?.unwrap_or_default();
        let size = self.dataset.element_size().map_err(damaged)?;
        let shape = self.dataset.shape().map_err(damaged)?;
        let bytes = |dims: &[u64]| dims.iter().fold(size.max(8), |product, dim| product.saturating_mul(*dim));
        room.check(bytes(&shape).max(bytes(&chunk)))?;
        let Some(field) = &self.field else {
            return Ok(self.dataset.read_f64().map_err(damaged)?);
        };
        let size = usize::try_from(size).unwrap_or(usize::MAX).max(1);
        let raw = self.dataset.read_raw().map_err(damaged)?;
        let value = |row: &[u8]| field.scalar.read(row.get(field.offset..)?, field.order);
        let values: Option<Vec<f64>> = raw.chunks_exact(size).map(value).collect();
        Ok(values.ok_or_else(|| damaged("a field is beyond its row"))?)
    }
}

impl Container for Hdf5 {
    fn arrays(&self) -> &[Array] {
        &self.arrays
    }

    fn values(&mut self, index: usize, room: &Room) -> Result<Vec<f64>, Fault> {
        let expected = self.arrays[index].len();
        let values = guarded(Format::Hdf5, || self.stored[index].values(room))?;
        if values.len() == expected {
            Ok(values)
        } else {
            Err(damaged("a dataset has not as many values as its shape").into())
        }
    }
}
