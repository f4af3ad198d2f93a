//! Finds the table in a text: the longest block of lines of numbers, and the names above it.
//!
//! A line of numbers has at least two fields that are numbers or dates, or a single field that is one. Consecutive
//! lines of numbers with equally many fields are a block; blank lines and comments do not end it.

use std::io::{self, BufRead};

use super::stamp::is_date;
use super::units;

const ENOUGH_LINES: usize = 1000;

const MAX_BYTES: usize = 16 << 20;

/// In the order of preference. `None` stands for runs of spaces, which are last, because other separators may be
/// followed by spaces.
const SEPARATORS: [Option<u8>; 5] = [Some(b';'), Some(b'\t'), Some(b'|'), Some(b','), None];

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Table {
    pub(super) separator: Option<u8>,
    /// Number of lines above the names, or above the first row of a table without names.
    pub(super) lines_before: usize,
    pub(super) from: usize,
    /// `None` for a table with names.
    pub(super) unnamed: Option<usize>,
}

pub(super) fn beginning(text: &mut impl BufRead) -> io::Result<Vec<u8>> {
    let mut read = vec![];
    let mut runs = SEPARATORS.map(Run::new);
    loop {
        let from = read.len();
        if text.read_until(b'\n', &mut read)? == 0 {
            break;
        }
        if from == 0 && read.starts_with(b"\xef\xbb\xbf") {
            read.drain(..3);
        }
        let line = &read[from..];
        if !is_empty(line) {
            runs.iter_mut().for_each(|run| run.push(0, line));
        }
        if read.len() > MAX_BYTES || runs.iter().any(|run| run.current.lines >= ENOUGH_LINES) {
            break;
        }
    }
    Ok(read)
}

pub(super) fn table(text: &[u8]) -> Option<Table> {
    let mut lines: Vec<(usize, usize, &[u8])> = vec![];
    let mut from = 0;
    for (number, line) in text.split_inclusive(|byte| *byte == b'\n').enumerate() {
        if !is_empty(line) {
            lines.push((number, from, line));
        }
        from += line.len();
    }
    let mut runs = SEPARATORS.map(Run::new);
    for (index, (_, _, line)) in lines.iter().enumerate() {
        runs.iter_mut().for_each(|run| run.push(index, line));
    }
    // `max_by` returns the last of equal elements.
    let best = runs.iter().rev().max_by(|a, b| {
        let (a, b) = (&a.best, &b.best);
        a.lines.cmp(&b.lines).then(a.share().total_cmp(&b.share())).then(a.width.cmp(&b.width))
    })?;
    let Block { first, lines: count, width, .. } = best.best;
    if count == 0 {
        return None;
    }
    let has_names = |index: usize| {
        let named = fields(lines[index].2, best.separator);
        let row = fields(lines[first].2, best.separator);
        let is_wide = named.len() == width || without_blank_end(&named) == without_blank_end(&row);
        is_wide
            && named.iter().all(|field| !is_value(field, best.separator))
            && named.iter().any(|field| !field.is_empty())
    };
    let mut names = first.checked_sub(1).filter(|above| has_names(*above));
    let is_units =
        |index: &usize| fields(lines[*index].2, best.separator).iter().any(|field| units::is_known(&shown(field)));
    if names.filter(is_units).is_some() {
        names = names.and_then(|units| units.checked_sub(1)).filter(|above| has_names(*above)).or(names);
    }
    let is_text = |field: &&&[u8]| !field.is_empty() && !is_value(field, best.separator);
    let texts = |line: &[u8]| fields(line, best.separator).iter().filter(is_text).count();
    let place = |index: usize, unnamed| {
        let (lines_before, from, _) = lines[index];
        Some(Table { separator: best.separator, lines_before, from, unnamed })
    };
    match names {
        Some(0) => None,
        Some(names) => place(names, None),
        // Names on the first line belong to the block, even if a damaged row is between them.
        None if first > 0 && may_be_names(lines[0].2, best.separator, width) => None,
        // A name can be a number, as in `t,1,2`. A row below then has fewer texts.
        None if first == 0 && lines.get(1).is_some_and(|row| texts(lines[0].2) > texts(row.2)) => None,
        None => place(first, Some(width)),
    }
}

fn may_be_names(line: &[u8], separator: Option<u8>, width: usize) -> bool {
    let fields = fields(line, separator);
    let numbers = fields.iter().filter(|field| is_value(field, separator)).count();
    separator.is_some() && fields.len() > 1 && (numbers == 0 || fields.len() == width && numbers < width)
}

#[derive(Debug, Clone, Copy, Default)]
struct Block {
    first: usize,
    lines: usize,
    width: usize,
    values: usize,
}

impl Block {
    fn share(&self) -> f64 {
        self.values as f64 / (self.lines * self.width).max(1) as f64
    }
}

struct Run {
    separator: Option<u8>,
    current: Block,
    best: Block,
}

