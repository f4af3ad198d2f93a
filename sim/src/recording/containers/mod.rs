//! Files of named arrays: a module per format.
//!
//! A [`Container`] gives its arrays by name, with their sizes; [`name`] picks a signal out of them, [`read`] makes a recording of
//! signals. A format is a module here and a line in [`formats!`].

mod bytes;
mod foreign;
mod mat;
mod mat4;
mod name;
mod parquet;
mod read;
mod tdms;

#[cfg(feature = "lab-formats")]
mod excel;
#[cfg(feature = "lab-formats")]
mod hdf5;

use std::fmt;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use super::error::{Problem, Row};
use super::{Limits, utf16};

pub(super) use foreign::guarded;
pub(super) use name::vectors;
pub(super) use read::{read, scan};

/// The feature with the formats of large libraries.
pub(super) const LAB_FORMATS: &str = "lab-formats";

/// An array of numbers in a file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Array {
    /// Its name, with the path to it.
    pub(super) name: String,
    /// Other names of it, such as the header of a column.
    pub(super) aliases: Vec<String>,
    /// Its size in each dimension, as its own program gives it.
    pub(super) dims: Vec<usize>,
    /// Whether the first index varies fastest in [`Container::values`]; otherwise the last.
    pub(super) column_major: bool,
    /// A text of the file about it.
    pub(super) label: Option<String>,
    /// Its unit, as the file gives it.
    pub(super) unit: Option<String>,
}

impl Array {
    /// An array without text, of rows first.
    pub(super) fn new(name: impl Into<String>, dims: Vec<usize>) -> Self {
        Self { name: name.into(), aliases: vec![], dims, column_major: false, label: None, unit: None }
    }

    /// The number of its elements.
    pub(super) fn len(&self) -> usize {
        self.dims.iter().fold(1, |product, dim| product.saturating_mul(*dim))
    }
}

/// A problem at a sample of an array.
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

/// A file of named arrays.
pub(super) trait Container {
    /// Its arrays of numbers, in the order of the file.
    fn arrays(&self) -> &[Array];

    /// All elements of an array, in its order; NaN where the file has no number.
    fn values(&mut self, index: usize) -> Result<Vec<f64>, Fault>;

    /// The place of a sample of an array in messages.
    fn row(&self, _index: usize, sample: usize) -> Row {
        Row::Sample(sample as u64)
    }
}

/// Declares the formats: variant, phrase, suffixes of its files in lower case, and the phrase for what to export instead.
macro_rules! formats {
    ($($(#[doc = $doc:literal])* $Format:ident: $phrase:literal, [$($suffix:literal),*], $instead:literal;)*) => {
        /// The format of a file with a recording.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Format {
            $($(#[doc = $doc])* $Format,)*
        }

        impl Format {
            /// All formats.
            pub const ALL: &'static [Self] = &[$(Self::$Format),*];

            /// The suffixes of its files, in lower case.
            #[must_use]
            pub fn suffixes(self) -> &'static [&'static str] {
                match self { $(Self::$Format => &[$($suffix),*],)* }
            }

            /// What to export instead of it.
            pub(super) fn alternative(self) -> &'static str {
                match self { $(Self::$Format => $instead,)* }
            }
        }

        impl fmt::Display for Format {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(match self { $(Self::$Format => $phrase,)* })
            }
        }
    };
}

formats! {
    /// Text with a line per sample; LabVIEW's measurement files too.
    Csv: "a table in text", ["csv", "tsv", "lvm"], "CSV";
    /// MATLAB, up to version 7.
    Mat: "a MATLAB file", ["mat"], "CSV";
    /// HDF5; MATLAB 7.3 too.
    Hdf5: "an HDF5 file (or MATLAB 7.3)", ["h5", "hdf5"], "MATLAB v7 (save -v7), Parquet or CSV";
    /// Apache Parquet.
    Parquet: "a Parquet file", ["parquet"], "CSV";
    /// LabVIEW's binary measurement files.
    Tdms: "a TDMS file", ["tdms"], "CSV";
    /// Excel and OpenDocument spreadsheets.
    Excel: "a spreadsheet", ["xlsx", "xlsm", "xlsb", "xls", "ods"], "CSV";
}

impl Format {
    /// The format of a file, by its first bytes. What nothing else claims is text; a MATLAB file of version 4 has no mark, and is
    /// known by the name of the file.
    pub(super) fn of(path: &Path, file: &mut (impl Read + Seek)) -> std::io::Result<Self> {
        const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";
        let mut head = vec![];
        file.by_ref().take(1024).read_to_end(&mut head)?;
        file.seek(SeekFrom::Start(0))?;
        let at = |offset: usize, mark: &[u8]| head.get(offset..).is_some_and(|rest| rest.starts_with(mark));
        let is_mat = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("mat"));
        Ok(match () {
            () if [0, 512].into_iter().any(|offset| at(offset, HDF5)) || at(0, b"MATLAB 7.3") => Self::Hdf5,
            () if at(0, b"MATLAB 5.0") || at(126, b"IM") && at(124, b"\x00\x01") || at(124, b"\x01\x00MI") => Self::Mat,
            () if at(0, b"PAR1") => Self::Parquet,
            () if at(0, b"TDSm") => Self::Tdms,
            () if at(0, b"PK\x03\x04") || at(0, b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1") => Self::Excel,
            () if is_mat && head.contains(&0) && !utf16::is_marked(&head) => Self::Mat,
            () => Self::Csv,
        })
    }

    /// The error of a damaged file.
    pub(super) fn damaged(self, detail: impl fmt::Display) -> Problem {
        let detail = super::error::line(&detail.to_string()).into();
        Problem::Damaged { format: self, detail }
    }

    /// Opens a file of this format, which is not text.
    pub(super) fn open(self, mut file: std::fs::File, limits: &Limits) -> Result<Box<dyn Container>, Problem> {
        let mut whole = || {
            let mut bytes = vec![];
            file.by_ref().take(limits.max_bytes).read_to_end(&mut bytes).map_err(Problem::Unreadable)?;
            Ok::<_, Problem>(bytes)
        };
        Ok(match self {
            Self::Csv => return Err(Problem::Unsupported(self)),
            Self::Mat => mat::open(whole()?, limits)?,
            Self::Tdms => Box::new(tdms::Tdms::open(whole()?, limits)?),
            Self::Parquet => guarded(self, || Ok(Box::new(parquet::Parquet::open(file, limits)?)))?,
            #[cfg(feature = "lab-formats")]
            Self::Hdf5 => {
                let bytes = whole()?;
                guarded(self, || Ok(Box::new(hdf5::Hdf5::open(bytes, limits)?)))?
            }
            #[cfg(feature = "lab-formats")]
            Self::Excel => {
                let bytes = whole()?;
                guarded(self, || Ok(Box::new(excel::Excel::open(bytes, limits)?)))?
            }
            #[cfg(not(feature = "lab-formats"))]
            Self::Hdf5 | Self::Excel => return Err(Problem::Unsupported(self)),
        })
    }
}

/// Checks that an array of `len` elements may be held.
pub(super) fn check_size(len: usize, limits: &Limits) -> Result<(), Problem> {
    let size = (len as u64).saturating_mul(8);
    if size <= limits.max_bytes { Ok(()) } else { Err(Problem::TooLarge { size, limit: limits.max_bytes }) }
}
