//! Time and memory grow at most linearly with the size of a file, for every part of a format that can be repeated.

use super::containers::{
    archive, channel, channels, chunk, lead_in, leaf, log, matlab, matrix, message, numpy, packed, segment,
};
use super::tables::zipped;
use super::{LONGEST, peak};
use trocar_recording::{Limits, list_signals};

/// Sizes of the files in bytes.
const SIZES: [usize; 4] = [10_000, 100_000, 1_000_000, 10_000_000];

/// How far time and memory may exceed the proportional growth from one size to the next: vectors double, and a large file
/// does not fit in the caches. A growth with the square of the size is tenfold the proportional one.
const SLACK: f64 = 4.0;

/// Memory in bytes and time in s that do not depend on the size.
const BUFFERS: f64 = 2e6;
const START_S: f64 = 0.1;

/// The time of this thread on a processor in s, which other programs do not change. The readers use one thread.
fn cpu_s() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// Reads files with more and more of a repeated part. `content` makes a file with that many parts of `part_bytes`.
fn grows_linearly(name: &str, part_bytes: usize, content: impl Fn(usize) -> Vec<u8>) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    let mut last: Option<[f64; 2]> = None;
    for size in SIZES {
        std::fs::write(&path, content(size / part_bytes)).expect("written");
        let start_s = cpu_s();
        let (peak, _) = peak::of(|| list_signals(&path, &Limits::default()).map(|signals| signals.len()));
        let costs = [cpu_s() - start_s, peak as f64];
        if let Some(before) = last {
            let [time_s, memory] = before.map(|cost| 10.0 * SLACK * cost);
            assert!(
                costs[0] <= time_s + START_S && costs[1] <= memory + BUFFERS,
                "{name}, {size}: {before:?}, {costs:?}"
            );
        }
        assert!(costs[0] < LONGEST.as_secs_f64(), "{name}, {size}: {costs:?}");
        last = Some(costs);
    }
}

/// Numbered texts, separated by a text.
fn numbered(count: usize, separator: &str, text: impl Fn(usize) -> String) -> String {
    (0..count).map(text).collect::<Vec<_>>().join(separator)
}

#[test]
fn text() {
    const HEADER: &str = "time_s,position_m,force_n\n";
    grows_linearly("rows.csv", 12, |n| (HEADER.to_owned() + &numbered(n, "\n", |k| format!("{k},{k},{k}"))).into());
    grows_linearly("preamble.csv", 10, |n| {
        (numbered(n, "\n", |k| format!("# note {k}")) + "\n" + HEADER + "1,2,3\n").into()
    });
    grows_linearly("columns.csv", 7, |n| {
        (numbered(n, ",", |k| format!("a{k}")) + "\n" + &numbered(n, ",", |_| "1".into())).into()
    });
    grows_linearly("empty.csv", 1, |n| (HEADER.to_owned() + &"\n".repeat(n) + "1,2,3\n").into());
    grows_linearly("separators.csv", 1, |n| (HEADER.to_owned() + &",".repeat(n)).into());
    grows_linearly("quotes.csv", 2, |n| (HEADER.to_owned() + "\"" + &"\"\"".repeat(n) + "\"").into());
    grows_linearly("words.csv", 4, |n| (HEADER.to_owned() + &"x,y\n".repeat(n)).into());
    grows_linearly("dates.csv", 24, |n| {
        (HEADER.to_owned() + &numbered(n, "\n", |k| format!("2020-01-01 00:00:{:02},{k},1", k % 60))).into()
    });
    grows_linearly("rows.csv.gz", 1000, |n| zipped(n, HEADER, &"0,1,2\n".repeat(1000)));
}

#[test]
fn json_lines() {
    grows_linearly("rows.jsonl", 20, |n| numbered(n, "\n", |k| format!("{{\"a\":{k},\"b\":{k}}}")).into());
    grows_linearly("keys.jsonl", 12, |n| format!("{{{}}}\n", numbered(n, ",", |k| format!("\"a{k}\":1"))).into());
    grows_linearly("other_keys.jsonl", 14, |n| numbered(n, "\n", |k| format!("{{\"a{k}\":1}}")).into());
    grows_linearly("lists.jsonl", 2, |n| format!("{{\"a\":[{}]}}\n", numbered(n, ",", |_| "1".into())).into());
    grows_linearly("depth.jsonl", 6, |n| ("{\"a\":".repeat(n) + "1" + &"}".repeat(n) + "\n").into());
}

#[test]
fn matlab_files() {
    grows_linearly("arrays.mat", 96, |n| {
        matlab(&(0..n).flat_map(|k| leaf(format!("a{k}").as_bytes())).collect::<Vec<_>>())
    });
    grows_linearly("cells.mat", 72, |n| matlab(&matrix(1, [1, n as i32], b"a", &leaf(b"").repeat(n))));
    grows_linearly("packed.mat", 80, |n| matlab(&packed(&leaf(b"a")).repeat(n)));
    grows_linearly("depth.mat", 56, |n| {
        matlab(&(0..n.min(3000)).fold(leaf(b"a"), |inner, _| matrix(1, [1, 1], b"a", &inner)))
    });
}

