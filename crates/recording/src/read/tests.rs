//! Tests of accepted tables, and of the errors of rejected ones.

use std::io;

use proptest::prelude::*;

use super::super::fixtures::{columns, read, recording, refusal};
use super::*;

fn samples(table: impl AsRef<[u8]>) -> Vec<[f64; 3]> {
    let recording = read(table).expect("a recording");
    let (position, force) = (recording.position_m(), recording.force_n());
    let rows = recording.time_s().iter().zip(position).zip(force);
    rows.map(|((&t, &x), &f)| [t, x, f]).collect()
}

#[test]
fn tables_of_any_form_are_read() {
    let plain = [[0.0, 1.0, 2.0], [1.0, -3.0, 4e-3]];
    for table in [
        "t,x,f\n0,1,2\n1,-3,4e-3\n",
        "t,x,f\n0,1,2\n1,-3,4e-3",
        "t;x;f\n0;1;2\n1;-3;4e-3\n",
        "t\tx\tf\n0\t1\t2\n1\t-3\t4e-3\n",
        "\u{feff}t,x,f\r\n0,1,2\r\n1,-3,4e-3\r\n\r\n",
        "t,x,f\r0,1,2\r1,-3,4e-3\r",
        "# by hand\n\n  # twice\nt,x,f\n0,1,2\n# pause\n  # pause\n\n1,-3,4e-3\n   \n,,\n",
        " t , x,f \n +0.0 , 1., 2\n\t1 ,-3,.4e-2\n",
        "\"t\",\"x\",\"f\"\n\"0\",\"1\",\"2\"\n\"1\", \"-3\",4e-3\n",
        "f,note,t,x\n2,a,0,1\n4e-3,\"b, \"\"c\"\"\nd\",1,-3\n",
        "t,x,f\n0,1,2,\n1,-3,4e-3,,\n",
        "t,x,t2,f,t2\n0,1,,2,\n1,-3,nan,4e-3,\n",
    ] {
        assert_eq!(samples(table), plain, "{table:?}");
    }
    let latin = b"t,x,f,note\n0,1,2,\xb5\n1,-3,4e-3,\xff\n";
    assert_eq!(samples(latin), plain);
}

/// A LabVIEW file with the given lines below its header.
fn labview(lines: &str) -> String {
    format!(
        "LabVIEW Measurement\t\r\nWriter_Version\t2\r\nSeparator\tTab\r\nDecimal_Separator\t,\r\n***End_of_Header***\t\r\n\t\r\n\
         Channels\t2\t\t\r\nY_Unit_Label\tmm\tN\t\r\nX0\t0,0\t0,0\t\r\nDelta_X\t1,0\t1,0\t\r\n***End_of_Header***\t\t\t\r\n{lines}"
    )
}

#[test]
fn tables_of_laboratories_are_read() {
    let plain = [[0.0, 1.0, 2.5], [1.0, -3.0, 4e-3]];
    let spaced = |text: &str| text.replace(',', "  ");
    let rows = "0,1,2.5\n1,-3,4e-3\n";
    for table in [
        format!("# t,x,f\n{rows}"),
        format!("%t,x,f\n{rows}"),
        format!("% by hand\n% t, x, f\n%\n% [s],[m],[N]\n{rows}").replace("%\n", ""),
        "% by hand\nt,x,f\n0,1,2.5\n% pause\n1,-3,4e-3\n".into(),
        format!("#t x f\n{}", spaced(rows)),
        format!("# t, x, f\n{}", spaced(rows)),
        format!("  t x   f\n {}", spaced(rows)),
        format!("t,x,f\ns,m,N\n{rows}"),
        format!("t,x,f\n[s],[m],[N]\n{rows}"),
        "t|x|f\n0|1|2.5\n1|-3|4e-3\n".into(),
        "t;x;f\n0;1,0;2,5\n1;-3;4e-3\n".into(),
        "t\tx\tf\n0,0\t1\t2,5\n1\t-3\t,4e-2\n".into(),
        "t x f\n0 1,0 2,5\n1 -3 4e-3\n".into(),
        "% t;x;f\n0,0;1,0;2,5\n1;-3;4e-3\n".into(),
        "# t x f\n0,0 1,0 2,5\n1 -3 4e-3\n".into(),
    ] {
        assert_eq!(samples(&table), plain, "{table:?}");
    }
    let utf16 =
        |table: &str| [0xfeff].into_iter().chain(table.encode_utf16()).flat_map(u16::to_le_bytes).collect::<Vec<_>>();
    assert_eq!(samples(utf16(&format!("t,x,f,µ\r\n{}", rows.replace('\n', ",1\r\n")))), plain);
    assert_eq!(samples(b"t,x,f,\xb5\n0,1,2.5,1\n1,-3,4e-3,1\n"), plain, "Latin-1 in the names");
}

