use std::f64::consts::{PI, TAU};

use super::ports::force_reading;
use super::{ClosedLoop, LinearLoop, StabilityError};
use trocar_engine::teleoperation::ControllerKind;
use trocar_lti::Complex64;

const POINTS: usize = 4000;

const HALVINGS: usize = 60;

/// Linear in `ln` magnitude and phase over `ln` frequency; the phase changes by less than half a turn per row.
#[derive(Debug, Clone, PartialEq)]
pub struct FrequencyResponse {
    /// `ln` of frequency (Hz) and magnitude; phase in rad.
    rows: Vec<[f64; 3]>,
}

impl FrequencyResponse {
    /// Takes ascending frequencies in Hz, magnitudes, and phases in rad; `None` for fewer than two rows.
    pub fn new(table: impl IntoIterator<Item = [f64; 3]>) -> Option<Self> {
        let mut rows: Vec<[f64; 3]> = vec![];
        for [frequency_hz, magnitude, phase_rad] in table {
            let at = frequency_hz.ln();
            let before = rows.last().copied().unwrap_or([f64::NEG_INFINITY, 0.0, phase_rad]);
            let phase = phase_rad + TAU * ((before[2] - phase_rad) / TAU).round();
            let row = [at, magnitude.ln(), phase];
            if at <= before[0] || !row.iter().all(|value| value.is_finite()) {
                return None;
            }
            rows.push(row);
        }
        (rows.len() >= 2).then_some(Self { rows })
    }

    pub fn range_hz(&self) -> (f64, f64) {
        (self.rows[0][0].exp(), self.rows[self.rows.len() - 1][0].exp())
    }

    pub fn largest_turn_rad(&self) -> f64 {
        self.rows.windows(2).map(|two| (two[1][2] - two[0][2]).abs()).fold(0.0, f64::max)
    }

    /// Constant outside the range.
    pub fn at(&self, frequency_hz: f64) -> Complex64 {
        let at = frequency_hz.ln();
        let next = self.rows.partition_point(|row| row[0] < at).clamp(1, self.rows.len() - 1);
        let (low, high) = (self.rows[next - 1], self.rows[next]);
        let share = ((at - low[0]) / (high[0] - low[0])).clamp(0.0, 1.0);
        let [ln_magnitude, phase] = [1, 2].map(|i| low[i] + share * (high[i] - low[i]));
        Complex64::from_polar(ln_magnitude.exp(), phase)
    }
}

/// Each response includes the hold of its command over a tick.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeasuredSides {
    /// Handle position (m) in the direction of the force per feedback force (N), with the hand on it.
    pub master: Option<FrequencyResponse>,
    /// Position (m) of the free needle per reference (m).
    pub slave: Option<FrequencyResponse>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeasuredVerdict {
    /// Requires that the loop gain stays below 1 above the highest frequency.
    Stable,
    Unstable,
    Open,
}

#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredLoop {
    /// Common to the tables, up to half the sampling rate.
    pub range_hz: (f64, f64),
    /// Pairs (Hz, `L`).
    pub gain: Vec<(f64, Complex64)>,
    pub verdict: MeasuredVerdict,
    /// The smallest destabilising gain factor, and its frequency in Hz.
    pub limit: Option<(f64, f64)>,
    /// Phase margin in rad, its frequency in Hz, and delay margin in s.
    pub phase: Option<(f64, f64, f64)>,
    pub largest_turn_rad: f64,
    /// The stability is unknown above this gain factor.
    pub open_from: f64,
}

impl MeasuredLoop {
    pub fn of(settings: &LinearLoop, sides: &MeasuredSides) -> Result<Self, StabilityError> {
        let tables: Vec<&FrequencyResponse> = sides.master.iter().chain(&sides.slave).collect();
        let low = tables.iter().map(|table| table.range_hz().0).fold(0.0, f64::max);
        let high = tables.iter().map(|table| table.range_hz().1).fold(0.5 / settings.tick_s, f64::min);
        let refused = if tables.is_empty() {
            Some("there is no table")
        } else if settings.link.controller.kind != ControllerKind::PositionForce {
            Some(
                "they replace a side of the architecture position-force only; set controller.kind = \"position-force\"",
            )
        } else if low >= high {
            Some(
                "they have no common range of frequencies below half the sampling rate; measure the same range on both sides",
            )
        } else {
            None
        };
        if let Some(reason) = refused {
            return Err(StabilityError::Measured { reason });
        }
        let closed = ClosedLoop::new(settings)?;
        let at = |hertz: f64| loop_gain(settings, &closed, sides, hertz);
        let mut frequencies: Vec<f64> =
            (0..=POINTS).map(|k| low * (high / low).powf(k as f64 / POINTS as f64)).collect();
        frequencies.extend(tables.iter().flat_map(|table| &table.rows).map(|row| row[0].exp()));
        frequencies.retain(|hertz| (low..=high).contains(hertz));
        frequencies.sort_by(f64::total_cmp);
        frequencies.dedup();
        let gain: Vec<(f64, Complex64)> = frequencies.into_iter().map(|hertz| (hertz, at(hertz))).collect();

        let mut limit: Option<(f64, f64)> = None;
        for hertz in crossings(&gain, &at, |gain| gain.im) {
            let crossing = at(hertz).re;
            if crossing > 0.0 && limit.is_none_or(|(factor, _)| 1.0 / crossing < factor) {
                limit = Some((1.0 / crossing, hertz));
            }
        }
        let highest = gain[gain.len() - 1].1.norm();
        let one = Complex64::new(1.0, 0.0);
        let turned: f64 = gain.windows(2).map(|two| ((one - two[1].1) / (one - two[0].1)).arg()).sum();
        let direct = (one - gain[gain.len() - 1].1).arg() - (one - gain[0].1).arg();
        let verdict = match (turned - direct).abs() > PI {
            true => MeasuredVerdict::Unstable,
            false if highest >= 1.0 => MeasuredVerdict::Open,
            false => MeasuredVerdict::Stable,
        };
        let phase = (verdict == MeasuredVerdict::Stable).then(|| phase_margin(&gain, &at)).flatten();
        let largest_turn_rad = tables.iter().map(|table| table.largest_turn_rad()).fold(0.0, f64::max);
        Ok(Self { range_hz: (low, high), gain, verdict, limit, phase, largest_turn_rad, open_from: 1.0 / highest })
    }
}

