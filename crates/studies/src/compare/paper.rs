//! The figures of the paper with results: the runs behind them, and what each shows.

use super::facts::{Fact, paper_facts};
use super::{ADDED_NOISE_STD_N, Comparison};
use crate::run::{Run, RunError, run};
use trocar_base::moments::Moments;
use trocar_detect::calibration::Whiteness;
use trocar_detect::{Phase, PhaseRule};
use trocar_scenario::{Scenario, ScenarioError, Source};

/// The figures of the paper that show results or the method of detection.
pub const FIGURES: [u8; 12] = [4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 15, 16];

const DIRECT: &str = "layers/direct-access";
const PAIR: [&str; 2] = ["paper/classical", "paper/augmented"];

/// Time after a rupture, in s, until the estimate has converged again: its peak is there, and a quiet stretch is not.
const TRANSIENT_S: f64 = 0.5;
/// Time in s over which a change of the stiffness is taken.
const CHANGE_S: f64 = 0.1;
/// Variance of the residual without changes in the paper, in N² (4.3).
pub const PAPER_VARIANCE_N2: f64 = 4e-4;

/// A figure of the paper: its facts and ours.
#[derive(Debug, Clone)]
pub struct PaperFigure {
    /// Its number in the paper.
    pub number: u8,
    /// What the paper's figure shows.
    pub shows: &'static str,
    /// What ours shows.
    pub ours: &'static str,
    /// What differs, and why.
    pub differs: &'static str,
    /// Statements of the paper with the results.
    pub facts: Vec<Fact>,
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

/// The runs behind the figures.
#[derive(Debug, Clone)]
pub struct PaperStudy {
    /// Direct access to the liver: figures 4 and 5.
    pub direct: Run,
    /// The classical and the augmented run: figures 6 to 8, 10, 11, 13, 15 and 16.
    pub pair: Comparison,
    /// The classical run with the paper's noise: figures 9 and 12.
    pub noisy: Run,
    /// The quiet stretches of the classical run.
    pub quiet: Vec<QuietStretch>,
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

impl PaperStudy {
    /// Runs the shipped scenarios.
    ///
    /// # Errors
    /// [`PaperError`].
    pub fn new() -> Result<Self, PaperError> {
        let load = |name: &str, settings: &[String]| Scenario::load(&Source::parse(name), settings);
        let noise = format!("sensor.force_noise_std_n={ADDED_NOISE_STD_N}");
        let (direct, noisy) = (load(DIRECT, &[])?, load(PAIR[0], &[noise])?);
        let pair = PAIR.map(|name| load(name, &[])).into_iter().collect::<Result<Vec<_>, _>>()?;
        let (pair, (direct, noisy)) =
            rayon::join(|| Comparison::of(pair), || rayon::join(|| run(direct), || run(noisy)));
        let pair = pair?;
        let quiet = pair.runs.first().map_or(vec![], quiet_stretches);
        Ok(Self { direct: direct?, pair, noisy: noisy?, quiet })
    }

    /// Returns the residuals of all quiet stretches, in N.
    #[must_use]
    pub fn quiet_residual_n(&self) -> Vec<f64> {
        self.quiet.iter().flat_map(|stretch| &stretch.residual_n).copied().collect()
    }

    /// Returns the squared changes of the noisy force from sample to sample, in N²: the distance of figure 9.
    #[must_use]
    pub fn squared_changes_n2(&self) -> Vec<f64> {
        let force = &self.noisy.trace.measured_force_n;
        let changes = force.windows(2).map(|pair| (pair[1] - pair[0]).powi(2));
        std::iter::once(0.0).take(force.len()).chain(changes).collect()
    }

    /// Returns every figure of [`FIGURES`], with its facts.
    #[must_use]
    pub fn figures(&self) -> Vec<PaperFigure> {
        let shared = paper_facts(&self.pair).unwrap_or_default();
        let figure = |number: u8| {
            let [shows, ours, differs] = texts(number);
            let facts =
                self.own_facts(number).into_iter().chain(shared.iter().filter(|fact| fact.figure == number).cloned());
            PaperFigure { number, shows, ours, differs, facts: facts.collect() }
        };
        FIGURES.map(figure).into()
    }