impl Run {
    fn new(separator: Option<u8>) -> Self {
        Self { separator, current: Block::default(), best: Block::default() }
    }

    fn push(&mut self, index: usize, line: &[u8]) {
        let fields = fields(line, self.separator);
        let values = fields.iter().filter(|field| is_value(field, self.separator)).count();
        if values < 2 && !(values == 1 && fields.len() == 1) {
            self.current = Block::default();
            return;
        }
        if self.current.width != fields.len() {
            self.current = Block { first: index, width: fields.len(), ..Block::default() };
        }
        self.current.lines += 1;
        self.current.values += values;
        if self.current.lines > self.best.lines {
            self.best = self.current;
        }
    }
}

fn is_empty(line: &[u8]) -> bool {
    let content = line.trim_ascii();
    content.starts_with(b"#") || content.starts_with(b"%") || content.iter().all(|byte| b",;\t ".contains(byte))
}

fn without_blank_end(fields: &[&[u8]]) -> usize {
    fields.iter().rposition(|field| !field.is_empty()).map_or(0, |last| last + 1)
}

fn fields(line: &[u8], separator: Option<u8>) -> Vec<&[u8]> {
    let line = line.trim_ascii_end();
    let mut quoted = false;
    let is_end = |byte: &u8| {
        quoted ^= *byte == b'"';
        !quoted && separator.map_or(byte.is_ascii_whitespace(), |separator| *byte == separator)
    };
    let fields = line.split(is_end).map(|field| {
        let field = field.trim_ascii();
        field.strip_prefix(b"\"").and_then(|rest| rest.strip_suffix(b"\"")).map_or(field, <[u8]>::trim_ascii)
    });
    fields.filter(|field| separator.is_some() || !field.is_empty()).collect()
}

fn shown(field: &[u8]) -> String {
    String::from_utf8_lossy(field).into_owned()
}

fn is_value(field: &[u8], separator: Option<u8>) -> bool {
    let Ok(text) = str::from_utf8(field) else { return false };
    let comma = separator != Some(b',') && text.contains(',');
    let number = if comma { text.replacen(',', ".", 1).parse::<f64>() } else { text.parse::<f64>() };
    number.is_ok() || is_date(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> Option<(usize, Option<u8>, Option<usize>)> {
        let table = table(text.as_bytes())?;
        assert_eq!(text[..table.from].lines().count(), table.lines_before, "{text}");
        Some((table.lines_before, table.separator, table.unnamed))
    }

    #[test]
    fn names_on_the_first_line_need_no_search() {
        for text in [
            "t,x,f\n0,1,2\n1,2,3\n",
            "t;x;f\ns;mm;N\n0;0,1;2,5\n",
            "t,x,f\n0,1,2\n1,abc,\n2,1,1\n3,1,1\n4,1,1\n",
            "t,x,f\n0,0,1,5,2,0\n",
            "t,1,2\n0,1,2\n1,1,2\n",
        ] {
            assert_eq!(found(text), None, "{text}");
        }
    }

    #[test]
    fn the_names_are_above_the_longest_block_of_numbers() {
        for (text, lines, separator) in [
            ("Test,\"1\"\nDate,2024-01-01,1\n\nt,x,f\n(s),(mm),(N)\n\"0\",\"1\",\"2\"\n\"1\",\"1\",\"2\"\n", 3, b','),
            ("Probe;1,5;2,5\nt;x;f\n0;0,1;2\n1;0,1;2\n2;0,1;2\n", 1, b';'),
            ("MTS793|BTW|ENU|1\nData\tTime:\t3,5\tSec\nt\tx\tf\nsec\tmm\tN\n0\t1\t2\n1\t1\t2\n", 2, b'\t'),
        ] {
            assert_eq!(found(text), Some((lines, Some(separator), None)), "{text}");
        }
    }

    #[test]
    fn a_table_without_names_has_numbered_columns() {
        assert_eq!(found("0,1,2\n1,1,2\n"), Some((0, Some(b','), Some(3))));
        assert_eq!(found("0 0,1 2,5\n1 0,2 2,5\n"), Some((0, None, Some(3))));
        assert_eq!(found("0;0,1;2,5\n1;0,2;2,5\n"), Some((0, Some(b';'), Some(3))));
        assert_eq!(found("a preamble\n\n0\t1\n1\t1\n"), Some((2, Some(b'\t'), Some(2))));
        assert_eq!(found("2024-01-01 10:00:00.5,1\n2024-01-01 10:00:01.5,1\n"), Some((0, Some(b','), Some(2))));
    }

    #[test]
    fn the_beginning_ends_after_enough_lines_of_numbers() {
        let text = format!("preamble\nt,x\n{}", "0,1\n".repeat(5000));
        let read = beginning(&mut text.as_bytes()).expect("text");
        assert_eq!(read.len(), 13 + 4 * ENOUGH_LINES);
        assert_eq!(beginning(&mut &b"\xef\xbb\xbft,x"[..]).expect("text"), b"t,x");
    }
}
