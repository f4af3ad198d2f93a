//! Reads samples from a growing table, line by line.

use super::error::{Place, Problem};
use super::header::{Layout, names, separator};
use super::number::number;
use super::{Columns, Limits, RecordingError};

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiveSample {
    pub time_s: f64,
    pub position_m: f64,
    /// Velocity of the needle in m/s; 0 without a column for it.
    pub velocity_m_per_s: f64,
    pub force_n: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LiveLine {
    /// No sample: a blank line, a comment, or the header.
    Nothing,
    Sample(LiveSample),
}

/// As for [`read_csv`](super::read_csv), but a quoted field ends on its line. Only one line is stored, at most
/// [`Limits::MAX_LINE_BYTES`]. The order of the times is not checked.
#[derive(Debug)]
pub struct LiveTable {
    source: Box<str>,
    columns: Columns,
    layout: Option<(u8, Layout)>,
    line: u64,
    open: Vec<u8>,
    is_too_long: bool,
    after_return: bool,
    fields: Vec<(usize, usize)>,
}

impl LiveTable {
    pub fn new(source: &str, columns: Columns) -> Self {
        Self {
            source: source.into(),
            columns,
            layout: None,
            line: 0,
            open: vec![],
            is_too_long: false,
            after_return: false,
            fields: vec![],
        }
    }

    pub fn has_header(&self) -> bool {
        self.layout.is_some()
    }

    pub fn lines(&self) -> u64 {
        self.line
    }

    /// `None` if the rest is an incomplete line.
    pub fn next(&mut self, bytes: &mut &[u8]) -> Option<Result<LiveLine, RecordingError>> {
        if self.after_return {
            let &first = bytes.first()?;
            self.after_return = false;
            if first == b'\n' {
                *bytes = &bytes[1..];
            }
        }
        let Some(end) = bytes.iter().position(|&byte| byte == b'\n' || byte == b'\r') else {
            self.keep(bytes);
            *bytes = &[];
            return None;
        };
        self.after_return = bytes[end] == b'\r';
        let rest = &bytes[end + 1..];
        let line = if self.open.is_empty() && !self.is_too_long {
            let whole = &bytes[..end];
            self.line(whole)
        } else {
            self.keep(&bytes[..end]);
            self.end()
        };
        *bytes = rest;
        Some(line)
    }

    pub fn finish(&mut self) -> Option<Result<LiveLine, RecordingError>> {
        if self.open.is_empty() && !self.is_too_long { None } else { Some(self.end()) }
    }

    fn keep(&mut self, bytes: &[u8]) {
        self.is_too_long |= (self.open.len() + bytes.len()) as u64 > Limits::MAX_LINE_BYTES;
        if self.is_too_long {
            self.open.clear();
        } else {
            self.open.extend_from_slice(bytes);
        }
    }

    fn end(&mut self) -> Result<LiveLine, RecordingError> {
        if std::mem::take(&mut self.is_too_long) {
            self.line += 1;
            return Err(self.place().error(Problem::LineTooLong));
        }
        let mut whole = std::mem::take(&mut self.open);
        let line = self.line(&whole);
        whole.clear();
        self.open = whole;
        line
    }

    fn line(&mut self, line: &[u8]) -> Result<LiveLine, RecordingError> {
        self.line += 1;
        let line = if self.line == 1 { line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line) } else { line };
        let content = line.trim_ascii_start();
        if content.is_empty() || content.starts_with(b"#") {
            return Ok(LiveLine::Nothing);
        }
        let Some((separator, layout)) = &self.layout else {
            self.layout = Some(self.header(line)?);
            return Ok(LiveLine::Nothing);
        };
        split(line, *separator, &mut self.fields);
        let field = |index: usize| self.fields.get(index).map_or(&[][..], |&(from, to)| &line[from..to]);
        if (0..self.fields.len()).all(|index| field(index).trim_ascii().is_empty()) {
            return Ok(LiveLine::Nothing);
        }
        let (found, expected) = (self.fields.len(), layout.width);
        if found < expected || (expected..found).any(|index| !field(index).trim_ascii().is_empty()) {
            return Err(self.place().error(Problem::RaggedRow { found, expected }));
        }
        let read = |index: usize, column: &super::Column, limit: f64| {
            let value = number(field(index), column.scale()).and_then(|value| {
                let value = column.shift(value);
                if value.abs() <= limit { Ok(value) } else { Err(Problem::TooGreat { value, limit }) }
            });
            value.map_err(|problem| self.place().in_column(column.name()).error(problem))
        };
        let velocity = layout.velocity.zip(self.columns.velocity.as_ref());
        Ok(LiveLine::Sample(LiveSample {
            time_s: layout.time.map_or(Ok(0.0), |index| read(index, &self.columns.time, f64::INFINITY))?,
            position_m: read(layout.position, &self.columns.position, Limits::MAX_MAGNITUDE)?,
            velocity_m_per_s: velocity.map_or(Ok(0.0), |(index, column)| read(index, column, Limits::MAX_MAGNITUDE))?,
            force_n: read(layout.force, &self.columns.force, Limits::MAX_MAGNITUDE)?,
        }))
    }

    fn header(&self, line: &[u8]) -> Result<(u8, Layout), RecordingError> {
        let separator = separator(line);
        let mut fields = vec![];
        split(line, separator, &mut fields);
        let names = names(fields.iter().map(|&(from, to)| &line[from..to]));
        let layout = names.and_then(|names| Layout::locate(&names, &self.columns, false));
        layout.map(|layout| (separator, layout)).map_err(|problem| self.place().error(problem))
    }

    fn place(&self) -> Place {
        Place::file(&self.source).at_line(self.line)
    }
}

