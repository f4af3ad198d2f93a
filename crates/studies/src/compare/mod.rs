mod document;
mod facts;

mod noise;
mod paper;
mod scheme_document;
mod schemes;
mod seeds;
mod sensitivity;
mod strategies;
mod table;
mod verdict;

pub use document::{ComparisonFile, ComparisonReport, add_figures};
pub(crate) use document::{events_table, metric_tables};
pub use facts::{Fact, paper_facts};

pub use noise::{ADDED_NOISE_STD_N, NoiseCheck, check_in_noise};
pub use paper::{
    FIGURES, Judgement, NOISE_SEEDS, PAPER_VARIANCE_N2, PaperFigure, PaperFile, PaperStudy, QuietStretch, Statement,
};
pub use scheme_document::SchemeReport;
pub use schemes::{IMPEDANCE_FREQUENCIES_HZ, SchemeRow, SchemeStudy};
pub use seeds::{MAX_SEEDS, SeedStudy, SeedTotals, Spread, SpreadRow};
pub use sensitivity::{Noticed, Sensitivity};
pub(crate) use strategies::PERCEIVING;
pub use strategies::{
    FIXED_PERSONS, FalseAlarmCost, Group, LinearLoops, PERSONS, Person, STRATEGIES, StrategiesFile, Strategy,
    StrategyOptions, StrategyRow, StrategyStudy, Verdict, WINDOWS_S,
};
pub use table::{Row, rows};
pub use verdict::{verdict, verdict_of_schemes, verdict_over_seeds};

use schemars::JsonSchema;
use serde::Serialize;

use crate::run::{Run, RunError, RunReport, run};
use trocar_base::parallel::try_map;
use trocar_base::warning::Warning;
use trocar_scenario::Scenario;

#[derive(Debug, Clone)]
pub struct Comparison {
    pub runs: Vec<Run>,
    pub noise: Vec<NoiseCheck>,
}

/// The numbers of a comparison: the metrics of each scenario, and the detection in noise.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ComparisonTable {
    /// Names of the scenarios.
    pub scenarios: Vec<String>,
    /// A row per metric, with a value per scenario.
    pub rows: Vec<Row>,
}

impl Comparison {
    /// The results do not depend on the threads.
    pub fn of(scenarios: Vec<Scenario>) -> Result<Self, RunError> {
        let noise = || try_map(scenarios.len(), |index| check_in_noise(&scenarios[index]));
        let runs = || try_map(scenarios.len(), |index| run(scenarios[index].clone()));
        let (runs, noise) = rayon::join(runs, noise);
        Ok(Self { runs: runs?, noise: noise? })
    }

    pub fn warnings(&self) -> Vec<Warning> {
        self.runs.iter().flat_map(|run| RunReport::of(run).warnings()).collect()
    }

    pub fn table(&self) -> ComparisonTable {
        let scenarios = self.runs.iter().map(|run| run.scenario.name.clone()).collect();
        ComparisonTable {
            scenarios,
            rows: rows(&self.runs.iter().map(|run| &run.metrics).collect::<Vec<_>>(), &self.noise),
        }
    }
}
