//! A greedy adversary finds motions to compare with the bounds of [`Peaks`](super::Peaks).
//!
//! Under forces `|w| <= 1`, the position `c x_N` reaches `Σ |p_{k+1}ᵀ b_k|` with `p_N = c` and `p_k = M_kᵀ p_{k+1}`.
//! Backwards from the last tick, the adversary chooses the tissue that makes `p_k` largest, or one for all ticks.

use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use std::sync::Arc;

use super::ascent::{Choices, Steps};
use super::modes::{Modes, Space};
use super::settings::SwitchingSettings;
use crate::StabilityError;

const EXTRA_TICKS: [u64; 3] = [0, 20, 400];

/// Returns the largest motions of needle and hand in m/N.
pub fn adversary(
    settings: &SwitchingSettings,
    (sequences, events): (u64, usize),
    seed: u64,
) -> Result<[f64; 2], StabilityError> {
    let modes = Modes::new(&SwitchingSettings { loses_contact: true, ..settings.clone() })?;
    let steps = Steps::new(&modes, settings.phases());
    let mut largest = [0.0_f64; 2];
    for stream in 0..sequences {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(stream);
        let steps = sequence(&steps, events, &mut rng);
        for (largest, row) in largest.iter_mut().zip([modes.slave(), modes.hand_position()]) {
            let strategies = std::iter::once(None).chain(modes.vertices().map(Some));
            let found = strategies.map(|strategy| reached(&modes, &steps, &row, strategy));
            *largest = found.fold(*largest, f64::max);
        }
    }
    Ok(largest)
}

/// True if the additional force acts.
type Step = (Choices, bool);

fn sequence(steps: &Steps<'_>, events: usize, rng: &mut ChaCha8Rng) -> Vec<Step> {
    let (modes, phases) = (steps.modes(), steps.phases);
    let force = |choices: &Choices, ticks: u64| (0..ticks).map(|_| (Arc::clone(choices), true)).collect::<Vec<_>>();
    let mut all = vec![];
    for _ in 0..events {
        let extra = EXTRA_TICKS[rng.random_range(0..EXTRA_TICKS.len())];
        all.extend(force(&steps.teleoperation, phases.refractory + rng.random_range(0..=extra) + 1));
        all.push((Arc::clone(&steps.freeze), false));
        all.extend(force(&steps.frozen, rng.random_range(phases.held.0..=phases.held.1)));
        all.push((Arc::clone(&steps.release), false));
        // The gap closes before the required teleoperation begins.
        let closes_in = if modes.gap_closes() { rng.random_range(0..2 * phases.blend + 1) } else { phases.blend };
        for tick in 0..phases.blend.max(closes_in) {
            all.extend(force(steps.blends.get(tick as usize).unwrap_or(&steps.teleoperation), 1));
            if modes.gap_closes() && (tick >= closes_in || rng.random_bool(0.1)) {
                let share = rng.random_range(0.0..1.0);
                let whole = DMatrix::identity(modes.places_all(), modes.places_all());
                all.push((Arc::new(vec![modes.closed() * (1.0 - share) + whole * share]), false));
            }
        }
        if modes.gap_closes() {
            all.push((Arc::clone(&steps.closed), false));
        }
    }
    all.extend(force(&steps.teleoperation, rng.random_range(0..phases.refractory + 400)));
    all
}

fn reached(modes: &Modes, steps: &[Step], row: &DMatrix<f64>, constant: Option<usize>) -> f64 {
    let n = modes.places_all();
    let input = modes.selection(Space::All, Space::Input).transpose();
    let mut p = row.clone();
    let mut sum = 0.0;
    for (choices, is_driven) in steps.iter().rev() {
        let next = match constant {
            Some(vertex) => choices.get(vertex * choices.len() / modes.vertices().len()).map(|map| &p * map),
            None => choices.iter().map(|map| &p * map).max_by(|a, b| size(a, &input).total_cmp(&size(b, &input))),
        };
        p = next.unwrap_or_else(|| DMatrix::zeros(1, n));
        if *is_driven {
            sum += (&p * &input)[(0, 0)].abs();
        }
        // The force of another tick is another input.
        p -= &p * &input * input.transpose();
    }
    sum
}

fn size(p: &DMatrix<f64>, input: &DMatrix<f64>) -> f64 {
    p.norm() + (p * input)[(0, 0)].abs()
}