fn split(line: &[u8], separator: u8, fields: &mut Vec<(usize, usize)>) {
    fields.clear();
    let (mut from, mut quoted) = (0, false);
    for (at, &byte) in line.iter().enumerate() {
        quoted ^= byte == b'"';
        if byte == separator && !quoted {
            fields.push((from, at));
            from = at + 1;
        }
    }
    fields.push((from, line.len()));
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::columns;
    use super::super::read_csv;
    use super::*;
    use proptest::prelude::*;

    /// All samples and errors of a text, read in chunks of `step` bytes.
    fn through(text: &[u8], step: usize) -> (Vec<[f64; 3]>, Vec<String>) {
        let mut table = LiveTable::new("rig", columns());
        let (mut samples, mut refusals) = (vec![], vec![]);
        let mut take = |line: Result<LiveLine, RecordingError>| match line {
            Ok(LiveLine::Nothing) => {}
            Ok(LiveLine::Sample(s)) => samples.push([s.time_s, s.position_m, s.force_n]),
            Err(error) => refusals.push(error.to_string()),
        };
        for mut chunk in text.chunks(step) {
            while let Some(line) = table.next(&mut chunk) {
                take(line);
            }
        }
        if let Some(line) = table.finish() {
            take(line);
        }
        (samples, refusals)
    }

    #[test]
    fn tables_of_any_form_are_read_in_chunks_of_any_size() {
        let plain = vec![[0.0, 1.0, 2.0], [1.0, -3.0, 4e-3]];
        for table in [
            "t,x,f\n0,1,2\n1,-3,4e-3\n",
            "t;x;f\n0;1;2\n1;-3;4e-3",
            "\u{feff}t,x,f\r\n0,1,2\r\n1,-3,4e-3\r\n\r\n",
            "t,x,f\r0,1,2\r1,-3,4e-3\r",
            "# by hand\n\n  # twice\nt,x,f\n0,1,2\n# pause\n1,-3,4e-3\n   \n,,\n",
            " \"t\" , x,f \n +0.0 , 1.,\"2\"\n\t1 ,-3,.4e-2\n",
            "f,note,t,x\n2,a,0,1\n4e-3,\"b, c\",1,-3\n",
            "t,x,t2,f,t2\n0,1,,2,\n1,-3,nan,4e-3,,\n",
        ] {
            for step in [1, 2, 3, 7, 1000] {
                assert_eq!(through(table.as_bytes(), step), (plain.clone(), vec![]), "{table:?} by {step}");
            }
        }
    }

    #[test]
    fn a_bad_row_is_refused_with_its_line_and_the_next_one_read() {
        let text = "t,x,f\n0,1,2\n1,abc,2\n2,NaN,2\n3,1\n4,1,2,3\n5,1e7,2\n6,,2\n7,\"1,2\n8,1,\0\n9,1,2\n";
        let (samples, refusals) = through(text.as_bytes(), 5);
        assert_eq!(samples, [[0.0, 1.0, 2.0], [9.0, 1.0, 2.0]]);
        let places = [
            "rig line 3, column 'x'",
            "rig line 4, column 'x'",
            "rig line 5:",
            "rig line 6:",
            "rig line 7, column 'x'",
            "rig line 8, column 'x'",
            "rig line 9:",
            "rig line 10, column 'f'",
        ];
        assert_eq!(refusals.len(), places.len(), "{refusals:#?}");
        for (refusal, place) in refusals.iter().zip(places) {
            assert!(refusal.starts_with(place), "{refusal} at {place}");
        }
    }

    #[test]
    fn an_endless_line_is_not_stored() {
        let mut table = LiveTable::new("rig", columns());
        let junk = vec![b'7'; 1 << 16];
        for mut chunk in std::iter::once(&b"t,x,f\n"[..]).chain(std::iter::repeat_n(&junk[..], 100)) {
            while let Some(line) = table.next(&mut chunk) {
                assert!(line.is_ok());
            }
            assert!(table.open.capacity() <= 2 << 20);
        }
        let mut rest = &b"\n0,1,2\n"[..];
        let refusal = table.next(&mut rest).expect("a line").expect_err("too long").to_string();
        assert!(refusal.starts_with("rig line 2: the line is longer"), "{refusal}");
        assert!(matches!(table.next(&mut rest), Some(Ok(LiveLine::Sample(_)))));
    }

    #[test]
    fn a_header_without_a_requested_column_is_an_error() {
        let (samples, refusals) = through(b"t,y,f\n", 100);
        assert!(samples.is_empty() && refusals[0].contains("no column 'x'"), "{refusals:?}");
    }

    proptest! {
        #[test]
        fn a_stream_and_a_file_give_the_same_samples(
            rows in prop::collection::vec((1_u32..50, -1e3..1e3, -1e3..1e3), 2..40),
            step in 1_usize..200,
        ) {
            let mut text = String::from("t,x,f\n");
            let mut ms = 0;
            for (gap, x, f) in &rows {
                ms += 45 + gap / 10;
                text.push_str(&format!("{},{x},{f}\n", f64::from(ms) * 1e-3));
            }
            let file = read_csv("file", text.as_bytes(), &columns(), &Limits::default()).expect("a recording");
            let (samples, refusals) = through(text.as_bytes(), step);
            prop_assert!(refusals.is_empty());
            for (index, sample) in samples.iter().enumerate() {
                let [t, x, f] = *sample;
                let own = (file.time_s()[index], file.position_m()[index], file.force_n()[index]);
                prop_assert_eq!((t, x, f), own);
            }
            prop_assert_eq!(samples.len(), file.len());
        }
    }
}
