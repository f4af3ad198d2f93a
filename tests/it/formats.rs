//! Recordings as instruments and programs write them: files of their writers, and texts of the same kinds.

use serde_json::Value as Json;

use crate::support::file;
use crate::support::test_folder::TestFolder;

/// The time at which the force falls, in s.
const FALL_S: f64 = 0.7;

/// The force falls by 0.3 N after 0.7 s, as in `tests/data/formats/make.py`.
fn samples() -> impl Iterator<Item = [f64; 3]> {
    (0..1000_u32).map(|k| {
        let time_s = f64::from(k) / 1000.0;
        let position_m = 0.005 * time_s;
        let fallen_n = if time_s > FALL_S { 0.3 } else { 0.0 };
        [time_s, position_m, 120.0 * position_m - fallen_n + 0.0005 * (12.9898 * f64::from(k)).sin()]
    })
}

/// Returns the samples as lines.
fn lines(line: impl Fn([f64; 3]) -> String) -> String {
    samples().map(|sample| line(sample) + "\n").collect()
}

/// Returns the JSON of a detection.
fn detected(folder: &TestFolder, path: &str, flags: &[&str]) -> Json {
    let out = folder.good(&[&["detect", path, "--no-figures", "--json"], flags].concat());
    serde_json::from_str(&out).expect("JSON")
}

/// Checks that the fall, and nothing else, raises an alarm within 10 ms.
fn has_the_fall(detection: &Json, name: &str) {
    let alarms: Vec<f64> =
        detection["alarms"].as_array().expect("alarms").iter().filter_map(|alarm| alarm["time_s"].as_f64()).collect();
    let [alarm_s] = alarms[..] else { panic!("{name}: the alarms are {alarms:?}") };
    assert!((FALL_S..FALL_S + 0.01).contains(&alarm_s), "{name}: the alarm is at {alarm_s} s");
}

fn stored(name: &str) -> String {
    file(&format!("tests/data/formats/{name}")).to_str().expect("a path").to_owned()
}

#[test]
fn files_of_common_writers_are_read() {
    let folder = TestFolder::new();
    let of_matrix: &[&str] = &["--time", "array[:,0]", "--position", "array[:,1]", "--force", "array[:,2]"];
    let of_lists: &[&str] = &["--time", "timestamp:ns", "--position", "state[:,0]", "--force", "state[:,1]"];
    for (name, flags) in [
        ("arrays.npz", &[][..]),
        ("matrix.npy", of_matrix),
        ("records.npy", &["--time", "stamp:ns"]),
        ("zstd.parquet", &[]),
        ("zstd_v2.parquet", &[]),
        ("brotli.parquet", &[]),
        ("lz4.parquet", &[]),
        ("gzip.parquet", &[]),
        ("snappy.parquet", &[]),
        ("lists.parquet", of_lists),
    ] {
        let detection = detected(&folder, &stored(name), flags);
        assert_eq!(detection["samples"], 1000, "{name}");
        has_the_fall(&detection, name);
    }
}

#[test]
fn topics_of_different_rates_are_joined_by_their_log_times() {
    let folder = TestFolder::new();
    for name in ["zstd.mcap", "lz4.mcap"] {
        let detection = detected(&folder, &stored(name), &[]);
        has_the_fall(&detection, name);
        assert_eq!(detection["samples"], 941, "{name}: from 0.05 s to 0.99 s");
        let alarm = &detection["alarms"][0];
        let (time_s, position_m) =
            (alarm["time_s"].as_f64().expect("a time"), alarm["position_m"].as_f64().expect("one"));
        assert!((position_m - 0.005 * time_s).abs() < 1e-6, "{name}: {position_m} m at {time_s} s");
        let note = detection["notes"][0].as_str().expect("a note");
        assert!(note.contains("'/pose.position.z' has its own clock") && note.contains("10.00 ms apart"), "{note}");
        let flags = ["--time", "/wrench.log_time", "--position", "position.z", "--force", "force.z"];
        has_the_fall(&detected(&folder, &stored(name), &flags), name);
    }
}

