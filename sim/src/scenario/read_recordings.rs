//! Recordings that were read, for further scenarios of the same files.

use std::sync::{Arc, Mutex, PoisonError};

use super::document::Source;
use crate::recording::{Columns, Limits, Recording};

/// Recordings that were read.
#[derive(Debug, Clone, Default)]
pub(super) struct ReadRecordings(Arc<Mutex<Vec<ReadRecording>>>);

/// A recording, and what it was read from.
#[derive(Debug)]
struct ReadRecording {
    source: Source,
    columns: Columns,
    limits: Limits,
    recording: Recording,
}

impl ReadRecordings {
    /// A recording that was read before, or the one that is read now.
    pub(super) fn get_or_read<E>(
        &self,
        (source, columns, limits): (&Source, &Columns, &Limits),
        read: impl FnOnce() -> Result<Recording, E>,
    ) -> Result<Recording, E> {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let is_read = |one: &&ReadRecording| (&one.source, &one.columns, &one.limits) == (source, columns, limits);
        if let Some(found) = all.iter().find(is_read) {
            return Ok(found.recording.clone());
        }
        let recording = read()?;
        all.push(ReadRecording {
            source: source.clone(),
            columns: columns.clone(),
            limits: limits.clone(),
            recording: recording.clone(),
        });
        Ok(recording)
    }
}
