use trocar_document::Table;
use trocar_studies::sweep::{Column, SWEEP_KEYS};

const FILE: &str = "\
A sweep file with every combination of three axes and 20 noise seeds each:
  base = \"layers/through-the-skin\"      # the varied scenario
  seeds = 20
  metrics = [\"max_slave_overshoot_m\", \"false_alarms\"]
  [set]                                  # keys of all cases
  augmentation.enabled = true
  [axes]                                 # keys of the scenario
  scaling.force = { from = 0.5, to = 2.0, points = 8 }
  detector.threshold = { from = 2e-3, to = 2e-1, points = 8, log = true }
  augmentation.reengage = [\"ramp\", \"snap\"]  # a list of words or numbers

A sweep file with points between the ends of ranges:
  [design]
  kind = \"latin-hypercube\"               # or random, sobol
  points = 1000
  [axes]
  tissue.layer.skin.rupture_force_n = { from = 2.0, to = 8.0 }
";

const REST: &str = "\
A case has the same result alone, in a shard and on any number of threads. Complete cases are kept: after any interruption, \
the same command continues the sweep, to the same bytes. A changed sweep file is an error that shows the difference.

Files, in DIR/NAME: cases.parquet and cases.csv (a row per case: number, values, seed, outcome, metrics), summary.csv, .json and \
.txt, heat_METRIC and tornado as figures and .csv, sweep.toml (all inputs of the sweep), manifest.json.

Examples:
  trocar sweep scenarios/sweeps/small.toml
  trocar sweep big.toml --case 17 > case.toml && trocar run case.toml
  trocar sweep big.toml --shard 3/8   on each of eight machines
  trocar sweep merge out/big          joins the parts
  parallel --resume --joblog log trocar sweep big.toml --shard {}/8 \\
      --threads 1 --quiet ::: {1..8}
  trocar schema sweep-file            a JSON Schema for editors";

pub(super) fn text() -> String {
    let mut keys = Table::new("keys", "Keys", [("key", "key"), ("meaning", "meaning")]).of_text();
    SWEEP_KEYS.iter().for_each(|(key, meaning)| keys.row([*key, *meaning]));
    let keys = trocar_report::Table::from(&keys);
    let metrics: Vec<String> = Column::names().collect();
    let metrics = metrics.join(", ");
    format!("{FILE}\n{keys}\nMetrics (those of other ruptures and events have their number): {metrics}\n\n{REST}")
}
