//! Folders of results: commands that are killed, run at once, or are interrupted.
//!
//! `TROCAR_KILLS=75 cargo test --test it output::` kills each of the four commands 75 times, instead of 2.

use std::process::{Child, Command};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use crate::support::test_folder::TestFolder;

const SCENARIO: &str = "name = \"x\"\nbase = \"layers/skin-augmented\"\n[simulation]\nduration_s = 1.0\n";
const SWEEP: &str = "name = \"s\"\nbase = \"x.toml\"\nseeds = 2\nmetrics = [\"max_excess_advance_m\", \"false_alarms\"]\n\
    focus = [\"max_excess_advance_m\"]\n[set]\nsensor.force_noise_std_n = 0.02\n[design]\nkind = \"sobol\"\npoints = 64\n\
    [axes]\nscaling.force = { from = 0.5, to = 2.0 }\n";

/// A command that removes the leftovers of others.
const NEXT: &str = "run z.toml --set simulation.duration_s=0.1 --no-figures --quiet";

fn folder() -> TestFolder {
    let folder = TestFolder::new();
    for name in ["x", "y", "z"] {
        folder.file(&format!("{name}.toml"), SCENARIO.replace("\"x\"", &format!("\"{name}\"")));
    }
    folder.file("s.toml", SWEEP);
    folder.file("two.csv", insertion());
    folder
}

/// Returns a recording at 10 mm/s with a rupture after 1 s.
fn insertion() -> String {
    let rows = (0..1500).map(|k| {
        let (t, since) = (f64::from(k) * 1e-3, if k > 1000 { 1.0 } else { 0.0 });
        format!("{t:.3},{:.6},{:.4}\n", 1e-2 * t, 3.0 * (t - 0.95 * since))
    });
    std::iter::once("time_s,position_m,force_n\n".to_owned()).chain(rows).collect()
}

fn kills() -> usize {
    std::env::var("TROCAR_KILLS").ok().and_then(|kills| kills.parse().ok()).unwrap_or(2)
}

/// Random numbers below 1, different in each run.
pub(crate) struct Moments(u64);

impl Moments {
    pub(crate) fn new() -> Self {
        Self(SystemTime::now().duration_since(UNIX_EPOCH).map_or(1, |now| now.as_nanos() as u64))
    }

    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / (1 << 24) as f64
    }
}

fn words(line: &str) -> Vec<&str> {
    line.split_whitespace().collect()
}

fn has_leftovers(folder: &TestFolder) -> bool {
    let left = |name: &str| name.contains(".trocar-");
    let entries = std::fs::read_dir(folder.path("out")).expect("a folder").flatten();
    entries.into_iter().any(|entry| left(&entry.file_name().to_string_lossy()))
        || folder.files("out").keys().any(|path| left(&path.to_string_lossy()))
}

/// Kills a command at a random moment. Some of the commands end before.
fn kill(mut child: Child, time_s: f64, moments: &mut Moments) -> f64 {
    let moment_s = 1.05 * time_s * moments.next();
    std::thread::sleep(Duration::from_secs_f64(moment_s));
    let _ = child.kill();
    child.wait().expect("ended");
    moment_s
}

#[test]
fn a_killed_command_leaves_the_old_or_the_new_folder_and_does_not_disturb_others() {
    for (line, name) in [("run x.toml", "x"), ("detect two.csv", "two"), ("compare x.toml y.toml", "compare")] {
        let folder = folder();
        let at = format!("out/{name}");
        let lines = [line, &format!("{line} --set detector.threshold=0.9")].map(|line| format!("{line} --quiet"));
        let mut time_s = 0.0;
        let wholes = [1, 0].map(|which| {
            let begun = Instant::now();
            folder.good(&words(&lines[which]));
            time_s = begun.elapsed().as_secs_f64();
            folder.files(&at)
        });
        assert!(wholes[0] != wholes[1], "{line}: the settings have no effect");
        let mut moments = Moments::new();
        for turn in 0..kills() {
            // Every second command has company, of its own kind or of another.
            let company = [&lines[turn % 2], NEXT][turn / 2 % 2];
            let other = (turn % 2 == 1).then(|| folder.begin(&words(company)));
            let moment_s = kill(folder.begin(&words(&lines[(turn + 1) % 2])), time_s, &mut moments);
            if let Some(other) = other {
                let output = other.wait_with_output().expect("ended");
                assert!(output.status.success(), "{company}: {}", String::from_utf8_lossy(&output.stderr));
            }
            assert!(wholes.contains(&folder.files(&at)), "{line}: a mixture after {moment_s} s");
            folder.good(&words(NEXT));
            assert!(wholes.contains(&folder.files(&at)), "{line}: a mixture after {moment_s} s and the next command");
            assert!(!has_leftovers(&folder), "{line}: leftovers after {moment_s} s");
        }
    }
}