#[test]
fn other_formats_name_the_remedy() {
    let folder = TestFolder::new();
    folder.file("rig.bag", b"#ROSBAG V2.0\n\x45\0\0\0");
    folder.refused(&["detect", "rig.bag"], &["rig.bag: is a ROS 1 bag", "convert it with `mcap convert "]);
    folder.file("old.xls", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1");
    folder.refused(&["detect", "old.xls"], &["old.xls: is an old Excel spreadsheet", "`pandas.read_excel("]);
    folder.file("text.xls", lines(|[t, x, f]| format!("{t}\t{x}\t{f}")));
    let columns = ["--time", "1", "--position", "2", "--force", "3"];
    has_the_fall(&detected(&folder, "text.xls", &columns), "text named .xls");
}

/// Returns a text for each kind of instrument and program, with the flags of its columns.
fn texts() -> Vec<(&'static str, String, &'static [&'static str])> {
    let comma = |number: f64, digits: usize| format!("{number:.digits$}").replace('.', ",");
    let plain = lines(|[t, x, f]| format!("{t},{x},{f}"));
    let mm = lines(|[t, x, f]| format!("{t},{},{f}", 1e3 * x));
    let bluehill = lines(|[t, x, f]| format!("\"{t:.3}\",\"{:.5}\",\"{f:.5}\"", 1e3 * x));
    let german = lines(|[t, x, f]| format!("{};{};{}", comma(t, 3), comma(1e3 * x, 5), comma(f, 5)));
    let tabs = lines(|[t, x, f]| format!("{t:.4}\t{:.6}\t{f:.5}", 1e3 * x));
    let hysitron = lines(|[t, x, f]| format!("{:.3}\t{:.4}\t{t:.4}", 1e9 * x, 1e6 * f));
    let spaced = lines(|[t, x, f]| format!("  {t:.3}   {x:.8}   {f:.5}"));
    let date = |t: f64, from: &str, to: &str| format!("{from}{:06.3}{to}", t);
    let dated = |from: &'static str, to: &'static str| lines(move |[t, x, f]| format!("{},{x},{f}", date(t, from, to)));
    vec![
        (
            "bluehill",
            format!(
                "General : Start date,\"2024-01-01\"\nSpecimen label,\"A1\"\nMaximum Load,\"2.00\",N\n\nTime,Extension,Load\n(s),(mm),(N)\n{bluehill}"
            ),
            &[],
        ),
        (
            "bluehill in German",
            format!("Allgemein : Datum;01.01.2024\nMax. Kraft;2,00;N\n\nZeit;Weg;Kraft\n(s);(mm);(N)\n{german}"),
            &[],
        ),
        (
            "zwick",
            format!(
                "\"Prüfprotokoll\"\n\"Prüfer\";\"AB\"\n\"Vorkraft\";0,1;\"N\"\n\n\"Prüfzeit\";\"Standardweg\";\"Standardkraft\"\n\"s\";\"mm\";\"N\"\n{german}"
            ),
            &[],
        ),
        (
            "mts",
            format!(
                "MTS793|BTW|ENU|1|2|.|/|:|1|0|0|A\n\nData Header:\t\tTime:\t10.5\tSec\t01/01/2024\nData Acquisition\t\tTimed\n\nTime\tAxial Displacement\tAxial Force\nSec\tmm\tN\n{tabs}"
            ),
            &[],
        ),
        (
            "hysitron",
            format!(
                "File: a.hys\r\nApproach\t12\r\nNumber of Points = 1000\r\n\r\nDepth (nm)\tLoad (µN)\tTime (s)\r\n{hysitron}"
            ),
            &[],
        ),
        (
            "mecmesin",
            format!("Mecmesin VectorPro\nSample,1\nRate,1000,Hz\nTime (s),Displacement (mm),Load (N)\n{mm}"),
            &[],
        ),
        (
            "labview",
            format!(
                "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\n***End_of_Header***\t\n\t\nChannels\t2\t\t\nY_Unit_Label\tmm\tN\t\nX0\t0\t0\t\nDelta_X\t0.001\t0.001\t\n***End_of_Header***\t\t\t\nX_Value\tposition\tforce\tComment\n{tabs}"
            ),
            &[],
        ),
        ("text of labview without a header", tabs.clone(), &["--time", "1", "--position", "2:mm", "--force", "3"]),
        (
            "a preamble of 3000 lines",
            format!("{}time,position,force\ns,mm,N\n{mm}", "a remark of the operator\n".repeat(3000)),
            &[],
        ),
        (
            "a calibration table in the preamble",
            format!("gain,offset\n1.0,0.1\n1.1,0.2\n1.2,0.3\n\nt,x,f\nsec,mm,N\n{mm}"),
            &[],
        ),
        ("spaces without names", spaced, &["--time", "1", "--position", "2", "--force", "3"]),
        ("names in quotes with units after a slash", format!("\"Time/s\";\"Position/mm\";\"Force/N\"\n{german}"), &[]),
        (
            "names that occur twice",
            format!("time,value,value\n{plain}"),
            &["--time", "time", "--position", "2", "--force", "3"],
        ),
        ("a first time that occurs twice", format!("Time (sec),Position (mm),Force (N)\n0,0,0\n{mm}"), &[]),
        (
            "milliseconds",
            format!("t (ms),x (mm),f (N)\n{}", lines(|[t, x, f]| format!("{},{},{f}", 1e3 * t, 1e3 * x))),
            &[],
        ),
        (
            "microseconds of a controller",
            format!(
                "micros,pos_um,load_mN\n{}",
                lines(|[t, x, f]| format!("{},{},{}", (1e6 * t).round(), 1e6 * x, 1e3 * f))
            ),
            &["--time", "micros:us", "--position", "pos_um:um", "--force", "load_mN:mN"],
        ),
        (
            "Unix times in milliseconds",
            format!(
                "timestamp_ms,position_m,force_n\n{}",
                lines(|[t, x, f]| format!("{},{x},{f}", 1_767_225_600_000.0 + (1e3 * t).round()))
            ),
            &[],
        ),
        (
            "Unix times in nanoseconds",
            format!(
                "timestamp_ns,position_m,force_n\n{}",
                lines(|[t, x, f]| format!("{}000000,{x},{f}", 1_767_225_600_000_u64 + (1e3 * t).round() as u64))
            ),
            &[],
        ),
        ("dates without a zone", format!("timestamp,position_m,force_n\n{}", dated("2026-01-01 10:00:", "")), &[]),
        ("dates in UTC", format!("timestamp,position_m,force_n\n{}", dated("2026-01-01T10:00:", "Z")), &[]),
        ("times of the day", format!("time,position_m,force_n\n{}", dated("10:00:", "")), &[]),
        (
            "a scale in grams",
            format!("time_s,position_m,load_g\n{}", lines(|[t, x, f]| format!("{t},{x},{}", f / 9.80665e-3))),
            &[],
        ),
        (
            "an axis that counts down",
            format!("time_s,z_mm,force_n\n{}", lines(|[t, x, f]| format!("{t},{},{}", 1e3 * (0.1 - x), -f))),
            &["--time", "time_s", "--position", "z_mm:-mm+100mm", "--force", "force_n:-1"],
        ),
        (
            "the start of the motion as zero",
            format!("time_s,z_m,force_n\n{}", lines(|[t, x, f]| format!("{t},{},{f}", 0.1 - x))),
            &["--time", "time_s", "--position", "z_m:-1", "--force", "force_n", "--zero-at-start"],
        ),
        ("no time", format!("position_m,force_n\n{}", lines(|[_, x, f]| format!("{x},{f}"))), &["--rate", "1kHz"]),
        (
            "a wrench and a pose in one table",
            format!(
                "time,pose.position.x,pose.position.z,wrench.force.x,wrench.force.z,wrench.torque.z\n{}",
                lines(|[t, x, f]| format!("{t},0.4,{x},0,{f},{}", 0.01 * f))
            ),
            &[],
        ),
        (
            "UTF-16 of Excel",
            format!("\u{feff}Zeit [s]\tWeg [mm]\tKraft [N]\r\n{}", tabs.replace('\n', "\r\n").replace('.', ",")),
            &[],
        ),
        ("two lines to skip", format!("1,2,3\n4,5,6\ntime_s,position_m,force_n\n{plain}"), &["--skip-lines", "2"]),
    ]
}

#[test]
fn texts_of_instruments_and_programs_are_read() {
    let folder = TestFolder::new();
    for (name, text, flags) in texts() {
        let bytes = match text.strip_prefix('\u{feff}') {
            Some(_) => text.encode_utf16().flat_map(u16::to_le_bytes).collect(),
            None => text.into_bytes(),
        };
        folder.file("lab.txt", bytes);
        let detection = detected(&folder, "lab.txt", flags);
        has_the_fall(&detection, name);
        assert_eq!(detection["samples"], 1000, "{name}");
    }
}

#[test]
fn json_lines_are_read_with_their_nested_numbers_and_dates() {
    let folder = TestFolder::new();
    folder.file("plain.jsonl", lines(|[t, x, f]| format!("{{\"time_s\":{t},\"position_m\":{x},\"force_n\":{f}}}")));
    has_the_fall(&detected(&folder, "plain.jsonl", &[]), "plain");
    let nested = |[t, x, f]: [f64; 3]| {
        format!("{{\"stamp\":\"2026-01-01T00:00:{t:06.3}Z\",\"pose\":{{\"z\":{x}}},\"force\":[0,0,{f}]}}")
    };
    folder.file("nested.jsonl", lines(nested));
    let flags = ["--time", "stamp", "--position", "pose.z", "--force", "force[2]"];
    has_the_fall(&detected(&folder, "nested.jsonl", &flags), "nested");
    folder.file("cut.jsonl", "{\"time_s\":0}\n{\"time_s\":");
    folder.refused(&["detect", "cut.jsonl"], &["cut.jsonl line 2: is a file of JSON lines that cannot be read"]);
}

#[test]
fn a_column_in_another_unit_is_not_read_in_silence() {
    let folder = TestFolder::new();
    folder.file("scale.csv", format!("time_s,position_m,load_g\n{}", lines(|[t, x, f]| format!("{t},{x},{f}"))));
    let columns = ["--time", "time_s", "--position", "position_m", "--force", "load_g"];
    let outcome = folder.trocar(&[&["detect", "scale.csv", "--no-figures"], &columns[..]].concat());
    assert!(outcome.err.contains("warning[unit-ignored]") && outcome.err.contains("load_g:gf"), "{}", outcome.err);
    folder.file("rows.csv", format!("t,x,f\ns,mm,N\n{}", lines(|[t, x, f]| format!("{t},{},{f}", 1e3 * x))));
    let outcome =
        folder.trocar(&["detect", "rows.csv", "--time", "t", "--position", "x", "--force", "f", "--no-figures"]);
    assert!(outcome.err.contains("x:mm"), "{}", outcome.err);
}

#[test]
fn a_torque_is_never_a_position() {
    let folder = TestFolder::new();
    let path = stored("torque_named_z.csv.gz");
    folder.refused(&["detect", &path], &["no column 'position_m'", "--position time:0.005"]);
    let flags = ["--time", "time", "--position", "time:0.005", "--force", "force"];
    let detection = detected(&folder, &path, &flags);
    let alarms = detection["alarms"].as_array().expect("alarms");
    assert!(alarms.iter().any(|alarm| alarm["time_s"].as_f64().is_some_and(|time_s| (3.0..3.01).contains(&time_s))));
    let listed = folder.good(&["detect", &path, "--list", "--json"]);
    let listed: Json = serde_json::from_str(&listed).expect("JSON");
    assert_eq!(listed["signals"][1]["name"], "torque_z");
    assert_eq!(listed["signals"][1]["role"], Json::Null);
}

#[test]
fn a_break_between_the_samples_of_the_median_rate_is_found() {
    let folder = TestFolder::new();
    let detection = detected(&folder, &stored("dense_at_the_break.csv.gz"), &[]);
    let alarms = detection["alarms"].as_array().expect("alarms");
    let last = alarms.last().and_then(|alarm| alarm["time_s"].as_f64()).expect("an alarm");
    assert!((30.0..30.01).contains(&last), "{last}");
    let note = detection["notes"][0].as_str().expect("a note");
    assert!(note.contains("which keeps the course of the densest part"), "{note}");
}

#[test]
fn a_preamble_is_listed_and_read() {
    let folder = TestFolder::new();
    let path = stored("preamble.csv");
    let listed = folder.good(&["detect", &path, "--list"]);
    assert!(listed.ends_with("--time Time:s --position Extension:mm --force Load:N\n"), "{listed}");
    assert_eq!(detected(&folder, &path, &[])["samples"], 4);
}

#[test]
fn tests_of_a_tensile_machine_are_read() {
    let folder = TestFolder::new();
    for name in ["mecmesin_2.csv.gz", "mecmesin_7.csv.gz"] {
        let detection = detected(&folder, &stored(name), &[]);
        assert!((detection["interval_s"].as_f64().expect("an interval") - 0.0012).abs() < 1e-9, "{name}");
    }
}

#[test]
fn a_list_without_a_signal_says_why() {
    let folder = TestFolder::new();
    folder.file("words.csv", "name,remark\na,b\nc,d\n");
    folder.refused(&["detect", "words.csv", "--list"], &["no column has a number"]);
    folder.file("empty.csv", "t,x,f\n");
    folder.refused(&["detect", "empty.csv", "--list"], &["a header but no samples"]);
}

#[test]
fn bombs_and_damaged_files_are_refused() {
    use std::io::Write as _;
    let folder = TestFolder::new();
    let mut bomb = flate2::write::GzEncoder::new(vec![], flate2::Compression::best());
    bomb.write_all(b"time_s,position_m,force_n\n").expect("written");
    (0..300).for_each(|_| bomb.write_all(&vec![b'\n'; 1 << 20]).expect("written"));
    folder.file("bomb.csv.gz", bomb.finish().expect("written"));
    folder.refused(&["detect", "bomb.csv.gz"], &["holds more than 256.0 MiB"]);
    for name in ["arrays.npz", "zstd.mcap", "lz4.mcap"] {
        let limit = format!("recording.max_bytes={}", std::fs::metadata(stored(name)).expect("there").len());
        folder.refused(&["detect", &stored(name), "--set", &limit], &["holds more than", "recording.max_bytes"]);
    }
    for name in ["arrays.npz", "zstd.mcap", "lz4.mcap", "zstd.parquet", "brotli.parquet"] {
        let whole = std::fs::read(stored(name)).expect("there");
        for share in [0.1, 0.5, 0.9] {
            let cut = &whole[..(share * whole.len() as f64) as usize];
            folder.file("cut", cut);
            assert_eq!(folder.trocar(&["detect", "cut"]).code, 2, "{name} cut to {share}");
            let mut flipped = whole.clone();
            let at = cut.len();
            flipped[at..at + 24].iter_mut().for_each(|byte| *byte ^= 0x5a);
            folder.file("flipped", flipped);
            let outcome = folder.trocar(&["detect", "flipped", "--no-figures"]);
            assert!([0, 2].contains(&outcome.code) && !outcome.err.contains("panicked"), "{name}: {}", outcome.err);
        }
    }
}

#[test]
fn a_long_detection_is_parquet_and_its_size_is_told() {
    let folder = TestFolder::new();
    let rows: String =
        (0..1_000_001).map(|k| format!("{}\n", if k % 1000 < 500 { "0.01,1" } else { "0.01,1.1" })).collect();
    folder.file("long.csv", format!("position_m,force_n\n{rows}"));
    let out = folder.good(&["detect", "long.csv", "--rate", "1000", "--no-figures"]);
    assert!(out.contains("detection.parquet: 1000001 rows, ") && out.trim_end().ends_with(" MB"), "{out}");
    assert!(!folder.path("out/long/detection.csv").exists());
}
