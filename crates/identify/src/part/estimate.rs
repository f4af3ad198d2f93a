use trocar_base::interrupt;
use trocar_base::warning::Warning;
use trocar_document::TextFile;

use super::signals::Signals;
use super::{
    Candidate, Chosen, Conclusions, NamedRupture, Part, PartSystem, Range, Simulation, Spec, plausibility, tissue,
};
use crate::IdentifyError;
use crate::actuator::Bounded;
use crate::estimate::{FITTED_SHARE, Role, mean_fit};
use crate::intervals::intervals;
use crate::measured::{fit_percent, span};
use crate::problem::Problem;
use crate::whiteness::Whiteness;

/// Minimum relative range of a held-out part.
const EXCITED_SHARE: f64 = 1.0 / 3.0;

#[derive(Debug, Clone, PartialEq)]
pub struct PartRequest {
    pub training: Vec<Signals>,
    pub predictions: Vec<Signals>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct PartFit {
    /// The part before the rupture of a tissue.
    pub signals: Signals,
    pub role: Role,
    /// Force in N, or position in m for a master; `None` if the simulation diverges.
    pub simulated: Option<Vec<f64>>,
    /// `100 (1 - |simulated - measured| / |measured - mean|)` with 2-norms.
    pub fit_percent: Option<f64>,
    pub whiteness: Option<Whiteness>,
}

/// Relative to the smallest one; the simplest structure within it is chosen.
const TOLERANCE: f64 = 1.05;

/// Maximum ratio of an essential parameter in equal solutions.
const OTHER_RATIO: f64 = 2.0;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Criterion {
    /// Fit on held-out parts.
    HeldOut,
    /// Bayes' information criterion, for held-out parts with too little motion.
    Bayes,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Compared {
    pub(crate) key: &'static str,
    pub(crate) name: &'static str,
    /// On the last third of the training recordings; `None` if it diverges.
    pub(crate) held_out_percent: Option<f64>,
    /// The smallest is the best.
    pub(crate) bayes: f64,
}

#[derive(Debug, Clone, PartialEq)]
pub struct PartIdentification {
    pub part: Part,
    pub fits: Vec<PartFit>,
    pub warnings: Vec<Warning>,
    /// Such as `kelvin-voigt`.
    pub structure: &'static str,
    pub(crate) criterion: Criterion,
    pub(crate) compared: Vec<Compared>,
    pub(crate) parameters: Vec<(Spec, Bounded)>,
    pub(crate) open: Vec<String>,
    pub(crate) file: TextFile,
}

impl PartIdentification {
    pub fn scenario(&self) -> &str {
        &self.file.text
    }

    pub fn mean_fit_percent(&self, role: Role) -> Option<f64> {
        mean_fit(self.fits.iter().filter(|fit| fit.role == role).map(|fit| fit.fit_percent))
    }

    pub fn parameter(&self, key: &str) -> Option<(f64, [f64; 2])> {
        let (_, bounded) = self.parameters.iter().find(|(spec, _)| spec.key == key)?;
        Some((bounded.value, [bounded.low, bounded.high]))
    }
}

struct Fitted<'a> {
    problem: Problem<PartSystem<'a>>,
    values: Vec<f64>,
    squares: f64,
    /// Another start ends at other essential parameters with nearly the same error.
    is_ambiguous: bool,
}

/// `progress` receives the numbers of finished and of all steps.
pub fn identify_part(
    part: Part,
    request: PartRequest,
    progress: impl Fn(usize, usize),
) -> Result<PartIdentification, IdentifyError> {
    let warnings: Vec<Warning> =
        request.training.iter().chain(&request.predictions).flat_map(|one| plausibility::warnings(part, one)).collect();
    let (training, ruptures) = whole(part, request.training)?;
    let (predictions, _) = whole(part, request.predictions)?;
    if training.is_empty() {
        return Err(IdentifyError::NoTraining);
    }
    let candidates = part.candidates(&training)?;
    let (mut done, steps) = (0, 2 * candidates.len() + 1);
    let mut finished = || {
        done += 1;
        progress(done, steps);
    };
    let early: Vec<Signals> = training.iter().map(|one| one.before(cut(one))).collect();
    let mut fitted = vec![];
    let mut compared = vec![];
    for candidate in &candidates {
        let held_out_percent =
            solved(part, candidate, &early).and_then(|one| held_out(part, candidate, &one.values, &training));
        finished();
        let one = solved(part, candidate, &training);
        finished();
        compared.push(Compared { key: candidate.key, name: candidate.name, held_out_percent, bayes: f64::INFINITY });
        fitted.push(one);
    }
    let samples = effective_samples(&fitted);
    for (compared, fitted) in compared.iter_mut().zip(&fitted) {
        let Some(fitted) = fitted else { continue };
        compared.bayes = samples * fitted.squares.max(1e-300).ln() + fitted.values.len() as f64 * samples.ln();
    }
    let is_excited = |one: &Signals| {
        let predicted = one.predicted(part);
        span(&predicted[cut(one)..]) >= EXCITED_SHARE * span(predicted)
    };
    let criterion = if training.iter().all(is_excited) { Criterion::HeldOut } else { Criterion::Bayes };
    let mut order = ordered(&compared, criterion);
    order.retain(|index| fitted[*index].is_some());
    let bounded = |index: usize| {
        let fitted = fitted[index].as_ref()?;
        Some((index, bounds(part, &candidates[index], fitted), fitted))
    };
    let chosen = order.iter().filter_map(|index| bounded(*index)).find(|(index, bounds, fitted)| {
        let Candidate { specs, essential, .. } = &candidates[*index];
        let is_told = |(spec, bounded): (&Spec, &Bounded)| {
            !essential.contains(&spec.key) || (bounded.low > 0.0 && bounded.high.is_finite())
        };
        !fitted.is_ambiguous && specs.iter().zip(bounds).all(is_told)
    });
    let (index, bounds, fitted) = chosen.ok_or(IdentifyError::Diverges)?;
    let candidate = &candidates[index];
    let chosen = Chosen { candidate, values: &fitted.values, ruptures: &ruptures };
    let Conclusions { open, file } = part.conclusions(&training, &chosen);
    let fit = |signals: &Signals, role| fit(part, signals.clone(), role, candidate, &fitted.values);
    let trained = training.iter().map(|one| fit(one, Role::Training));
    let fits = trained.chain(predictions.iter().map(|one| fit(one, Role::Prediction))).collect();
    let parameters = candidate.specs.iter().copied().zip(bounds.iter().copied()).collect();
    finished();
    Ok(PartIdentification {
        part,
        fits,
        warnings,
        structure: candidate.key,
        criterion,
        compared,
        parameters,
        open,
        file,
    })
}

fn whole(part: Part, recordings: Vec<Signals>) -> Result<(Vec<Signals>, Vec<NamedRupture>), IdentifyError> {
    let mut ruptures = vec![];
    let mut whole = vec![];
    for recording in recordings {
        let (recording, rupture) = if part == Part::Tissue { tissue::intact(recording)? } else { (recording, None) };
        ruptures.extend(rupture.map(|rupture| (recording.name.clone(), rupture)));
        whole.push(recording);
    }
    Ok((whole, ruptures))
}

fn cut(one: &Signals) -> usize {
    (FITTED_SHARE * one.len() as f64) as usize
}

/// Tries all starts; `None` if every simulation diverges.
fn solved<'a>(part: Part, candidate: &'a Candidate, recordings: &'a [Signals]) -> Option<Fitted<'a>> {
    let system = PartSystem { part, specs: &candidate.specs, simulate: &candidate.simulate, recordings };
    let free: Vec<usize> = (0..candidate.specs.len()).collect();
    let solve = |start: &Vec<f64>| {
        interrupt::check();
        Problem::new(system, free.clone(), start.clone()).solve()
    };
    let solutions: Vec<(f64, Problem<PartSystem<'a>>)> =
        candidate.starts.iter().map(solve).filter(|solution| solution.0.is_finite()).collect();
    let best = solutions.iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
    let is_other = |values: &[f64]| {
        let ratio = |key: &&str| candidate.value(values, key) / candidate.value(&best.1.model(), key);
        candidate.essential.iter().any(|key| !(1.0 / OTHER_RATIO..=OTHER_RATIO).contains(&ratio(key)))
    };
    let close = solutions.iter().filter(|solution| solution.0 <= TOLERANCE.powi(2) * best.0);
    let is_ambiguous = close.map(|solution| solution.1.model()).any(|values| is_other(&values));
    let problem = best.1.clone();
    let mut values = problem.model();
    (system.simulate)(&values, &recordings[0])?;
    // The optimiser drove these to their bound of 0.
    for ((value, spec), start) in values.iter_mut().zip(&candidate.specs).zip(&candidate.starts[0]) {
        if spec.range == Range::Positive && *value < 1e-6 * start {
            *value = 0.0;
        }
    }
    let squares = sum_of_squares(&problem, &values);
    Some(Fitted { problem, values, squares, is_ambiguous })
}

fn sum_of_squares(problem: &Problem<PartSystem<'_>>, values: &Vec<f64>) -> f64 {
    use crate::system::System as _;
    problem.system().errors(values).iter().map(|error| error * error).sum()
}

fn held_out(part: Part, candidate: &Candidate, values: &[f64], training: &[Signals]) -> Option<f64> {
    let fits = training.iter().map(|one| {
        let (simulated, from) = ((candidate.simulate)(values, one)?, cut(one));
        // Relative to the variation of a third of the recording, because the end may be at rest.
        let variation = one.variation(part) * (1.0 - FITTED_SHARE).sqrt();
        Some(fit_percent(&simulated[from..], &one.predicted(part)[from..], variation))
    });
    mean_fit(fits)
}

/// n (1 - ρ)/(1 + ρ), with the correlation ρ of the best structure's errors.
fn effective_samples(fitted: &[Option<Fitted<'_>>]) -> f64 {
    use crate::system::System as _;
    let best = fitted.iter().flatten().min_by(|a, b| a.squares.total_cmp(&b.squares));
    let Some(best) = best else { return 1.0 };
    let errors = best.problem.system().errors(&best.values);
    let correlation = Whiteness::of(&errors).map_or(0.0, |whiteness| whiteness.lag_one_correlation.clamp(0.0, 0.999));
    (errors.len() as f64 * (1.0 - correlation) / (1.0 + correlation)).max(10.0)
}

/// From best to worst. By held-out fit, those close to the best fit come first, the simplest one leading.
fn ordered(compared: &[Compared], criterion: Criterion) -> Vec<usize> {
    let mut order: Vec<usize> = (0..compared.len()).collect();
    let fit = |index: usize| compared[index].held_out_percent.unwrap_or(f64::NEG_INFINITY);
    match criterion {
        Criterion::Bayes => order.sort_by(|a, b| compared[*a].bayes.total_cmp(&compared[*b].bayes)),
        Criterion::HeldOut => {
            let best = order.iter().map(|index| fit(*index)).fold(f64::NEG_INFINITY, f64::max);
            order.sort_by(|a, b| fit(*b).total_cmp(&fit(*a)));
            let (mut close, others): (Vec<usize>, Vec<usize>) =
                order.into_iter().partition(|index| 100.0 - fit(*index) <= TOLERANCE * (100.0 - best));
            close.sort_unstable();
            close.extend(others);
            order = close;
        }
    }
    order
}

/// Adds the change by the alternative velocity estimate.
fn bounds(part: Part, candidate: &Candidate, fitted: &Fitted<'_>) -> Vec<Bounded> {
    let Fitted { problem, values, .. } = fitted;
    let found = intervals(problem, values, &candidate.starts[0], None);
    let change = |simulate: &Simulation| {
        let system = PartSystem { part, simulate, ..*problem.system() };
        let start = values
            .iter()
            .zip(&candidate.starts[0])
            .map(|(value, start)| if *value == 0.0 { 1e-3 * start } else { *value });
        Problem::new(system, (0..values.len()).collect(), start.collect()).solve().1.model()
    };
    let others = candidate.alternative.as_ref().map(change);
    found
        .into_iter()
        .map(|(index, Bounded { value, low, high })| {
            let change = others.as_ref().map_or(0.0, |others| (others[index] - value).abs());
            let Spec { key, range, .. } = candidate.specs[index];
            let low = if range == Range::Positive { (low - change).max(0.0) } else { low - change };
            let reduction =
                candidate.reductions.iter().find(|(reduced, _)| *reduced == key).map_or(1.0, |found| found.1);
            Bounded { value, low, high: high + change + value * (1.0 / reduction - 1.0) }
        })
        .collect()
}

fn fit(part: Part, signals: Signals, role: Role, candidate: &Candidate, values: &[f64]) -> PartFit {
    let simulated = (candidate.simulate)(values, &signals);
    let measured = signals.predicted(part);
    let fit_percent = simulated.as_deref().map(|simulated| fit_percent(simulated, measured, signals.variation(part)));
    let whiteness = simulated.as_deref().and_then(|simulated| Whiteness::between(simulated, measured));
    PartFit { signals, role, simulated, fit_percent, whiteness }
}
