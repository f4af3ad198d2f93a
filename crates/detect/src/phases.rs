use std::ops::Range;
use trocar_document::figure::Shade;

use schemars::JsonSchema;
use serde::Serialize;

use trocar_base::interrupt;

/// The phase of an insertion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Phase {
    /// Out of the tissue: before the contact, or after the withdrawal.
    Free,
    /// In the tissue and moving inwards.
    Insertion,
    /// In the tissue and at rest, while the tissue relaxes.
    Hold,
    /// In the tissue and moving outwards.
    Withdrawal,
}

impl Phase {
    pub fn shade(self) -> Option<Shade> {
        match self {
            Self::Free => None,
            Self::Insertion => Some(Shade::Insertion),
            Self::Hold => Some(Shade::Hold),
            Self::Withdrawal => Some(Shade::Withdrawal),
        }
    }

    pub const ALL: [Self; 4] = [Self::Free, Self::Insertion, Self::Hold, Self::Withdrawal];

    pub fn name(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::Insertion => "insertion",
            Self::Hold => "hold",
            Self::Withdrawal => "withdrawal",
        }
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PhaseInterval {
    pub phase: Phase,
    pub samples: Range<usize>,
}

/// Determines the phases from positions alone.
///
/// The mean velocity at a sample is `v̄ = (p(t + w/2) - p(t - w/2)) / w`. In contact the phase is insertion if
/// `v̄ > moving_m_per_s`, withdrawal if `v̄ < -moving_m_per_s`, and hold otherwise. An interval shorter than
/// `shortest_s` joins the previous one.
///
/// The defaults are chosen here: 0.1 s is a period of a tremor of 10 Hz; 1 mm/s lies between a resting hand's creep and
/// the shipped insertion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhaseRule {
    /// `w`, above 0.
    pub window_s: f64,
    /// At least 0.
    pub moving_m_per_s: f64,
    /// At least 0.
    pub shortest_s: f64,
}

impl Default for PhaseRule {
    fn default() -> Self {
        Self { window_s: 0.1, moving_m_per_s: 1e-3, shortest_s: 0.1 }
    }
}

impl PhaseRule {
    /// Without gaps; neighbours differ in phase.
    pub fn split(&self, position_m: &[f64], interval_s: f64, contact_m: f64) -> Vec<PhaseInterval> {
        let samples = |duration_s: f64| (duration_s / interval_s).round().max(0.0) as usize;
        let half = samples(0.5 * self.window_s).max(1);
        let shortest = samples(self.shortest_s);
        let mut intervals: Vec<PhaseInterval> = vec![];
        for sample in 0..position_m.len() {
            interrupt::check_at(sample as u64);
            let phase = self.phase_at(position_m, sample, half, interval_s, contact_m);
            extend(&mut intervals, phase, sample..sample + 1);
        }
        merge(&intervals, shortest)
    }

    fn phase_at(&self, position_m: &[f64], sample: usize, half: usize, interval_s: f64, contact_m: f64) -> Phase {
        // NaN counts as out of contact.
        let is_in_contact = position_m[sample] > contact_m;
        if !is_in_contact {
            return Phase::Free;
        }
        let (from, to) = (sample.saturating_sub(half), sample.saturating_add(half).min(position_m.len() - 1));
        let duration_s = (to - from) as f64 * interval_s;
        let speed = if to > from { (position_m[to] - position_m[from]) / duration_s } else { 0.0 };
        if speed > self.moving_m_per_s {
            Phase::Insertion
        } else if speed < -self.moving_m_per_s {
            Phase::Withdrawal
        } else {
            Phase::Hold
        }
    }
}

fn extend(intervals: &mut Vec<PhaseInterval>, phase: Phase, samples: Range<usize>) {
    match intervals.last_mut() {
        Some(last) if last.phase == phase => last.samples.end = samples.end,
        _ => intervals.push(PhaseInterval { phase, samples }),
    }
}

