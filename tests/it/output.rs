//! Folders of results: commands that are killed, run twice at once or are interrupted, and damaged files.
//!
//! `TROCAR_KILLS=75 cargo test --test it output::` kills each of the four commands 75 times, instead of 5.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use crate::support::test_folder::TestFolder;

type Files = BTreeMap<PathBuf, Vec<u8>>;

const SCENARIO: &str = "name = \"x\"\nbase = \"layers/skin-augmented\"\n[simulation]\nduration_s = 1.0\n";
const SWEEP: &str = "name = \"s\"\nbase = \"x.toml\"\nseeds = 2\nmetrics = [\"max_excess_advance_m\", \"false_alarms\"]\n\
    focus = [\"max_excess_advance_m\"]\n[set]\nsensor.force_noise_std_n = 0.02\n[design]\nkind = \"sobol\"\npoints = 64\n\
    [axes]\nscaling.force = { from = 0.5, to = 2.0 }\n";

fn folder() -> TestFolder {
    let folder = TestFolder::new();
    folder.file("x.toml", SCENARIO).file("y.toml", SCENARIO.replace("\"x\"", "\"y\"")).file("s.toml", SWEEP);
    let rows = (0..1500).map(|k| {
        let (t, since) = (f64::from(k) * 1e-3, if k > 1000 { 1.0 } else { 0.0 });
        format!("{t:.3},{:.6},{:.4}\n", 1e-2 * t, 3.0 * (t - 0.95 * since))
    });
    folder.file("two.csv", std::iter::once("time_s,position_m,force_n\n".to_owned()).chain(rows).collect::<String>());
    folder
}

fn kills() -> u32 {
    std::env::var("TROCAR_KILLS").ok().and_then(|kills| kills.parse().ok()).unwrap_or(5)
}

/// Random numbers below 1, different in each run.
struct Moments(u64);

impl Moments {
    fn new() -> Self {
        Self(SystemTime::now().duration_since(UNIX_EPOCH).map_or(1, |now| now.as_nanos() as u64))
    }

    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / (1 << 24) as f64
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() * end as f64) as usize
    }
}

fn words(line: &str) -> Vec<&str> {
    line.split_whitespace().collect()
}

fn begin(folder: &TestFolder, line: &str) -> Child {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin("trocar"));
    command.current_dir(folder.path("")).args(words(line)).stdout(Stdio::null()).stderr(Stdio::piped());
    command.spawn().expect("starts")
}

/// Returns the files of results, without those that a killed command has left.
fn results(folder: &TestFolder, below: &str) -> Files {
    let mut files = folder.files(below);
    files.retain(|path, _| !path.to_string_lossy().contains(".trocar-"));
    files
}

fn has_leftovers(folder: &TestFolder, below: &str) -> bool {
    let left = |path: &PathBuf| path.to_string_lossy().contains(".trocar-");
    let entries = std::fs::read_dir(folder.path(below)).expect("a folder").flatten();
    folder.files(below).keys().any(left) || entries.map(|entry| entry.path()).any(|path| left(&path))
}

/// Kills a command while it replaces results of other settings. `is_one_step` says that a reader of the folder never
/// sees a mixture, even before the next command.
fn killed(line: &str, is_one_step: bool) {
    let folder = folder();
    let other = format!("{line} --set detector.threshold=0.9");
    let lines = [line, other.as_str()];
    let wholes = [0, 1].map(|which| {
        folder.good(&words(&format!("{} --quiet --out whole{which}", lines[which])));
        results(&folder, &format!("whole{which}"))
    });
    assert!(wholes[0] != wholes[1], "{line}: the settings have no effect");
    let begun = Instant::now();
    folder.good(&words(&format!("{line} --quiet")));
    let time_s = begun.elapsed().as_secs_f64();
    let mut moments = Moments::new();
    for kill in 0..kills() as usize {
        // Some of the commands end before they are killed.
        let moment_s = 1.05 * time_s * moments.next();
        let mut child = begin(&folder, &format!("{} --quiet", lines[(kill + 1) % 2]));
        std::thread::sleep(Duration::from_secs_f64(moment_s));
        let _ = child.kill();
        child.wait().expect("ended");
        let is_whole = |found: &Files| wholes.contains(found);
        if is_one_step {
            assert!(is_whole(&results(&folder, "out")), "{line}: a mixture after {moment_s} s");
        }
        folder.good(&["verify", "out"]);
        assert!(is_whole(&results(&folder, "out")), "{line}: a mixture after {moment_s} s and the next command");
        assert!(!has_leftovers(&folder, "out"), "{line}: leftovers after {moment_s} s");
    }
    folder.good(&words(&format!("{line} --quiet")));
    assert!(results(&folder, "out") == wholes[0] && !has_leftovers(&folder, "out"), "{line}");
}

#[test]
fn a_killed_run_leaves_the_old_or_the_new_folder() {
    killed("run x.toml", cfg!(any(target_os = "linux", target_os = "macos")));
}

#[test]
fn a_killed_detection_leaves_the_old_or_the_new_folder() {
    killed("detect two.csv", cfg!(any(target_os = "linux", target_os = "macos")));
}

#[test]
fn a_killed_comparison_leaves_the_old_or_the_new_folders() {
    killed("compare x.toml y.toml", false);
}

#[test]
fn a_killed_sweep_continues_to_the_same_bytes_without_leftovers() {
    let folder = folder();
    let begun = Instant::now();
    folder.good(&words("sweep s.toml --quiet --out whole"));
    let time_s = begun.elapsed().as_secs_f64();
    let whole = results(&folder, "whole");
    let mut moments = Moments::new();
    for _ in 0..kills() {
        let moment_s = 1.05 * time_s * moments.next();
        let mut child = begin(&folder, "sweep s.toml --quiet");
        std::thread::sleep(Duration::from_secs_f64(moment_s));
        let _ = child.kill();
        child.wait().expect("ended");
        folder.good(&words("sweep s.toml --quiet"));
        assert!(results(&folder, "out") == whole && !has_leftovers(&folder, "out"), "after {moment_s} s");
        std::fs::remove_dir_all(folder.path("out")).expect("there");
    }
}