#[test]
fn labview_files_are_read_with_their_times_or_their_clock() {
    let columns =
        Columns { time: "X_Value".parse().expect("a column"), position: "x".parse().expect("a column"), ..columns() };
    for lines in [
        "X_Value\tx\tf\tComment\r\n0,0\t1,5\t2\r\n1\t2\t3\tend\r\n",
        "X_Value\tx\tf\tComment\r\n\t1,5\t2\r\n\t2\t3\r\n",
    ] {
        let table = labview(lines);
        let recording = read_csv("l.lvm", table.as_bytes(), &columns, &Limits::default()).expect(lines);
        assert_eq!((recording.time_s(), recording.position_m()), (&[0.0, 1.0][..], &[1.5, 2.0][..]), "{lines:?}");
        let signals = scan_csv("l.lvm", table.as_bytes(), &Limits::default()).expect("signals");
        let units: Vec<_> = signals.iter().map(|signal| signal.unit.as_deref().unwrap_or_default()).collect();
        assert_eq!(units, ["s", "mm", "N"]);
    }
    let bad = labview("X_Value\tx\tf\r\n0\t1\t2\r\n1\t?\t2\r\n");
    let refusal = |table: &str| {
        read_csv("l.lvm", table.as_bytes(), &columns, &Limits::default()).expect_err("refused").to_string()
    };
    assert!(refusal(&bad).starts_with("l.lvm line 14, column 'x': '?' is not a number"), "{}", refusal(&bad));
    assert_eq!(
        refusal(&labview("")),
        "l.lvm: the LabVIEW header is incomplete: no line of columns (X_Value, …) follows it; export the file again"
    );
}

#[test]
fn a_name_after_a_percent_sign_can_be_given_with_the_sign() {
    let columns = Columns { time: "%t".parse().expect("a column"), ..columns() };
    let read =
        |table: &str| read_csv("pop.csv", table.as_bytes(), &columns, &Limits::default()).map(|found| found.len());
    assert_eq!(read("%t,x,f,note\n0,1,2,a\n1,2,3,b\n").expect("as before"), 2);
}

#[test]
fn tables_below_a_preamble_are_read() {
    let bluehill = "General : Start date,\"2024-01-01\"\nMaximum Load,\"2.00\",N\n\nt,x,f\n(s),(m),(N)\n\"0.0\",\"1\",\"2.5\"\n\"1.0\",\"-3\",\"0.004\"\n";
    let plain = [[0.0, 1.0, 2.5], [1.0, -3.0, 4e-3]];
    assert_eq!(samples(bluehill), plain);
    let long = format!("{}t;x;f\n0;1;2,5\n1;-3;,004\n", "Parameter;1\n# remark\n\n".repeat(3));
    assert_eq!(samples(&long), plain, "{long}");
    assert_eq!(samples(format!("{}{bluehill}", "a line of text\n".repeat(5000))), plain);
    let limits = Limits { skip_lines: 1, ..Limits::default() };
    let skipped = |table: &str| read_csv("pop.csv", table.as_bytes(), &columns(), &limits);
    assert_eq!(skipped("a,b,c\nt,x,f\n0,1,2\n1,-3,4\n").expect("a recording").len(), 2);
    let refusal = skipped("a,b,c\nt,x,f\n0,1,2\n1,?,4\n").expect_err("refused").to_string();
    assert!(refusal.starts_with("pop.csv line 4, column 'x'"), "{refusal}");
}

