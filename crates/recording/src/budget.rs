//! The budget of one file: how much memory and work its reading may take.
//!
//! Every reader of a container charges it as the data arrive, before it asks for memory. A file is then refused after
//! bounded time and memory, however its content multiplies: by compression, by long names that many signals repeat, by
//! lists that refer to the same bytes again and again.

use std::io::{self, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use super::Limits;
use super::error::Problem;
use super::format::Format;

/// Work in bytes per byte of memory. Values that are read one after the other need memory only once.
const WORK_PER_MEMORY: u64 = 2;

/// Maximum number of bytes of the name of a signal, with the path to it.
pub(crate) const MAX_NAME_BYTES: usize = 1000;

/// Maximum number of dimensions of an array.
pub(crate) const MAX_DIMENSIONS: usize = 32;

/// Maximum depth of structures within one another.
pub(crate) const MAX_DEPTH: usize = 32;

/// Maximum number of characters of a text about a signal: its label or its unit.
const MAX_TEXT_CHARACTERS: usize = 100;

/// Memory of a signal in bytes, besides its name and its samples: its description, its statistics, its row in a list.
const SIGNAL_BYTES: usize = 4096;

/// Memory of an array without signals, such as a single number.
const ARRAY_BYTES: usize = 512;

/// Number of copies of a name: in the array, in the signal, in its description and in a list.
const COPIES: usize = 4;

/// What is left of the memory and the work that a file may take. Copies share it.
#[derive(Debug, Clone)]
pub(crate) struct Budget {
    limits: Arc<Limits>,
    left: Arc<Left>,
}

/// Bytes that are left.
#[derive(Debug)]
struct Left {
    memory: AtomicU64,
    work: AtomicU64,
}

impl Budget {
    pub(crate) fn new(limits: &Limits) -> Self {
        let memory = limits.max_memory_bytes;
        let work = memory.saturating_mul(WORK_PER_MEMORY);
        let left = Left { memory: AtomicU64::new(memory), work: AtomicU64::new(work) };
        Self { limits: Arc::new(limits.clone()), left: Arc::new(left) }
    }

    pub(crate) fn limits(&self) -> &Limits {
        &self.limits
    }

    fn over(&self, part: &'static str) -> Problem {
        Problem::OverBudget { part, limit: self.limits.max_memory_bytes }
    }

    /// Charges memory that stays in use until the file is closed, or until [`Budget::release`]. `part` names its content
    /// in the message.
    pub(crate) fn hold(&self, part: &'static str, bytes: usize) -> Result<(), Problem> {
        self.take(&self.left.memory, part, bytes)
    }

    /// Returns memory that is no longer in use.
    pub(crate) fn release(&self, bytes: usize) {
        let sum = self.left.memory.load(Relaxed).saturating_add(bytes as u64);
        self.left.memory.store(sum.min(self.limits.max_memory_bytes), Relaxed);
    }

    /// Charges work, in bytes that are read or written.
    pub(crate) fn work(&self, part: &'static str, bytes: usize) -> Result<(), Problem> {
        self.take(&self.left.work, part, bytes)
    }

    fn take(&self, of: &AtomicU64, part: &'static str, bytes: usize) -> Result<(), Problem> {
        let left = of.load(Relaxed).checked_sub(bytes as u64).ok_or_else(|| self.over(part))?;
        of.store(left, Relaxed);
        Ok(())
    }

    /// Checks that the values of an array fit in the memory that is left, and charges the work of reading them.
    pub(crate) fn values(&self, count: usize) -> Result<(), Problem> {
        const PART: &str = "values";
        let bytes = count.saturating_mul(size_of::<f64>());
        if bytes as u64 > self.left.memory.load(Relaxed) {
            return Err(self.over(PART));
        }
        self.work(PART, bytes)
    }

    /// Charges `count` values that are kept.
    pub(crate) fn keep_values(&self, count: usize) -> Result<(), Problem> {
        self.hold("values", count.saturating_mul(size_of::<f64>()))
    }

    /// Checks the length of a name before it is copied.
    pub(crate) fn check_name(&self, bytes: usize) -> Result<(), Problem> {
        check_name(bytes)
    }

    /// Checks the depth of a structure before its parts are read.
    pub(crate) fn check_depth(&self, depth: usize) -> Result<(), Problem> {
        check(depth, MAX_DEPTH, || format!("parts within one another at depth {depth}"))
    }

    /// Charges `count` signals with names of `name_bytes`.
    pub(crate) fn signals(&self, count: usize, name_bytes: usize) -> Result<(), Problem> {
        self.hold("signals and their names", count.saturating_mul(SIGNAL_BYTES + COPIES * name_bytes))
    }

    /// Charges an array of which `signals` are listed.
    pub(crate) fn charge_array(&self, name: &str, dims: &[usize], signals: usize) -> Result<(), Problem> {
        self.check_name(name.len())?;
        check(dims.len(), MAX_DIMENSIONS, || format!("an array of {} dimensions", dims.len()))?;
        match signals {
            0 => self.hold("signals and their names", ARRAY_BYTES + COPIES * name.len()),
            count => self.signals(count, name.len()),
        }
    }

    /// Reads everything, and charges it as it arrives. A problem of the budget is in the error; see [`recover`].
    pub(crate) fn read(&self, mut reader: impl Read) -> io::Result<Vec<u8>> {
        const PART: &str = "decompressed content";
        const CHUNK_BYTES: usize = 64 << 10;
        let left = self.left();
        let mut bytes = vec![];
        let mut chunk = vec![0; CHUNK_BYTES];
        loop {
            let count = match reader.read(&mut chunk) {
                Ok(0) => break,
                Ok(count) => count,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(error) => return Err(error),
            };
            let room = left - bytes.len();
            if count > room {
                return Err(io::Error::other(self.over(PART)));
            }
            // A vector that grows by itself could take twice the memory.
            if bytes.capacity() - bytes.len() < count {
                bytes.reserve_exact(bytes.len().max(count).min(room));
            }
            bytes.extend_from_slice(&chunk[..count]);
        }
        self.hold(PART, bytes.len()).and_then(|()| self.work(PART, bytes.len())).map_err(io::Error::other)?;
        Ok(bytes)
    }

    fn least(&self) -> u64 {
        self.left.memory.load(Relaxed).min(self.left.work.load(Relaxed))
    }

    /// The bytes that may still be read into memory.
    pub(crate) fn left(&self) -> usize {
        usize::try_from(self.least()).unwrap_or(usize::MAX)
    }
}

/// Checks the length of a name.
pub(crate) fn check_name(bytes: usize) -> Result<(), Problem> {
    check(bytes, MAX_NAME_BYTES, || format!("a name of {bytes} bytes with its path"))
}

/// Checks a number that no option raises.
fn check(found: usize, limit: usize, part: impl FnOnce() -> String) -> Result<(), Problem> {
    if found <= limit { Ok(()) } else { Err(Problem::OverLimit { part: part().into(), limit }) }
}

/// Extracts the problem of a budget from an error of reading, or returns that of a damaged file.
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

    fn budget(max_memory_bytes: u64) -> Budget {
        Budget::new(&Limits { max_memory_bytes, ..Limits::default() })
    }

    #[test]
    fn memory_is_charged_until_it_is_released() {
        let budget = budget(100);
        budget.hold("values", 60).expect("within");
        let refused = budget.hold("cells", 41).expect_err("beyond").to_string();
        assert!(refused.contains("cells") && refused.contains("--max-memory"), "{refused}");
        budget.release(60);
        budget.hold("values", 100).expect("released");
    }

    #[test]
    fn work_is_charged_for_good() {
        let budget = budget(100);
        for _ in 0..2 {
            budget.values(12).expect("within");
            assert_eq!(budget.read(&[0; 4][..]).expect("within").len(), 4);
        }
        assert!(budget.read(io::repeat(0)).is_err());
        assert!(budget.values(1).is_err());
    }

    #[test]
    fn names_depths_and_dimensions_are_bounded() {
        let budget = budget(1 << 20);
        assert!(budget.charge_array(&"a".repeat(MAX_NAME_BYTES + 1), &[2], 1).is_err());
        assert!(budget.charge_array("a", &[1; MAX_DIMENSIONS + 1], 0).is_err());
        assert!(budget.check_depth(MAX_DEPTH + 1).is_err());
        assert!((0..1000).any(|_| budget.charge_array("a", &[2], 1).is_err()));
    }
}
