//! Recordings in files of arrays: a real file from MATLAB, trocar's own files, damaged files, and lists of signals.

use proptest::prelude::*;
use serde_json::Value as Json;

use trocar::recording::{Columns, Limits, open_recording};

use crate::support::file;
use crate::support::test_folder::TestFolder;

/// The shipped recording in the file that MATLAB wrote, and its columns.
const REAL: &str = "tests/data/teleop_1dof/own_ctrl_pop.mat";
const REAL_COLUMNS: [&str; 6] = [
    "--time",
    "scope.time",
    "--position",
    "scope.signals[0].values[:,1]:0.075",
    "--force",
    "scope.signals[1].values[:,0]:13.333333333333334",
];

fn json(text: &str) -> Json {
    serde_json::from_str(text).expect("JSON")
}

/// Returns a folder with a short run in every format of columns, and the flags of its columns.
fn traces() -> (TestFolder, [&'static str; 6]) {
    let folder = TestFolder::new();
    let scenario =
        "name = \"short\"\noperator.kind = \"ramp\"\ntissue.kind = \"kelvin-voigt\"\nsimulation.duration_s = 0.5\n";
    folder.file("short.toml", scenario);
    folder.good(&["run", "short.toml", "--quiet", "--format", "csv,mat,parquet"]);
    (folder, ["--time", "time_s", "--position", "slave_position_m", "--force", "tissue_force_n"])
}

#[test]
fn scope_signals_of_a_real_rig_agree_with_the_csv_file() {
    let column = |text: &str| text.parse().expect("a column");
    let open = |path: &str, time: &str, position: &str, force: &str| {
        let columns = Columns { time: column(time), position: column(position), velocity: None, force: column(force) };
        open_recording(&file(path), &columns, &Limits::default()).expect(path)
    };
    let scopes = open(REAL, "scope.time", "scope.signals[0].values[:,1]", "scope.signals[0].values[:,0]");
    let table = open("scenarios/recordings/own_ctrl_pop.csv", "t_s", "xs_rad", "xm_rad");
    assert_eq!(scopes.len(), table.len());
    // The table has five decimals, and its clock starts at 0.
    let start_s = scopes.time_s()[0];
    for sample in 0..table.len() {
        assert!((scopes.time_s()[sample] - start_s - table.time_s()[sample]).abs() < 1e-9, "{sample}");
        assert!((scopes.position_m()[sample] - table.position_m()[sample]).abs() < 5.001e-6, "{sample}");
        assert!((scopes.force_n()[sample] - table.force_n()[sample]).abs() < 5.001e-6, "{sample}");
    }
    let folder = TestFolder::new();
    let real = file(REAL);
    let recording = real.to_str().expect("a path");
    let arguments = [&["detect", recording], &REAL_COLUMNS[..], &["--no-figures"]].concat();
    let printed = folder.good(&arguments);
    assert!(printed.starts_with("own_ctrl_pop: 5810 samples over 2.905 s"), "{printed}");
}

#[test]
fn a_trace_in_any_format_gives_the_same_bytes() {
    let (folder, columns) = traces();
    let of = |format: &str| {
        let (input, out) = (format!("out/short/trace.{format}"), format!("of-{format}"));
        folder.good(&[&["detect", &input], &columns[..], &["--quiet", "--no-figures", "--out", &out]].concat());
        folder.text(&format!("{out}/trace/detection.csv"))
    };
    let of_csv = of("csv");
    assert!(of_csv.lines().count() > 400);
    for format in ["mat", "parquet"] {
        assert!(of(format) == of_csv, "{format}");
    }
    folder.good(&[&["detect", "out/short/trace.mat"], &columns[..], &["--quiet", "--format", "parquet"]].concat());
    assert!(folder.path("out/trace/detection.parquet").exists() && !folder.path("out/trace/detection.csv").exists());
}

#[test]
fn a_list_has_the_names_and_the_command_line() {
    let folder = TestFolder::new();
    folder.file("lab.csv", "t;x;f\nms;mm;N\n0;1,5;2\n1;1,6;2,5\n2;1,7;3\n");
    let listed = folder.good(&["detect", "lab.csv", "--list"]);
    assert!(listed.ends_with("trocar detect lab.csv --time t:ms --position x:mm --force f:N\n"), "{listed}");
    let listed = json(&folder.good(&["detect", "lab.csv", "--list", "--json"]));
    assert_eq!(listed["signals"][1]["max"], 1.7);
    assert_eq!(listed["signals"][2]["role"], "force");
    assert_eq!(listed["signals"][2]["rate_hz"], 1000.0);
    let listed = folder.good(&["detect", file(REAL).to_str().expect("a path"), "--list"]);
    for phrase in ["scope.signals[0].values[:,1]", "5810 x 2", "rad", "2000 Hz", "Lever positions"] {
        assert!(listed.contains(phrase), "no {phrase} in {listed}");
    }
    assert!(!folder.path("out").exists(), "a list writes nothing");
}

#[test]
fn columns_are_guessed_only_if_one_signal_fits_each_and_with_a_warning() {
    let folder = TestFolder::new();
    let rows: String = (0..400).map(|k| format!("{k};{};{}\n", 0.01 * f64::from(k), 0.03 * f64::from(k))).collect();
    folder.file("lab.csv", format!("t (ms);x (mm);f (N)\n{rows}"));
    let warned = folder.warned(&["detect", "lab.csv", "--no-figures"]);
    let expected = "warning[guessed-columns]: lab.csv: the columns are guessed: --time t (ms):ms";
    assert!(warned.starts_with(expected), "{warned}");
    folder.good(&["calibrate", "lab.csv", "--help"]);
    assert_eq!(folder.trocar(&["detect", "lab.csv", "--no-figures", "--deny-warnings"]).code, 1);
    folder.refused(
        &["detect", "lab.csv", "--force", "f (N)"],
        &["no column 'time_s' (--time or", "the file has t (ms), x (mm), f (N)"],
    );
    let doubled = |row: &str| format!("{row};{}\n", row.rsplit(';').next().expect("a field"));
    let doubled: String = rows.lines().map(doubled).collect();
    folder.file("two.csv", format!("t;x (mm);f1 (N);f2 (N)\n{doubled}"));
    folder.refused(
        &["detect", "two.csv"],
        &["no column 'force_n' (--force or", "the file has t, x (mm), f1 (N), f2 (N)"],
    );
}

#[test]
fn a_recording_has_its_operating_characteristic_with_flags() {
    let folder = TestFolder::new();
    let real = file(REAL);
    let arguments = [
        &["roc", real.to_str().expect("a path")],
        &REAL_COLUMNS[..],
        &["--rupture-s", "1.779", "--seeds", "1", "--thresholds", "2", "--quiet", "--detectors", "squared-residual"],
    ]
    .concat();
    folder.good(&arguments);
    assert!(folder.text("out/roc/roc.csv").contains("own_ctrl_pop"));
    folder.refused(&["roc", "a.csv", "b.csv", "--rupture-s", "1"], &["--rupture-s labels a single recording"]);
}

#[test]
fn label_files_in_the_folder_are_not_recordings() {
    let folder = TestFolder::new();
    let rows: String = (0..400)
        .map(|k| format!("{},{},{}\n", 1e-3 * f64::from(k), 1e-5 * f64::from(k), 0.03 * f64::from(k)))
        .collect();
    folder.file("trials/a.csv", format!("time_s,position_m,force_n\n{rows}"));
    folder.file("trials/truth.csv", "file,time_s\na.csv,0.2\n");
    let listed = folder.good(&["detect", "trials", "--labels", "trials/truth.csv", "--no-figures"]);
    assert!(!listed.contains("truth"), "{listed}");
    assert!(!folder.path("out/truth").exists());
    assert_eq!(
        folder.trocar(&["detect", "trials", "--no-figures"]).code,
        2,
        "without --labels it is a file like any other"
    );
}

/// Reads damaged content as a recording. A panic ends with another exit code.
fn is_refused_or_read(folder: &TestFolder, name: &str, content: &[u8], columns: &[&str]) -> Result<(), TestCaseError> {
    folder.file(name, content);
    for arguments in [[&["detect", name, "--quiet", "--no-figures"], columns].concat(), vec!["detect", name, "--list"]]
    {
        let outcome = folder.trocar(&arguments);
        prop_assert!([0, 2].contains(&outcome.code), "{} {}", outcome.code, outcome.err);
        prop_assert!(!outcome.err.contains("panicked"), "{}", outcome.err);
    }
    Ok(())
}

#[test]
fn damaged_files_are_errors() {
    let (folder, columns) = traces();
    for format in ["mat", "parquet"] {
        let content = std::fs::read(folder.path(&format!("out/short/trace.{format}"))).expect("there");
        let name = format!("bad.{format}");
        let mut runner = proptest::test_runner::TestRunner::new(ProptestConfig::with_cases(40));
        let damage = (0..content.len(), 0..300_usize, any::<u8>(), any::<bool>());
        let outcome = runner.run(&damage, |(at, near, byte, is_cut)| {
            let mut damaged = content.clone();
            damaged[near] ^= byte;
            damaged[at] = byte;
            if is_cut {
                damaged.truncate(at);
            }
            is_refused_or_read(&folder, &name, &damaged, &columns)
        });
        outcome.expect(format);
    }
    let whole = std::fs::read(folder.path("out/short/trace.mat")).expect("there");
    folder.file("cut.mat", &whole[..whole.len() / 2]);
    folder.refused(
        &[&["detect", "cut.mat"], &columns[..]].concat(),
        &["cut.mat: is a MATLAB file that cannot be read: it is cut off; write it again"],
    );
    // An array that claims 2^31 rows.
    let mut large = whole.clone();
    large[128 + 8 + 16 + 8..128 + 8 + 16 + 12].copy_from_slice(&i32::MAX.to_le_bytes());
    folder.file("large.mat", &large);
    folder
        .refused(&[&["detect", "large.mat"], &columns[..]].concat(), &["the sizes of an array contradict each other"]);
}
