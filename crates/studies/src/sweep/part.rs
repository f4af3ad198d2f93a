//! The stored results of the cases. Every pack has a slot with a checksum over its content, its number and the sweep's
//! hash, so an interruption loses only the packs in progress.

use std::fs::{File, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::error::SweepError;

pub const PACK_CASES: u64 = 8;

const BLOCK_PACKS: u64 = 1024;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    Completed,
    Diverged,
    Failed,
}

impl Outcome {
    /// A sweep does not detect sustained oscillations.
    pub fn of(outcome: trocar_metrics::Outcome) -> Self {
        match outcome {
            trocar_metrics::Outcome::Completed | trocar_metrics::Outcome::Oscillating { .. } => Self::Completed,
            trocar_metrics::Outcome::Diverged { .. } => Self::Diverged,
        }
    }

    pub fn word(self) -> &'static str {
        match self {
            Self::Completed => "completed",
            Self::Diverged => "diverged",
            Self::Failed => "failed",
        }
    }

    fn code(self) -> f64 {
        match self {
            Self::Completed => 0.0,
            Self::Diverged => 1.0,
            Self::Failed => 2.0,
        }
    }

    fn of_code(code: f64) -> Self {
        match code {
            0.0 => Self::Completed,
            1.0 => Self::Diverged,
            _ => Self::Failed,
        }
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    pub key: u64,
    pub columns: usize,
    pub cases: u64,
    pub packs: Range<u64>,
}

impl Layout {
    /// The last pack may have fewer than eight.
    pub fn cases_of(&self, pack: u64) -> Range<u64> {
        let first = pack * PACK_CASES;
        first.min(self.cases)..(first + PACK_CASES).min(self.cases)
    }

    pub fn part_cases(&self) -> u64 {
        self.cases.min(self.packs.end * PACK_CASES) - self.cases.min(self.packs.start * PACK_CASES)
    }

    fn slot_words(&self, cases: u64) -> usize {
        1 + cases as usize * (1 + self.columns)
    }

    fn slot_bytes(&self) -> u64 {
        8 * self.slot_words(PACK_CASES) as u64
    }

    fn offset(&self, pack: u64) -> u64 {
        (pack - self.packs.start) * self.slot_bytes()
    }

    fn checksum(&self, pack: u64, words: &[u64]) -> u64 {
        let start = super::permutation::mix(self.key ^ pack.rotate_left(32));
        words.iter().fold(start, |sum, word| {
            let mixed = (sum ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            mixed ^ (mixed >> 29)
        })
    }

    fn is_intact(&self, pack: u64, slot: &[u64]) -> bool {
        let cases = self.cases_of(pack);
        slot.len() >= self.slot_words(cases.end - cases.start)
            && slot[0] == self.checksum(pack, &slot[1..self.slot_words(cases.end - cases.start)])
    }
}

#[derive(Debug, Default)]
pub struct PackRows(Vec<u64>);

impl PackRows {
    pub fn clear(&mut self) {
        self.0.clear();
        self.0.push(0);
    }

    /// `None` is stored as NaN.
    pub fn push(&mut self, outcome: Outcome, values: impl Iterator<Item = Option<f64>>) {
        self.0.push(outcome.code().to_bits());
        self.0.extend(values.map(|value| value.unwrap_or(f64::NAN).to_bits()));
    }
}

#[derive(Debug)]
pub struct Part {
    path: PathBuf,
    layout: Layout,
    file: Mutex<File>,
}

impl Part {
    /// Locks it until it is dropped.
    pub fn open(path: &Path, layout: Layout) -> Result<Self, SweepError> {
        let file = File::options().read(true).write(true).create(true).truncate(false).open(path);
        let part = Self::with(path, layout, file)?;
        let locked = part.file.lock().unwrap_or_else(PoisonError::into_inner).try_lock();
        match locked {
            Err(TryLockError::WouldBlock) => Err(SweepError::Busy { path: path.to_owned() }),
            // File systems without locks, such as some network drives, are not protected.
            Ok(()) | Err(TryLockError::Error(_)) => Ok(part),
        }
    }

    pub fn open_existing(path: &Path, layout: Layout) -> Result<Self, SweepError> {
        Self::with(path, layout, File::open(path))
    }

    fn with(path: &Path, layout: Layout, file: io::Result<File>) -> Result<Self, SweepError> {
        let path = path.to_owned();
        match file {
            Ok(file) => Ok(Self { path, layout, file: Mutex::new(file) }),
            Err(source) => Err(SweepError::Io { path, source }),
        }
    }

    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    fn failed(&self, source: io::Error) -> SweepError {
        SweepError::Io { path: self.path.clone(), source }
    }

    /// After an error, the pack counts as missing.
    pub fn write(&self, pack: u64, rows: &mut PackRows) -> Result<(), SweepError> {
        if let Some((sum, words)) = rows.0.split_first_mut() {
            *sum = self.layout.checksum(pack, words);
        }
        let bytes: Vec<u8> = rows.0.iter().flat_map(|word| word.to_le_bytes()).collect();
        let write = || {
            let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
            file.seek(SeekFrom::Start(self.layout.offset(pack)))?;
            file.write_all(&bytes)
        };
        write().map_err(|error| self.failed(error))
    }

    pub fn has(&self, pack: u64) -> Result<bool, SweepError> {
        let mut slots = vec![];
        self.read(pack..pack + 1, &mut slots)?;
        Ok(self.layout.is_intact(pack, &slots))
    }

