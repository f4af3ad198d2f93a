//! Stability limits over people: arms drawn at random.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::limit::StabilityTester;
use super::{ClosedLoop, LoopSettings, Parameter, StabilityError};

/// Range of the factor of a grip on both stiffnesses: from the relaxed to the firm grip. The dampings change by its root,
/// so that the damping ratios stay.
const GRIP: (f64, f64) = (0.5, 2.0);

/// Range of the factor of a person on each parameter of the arm.
const PERSON: (f64, f64) = (1.0 / 1.3, 1.3);

/// Range of the search for the maximum stable stiffness in N/m, points of the scan and bisections.
const STIFFNESS: (f64, f64) = (10.0, 1e5);
const SCAN: usize = 20;
const BISECTIONS: usize = 22;

/// The share of arms in an interval of a quantile, or in the interval of a share.
const CONFIDENCE: f64 = 1.959_963_984_540_054;

/// The quantiles.
const QUANTILES: [f64; 5] = [0.05, 0.25, 0.5, 0.75, 0.95];

/// The parameters of the arm, in the order of [`Arm::factors`].
const PARAMETERS: [Parameter; 5] =
    [Parameter::ArmKa, Parameter::ArmBa, Parameter::ArmKh, Parameter::ArmBh, Parameter::ArmMass];

/// An arm, relative to that of the scenario.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arm {
    /// Factors of `k_a`, `b_a`, `k_h`, `b_h` and `m_h`.
    pub factors: [f64; 5],
    /// Whether the scenario's loop is stable with it.
    pub is_stable: bool,
    /// The maximum stable stiffness in N/m; 0 if none is, infinite beyond the search range.
    pub stiffness_n_per_m: f64,
}

/// A quantile with the interval that contains it with a probability of 95 %.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantile {
    /// The share of arms below it.
    pub share: f64,
    /// Its estimate.
    pub value: f64,
    /// The interval, from order statistics.
    pub interval: (f64, f64),
}

/// Limits over a population.
#[derive(Debug, Clone, PartialEq)]
pub struct Population {
    /// The arms, in the order in which they were drawn.
    pub arms: Vec<Arm>,
    /// The share with which the scenario's loop is stable, with its 95 % interval.
    pub stable_share: (f64, (f64, f64)),
    /// Quantiles of the maximum stable stiffness in N/m.
    pub quantiles: Vec<Quantile>,
    /// The arm with the smallest maximum stable stiffness that was found in the box of all factors. It is a corner of the
    /// box or a drawn arm; no proof that none is worse.
    pub worst: Arm,
}

fn with_factors(settings: &LoopSettings, factors: &[f64; 5]) -> LoopSettings {
    PARAMETERS.iter().zip(factors).fold(settings.clone(), |settings, (&parameter, factor)| {
        let value = settings.get(parameter) * factor;
        settings.with(parameter, value)
    })
}

/// The verdict and the limit of an arm.
fn analysed(settings: &LoopSettings, factors: [f64; 5]) -> Result<Arm, StabilityError> {
    let settings = with_factors(settings, &factors);
    let is_stable = ClosedLoop::new(&settings)?.is_stable()?;
    let tester = StabilityTester::new(&settings)?;
    let at = |stiffness: f64| tester.is_stable(&[(Parameter::Stiffness, stiffness)]);
    let step = (STIFFNESS.1 / STIFFNESS.0).powf(1.0 / (SCAN - 1) as f64);
    let mut below = 0.0;
    let mut above = None;
    if !at(0.0)? {
        return Ok(Arm { factors, is_stable, stiffness_n_per_m: 0.0 });
    }
    for k in 0..SCAN {
        let stiffness = STIFFNESS.0 * step.powi(k as i32);
        if at(stiffness)? {
            below = stiffness;
        } else {
            above = Some(stiffness);
            break;
        }
    }
    let Some(mut above) = above else { return Ok(Arm { factors, is_stable, stiffness_n_per_m: f64::INFINITY }) };
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (below + above);
        if at(middle)? { below = middle } else { above = middle }
    }
    Ok(Arm { factors, is_stable, stiffness_n_per_m: below })
}