#[test]
fn a_table_without_names_has_numbered_columns() {
    let column = |text: &str| text.parse().expect("a column");
    let columns = Columns { time: column("1"), position: column("2:2+1"), velocity: None, force: column("3") };
    for table in
        ["0,1,2\n1,2,3\n", "0;1;2\n1;2;3\n", "0 1 2\n1 2 3\n", "by hand\n\n0\t1\t2\n1\t2\t3\n", "t,x,f\n0,1,2\n1,2,3\n"]
    {
        let recording = read_csv("pop.csv", table.as_bytes(), &columns, &Limits::default()).expect(table);
        assert_eq!((recording.time_s(), recording.position_m()), (&[0.0, 1.0][..], &[3.0, 5.0][..]), "{table}");
    }
    let at = read_csv("pop.csv", &b"0,1,2\n1,?,3\n2,2,2\n"[..], &columns, &Limits::default()).expect_err("refused");
    assert!(at.to_string().starts_with("pop.csv line 2, column '2'"), "{at}");
    let names: Vec<String> = scan_csv("pop.csv", &b"0,1\n1,2\n"[..], &Limits::default())
        .expect("signals")
        .into_iter()
        .map(|s| s.name)
        .collect();
    assert_eq!(names, ["1", "2"]);
}

#[test]
fn a_rate_replaces_the_column_of_time() {
    let limits = Limits { rate_hz: Some(500.0), ..Limits::default() };
    let recording = read_csv("pop.csv", &b"x,f\n0,1\n1,2\n2,3\n"[..], &columns(), &limits).expect("a recording");
    assert_eq!(recording.time_s(), [0.0, 0.002, 0.004]);
}

#[test]
fn dates_and_unix_times_count_from_the_first_sample() {
    for table in [
        "t,x,f\n2026-01-01T00:00:00.000Z,1,2\n2026-01-01T00:00:00.250Z,1,2\n",
        "t,x,f\n1767225600.000000,1,2\n1767225600.250000,1,2\n",
    ] {
        let recording = read(table).expect(table);
        assert_eq!((recording.time_s(), recording.origin_s()), (&[0.0, 0.25][..], 1767225600.0), "{table}");
    }
    let mixed = refusal("t,x,f\n2026-01-01T00:00:00,1,2\nyesterday,1,2\n");
    assert!(mixed.starts_with("pop.csv line 3, column 't': 'yesterday' is not a number"), "{mixed}");
    let listed = scan_csv("pop.csv", &b"t,x\n10:00:00,1\n10:00:01,2\n"[..], &Limits::default()).expect("signals");
    assert_eq!((listed[0].role, listed[0].unit.as_deref()), (Some(Quantity::Time), Some("s")));
}

#[test]
fn a_first_time_that_is_written_twice_counts_once() {
    assert_eq!(samples("t,x,f\n0,9,9\n0,1,2\n1,2,3\n"), [[0.0, 1.0, 2.0], [1.0, 2.0, 3.0]]);
    assert!(refusal("t,x,f\n0,9,9\n-1,1,2\n").contains("time decreases"));
}

#[test]
fn a_table_is_listed_as_signals() {
    let table = "t,x,f,note\nms,mm,N,-\n0,1,2,a\n1,3,,b\n2,2,5,c\n";
    let signals = scan_csv("pop.csv", table.as_bytes(), &Limits::default()).expect("signals");
    let shown = |signal: &Signal| (signal.column(), signal.samples, signal.range, signal.undefined, signal.increase);
    assert_eq!(
        signals.iter().map(shown).collect::<Vec<_>>(),
        [
            ("t:ms".into(), 3, Some((0.0, 2.0)), 0, Some(2.0)),
            ("x:mm".into(), 3, Some((1.0, 3.0)), 0, None),
            ("f:N".into(), 3, Some((2.0, 5.0)), 1, None),
        ]
    );
}

#[test]
fn scales_convert_units_and_signs() {
    let columns =
        Columns { time: "t:0.001".parse().expect("a column"), force: "f:-2".parse().expect("a column"), ..columns() };
    let recording = read_csv("pop.csv", &b"t,x,f\n0,1,2\n4,5,6\n"[..], &columns, &Limits::default());
    let recording = recording.expect("a recording");
    assert_eq!(recording.time_s(), [0.0, 0.004]);
    assert_eq!(recording.force_n(), [-4.0, -12.0]);
    assert_eq!(recording.velocity_m_per_s(), None);
}

