//! The figures of the paper with results: the runs behind them, and what each shows.

mod detection;
mod document;
mod drawn;
mod estimation;
mod measures;
mod statement;
mod teleoperation;
mod texts;

pub use statement::{Judgement, Statement};

use super::ADDED_NOISE_STD_N;
use crate::run::{Run, RunError, measure, run};
use drawn::{PUNCTURE_S, in_the_papers_terms};
use trocar_base::parallel::try_map;
use trocar_detect::calibration::Whiteness;
use trocar_detect::{Phase, PhaseRule};
use trocar_scenario::{Scenario, ScenarioError, Source};

/// The figures of the paper that are drawn. Figures 2 and 3 are photographs.
pub const FIGURES: [u8; 14] = [1, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16];

/// The runs and their settings, in the order of [`PaperStudy`].
const RUNS: [(&str, &[&str]); 11] = [
    ("layers/direct-access", &[]),
    ("layers/direct-access", &["estimator.parameters=stiffness"]),
    ("paper/classical", &[]),
    ("paper/classical", &["estimator.parameters=stiffness"]),
    // No reset: α_0 is never reached.
    ("paper/classical", &["estimator.reset_threshold=1e9"]),
    ("paper/classical", &["detector.distance=parameter-change"]),
    ("paper/augmented", &[]),
    ("paper/amplified", &[]),
    ("paper/classical", &["master.coupling=as-printed"]),
    ("paper/classical", &["slave.damping=as-printed"]),
    ("paper/classical", &["estimator.dead_zone_n=0"]),
];

/// Number of seeds of the added noise.
pub const NOISE_SEEDS: usize = 20;

/// Time after a rupture, in s, until the estimate has converged again: its peak is there, and a quiet stretch is not.
const TRANSIENT_S: f64 = 0.5;
/// Variance of the residual without changes in the paper, in N² (4.3).
pub const PAPER_VARIANCE_N2: f64 = 4e-4;

/// A figure of the paper, or what no figure shows, with its statements.
#[derive(Debug, Clone)]
pub struct PaperFigure {
    /// Its number in the paper; `None` for the statements that no figure shows.
    pub number: Option<u8>,
    /// What the paper's figure shows.
    pub shows: &'static str,
    /// What ours shows.
    pub ours: &'static str,
    /// What differs, and why.
    pub differs: &'static str,
    /// Statements of the paper with the results.
    pub statements: Vec<Statement>,
}

/// A part of an insertion without a sudden change.
#[derive(Debug, Clone)]
pub struct QuietStretch {
    /// Its first and last time, in s.
    pub from_to_s: (f64, f64),
    /// Its residuals, in N.
    pub residual_n: Vec<f64>,
    /// Its tests; `None` for a stretch that is too short.
    pub tests: Option<Whiteness>,
}

/// The insertion with the added noise of one seed.
#[derive(Debug, Clone, Copy)]
struct NoisySeed {
    /// The smaller peak of the squared change at the ruptures over its largest value elsewhere.
    derivative_contrast: f64,
    /// The same of the squared residual.
    residual_contrast: f64,
    /// True if the detector announces both ruptures and nothing else.
    residual_detects: bool,
    /// The same of the force less its moving average.
    moving_average_detects: bool,
}

/// The runs behind the figures.
#[derive(Debug, Clone)]
pub struct PaperStudy {
    direct: Run,
    direct_stiffness: Run,
    classical: Run,
    classical_stiffness: Run,
    /// Without covariance resetting.
    no_reset: Run,
    /// With the distance of eq. 26.
    vector: Run,
    augmented: Run,
    amplified: Run,
    master_as_printed: Run,
    slave_as_printed: Run,
    no_dead_zone: Run,
    /// The classical run with the paper's noise: figures 9 and 12.
    noisy: Run,
    noisy_seeds: Vec<NoisySeed>,
    /// The quiet stretches of the classical run.
    quiet: Vec<QuietStretch>,
    /// The direct access, the classical and the augmented run with the signs and the time of the paper.
    drawn: [Run; 3],
    noisy_changes_n2: Vec<f64>,
}

