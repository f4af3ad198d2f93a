//! Matrices in MATLAB files.

use super::budget::Budget;
use super::containers::ArrayFile;
use super::error::Place;
use super::{Limits, RecordingError};

/// A matrix of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Matrix {
    /// Name, with the path of a matrix inside a structure: `sys.A`.
    pub name: String,
    /// The rows, all of the same length.
    pub rows: Vec<Vec<f64>>,
}

/// Reads the matrices of a MATLAB file (versions 4 to 7), without arrays of other dimensions. `file` names the file in
/// messages.
///
/// # Errors
/// [`RecordingError`] for a damaged file, and for one that exceeds the limits.
pub fn read_matrices(file: &str, bytes: Vec<u8>, limits: &Limits) -> Result<Vec<Matrix>, RecordingError> {
    let budget = Budget::new(limits);
    let mut opened = ArrayFile::of_matlab(bytes, &budget).map_err(|problem| Place::file(file).error(problem))?;
    opened.matrices(file, &budget)
}

#[cfg(all(test, feature = "formats"))]
mod tests {
    use super::*;

    /// A file of version 4: five words of 32 bits, the name and the numbers, column by column.
    fn version_4(name: &str, height: u32, values: &[f64]) -> Vec<u8> {
        let width = values.len() as u32 / height;
        let head = [0, height, width, 0, name.len() as u32 + 1];
        let mut bytes: Vec<u8> = head.iter().flat_map(|word| word.to_le_bytes()).collect();
        bytes.extend(name.bytes().chain([0]));
        bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        bytes
    }

    #[test]
    fn a_matrix_is_read_row_by_row() {
        let bytes = version_4("A", 2, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let found = read_matrices("a.mat", bytes, &Limits::default()).expect("read");
        let rows = vec![vec![1.0, 3.0, 5.0], vec![2.0, 4.0, 6.0]];
        assert_eq!(found, [Matrix { name: "A".into(), rows }]);
    }

    #[test]
    fn a_damaged_file_is_refused() {
        let mut bytes = version_4("A", 2, &[1.0, 2.0, 3.0, 4.0]);
        bytes.truncate(40);
        assert!(read_matrices("a.mat", bytes, &Limits::default()).is_err());
    }
}