/// The factors of an arm drawn at random: of a grip and of a person, both uniform in the logarithm.
fn drawn(seed: u64, index: u64) -> [f64; 5] {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(index);
    let mut between = |(low, high): (f64, f64)| libm::exp(rng.random_range(libm::log(low)..=libm::log(high)));
    let grip = between(GRIP);
    let by_grip = [grip, grip.sqrt(), grip, grip.sqrt(), 1.0];
    by_grip.map(|factor| factor * between(PERSON))
}

/// The score interval of Wilson for a share.
fn share_interval(count: usize, of: usize) -> (f64, (f64, f64)) {
    let (n, z2) = (of as f64, CONFIDENCE * CONFIDENCE);
    let share = count as f64 / n;
    let middle = (share + z2 / (2.0 * n)) / (1.0 + z2 / n);
    let half = CONFIDENCE * (share * (1.0 - share) / n + z2 / (4.0 * n * n)).sqrt() / (1.0 + z2 / n);
    (share, ((middle - half).max(0.0), (middle + half).min(1.0)))
}

/// A quantile of sorted values, with its interval from the ranks `n p ± z √(n p (1 - p))`.
fn quantile(sorted: &[f64], share: f64) -> Quantile {
    let n = sorted.len() as f64;
    let at = |rank: f64| sorted[(rank.max(0.0) as usize).min(sorted.len() - 1)];
    let half = CONFIDENCE * (n * share * (1.0 - share)).sqrt();
    Quantile {
        share,
        value: at((n * share).ceil() - 1.0),
        interval: (at((n * share - half).floor() - 1.0), at((n * share + half).ceil())),
    }
}

impl Population {
    /// The limits of `count` arms (at least 1) around that of a loop.
    ///
    /// # Errors
    /// [`StabilityError`].
    pub fn of(settings: &LoopSettings, count: usize, seed: u64) -> Result<Self, StabilityError> {
        let count = count.max(1);
        let arms: Vec<Arm> = (0..count as u64)
            .into_par_iter()
            .map(|index| analysed(settings, drawn(seed, index)))
            .collect::<Result<_, StabilityError>>()?;
        // The corners of the box: the grip's ends, and each person's factor.
        let corners: Vec<Arm> = (0..64_u32)
            .into_par_iter()
            .map(|corner| {
                let is_high = |bit: u32| corner & (1 << bit) != 0;
                let end = |range: (f64, f64), bit: u32| if is_high(bit) { range.1 } else { range.0 };
                let grip = end(GRIP, 5);
                let by_grip = [grip, grip.sqrt(), grip, grip.sqrt(), 1.0];
                analysed(settings, std::array::from_fn(|k| by_grip[k] * end(PERSON, k as u32)))
            })
            .collect::<Result<_, StabilityError>>()?;
        let mut limits: Vec<f64> = arms.iter().map(|arm| arm.stiffness_n_per_m).collect();
        limits.sort_by(f64::total_cmp);
        let worst = corners
            .iter()
            .chain(&arms)
            .copied()
            .reduce(|worst, arm| if arm.stiffness_n_per_m < worst.stiffness_n_per_m { arm } else { worst });
        Ok(Self {
            stable_share: share_interval(arms.iter().filter(|arm| arm.is_stable).count(), count),
            quantiles: QUANTILES.iter().map(|&share| quantile(&limits, share)).collect(),
            worst: worst.unwrap_or(arms[0]),
            arms,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantile_lies_in_its_interval_and_a_share_too() {
        let values: Vec<f64> = (0..1000).map(f64::from).collect();
        for share in QUANTILES {
            let Quantile { value, interval, .. } = quantile(&values, share);
            assert!((value - (1000.0 * share - 1.0)).abs() < 1e-9);
            assert!(interval.0 < value && value < interval.1 && interval.1 - interval.0 < 70.0);
        }
        let (share, (low, high)) = share_interval(0, 100);
        assert!(share == 0.0 && low < 1e-12 && (high - 0.0370).abs() < 1e-3);
    }
}