/// If all intervals are shorter than `shortest`, the longest gives the phase.
fn merge(intervals: &[PhaseInterval], shortest: usize) -> Vec<PhaseInterval> {
    let mut merged: Vec<PhaseInterval> = vec![];
    for interval in intervals {
        if interval.samples.len() >= shortest {
            let start = if merged.is_empty() { 0 } else { interval.samples.start };
            extend(&mut merged, interval.phase, start..interval.samples.end);
        } else if let Some(last) = merged.last_mut() {
            last.samples.end = interval.samples.end;
        }
    }
    let longest = intervals.iter().rev().max_by_key(|interval| interval.samples.len());
    if let (true, Some(longest), Some(last)) = (merged.is_empty(), longest, intervals.last()) {
        merged.push(PhaseInterval { phase: longest.phase, samples: 0..last.samples.end });
    }
    merged
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Returns positions at 1 kHz from `start_m`, for pieces of (duration in ms, velocity in m/s).
    fn path(start_m: f64, pieces: &[(usize, f64)]) -> Vec<f64> {
        let mut position_m = vec![start_m];
        for &(samples, speed) in pieces {
            for _ in 0..samples {
                position_m.push(position_m[position_m.len() - 1] + 1e-3 * speed);
            }
        }
        position_m
    }

    fn phases(position_m: &[f64]) -> Vec<(Phase, usize)> {
        let intervals = PhaseRule::default().split(position_m, 1e-3, 0.0);
        intervals.into_iter().map(|interval| (interval.phase, interval.samples.start)).collect()
    }

    #[test]
    fn an_insertion_is_split_into_its_phases() {
        // 5 mm to the surface and 10 mm in at 5 mm/s, a rest, and out at 20 mm/s.
        let found = phases(&path(-5e-3, &[(1000, 5e-3), (2000, 5e-3), (1500, 0.0), (500, -20e-3), (500, -20e-3)]));
        let names: Vec<_> = found.iter().map(|(phase, _)| *phase).collect();
        assert_eq!(names, [Phase::Free, Phase::Insertion, Phase::Hold, Phase::Withdrawal, Phase::Free]);
        for ((_, start), expected) in found.iter().zip([0_usize, 1000, 3000, 4500, 5000]) {
            assert!(start.abs_diff(expected) <= 50, "within half a window: {start} and {expected}");
        }
    }

    #[test]
    fn a_hold_with_tremor_is_a_hold() {
        let tremor = |k: usize| 0.01 + 3e-4 * (std::f64::consts::TAU * 10.0 * k as f64 * 1e-3).sin();
        let position_m: Vec<f64> = (0..3000).map(tremor).collect();
        // The speed of the tremor reaches 19 mm/s.
        let inside = PhaseRule::default().split(&position_m, 1e-3, 0.0);
        let held: usize = inside.iter().filter(|s| s.phase == Phase::Hold).map(|s| s.samples.len()).sum();
        assert!(held > 2850, "{inside:?}");
    }

    #[test]
    fn short_intervals_join_their_neighbour() {
        let position_m = path(1e-3, &[(1000, 5e-3), (60, 0.0), (1000, 5e-3)]);
        assert_eq!(phases(&position_m), [(Phase::Insertion, 0)]);
        assert_eq!(phases(&[1e-3; 20]), [(Phase::Hold, 0)]);
        assert_eq!(phases(&[]), []);
        assert_eq!(phases(&[f64::NAN; 3]), [(Phase::Free, 0)]);
    }

    proptest! {
        #[test]
        fn intervals_cover_every_sample_once(
            pieces in prop::collection::vec((1_usize..400, -2e-2..2e-2), 1..12),
            start_m in -2e-2..2e-2,
            shortest_s in 0.0..0.3,
        ) {
            let position_m = path(start_m, &pieces);
            let rule = PhaseRule { shortest_s, ..PhaseRule::default() };
            let intervals = rule.split(&position_m, 1e-3, 0.0);
            let mut next = 0;
            for interval in &intervals {
                prop_assert_eq!(interval.samples.start, next);
                prop_assert!(!interval.samples.is_empty());
                next = interval.samples.end;
            }
            prop_assert_eq!(next, position_m.len());
            prop_assert!(intervals.windows(2).all(|pair| pair[0].phase != pair[1].phase));
        }
    }
}