    fn read(&self, packs: Range<u64>, words: &mut Vec<u64>) -> Result<(), SweepError> {
        let mut bytes = vec![];
        let mut read = || {
            let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
            file.seek(SeekFrom::Start(self.layout.offset(packs.start)))?;
            Read::by_ref(&mut *file).take((packs.end - packs.start) * self.layout.slot_bytes()).read_to_end(&mut bytes)
        };
        read().map_err(|error| self.failed(error))?;
        words.clear();
        words
            .extend(bytes.chunks_exact(8).map(|bytes| bytes.iter().rev().fold(0, |word, b| word << 8 | u64::from(*b))));
        Ok(())
    }

    fn scan(&self, mut each: impl FnMut(u64, Option<&[u64]>) -> Result<(), SweepError>) -> Result<(), SweepError> {
        let Range { start, end } = self.layout.packs;
        let slot_words = self.layout.slot_words(PACK_CASES);
        let (mut words, mut next) = (vec![], start);
        while next < end {
            let block = next..end.min(next + BLOCK_PACKS);
            self.read(block.clone(), &mut words)?;
            for pack in block.clone() {
                let from = ((pack - block.start) as usize * slot_words).min(words.len());
                let slot = &words[from..(from + slot_words).min(words.len())];
                each(pack, self.layout.is_intact(pack, slot).then_some(slot))?;
            }
            next = block.end;
        }
        Ok(())
    }

    pub fn cases_done(&self) -> Result<u64, SweepError> {
        let mut done = 0;
        self.scan(|pack, slot| {
            let cases = self.layout.cases_of(pack);
            done += if slot.is_some() { cases.end - cases.start } else { 0 };
            Ok(())
        })?;
        Ok(done)
    }
}

/// Ordered parts of a whole sweep.
#[derive(Debug)]
pub struct Rows(pub Vec<Part>);

impl Rows {
    /// Undefined values are NaN.
    pub fn each(&self, mut each: impl FnMut(u64, Outcome, &[f64]) -> Result<(), SweepError>) -> Result<(), SweepError> {
        let mut values = vec![];
        for part in &self.0 {
            part.scan(|pack, slot| {
                let cases = part.layout.cases_of(pack);
                let Some(slot) = slot else {
                    let (path, first, last) = (part.path.display(), cases.start, cases.end.saturating_sub(1));
                    return Err(SweepError::Parts {
                        message: format!("{path}: the cases {first} to {last} are missing"),
                    });
                };
                for (case, row) in cases.zip(slot[1..].chunks(1 + part.layout.columns)) {
                    values.clear();
                    values.extend(row[1..].iter().map(|bits| f64::from_bits(*bits)));
                    each(case, Outcome::of_code(f64::from_bits(row[0])), &values)?;
                }
                Ok(())
            })?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(folder: &Path) -> Part {
        let layout = Layout { key: 7, columns: 2, cases: 21, packs: 0..3 };
        Part::open(&folder.join("cases.part"), layout).expect("open")
    }

    fn write(part: &Part, pack: u64) {
        let mut rows = PackRows::default();
        rows.clear();
        for case in part.layout().cases_of(pack) {
            rows.push(Outcome::Completed, [Some(case as f64), None].into_iter());
        }
        part.write(pack, &mut rows).expect("written");
    }

    #[test]
    fn packs_are_read_in_order_for_any_order_of_writing() {
        let folder = tempfile::tempdir().expect("a folder");
        let part = part(folder.path());
        for pack in [2, 0] {
            write(&part, pack);
        }
        assert_eq!(part.cases_done().expect("read"), 13);
        assert_eq!([0, 1, 2].map(|pack| part.has(pack).expect("read")), [true, false, true]);
        let rows = Rows(vec![part]);
        assert!(matches!(rows.each(|_, _, _| Ok(())), Err(SweepError::Parts { .. })));
        write(&rows.0[0], 1);
        let mut cases = vec![];
        rows.each(|case, outcome, values| {
            assert!(outcome == Outcome::Completed && values[0] == case as f64 && values[1].is_nan());
            cases.push(case);
            Ok(())
        })
        .expect("whole");
        assert_eq!(cases, (0..21).collect::<Vec<_>>());
    }

    #[test]
    fn a_torn_or_changed_slot_is_rejected() {
        let folder = tempfile::tempdir().expect("a folder");
        let part = part(folder.path());
        (0..3).for_each(|pack| write(&part, pack));
        let bytes = std::fs::read(part.path()).expect("read");
        let slot = part.layout().slot_bytes() as usize;
        for at in [0, 9, slot - 1, slot, 2 * slot + 3, bytes.len() - 1] {
            let mut torn = bytes.clone();
            torn[at] ^= 0x10;
            std::fs::write(part.path(), &torn).expect("written");
            let intact = [0, 1, 2].map(|pack| part.has(pack).expect("read"));
            assert_eq!(intact.iter().filter(|intact| **intact).count(), 2, "{at}");
            assert!(!intact[at / slot], "{at}");
        }
        for length in [0, 5, slot, slot + 40, bytes.len() - 1] {
            std::fs::write(part.path(), &bytes[..length]).expect("written");
            let done = (0..3).filter(|pack| part.has(*pack).expect("read")).count();
            assert_eq!(done, length / slot, "{length}");
        }
        std::fs::write(part.path(), &bytes).expect("written");
        let other = Layout { key: 8, ..part.layout().clone() };
        assert_eq!(Part::open_existing(part.path(), other).expect("open").cases_done().expect("read"), 0);
    }
}