#[test]
fn of_two_commands_with_the_same_folder_the_second_is_refused() {
    let folder = folder();
    let mut first = begin(&folder, "compare x.toml y.toml --seeds 400 --quiet");
    let is_claimed = || {
        let entries = std::fs::read_dir(folder.path("out")).into_iter().flatten().flatten();
        entries.map(|entry| entry.path().join("claims")).any(|path| path.is_file())
    };
    while !is_claimed() {
        assert!(first.try_wait().expect("asked").is_none(), "the first command has ended");
        std::thread::sleep(Duration::from_millis(2));
    }
    for line in ["run x.toml", "compare y.toml", "strategies x.toml", "stability y.toml", "roc x.toml"] {
        let second = folder.trocar(&words(line));
        assert_eq!(second.code, 1, "{line}: {}", second.err);
        assert!(second.err.contains("another process; wait for it"), "{line}: {}", second.err);
    }
    // Another folder is free.
    folder.good(&words("detect two.csv --quiet --no-figures"));
    first.kill().expect("killed");
    first.wait().expect("ended");
    folder.good(&words("run x.toml --quiet"));
    assert!(!has_leftovers(&folder, "out"));
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_with_a_message_and_code_130_and_leaves_the_old_results() {
    let folder = folder();
    folder.good(&words("compare x.toml y.toml --quiet"));
    let before = results(&folder, "out");
    for line in [
        "compare x.toml y.toml --seeds 50000 --quiet",
        "run x.toml --set simulation.duration_s=2000 --quiet",
        "strategies x.toml --seeds 1000 --quiet",
        "stability x.toml --event-limits --quiet",
    ] {
        let child = begin(&folder, line);
        std::thread::sleep(Duration::from_millis(400));
        let interrupt = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("ran");
        assert!(interrupt.success());
        let output = child.wait_with_output().expect("ended");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(130), "{line}: {said}");
        assert!(said.contains("interrupted: unfinished results were removed"), "{line}: {said}");
        assert!(results(&folder, "out") == before && !has_leftovers(&folder, "out"), "{line}");
    }
}

/// Damages a file. Returns false if the damage changes nothing.
fn damage(folder: &TestFolder, name: &str, kind: usize, moments: &mut Moments) -> bool {
    let path = folder.path(name);
    let mut content = std::fs::read(&path).expect("there");
    let before = content.clone();
    match kind {
        0 => std::fs::remove_file(&path).expect("removed"),
        1 => content.truncate(moments.below(content.len())),
        2 if !content.is_empty() => {
            let at = moments.below(content.len());
            content[at] ^= 1 << moments.below(8);
        }
        3 => content = b"replaced".to_vec(),
        _ => content.extend_from_slice(b"\n"),
    }
    if kind > 0 {
        std::fs::write(&path, &content).expect("written");
    }
    kind == 0 || content != before
}

#[test]
fn verify_notices_every_damage_of_results() {
    let folder = folder();
    for line in ["compare x.toml y.toml --report", "detect two.csv", "sweep s.toml"] {
        folder.good(&words(&format!("{line} --quiet")));
    }
    folder.file("out/x/notes.txt", "of the user");
    let said = folder.good(&["verify", "out"]);
    assert!(said.contains("out/x: ") && said.contains("files unchanged"), "{said}");
    let whole = folder.files("out");
    let (mut tried, mut moments) = (0, Moments::new());
    for (number, (path, content)) in whole.iter().enumerate().filter(|(_, (path, _))| !path.ends_with("notes.txt")) {
        let name = format!("out/{}", path.display());
        for kind in 0..5 {
            // Three kinds for each file.
            if (kind + number) % 5 > 2 || !damage(&folder, &name, kind, &mut moments) {
                continue;
            }
            let outcome = folder.trocar(&["verify", "out"]);
            // Without a manifest, the files directly in the folder are not known.
            let is_noted = outcome.err.contains("has no manifest.json");
            assert!(
                outcome.code == 1 || (name.ends_with("manifest.json") && is_noted),
                "{name}, kind {kind}: {}",
                outcome.err
            );
            folder.file(&name, content);
            tried += 1;
        }
    }
    assert!(tried >= 100, "{tried}");
    folder.good(&["verify", "out", "--quiet"]);
    folder.refused(&["verify", "nowhere"], &["no manifest.json"]);
}

#[test]
fn a_finished_sweep_notices_every_damage_and_writes_the_same_bytes_again() {
    let folder = folder();
    folder.good(&words("sweep s.toml --report --quiet"));
    let whole = folder.files("out/s");
    assert!(folder.good(&["sweep", "s.toml"]).contains("already complete"));
    let (mut moments, mut names) = (Moments::new(), whole.keys().cycle());
    for turn in 0..25 {
        let name = format!("out/s/{}", names.next().expect("files").display());
        if !damage(&folder, &name, turn % 5, &mut moments) {
            continue;
        }
        let outcome = folder.trocar(&["sweep", "s.toml"]);
        assert_eq!(outcome.code, 0, "{name}: {}", outcome.err);
        let is_noticed = outcome.err.contains("the sweep runs again") || name.ends_with("manifest.json");
        assert!(is_noticed && !outcome.out.contains("already complete"), "{name}: {}", outcome.err);
        assert!(folder.files("out/s") == whole, "{name}, kind {}", turn % 5);
    }
}
