//! Files of named arrays, one module per format.
//!
//! A new format needs a module here, a line in [`Format`] and one in [`open`].

mod array_file;
mod bytes;
mod excel;
mod foreign;
mod gzip;
mod hdf5;
mod join;
mod json;
mod json_lines;
mod loaded;
mod mat;
mod mcap;
mod name;
mod npy;
mod parquet;
mod read;
mod ros;
mod tdms;
mod topics;

use std::fs::File;
use std::io::Read;

use super::Format;
use super::error::{Problem, Row};
use super::room::{Room, check_dimensions};

pub(super) use array_file::ArrayFile;
use foreign::guarded;
pub(super) use gzip::gunzipped;
use loaded::Loaded;
use name::{has_signals, listed};

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Array {
    pub(super) name: String,
    /// Such as the header of a column.
    pub(super) aliases: Vec<String>,
    pub(super) dims: Vec<usize>,
    /// True if the first index varies fastest in [`Container::values`], false if the last does.
    pub(super) column_major: bool,
    pub(super) label: Option<String>,
    pub(super) unit: Option<String>,
    pub(super) clock: Option<usize>,
    /// True for times that all topics of a log share.
    pub(super) is_shared_time: bool,
}

impl Array {
    pub(super) fn new(name: impl Into<String>, dims: Vec<usize>) -> Self {
        Self {
            name: name.into(),
            aliases: vec![],
            dims,
            column_major: false,
            label: None,
            unit: None,
            clock: None,
            is_shared_time: false,
        }
    }

    fn in_room(name: &str, dims: Vec<usize>, room: &Room) -> Result<Self, Problem> {
        check_dimensions(dims.len())?;
        room.take_signals(name, listed(&dims))?;
        Ok(Self::new(name, dims))
    }

    pub(super) fn len(&self) -> usize {
        self.dims.iter().fold(1, |product, dim| product.saturating_mul(*dim))
    }
}

#[derive(Debug)]
pub(super) struct Fault {
    pub(super) row: Option<Row>,
    pub(super) problem: Problem,
}

impl From<Problem> for Fault {
    fn from(problem: Problem) -> Self {
        Self { row: None, problem }
    }
}

pub(super) trait Container {
    fn arrays(&self) -> &[Array];

    /// NaN if the file has no number. The caller takes the room for them.
    fn values(&mut self, index: usize, room: &Room) -> Result<Vec<f64>, Fault>;

    fn unfinished(&self) -> Option<&str> {
        None
    }

    fn row(&self, _index: usize, sample: usize) -> Row {
        Row::Sample(sample as u64)
    }
}

fn open(format: Format, mut file: File, room: &Room) -> Result<Box<dyn Container>, Problem> {
    let mut whole = || {
        let mut bytes = vec![];
        file.by_ref().take(room.limits().max_bytes).read_to_end(&mut bytes).map_err(Problem::Unreadable)?;
        Ok::<_, Problem>(bytes)
    };
    Ok(match format {
        Format::Npy => {
            let bytes = whole()?;
            guarded(format, || Ok(Box::new(npy::open_array(&bytes, room)?)))?
        }
        Format::Npz => {
            let bytes = whole()?;
            guarded(format, || Ok(Box::new(npy::open_archive(bytes, room)?)))?
        }
        Format::Mat => mat::open(whole()?, room)?,
        Format::Tdms => Box::new(tdms::Tdms::open(whole()?, room)?),
        Format::Mcap => {
            let bytes = whole()?;
            guarded(format, || Ok(Box::new(mcap::open(&bytes, room)?)))?
        }
        Format::Parquet => guarded(format, || Ok(Box::new(parquet::Parquet::open(file, room)?)))?,
        Format::Hdf5 => {
            let bytes = whole()?;
            guarded(format, || Ok(Box::new(hdf5::Hdf5::open(bytes, room)?)))?
        }
        Format::Excel => {
            let bytes = whole()?;
            guarded(format, || Ok(Box::new(excel::Excel::open(bytes, room)?)))?
        }
        Format::Csv
        | Format::JsonLines
        | Format::Xls
        | Format::Xlsb
        | Format::Ods
        | Format::Mat4
        | Format::Arrow
        | Format::Rosbag2
        | Format::Rosbag1 => return Err(Problem::Unsupported(format)),
    })
}
