//! A scenario's files, read once for several scenarios.

use super::document::{Entry, Source, below, of_files, of_settings};
use super::error::ScenarioError;
use super::read_recordings::ReadRecordings;
use super::resolve::Scenario;
use super::values::Values;

/// A scenario's file with its bases, and the recordings that its scenarios have read: a later change of these files does not
/// change its scenarios.
#[derive(Debug, Clone)]
pub struct Written {
    entries: Vec<Entry>,
    read: ReadRecordings,
}

impl Written {
    /// Reads a file and its bases.
    ///
    /// # Errors
    /// A file that cannot be read, is not TOML, or is based on itself.
    pub fn read(source: &Source) -> Result<Self, ScenarioError> {
        Ok(Self { entries: of_files(source)?, read: ReadRecordings::default() })
    }

    /// The scenario with lists of `section.key=value` settings, of which a later one overrides the earlier ones and may change
    /// their kinds. `source` is what was read.
    ///
    /// # Errors
    /// As [`Scenario::load`].
    pub fn scenario(&self, source: &Source, settings: &[&[String]]) -> Result<Scenario, ScenarioError> {
        let mut entries = of_settings(settings)?;
        entries.extend(below(settings, self.entries.clone()));
        Scenario::of_acting(Values::of_entries(source, entries)?.remembering(self.read.clone()))
    }
}
