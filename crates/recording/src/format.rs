use std::fmt;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use super::utf16;

/// Variant, description, suffixes in lower case, and the alternative format to export.
macro_rules! formats {
    ($($(#[doc = $doc:literal])* $Format:ident: $phrase:literal, [$($suffix:literal),*], $instead:literal;)*) => {
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Format {
            $($(#[doc = $doc])* $Format,)*
        }

        impl Format {
            pub const ALL: &'static [Self] = &[$(Self::$Format),*];

            pub fn suffixes(self) -> &'static [&'static str] {
                match self { $(Self::$Format => &[$($suffix),*],)* }
            }

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
    Csv: "a table in text", ["csv", "tsv", "lvm", "gz"], "CSV";
    JsonLines: "a file of JSON lines", ["jsonl", "ndjson"], "CSV";
    Npy: "an array of NumPy", ["npy"], "CSV";
    Npz: "an archive of NumPy", ["npz"], "CSV";
    Mat: "a MATLAB file", ["mat"], "CSV";
    Hdf5: "an HDF5 file (or MATLAB 7.3)", ["h5", "hdf5"], "MATLAB v7 (save -v7), Parquet or CSV";
    Parquet: "a Parquet file", ["parquet"], "CSV";
    Mcap: "an MCAP log", ["mcap"], "CSV";
    Tdms: "a TDMS file", ["tdms"], "CSV";
    Excel: "a spreadsheet", ["xlsx", "xlsm", "xls"], "CSV";
    // Not read; [`Format::conversion`] names the program that converts them.
    Xls: "an old Excel spreadsheet", [], "CSV";
    Xlsb: "a binary spreadsheet (.xlsb)", [], "CSV";
    Ods: "an OpenDocument spreadsheet", [], "CSV";
    Mat4: "a MATLAB file of version 4 (without the header of versions 5 to 7)", [], "MATLAB v7";
    Arrow: "an Arrow or Feather file", [], "Parquet";
    Rosbag2: "a ROS 2 bag in SQLite", ["db3"], "MCAP";
    Rosbag1: "a ROS 1 bag", ["bag"], "MCAP";
}

impl Format {
    pub(super) fn conversion(self) -> Option<&'static str> {
        match self {
            Self::Xls | Self::Xlsb | Self::Ods => {
                Some("`pandas.read_excel('FILE').to_csv('FILE.csv', index=False)` (Python)")
            }
            Self::Mat4 => Some("`scipy.io.savemat('NEW.mat', scipy.io.loadmat('FILE'))` (Python)"),
            Self::Arrow => Some("`pandas.read_feather('FILE').to_parquet('FILE.parquet')` (Python)"),
            Self::Rosbag2 => {
                Some("`rosbags-convert --src FOLDER --dst NEW --dst-storage mcap` (from `pip install rosbags`)")
            }
            Self::Rosbag1 => Some("`mcap convert FILE FILE.mcap` (from github.com/foxglove/mcap)"),
            Self::Csv
            | Self::JsonLines
            | Self::Npy
            | Self::Npz
            | Self::Mat
            | Self::Hdf5
            | Self::Parquet
            | Self::Mcap
            | Self::Tdms
            | Self::Excel => None,
        }
    }

    /// Unknown files count as text. A MATLAB file of version 4 has no signature: it is binary and has the suffix.
    pub(super) fn of(path: &Path, file: &mut (impl Read + Seek)) -> io::Result<Self> {
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
            () if at(0, b"\x89MCAP0\r\n") => Self::Mcap,
            () if at(0, b"TDSm") => Self::Tdms,
            () if at(0, b"\x93NUMPY") => Self::Npy,
            () if is_npz(&head) => Self::Npz,
            () if at(0, b"ARROW1") => Self::Arrow,
            () if at(0, b"SQLite format 3\0") => Self::Rosbag2,
            () if at(0, b"#ROSBAG V") => Self::Rosbag1,
            () if at(30, b"mimetypeapplication/vnd.oasis.opendocument") => Self::Ods,
            () if at(0, b"PK\x03\x04") => Self::Excel,
            () if at(0, b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1") => Self::Xls,
            () if is_mat && head.contains(&0) && !utf16::is_marked(&head) => Self::Mat4,
            () => Self::of_text(&head),
        })
    }

    pub(super) fn of_text(head: &[u8]) -> Self {
        let content = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head).trim_ascii_start();
        if content.starts_with(b"{") { Self::JsonLines } else { Self::Csv }
    }
}

/// The first file's name is at byte 30, its length at byte 26.
fn is_npz(head: &[u8]) -> bool {
    let name = |length: &[u8]| head.get(30..)?.get(..usize::from(u16::from_le_bytes(*length.first_chunk()?)));
    head.starts_with(b"PK\x03\x04") && head.get(26..).and_then(name).is_some_and(|name| name.ends_with(b".npy"))
}
