//! Text: delimited tables and JSON lines.

use std::io::Write;

use super::{answers, refused};

pub(crate) fn zipped(blocks: usize, beginning: &str, block: &str) -> Vec<u8> {
    let mut zipped = flate2::write::GzEncoder::new(vec![], flate2::Compression::fast());
    zipped.write_all(beginning.as_bytes()).expect("memory");
    (0..blocks).for_each(|_| zipped.write_all(block.as_bytes()).expect("memory"));
    zipped.finish().expect("memory")
}

#[test]
fn many_columns_and_long_names_are_refused() {
    let header = vec!["a"; 300_000].join(",");
    let row = vec!["1"; 300_000].join(",");
    let messages = answers("columns.csv", format!("{header}\n{row}\n{row}\n").as_bytes());
    assert!(messages[0].contains("recording.max_bytes"), "{messages:?}");
    let long = "n".repeat(300_000);
    let rows: String = (0..20).map(|k| format!("{k},{k},{k}\n")).collect();
    refused(
        "long.csv",
        format!("time_s,position_m{long},force_n{long}\n{rows}").as_bytes(),
        &["a name of 300010 bytes"],
    );
}

#[test]
fn rows_without_end_are_refused() {
    // The last row with the first time counts, so that none of these rows is kept.
    let repeated = zipped(10, "time_s,position_m,force_n\n", &"0,0,0\n".repeat(100_000));
    let messages = answers("repeated.csv.gz", &repeated);
    assert_eq!(messages.len(), 2, "{messages:?}");
    assert!(messages.iter().all(|message| message.contains("more than 500000 samples")), "{messages:?}");
}

#[test]
fn json_is_neither_deep_nor_wide() {
    let deep = "{\"a\":".repeat(100_000) + "1" + &"}".repeat(100_000) + "\n";
    refused("deep.jsonl", deep.as_bytes(), &["recursion limit"]);
    let wide: Vec<String> = (0..50_000).map(|k| format!("\"a{k}\":1")).collect();
    refused("wide.jsonl", format!("{{{}}}\n", wide.join(",")).as_bytes(), &["more than 1024 numbers"]);
    let long = format!("{{\"{}\":{{\"a\":1}}}}\n", "k".repeat(500_000));
    refused("long.jsonl", long.repeat(2).as_bytes(), &["a name of 500001 bytes"]);
}
