//! `trocar detect -`: a live stream on standard input.

use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use crate::support::test_folder::TestFolder;
use serde_json::Value as Json;

/// Time limit for a test that waits on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

const VELOCITY: [&str; 2] = ["--velocity", "velocity_m_per_s"];

fn insertion() -> String {
    trocar::recording::in_vivo_like_csv(1)
}

/// A stream that a test writes and reads.
struct Rig {
    child: Child,
    input: Option<ChildStdin>,
    lines: Receiver<String>,
    errors: Receiver<String>,
}

/// Returns the lines of a pipe as they arrive.
fn lines(pipe: impl Read + Send + 'static) -> Receiver<String> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        for line in BufReader::new(pipe).lines() {
            let Ok(line) = line else { return };
            if sender.send(line).is_err() {
                return;
            }
        }
    });
    receiver
}

impl Rig {
    fn start(arguments: &[&str]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_trocar"))
            .args(["detect", "-"])
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("started");
        let input = child.stdin.take();
        let lines_out = lines(child.stdout.take().expect("a pipe"));
        let errors = lines(child.stderr.take().expect("a pipe"));
        Self { child, input, lines: lines_out, errors }
    }

    fn feed(&mut self, text: &str) {
        let input = self.input.as_mut().expect("open");
        input.write_all(text.as_bytes()).and_then(|()| input.flush()).expect("fed");
    }

    fn line(&self) -> String {
        self.lines.recv_timeout(PATIENCE).expect("a line in time")
    }

    fn end(mut self) -> (i32, Vec<String>, Vec<String>) {
        drop(self.input.take());
        let code = self.child.wait().expect("ended").code().unwrap_or(-1);
        (code, self.lines.iter().collect(), self.errors.iter().collect())
    }

    fn signal(&self, name: &str) {
        let id = self.child.id().to_string();
        assert!(Command::new("kill").args([name, &id]).status().expect("kill").success());
    }

    /// Returns the peak memory, in kB.
    #[cfg(target_os = "linux")]
    fn peak_kb(&self) -> u64 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.child.id())).expect("there");
        let line = status.lines().find(|line| line.starts_with("VmHWM:")).expect("a peak");
        line.split_whitespace().nth(1).and_then(|kb| kb.parse().ok()).expect("a number")
    }
}

fn json(text: &str) -> Json {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

#[test]
fn an_evenly_sampled_stream_gives_the_alarms_of_its_file_bit_for_bit() {
    let folder = TestFolder::new();
    let root = env!("CARGO_MANIFEST_DIR");
    let lever = std::fs::read_to_string(format!("{root}/scenarios/recordings/own_ctrl_pop.csv")).expect("there");
    folder.file("insertion.csv", insertion()).file("lever.csv", &lever);
    let lever_columns = ["--time", "t_s", "--position", "xs_rad:0.075", "--force", "env_out_Nm_derived:13.333333"];
    let lever_contact = ["--contact-m", "0.0063"];
    let filtered = ["--set", "sensor.position_resolution_m=1e-6"];
    let cases: [(&str, Vec<&str>, usize); 4] = [
        ("insertion.csv", VELOCITY.to_vec(), 2),
        ("insertion.csv", filtered.to_vec(), 2),
        ("lever.csv", [&lever_columns[..], &lever_contact, &["--velocity", "vs_rad_s:0.075"]].concat(), 1),
        ("lever.csv", [&lever_columns[..], &lever_contact, &filtered].concat(), 1),
    ];
    for (file, flags, expected) in cases {
        let stem = file.strip_suffix(".csv").expect("a name");
        folder.good(&[&["detect", file, "--no-figures", "--quiet"], &flags[..]].concat());
        // The texts are compared, so every digit counts.
        let stored = folder.text(&format!("out/{stem}/detection.json"));
        let interval = stored.lines().find_map(|line| line.trim().strip_prefix("\"interval_s\": ")).expect("there");
        let mut all = vec!["detect", "-", "--interval-s", interval.trim_end_matches(',')];
        all.extend(&flags);
        let streamed = folder.fed(&all, &std::fs::read(folder.path(file)).expect("there"));
        assert_eq!(streamed.code, 0, "{}", streamed.err);
        let numbers = |row: &str, columns: &[usize]| {
            let cells: Vec<&str> = row.split(',').collect();
            columns.iter().map(|&column| cells[column].to_owned()).collect::<Vec<_>>()
        };
        // The columns are time, sample, position, depth, force and residual.
        let live: Vec<_> = streamed.out.lines().skip(1).map(|row| numbers(row, &[1, 2, 3, 4, 6, 7])).collect();
        let events = folder.text(&format!("out/{stem}/events.csv"));
        let stored: Vec<_> = events.lines().skip(1).map(|row| numbers(row, &[2, 3, 4, 5, 6, 7])).collect();
        assert_eq!((live.len(), &live), (expected, &stored), "{file} {flags:?}");
    }
}

#[test]
fn an_alarm_is_printed_before_the_next_sample_arrives() {
    let mut rig = Rig::start(&VELOCITY);
    assert!(rig.line().starts_with("event,time_s,sample,position_m"), "the header comes at once");
    let text = insertion();
    let all: Vec<&str> = text.lines().collect();
    // Send the header and samples 0 to 5527, the sample of the alarm, and then nothing.
    rig.feed(&(all[..=5528].join("\n") + "\n"));
    assert!(rig.line().starts_with("alarm,5.527,5527,"));
    rig.feed(&(all[5529..].join("\n") + "\n"));
    assert!(rig.line().starts_with("alarm,8.86,8860,"));
    let (code, rest, errors) = rig.end();
    assert_eq!((code, rest.len()), (0, 0));
    let errors = errors.join(" ");
    assert!(
        errors.contains("17000 samples 1.000 ms apart over 17.00 s")
            && errors.contains("2 alarms; ended by end of input"),
        "{errors}"
    );
}

#[test]
fn a_signal_ends_the_stream_with_the_results_so_far() {
    for signal in ["-INT", "-TERM"] {
        let mut rig = Rig::start(&[&VELOCITY[..], &["--json"]].concat());
        let text = insertion();
        rig.feed(&(text.lines().take(6001).collect::<Vec<_>>().join("\n") + "\n6.0,0.0283"));
        assert_eq!(json(&rig.line())["event"], "alarm");
        // The input stays open, so the command waits for the rest of the line.
        rig.signal(signal);
        let summary = json(&rig.line());
        assert_eq!((&summary["event"], &summary["ended"]), (&Json::from("summary"), &Json::from("signal")));
        assert_eq!((&summary["alarms"], &summary["skipped_rows"]), (&Json::from(1), &Json::from(0)));
        let (code, rest, _) = rig.end();
        assert_eq!((code, rest.len()), (0, 0), "{signal}");
    }
}

#[test]
fn a_closed_reader_ends_the_stream_without_an_error() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_trocar"))
        .args(["detect", "-", "--every", "1"])
        .args(VELOCITY)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("started");
    let mut input = child.stdin.take().expect("a pipe");
    let mut first = String::new();
    BufReader::new(child.stdout.take().expect("a pipe")).read_line(&mut first).expect("the header");
    // The command ends at its next row, because the reader is closed; then writing fails.
    let _ = input.write_all(insertion().as_bytes());
    let output = child.wait_with_output().expect("ended");
    assert!(output.status.success());
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
}