    fn own_facts(&self, number: u8) -> Vec<Fact> {
        let [classical, ..] = &self.pair.runs[..] else { return vec![] };
        match number {
            4 => self.direct_facts(),
            5 => vec![jump("stiffness, in 0.1 s after the puncture", "discontinuous (3.2.1)", &self.direct, 0)],
            7 => vec![
                jump("stiffness, in 0.1 s after rupture 1", "discontinuous (3.2.2)", classical, 0),
                jump("stiffness, in 0.1 s after rupture 2", "discontinuous (3.2.2)", classical, 1),
            ],
            8 => vec![extraction(classical)],
            10 => vec![distance(classical)],
            11 => self.quiet_facts(),
            9 => vec![self.contrast("smaller peak over the largest value elsewhere", 9)],
            12 => vec![self.contrast("smaller peak over the largest value elsewhere", 12)],
            _ => vec![],
        }
        .into_iter()
        .map(|fact| Fact { figure: number, ..fact })
        .collect()
    }

    fn direct_facts(&self) -> Vec<Fact> {
        let trace = &self.direct.trace;
        let low = trace.tissue_force_n.iter().copied().fold(f64::INFINITY, f64::min);
        let high = trace.tissue_force_n.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let (mean, variance) = mean_and_variance(trace.residual_n.iter().map(|e| e.abs()));
        let std = variance.sqrt();
        let max = trace.residual_n.iter().map(|e| e.abs()).fold(0.0, f64::max);
        vec![
            fact(
                "force, in the paper's sign",
                "-1.45 to 0.37 N (3.2.1)",
                "within 0.2 N",
                format!("{:.2} to {:.2} N", -high, -low),
                (high - 1.45).abs() <= 0.2 && (low + 0.37).abs() <= 0.2,
            ),
            fact(
                "mean absolute error",
                "0.019 N (3.2.1)",
                "at most twice",
                format!("{mean:.4} N"),
                mean <= 2.0 * 0.019,
            ),
            fact(
                "its standard deviation",
                "0.0136 N (3.2.1)",
                "at most twice",
                format!("{std:.4} N"),
                std <= 2.0 * 0.0136,
            ),
            fact(
                "largest transient error",
                "up to 0.32 N (3.2.1)",
                "at most twice",
                format!("{max:.2} N"),
                max <= 0.64,
            ),
        ]
    }

    fn quiet_facts(&self) -> Vec<Fact> {
        let residuals = self.quiet_residual_n();
        let (mean, variance) = mean_and_variance(residuals.iter().copied());
        let mut facts = vec![
            fact("mean", "zero (4.3)", "below σ", format!("{mean:.4} N"), mean.abs() < variance.sqrt()),
            fact(
                "variance σ²",
                "4e-4 N² (4.3)",
                "within a factor of 2",
                format!("{variance:.1e} N²"),
                (0.5..=2.0).contains(&(variance / PAPER_VARIANCE_N2)),
            ),
        ];
        let whole = Whiteness::of(&residuals);
        facts.extend(whole.map(|tests| normality("all stretches, test of Jarque and Bera", &tests)));
        let names = ["before rupture 1", "between the ruptures", "after rupture 2"];
        let each = names.into_iter().zip(&self.quiet);
        facts.extend(each.filter_map(|(name, stretch)| Some(normality(name, stretch.tests.as_ref()?))));
        facts
    }

