//! The phases of an insertion as whoever holds the needle means them, by a rule from the positions alone.

use std::ops::Range;

use serde::Serialize;

/// What the needle is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Phase {
    /// Not in the tissue: before the contact, or out of it again.
    Free,
    /// Going in.
    Insertion,
    /// In the tissue and not moving: what relaxes does so here.
    Hold,
    /// In the tissue and coming out.
    Withdrawal,
}

impl Phase {
    /// Every phase, in the order of an insertion.
    pub const ALL: [Self; 4] = [Self::Free, Self::Insertion, Self::Hold, Self::Withdrawal];

    /// Its name, as tables and files write it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::Insertion => "insertion",
            Self::Hold => "hold",
            Self::Withdrawal => "withdrawal",
        }
    }
}

/// A interval of samples in one phase.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PhaseInterval {
    /// Which phase.
    pub phase: Phase,
    /// Which samples.
    pub samples: Range<usize>,
}

/// How positions become phases.
///
/// At each sample the mean speed over the `window_s` around it, `v̄ = (p(t + w/2) - p(t - w/2)) / w`, is taken from the
/// positions (over what there is of the window at either end). Below the contact the needle is free; in contact it goes in
/// where `v̄ > moving_m_per_s`, comes out where `v̄ < -moving_m_per_s`, and holds between. A interval shorter than
/// `shortest_s` belongs to the one before it (the first to the one after it).
///
/// The defaults are chosen here: a window of 0.1 s holds a whole period of a physiological tremor of 10 Hz, which then is
/// no motion, and 1 mm/s lies between the creep of a resting hand and the 4 to 6 mm/s at which the shipped insertion is
/// pushed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhaseRule {
    /// Over what the speed is averaged, in s, above 0.
    pub window_s: f64,
    /// The mean speed in m/s, at least 0, above which the needle moves.
    pub moving_m_per_s: f64,
    /// The shortest interval of its own, in s, at least 0.
    pub shortest_s: f64,
}

impl Default for PhaseRule {
    fn default() -> Self {
        Self { window_s: 0.1, moving_m_per_s: 1e-3, shortest_s: 0.1 }
    }
}

impl PhaseRule {
    /// Splits evenly spaced positions (m, `interval_s` apart) into intervals that follow one another without a gap, from the
    /// first sample to the last; neighbours differ in phase. No samples have none. `contact_m` is where the tissue begins.
    #[must_use]
    pub fn split(&self, position_m: &[f64], interval_s: f64, contact_m: f64) -> Vec<PhaseInterval> {
        let samples = |duration_s: f64| (duration_s / interval_s).round().max(0.0) as usize;
        let half = samples(0.5 * self.window_s).max(1);
        let shortest = samples(self.shortest_s);
        let mut intervals: Vec<PhaseInterval> = vec![];
        for sample in 0..position_m.len() {
            let phase = self.phase_at(position_m, sample, half, interval_s, contact_m);
            extend(&mut intervals, phase, sample..sample + 1);
        }
        merge(&intervals, shortest)
    }

    fn phase_at(&self, position_m: &[f64], sample: usize, half: usize, interval_s: f64, contact_m: f64) -> Phase {
        // A position that is no number is in no tissue.
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

/// Lets the last interval go on, or begins the next one.
fn extend(intervals: &mut Vec<PhaseInterval>, phase: Phase, samples: Range<usize>) {
    match intervals.last_mut() {
        Some(last) if last.phase == phase => last.samples.end = samples.end,
        _ => intervals.push(PhaseInterval { phase, samples }),
    }
}

/// The same samples without intervals shorter than `shortest` samples; where all are, the longest of them stands for all.
fn merge(intervals: &[PhaseInterval], shortest: usize) -> Vec<PhaseInterval> {
    let mut merged: Vec<PhaseInterval> = vec![];
    for interval in intervals {
        if interval.samples.len() >= shortest {
            // What is short at the very beginning belongs to the first that is not.
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

    /// Positions at 1 kHz by pieces of (duration in ms, speed in m/s), from `start_m`.
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
    fn an_insertion_reads_as_it_was_done() {
        // 5 mm to the surface at 5 mm/s, 10 mm in, a rest, and out again at 20 mm/s.
        let found = phases(&path(-5e-3, &[(1000, 5e-3), (2000, 5e-3), (1500, 0.0), (500, -20e-3), (500, -20e-3)]));
        let names: Vec<_> = found.iter().map(|(phase, _)| *phase).collect();
        assert_eq!(names, [Phase::Free, Phase::Insertion, Phase::Hold, Phase::Withdrawal, Phase::Free]);
        for ((_, start), expected) in found.iter().zip([0_usize, 1000, 3000, 4500, 5000]) {
            assert!(start.abs_diff(expected) <= 50, "within half a window: {start} and {expected}");
        }
    }

    #[test]
    fn a_trembling_hand_that_holds_is_holding() {
        let tremor = |k: usize| 0.01 + 3e-4 * (std::f64::consts::TAU * 10.0 * k as f64 * 1e-3).sin();
        let position_m: Vec<f64> = (0..3000).map(tremor).collect();
        // Its speed reaches 19 mm/s, to and fro.
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