#[test]
fn unusable_tables_are_refused_with_place_and_remedy() {
    const EMPTY: &str = ": holds no data; a header line with the columns' names is expected, then one sample per line";
    const NO_SAMPLES: &str = ": holds a header but no samples; at least two are needed";
    const BINARY: &str = ": holds binary data (a zero byte); export it as CSV text in UTF-8";
    const RAGGED: &str = "the header 3; complete or remove the row (decimals need a point, not a comma)";
    const OPEN: &str = ": a quoted field continues past the end of the line; close the quote";
    const REMOVE: &str = "; correct it or remove the row";
    let by_numbers = ": no column 't' (--time or recording.columns.time_s): the file has no line of names, so that its 3 columns \
                      are named by their numbers; give them as in --time 1 --position 2 --force 3, or add a line of names";
    for (table, place, problem) in [
        (
            "t,x,F,raw\n",
            ": no column 'f' (--force or recording.columns.force_n)",
            "; the file has t, x, F, raw; did you mean 'F'?",
        ),
        ("t,y,f\n", ": no column 'x' (--position or recording.columns.position_m)", "; the file has t, y, f"),
        ("t,x,f,x,x\n", ": 3 columns are named 'x'; rename all but one, ", "or give the number of the column, from 1"),
        ("# t,x\n0,1,2\n", "", by_numbers),
        ("", "", EMPTY),
        ("\n\n", "", EMPTY),
        ("\u{feff}", "", EMPTY),
        ("# nothing\n", "", EMPTY),
        ("  ", "", EMPTY),
        ("t,x,f", "", NO_SAMPLES),
        ("t,x,f\n\n# 0,1,2\n", "", NO_SAMPLES),
        ("t,x,f\n0,1,2\n", "", ": holds a single sample; at least two are needed"),
        ("t,x,f\n0,1,2\n\0", " line 3", BINARY),
        ("t\0,\0", " line 1", BINARY),
        ("t,x,f\n0,1,2\n1,abc,2\n", " line 3, column 'x': 'abc' is not a number", REMOVE),
        ("t,x,f\n0,1,NaN\n", " line 2, column 'f': 'NaN' is not finite", REMOVE),
        ("t,x,f\n0,\"1,5\",2\n", " line 2, column 'x': '1,5' is not a number", "; write decimals with a point"),
        ("t,x,f\n0,,2\n", " line 2, column 'x': the field is empty; fill in a number or", " remove the row"),
        ("t,x,f\n0,1\n", " line 2: the row has 2 fields, ", RAGGED),
        ("t,x,f\n0,0,1,5,2,0\n", " line 2: the row has 6 fields, ", RAGGED),
        ("t,x,f\n0,\"1,2\n1,1,2\n2,1,2\n", " line 2", OPEN),
        ("t,x,f\n0,1,2\n1,\"1,2", " line 3", OPEN),
        ("t,x,f\n0,1,\"2\n1,1,2\n", " line 2, column 'f'", OPEN),
        (
            "t,x,f\n0,1,2\n# pause\n0.5,1,2\n0.25,1,2\n",
            " line 5, column 't': time decreases, from 0.5 s on line 4 to 0.25 s",
            "; sort the rows by time, or keep one run per file",
        ),
        (
            "t,x,f\n0,1,2\n1,1,2\n# pause\n1,1,2\n",
            " line 5, column 't': the time 1 s repeats that of line 3",
            "; remove the repeated row, or log time with more digits",
        ),
        (
            "t,x,f\n0,0,0\n0.1,0,0\n\n0.2,0,1e9\n",
            " line 5, column 'f': is 1e9 N, at most 1e6 N",
            "; correct it, or give the unit or the factor of the column",
        ),
    ] {
        assert_eq!(refusal(table), format!("pop.csv{place}{problem}"), "{table:?}");
    }
}

#[test]
fn lines_are_counted_as_in_an_editor() {
    for (table, line) in [
        ("t,x,f\n0,1,2\n?,1,2\n", 3),
        ("t,x,f\n?,1,2", 2),
        ("\u{feff}t,x,f\r\n0,1,2\r\n?,1,2\r\n", 3),
        ("t,x,f\r0,1,2\r?,1,2", 3),
        ("#\n\n#\nt,x,f\n0,1,2\n\n# pause\n?,1,2\n", 8),
        ("t,x,f,n\n0,1,2,\"a\nb\"\n?,1,2,\"c\nd\"\n", 4),
        ("t,x,\"f\"\n0,1,2\n  \n?,1,2\n", 4),
    ] {
        assert!(refusal(table).starts_with(&format!("pop.csv line {line}, column 't': '?'")), "{table:?}");
    }
}

