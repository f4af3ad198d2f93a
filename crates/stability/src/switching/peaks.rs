//! Bounds of the motion under a tissue force in addition to springs and dampers.
//!
//! The tissue force is `f = K p + B v + w`. `K` and `B` may change at any tick; the input `w` within `±W` contains the
//! drop at a rupture, cutting, friction and relaxation. In each tick
//!
//! ```text
//! V_{k+1} < a V_k + (1 - a) ω w²,  0 < a < 1
//! ```
//! so `max(V, ω W²)` cannot grow: from rest, `V <= ω W²` (reachable ellipsoid, Boyd et al., *Linear Matrix Inequalities
//! in System and Control Theory*, 1994, section 6.1; Abedor, Nagpal and Poolla, *Int. J. Robust Nonlinear Control* 6,
//! 1996). With `s (c z)² < V` and `ω < s b²` the quantity `c z` stays within `b W`.

use nalgebra::DMatrix;

use super::attempt::{certify, narrowed};
use super::modes::{Modes, Space};
use super::settings::SwitchingSettings;
use crate::StabilityError;
use crate::certificate::{Certificate, Choice};

/// Pieces, decay rate as a share of twice the slowest mode's, and time constant of a held gap in s. The first ones give
/// smaller bounds sooner.
const TRIED: [(u64, f64, f64); 8] = [
    (2, 0.5, 0.1),
    (2, 0.25, 0.1),
    (2, 0.1, 0.1),
    (4, 0.25, 0.2),
    (4, 0.1, 0.1),
    (4, 0.1, 0.2),
    (8, 0.02, 0.1),
    (8, 0.004, 0.2),
];

const SIMILAR: usize = 3;

const MAX_RATIO: f64 = 1.2;
const LARGEST: f64 = 1e3;

const LONGEST_S: f64 = 20.0;
const TIME_CONSTANTS: f64 = 20.0;

#[derive(Debug, Clone)]
pub struct Peaks {
    pub certificate: Certificate,
    pub needle_m_per_n: f64,
    pub hand_m_per_n: f64,
    /// Lower bounds, on one of the springs.
    pub found_m_per_n: [f64; 2],
    pub decay_per_s: f64,
    tried: usize,
}

/// `None` if no functions can exist.
fn tried(settings: &SwitchingSettings) -> Result<Option<(Modes, f64, [Choice; TRIED.len()])>, StabilityError> {
    let modes = Modes::new(&SwitchingSettings { loses_contact: true, ..settings.clone() })?;
    let slowest_per_s = modes.slowest_decay_per_s()?;
    if settings.keeps_gap() || slowest_per_s <= 0.0 {
        return Ok(None);
    }
    let dwell_ticks = settings.phases().refractory;
    let choices = TRIED.map(|(pieces, share, hold_s)| {
        let rate_per_s = 2.0 * share * slowest_per_s;
        let contraction = (-rate_per_s * modes.tick_s * dwell_ticks as f64).exp();
        Choice { dwell_ticks, contraction, rate_per_s, bounds_m_per_n: None, is_driven: true, hold_s, pieces }
    });
    Ok(Some((modes, slowest_per_s, choices)))
}

impl Peaks {
    pub fn of(settings: &SwitchingSettings) -> Result<Option<Self>, StabilityError> {
        let Some((modes, slowest_per_s, choices)) = tried(settings)? else { return Ok(None) };
        let rows = [modes.slave(), modes.hand_position()];
        let found = largest_without_events(&modes, &rows, slowest_per_s);
        let bounds = |ratio: f64| found.map(|found| (found * ratio).max(f64::MIN_POSITIVE));
        let certify = |choice: Choice, ratio: f64| {
            certify(&modes, settings.phases(), Choice { bounds_m_per_n: Some(bounds(ratio)), ..choice })
        };
        let mut best = None;
        for (tried, choice) in choices.into_iter().enumerate() {
            if let Some(certificate) = certify(choice, LARGEST)? {
                best = Some((tried, choice, certificate));
                break;
            }
        }
        let Some((tried, choice, certificate)) = best else { return Ok(None) };
        let (ratio, certificate) = narrowed((LARGEST, certificate), 1.0, MAX_RATIO, |ratio| certify(choice, ratio))?;
        let [needle_m_per_n, hand_m_per_n] = bounds(ratio);
        Ok(Some(Self {
            certificate,
            needle_m_per_n,
            hand_m_per_n,
            found_m_per_n: found,
            decay_per_s: 0.5 * choice.rate_per_s,
            tried,
        }))
    }

    pub fn exist(settings: &SwitchingSettings, similar: Option<&Self>) -> Result<bool, StabilityError> {
        let Some((modes, _, choices)) = tried(settings)? else { return Ok(false) };
        let (first, count) = similar.map_or((0, TRIED.len()), |peaks| (peaks.tried, SIMILAR));
        for choice in choices.iter().skip(first).take(count) {
            if certify(&modes, settings.phases(), *choice)?.is_some() {
                return Ok(true);
            }
        }
        Ok(false)
    }
}

/// On the worst constant spring and damper.
fn largest_without_events(modes: &Modes, rows: &[DMatrix<f64>; 2], slowest_per_s: f64) -> [f64; 2] {
    let ticks = ((TIME_CONSTANTS / slowest_per_s).min(LONGEST_S) / modes.tick_s) as u64;
    let narrow = [0, 1].map(|k: usize| modes.row(&rows[k], Space::Loop));
    let mut largest = [0.0_f64; 2];
    for vertex in modes.vertices() {
        let whole = modes.teleoperation(vertex);
        let map = modes.between(&whole, Space::Loop, Space::Loop);
        let mut state = modes.between(&whole, Space::Input, Space::Loop);
        let mut sums = [0.0; 2];
        for _ in 0..ticks {
            for (sum, row) in sums.iter_mut().zip(&narrow) {
                *sum += (row * &state)[(0, 0)].abs();
            }
            state = &map * state;
        }
        for (largest, sum) in largest.iter_mut().zip(sums) {
            *largest = largest.max(sum);
        }
    }
    largest
}
