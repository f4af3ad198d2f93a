//! Sweeps on the command line: identical files for any threads, shards and interruptions; and invalid sweeps.

use crate::support;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::process::{Child, Command};
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use crate::support::test_folder::{TestFolder, words};
use trocar::run::measure;
use trocar::scenario::Source;
use trocar::sweep::{Execution, Part, Plan, Progress, Rows, Shard, execute};

/// Three axes and three seeds, on a short insertion into layers with noise and one or two events.
const SMALL: &str = r#"
base = "builtin:layers/skin-augmented.toml"
seeds = 3
metrics = ["detected_ruptures", "max_slave_overshoot_m", "tracking_rmse_m", "rupture_1_detection_delay_s", "port_needle_energy_j"]
[set]
simulation.duration_s = 3.5
[axes]
scaling.force = { from = 0.5, to = 2.0, points = 3 }
augmentation.reengage = ["ramp", "snap"]
tissue.layer.skin.rupture_force_n = [4.9, 5.3]
"#;

const LONG: &str = r#"
base = "builtin:layers/direct-access.toml"
metrics = ["max_slave_overshoot_m", "tracking_rmse_m"]
csv = false
[design]
kind = "latin-hypercube"
points = 12001
[axes]
tissue.layer.capsule.rupture_force_n = { from = 0.6, to = 1.5 }
detector.threshold = { from = 1e-3, to = 1e-1, log = true }
"#;

/// A sweep of about a second, in which many cases share a run.
const SHARED: &str = r#"
base = "builtin:paper/augmented.toml"
seeds = 9
metrics = ["max_slave_overshoot_m", "false_alarms"]
csv = false
[set]
simulation.duration_s = 7.0
sensor.force_noise_std_n = 0.03
detector.cap = 0.5
[axes]
scaling.force = { from = 0.5, to = 2.0, points = 120 }
detector.threshold = { from = 2e-3, to = 0.2, points = 20, log = true }
"#;

/// Patients from distributions, whose named layers are tough together.
const PATIENTS: &str = r#"
base = "builtin:tearing/yellow-ligament.toml"
metrics = ["detected_ruptures", "max_slave_overshoot_m"]
[design]
kind = "latin-hypercube"
points = 64
[set]
simulation.duration_s = 3.0
tissue.layer.interspinous-ligament.friction_n_per_m = 5.0
[axes]
tissue.layer.interspinous-ligament.toughness_j_per_m2 = { median = 700.0, spread = 1.4 }
tissue.layer.yellow-ligament.toughness_j_per_m2 = { median = 1500.0, spread = 1.4 }
operator.movement_s = { from = 5.0, to = 11.0 }
[correlations.toughness]
axes = ["tissue.layer.interspinous-ligament.toughness_j_per_m2", "tissue.layer.yellow-ligament.toughness_j_per_m2"]
coefficient = 0.8
"#;

#[test]
fn patients_are_drawn_from_correlated_distributions() {
    let folder = TestFolder::new();
    folder.file("patients.toml", PATIENTS);
    let plan = Plan::load(&Source::Disk(folder.path("patients.toml")), &[]).expect("good");
    let tough = |case: u64| {
        let scenario = plan.scenario(case).expect("good");
        let echo: toml::Table = scenario.echo().parse().expect("TOML");
        let layers = echo["tissue"]["layer"].as_array().expect("a list").clone();
        assert_eq!(layers[0]["friction_n_per_m"].as_float(), Some(5.0));
        [0, 1].map(|layer: usize| layers[layer]["toughness_j_per_m2"].as_float().expect("a number").ln())
    };
    let drawn: Vec<[f64; 2]> = (0..64).map(tough).collect();
    let mean = |of: &dyn Fn(&[f64; 2]) -> f64| drawn.iter().map(of).sum::<f64>() / 64.0;
    let means = [mean(&|pair| pair[0]), mean(&|pair| pair[1])];
    assert!((means[0] - 700.0_f64.ln()).abs() < 0.05 && (means[1] - 1500.0_f64.ln()).abs() < 0.1, "{means:?}");
    let moment = |a: usize, b: usize| mean(&|pair| (pair[a] - means[a]) * (pair[b] - means[b]));
    let correlation = moment(0, 1) / (moment(0, 0) * moment(1, 1)).sqrt();
    assert!((0.65..0.92).contains(&correlation), "{correlation}");
    assert!((moment(0, 0).sqrt() - 1.4_f64.ln()).abs() < 0.04, "{}", moment(0, 0).sqrt());
    // The stored sweep is recognised as the same sweep.
    folder.good(&["sweep", "patients.toml", "--out", "out", "--quiet"]);
    let again = folder.good(&["sweep", "patients.toml", "--out", "out"]);
    assert!(again.contains("share their influence"), "{again}");
}

