//! Limits the content of one file: a compressed file can hold far more than it has bytes.

use std::cell::Cell;
use std::io::{self, Read};

use super::Limits;
use super::error::Problem;
use super::format::Format;

/// Bytes of content per byte of the largest file.
const CONTENT_PER_FILE: u64 = 2;

/// Includes the path.
const MAX_NAME_BYTES: usize = 1000;

pub(crate) const MAX_DIMENSIONS: usize = 32;

const MAX_DEPTH: usize = 32;

const MAX_TEXT_CHARACTERS: usize = 100;

/// Its description, its statistics, its row in a list.
const SIGNAL_BYTES: usize = 4096;

#[derive(Debug)]
pub(crate) struct Room {
    limits: Limits,
    left: Cell<u64>,
}

impl Room {
    pub(crate) fn new(limits: &Limits) -> Self {
        let left = Cell::new(limits.max_bytes.saturating_mul(CONTENT_PER_FILE));
        Self { limits: limits.clone(), left }
    }

    pub(crate) fn limits(&self) -> &Limits {
        &self.limits
    }

    fn full(&self) -> Problem {
        Problem::TooManyBytes { limit: self.limits.max_bytes.saturating_mul(CONTENT_PER_FILE) }
    }

    /// Checks that there is room for bytes that are not kept.
    pub(crate) fn check(&self, bytes: u64) -> Result<(), Problem> {
        if bytes <= self.left.get() { Ok(()) } else { Err(self.full()) }
    }

    pub(crate) fn take(&self, bytes: usize) -> Result<(), Problem> {
        self.left.set(self.left.get().checked_sub(bytes as u64).ok_or_else(|| self.full())?);
        Ok(())
    }

    pub(crate) fn take_values(&self, count: usize) -> Result<(), Problem> {
        self.take(count.saturating_mul(size_of::<f64>()))
    }

    pub(crate) fn take_signals(&self, name: &str, signals: usize) -> Result<(), Problem> {
        check_name(name.len())?;
        self.take(signals.saturating_mul(SIGNAL_BYTES + name.len()).max(name.len()))
    }

    /// A full room is a [`Problem`] inside the error; see [`recover`].
    pub(crate) fn read(&self, reader: impl Read) -> io::Result<Vec<u8>> {
        let mut bytes = vec![];
        reader.take(self.left.get().saturating_add(1)).read_to_end(&mut bytes)?;
        self.take(bytes.len()).map_err(io::Error::other)?;
        Ok(bytes)
    }
}

pub(crate) fn check_name(bytes: usize) -> Result<(), Problem> {
    check(bytes, MAX_NAME_BYTES, || format!("a name of {bytes} bytes with its path"))
}

pub(crate) fn check_depth(depth: usize) -> Result<(), Problem> {
    check(depth, MAX_DEPTH, || format!("parts within one another at depth {depth}"))
}

pub(crate) fn check_dimensions(count: usize) -> Result<(), Problem> {
    check(count, MAX_DIMENSIONS, || format!("an array of {count} dimensions"))
}

fn check(found: usize, limit: usize, part: impl FnOnce() -> String) -> Result<(), Problem> {
    if found <= limit { Ok(()) } else { Err(Problem::OverLimit { part: part().into(), limit }) }
}

pub(crate) fn recover(format: Format, error: io::Error) -> Problem {
    match error.downcast::<Problem>() {
        Ok(problem) => problem,
        Err(error) => format.damaged(error),
    }
}

/// Shortens a text about a signal, such as its unit, which many signals can repeat.
pub(crate) fn short(text: &str) -> String {
    text.chars().take(MAX_TEXT_CHARACTERS).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_names_depths_and_dimensions_are_bounded() {
        let room = Room::new(&Limits { max_bytes: 10_000, ..Limits::default() });
        assert_eq!(room.read(&[0; 4000][..]).expect("within").len(), 4000);
        room.take_values(1000).expect("within");
        room.take_signals("a", 1).expect("within");
        let refused = recover(Format::Npz, room.read(io::repeat(0)).expect_err("endless")).to_string();
        assert!(refused.starts_with("holds more than 0.0 MiB (20000 bytes)"), "{refused}");
        assert!(room.take_signals("a", 2).is_err());
        assert!(check_name(MAX_NAME_BYTES + 1).is_err());
        assert!(check_dimensions(MAX_DIMENSIONS + 1).is_err());
        assert!(check_depth(MAX_DEPTH + 1).is_err());
    }
}
