//! LabVIEW's text measurement files (`.lvm`): lines of keys and values, ended by `***End_of_Header***`, once for the
//! file and once for the segment. Then follow the names of the columns, the first of which is `X_Value`.

use std::io::{self, BufRead};

pub(super) const MARK: &[u8] = b"LabVIEW Measurement";

pub(super) const X_VALUE: &str = "X_Value";

/// The last column, absent in most rows.
const COMMENT: &str = "Comment";

const MAX_LINES: u64 = 1000;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Clock {
    pub(super) start_s: f64,
    pub(super) interval_s: f64,
}

impl Clock {
    pub(super) fn time_s(self, sample: usize) -> f64 {
        self.start_s + sample as f64 * self.interval_s
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct LabView {
    pub(super) names: Vec<u8>,
    pub(super) separator: u8,
    pub(super) clock: Option<Clock>,
    pub(super) units: Vec<String>,
    pub(super) lines: u64,
}

pub(super) fn read(text: &mut impl BufRead) -> io::Result<Option<LabView>> {
    let mut found = LabView { names: vec![], separator: b'\t', clock: None, units: vec![], lines: 1 };
    let (mut start_s, mut interval_s) = (0.0, None);
    let mut line = vec![];
    while found.lines < MAX_LINES {
        line.clear();
        if text.read_until(b'\n', &mut line)? == 0 {
            return Ok(None);
        }
        let shown = String::from_utf8_lossy(&line);
        let mut fields = shown.trim_end_matches(['\n', '\t', ',']).split(char::from(found.separator)).map(str::trim);
        let key = fields.next().unwrap_or_default();
        let number =
            |text: Option<&str>| text?.replace(',', ".").parse::<f64>().ok().filter(|number| number.is_finite());
        match key {
            X_VALUE => {
                let separator = char::from(found.separator).to_string();
                let mut names: Vec<&str> = shown.trim_end().split(char::from(found.separator)).map(str::trim).collect();
                if names.last() == Some(&COMMENT) {
                    names.pop();
                }
                found.names = format!("{}\n", names.join(&separator)).into_bytes();
                found.clock = interval_s.map(|interval_s| Clock { start_s, interval_s });
                return Ok(Some(found));
            }
            "Separator" if fields.next() == Some("Comma") => found.separator = b',',
            _ if key.starts_with("Separator,") => found.separator = b',',
            "Delta_X" => interval_s = number(fields.next()).filter(|interval_s| *interval_s > 0.0),
            "X0" => start_s = number(fields.next()).unwrap_or(0.0),
            "Y_Unit_Label" => {
                found.units = std::iter::once("s").chain(fields).map(str::to_owned).collect();
            }
            _ => {}
        }
        found.lines += 1;
    }
    Ok(None)
}
