//! Tables for other libraries, through the C data interface of Apache Arrow.
//!
//! The interface is two C structures and a stream, written here as they are documented
//! (<https://arrow.apache.org/docs/format/CDataInterface.html>), so that neither this crate nor its users need an Arrow
//! library. Columns of numbers are not copied: the exported structure holds a reference to their numpy array.

use std::ffi::{CString, c_char, c_int, c_void};
use std::ptr::{null, null_mut};

use numpy::{Element, PyArray1, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyCapsule;

use crate::error;

#[repr(C)]
pub(crate) struct ArrowSchema {
    format: *const c_char,
    name: *const c_char,
    metadata: *const c_char,
    flags: i64,
    n_children: i64,
    children: *mut *mut ArrowSchema,
    dictionary: *mut ArrowSchema,
    release: Option<unsafe extern "C" fn(*mut ArrowSchema)>,
    private_data: *mut c_void,
}

#[repr(C)]
pub(crate) struct ArrowArray {
    length: i64,
    null_count: i64,
    offset: i64,
    n_buffers: i64,
    n_children: i64,
    buffers: *mut *const c_void,
    children: *mut *mut ArrowArray,
    dictionary: *mut ArrowArray,
    release: Option<unsafe extern "C" fn(*mut ArrowArray)>,
    private_data: *mut c_void,
}

#[repr(C)]
struct ArrowArrayStream {
    get_schema: Option<unsafe extern "C" fn(*mut ArrowArrayStream, *mut ArrowSchema) -> c_int>,
    get_next: Option<unsafe extern "C" fn(*mut ArrowArrayStream, *mut ArrowArray) -> c_int>,
    get_last_error: Option<unsafe extern "C" fn(*mut ArrowArrayStream) -> *const c_char>,
    release: Option<unsafe extern "C" fn(*mut ArrowArrayStream)>,
    private_data: *mut c_void,
}

/// The flag of a column that can have undefined values.
const NULLABLE: i64 = 2;

/// The memory of a column.
enum Buffer {
    /// The data of a numpy array, which the reference keeps alive.
    Shared {
        data: *const c_void,
        _array: Py<PyAny>,
    },
    Owned(Vec<u8>),
}

// SAFETY: the pointer refers to memory of the array, which is not written while it is exported and may be read and
// released from any thread; the reference to the array is `Send`.
#[allow(unsafe_code, reason = "a raw pointer is not Send by itself")]
unsafe impl Send for Buffer {}

impl Buffer {
    fn pointer(&self) -> *const c_void {
        match self {
            Self::Shared { data, .. } => *data,
            Self::Owned(bytes) => bytes.as_ptr().cast(),
        }
    }
}

/// The name and the type of a column.
struct Field {
    name: CString,
    format: &'static str,
    /// Key and value pairs in the encoding of the interface; empty for none.
    metadata: Vec<u8>,
}

/// A column of a table.
struct Column {
    field: Field,
    length: usize,
    nulls: usize,
    /// The first one is the bitmap of defined values; `None` if all are defined.
    buffers: Vec<Option<Buffer>>,
}

impl Column {
    fn of(name: &str, values: &Bound<'_, PyAny>, metadata: &[(String, String)]) -> PyResult<Self> {
        let column = |format, length, nulls, buffers| -> PyResult<Self> {
            let name = CString::new(name).map_err(error::value)?;
            let field = Field { name, format, metadata: encoded(metadata) };
            Ok(Self { field, length, nulls, buffers })
        };
        if let Some((length, buffer)) = shared::<f64>(values)? {
            return column("g", length, 0, vec![None, Some(buffer)]);
        }
        if let Some((length, buffer)) = shared::<i64>(values)? {
            return column("l", length, 0, vec![None, Some(buffer)]);
        }
        if let Some((length, buffer)) = shared::<u8>(values)? {
            return column("C", length, 0, vec![None, Some(buffer)]);
        }
        if let Some((length, buffer)) = shared::<i8>(values)? {
            return column("c", length, 0, vec![None, Some(buffer)]);
        }
        // Booleans are bits in Arrow, and texts have no fixed length, so both are copied.
        if let Ok(flags) = values.extract::<Vec<Option<bool>>>() {
            let bits = |of: fn(&Option<bool>) -> bool| packed(flags.iter().map(of));
            let nulls = flags.iter().filter(|flag| flag.is_none()).count();
            let defined = (nulls > 0).then(|| Buffer::Owned(bits(Option::is_some)));
            return column(
                "b",
                flags.len(),
                nulls,
                vec![defined, Some(Buffer::Owned(bits(|flag| *flag == Some(true))))],
            );
        }
        if let Ok(numbers) = values.extract::<Vec<Option<f64>>>() {
            let nulls = numbers.iter().filter(|number| number.is_none()).count();
            let defined = (nulls > 0).then(|| Buffer::Owned(packed(numbers.iter().map(Option::is_some))));
            let bytes = numbers.iter().flat_map(|number| number.unwrap_or(f64::NAN).to_ne_bytes()).collect();
            return column("g", numbers.len(), nulls, vec![defined, Some(Buffer::Owned(bytes))]);
        }
        let texts: Vec<Option<String>> = values
            .extract()
            .map_err(|_| PyTypeError::new_err(format!("the column {name} has values of other types")))?;
        let nulls = texts.iter().filter(|text| text.is_none()).count();
        let defined = (nulls > 0).then(|| Buffer::Owned(packed(texts.iter().map(Option::is_some))));
        let (mut offsets, mut bytes) = (0_i64.to_ne_bytes().to_vec(), vec![]);
        for text in &texts {
            bytes.extend_from_slice(text.as_deref().unwrap_or_default().as_bytes());
            offsets.extend_from_slice(&(bytes.len() as i64).to_ne_bytes());
        }
        column("U", texts.len(), nulls, vec![defined, Some(Buffer::Owned(offsets)), Some(Buffer::Owned(bytes))])
    }
}

/// The length and the memory of a contiguous array of a type; `None` for other values.
fn shared<T: Element>(values: &Bound<'_, PyAny>) -> PyResult<Option<(usize, Buffer)>> {
    let Ok(array) = values.cast::<PyArray1<T>>() else { return Ok(None) };
    if !array.is_contiguous() {
        return Err(error::value("the array is not contiguous"));
    }
    let buffer = Buffer::Shared { data: array.data().cast_const().cast(), _array: array.clone().into_any().unbind() };
    Ok(Some((array.len(), buffer)))
}

fn packed(flags: impl Iterator<Item = bool>) -> Vec<u8> {
    let mut bytes = vec![];
    for (index, flag) in flags.enumerate() {
        if index % 8 == 0 {
            bytes.push(0);
        }
        if let Some(last) = bytes.last_mut() {
            *last |= u8::from(flag) << (index % 8);
        }
    }
    bytes
}

fn encoded(metadata: &[(String, String)]) -> Vec<u8> {
    let mut bytes = vec![];
    if !metadata.is_empty() {
        bytes.extend_from_slice(&(metadata.len() as i32).to_ne_bytes());
        for text in metadata.iter().flat_map(|(key, value)| [key, value]) {
            bytes.extend_from_slice(&(text.len() as i32).to_ne_bytes());
            bytes.extend_from_slice(text.as_bytes());
        }
    }
    bytes
}

/// The memory behind an exported schema.
struct SchemaMemory {
    _format: CString,
    _name: CString,
    _metadata: Vec<u8>,
    children: Vec<*mut ArrowSchema>,
}

fn schema(format: &str, name: CString, metadata: Vec<u8>, children: Vec<ArrowSchema>) -> ArrowSchema {
    let children: Vec<_> = children.into_iter().map(|child| Box::into_raw(Box::new(child))).collect();
    // The formats contain no zero byte.
    let format = CString::new(format).unwrap_or_default();
    let flags = if children.is_empty() { NULLABLE } else { 0 };
    let mut memory = Box::new(SchemaMemory { _format: format, _name: name, _metadata: metadata, children });
    ArrowSchema {
        format: memory._format.as_ptr(),
        name: memory._name.as_ptr(),
        metadata: if memory._metadata.is_empty() { null() } else { memory._metadata.as_ptr().cast() },
        flags,
        n_children: memory.children.len() as i64,
        children: memory.children.as_mut_ptr(),
        dictionary: null_mut(),
        release: Some(release_schema),
        private_data: Box::into_raw(memory).cast(),
    }
}

/// The memory behind an exported array.
struct ArrayMemory {
    _buffers: Vec<Option<Buffer>>,
    pointers: Vec<*const c_void>,
    children: Vec<*mut ArrowArray>,
}

fn array(length: usize, nulls: usize, buffers: Vec<Option<Buffer>>, children: Vec<ArrowArray>) -> ArrowArray {
    let children: Vec<_> = children.into_iter().map(|child| Box::into_raw(Box::new(child))).collect();
    let pointers = buffers.iter().map(|buffer| buffer.as_ref().map_or(null(), Buffer::pointer)).collect();
    let mut memory = Box::new(ArrayMemory { _buffers: buffers, pointers, children });
    ArrowArray {
        length: length as i64,
        null_count: nulls as i64,
        offset: 0,
        n_buffers: memory.pointers.len() as i64,
        n_children: memory.children.len() as i64,
        buffers: memory.pointers.as_mut_ptr(),
        children: memory.children.as_mut_ptr(),
        dictionary: null_mut(),
        release: Some(release_array),
        private_data: Box::into_raw(memory).cast(),
    }
}

/// A table that is exported once.
struct Stream {
    fields: Vec<Field>,
    length: usize,
    /// The columns; `None` after the only batch.
    columns: Option<Vec<ArrowArray>>,
}

impl Drop for Stream {
    fn drop(&mut self) {
        for mut column in self.columns.take().into_iter().flatten() {
            // SAFETY: the column is an array of this module that no consumer has received.
            #[allow(unsafe_code, reason = "a function of the C interface")]
            unsafe {
                release_array(&raw mut column);
            }
        }
    }
}

/// # Safety
/// `schema` points to a schema that [`schema`] made and that is not released, as the interface demands.
#[allow(unsafe_code, reason = "a function of the C interface")]
unsafe extern "C" fn release_schema(schema: *mut ArrowSchema) {
    // SAFETY: by the contract of this function, `private_data` and the children are boxes of this module.
    unsafe {
        let memory = Box::from_raw((*schema).private_data.cast::<SchemaMemory>());
        for &child in &memory.children {
            // A consumer may have moved a child, which sets its `release` to null.
            if let Some(release) = (*child).release {
                release(child);
            }
            drop(Box::from_raw(child));
        }
        (*schema).release = None;
    }
}

/// # Safety
/// `array` points to an array that [`array`] made and that is not released, as the interface demands.
#[allow(unsafe_code, reason = "a function of the C interface")]
unsafe extern "C" fn release_array(array: *mut ArrowArray) {
    // SAFETY: by the contract of this function, `private_data` and the children are boxes of this module.
    unsafe {
        let memory = Box::from_raw((*array).private_data.cast::<ArrayMemory>());
        for &child in &memory.children {
            if let Some(release) = (*child).release {
                release(child);
            }
            drop(Box::from_raw(child));
        }
        (*array).release = None;
        // The references to numpy arrays are dropped in any thread, and without the interpreter, which they reach later.
        drop(memory);
    }
}

/// # Safety
/// `stream` points to a stream of [`arrow_stream`] that is not released, and `out` to memory for a schema.
#[allow(unsafe_code, reason = "a function of the C interface")]
unsafe extern "C" fn get_schema(stream: *mut ArrowArrayStream, out: *mut ArrowSchema) -> c_int {
    // SAFETY: by the contract of this function, `private_data` is a `Stream`, and `out` can be written.
    unsafe {
        let table = &*(*stream).private_data.cast::<Stream>();
        let of_field = |field: &Field| schema(field.format, field.name.clone(), field.metadata.clone(), vec![]);
        out.write(schema("+s", CString::default(), vec![], table.fields.iter().map(of_field).collect()));
    }
    0
}

/// # Safety
/// `stream` points to a stream of [`arrow_stream`] that is not released, and `out` to memory for an array.
#[allow(unsafe_code, reason = "a function of the C interface")]
unsafe extern "C" fn get_next(stream: *mut ArrowArrayStream, out: *mut ArrowArray) -> c_int {
    // SAFETY: by the contract of this function, `private_data` is a `Stream`, and `out` can be written.
    unsafe {
        let table = &mut *(*stream).private_data.cast::<Stream>();
        out.write(match table.columns.take() {
            Some(columns) => array(table.length, 0, vec![None], columns),
            // An array without a release function ends the stream.
            None => ENDED,
        });
    }
    0
}

/// A released array.
const ENDED: ArrowArray = ArrowArray {
    length: 0,
    null_count: 0,
    offset: 0,
    n_buffers: 0,
    n_children: 0,
    buffers: null_mut(),
    children: null_mut(),
    dictionary: null_mut(),
    release: None,
    private_data: null_mut(),
};

/// # Safety
/// As the interface demands; nothing is read.
#[allow(unsafe_code, reason = "a function of the C interface")]
unsafe extern "C" fn get_last_error(_stream: *mut ArrowArrayStream) -> *const c_char {
    null()
}

/// # Safety
/// `stream` points to a stream of [`arrow_stream`] that is not released.
#[allow(unsafe_code, reason = "a function of the C interface")]
unsafe extern "C" fn release_stream(stream: *mut ArrowArrayStream) {
    // SAFETY: by the contract of this function, `private_data` is a boxed `Stream`.
    unsafe {
        drop(Box::from_raw((*stream).private_data.cast::<Stream>()));
        (*stream).release = None;
    }
}

/// The stream in a capsule, which releases it unless a consumer has moved it.
#[repr(transparent)]
struct Exported(ArrowArrayStream);

// SAFETY: the stream is used by one thread at a time, and its memory may be released from any thread.
#[allow(unsafe_code, reason = "a raw pointer is not Send by itself")]
unsafe impl Send for Exported {}

impl Drop for Exported {
    fn drop(&mut self) {
        if let Some(release) = self.0.release {
            // SAFETY: a stream with a release function is not released.
            #[allow(unsafe_code, reason = "a function of the C interface")]
            unsafe {
                release(&raw mut self.0);
            }
        }
    }
}

/// The name of a column, its values, and its metadata.
type NamedColumn<'py> = (String, Bound<'py, PyAny>, Vec<(String, String)>);

