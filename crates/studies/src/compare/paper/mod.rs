mod detection;
mod document;
mod drawn;
mod estimation;
mod measures;
mod statement;
mod teleoperation;
mod texts;
mod variations;

pub use document::PaperFile;
pub use statement::{Judgement, Statement};

pub use variations::NOISE_SEEDS;

use super::ADDED_NOISE_STD_N;
use crate::run::{Run, RunError, run};
use drawn::{PUNCTURE_S, in_the_papers_terms};
use trocar_base::parallel::try_map;
use trocar_detect::calibration::Whiteness;
use trocar_detect::{Phase, PhaseRule};
use trocar_scenario::{Scenario, ScenarioError, Source};
use variations::{NoisySeed, OfSettings, Varied};

/// Figures 2 and 3 are photographs.
pub const FIGURES: [u8; 14] = [1, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16];

/// Ordered as in [`PaperStudy`].
const RUNS: [(&str, &[&str]); 12] = [
    ("layers/direct-access", &[]),
    ("layers/direct-access", &["estimator.parameters=stiffness"]),
    ("paper/classical", &[]),
    ("paper/classical", &["estimator.parameters=stiffness"]),
    // This threshold α_0 is never reached.
    ("paper/classical", &["estimator.reset_threshold=1e9"]),
    ("paper/classical", &["estimator.dead_zone_n=0"]),
    ("paper/classical", &["detector.distance=parameter-change"]),
    ("paper/classical", &["detector.motion=any", "detector.drop_only=false"]),
    ("paper/augmented", &[]),
    ("paper/amplified", &[]),
    ("paper/classical", &["master.coupling=as-printed"]),
    ("paper/classical", &["slave.damping=as-printed"]),
];

/// Time after a rupture until the estimate has converged again.
const TRANSIENT_S: f64 = 0.5;
/// Variance of the residual without changes in the paper (4.3).
pub const PAPER_VARIANCE_N2: f64 = 4e-4;

#[derive(Debug, Clone)]
pub struct PaperFigure {
    pub number: Option<u8>,
    pub shows: &'static str,
    pub ours: &'static str,
    pub differs: &'static str,
    pub statements: Vec<Statement>,
}

#[derive(Debug, Clone)]
pub struct QuietStretch {
    pub from_to_s: (f64, f64),
    pub residual_n: Vec<f64>,
    pub tests: Option<Whiteness>,
}

#[derive(Debug, Clone)]
pub struct PaperStudy {
    direct: Run,
    direct_stiffness: Run,
    classical: Run,
    classical_stiffness: Run,
    no_reset: Run,
    no_dead_zone: Run,
    /// With the distance of eq. 26.
    vector: Run,
    /// With alarms in any motion, and at a rise of the force.
    unarmed: Run,
    augmented: Run,
    amplified: Run,
    master_as_printed: Run,
    slave_as_printed: Run,
    /// With the paper's noise: figures 9 and 12.
    noisy: Run,
    noisy_changes_n2: Vec<f64>,
    noisy_seeds: Varied<Vec<NoisySeed>>,
    falls: Varied<Run>,
    direct_settings: Varied<OfSettings>,
    classical_settings: Varied<OfSettings>,
    /// Mean absolute errors of direct access, with K and B and with K alone.
    direct_default_n: [f64; 2],
    /// For the squared residual, and for eq. 26.
    thresholds: [Varied<Option<(f64, f64)>>; 2],
    quiet: Vec<QuietStretch>,
    drawn: [Run; 3],
}

fn load(name: &str, settings: &[String]) -> Result<Scenario, ScenarioError> {
    Scenario::load(&Source::parse(name), settings)
}

