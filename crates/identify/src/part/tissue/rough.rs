//! A rough spring and damper, to start the optimiser.

use super::super::regression::{Regression, regression};
use super::super::signals::Signals;
use super::law::Velocity;
use crate::filter::delayed;
use crate::measured::{deviation, span};

/// Longest lag of the starts.
const LONGEST_LAG_S: f64 = 12e-3;

const MAX_LAGS: usize = 25;

/// Share of the range of positions that may be free of contact.
const LOWEST_SHARE: f64 = 0.15;

/// Maximum rise of the force without contact, relative to the whole recording.
const FLAT_SHARE: f64 = 1.0 / 3.0;

/// Maximum standard deviation without contact, relative to the force's range.
const QUIET_SHARE: f64 = 0.1;

pub(super) struct Rough {
    pub(super) zero_n: Option<f64>,
    pub(super) contact_m: f64,
    pub(super) stiffness_n_per_m: f64,
    pub(super) damping_n_s_per_m: f64,
    pub(super) lag_s: f64,
    pub(super) velocity: Velocity,
    /// Factor of the damping by the rounding of the positions; at most 1.
    pub(super) reduction: f64,
    pub(super) depth_m: f64,
    pub(super) span_m: f64,
    pub(super) span_n: f64,
}

impl Rough {
    /// `None` if the force does not rise with the depth.
    pub(super) fn of(recordings: &[Signals]) -> Option<Self> {
        let all = |of: fn(&Signals) -> &[f64]| -> Vec<f64> { recordings.iter().flat_map(of).copied().collect() };
        let (positions, forces) = (all(|one| &one.position_m), all(|one| &one.force_n));
        let (span_m, span_n) = (span(&positions), span(&forces));
        let lowest_m = positions.iter().copied().fold(f64::INFINITY, f64::min);
        let free = Free::of(&positions, &forces);
        let begin_m = free.as_ref().map_or(f64::NEG_INFINITY, |free| free.contact_m);
        let zero_n = free.as_ref().map(|free| free.zero_n);
        let interval_s = recordings.iter().map(|one| one.interval_s).fold(f64::INFINITY, f64::min);
        let lags = ((LONGEST_LAG_S / interval_s) as usize + 1).clamp(2, MAX_LAGS);
        let lag_step_s = LONGEST_LAG_S.min(interval_s * (lags - 1) as f64) / (lags - 1) as f64;
        let mut best: Option<(Regression, f64, Velocity)> = None;
        for velocity in [Velocity::Slope, Velocity::Difference] {
            let velocities: Vec<Vec<f64>> = recordings.iter().map(|one| velocity.of(one)).collect();
            for step in 0..lags {
                let lag_s = step as f64 * lag_step_s;
                let mut rows = vec![];
                for (one, velocities) in recordings.iter().zip(&velocities) {
                    for (sample, force_n) in one.force_n.iter().enumerate() {
                        let position_m = delayed(&one.position_m, sample, lag_s, one.interval_s);
                        if position_m > begin_m {
                            let velocity = delayed(velocities, sample, lag_s, one.interval_s);
                            rows.push((vec![position_m - lowest_m, velocity, 1.0], *force_n));
                        }
                    }
                }
                let Some(found) = regression(&rows) else { continue };
                if best.as_ref().is_none_or(|best| found.squares < best.0.squares) {
                    best = Some((found, lag_s, velocity));
                }
            }
        }
        let (found, lag_s, velocity) = best?;
        let coefficients = &found.coefficients;
        let stiffness = coefficients[0];
        if stiffness <= 0.0 || !found.explains_enough() {
            return None;
        }
        let regressed_m = lowest_m - (coefficients[2] - zero_n.unwrap_or(0.0)) / stiffness;
        // A line through all forces would begin too deep.
        let contact_m = if free.is_some() {
            regressed_m.clamp(begin_m - 0.1 * span_m, begin_m + 0.1 * span_m)
        } else {
            regressed_m
        };
        Some(Self {
            zero_n,
            contact_m,
            stiffness_n_per_m: stiffness,
            damping_n_s_per_m: coefficients[1].max(1e-3 * stiffness),
            lag_s,
            velocity,
            reduction: velocity.reduction(recordings),
            depth_m: (lowest_m + span_m - contact_m).max(1e-3 * span_m),
            span_m,
            span_n,
        })
    }
}

struct Free {
    zero_n: f64,
    contact_m: f64,
}

impl Free {
    /// `None` if the needle is in contact at the lowest positions.
    fn of(positions: &[f64], forces: &[f64]) -> Option<Self> {
        let lowest_m = positions.iter().copied().fold(f64::INFINITY, f64::min);
        let end_m = lowest_m + LOWEST_SHARE * span(positions);
        let pairs = positions.iter().zip(forces);
        let lowest = pairs.clone().filter(|(x, _)| **x <= end_m).map(|(x, f)| (vec![x - lowest_m, 1.0], *f));
        let lowest: Vec<(Vec<f64>, f64)> = lowest.collect();
        let slope = regression(&lowest)?.coefficients[0];
        let zero_n = lowest.iter().map(|row| row.1).sum::<f64>() / lowest.len() as f64;
        let range_n = span(forces);
        let spread_n = deviation(&lowest.iter().map(|row| row.1).collect::<Vec<_>>()) / (lowest.len() as f64).sqrt();
        if slope.abs() > FLAT_SHARE * range_n / span(positions) || spread_n > QUIET_SHARE * range_n {
            return None;
        }
        // Contact begins below the lowest position with a clear force.
        let clear = pairs.filter(|(_, force_n)| **force_n > zero_n + 0.1 * range_n).map(|(x, _)| *x);
        let mut clear: Vec<f64> = clear.collect();
        clear.sort_by(f64::total_cmp);
        let contact_m = *clear.get(clear.len() / 50)?;
        Some(Self { zero_n, contact_m })
    }
}