/// A capsule `arrow_array_stream` with one batch of named columns of the same length: one-dimensional contiguous arrays
/// of float64, int64, uint8 or int8, which are not copied, or lists of booleans, numbers or texts, with `None` where
/// undefined. Each column can have metadata.
#[pyfunction]
pub(crate) fn arrow_stream<'py>(py: Python<'py>, columns: Vec<NamedColumn<'py>>) -> PyResult<Bound<'py, PyCapsule>> {
    let columns = columns.iter().map(|(name, values, metadata)| Column::of(name, values, metadata));
    let columns = columns.collect::<PyResult<Vec<_>>>()?;
    if let Some(other) = columns.iter().find(|column| column.length != columns[0].length) {
        let name = other.field.name.to_string_lossy();
        return Err(error::value(format!("the column {name} has {} values, not {}", other.length, columns[0].length)));
    }
    let length = columns.first().map_or(0, |column| column.length);
    let (fields, columns) = columns
        .into_iter()
        .map(|Column { field, length, nulls, buffers }| (field, array(length, nulls, buffers, vec![])))
        .unzip();
    let table = Box::new(Stream { fields, length, columns: Some(columns) });
    let stream = ArrowArrayStream {
        get_schema: Some(get_schema),
        get_next: Some(get_next),
        get_last_error: Some(get_last_error),
        release: Some(release_stream),
        private_data: Box::into_raw(table).cast(),
    };
    PyCapsule::new_with_value(py, Exported(stream), c"arrow_array_stream")
}
