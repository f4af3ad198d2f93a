//! Matrices in MATLAB files.

use super::budget::Budget;
use super::containers::open_mat;
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
    let refuse = |problem| Place::file(file).error(problem);
    let budget = Budget::new(limits);
    let mut container = open_mat(bytes, &budget).map_err(refuse)?;
    let arrays = container.arrays().to_vec();
    let mut matrices = vec![];
    for (index, array) in arrays.iter().enumerate() {
        let &[height, width] = array.dims.as_slice() else { continue };
        let (rows, size) = (height.saturating_mul(size_of::<Vec<f64>>()), array.len().saturating_mul(size_of::<f64>()));
        budget.hold("matrices", rows.saturating_add(size)).map_err(refuse)?;
        let values = container.values(index, &budget).map_err(|fault| refuse(fault.problem))?;
        let at = |i: usize, j: usize| if array.column_major { j * height + i } else { i * width + j };
        let row = |i: usize| (0..width).map(|j| values.get(at(i, j)).copied().unwrap_or(f64::NAN)).collect();
        matrices.push(Matrix { name: array.name.clone(), rows: (0..height).map(row).collect() });
    }
    Ok(matrices)
}

#[cfg(test)]
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