#[test]
fn pauses_have_a_limit() {
    let table = "t,x,f\n0,0,0\n0.005,0,0\n0.01,0,0\n# pause\n0.21,0,0\n0.215,0,0\n";
    assert_eq!(
        refusal(table),
        "pop.csv line 6, column 't': no sample for 0.2 s since line 4 (from 0.01 s to 0.21 s), the limit is 0.05 s \
         (10 times the median interval, 0.005 s); cut the recording there, or raise max_gap_s"
    );
    let limited = |max_gap_s| {
        let max_gap_s = Some(max_gap_s);
        let limits = Limits { max_gap_s, ..Limits::default() };
        read_csv("pop.csv", table.as_bytes(), &columns(), &limits)
    };
    assert_eq!(limited(0.2).expect("allowed").len(), 5);
    assert!(limited(f64::NAN).is_err());
    assert_eq!(
        limited(0.1).expect_err("too long").to_string(),
        "pop.csv line 6, column 't': no sample for 0.2 s since line 4 (from 0.01 s to 0.21 s), the limit is 0.1 s; \
         cut the recording there, or raise max_gap_s"
    );
}

#[test]
fn samples_have_a_limit() {
    let limits = Limits { max_samples: 2, ..Limits::default() };
    let limited = |table: &str| read_csv("pop.csv", table.as_bytes(), &columns(), &limits);
    assert_eq!(limited("t,x,f\n0,0,0\n1,0,0\n\n#\n").expect("two").len(), 2);
    let error = limited("t,x,f\n0,0,0\n1,0,0\n2,0,0\n").expect_err("three");
    assert_eq!(
        error.to_string(),
        "pop.csv line 4: more than 2 samples; downsample the recording or raise recording.max_samples"
    );
}

#[test]
fn a_failing_source_is_an_error() {
    struct Failing;
    impl Read for Failing {
        fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
            Err(io::Error::other("the disk is gone"))
        }
    }
    let rest = b"t,x,f\n0,0,0\n".chain(Failing);
    let error = read_csv("pop.csv", rest, &columns(), &Limits::default()).expect_err("refused");
    assert_eq!(error.to_string(), "pop.csv: cannot be read: the disk is gone");
}

fn almost_a_table() -> impl Strategy<Value = String> {
    let piece = prop::sample::select(vec![
        "0", "1", "2.5", "-1e-3", "nan", "abc", "", " ", "\"", "\"\"", "#", ",", ",", ";", "\t", "\n", "\r\n", "\r",
        "é", "1,2,3\n",
    ]);
    prop::collection::vec(piece, 0..60).prop_map(|pieces| format!("t,x,f\n{}", pieces.concat()))
}

/// A number of any exponent that a position can have, and also twice the number.
fn plausible(number: f64) -> f64 {
    if number.abs() <= 0.5 * Limits::MAX_MAGNITUDE { number } else { 1.0 / number }
}

#[test]
fn a_last_line_without_its_end_is_noted() {
    let table = "t,x,f\n0,0,0\n0.1,0,0\n0.2,0,1";
    let cut = read(table).expect("a recording");
    assert!(cut.unfinished().is_some_and(|reason| reason.contains("its last line, 4,")), "{:?}", cut.unfinished());
    assert_eq!(read(format!("{table}\n")).expect("a recording").unfinished(), None);
}

proptest! {
    #[test]
    fn bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = read(&bytes);
        let _ = read([b"t,x,f\n0,1,2\n", bytes.as_slice()].concat());
    }

    #[test]
    fn almost_tables_never_panic(table in almost_a_table()) {
        match read(&table) {
            Ok(recording) => {
                prop_assert!(recording.len() >= 2);
                prop_assert!(recording.time_s().is_sorted_by(|a, b| a < b));
            }
            Err(error) => {
                let message = error.to_string();
                prop_assert!(message.starts_with("pop.csv"));
                let lines = table.replace("\r\n", "\n").replace('\r', "\n").lines().count() as u64;
                prop_assert!(error.place.row.is_none_or(|row| matches!(row, Row::Line(line) if (1..=lines).contains(&line))), "{} {:?}", message, table);
            }
        }
    }

    #[test]
    fn written_numbers_read_back_as_the_same_bits(
        rows in prop::collection::btree_map(-1_000_000_i64..1_000_000, prop::num::f64::NORMAL.prop_map(plausible), 2..50),
    ) {
        let time_s: Vec<f64> = rows.keys().map(|&t| t as f64 / 3.0).collect();
        let position_m: Vec<f64> = rows.into_values().collect();
        let recording = recording(&time_s, &position_m);
        let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        prop_assert_eq!(bits(recording.time_s()), bits(&time_s));
        prop_assert_eq!(bits(recording.position_m()), bits(&position_m));
    }
}
