//! The beginning of a text table: comments, a preamble, LabVIEW's header, the names of the columns, and the separator.
//!
//! The names are the first line that is neither blank nor a comment (`#` or `%`), unless [`block::table`] finds them
//! below a preamble. If that line contains only numbers, the names are the last comment with as many fields; without
//! one the columns are numbered. The separator is the most frequent of `,`, `;` and tab in the names, otherwise `|`, or
//! spaces if the line below the names has as many numbers.

use std::io::{self, BufRead};

use super::block::{self, Table};
use super::header::separator;
use super::labview::{self, Clock};
use super::units;

#[derive(Debug, Default)]
pub(super) struct Head {
    pub(super) text: Vec<u8>,
    pub(super) lines_before: u64,
    pub(super) separator: u8,
    pub(super) in_spaces: bool,
    pub(super) has_comment_names: bool,
    pub(super) has_percent: bool,
    pub(super) units: Vec<String>,
    pub(super) clock: Option<Clock>,
    /// True if rows may have more fields than names, such as comments.
    pub(super) is_labview: bool,
    pub(super) is_incomplete: bool,
    pub(super) unnamed: Option<usize>,
}

pub(super) fn head(text: &mut impl BufRead, skip_lines: u64) -> io::Result<Head> {
    let mut skipped = vec![];
    for _ in 0..skip_lines {
        skipped.clear();
        if text.read_until(b'\n', &mut skipped)? == 0 {
            break;
        }
    }
    let beginning = block::beginning(text)?;
    let mut rest = &beginning[..];
    let table = block::table(&beginning);
    let mut head = with_names(&mut rest, table.as_ref())?;
    head.lines_before += skip_lines;
    head.text.extend_from_slice(rest);
    match table {
        Some(table) if !head.has_comment_names && !head.is_labview && !head.is_incomplete => Ok(Head {
            text: beginning[table.from..].to_vec(),
            lines_before: skip_lines + table.lines_before as u64,
            separator: table.separator.unwrap_or(b'\t'),
            in_spaces: table.separator.is_none(),
            has_percent: head.has_percent,
            unnamed: table.unnamed,
            ..Head::default()
        }),
        _ => Ok(head),
    }
}

fn with_names(text: &mut impl BufRead, table: Option<&Table>) -> io::Result<Head> {
    let mut line = Vec::new();
    let mut lines_before = 0;
    let mut comments: Vec<Vec<u8>> = vec![];
    loop {
        line.clear();
        let ended = text.read_until(b'\n', &mut line)? == 0;
        let content = line.trim_ascii();
        let is_comment = content.starts_with(b"#") || content.starts_with(b"%");
        if ended || !(content.is_empty() || is_comment) {
            break;
        }
        if is_comment {
            // The last two comments can be names and units.
            if comments.len() == 2 {
                comments.remove(0);
            }
            comments.push(content.to_vec());
        }
        lines_before += 1;
    }
    if line.trim_ascii_start().starts_with(labview::MARK) {
        return from_labview(text, lines_before);
    }
    let has_percent = comments.iter().any(|comment| comment.starts_with(b"%"));
    // Not the first line if a preamble precedes it.
    let is_first = table.is_none_or(|table| table.lines_before as u64 == lines_before);
    if is_first && let Some(head) = from_comments(&line, &comments, lines_before) {
        return Ok(Head { has_percent, has_comment_names: true, ..head });
    }
    let mut head = Head { separator: separator(&line), lines_before, has_percent, ..Head::default() };
    let has_separator = line.iter().any(|byte| b",;\t".contains(byte));
    if !has_separator && line.contains(&b'|') {
        head.separator = b'|';
    } else if !has_separator && line.trim_ascii().contains(&b' ') {
        let names = spaced(&line).len();
        head.text.append(&mut line);
        text.read_until(b'\n', &mut line)?;
        head.in_spaces =
            names > 1 && spaced(&line).len() == names && spaced(&line).into_iter().all(|field| is_number(field, true));
        if head.in_spaces {
            head.separator = b'\t';
        }
    }
    head.text.append(&mut line);
    Ok(head)
}

fn from_labview(text: &mut impl BufRead, lines_before: u64) -> io::Result<Head> {
    let Some(found) = labview::read(text)? else {
        return Ok(Head { is_incomplete: true, lines_before, ..Head::default() });
    };
    Ok(Head {
        text: found.names,
        lines_before: lines_before + found.lines,
        separator: found.separator,
        units: found.units,
        clock: found.clock,
        is_labview: true,
        ..Head::default()
    })
}

fn from_comments(line: &[u8], comments: &[Vec<u8>], lines_before: u64) -> Option<Head> {
    let last = comments.last()?;
    // A line that begins with % may be the names itself, if the line below contains a number.
    let has_percent = last.starts_with(b"%");
    // The comma is tried last, because it can be the decimal mark between other separators.
    let (separator, values) =
        [Some(b';'), Some(b'\t'), Some(b'|'), Some(b','), None].into_iter().find_map(|separator| {
            let values = separator.map_or_else(|| spaced(line), |separator| fields(line, separator));
            let is_number = |value: &&[u8]| is_number(value, separator != Some(b','));
            let is_data = if has_percent { values.iter().any(is_number) } else { values.iter().all(is_number) };
            (values.len() > 1 && is_data && split(last, separator, values.len()).is_some())
                .then_some((separator, values))
        })?;
    let mut names = split(last, separator, values.len())?;
    let mut units = vec![];
    let has_units = names.iter().any(|name| units::is_known(name));
    if has_units
        && let [above, _] = comments
        && let Some(above) = split(above, separator, values.len())
    {
        units = std::mem::replace(&mut names, above);
    }
    let in_spaces = separator.is_none();
    let separator = separator.unwrap_or(b'\t');
    let quoted = names.iter().map(|name| format!("\"{}\"", name.replace('"', "\"\"")));
    let mut text = quoted.collect::<Vec<_>>().join(&char::from(separator).to_string()).into_bytes();
    text.push(b'\n');
    text.extend_from_slice(line);
    // As if directly above the numbers.
    let lines_before = lines_before.saturating_sub(1);
    Some(Head { text, lines_before, separator, in_spaces, units, ..Head::default() })
}

/// Splits at the separator of the rows, at the most frequent separator, or at spaces.
fn split(comment: &[u8], separator: Option<u8>, count: usize) -> Option<Vec<String>> {
    let marks = comment.iter().take_while(|byte| b"#%".contains(byte)).count();
    let text = comment[marks..].trim_ascii();
    let own = separator.into_iter().chain([self::separator(text)]).map(|separator| fields(text, separator));
    let split = own.chain([spaced(text)]).find(|fields| fields.len() == count)?;
    Some(split.into_iter().map(|field| String::from_utf8_lossy(field).trim_matches('"').to_owned()).collect())
}

fn fields(line: &[u8], separator: u8) -> Vec<&[u8]> {
    line.trim_ascii_end().split(|byte| *byte == separator).map(<[u8]>::trim_ascii).collect()
}

fn spaced(line: &[u8]) -> Vec<&[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|field| !field.is_empty()).collect()
}

fn is_number(field: &[u8], may_have_comma: bool) -> bool {
    let text = String::from_utf8_lossy(field);
    let text = if may_have_comma { text.replacen(',', ".", 1) } else { text.into_owned() };
    text.parse::<f64>().is_ok()
}
