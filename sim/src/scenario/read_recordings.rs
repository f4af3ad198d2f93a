//! Recordings that were read, for further scenarios of the same files.

use std::sync::{Arc, Mutex, PoisonError};

use super::document::Source;
use crate::recording::{Columns, Limits, Recording};

/// Recordings that were read, by what they were read from.
#[derive(Debug, Clone, Default)]
pub(super) struct ReadRecordings(Arc<Mutex<Vec<(Source, Columns, Limits, Arc<Recording>)>>>);

impl ReadRecordings {
    /// A recording that was read before, or the one that is read now.
    pub(super) fn get_or_read<E>(
        &self,
        (source, columns, limits): (&Source, &Columns, &Limits),
        read: impl FnOnce() -> Result<Recording, E>,
    ) -> Result<Recording, E> {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((.., recording)) = all.iter().find(|(a, b, c, _)| (a, b, c) == (source, columns, limits)) {
            return Ok(Recording::clone(recording));
        }
        let recording = read()?;
        all.push((source.clone(), columns.clone(), limits.clone(), Arc::new(recording.clone())));
        Ok(recording)
    }
}