fn phase_margin(gain: &[(f64, Complex64)], at: &impl Fn(f64) -> Complex64) -> Option<(f64, f64, f64)> {
    let crossings = crossings(gain, at, |gain| gain.norm() - 1.0);
    let of = |hertz: f64| (at(hertz).arg(), hertz);
    let (lead, hertz) = crossings.iter().copied().map(of).min_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))?;
    let delay = |hertz: &f64| at(*hertz).arg().rem_euclid(TAU) / (TAU * hertz);
    let delay_s = crossings.iter().map(delay).fold(f64::INFINITY, f64::min);
    Some((lead.abs(), hertz, delay_s))
}

fn crossings(gain: &[(f64, Complex64)], at: &impl Fn(f64) -> Complex64, of: impl Fn(Complex64) -> f64) -> Vec<f64> {
    let is_positive = |gain: Complex64| of(gain) > 0.0;
    let found = gain.windows(2).filter(|two| is_positive(two[0].1) != is_positive(two[1].1)).map(|two| {
        let (mut low, mut high) = (two[0].0, two[1].0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if is_positive(at(middle)) == is_positive(two[0].1) { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    });
    found.collect()
}

/// A side without a table is the model's.
fn loop_gain(settings: &LinearLoop, closed: &ClosedLoop, sides: &MeasuredSides, hertz: f64) -> Complex64 {
    let s = Complex64::new(0.0, TAU * hertz);
    let z = (s * settings.tick_s).exp();
    let [of_master, of_slave] = closed.responses_at(z);
    let machines = &settings.link.machines;
    // A sample within a tick arrives later by this share.
    let late = |share: f64| (-s * settings.tick_s * share).exp();
    let master = match &sides.master {
        Some(table) => -late(settings.backward().share) * table.at(hertz) * machines.position_scale,
        None => of_master,
    };
    let slave = match &sides.slave {
        Some(table) => {
            let free = late(settings.forward().share) * table.at(hertz);
            let tissue = s * settings.damping_n_s_per_m + settings.stiffness_n_per_m;
            // The tissue moves the slave by its compliance, as a change of the reference.
            let pushed = tissue * free * machines.compliance_m_per_n + 1.0;
            force_reading(settings, s) * tissue * free * machines.force_scale / pushed
        }
        None => of_slave,
    };
    master * slave * (-s * settings.tick_s * closed.round_trip_ticks() as f64).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_response_is_interpolated_over_the_logarithm_of_the_frequency() {
        // A double integrator is a line in these coordinates.
        let of = |hertz: f64| [hertz, hertz.powi(-2), -PI + 0.1 * hertz.ln()];
        let response = FrequencyResponse::new([0.5, 2.0, 5.0, 80.0].map(of)).expect("a response");
        for hertz in [0.5, 0.9, 3.3, 40.0, 80.0] {
            let [_, magnitude, phase] = of(hertz);
            assert!((response.at(hertz) / Complex64::from_polar(magnitude, phase) - 1.0).norm() < 1e-12, "{hertz}");
        }
        assert_eq!(response.at(1000.0), response.at(80.0));
        let (low, high) = response.range_hz();
        assert!((low - 0.5).abs() < 1e-12 && (high - 80.0).abs() < 1e-12);
    }

    #[test]
    fn a_wrapped_phase_is_followed() {
        let response =
            FrequencyResponse::new([[1.0, 1.0, -3.0], [2.0, 1.0, 3.0], [4.0, 1.0, 2.0]]).expect("a response");
        assert!(response.largest_turn_rad() < 1.1, "{response:?}");
        assert!((response.at(2.0_f64.sqrt()).arg() + 3.0 + 0.5 * (TAU - 6.0)).abs() < 1e-12);
    }

    #[test]
    fn numbers_that_are_no_response_are_refused() {
        let row = [1.0, 1.0, 0.0];
        for table in [vec![], vec![row], vec![row, row], vec![row, [2.0, 0.0, 0.0]], vec![[0.0, 1.0, 0.0], row]] {
            assert_eq!(FrequencyResponse::new(table), None);
        }
    }
}
