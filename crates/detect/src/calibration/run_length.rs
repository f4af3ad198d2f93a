//! Average run length (ARL): the number of samples before a CUSUM alarms on noise alone.
//!
//! The CUSUM is `g_k = max(g_{k-1} + s_k - ν, 0)` from `g_0 = 0` with an alarm at `g_k > γ`, and `s_k = x_k²` of
//! independent standard normal `x_k`. Its ARL is `L(0)` of the integral equation of Page (1954)
//!
//! ```text
//! L(z) = 1 + L(0) F(ν - z) + ∫₀^γ L(y) f(y - z + ν) dy
//! ```
//!
//! with distribution `F` and density `f` of `s`. `f` is infinite at 0, so the constant states of Brook and Evans (1972)
//! are inaccurate. Here `L` is linear between nodes, and its products with `f` are integrated exactly, as in Knoth
//! (2006, *Computational Statistics & Data Analysis* 51).
//!
//! Decisions and drifts are in variances, run lengths in samples.

use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

use trocar_base::parallel::map;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunLength {
    pub drift: f64,
    pub threshold: f64,
    /// Solution of the integral equation.
    pub predicted: f64,
    pub simulated: f64,
    /// Its inverse square root is the relative standard error.
    pub alarms: u64,
}

const RUNS_PER_STREAM: u64 = 32;

impl RunLength {
    /// Simulates `alarms` runs (a multiple of 32), and calls `done` after every 32.
    pub fn check(drift: f64, wanted: f64, alarms: u64, done: impl Fn() + Sync) -> Self {
        let threshold = threshold_for(drift, wanted);
        let chunks = alarms.div_ceil(RUNS_PER_STREAM);
        let samples = map(chunks as usize, |chunk| {
            // A separate stream for every chunk.
            let seed = (wanted as u64).wrapping_mul(2) + ((chunk as u64) << 40);
            let samples = simulate(drift, threshold, RUNS_PER_STREAM, seed);
            done();
            samples
        });
        let samples: u64 = samples.into_iter().sum();
        let alarms = chunks * RUNS_PER_STREAM;
        let predicted = average_run_length(drift, threshold);
        Self { drift, threshold, predicted, simulated: samples as f64 / alarms as f64, alarms }
    }
}

const NODES_PER_UNIT: f64 = 10.0;
const NODES: (f64, f64) = (60.0, 700.0);

/// Beyond it, rounding errors dominate the solution.
pub const LONGEST: f64 = 1e12;

pub const WANTED: std::ops::RangeInclusive<f64> = 2.0..=1e10;

/// Distribution function of `x²` at `u`, and the mean of `x²` over `x² <= u`.
fn chi_square(u: f64) -> (f64, f64) {
    if u <= 0.0 {
        return (0.0, 0.0);
    }
    let distribution = libm::erf((u / 2.0).sqrt());
    (distribution, distribution - (2.0 * u / std::f64::consts::PI).sqrt() * (-u / 2.0).exp())
}

/// For `drift > 0` and `threshold > 0`; at most [`LONGEST`].
pub fn average_run_length(drift: f64, threshold: f64) -> f64 {
    let elements = (threshold * NODES_PER_UNIT).ceil().clamp(NODES.0, NODES.1) as usize;
    on_elements(drift, threshold, elements)
}

fn on_elements(drift: f64, threshold: f64, elements: usize) -> f64 {
    let width = threshold / elements as f64;
    let mut equations = DMatrix::<f64>::identity(elements + 1, elements + 1);
    for row in 0..=elements {
        let from = row as f64 * width;
        let at = |node: usize| chi_square(node as f64 * width - from + drift);
        let mut lower = at(0);
        equations[(row, 0)] -= lower.0;
        for element in 0..elements {
            let upper = at(element + 1);
            let (mass, moment) = (upper.0 - lower.0, upper.1 - lower.1);
            let right = (moment + (from - drift - element as f64 * width) * mass) / width;
            equations[(row, element)] -= mass - right;
            equations[(row, element + 1)] -= right;
            lower = upper;
        }
    }
    let solution = equations.lu().solve(&DVector::from_element(elements + 1, 1.0));
    // Numerically singular: the run length exceeds every wanted one.
    match solution.map(|length| length[0]) {
        Some(length) if (1.0..LONGEST).contains(&length) => length,
        _ => LONGEST,
    }
}

/// For `samples` within [`WANTED`], with a relative error of 1e-4.
pub fn threshold_for(drift: f64, samples: f64) -> f64 {
    let (mut low, mut high) = (1e-3_f64, 1.0_f64);
    while average_run_length(drift, high) < samples && high < 1e6 {
        low = high;
        high *= 2.0;
    }
    while high / low > 1.0001 {
        trocar_base::interrupt::check();
        let middle = (low * high).sqrt();
        if average_run_length(drift, middle) < samples {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

/// Total number of samples.
pub fn simulate(drift: f64, threshold: f64, alarms: u64, seed: u64) -> u64 {
    let mut noise = ChaCha8Rng::seed_from_u64(seed);
    let mut samples = 0;
    for _ in 0..alarms {
        trocar_base::interrupt::check();
        let mut decision = 0.0_f64;
        while decision <= threshold {
            let x: f64 = StandardNormal.sample(&mut noise);
            decision = (decision + x * x - drift).max(0.0);
            samples += 1;
        }
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn with_a_threshold_near_zero_the_run_length_is_geometric() {
        // One sample above the drift raises an alarm.
        let drift = 1.7;
        let exceeds = 1.0 - chi_square(drift).0;
        let length = average_run_length(drift, 1e-9);
        assert!((length * exceeds - 1.0).abs() < 1e-6, "{length}, {}", 1.0 / exceeds);
    }

    #[test]
    fn four_times_the_elements_hardly_change_the_run_length() {
        for (drift, threshold) in [(4.65, 21.0), (2.56, 30.0), (1.5, 40.0)] {
            let length = average_run_length(drift, threshold);
            let elements = 4 * (threshold * NODES_PER_UNIT) as usize;
            let finer = on_elements(drift, threshold, elements);
            assert!((length / finer - 1.0).abs() < 0.01, "{drift} {threshold}: {length} {finer}");
        }
    }

    #[test]
    fn predicted_and_simulated_run_lengths_agree_within_10_percent() {
        // With 2000 alarms, the standard error of the simulated mean is 2.2 %.
        for (drift, wanted) in [(1.5, 1e3), (2.56, 1e3), (4.65, 1e4)] {
            let threshold = threshold_for(drift, wanted);
            let predicted = average_run_length(drift, threshold);
            let simulated = simulate(drift, threshold, 2000, 7) as f64 / 2000.0;
            assert!((predicted / wanted - 1.0).abs() < 0.01, "{predicted}");
            assert!((simulated / predicted - 1.0).abs() < 0.1, "{drift}: {predicted} {simulated}");
        }
    }

    #[test]
    fn the_run_length_grows_with_threshold_and_drift_up_to_the_longest() {
        let length = |drift, threshold| average_run_length(drift, threshold);
        assert!(length(2.0, 10.0) < length(2.0, 12.0) && length(2.0, 12.0) < length(3.0, 12.0));
        assert_eq!(length(50.0, 50.0), LONGEST);
    }
}