#[test]
fn invalid_distributions_and_correlations_are_refused() {
    let changes: [(&str, &str, &[&str]); 9] = [
        ("spread = 1.4 }\noperator", "spread = 1.0 }\noperator", &["above 1 and at most 10"]),
        (", spread = 1.4 }\noperator", " }\noperator", &["only one of median and spread"]),
        ("spread = 1.4 }\noperator", "spread = 1.4, from = 1.0 }\noperator", &["a range and a distribution"]),
        ("coefficient = 0.8", "coefficient = 1.0", &["above -1 and below 1 for 2 axes"]),
        ("coefficient = 0.8", "strength = 0.8", &["a correlation has no strength"]),
        ("axes = [\"tissue.layer.inter", "axes = [\"tissue.layer.intro", &["is no axis of this sweep"]),
        ("[correlations.toughness]", "[correlations]", &["write [correlations.NAME]"]),
        ("kind = \"latin-hypercube\"\npoints = 64", "kind = \"grid\"", &["a grid cannot have"]),
        ("interspinous", "intraspinous", &["there is no layer intraspinous-ligament"]),
    ];
    TestFolder::new().refused_changes("sweep", PATIENTS, &changes);
}

/// User-defined points, two of which share a value, with listed seeds.
const LISTED: &str = r#"
base = "builtin:paper/augmented.toml"
seeds = [7, 3]
metrics = ["max_slave_overshoot_m"]
[design]
kind = "list"
[set]
simulation.duration_s = 6.0
sensor.force_noise_std_n = 0.03
[axes]
scaling.force = [0.5, 1.0, 1.0]
detector.threshold = [0.02, 0.02, 0.05]
"#;

#[test]
fn given_points_run_with_listed_seeds() {
    let folder = TestFolder::new();
    folder.file("listed.toml", LISTED);
    folder.good(&["sweep", "listed.toml", "--out", "out", "--quiet"]);
    let rows = folder.text("out/listed/cases.csv");
    let inputs: Vec<String> =
        rows.lines().skip(1).map(|row| row.split(',').take(4).collect::<Vec<_>>().join(",")).collect();
    assert_eq!(
        inputs,
        ["0,0.5,0.02,7", "1,0.5,0.02,3", "2,1.0,0.02,7", "3,1.0,0.02,3", "4,1.0,0.05,7", "5,1.0,0.05,3"]
    );
    assert!(!folder.path("out/listed/heat_max_slave_overshoot_m.csv").exists(), "given points fill no map");
    let changes: [(&str, &str, &[&str]); 6] = [
        ("[0.02, 0.02, 0.05]", "[0.02, 0.05]", &["axes.detector.threshold must be a list of as many values"]),
        ("[0.02, 0.02, 0.05]", "{ from = 0.01, to = 0.1 }", &["axes.detector.threshold must be a list"]),
        ("[0.02, 0.02, 0.05]", "[0.02, 0.02, -1.0]", &["detector.threshold", "-1"]),
        ("kind = \"list\"", "kind = \"list\"\npoints = 3", &["a design of given points has no design.points"]),
        ("seeds = [7, 3]", "seeds = [7, 7]", &["a list of different whole numbers"]),
        ("seeds = [7, 3]", "seeds = [7, 3]\nfirst_seed = 1", &["first_seed is given, and the seeds are a list"]),
    ];
    folder.refused_changes("sweep", LISTED, &changes);
}

fn sweep_files() -> TestFolder {
    let folder = TestFolder::new();
    folder.file("small.toml", SMALL).file("long.toml", LONG).file("shared.toml", SHARED);
    folder
}

