//! A build without the feature `formats` opens no file of arrays.

use std::convert::Infallible;
use std::fs::File;
use std::io::{BufReader, Read};

use crate::error::{Place, Problem};
use crate::room::Room;
use crate::{Columns, Format, Matrix, Recording, RecordingError, Signal};

pub(crate) struct ArrayFile(Infallible);

impl ArrayFile {
    pub(crate) fn open(format: Format, _: File, _: &Room) -> Result<Self, Problem> {
        Err(Problem::Unsupported(format))
    }

    pub(crate) fn of_json_lines(file: &str, _: impl Read, _: &Room) -> Result<Self, RecordingError> {
        Err(Place::file(file).error(Problem::Unsupported(Format::JsonLines)))
    }

    pub(crate) fn of_matlab(_: Vec<u8>, _: &Room) -> Result<Self, Problem> {
        Err(Problem::Unsupported(Format::Mat))
    }

    pub(crate) fn recording(&mut self, _: &str, _: &Columns, _: &Room) -> Result<Recording, RecordingError> {
        match self.0 {}
    }

    pub(crate) fn signals(&mut self, _: &str, _: &Room) -> Result<Vec<Signal>, RecordingError> {
        match self.0 {}
    }

    pub(crate) fn signal_names(&self) -> Vec<String> {
        match self.0 {}
    }

    pub(crate) fn matrices(&mut self, _: &str, _: &Room) -> Result<Vec<Matrix>, RecordingError> {
        match self.0 {}
    }
}

pub(crate) fn gunzipped(_: File) -> Result<BufReader<File>, Problem> {
    Err(Problem::GzipUnsupported)
}