    /// Returns how clearly a distance shows both ruptures of the noisy run.
    fn contrast(&self, what: &'static str, number: u8) -> Fact {
        let [changes, residuals] = [self.squared_changes_n2(), self.noisy.trace.distance.clone()]
            .map(|distance| peaks(&self.noisy, &distance).map_or(0.0, |(least, elsewhere)| least / elsewhere));
        let (paper, asked, ours) = match number {
            9 => ("no threshold for both (4.1)", "below 1", changes),
            _ => ("two distinct peaks (4.4.3)", "above 1", residuals),
        };
        fact(what, paper, asked, format!("{ours:.2}"), if number == 9 { ours < 1.0 } else { ours > 1.0 })
    }
}

/// The mean of values and their variance about it; 0 without values.
fn mean_and_variance(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let mut moments = Moments::default();
    values.into_iter().for_each(|value| moments.add(value));
    (moments.mean, moments.squares / moments.count.max(1) as f64)
}

fn fact(what: &'static str, paper: &'static str, asked: &'static str, ours: String, holds: bool) -> Fact {
    Fact { figure: 0, what, paper, asked, ours, holds }
}

/// Returns the test of normality of residuals.
fn normality(what: &'static str, tests: &Whiteness) -> Fact {
    let Whiteness { samples, skewness, excess_kurtosis, jarque_bera, jarque_bera_p: p, .. } = tests;
    let ours = format!(
        "{samples} samples, skewness {skewness:.2}, excess kurtosis {excess_kurtosis:.2}, JB {jarque_bera:.1}, p {p:.1e}"
    );
    fact(what, "Gaussian (4.3)", "p at least 0.01", ours, *p >= 0.01)
}

/// Returns the change of the stiffness at a rupture of a run, beside its change before.
fn jump(what: &'static str, paper: &'static str, run: &Run, rupture: usize) -> Fact {
    let trace = &run.trace;
    let stiffness = |time_s: f64| {
        let tick = trace.time_s.partition_point(|time| *time < time_s).min(trace.len().saturating_sub(1));
        trace.stiffness_n_per_m[tick]
    };
    let changes = run.metrics.ruptures.get(rupture).map(|rupture| {
        let [before, at, after] = [-CHANGE_S, 0.0, CHANGE_S].map(|offset_s| stiffness(rupture.time_s + offset_s));
        (at - before, after - at)
    });
    let ours =
        changes.map_or("—".to_owned(), |(before, after)| format!("{after:+.0} N/m, before it {before:+.0} N/m"));
    let holds = changes.is_some_and(|(before, after)| before > 0.0 && -after > before);
    fact(what, paper, "falls faster than it rose", ours, holds)
}

/// Returns when the fast extraction is.
fn extraction(run: &Run) -> Fact {
    let trace = &run.trace;
    let lowest = trace.time_s.iter().zip(&trace.tissue_force_n).min_by(|a, b| a.1.total_cmp(b.1));
    let at = lowest.map_or(f64::NAN, |(time_s, _)| *time_s);
    fact("fast extraction", "14.5 s (4.1)", "within 0.5 s", format!("{at:.2} s"), (at - 14.5).abs() <= 0.5)
}

/// Returns whether the distance of the run is that of the diagram.
fn distance(run: &Run) -> Fact {
    let trace = &run.trace;
    let differences = trace.residual_n.iter().zip(&trace.distance).map(|(e, s)| (s - e * e).abs());
    let max = differences.fold(0.0, f64::max);
    fact("distance less the squared error, at most", "s = e² (4.4.3)", "0", format!("{max:.0e} N²"), max <= 1e-12)
}

/// Returns the smaller of the peaks at the ruptures, and the largest value elsewhere.
fn peaks(run: &Run, distance: &[f64]) -> Option<(f64, f64)> {
    let ruptures_s: Vec<f64> = run.metrics.ruptures.iter().map(|rupture| rupture.time_s).collect();
    let mut at_ruptures = vec![0.0_f64; ruptures_s.len()];
    let mut elsewhere = 0.0_f64;
    for (time_s, value) in run.trace.time_s.iter().zip(distance) {
        let near = ruptures_s.iter().position(|rupture_s| (0.0..=TRANSIENT_S).contains(&(time_s - rupture_s)));
        let peak = near.map_or(&mut elsewhere, |index| &mut at_ruptures[index]);
        *peak = peak.max(*value);
    }
    Some((at_ruptures.into_iter().reduce(f64::min)?, elsewhere))
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

const GENERATED: &str =
    "The paper's recording was never published; a generator makes one from the facts that the paper states.";

/// Returns what the paper's figure shows, what ours shows, and what differs.
fn texts(number: u8) -> [&'static str; 3] {
    match number {
        4 => [
            "Measured and estimated force, and the absolute error of the estimate, for direct access to a liver.",
            "The same signals of a simulated insertion through capsule and organ.",
            "A simulated tissue instead of a pig: the insertion is faster, and has one puncture and no small vessels.",
        ],
        5 => [
            "Estimated stiffness and damping of the same insertion; the stiffness falls at the puncture of the liver.",
            "The same estimates, with a band of two standard errors.",
            "The tissue is simulated, so its stiffness and damping are other numbers; the fall is what compares.",
        ],
        6 => [
            "Measured and estimated force, and the absolute error, for an insertion through the skin.",
            "The same signals of the in-vivo-like recording.",
            GENERATED,
        ],
        7 => [
            "Estimated stiffness and damping of the insertion through the skin: bounded, and discontinuous at the ruptures.",
            "The same estimates of the in-vivo-like recording, with a band of two standard errors.",
            "The generator knows loads and drops, not the animal's parameters: their values differ.",
        ],
        8 => [
            "The force of the insertion that is used for the detection: two ruptures, and a fast extraction that is none.",
            "The force of the in-vivo-like recording with its ruptures.",
            "Forces are positive here when they resist insertion; the paper has the opposite sign.",
        ],
        9 => [
            "The squared change of the force from sample to sample, with added noise of 6.25e-4 N²: hard to threshold.",
            "The same quantity of the in-vivo-like recording with the same noise.",
            GENERATED,
        ],
        10 => [
            "The principle: the error of the estimated force is the residual, from which the detector decides.",
            "The chain that every run computes.",
            "Nothing: residual, squared distance, CUSUM and threshold are the paper's.",
        ],
        11 => [
            "The distribution of the prediction error without ruptures, and a Gaussian of variance 4e-4 N².",
            "The prediction error during insertion, without the 0.5 s after each rupture.",
            "The estimator ignores errors within its dead zone, which leaves a mean that differs from stretch to stretch. The \
             errors of all stretches together are therefore not Gaussian, and successive errors are correlated, which the test \
             does not allow for.",
        ],
        12 => [
            "The squared prediction error with the noise of figure 9: two distinct peaks.",
            "The same distance of the in-vivo-like recording with that noise.",
            GENERATED,
        ],
        13 => [
            "The decision function, and the force with the detected ruptures.",
            "The same, of the in-vivo-like recording, with the paper's drift and threshold.",
            "The paper's text states 5.22 s for the first rupture in one place and 5.52 s in another; 5.52 s is used here.",
        ],
        15 => [
            "Forces and positions of master and slave around the first rupture, by classical teleoperation.",
            "The same signals of the classical run.",
            "Forces are positive here when they resist insertion; the paper has the opposite sign.",
        ],
        _ => [
            "The same with augmentation: the slave is frozen for about 0.5 s while the master moves on.",
            "The same signals of the augmented run, with the time that the slave is frozen and re-engaging.",
            "The paper does not say how the slave returns to the master; here a ramp re-engages it.",
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_texts_and_facts_of_every_figure_are_there_and_quiet_stretches_avoid_the_ruptures() {
        let study = PaperStudy::new().expect("runs");
        let figures = study.figures();
        assert_eq!(figures.iter().map(|figure| figure.number).collect::<Vec<_>>(), FIGURES);
        for figure in &figures {
            assert!(!figure.facts.is_empty(), "figure {}", figure.number);
            assert!(
                figure
                    .facts
                    .iter()
                    .all(|fact| fact.figure == figure.number && fact.ours.contains(|c: char| c.is_ascii_digit()))
            );
        }
        assert_eq!(study.quiet.len(), 3);
        for stretch in &study.quiet {
            let (from, to) = stretch.from_to_s;
            for rupture in &study.pair.runs[0].metrics.ruptures {
                assert!(to < rupture.time_s || from >= rupture.time_s + TRANSIENT_S - 1e-9, "{from} to {to}");
            }
        }
        // Only normality may differ from the paper.
        for fact in figures.iter().flat_map(|figure| &figure.facts).filter(|fact| !fact.holds) {
            assert_eq!(fact.paper, "Gaussian (4.3)", "{fact:?}");
        }
    }
}
