//! End-to-end sweeps: the program itself, from a sweep file to its results.

use std::path::Path;
use std::process::{Command, Stdio};

use crate::markdown::{Table, figure};
use crate::timing::{Cost, elapsed_s};

const TICK_S: f64 = 1e-3;

/// A sweep over force scale, threshold and seeds of the shipped augmented scenario.
pub struct Sweep {
    /// Number of force scales, and number of thresholds.
    pub axes: (u64, u64),
    pub seeds: u64,
    /// Duration of each case, in s.
    pub duration_s: f64,
    /// Standard deviation of the force noise, in N.
    pub noise_n: f64,
    /// True if all thresholds have the same cap, so that cases share runs.
    pub has_cap: bool,
}

impl Sweep {
    pub fn cases(&self) -> u64 {
        self.axes.0 * self.axes.1 * self.seeds
    }

    /// Returns the ticks of all cases.
    pub fn case_ticks(&self) -> f64 {
        self.cases() as f64 * (self.duration_s / TICK_S).round()
    }

    fn text(&self) -> String {
        let Self { axes: (scales, thresholds), seeds, duration_s, noise_n, has_cap } = self;
        let cap = if *has_cap { "detector.cap = 0.4\n" } else { "" };
        format!(
            "base = \"builtin:paper/augmented.toml\"\n\
             seeds = {seeds}\n\
             metrics = [\"detected_ruptures\", \"false_alarms\", \"tissue_energy_j\"]\n\
             focus = [\"tissue_energy_j\"]\n\
             csv = false\n\
             [set]\n\
             simulation.duration_s = {duration_s:?}\n\
             sensor.force_noise_std_n = {noise_n:?}\n\
             {cap}\
             [axes]\n\
             scaling.force = {{ from = 0.5, to = 2.0, points = {scales} }}\n\
             detector.threshold = {{ from = 2e-3, to = 2e-1, points = {thresholds}, log = true }}\n"
        )
    }

    /// Runs the program `times` times. Returns the best and the median time, in s.
    pub fn run_s(&self, threads: usize, times: usize) -> Cost {
        let run = |_| {
            let folder = tempfile::tempdir().expect("there is a temporary directory");
            let file = folder.path().join("bench.toml");
            std::fs::write(&file, self.text()).expect("the sweep file can be written");
            elapsed_s(|| sweep(&file, threads))
        };
        Cost::of((0..times).map(run).collect())
    }
}

fn sweep(file: &Path, threads: usize) {
    let out = file.with_file_name("out");
    let mut command = Command::new(env!("CARGO_BIN_EXE_trocar"));
    command.arg("sweep").arg(file).args(["--quiet", "--threads", &threads.to_string(), "--out"]).arg(out);
    let status = command.stdout(Stdio::null()).status().expect("the program starts");
    assert!(status.success(), "trocar sweep: {status}");
}

pub fn section() -> String {
    let header = ["sweep", "threads", "s, best", "s, median", "ns per tick and case", "one thread / this"];
    let mut table = Table::new(1, &header);
    let kinds = [("augmented", 0.0, false), ("augmented, noise", 0.025, false), ("the same with one cap", 0.025, true)];
    for (name, noise_n, has_cap) in kinds {
        let sweep = Sweep { axes: (40, 25), seeds: 100, duration_s: 7.0, noise_n, has_cap };
        let mut single = f64::NAN;
        for threads in [1, 2] {
            let cost = sweep.run_s(threads, 3);
            if threads == 1 {
                single = cost.best;
            }
            let ns = figure(1e9 * cost.best / sweep.case_ticks());
            let figures = [threads.to_string(), figure(cost.best), figure(cost.median), ns, figure(single / cost.best)];
            table.row([name.to_owned()].into_iter().chain(figures));
        }
    }
    let about = "`trocar sweep` as a process: 10⁵ insertions of 7 s (40 force scales, 25 thresholds, 100 seeds; 7·10⁸ ticks), \
         from the sweep file to Parquet, summary and heat maps. The gain of two threads is smaller if they share a core \
         or other programs run. With one cap for all thresholds, cases with identical alarms share runs.";
    table.section("A sweep end to end", about)
}
