use std::io::Read;

use super::header::find;
use super::table::Rows;
use super::{Column, Limits, RecordingError};

#[derive(Debug, Clone, PartialEq)]
pub struct LabelRow {
    /// `None` without this column.
    pub file: Option<String>,
    /// `None`: examined, without a rupture.
    pub time_s: Option<f64>,
    pub kind: Option<String>,
    pub line: u64,
}

/// Columns `file` (required only if `needs_file`), `time_s` and optionally `kind`; rows in any order. An empty time
/// means that the recording has no rupture.
pub fn read_labels<R: Read>(
    source: &str,
    reader: R,
    limits: &Limits,
    needs_file: bool,
) -> Result<Vec<LabelRow>, RecordingError> {
    let columns = ["file", "time_s", "kind"].map(Column::plain);
    let (mut rows, (file, time, kind, width)) = Rows::open(source, reader, &limits.of_table(), |names| {
        let optional = |column: &Column| {
            if names.iter().any(|name| name == column.name()) { find(names, column).map(Some) } else { Ok(None) }
        };
        let file = if needs_file { Some(find(names, &columns[0])?) } else { optional(&columns[0])? };
        Ok((file, find(names, &columns[1])?, optional(&columns[2])?, names.len()))
    })?;
    let mut labels = vec![];
    while rows.next()? {
        rows.check_room(labels.len(), limits.max_samples)?;
        rows.check_width(width)?;
        let time_s = if rows.is_empty_or(time, &[]) { None } else { Some(rows.number(time, &columns[1])?) };
        let file = file.map(|index| rows.word(index, &columns[0])).transpose()?;
        let kind = match kind {
            Some(index) if !rows.is_empty_or(index, &[]) => Some(rows.word(index, &columns[2])?),
            _ => None,
        };
        labels.push(LabelRow { file, time_s, kind, line: rows.line() });
    }
    Ok(labels)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(table: &str, needs_file: bool) -> Result<Vec<LabelRow>, String> {
        read_labels("l.csv", table.as_bytes(), &Limits::default(), needs_file).map_err(|error| error.to_string())
    }

    #[test]
    fn rows_are_returned_with_their_line() {
        let rows = read("# by hand\nkind;time_s;file\nskin;1.5;a.csv\n;0.5;\"b.csv\"\n\n;;c.csv\n", true);
        let row = |file: &str, time_s, kind: Option<&str>, line| LabelRow {
            file: Some(file.into()),
            time_s,
            kind: kind.map(Into::into),
            line,
        };
        let expected = vec![
            row("a.csv", Some(1.5), Some("skin"), 3),
            row("b.csv", Some(0.5), None, 4),
            row("c.csv", None, None, 6),
        ];
        assert_eq!(rows, Ok(expected));
        let alone = LabelRow { file: None, time_s: Some(-2.0), kind: None, line: 2 };
        assert_eq!(read("time_s\n-2\n", false), Ok(vec![alone]));
        assert_eq!(read("time_s\n", false), Ok(vec![]), "examined, without a rupture");
    }

    #[test]
    fn invalid_labels_are_rejected_with_their_place() {
        let refusal = |table: &str| read(table, true).expect_err("refused");
        for (table, problem) in [
            ("file,time_s\na.csv,soon\n", "l.csv line 2, column 'time_s': 'soon' is not a number"),
            ("file,time_s\na.csv,1\na.csv,NaN\n", "l.csv line 3, column 'time_s': 'NaN' is not fin"),
            ("file,time_s\n,1\n", "l.csv line 2, column 'file': the field is empty"),
            ("file,time_s\na.csv,1,2\n", "l.csv line 2: the row has 3 fields, the header 2"),
        ] {
            assert!(refusal(table).starts_with(problem), "{}", refusal(table));
        }
        assert!(refusal("time_s\n1\n").contains("no column 'file'"));
        assert!(refusal("file,time\na,1\n").contains("did you mean 'time'?"));
        assert!(refusal("").contains("holds no data"));
    }
}
