//! What `trocar sweep --help` teaches.

use trocar_sim::sweep::{Column, SWEEP_KEYS};

const FILE: &str = "\
A sweep file, every combination of three axes with 20 seeds of noise each:
  base = \"builtin:01_through_the_skin.toml\"    # what is varied; --set changes it too
  seeds = 20
  metrics = [\"max_slave_overshoot_m\", \"false_alarms\", \"rupture_1_detection_delay_s\"]
  [set]                                        # keys that all cases share
  augmentation.enabled = true
  [axes]                                       # any keys of the scenario
  scaling.force = { from = 0.5, to = 2.0, points = 8 }
  detector.threshold = { from = 2e-3, to = 2e-1, points = 8, log = true }
  augmentation.reengage = [\"ramp\", \"snap\"]     # a list, of words or numbers
or points that fill the space between the ends of ranges, which then have no points of their own:
  [design]
  kind = \"latin-hypercube\"                     # or random, sobol
  points = 1000
  [axes]
  tissue.skin.rupture_force_n = { from = 2.0, to = 8.0 }
";

const REST: &str = "\
Case i is the same by itself, in a shard and on any number of threads. What is done is kept: whatever ended a sweep, the
same command continues it, to the same bytes. A changed file is refused, with the difference.

Files, in DIR/NAME: cases.parquet and cases.csv (a row per case: its number, its values, its seed, how it ended, its
metrics), summary.csv, .json and .txt, heat_METRIC and tornado as .svg, .png and .csv, sweep.toml (everything that the
result depends on), manifest.json.

Examples:
  trocar sweep scenarios/sweeps/small.toml
  trocar sweep scenarios/sweeps/small.toml --case 17 > case.toml && trocar run case.toml
  trocar sweep big.toml --shard 3/8                       on each of eight machines, then
  trocar sweep merge out/big                              to join the parts
  parallel --resume --joblog log trocar sweep big.toml --shard {}/8 --threads 1 --quiet ::: {1..8}
  trocar schema --sweep                                   a JSON Schema for editors";

/// The keys of a file, its axes, the metrics, examples.
pub(super) fn text() -> String {
    let width = SWEEP_KEYS.iter().map(|(key, _)| key.len()).max().unwrap_or(0);
    let keys: Vec<String> = SWEEP_KEYS.iter().map(|(key, about)| format!("  {key:width$}  {about}\n")).collect();
    let names: Vec<String> = Column::names().collect();
    let mut metrics = String::new();
    let mut column = 0;
    for name in names {
        if column + name.len() > 110 {
            metrics.push('\n');
            column = 0;
        }
        metrics.push_str(if column == 0 { "  " } else { ", " });
        column += 2 + name.len();
        metrics.push_str(&name);
    }
    format!(
        "{FILE}\nKeys:\n{}\nMetrics, those of further ruptures and events by their number:\n{metrics}\n\n{REST}",
        keys.concat()
    )
}
