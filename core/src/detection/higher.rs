//! Higher thresholds that have announced the same as a detector's own.

use alloc::vec::Vec;

use crate::lane::{Gather, LANES, Lane, Mask};

/// Other thresholds in each lane, as long as they announce what the lane's own does.
///
/// A threshold reaches the rest of a run by its alarms alone: up to the first alarm that one threshold raises and another does
/// not, their runs are the same, with the same residuals and the same `g`. A higher threshold has nothing to announce that is
/// not above the lower one too, so that it has to be asked only then.
///
/// What the detectors do not share is for how long they have been quiet, which arms them: the higher one at least as long as
/// the lower one, and at most by the number that is kept here longer. Where that leaves open whether it is armed, it is let go.
#[derive(Debug, Clone, Default)]
pub(super) struct HigherThresholds {
    /// Those that still agree, lane by lane; no lanes where none were asked for.
    lanes: Vec<Vec<Higher>>,
}

#[derive(Debug, Clone, Copy)]
struct Higher {
    threshold: f64,
    /// At most so many ticks more than the lane's own detector it has been quiet.
    extra_quiet_ticks: f64,
}

/// A sample above the lane's own threshold, as all of the thresholds see it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing<L: Lane> {
    /// `g_k`.
    pub decision: L,
    /// Where it is above the lane's own threshold.
    pub above: L::Mask,
    /// Where the sample looks like a rupture.
    pub like_rupture: L::Mask,
    /// Where the needle touches the tissue.
    pub in_contact: L::Mask,
    /// Where the lane's own detector raises an alarm.
    pub alarm: L::Mask,
    /// For how many ticks the lane's own detector has been quiet before.
    pub quiet_ticks: L,
    /// How many arm it.
    pub settle_ticks: L,
}

impl HigherThresholds {
    /// Thresholds that are asked beside the own one of the only lane.
    pub(super) fn of(thresholds: &[f64]) -> Self {
        let higher = |&threshold: &f64| Higher { threshold, extra_quiet_ticks: 0.0 };
        Self { lanes: [thresholds.iter().map(higher).collect()].into() }
    }

    /// Those that have announced what lane `index` has.
    pub(super) fn alike(&self, index: usize) -> impl Iterator<Item = f64> {
        self.lanes.get(index).into_iter().flatten().map(|higher| higher.threshold)
    }

    #[inline(always)]
    pub(super) fn are_asked(&self) -> bool {
        !self.lanes.is_empty()
    }

    /// Lets those go that disagree about a sample.
    pub(super) fn ask<L: Lane>(&mut self, crossing: &Crossing<L>) {
        let lanes = self.lanes.iter_mut().enumerate();
        for (index, lane) in lanes.filter(|(index, lane)| crossing.above.lane(*index) && !lane.is_empty()) {
            let decision = crossing.decision.lane(index);
            let (quiet_ticks, settle_ticks) = (crossing.quiet_ticks.lane(index), crossing.settle_ticks.lane(index));
            let (like_rupture, alarm) = (crossing.like_rupture.lane(index), crossing.alarm.lane(index));
            let in_contact = crossing.in_contact.lane(index);
            lane.retain_mut(|higher| {
                let at_most = quiet_ticks + higher.extra_quiet_ticks;
                if decision > higher.threshold {
                    // Armed as the lower one is, or certainly not.
                    higher.extra_quiet_ticks = 0.0;
                    !like_rupture || quiet_ticks >= settle_ticks || at_most < settle_ticks
                } else {
                    higher.extra_quiet_ticks = if in_contact { at_most + 1.0 } else { 0.0 };
                    !alarm
                }
            });
        }
    }
}

impl Gather for HigherThresholds {
    type Of<L: Lane> = Self;

    fn gather<L: Lane>(all: [&Self; LANES]) -> Option<Self> {
        if all.iter().all(|one| one.lanes.is_empty()) {
            return Some(Self::default());
        }
        Some(Self { lanes: all.iter().map(|one| one.lanes.first().cloned().unwrap_or_default()).collect() })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{CusumDetector, Detector, DetectorSettings, Evidence};

    /// Numbers between -1 and 1, the next one of a seed each time.
    fn random(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Three seconds of an insertion with noise, spikes, lasting drops, withdrawals and losses of contact.
    fn insertion(seed: u64) -> Vec<Evidence<f64>> {
        let mut state = seed;
        let mut residual = 0.0;
        let sample = |_| {
            let chance = random(&mut state);
            residual = if chance > 0.99 { -0.6 * random(&mut state).abs() } else { 0.9 * residual };
            let residual_n = residual + 0.08 * random(&mut state) * random(&mut state);
            Evidence {
                force_n: 2.0 + residual_n,
                predicted_force_n: 2.0,
                residual_n,
                correction: [0.0; 2],
                depth_m: 0.02,
                velocity_m_per_s: if chance < -0.9 { -0.02 } else { 0.01 },
                in_contact: chance.abs() > 3e-3,
            }
        };
        (0..3000).map(sample).collect()
    }

    #[test]
    fn those_that_are_alike_raise_the_same_alarms_and_few_are_missed() {
        let thresholds: Vec<f64> = (0..40).map(|k| 2e-3 * 1.12_f64.powi(k)).collect();
        let detector = |threshold: f64| {
            let mut settings = DetectorSettings::default();
            (settings.cusum.threshold, settings.cusum.cap) = (threshold, 0.3);
            settings.arming.settle_s = 0.03;
            CusumDetector::<f64>::new(&settings, 1e-3)
        };
        let (mut told, mut true_of, mut alarms_seen) = (0, 0, 0);
        for seed in 1..30 {
            let samples = insertion(seed);
            let alarms = |detector: &mut CusumDetector<f64>| -> Vec<bool> {
                samples.iter().map(|sample| detector.update(sample).alarm).collect()
            };
            for own in [0, 7, 20] {
                let mut lowest = detector(thresholds[own]);
                lowest.ask_higher(&thresholds[own + 1..]);
                let of_lowest = alarms(&mut lowest);
                let alike: Vec<f64> = lowest.alike(0).collect();
                for &threshold in &thresholds[own + 1..] {
                    let is_alike = alarms(&mut detector(threshold)) == of_lowest;
                    assert!(is_alike || !alike.contains(&threshold), "seed {seed}, {} {threshold}", thresholds[own]);
                    told += usize::from(alike.contains(&threshold));
                    true_of += usize::from(is_alike);
                }
                alarms_seen += of_lowest.iter().filter(|alarm| **alarm).count();
            }
        }
        assert!(alarms_seen > 500 && true_of > 300 && 10 * told > 8 * true_of, "{told} of {true_of}, {alarms_seen}");
    }
}