/// The error of a study.
#[derive(Debug, thiserror::Error)]
pub enum PaperError {
    /// A shipped scenario cannot be loaded.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// A run failed.
    #[error(transparent)]
    Run(#[from] RunError),
}

fn load(name: &str, settings: &[String]) -> Result<Scenario, ScenarioError> {
    Scenario::load(&Source::parse(name), settings)
}

/// The classical scenario with the paper's noise, further settings included.
fn noisy_scenario(further: &[String]) -> Result<Scenario, ScenarioError> {
    let noise = format!("sensor.force_noise_std_n={ADDED_NOISE_STD_N}");
    load("paper/classical", &[&[noise], further].concat())
}

impl NoisySeed {
    fn new(seed: usize) -> Result<Self, PaperError> {
        let seed = format!("simulation.seed={seed}");
        let noisy = run(noisy_scenario(std::slice::from_ref(&seed))?)?;
        let baseline = measure(&noisy_scenario(&[seed, "detector.distance=moving-average".to_owned()])?)?;
        let detects = |ruptures: usize, missed: u64, false_alarms: u64| ruptures == 2 && missed + false_alarms == 0;
        let metrics = &noisy.metrics;
        Ok(Self {
            derivative_contrast: measures::contrast(&noisy, &measures::squared_changes_n2(&noisy)),
            residual_contrast: measures::contrast(&noisy, &noisy.trace.distance),
            residual_detects: detects(metrics.ruptures.len(), metrics.missed_ruptures, metrics.false_alarms),
            moving_average_detects: detects(baseline.ruptures.len(), baseline.missed_ruptures, baseline.false_alarms),
        })
    }
}

impl PaperStudy {
    /// Runs the shipped scenarios.
    ///
    /// # Errors
    /// [`PaperError`].
    pub fn new() -> Result<Self, PaperError> {
        let of_settings = |index: usize| {
            let (name, settings) = RUNS[index];
            let settings: Vec<String> = settings.iter().map(|&setting| setting.to_owned()).collect();
            Ok::<_, PaperError>(run(load(name, &settings)?)?)
        };
        let (runs, noise) = rayon::join(
            || try_map(RUNS.len(), of_settings),
            || {
                Ok::<_, PaperError>((
                    run(noisy_scenario(&[])?)?,
                    try_map(NOISE_SEEDS, |index| NoisySeed::new(index + 1))?,
                ))
            },
        );
        let (noisy, noisy_seeds) = noise?;
        let runs: [Run; RUNS.len()] = runs?.try_into().unwrap_or_else(|_| unreachable!("one run for each of RUNS"));
        let [
            direct,
            direct_stiffness,
            classical,
            classical_stiffness,
            no_reset,
            vector,
            augmented,
            amplified,
            master_as_printed,
            slave_as_printed,
            no_dead_zone,
        ] = runs;
        let shift_s = measures::ruptures_s(&direct).first().map_or(0.0, |puncture_s| PUNCTURE_S - puncture_s);
        let drawn = [(&direct, shift_s), (&classical, 0.0), (&augmented, 0.0)]
            .map(|(run, shift_s)| in_the_papers_terms(run, shift_s));
        Ok(Self {
            quiet: quiet_stretches(&classical),
            noisy_changes_n2: measures::squared_changes_n2(&noisy),
            direct,
            direct_stiffness,
            classical,
            classical_stiffness,
            no_reset,
            vector,
            augmented,
            amplified,
            master_as_printed,
            slave_as_printed,
            no_dead_zone,
            noisy,
            noisy_seeds,
            drawn,
        })
    }

    /// Returns the residuals of all quiet stretches, in N.
    fn quiet_residual_n(&self) -> Vec<f64> {
        self.quiet.iter().flat_map(|stretch| &stretch.residual_n).copied().collect()
    }

    /// Returns every figure of [`FIGURES`], then the statements that no figure shows, each with its statements.
    #[must_use]
    pub fn figures(&self) -> Vec<PaperFigure> {
        let figure = |number: Option<u8>| {
            let [shows, ours, differs] = texts::texts(number);
            let mut statements = self.statements(number);
            let group = number.map_or_else(|| "A".to_owned(), |number| number.to_string());
            for (letter, statement) in ('a'..='z').zip(&mut statements) {
                statement.number = format!("{group}{letter}");
            }
            PaperFigure { number, shows, ours, differs, statements }
        };
        FIGURES.into_iter().map(Some).chain([None]).map(figure).collect()
    }

    fn statements(&self, number: Option<u8>) -> Vec<Statement> {
        match number {
            Some(1) => self.phases(),
            Some(4) => self.direct_access(),
            Some(5) => self.parameters_of_direct_access(),
            Some(6) => self.through_the_skin(),
            Some(7) => self.parameters_through_the_skin(),
            Some(8) => self.insertion(),
            Some(9) => self.direct_filtering(),
            Some(10) => self.residual_generation(),
            Some(11) => self.distribution(),
            Some(12) => self.peaks(),
            Some(13) => self.decisions(),
            Some(14) => self.scheme(),
            Some(15) => self.classical_teleoperation(),
            Some(16) => self.augmented_teleoperation(),
            _ => [self.estimator(), self.appendix()].concat(),
        }
    }
}

/// Returns the parts of an insertion that are away from its ruptures.
fn quiet_stretches(run: &Run) -> Vec<QuietStretch> {
    let trace = &run.trace;
    let phases =
        PhaseRule::default().split(&trace.slave_position_m, run.scenario.grid.tick_s(), run.scenario.contact_m);
    let before_withdrawal = || phases.iter().take_while(|phase| phase.phase != Phase::Withdrawal);
    let mut insertion = before_withdrawal().filter(|phase| phase.phase == Phase::Insertion);
    let mut is_quiet = vec![false; trace.len()];
    if let Some(first) = insertion.next() {
        let end = insertion.last().unwrap_or(first).samples.end;
        is_quiet[first.samples.start..end].fill(true);
    }
    for rupture in &run.metrics.ruptures {
        let from = trace.time_s.partition_point(|time_s| *time_s < rupture.time_s);
        let to = trace.time_s.partition_point(|time_s| *time_s < rupture.time_s + TRANSIENT_S);
        is_quiet[from..to].fill(false);
    }
    let mut stretches = vec![];
    let mut start = 0;
    for part in is_quiet.chunk_by(|a, b| a == b) {
        let samples = start..start + part.len();
        start = samples.end;
        if part[0] {
            let residual_n = trace.residual_n[samples.clone()].to_vec();
            let from_to_s = (trace.time_s[samples.start], trace.time_s[samples.end - 1]);
            stretches.push(QuietStretch { from_to_s, tests: Whiteness::of(&residual_n), residual_n });
        }
    }
    stretches
}
