//! The compact protocol of Apache Thrift, in which Parquet files describe their content: fields with a number and a type.
//!
//! The library reads the descriptions. This reader checks them first: the library takes the stack and the memory that a
//! description asks for.

use super::bytes::{Cursor, Order};
use crate::budget::MAX_DEPTH;

/// A value of a field. A binary is borrowed; the parts of a structure or a list follow in the reader.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Kind {
    True,
    False,
    /// Whole numbers of 16, 32 or 64 bits.
    Integer,
    Byte,
    Double,
    Binary,
    List,
    Map,
    Struct,
}

impl Kind {
    fn parse(code: u8) -> Option<Self> {
        Some(match code {
            1 => Self::True,
            2 => Self::False,
            3 => Self::Byte,
            4..=6 => Self::Integer,
            7 => Self::Double,
            8 => Self::Binary,
            9 | 10 => Self::List,
            11 => Self::Map,
            12 => Self::Struct,
            _ => return None,
        })
    }
}

pub(super) struct Thrift<'a> {
    cursor: Cursor<'a>,
    /// Number of elements of all lists of structures and maps that were read or skipped.
    pub(super) elements: usize,
}

impl<'a> Thrift<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { cursor: Cursor::new(bytes, Order::Little), elements: 0 }
    }

    /// Number of bytes that are read.
    pub(super) fn at(&self) -> usize {
        self.cursor.at
    }

    fn byte(&mut self) -> Option<u8> {
        self.cursor.take(1)?.first().copied()
    }

    fn unsigned(&mut self) -> Option<u64> {
        let mut value = 0_u64;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                return Some(value);
            }
        }
        None
    }

    pub(super) fn integer(&mut self) -> Option<i64> {
        let value = self.unsigned()?;
        Some((value >> 1) as i64 ^ -((value & 1) as i64))
    }

    pub(super) fn binary(&mut self) -> Option<&'a [u8]> {
        let length = usize::try_from(self.unsigned()?).ok()?;
        self.cursor.take(length)
    }

    /// Reads the next field of a structure: `Some(None)` at its end. `last` is the number of the field before.
    pub(super) fn field(&mut self, last: &mut i64) -> Option<Option<(i64, Kind)>> {
        let head = self.byte()?;
        if head == 0 {
            return Some(None);
        }
        *last = if head >> 4 == 0 { self.integer()? } else { *last + i64::from(head >> 4) };
        Some(Some((*last, Kind::parse(head & 0xf)?)))
    }

    /// Reads the head of a list: the number of its elements, which each have at least one byte, and their type.
    pub(super) fn list(&mut self) -> Option<(usize, Kind)> {
        let head = self.byte()?;
        let count = match head >> 4 {
            15 => usize::try_from(self.unsigned()?).ok()?,
            count => usize::from(count),
        };
        let kind = Kind::parse(head & 0xf)?;
        if kind == Kind::Struct {
            self.elements = self.elements.saturating_add(count);
        }
        (count <= self.cursor.rest().len()).then_some((count, kind))
    }

    /// Skips a value. `depth` is the number of structures around it.
    pub(super) fn skip(&mut self, kind: Kind, depth: usize) -> Option<()> {
        if depth > MAX_DEPTH {
            return None;
        }
        match kind {
            Kind::True | Kind::False => {}
            Kind::Byte => drop(self.byte()?),
            Kind::Integer => drop(self.unsigned()?),
            Kind::Double => drop(self.cursor.take(8)?),
            Kind::Binary => drop(self.binary()?),
            Kind::List => {
                let (count, kind) = self.list()?;
                for _ in 0..count {
                    self.element(kind, depth)?;
                }
            }
            Kind::Map => {
                let count =
                    usize::try_from(self.unsigned()?).ok().filter(|count| *count <= self.cursor.rest().len())?;
                self.elements = self.elements.saturating_add(count);
                if count > 0 {
                    let kinds = self.byte()?;
                    let (key, value) = (Kind::parse(kinds >> 4)?, Kind::parse(kinds & 0xf)?);
                    for _ in 0..count {
                        self.element(key, depth)?;
                        self.element(value, depth)?;
                    }
                }
            }
            Kind::Struct => {
                let mut last = 0;
                while let Some((_, kind)) = self.field(&mut last)? {
                    self.skip(kind, depth + 1)?;
                }
            }
        }
        Some(())
    }

    /// Skips an element of a list, in which a Boolean has a byte.
    fn element(&mut self, kind: Kind, depth: usize) -> Option<()> {
        match kind {
            Kind::True | Kind::False => self.byte().map(drop),
            kind => self.skip(kind, depth + 1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_read_and_skipped() {
        // Field 1: the number -3. Field 3: two texts. Field 4: a structure with a flag. The end.
        let bytes = [0x15, 5, 0x29, 0x28, 1, b'a', 2, b'b', b'c', 0x1c, 0x11, 0, 0];
        let mut thrift = Thrift::new(&bytes);
        let mut last = 0;
        assert_eq!(thrift.field(&mut last), Some(Some((1, Kind::Integer))));
        assert_eq!(thrift.integer(), Some(-3));
        assert_eq!(thrift.field(&mut last), Some(Some((3, Kind::List))));
        assert_eq!(thrift.list(), Some((2, Kind::Binary)));
        assert_eq!((thrift.binary(), thrift.binary()), (Some(&b"a"[..]), Some(&b"bc"[..])));
        assert_eq!(thrift.field(&mut last), Some(Some((4, Kind::Struct))));
        assert_eq!(thrift.skip(Kind::Struct, 0), Some(()));
        assert_eq!((thrift.field(&mut last), thrift.at()), (Some(None), bytes.len()));
        let mut whole = Thrift::new(&bytes);
        assert_eq!((whole.skip(Kind::Struct, 0), whole.at()), (Some(()), bytes.len()));
        for cut in 0..bytes.len() {
            assert_eq!(Thrift::new(&bytes[..cut]).skip(Kind::Struct, 0), None, "{cut}");
        }
    }

    #[test]
    fn depth_and_lengths_are_bounded() {
        assert_eq!(Thrift::new(&[0x1c; 100_000]).skip(Kind::Struct, 0), None);
        // A list of 2^28 flags in six bytes.
        assert_eq!(Thrift::new(&[0xf1, 0xff, 0xff, 0xff, 0x7f, 0]).skip(Kind::List, 0), None);
    }
}
