//! Scenarios side by side: the table of their metrics, their standing in noise, and the paper's facts.

mod facts;
mod noise;
mod seeds;
mod table;

pub use facts::{Fact, paper_facts};
pub use noise::{ADDED_NOISE_STD_N, NoiseCheck, check_in_noise};
pub use seeds::{MAX_SEEDS, SeedStudy, Spread, SpreadRow};
pub use table::{Row, rows};

use rayon::prelude::*;
use serde::Serialize;

use crate::run::{Run, RunError, run};
use crate::scenario::Scenario;

/// Scenarios that were run to be compared.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// The runs, in the order in which they were given.
    pub runs: Vec<Run>,
    /// Each run's standing in noise.
    pub noise: Vec<NoiseCheck>,
}

/// What a comparison says in numbers: the metrics side by side, and the detection in noise.
#[derive(Debug, Clone, Serialize)]
pub struct ComparisonTable {
    /// The scenarios' names.
    pub scenarios: Vec<String>,
    /// A row per metric, a value per scenario.
    pub rows: Vec<Row>,
}

impl Comparison {
    /// Runs scenarios, in parallel, each also in noise. The results do not depend on the number of threads.
    ///
    /// # Errors
    /// The first scenario's [`RunError`].
    pub fn of(scenarios: Vec<Scenario>) -> Result<Self, RunError> {
        let noise = || scenarios.par_iter().map(check_in_noise).collect::<Result<Vec<_>, _>>();
        let runs = || scenarios.par_iter().cloned().map(run).collect::<Result<Vec<_>, _>>();
        let (runs, noise) = rayon::join(runs, noise);
        Ok(Self { runs: runs?, noise: noise? })
    }

    /// The table of the metrics.
    #[must_use]
    pub fn table(&self) -> ComparisonTable {
        let scenarios = self.runs.iter().map(|run| run.scenario.name.clone()).collect();
        ComparisonTable {
            scenarios,
            rows: rows(&self.runs.iter().map(|run| &run.metrics).collect::<Vec<_>>(), &self.noise),
        }
    }
}
