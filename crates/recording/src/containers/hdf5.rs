//! HDF5 files: a signal `/group/dataset` per dataset of numbers, and `/group/table.field` per field of a compound
//! dataset. MATLAB 7.3 files are also read, with the names of earlier versions: `scope.signals[0].values`. A library
//! reads the files; [`guarded`] converts its panics to errors.

use std::rc::Rc;

use hdf5_pure::{AttrValue, DType, Dataset, Datatype, DatatypeByteOrder, File, Group, Object};

use super::bytes::{Order, Scalar};
use super::{Array, Container, Fault, Format, check_size, guarded};
use crate::Limits;
use crate::error::Problem;

/// Maximum depth of nested groups; links can form cycles.
const MAX_DEPTH: usize = 16;

const MAX_OBJECTS: usize = 100_000;

const UNITS: [&str; 4] = ["units", "unit", "Units", "Unit"];

/// Datasets of a MATLAB structure that describe its arrays.
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
    limits: Limits,
    is_matlab: bool,
    objects: usize,
    /// The names in each group that contains the present one.
    outer: Vec<Vec<String>>,
}

fn damaged(error: impl std::fmt::Display) -> Problem {
    Format::Hdf5.damaged(error)
}

impl Hdf5 {
    pub(super) fn open(bytes: Vec<u8>, limits: &Limits) -> Result<Self, Problem> {
        let is_matlab = bytes.starts_with(b"MATLAB");
        let file = File::from_bytes(bytes).map_err(damaged)?;
        let mut found =
            Self { arrays: vec![], stored: vec![], limits: limits.clone(), is_matlab, objects: 0, outer: vec![] };
        found.group(&file.root(), "", 0)?;
        if super::vectors(&found.arrays).is_empty() { Err(Problem::no_signal(Format::Hdf5, &[])) } else { Ok(found) }
    }

    fn count(&mut self) -> Result<(), Problem> {
        self.objects += 1;
        if self.objects > MAX_OBJECTS {
            return Err(damaged(format!("it has more than {MAX_OBJECTS} objects")));
        }
        Ok(())
    }

    fn name(&self, outer: &str, name: &str) -> String {
        match (self.is_matlab, outer.is_empty()) {
            (false, _) => format!("{outer}/{name}"),
            (true, true) => name.to_owned(),
            (true, false) => format!("{outer}.{name}"),
        }
    }

    fn group(&mut self, group: &Group, path: &str, depth: usize) -> Result<(), Problem> {
        self.count()?;
        if depth > MAX_DEPTH {
            return Ok(());
        }
        let first = self.arrays.len();
        let mut label = None;
        let datasets = group.datasets().map_err(damaged)?;
        let groups = group.groups().map_err(damaged)?;
        // A link can lead back to an enclosing group. The library does not identify equal groups, so their names are
        // compared.
        let names: Vec<String> = datasets.iter().chain(&groups).cloned().collect();
        if !datasets.is_empty() && !groups.is_empty() && self.outer.contains(&names) {
            return Ok(());
        }
        self.outer.push(names);
        for name in datasets {
            // A dataset that the library cannot read is omitted; the others may be readable.
            let Ok(dataset) = group.dataset(&name) else { continue };
            if self.is_matlab && label.is_none() && LABELS.contains(&name.as_str()) {
                label = text(&dataset);
            }
            self.dataset(dataset, path, &name, depth + 1)?;
        }
        for array in &mut self.arrays[first..] {
            array.label = array.label.take().or_else(|| label.clone());
        }
        for name in groups {
            // MATLAB stores the targets of references there.
            if self.is_matlab && name.starts_with('#') {
                continue;
            }
            let Ok(inner) = group.group(&name) else { continue };
            self.group(&inner, &self.name(path, &name), depth + 1)?;
        }
        self.outer.pop();
        Ok(())
    }

    fn dataset(&mut self, dataset: Dataset, outer: &str, name: &str, depth: usize) -> Result<(), Problem> {
        self.count()?;
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
            AttrValue::String(text) | AttrValue::AsciiString(text) => Some(text.trim_end_matches('\0').to_owned()),
            _ => None,
        });
        let path = self.name(outer, name);
        let array = Array { unit, column_major: self.is_matlab, ..Array::new(&path, dims) };
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
                        Object::Group(group) => self.group(&group, &self.name(&outer, &name), depth + 1)?,
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
                    self.arrays.push(Array { name: format!("{path}.{}", member.name), ..array.clone() });
                    self.stored.push(Stored { dataset, field: Some(Field { offset, scalar, order }) });
                }
            }
            DType::F32 | DType::F64 | DType::I8 | DType::I16 | DType::I32 | DType::I64 => self.keep(array, dataset),
            DType::U8 | DType::U16 | DType::U32 | DType::U64 if class(&attributes) != Some("char") => {
                self.keep(array, dataset);
            }
            _ => {}
        }
        Ok(())
    }

    fn keep(&mut self, array: Array, dataset: Dataset) {
        self.arrays.push(array);
        self.stored.push(Stored { dataset: Rc::new(dataset), field: None });
    }
}

fn class(attributes: &std::collections::HashMap<String, AttrValue>) -> Option<&str> {
    match attributes.get("MATLAB_class")? {
        AttrValue::String(class) | AttrValue::AsciiString(class) => Some(class.trim_end_matches('\0')),
        _ => None,
    }
}

/// The text of a MATLAB character array.
fn text(dataset: &Dataset) -> Option<String> {
    const MAX_CHARACTERS: u64 = 1000;
    let attributes = dataset.attrs().ok()?;
    let count: u64 = dataset.shape().ok()?.iter().product();
    if class(&attributes) != Some("char") || count > MAX_CHARACTERS || attributes.contains_key("MATLAB_empty") {
        return None;
    }
    let text = String::from_utf16_lossy(&dataset.read_u16().ok()?);
    let text = text.trim();
    (!text.is_empty()).then(|| text.to_owned())
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
    /// All elements. Too many are rejected before any allocation.
    fn values(&self, limits: &Limits) -> Result<Vec<f64>, Fault> {
        let chunk = self.dataset.chunk_shape().map_err(damaged)?.unwrap_or_default();
        let size = self.dataset.element_size().map_err(damaged)?;
        let shape = self.dataset.shape().map_err(damaged)?;
        for dims in [&shape, &chunk] {
            let elements = dims.iter().fold(size.max(8) / 8, |product, dim| product.saturating_mul(*dim));
            check_size(usize::try_from(elements).unwrap_or(usize::MAX), limits)?;
        }
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

    fn values(&mut self, index: usize) -> Result<Vec<f64>, Fault> {
        let expected = self.arrays[index].len();
        let values = guarded(Format::Hdf5, || self.stored[index].values(&self.limits))?;
        if values.len() == expected {
            Ok(values)
        } else {
            Err(damaged("a dataset has not as many values as its shape").into())
        }
    }
}
