use std::fs::File;
use std::io::Read;

use super::{Container, json_lines, mat, name, open, read};
use crate::error::{Place, Problem};
use crate::room::Room;
use crate::{Columns, Format, Matrix, Recording, RecordingError, Signal};

pub(crate) struct ArrayFile(Box<dyn Container>);

impl ArrayFile {
    pub(crate) fn open(format: Format, file: File, room: &Room) -> Result<Self, Problem> {
        open(format, file, room).map(Self)
    }

    pub(crate) fn of_json_lines(file: &str, text: impl Read, room: &Room) -> Result<Self, RecordingError> {
        Ok(Self(Box::new(json_lines::open(file, text, room)?)))
    }

    pub(crate) fn of_matlab(bytes: Vec<u8>, room: &Room) -> Result<Self, Problem> {
        mat::open(bytes, room).map(Self)
    }

    pub(crate) fn recording(
        &mut self,
        file: &str,
        columns: &Columns,
        room: &Room,
    ) -> Result<Recording, RecordingError> {
        read::read(file, self.0.as_mut(), columns, room)
    }

    pub(crate) fn signals(&mut self, file: &str, room: &Room) -> Result<Vec<Signal>, RecordingError> {
        read::scan(file, self.0.as_mut(), room)
    }

    pub(crate) fn signal_names(&self) -> Vec<String> {
        name::vectors(self.0.arrays()).into_iter().map(|vector| vector.name).collect()
    }

    pub(crate) fn matrices(&mut self, file: &str, room: &Room) -> Result<Vec<Matrix>, RecordingError> {
        let refuse = |problem| Place::file(file).error(problem);
        let arrays = self.0.arrays().to_vec();
        let mut matrices = vec![];
        for (index, array) in arrays.iter().enumerate() {
            let &[height, width] = array.dims.as_slice() else { continue };
            room.take(height.saturating_mul(size_of::<Vec<f64>>())).map_err(refuse)?;
            room.take_values(array.len()).map_err(refuse)?;
            let values = self.0.values(index, room).map_err(|fault| refuse(fault.problem))?;
            let at = |i: usize, j: usize| if array.column_major { j * height + i } else { i * width + j };
            let row = |i: usize| (0..width).map(|j| values.get(at(i, j)).copied().unwrap_or(f64::NAN)).collect();
            matrices.push(Matrix { name: array.name.clone(), rows: (0..height).map(row).collect() });
        }
        Ok(matrices)
    }
}
