//! Higher detector thresholds with which a run is identical, bit for bit.
//!
//! A threshold `γ` acts on a run by its alarms, and as the level below which an augmented phase may end. A higher
//! threshold `h` is dropped at the first tick at which one of them may differ.
//!
//! **Alarms.** At `g ≤ γ` neither raises an alarm. At `g > γ` they differ
//!
//! - if `g ≤ h` and the run raises an alarm, or
//! - if `g > h`, only one of the two detectors is armed, and the crossing would count as a rupture.
//!
//! With `q` ticks since the last crossing and `c` ticks of contact, a detector is armed if `min(q, c) ≥ S`. `c` is
//! equal for both, so they differ only if `q ≥ S` holds for one of them.
//!
//! **Exits.** A phase that ends at the minimum hold ends at the same tick with every higher threshold. A longer phase
//! may not, and drops all thresholds of its run.

use std::ops::Range;

use crate::run::{RunError, run_pack_sharing};
use trocar_core::lane::{Lane, Mask};
use trocar_core::time::nearest_ticks;
use trocar_engine::engine::{EventObserver, InstructionSet, SelectedSignals};
use trocar_engine::sensor::NoiseBank;
use trocar_metrics::Metrics;
use trocar_run::{RunObserver, run_pack_observed};
use trocar_scenario::Scenario;

#[derive(Debug, Clone)]
pub(super) struct RunWithEquivalents {
    pub(super) metrics: Metrics,
    /// The list may be incomplete.
    pub(super) thresholds: Vec<f64>,
}

/// `higher` lists thresholds between the detector's threshold and its cap, by scenario.
pub(super) fn run_with_equivalents(
    bank: &mut NoiseBank,
    scenarios: &[Scenario],
    higher: &[Vec<f64>],
) -> Vec<Result<RunWithEquivalents, RunError>> {
    let tracked = TrackedThresholds { scenarios, higher };
    let runs = run_pack_observed(InstructionSet::widest(), bank, scenarios, &tracked).into_iter();
    runs.map(|run| run.map(|(metrics, thresholds)| RunWithEquivalents { metrics, thresholds })).collect()
}

pub(super) fn run_without_equivalents(
    bank: &mut NoiseBank,
    scenarios: &[Scenario],
) -> Vec<Result<RunWithEquivalents, RunError>> {
    let runs = run_pack_sharing(bank, scenarios).into_iter();
    runs.map(|run| run.map(|metrics| RunWithEquivalents { metrics, thresholds: vec![] })).collect()
}

struct TrackedThresholds<'a> {
    scenarios: &'a [Scenario],
    higher: &'a [Vec<f64>],
}

impl RunObserver for TrackedThresholds<'_> {
    type OverLanes<L: Lane> = EquivalentThresholds<L>;
    type Finding = Vec<f64>;

    fn over_lanes<L: Lane>(&self, places: Range<usize>) -> EquivalentThresholds<L> {
        EquivalentThresholds::new(&self.scenarios[places.clone()], &self.higher[places])
    }

    fn finding<L: Lane>(observer: &EquivalentThresholds<L>, lane: usize) -> Vec<f64> {
        observer.thresholds(lane).collect()
    }
}

#[derive(Debug, Clone)]
struct EquivalentThresholds<L: Lane> {
    /// Infinite if none remains.
    threshold: L,
    /// An augmented phase up to this length is identical with any threshold.
    max_augmented_ticks: L,
    /// Number with the first one; 0 outside an augmented phase.
    augmented_ticks: L,
    runs: Vec<TrackedRun>,
}

#[derive(Debug, Clone)]
struct TrackedRun {
    /// `S`.
    settle_ticks: u64,
    /// True if only a residual below 0 counts as a rupture.
    drop_only: bool,
    /// Tick after the last crossing of the run's threshold; 0 before the first.
    quiet_from: u64,
    higher: Vec<HigherThreshold>,
}

