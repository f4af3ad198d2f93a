//! Checks the footer of a Parquet file before the library reads it: the depth of its schema, which the library follows on
//! the stack, the paths of its columns, which repeat the names of their groups, and the size of its tables of contents.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};

use super::Format;
use super::thrift::{Kind, Thrift};
use crate::budget::Budget;
use crate::error::Problem;

/// The length of the footer and the signature at the end of the file.
const TAIL_BYTES: usize = 8;

/// Memory of the library in bytes per structure of the footer, and per byte.
const STRUCTURE_BYTES: usize = 512;
const BYTES_PER_BYTE: usize = 4;

const PART: &str = "tables of contents";

/// Checks the footer. A file without one is left to the library, which reports it.
pub(super) fn check(file: &mut File, budget: &Budget) -> Result<(), Problem> {
    let Some(footer) = footer(file, budget)? else { return Ok(()) };
    budget.hold(PART, footer.len().saturating_mul(BYTES_PER_BYTE))?;
    let mut thrift = Thrift::new(&footer);
    let walked = walk(&mut thrift, budget)?;
    budget.hold(PART, thrift.elements.saturating_mul(STRUCTURE_BYTES))?;
    walked.ok_or_else(|| Format::Parquet.damaged("its footer contradicts itself, or is nested too deeply"))
}

fn footer(file: &mut File, budget: &Budget) -> Result<Option<Vec<u8>>, Problem> {
    let size = file.metadata().map_err(Problem::Unreadable)?.len();
    let Some(tail_at) = size.checked_sub(TAIL_BYTES as u64) else { return Ok(None) };
    let tail = read(file, tail_at, TAIL_BYTES)?;
    let Some(length) = tail.first_chunk().map(|length| u32::from_le_bytes(*length)) else { return Ok(None) };
    let Some(from) = tail_at.checked_sub(u64::from(length)) else { return Ok(None) };
    budget.work(PART, length as usize)?;
    read(file, from, length as usize).map(Some)
}

/// Reads a part of the file, and returns to its beginning.
pub(super) fn read(file: &mut File, from: u64, length: usize) -> Result<Vec<u8>, Problem> {
    let mut bytes = vec![];
    let mut part = || {
        file.seek(SeekFrom::Start(from))?;
        file.by_ref().take(length as u64).read_to_end(&mut bytes)?;
        file.seek(SeekFrom::Start(0))
    };
    part().map_err(Problem::Unreadable)?;
    Ok(bytes)
}

/// Reads all fields of the footer; `None` if it is damaged.
fn walk(thrift: &mut Thrift<'_>, budget: &Budget) -> Result<Option<()>, Problem> {
    const SCHEMA: i64 = 2;
    let mut last = 0;
    loop {
        let read = match thrift.field(&mut last) {
            None => None,
            Some(None) => return Ok(Some(())),
            Some(Some((SCHEMA, Kind::List))) => schema(thrift, budget)?,
            Some(Some((_, kind))) => thrift.skip(kind, 0),
        };
        if read.is_none() {
            return Ok(None);
        }
    }
}

/// A group whose columns follow: how many of them, and the length of its path.
struct Group {
    columns_left: usize,
    path_bytes: usize,
}

/// Reads the schema: a list of groups and columns, in which a group states the number of its columns.
fn schema(thrift: &mut Thrift<'_>, budget: &Budget) -> Result<Option<()>, Problem> {
    let Some((count, Kind::Struct)) = thrift.list() else { return Ok(None) };
    let mut groups: Vec<Group> = vec![];
    for index in 0..count {
        let Some((name_bytes, columns)) = element(thrift) else { return Ok(None) };
        while groups.last().is_some_and(|group| group.columns_left == 0) {
            groups.pop();
        }
        // The root has no part in the paths.
        let path_bytes = groups.last().map_or(0, |group| group.path_bytes + 1 + name_bytes);
        budget.check_name(path_bytes)?;
        if columns > count - index - 1 || index > 0 && groups.is_empty() {
            return Ok(None);
        }
        if let Some(group) = groups.last_mut() {
            group.columns_left -= 1;
        }
        if columns > 0 {
            groups.push(Group { columns_left: columns, path_bytes });
            budget.check_depth(groups.len())?;
        } else {
            // A column holds the names of its path apart.
            budget.hold(PART, 2 * path_bytes + size_of::<String>() * groups.len())?;
        }
    }
    Ok(Some(()))
}

/// Reads an element of the schema: the length of its name and the number of its columns.
fn element(thrift: &mut Thrift<'_>) -> Option<(usize, usize)> {
    const NAME: i64 = 4;
    const COLUMNS: i64 = 5;
    let (mut name_bytes, mut columns) = (0, 0);
    let mut last = 0;
    while let Some((field, kind)) = thrift.field(&mut last)? {
        match (field, kind) {
            (NAME, Kind::Binary) => name_bytes = thrift.binary()?.len(),
            (COLUMNS, Kind::Integer) => columns = usize::try_from(thrift.integer()?).ok()?,
            (_, kind) => thrift.skip(kind, 1)?,
        }
    }
    Some((name_bytes, columns))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Limits;

    /// A footer whose schema has the given names with the number of their columns.
    fn footer(elements: &[(&str, u8)]) -> Vec<u8> {
        let mut bytes = vec![0x29, 0xfc, u8::try_from(elements.len()).expect("few")];
        for (name, columns) in elements {
            bytes.extend([0x48, u8::try_from(name.len()).expect("short")]);
            bytes.extend(name.bytes());
            bytes.extend([0x15, 2 * columns, 0]);
        }
        bytes.push(0);
        bytes
    }

    fn checked(elements: &[(&str, u8)]) -> Result<Option<()>, Problem> {
        walk(&mut Thrift::new(&footer(elements)), &Budget::new(&Limits::default()))
    }

    #[test]
    fn the_depth_of_the_schema_and_its_paths_are_bounded() {
        assert_eq!(checked(&[("root", 2), ("group", 1), ("x", 0), ("y", 0)]).expect("good"), Some(()));
        assert_eq!(checked(&[("root", 2), ("x", 0)]).expect("more columns than elements"), None);
        assert_eq!(checked(&[("root", 1), ("x", 0), ("y", 0)]).expect("an element too many"), None);
        let deep: Vec<_> = std::iter::repeat_n(("g", 1), 100).chain([("x", 0)]).collect();
        assert!(checked(&deep).expect_err("too deep").to_string().contains("depth 33"));
        let long = "n".repeat(50);
        let long: Vec<_> = std::iter::repeat_n((long.as_str(), 1), 25).chain([("x", 0)]).collect();
        assert!(checked(&long).expect_err("too long").to_string().contains("a name of"));
    }
}
