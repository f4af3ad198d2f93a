use super::containers::ArrayFile;
use super::error::Place;
use super::room::Room;
use super::{Limits, RecordingError};

#[derive(Debug, Clone, PartialEq)]
pub struct Matrix {
    /// With the path inside a structure: `sys.A`.
    pub name: String,
    pub rows: Vec<Vec<f64>>,
}

pub fn read_matrices(file: &str, bytes: Vec<u8>, limits: &Limits) -> Result<Vec<Matrix>, RecordingError> {
    let room = Room::new(limits);
    let mut opened = ArrayFile::of_matlab(bytes, &room).map_err(|problem| Place::file(file).error(problem))?;
    opened.matrices(file, &room)
}

#[cfg(all(test, feature = "formats"))]
mod tests {
    use super::*;

    /// A file of one matrix: an element is its type, its size, and its content padded to 8 bytes.
    fn mat(name: &str, height: u32, values: &[f64]) -> Vec<u8> {
        let element = |kind: u32, content: &[u8]| {
            let padding = vec![0; content.len().next_multiple_of(8) - content.len()];
            [&kind.to_le_bytes()[..], &(content.len() as u32).to_le_bytes(), content, &padding].concat()
        };
        let mut bytes = [&b"MATLAB 5.0 MAT-file"[..], &[b' '; 105], &[0, 1], b"IM"].concat();
        let dims = [height, values.len() as u32 / height];
        let parts = [
            element(6, &[6, 0, 0, 0, 0, 0, 0, 0]),
            element(5, &dims.map(u32::to_le_bytes).concat()),
            element(1, name.as_bytes()),
            element(9, &values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>()),
        ];
        bytes.extend(element(14, &parts.concat()));
        bytes
    }

    #[test]
    fn a_matrix_is_read_row_by_row() {
        let bytes = mat("A", 2, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let found = read_matrices("a.mat", bytes, &Limits::default()).expect("read");
        let rows = vec![vec![1.0, 3.0, 5.0], vec![2.0, 4.0, 6.0]];
        assert_eq!(found, [Matrix { name: "A".into(), rows }]);
    }

    #[test]
    fn a_damaged_file_is_refused() {
        let mut bytes = mat("A", 2, &[1.0, 2.0, 3.0, 4.0]);
        bytes.truncate(bytes.len() - 8);
        assert!(read_matrices("a.mat", bytes, &Limits::default()).is_err());
    }
}