#[derive(Debug, Clone, Copy)]
struct HigherThreshold {
    threshold: f64,
    quiet_from: u64,
}

impl<L: Lane> EquivalentThresholds<L> {
    fn new(scenarios: &[Scenario], higher: &[Vec<f64>]) -> Self {
        let is_tracked = |lane: usize| higher.get(lane).is_some_and(|higher| !higher.is_empty());
        let tracked = |lane: usize, number: &dyn Fn(&Scenario) -> f64| {
            if is_tracked(lane) { number(&scenarios[lane]) } else { f64::INFINITY }
        };
        // The mode changes at the earliest one tick after the start of the phase.
        let max_augmented_ticks = |scenario: &Scenario| {
            nearest_ticks(scenario.augmentation.automaton.min_hold_s, scenario.grid.tick_s()).max(1) as f64
        };
        let run = |(scenario, higher): (&Scenario, &Vec<f64>)| {
            let arming = &scenario.detector.arming;
            let at_rest = |&threshold: &f64| HigherThreshold { threshold, quiet_from: 0 };
            TrackedRun {
                settle_ticks: nearest_ticks(arming.settle_s, scenario.grid.tick_s()),
                drop_only: arming.drop_only,
                quiet_from: 0,
                higher: higher.iter().map(at_rest).collect(),
            }
        };
        Self {
            threshold: L::from_lanes(|lane| tracked(lane, &|scenario| scenario.detector.cusum.threshold)),
            max_augmented_ticks: L::from_lanes(|lane| tracked(lane, &max_augmented_ticks)),
            augmented_ticks: L::zero(),
            runs: scenarios.iter().zip(higher).map(run).collect(),
        }
    }

    fn thresholds(&self, lane: usize) -> impl Iterator<Item = f64> {
        self.runs[lane].higher.iter().map(|higher| higher.threshold)
    }

    /// Called if `g` exceeds its threshold, or the mode is not teleoperation, in any lane.
    #[inline(always)]
    fn observe_event(&mut self, s: &SelectedSignals<L>, above: L::Mask) {
        let is_augmented = s.mode.is_augmented();
        self.augmented_ticks = L::select(is_augmented, self.augmented_ticks + L::splat(1.0), L::zero());
        let is_delayed = self.augmented_ticks.gt(self.max_augmented_ticks);
        if !(above | is_delayed).any() {
            return;
        }
        for (lane, run) in self.runs.iter_mut().enumerate() {
            if is_delayed.lane(lane) {
                run.higher.clear();
            } else if above.lane(lane) {
                run.cross(s.tick, s.decision.lane(lane), s.alarm.lane(lane), s.residual_n.lane(lane));
            }
            if run.higher.is_empty() {
                self.threshold.set_lane(lane, f64::INFINITY);
                self.max_augmented_ticks.set_lane(lane, f64::INFINITY);
            }
        }
    }
}

impl<L: Lane> EventObserver<L> for EquivalentThresholds<L> {
    #[inline(always)]
    fn observe(&mut self, s: &SelectedSignals<L>) {
        let above = s.decision.gt(self.threshold);
        let not_teleoperation = !s.mode.is_teleoperation();
        if (above | not_teleoperation).any() {
            self.observe_event(s, above);
        }
    }
}

impl TrackedRun {
    fn cross(&mut self, tick: u64, decision: f64, alarm: bool, residual_n: f64) {
        let settled = |quiet_from: u64| tick - quiet_from >= self.settle_ticks;
        let run_is_settled = settled(self.quiet_from);
        let can_be_rupture = !self.drop_only || residual_n < 0.0;
        self.higher.retain_mut(|higher| {
            if decision > higher.threshold {
                let is_settled = settled(higher.quiet_from);
                higher.quiet_from = tick + 1;
                is_settled == run_is_settled || !can_be_rupture
            } else {
                !alarm
            }
        });
        self.quiet_from = tick + 1;
    }
}

#[cfg(test)]
mod tests;