#[test]
fn tdms_files() {
    let first = segment(0x0e, &channels(2, 1), &[1; 4]);
    let after = |parts: Vec<u8>| [first.clone(), parts].concat();
    grows_linearly("channels.tdms", 40, |n| segment(0x0e, &channels(n as u32, 1), &vec![1; 2 * n]));
    grows_linearly("segments.tdms", 28, |n| after(lead_in(0x08, 0, 0).repeat(n)));
    grows_linearly("data.tdms", 32, |n| after(segment(0x08, &[], &[1; 2]).repeat(n)));
    grows_linearly("lists.tdms", 80, |n| {
        after((0..n).flat_map(|k| segment(0x0a, &channels(1, 2 + k as u64 % 2), &[])).collect())
    });
}

#[test]
fn logs() {
    let json =
        |n: usize| -> Vec<u8> { (0..n).flat_map(|k| message(k as u64, format!("{{\"x\":{k}}}").as_bytes())).collect() };
    grows_linearly("messages.mcap", 50, |n| log(&[channel("json", None), json(n)].concat()));
    grows_linearly("channels.mcap", 40, |n| log(&channel("json", None).repeat(n)));
    grows_linearly("schemas.mcap", 70, |n| log(&channel("cdr", Some(("lab/A", "float64 a\n"))).repeat(n)));
    grows_linearly("fields.mcap", 18, |n| {
        let fields = numbered(n, "\n", |k| format!("float64 a{k}"));
        log(&[channel("cdr", Some(("lab/A", &fields))), message(1, &vec![0; 4 + 8 * n])].concat())
    });
    grows_linearly("chunks.mcap", 110, |n| {
        let records = json(1);
        log(&[channel("json", None), chunk("", records.len() as u64, &records).repeat(n)].concat())
    });
}

#[test]
fn numpy_files() {
    let header = |shape: &str| format!("{{'descr':'<f8','fortran_order':False,'shape':{shape},}}\n");
    grows_linearly("values.npy", 8, |n| numpy(&header(&format!("({n},)")), &vec![0; 8 * n]));
    grows_linearly("columns.npy", 16, |n| numpy(&header(&format!("(2,{n})")), &vec![0; 16 * n]));
    grows_linearly("shape.npy", 2, |n| numpy(&header(&format!("({})", "1,".repeat(n))), &[0; 8]));
    grows_linearly("entries.npz", 200, |n| {
        archive(&(0..n).map(|k| (format!("a{k}.npy"), numpy(&header("(2,)"), &[0; 16]))).collect::<Vec<_>>())
    });
}

#[test]
fn spreadsheets() {
    use super::containers::book;
    let row = |cells: &str| format!("<row>{cells}</row>");
    grows_linearly("rows.xlsx", 35, |n| book(1, "", &row("<c><v>1</v></c>").repeat(n)));
    grows_linearly("cells.xlsx", 15, |n| book(1, "", &row(&"<c><v>1</v></c>".repeat(n))));
    grows_linearly("empty.xlsx", 6, |n| book(1, "", &"<row/>".repeat(n)));
    grows_linearly("attributes.xlsx", 5, |n| book(1, &"a=\"\" ".repeat(n), ""));
    grows_linearly("sheets.xlsx", 40, |n| book(n, "", &row("<c><v>1</v></c>")));
}

#[test]
fn parquet_files() {
    use parquet::data_type::DoubleType;
    use parquet::file::writer::SerializedFileWriter;
    use parquet::schema::parser::parse_message_type;
    let file = |columns: usize, rows: usize, groups: usize| {
        let fields = numbered(columns, "", |k| format!("REQUIRED DOUBLE a{k};"));
        let schema = parse_message_type(&format!("message m {{ {fields} }}")).expect("a schema");
        let mut writer = SerializedFileWriter::new(vec![], schema.into(), Default::default()).expect("a writer");
        for _ in 0..groups {
            let mut group = writer.next_row_group().expect("a group");
            while let Some(mut column) = group.next_column().expect("a column") {
                let values: Vec<f64> = (0..rows).map(|k| k as f64).collect();
                column.typed::<DoubleType>().write_batch(&values, None, None).expect("memory");
                column.close().expect("memory");
            }
            group.close().expect("memory");
        }
        writer.into_inner().expect("memory")
    };
    grows_linearly("rows.parquet", 8, |n| file(1, n, 1));
    grows_linearly("columns.parquet", 200, |n| file(n, 2, 1));
    grows_linearly("groups.parquet", 200, |n| file(1, 2, n));
}