#[test]
fn bad_rows_are_skipped_reported_and_counted() {
    let folder = TestFolder::new();
    let text = insertion();
    let mut rows: Vec<String> = text.lines().map(str::to_owned).collect();
    for (at, row) in [
        (9000, "junk"),
        (8000, "7.9985,0.03,nan,2"),
        (7000, "6.9985,0.03,0.01,inf"),
        (6000, "5,0.03,0.01,2"),
        (5000, "4.9985,1e9,0.01,2"),
        (4000, "3.9985,,0.01,2"),
        (3000, "2.9985,0.01,0.01,\u{b5}"),
    ] {
        rows.insert(at, row.to_owned());
    }
    let flags = [&["detect", "-", "--json", "--interval-s", "0.001", "--every", "1"], &VELOCITY[..]].concat();
    let outcome = folder.fed(&flags, (rows.join("\n")).as_bytes());
    assert_eq!(outcome.code, 0, "{}", outcome.err);
    assert!(!outcome.out.contains("NaN") && !outcome.out.contains("inf"), "no such number gets in");
    let all: Vec<Json> = outcome.out.lines().map(json).collect();
    let alarms: Vec<&Json> = all.iter().filter(|row| row["event"] == "alarm").map(|row| &row["sample"]).collect();
    assert_eq!(alarms, [5527, 8860]);
    let summary = all.last().expect("a summary");
    assert_eq!((&summary["rows"], &summary["skipped_rows"]), (&Json::from(17007), &Json::from(7)));
    assert_eq!((&summary["samples"], &summary["not_later"]), (&Json::from(17000), &Json::from(1)));
    for place in ["standard input line 3001, column 'force_n'", "line 4002, column 'position_m': the field is empty"] {
        assert!(outcome.err.contains(place), "{}", outcome.err);
    }

    let flood = text.clone() + &"what\n".repeat(100_000);
    let outcome = folder.fed(&[&["detect", "-"], &VELOCITY[..]].concat(), flood.as_bytes());
    assert_eq!(outcome.code, 0);
    let warnings = outcome.err.lines().filter(|line| line.starts_with("warning:")).count();
    assert!(warnings < 1000 && outcome.err.contains("more warnings suppressed"), "{warnings}");
    assert!(outcome.err.contains("100000 malformed"), "{}", outcome.err);
    let quiet = folder.fed(&[&["detect", "-", "--quiet"], &VELOCITY[..]].concat(), flood.as_bytes());
    assert_eq!((quiet.code, quiet.err.as_str(), quiet.out.lines().count()), (0, "", 3));
}