fn await_a_pack(folder: &TestFolder, below: &str, child: &mut Child) {
    let part = folder.path(below).join("cases.part");
    while !std::fs::metadata(&part).is_ok_and(|file| file.len() > 0) {
        assert!(child.try_wait().expect("a status").is_none(), "ended by itself");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Returns the files of a folder without the files of its shards.
fn files(folder: &TestFolder, below: &str) -> BTreeMap<PathBuf, Vec<u8>> {
    folder.files(below).into_iter().filter(|(path, _)| !path.to_string_lossy().contains("shard-")).collect()
}

fn same(folder: &TestFolder, one: &str, other: &str) {
    let (one, other) = (files(folder, one), files(folder, other));
    assert_eq!(one.keys().collect::<Vec<_>>(), other.keys().collect::<Vec<_>>());
    for (path, content) in &one {
        assert!(other[path] == *content, "{} differs", path.display());
    }
}

pub(crate) fn rows(folder: &TestFolder, name: &str) -> Vec<BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(folder.path(name)).expect("there");
    let names: Vec<String> = reader.headers().expect("a header").iter().map(str::to_owned).collect();
    let row = |record: csv::StringRecord| names.iter().cloned().zip(record.iter().map(str::to_owned)).collect();
    reader.records().map(|record| row(record.expect("a row"))).collect()
}

#[test]
fn a_row_has_the_results_of_a_separate_run() {
    let folder = sweep_files();
    let printed = folder.good(&["sweep", "small.toml"]);
    let said = words(printed.split("\n\n").next().unwrap_or_default());
    let answer = "small: The strongest influence on detected ruptures is scaling.force, with 36 % of its variance: on average 1.5 at 2 and 2 at \
                  1.25.";
    assert!(said.starts_with(answer), "{said}");
    assert!(said.contains("36 cases, 12 points (grid) with 3 seeds each"), "{said}");
    let rows = rows(&folder, "out/small/cases.csv");
    assert_eq!(rows.len(), 36);
    for case in [0, 7, 22, 35] {
        let row = &rows[case];
        assert_eq!(row["case"], case.to_string());
        folder.file("case.toml", folder.good(&["sweep", "small.toml", "--case", &case.to_string()]));
        let summary = folder.json(&["run", "case.toml", "--json"]);
        let metrics = &summary["metrics"];
        let number = |name: &str| row[name].parse::<f64>().expect("a number");
        assert_eq!(summary["seed"].to_string(), row["seed"]);
        // The JSON parser has an error in the last digit.
        let agree = |a: f64, b: f64| (a - b).abs() <= 2.0 * f64::EPSILON * b.abs();
        for (of_run, name) in [
            (&metrics["tracking_rmse_m"], "tracking_rmse_m"),
            (&metrics["ports"]["needle_energy_j"], "port_needle_energy_j"),
        ] {
            assert!(agree(of_run.as_f64().expect("a number"), number(name)), "{case}: {of_run}");
        }
        let ruptures = metrics["ruptures"].as_array().expect("a list");
        let overshoot = ruptures.iter().filter_map(|rupture| rupture["slave_overshoot_m"].as_f64()).reduce(f64::max);
        match (overshoot, row["max_slave_overshoot_m"].parse().ok()) {
            (Some(a), Some(b)) => assert!(agree(a, b), "{case}: {a} {b}"),
            (a, b) => assert_eq!(a, b, "{case}"),
        }
        let case = folder.text("case.toml");
        assert!(case.contains(&format!("reengage = \"{}\"", row["augmentation.reengage"])), "{case}");
    }
    let distinct: std::collections::BTreeSet<_> = rows.iter().map(|row| &row["tracking_rmse_m"]).collect();
    assert_eq!(distinct.len(), 36, "a seed or an axis does not matter");
    folder.refused(&["sweep", "small.toml", "--case", "36"], &["no case 36", "36 cases, numbered from 0"]);
}

#[test]
fn cases_that_share_a_run_have_the_results_of_separate_runs() {
    let folder = sweep_files();
    let sweep = |name: &str, base: &str, set: &str| {
        let text = format!(
            "base = \"builtin:{base}.toml\"\nseeds = 3\ncsv = false\n[set]\n{set}\n[axes]\nscaling.force = [0.6, 1.7]\n\
             detector.threshold = {{ from = 2e-3, to = 0.39, points = 23, log = true }}\n"
        );
        folder.file(name, &text);
        Plan::load(&Source::parse(folder.path(name).to_str().expect("a path")), &[]).expect("a sweep")
    };
    let noise = "simulation.duration_s = 7.0\nsensor.force_noise_std_n";
    let restless = "detector.motion = \"any\"\ndetector.drop_only = false\ndetector.settle_s = 0.01";
    let short =
        "simulation.duration_s = 4.0\nsensor.force_noise_std_n = 0.03\ndetector.settle_s = 0.01\ndetector.cap = 1.0";
    for (name, base, set) in [
        ("quiet.toml", "augmented", format!("{noise} = 0.025\ndetector.cap = 0.4")),
        // Alarms of all kinds, and events that end late because the threshold is low.
        (
            "restless.toml",
            "augmented",
            format!("{noise} = 0.08\n{restless}\ndetector.cap = 30.0\naugmentation.exit_ratio = 0.9"),
        ),
        ("layers.toml", "layers/skin-augmented", format!("{short}\naugmentation.min_hold_s = 0.05")),
        ("link.toml", "layers/skin-augmented", format!("{short}\nchannel.forward_delay_s = 0.01\nchannel.loss = 0.1")),
        // Without lanes.
        (
            "motors.toml",
            "augmented",
            format!("{short}\nactuator.master_force_limit_n = 3.0\nsimulation.control = \"sampled\""),
        ),
    ] {
        let plan = sweep(name, base, &set);
        let part = Part::open(&folder.path("part"), plan.layout(Shard::WHOLE)).expect("a part");
        let progress = Progress { stop: &AtomicBool::new(false), begun: &|_| {}, done: &|_| {} };
        assert_eq!(execute(&plan, &part, Execution { threads: 2, shares_runs: true }, &progress).expect("runs"), 138);
        let mut distinct = BTreeSet::new();
        let each = |case, _, values: &[f64]| {
            let metrics = measure(&plan.scenario(case).expect("a case")).expect("runs");
            let alone = plan.design.columns.iter().map(|column| column.value(&metrics, None).unwrap_or(f64::NAN));
            let bits = |values: &mut dyn Iterator<Item = f64>| values.map(f64::to_bits).collect::<Vec<_>>();
            let kept = bits(&mut values.iter().copied());
            assert_eq!(kept, bits(&mut { alone }), "{name}, case {case}");
            distinct.insert(kept);
            Ok(())
        };
        Rows(vec![part]).each(each).expect("rows");
        assert!((7..138).contains(&distinct.len()), "{name}: {} kinds of runs", distinct.len());
        std::fs::remove_file(folder.path("part")).expect("there");
    }
}

#[test]
fn sharing_runs_changes_no_byte() {
    let folder = sweep_files();
    folder.file("shared.toml", SHARED.replace("points = 120", "points = 3"));
    folder.good(&["sweep", "shared.toml", "--quiet", "--out", "with"]);
    folder.good(&["sweep", "shared.toml", "--quiet", "--no-sharing", "--out", "without"]);
    same(&folder, "with", "without");
}

#[test]
fn parquet_and_csv_have_the_same_content() {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;
    let folder = sweep_files();
    folder.good(&["sweep", "small.toml", "--quiet"]);
    let file = std::fs::File::open(folder.path("out/small/cases.parquet")).expect("there");
    let reader = SerializedFileReader::new(file).expect("Parquet");
    let rows = rows(&folder, "out/small/cases.csv");
    let mut seen = 0;
    for (row, cells) in reader.get_row_iter(None).expect("rows").zip(&rows) {
        for (name, field) in row.expect("a row").get_column_iter() {
            let cell = &cells[name];
            match field {
                Field::Null => assert_eq!(cell, "", "{name}"),
                Field::Double(number) => assert_eq!(Some(*number), cell.parse().ok(), "{name}"),
                Field::Long(number) => assert_eq!(Some(*number), cell.parse().ok(), "{name}"),
                Field::Str(text) => assert_eq!(text, cell, "{name}"),
                other => panic!("{name}: {other}"),
            }
        }
        seen += 1;
    }
    assert_eq!(seen, 36);
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let folder = sweep_files();
    for threads in ["1", "2", "5"] {
        folder.good(&["sweep", "small.toml", "--quiet", "--threads", threads, "--out", threads]);
    }
    same(&folder, "1", "2");
    same(&folder, "1", "5");
}

#[test]
fn shards_join_to_the_files_of_the_whole_sweep_after_a_killed_worker() {
    let folder = sweep_files();
    folder.good(&["sweep", "long.toml", "--quiet", "--out", "whole"]);
    let shard = |index: &'static str| ["sweep", "long.toml", "--quiet", "--threads", "1", "--shard", index];
    let (mut one, mut two) = (folder.begin(&shard("1/2")), folder.begin(&shard("2/2")));
    await_a_pack(&folder, "out/long/shard-2-of-2", &mut two);
    two.kill().expect("killed");
    two.wait().expect("ended");
    assert!(one.wait().expect("ended").success());
    let missing = folder.trocar(&["sweep", "merge", "out/long"]);
    assert_eq!(missing.code, 2);
    assert!(missing.err.contains("continues it"), "{}", missing.err);
    let before = std::fs::metadata(folder.path("out/long/shard-2-of-2/cases.part")).expect("kept").len();
    assert!(before > 0, "killed before the first pack");
    folder.good(&shard("2/2"));
    folder.good(&["sweep", "merge", "out/long", "--quiet", "--out", "merged"]);
    same(&folder, "whole/long", "merged/long");
}

#[test]
fn incomplete_or_different_parts_are_rejected() {
    let folder = sweep_files();
    for index in ["1/3", "2/3", "3/3"] {
        folder.good(&["sweep", "small.toml", "--quiet", "--shard", index]);
    }
    let part = |index: &str| format!("out/small/shard-{index}-of-3");
    let (one, two, three) = (part("1"), part("2"), part("3"));
    folder.refused(&["sweep", "merge", &one, &three], &["the cases 8 to 23 are in none of the parts"]);
    folder.refused(&["sweep", "merge", &one, &two], &["the cases 24 to 35"]);
    folder.refused(&["sweep", "merge", &one, &two, &two, &three], &["which is also in another part"]);
    folder.refused(&["sweep", "merge", "nowhere"], &["nowhere"]);
    folder.file("other/small.toml", SMALL.replace("seeds = 3", "seeds = 2"));
    folder.good(&["sweep", "other/small.toml", "--quiet", "--shard", "3/3", "--out", "other"]);
    let foreign = "other/small/shard-3-of-3";
    folder.refused(&["sweep", "merge", &one, &two, foreign], &["different sweeps", "- seeds = 3", "+ seeds = 2"]);
    let sweep = format!("{three}/sweep.toml");
    folder.file(&sweep, folder.text(&sweep).replace("points = 3", "points = 4"));
    folder.refused(&["sweep", "merge", &one, &two, &three], &["was changed"]);
}

#[test]
fn sweeps_killed_at_any_time_continue_to_the_same_bytes() {
    killed_ten_times("long");
    killed_ten_times("shared");
}

/// Kills a sweep at ten times between its start and its end, which are some hundred milliseconds apart.
fn killed_ten_times(name: &str) {
    let folder = sweep_files();
    let file = format!("{name}.toml");
    folder.good(&["sweep", &file, "--quiet", "--out", "undisturbed"]);
    let (undisturbed, out) = (format!("undisturbed/{name}"), format!("out/{name}"));
    let mut moments = crate::output::Moments::new();
    let (mut kept, mut kills) = (vec![], 0);
    while kills < 10 {
        let mut child = folder.begin(&["sweep", &file, "--quiet"]);
        std::thread::sleep(Duration::from_secs_f64(1e-3 * (30.0 + 300.0 * moments.next())));
        let _ = child.kill();
        let has_ended = child.wait().expect("ended").success();
        // A sweep killed between its last step and its end is also complete.
        let manifest = folder.path(&out).join("manifest.json");
        let is_complete = std::fs::read_to_string(manifest).is_ok_and(|text| text.contains("\"is_complete\": true"));
        if has_ended || is_complete {
            // The sweep is complete and its packs have become the files, so the loop starts a new sweep. If the
            // process was killed before the last step, the next run removes the packs.
            folder.good(&["sweep", &file, "--quiet"]);
            same(&folder, &undisturbed, &out);
            std::fs::remove_dir_all(folder.path(&out)).expect("there");
            kept.clear();
            continue;
        }
        kills += 1;
        kept.push(std::fs::metadata(folder.path(&out).join("cases.part")).map_or(0, |file| file.len()));
        assert!(kept.is_sorted(), "complete cases are lost: {kept:?}");
    }
    folder.good(&["sweep", &file, "--quiet"]);
    same(&folder, &undisturbed, &out);
    assert!(folder.good(&["sweep", &file]).contains("already complete"));
}

#[test]
fn a_folder_in_use_by_another_process_is_not_changed() {
    let folder = sweep_files();
    folder.good(&["sweep", "long.toml", "--quiet", "--out", "undisturbed"]);
    let mut first = folder.begin(&["sweep", "long.toml", "--quiet"]);
    await_a_pack(&folder, "out/long", &mut first);
    let second = folder.trocar(&["sweep", "long.toml", "--quiet"]);
    assert_eq!(second.code, 1, "{}", second.err);
    assert!(second.err.contains("another process; wait for it"), "{}", second.err);
    assert!(first.wait().expect("waited").success());
    same(&folder, "undisturbed/long", "out/long");
}

#[test]
fn sweeps_without_axes_or_with_unrankable_axes_have_a_summary() {
    let folder = TestFolder::new();
    let head = "base = \"builtin:paper/augmented.toml\"\nseeds = 4\nmetrics = [\"tissue_energy_j\", \"augmented_s\"]\n\
                focus = [\"tissue_energy_j\"]\n[set]\nsimulation.duration_s = 6.0\nsensor.force_noise_std_n = 0.02\n";
    for (name, axes) in [
        ("none", ""),
        ("one", "[axes]\nscaling.force = [1.0]\n"),
        ("words", "[axes]\naugmentation.reengage = [\"ramp\", \"snap\"]\n"),
        ("flags", "[axes]\naugmentation.enabled = [true, false]\naugmentation.reengage = [\"ramp\", \"snap\"]\n"),
    ] {
        folder.file(&format!("{name}.toml"), format!("{head}{axes}"));
        folder.good(&["sweep", &format!("{name}.toml"), "--quiet", "--report"]);
        let text = folder.text(&format!("out/{name}/summary.txt"));
        assert!(text.contains("energy into the tissue"), "{name}: {text}");
        // Without augmentation the slave is never frozen, even if other lanes are augmented.
        for row in rows(&folder, &format!("out/{name}/cases.csv")) {
            let is_off = row.get("augmentation.enabled").is_some_and(|enabled| enabled == "false");
            assert_eq!(row["augmented_s"] == "0.0", is_off, "{name}: {row:?}");
        }
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_stops_a_sweep_and_keeps_its_cases() {
    let folder = sweep_files();
    let mut child = folder.begin(&["sweep", "long.toml", "--threads", "1"]);
    await_a_pack(&folder, "out/long", &mut child);
    let interrupt = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("ran");
    assert!(interrupt.success());
    assert_eq!(child.wait().expect("ended").code(), Some(130));
    folder.good(&["sweep", "long.toml", "--quiet"]);
}

#[cfg(unix)]
#[test]
fn a_full_disk_is_reported_and_complete_cases_are_kept() {
    let folder = sweep_files();
    folder.good(&["sweep", "long.toml", "--quiet", "--out", "undisturbed"]);
    // A limit on the size of files fails like a full disk during the sweep. Its unit is 1 KiB or 512 bytes, depending
    // on the shell.
    let line = format!(
        "trap '' XFSZ; ulimit -f 24; exec '{}' sweep long.toml --quiet",
        assert_cmd::cargo::cargo_bin("trocar").display()
    );
    let output = Command::new("sh").current_dir(folder.path("")).args(["-c", &line]).output().expect("ran");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("cases.part") && said.contains("same command continues"), "{said}");
    assert!(std::fs::metadata(folder.path("out/long/cases.part")).expect("kept").len() > 4000);
    folder.good(&["sweep", "long.toml", "--quiet"]);
    same(&folder, "undisturbed/long", "out/long");
}

#[test]
fn a_changed_sweep_is_refused_with_the_difference() {
    let folder = sweep_files();
    folder.good(&["sweep", "small.toml", "--quiet"]);
    folder.file("small.toml", SMALL.replace("to = 2.0", "to = 3.0"));
    folder.refused(
        &["sweep", "small.toml"],
        &[
            "out/small",
            "- axes.scaling.force = { from = 0.5, to = 2.0",
            "+ axes.scaling.force = { from = 0.5, to = 3.0",
        ],
    );
    folder.file("small.toml", SMALL);
    folder.refused(&["sweep", "small.toml", "--set", "slave.velocity_gain=16"], &["- slave.velocity_gain = 15.0"]);
    // A change of comments does not change the sweep.
    folder.file("small.toml", format!("# a note\n{SMALL}"));
    assert!(folder.good(&["sweep", "small.toml"]).contains("already complete"));
}

#[test]
fn errors_in_a_file_are_underlined() {
    let folder = TestFolder::new();
    let base = "base = \"builtin:paper/classical.toml\"\n";
    let cases: [(&str, &[&str]); 20] = [
        ("sedes = 3", &["x.toml:2:1", "did you mean seeds?"]),
        ("scaling.force = 2.0", &["write axes.scaling.force to vary it, set.scaling.force to fix it"]),
        ("seeds = 0", &["seeds is 0, must be a whole number from 1", "^"]),
        ("metrics = [\"false_alarm\"]", &["no metric false_alarm", "did you mean false_alarms?"]),
        ("metrics = [\"events\", \"events\"]", &["events", "twice"]),
        ("metrics = [\"events\"]\nfocus = [\"ruptures\"]", &["not among the kept metrics", "add \"ruptures\""]),
        ("axes.scaling.froce = [1.0]", &["no key scaling.froce", "did you mean scaling.force?"]),
        ("axes.scaling.froce = { from = 1, to = 2, points = 3 }", &["did you mean scaling.force?"]),
        ("axes.scaling.force = [1.0, -1.0]", &["has -1.0, each must be a number, at least 0"]),
        ("axes.scaling.force = 1.0", &["must be a list"]),
        ("axes.scaling.force = { from = 1.0, to = 2.0 }", &["has no points"]),
        ("axes.scaling.force = { from = 1.0, to = 2.0, pints = 3 }", &["a range has no pints"]),
        ("axes.scaling.force = { from = 0.0, to = 2.0, points = 3, log = true }", &["above 0 with log = true"]),
        ("axes.augmentation.reengage = { from = 1, to = 2, points = 2 }", &["has no range", "give a list"]),
        ("axes.simulation.seed = [1, 2]", &["cannot be an axis", "seeds = N"]),
        ("axes.scaling.force = [1.0, 1.0]", &["twice"]),
        ("set.scaling.force = 1.0\naxes.scaling.force = [1.0]", &["both swept and set"]),
        ("set.slave.velocty_gain = 1.0", &["slave.velocity_gain"]),
        ("design = { kind = \"soboll\", points = 3 }", &["must be one of \"grid\""]),
        ("design = { kind = \"sobol\" }", &["design.points is missing"]),
    ];
    for (text, phrases) in cases {
        folder.file("x.toml", format!("{base}{text}\n"));
        folder.refused(&["sweep", "x.toml"], phrases);
    }
    // Each value is allowed, but the cutting force must not exceed the rupture force.
    let sweep = "base = \"builtin:layers/direct-access.toml\"\n\
                 axes.tissue.layer.capsule.cutting_force_n = { from = 0.1, to = 1.5, points = 3 }\n\
                 axes.tissue.layer.capsule.rupture_force_n = { from = 0.5, to = 2.0, points = 3 }\n";
    folder.file("x.toml", sweep).refused(&["sweep", "x.toml"], &["x.toml:", "in the case of"]);
    folder.file("x.toml", "seeds = 2\n").refused(&["sweep", "x.toml"], &["base is missing"]);
    folder.file("x.toml", "base = \"y.toml\"\n").refused(&["sweep", "x.toml"], &["y.toml"]);
    folder.refused(&["sweep"], &["FILE"]);
    folder.refused(&["sweep", "x.toml", "--shard", "3/2"], &["1 <= i <= n"]);
}

#[test]
fn shipped_and_documented_sweeps_are_valid() {
    let folder = TestFolder::new();
    let sweeps = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/sweeps");
    let mut shipped = 0;
    for entry in std::fs::read_dir(sweeps).expect("a folder") {
        let path = entry.expect("an entry").path().display().to_string();
        if path.ends_with(".toml") {
            assert!(folder.good(&["sweep", &path, "--case", "1"]).contains("[simulation]"), "{path}");
            shipped += 1;
        }
    }
    assert!(shipped >= 3);
    let help = folder.good(&["sweep", "--help"]);
    let example = help
        .split("each:\n")
        .nth(1)
        .and_then(|rest| rest.split("A sweep file with points").next())
        .expect("an example");
    folder.file("example.toml", example);
    folder.good(&["sweep", "example.toml", "--case", "2559"]);
    folder.refused(&["sweep", "example.toml", "--case", "2560"], &["2560"]);
    for word in ["seeds", "design.kind", "rupture_1_felt_contrast", "--shard 3/8", "merge"] {
        assert!(help.contains(word), "{word}");
    }
    let schema = folder.json(&["schema", "sweep-file"]);
    assert!(schema["properties"]["axes"]["properties"]["scaling"]["properties"]["force"]["anyOf"].is_array());
    assert!(schema["properties"]["set"]["properties"]["scaling"]["properties"]["force"].is_object());
}

/// Delays, tissue and scales as axes. One of them does not affect the insertion.
const LOOPS: &str = r#"
base = "builtin:paper/classical.toml"
metrics = ["stability_spectral_radius", "stability_is_stable", "stability_is_stable_simulated", "stability_gain_margin", "stability_delay_margin_s", "stability_is_absolutely_stable", "tracking_rmse_m"]
[set]
simulation.duration_s = 0.5
tissue.damping_n_s_per_m = 0.0
[axes]
scaling.force = [0.5, 2.0]
tissue.stiffness_n_per_m = [200.0, 900.0, 3000.0]
channel.forward_delay_s = [0.0, 0.0155]
"#;

#[test]
fn the_columns_of_the_loop_agree_with_the_analysis_of_each_case() {
    use trocar::scenario::{Scenario, Source};
    use trocar::stability::Analysis;
    let folder = TestFolder::new();
    folder.file("loops.toml", LOOPS);
    folder.good(&["sweep", "loops.toml"]);
    let rows = rows(&folder, "out/loops/cases.csv");
    assert_eq!(rows.len(), 12);
    let mut stable = 0;
    for (case, row) in rows.iter().enumerate() {
        folder.file("case.toml", folder.good(&["sweep", "loops.toml", "--case", &case.to_string()]));
        let path = folder.path("case.toml").display().to_string();
        let scenario = Scenario::load(&Source::parse(&path), &[]).expect("loads");
        let analysis = Analysis::of(&support::linear_loop(&scenario)).expect("analysed");
        let number = |name: &str| row[name].parse::<f64>().ok();
        assert_eq!(number("stability_spectral_radius"), Some(analysis.mode.spectral_radius), "{case}");
        assert_eq!(number("stability_is_stable"), Some(f64::from(u8::from(analysis.is_stable()))), "{case}");
        assert_eq!(number("stability_is_stable_simulated"), number("stability_is_stable"), "{case}");
        assert_eq!(number("stability_gain_margin"), analysis.margins.gain, "{case}");
        assert_eq!(number("stability_delay_margin_s"), analysis.margins.delay_s, "{case}");
        assert_eq!(number("stability_is_absolutely_stable"), Some(0.0), "{case}");
        stable += usize::from(analysis.is_stable());
    }
    assert!((3..10).contains(&stable), "{stable}");
}