impl PaperStudy {
    pub fn new() -> Result<Self, RunError> {
        let of_settings = |index: usize| {
            let (name, settings) = RUNS[index];
            let settings: Vec<String> = settings.iter().map(|&setting| setting.to_owned()).collect();
            run(load(name, &settings)?)
        };
        let runs: [Run; RUNS.len()] =
            try_map(RUNS.len(), of_settings)?.try_into().unwrap_or_else(|_| unreachable!("a run for each of RUNS"));
        let [
            direct,
            direct_stiffness,
            classical,
            classical_stiffness,
            no_reset,
            no_dead_zone,
            vector,
            unarmed,
            augmented,
            amplified,
            master_as_printed,
            slave_as_printed,
        ] = runs;
        let noisy = run(load("paper/classical", &[format!("sensor.force_noise_std_n={ADDED_NOISE_STD_N}")])?)?;
        let shift_s = measures::ruptures_s(&direct).first().map_or(0.0, |puncture_s| PUNCTURE_S - puncture_s);
        let drawn = [(&direct, shift_s), (&classical, 0.0), (&augmented, 0.0)]
            .map(|(run, shift_s)| in_the_papers_terms(run, shift_s));
        Ok(Self {
            noisy_changes_n2: measures::squared_changes_n2(&noisy),
            noisy_seeds: variations::in_noise()?,
            falls: variations::over_falls(&classical.scenario)?,
            direct_settings: variations::over_settings("layers/direct-access")?,
            classical_settings: variations::over_settings("paper/classical")?,
            direct_default_n: variations::with_default_estimator("layers/direct-access")?,
            thresholds: [
                variations::working_thresholds("squared-residual")?,
                variations::working_thresholds("parameter-change")?,
            ],
            quiet: quiet_stretches(&classical),
            direct,
            direct_stiffness,
            classical,
            classical_stiffness,
            no_reset,
            no_dead_zone,
            vector,
            unarmed,
            augmented,
            amplified,
            master_as_printed,
            slave_as_printed,
            noisy,
            drawn,
        })
    }

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

fn quiet_residual_n(quiet: &[QuietStretch]) -> Vec<f64> {
    quiet.iter().flat_map(|stretch| &stretch.residual_n).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(figures: &[PaperFigure], judgement: Judgement) -> Vec<&str> {
        let statements = figures.iter().flat_map(|figure| &figure.statements);
        statements.filter(|statement| statement.judgement == judgement).map(|statement| &*statement.number).collect()
    }

    #[test]
    fn every_statement_has_its_judgement() {
        let study = PaperStudy::new().expect("runs");
        let figures = study.figures();
        let drawn: Vec<u8> = figures.iter().filter_map(|figure| figure.number).collect();
        assert_eq!(drawn, FIGURES);
        // The reasons beside the judgements explain them; a changed judgement needs a new reason.
        let reproduced = numbers(&figures, Judgement::Reproduced);
        assert_eq!(
            reproduced,
            [
                "4f", "5a", "7a", "7b", "7c", "7e", "8c", "10a", "10b", "10c", "10d", "12b", "13a", "13f", "14a",
                "14b", "14c", "15a", "16c", "16d", "Ab"
            ]
        );
        let contradicted = numbers(&figures, Judgement::Contradicted);
        assert_eq!(contradicted, ["5b", "6c", "9b", "11a", "11c", "11d", "13b", "Ae"]);
        for statement in figures.iter().flat_map(|figure| &figure.statements) {
            assert!(!statement.ours.contains("NaN") && !statement.why.contains("NaN"), "{statement:?}");
            assert!(
                statement.why.ends_with('.') && !statement.ours.is_empty() && !statement.paper.is_empty(),
                "{statement:?}"
            );
            assert!(statement.judgement == Judgement::NotCheckable || !statement.condition.is_empty(), "{statement:?}");
        }
        for seeds in &study.noisy_seeds.0 {
            let contrasts = seeds.iter().map(|seed| seed.derivative_contrast.to_bits());
            let different = contrasts.collect::<std::collections::BTreeSet<u64>>();
            assert_eq!(different.len(), NOISE_SEEDS, "the noise is compared over different seeds");
        }
        // The damping carries the force at the puncture, and is negative between the ruptures.
        for (number, ours) in
            [("5b", "K p 0.07 N, B v 1.31 N of 1.41 N"), ("7e", "B is -100 N·s/m between the ruptures")]
        {
            let mut statements = figures.iter().flat_map(|figure| &figure.statements);
            assert!(statements.any(|statement| statement.number == number && statement.ours == ours), "{number}");
        }
    }

    #[test]
    fn quiet_stretches_avoid_the_ruptures() {
        let classical = run(load("paper/classical", &[]).expect("shipped")).expect("runs");
        let quiet = quiet_stretches(&classical);
        assert_eq!(quiet.len(), 3);
        for stretch in &quiet {
            let (from, to) = stretch.from_to_s;
            for rupture in &classical.metrics.ruptures {
                assert!(to < rupture.time_s || from >= rupture.time_s + TRANSIENT_S - 1e-9, "{from} to {to}");
            }
        }
    }
}
