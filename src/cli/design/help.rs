use trocar_document::Table;
use trocar_studies::design::{DESIGN_KEYS, Quantity};

const FILE: &str = "\
A design file: which ramp and hold have a small excess and end near the intended depth?
  base = \"layers/skin-augmented\"         # the scenario that is designed
  [patients]                             # what differs from patient to patient
  tissue.layer.skin.rupture_force_n = { median = 5.3, spread = 1.45 }
  operator.movement_s = { from = 4.0, to = 8.0 }
  [free]                                 # keys to design
  augmentation.min_hold_s = { from = 0.1, to = 1.0 }
  augmentation.catch_up_speed_m_per_s = { from = 0.003, to = 0.1, log = true }
  augmentation.force_law = [\"decay\", \"amplify\"]
  [objectives.excess]
  minimise = \"rupture_excess_advance_m\"  # of every rupture, the mean
  [objectives.shortfall]
  minimise = \"final_shortfall_m\"
  quantile = 0.9                         # instead of the mean
  [constraints.reached]
  metric = \"reached_share\"
  at_least = 0.95
  [constraints.stable]
  certified = true                       # the certificate of events: every motion decays
";

const REST: &str = "\
Search: NSGA-II. All candidates have the same patients, persons and noise. Candidates without prospect stop early. The \
result does not depend on the number of threads.
The designs on the front and the shipped strategies then run on other patients with other noise: the tables show both.
After an interruption, the same command continues after the last complete generation, to the same bytes.

Files, in DIR/NAME: designed.toml (the knee of the front as a scenario), front/01.toml ..., front (figure), design.json, \
candidates.csv (every complete candidate), design.toml (all inputs), search.json (the state of the search).

Examples:
  trocar design designs/liver.toml
  trocar run out/liver/designed.toml
  trocar compare layers/skin-augmented out/liver/designed.toml
  trocar design my.toml --report --threads 8";

pub(super) fn text() -> String {
    let mut keys = Table::new("keys", "Keys", [("key", "key"), ("meaning", "meaning")]).of_text();
    DESIGN_KEYS.iter().for_each(|(key, meaning)| keys.row([*key, *meaning]));
    let keys = trocar_report::Table::from(&keys);
    let metrics: Vec<String> = Quantity::names().collect();
    let metrics = metrics.join(", ");
    format!(
        "{FILE}\n{keys}\nMetrics (rupture_NAME and event_NAME are of every rupture or event, rupture_1_NAME of the first): \
         {metrics}\n\n{REST}"
    )
}