#[test]
fn the_detector_restarts_after_a_lost_second_but_not_after_a_few_lost_samples() {
    let folder = TestFolder::new();
    let text = insertion();
    let kept: Vec<&str> =
        text.lines().enumerate().filter(|(at, _)| !(6001..7001).contains(at)).map(|(_, l)| l).collect();
    let outcome = folder.fed(&[&["detect", "-", "--json"], &VELOCITY[..]].concat(), kept.join("\n").as_bytes());
    let summary = json(outcome.out.lines().last().expect("a summary"));
    assert_eq!((&summary["restarts"], &summary["interpolated"]), (&Json::from(1), &Json::from(0)));
    assert!(outcome.err.contains("no sample from 5.999 s to 7 s"), "{}", outcome.err);
    assert_eq!(outcome.out.lines().count(), 3, "both ruptures and the summary: {}", outcome.out);

    let kept: Vec<&str> = text.lines().enumerate().filter(|(at, _)| at % 50 != 30).map(|(_, l)| l).collect();
    let outcome = folder.fed(&[&["detect", "-", "--json"], &VELOCITY[..]].concat(), kept.join("\n").as_bytes());
    let summary = json(outcome.out.lines().last().expect("a summary"));
    assert_eq!((&summary["restarts"], &summary["interpolated"]), (&Json::from(0), &Json::from(340)));
    assert_eq!((&summary["alarms"], &summary["samples"]), (&Json::from(2), &Json::from(17000)));
}

#[test]
fn a_stream_that_cannot_be_used_is_refused() {
    let folder = TestFolder::new();
    let refused = |input: &str, arguments: &[&str], phrase: &str| {
        let outcome = folder.fed(&[&["detect", "-"], arguments].concat(), input.as_bytes());
        assert_eq!(outcome.code, 2, "{input:?}: {}", outcome.err);
        assert!(outcome.err.contains(phrase), "{input:?}: {}", outcome.err);
    };
    refused("", &[], "0 rows without the two usable samples");
    refused("time_s,position_m,force_n\n", &[], "0 rows without the two usable samples");
    refused("time_s,position_m,force_n\n0,0,0\n", &[], "1 row without the two usable samples");
    refused("time_s,position_m,force_n\n0,x,0\nc,d,e\n", &[], "2 rows without the two usable samples");
    refused("time,position_m,force_n\n0,0,0\n", &[], "no column 'time_s'");
    refused("0,0,0\n", &[], "numbers where the columns' names are expected");
    refused("", &["--interval-s", "0"], "--interval-s is 0");
    refused("", &["--interval-s", "nan"], "--interval-s");
    refused("", &["--set", "detector.cap=1e-9"], "detector.cap");
    refused("", &["--every", "0"], "--every");
    refused("", &["--report"], "--report");
    assert!(folder.files("").is_empty(), "a stream writes no file");
    let one = folder.fed(&["detect", "-", "--interval-s", "0.001", "--json"], b"time_s,position_m,force_n\n0,0,0\n");
    assert_eq!((one.code, &json(&one.out)["samples"]), (0, &Json::from(1)), "with an interval one sample is one");
}

/// 600 000 rows; the peak memory hardly grows after the first 20 000.
#[cfg(target_os = "linux")]
#[test]
fn memory_of_a_stream_is_constant() {
    let mut rig = Rig::start(&["--every", "20000", "--interval-s", "0.001", "--json", "--velocity", "v"]);
    rig.feed("time_s,position_m,force_n,v\n");
    let mut early = 0;
    for block in 0..30_u32 {
        let mut text = String::with_capacity(2 << 20);
        for k in block * 20_000..(block + 1) * 20_000 {
            let t = f64::from(k) * 1e-3;
            let phase = t.fract();
            // Oscillate through a layer that ruptures twice a second, so that there are alarms and warnings.
            let force = if phase < 0.5 { 8.0 * phase } else { 0.1 };
            text.push_str(&format!("{t:.3},{:.5},{force:.4},0.01\n", 0.01 + 0.01 * phase));
            if k % 1000 == 77 {
                text.push_str("not,a,row\n");
            }
        }
        rig.feed(&text);
        loop {
            let row = json(&rig.line());
            if row["event"] == "sample" {
                assert_eq!(row["sample"], block * 20_000);
                break;
            }
        }
        if block == 1 {
            early = rig.peak_kb();
        }
    }
    let late = rig.peak_kb();
    let (code, rest, _) = rig.end();
    let summary = json(rest.last().expect("a summary"));
    assert_eq!((code, &summary["samples"]), (0, &Json::from(600_000)));
    assert!(summary["alarms"].as_u64().is_some_and(|alarms| alarms > 100), "{summary}");
    assert!(late < early + 1024, "{early} kB after 20 000 rows, {late} kB after 580 000");
    assert!(late < 64 << 10, "{late} kB");
}
