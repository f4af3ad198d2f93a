use std::fs::File;
use std::io::{BufRead, BufReader};

use flate2::read::MultiGzDecoder;

use crate::error::Problem;

pub(crate) fn gunzipped(file: File) -> Result<impl BufRead + use<>, Problem> {
    Ok(BufReader::new(MultiGzDecoder::new(file)))
}