#[test]
fn a_killed_sweep_continues_to_the_same_bytes_without_leftovers() {
    let folder = folder();
    let begun = Instant::now();
    folder.good(&words("sweep s.toml --quiet"));
    let time_s = begun.elapsed().as_secs_f64();
    let whole = folder.files("out/s");
    let mut moments = Moments::new();
    for turn in 0..kills() {
        std::fs::remove_dir_all(folder.path("out/s")).expect("there");
        let other = (turn % 2 == 1).then(|| folder.begin(&words(["sweep s.toml --quiet", NEXT][turn / 2 % 2])));
        let moment_s = kill(folder.begin(&words("sweep s.toml --quiet")), time_s, &mut moments);
        if let Some(other) = other {
            let output = other.wait_with_output().expect("ended");
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(output.status.success() || said.contains("another process"), "{said}");
        }
        folder.good(&words("sweep s.toml --quiet"));
        assert!(folder.files("out/s") == whole && !has_leftovers(&folder), "after {moment_s} s");
    }
}

#[test]
fn of_two_commands_at_once_the_last_one_has_the_folder() {
    let folder = folder();
    folder.good(&words("compare x.toml y.toml --quiet"));
    let whole = folder.files("out/compare");
    let mut all = ["run x.toml", "compare x.toml", "roc x.toml --seeds 1", "detect two.csv", "compare y.toml"]
        .map(|line| (line, folder.begin(&words(&format!("{line} --no-figures --quiet")))));
    for (line, child) in &mut all {
        assert!(child.wait().expect("ended").success(), "{line}");
    }
    folder.good(&words("compare x.toml y.toml --quiet"));
    assert!(folder.files("out/compare") == whole && !has_leftovers(&folder));
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_with_a_message_and_code_130_and_leaves_the_old_results() {
    let folder = folder();
    folder.good(&words("compare x.toml y.toml --quiet"));
    let before = folder.files("out");
    for line in [
        "compare x.toml y.toml --seeds 50000 --quiet",
        "run x.toml --set simulation.duration_s=2000 --quiet",
        "strategies x.toml --seeds 1000 --quiet",
        "stability x.toml --event-limits --quiet",
    ] {
        let child = folder.begin(&words(line));
        std::thread::sleep(Duration::from_millis(400));
        let interrupt = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("ran");
        assert!(interrupt.success());
        let output = child.wait_with_output().expect("ended");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(130), "{line}: {said}");
        assert!(said.contains("interrupted: unfinished results were removed"), "{line}: {said}");
        assert!(folder.files("out") == before && !has_leftovers(&folder), "{line}");
    }
}

#[test]
fn a_finished_sweep_runs_again_if_a_file_is_missing_or_its_inputs_were_changed() {
    let folder = folder();
    folder.good(&words("sweep s.toml --report --quiet"));
    let whole = folder.files("out/s");
    assert!(folder.good(&["sweep", "s.toml"]).contains("already complete"));
    for name in whole.keys() {
        let path = folder.path("out/s").join(name);
        std::fs::remove_file(&path).expect("removed");
        if name.ends_with("sweep.toml") {
            std::fs::write(&path, "changed").expect("written");
        }
        let outcome = folder.trocar(&["sweep", "s.toml"]);
        assert_eq!(outcome.code, 0, "{name:?}: {}", outcome.err);
        assert!(!outcome.out.contains("already complete"), "{name:?}");
        assert!(folder.files("out/s") == whole, "{name:?}");
    }
}
